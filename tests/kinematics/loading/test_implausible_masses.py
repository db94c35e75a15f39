"""Masses in grams and moments of inertia in mm² are noticed, those of machines are not."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import numpy as np
import pytest

import kinematics
from kinematics.errors import LinkageError
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.loading.implausible_masses import DENSEST, implausible_masses
from kinematics.loading.model_gallery import _read as read_draft
from kinematics.loading.model_gallery import robots

MACHINES = sorted((Path(__file__).parents[3] / "docs/machines").glob("*.urdf"))


def _text(masses=1.0, inertias=1.0):
    """A small four-bar of steel, with masses and moments of inertia times factors."""
    bars = {"crank": (0.06, 0.12), "coupler": (0.2, 0.3), "rocker": (0.15, 0.25)}
    links = "".join(
        f'<link name="{name}"><inertial><origin xyz="{length / 2} 0 0"/>'
        f'<mass value="{masses * mass:.9g}"/><inertia ixx="{inertias * 1e-5:.9g}" '
        f'iyy="{inertias * mass * length**2 / 12:.9g}" '
        f'izz="{inertias * mass * length**2 / 12:.9g}" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
        for name, (length, mass) in bars.items()
    )
    return f"""<robot name="r"><link name="base"/>{links}
      <joint name="a" type="continuous"><parent link="base"/><child link="crank"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="b" type="continuous"><parent link="crank"/><child link="coupler"/>
        <origin xyz="0.06 0 0" rpy="0 0 0.7"/><axis xyz="0 0 1"/></joint>
      <joint name="c" type="continuous"><parent link="coupler"/><child link="rocker"/>
        <origin xyz="0.2 0 0" rpy="0 0 -2"/><axis xyz="0 0 1"/></joint></robot>"""


def _codes(text):
    return [notice.code for notice in implausible_masses(_draft(text))]


def _draft(source):
    return read_draft(source, None, ReadOptions())


@pytest.mark.parametrize(
    ("masses", "inertias", "code"),
    [
        (1, 1, None),
        (10, 10, None),  # a heavy machine
        (1e3, 1e3, "heavy_links"),  # g, g m²
        (1e3, 1, "heavy_links"),  # g, kg m²
        (1, 1e6, "wide_inertia"),  # kg, kg mm²
        (1e3, 1e9, "wide_inertia"),  # g, g mm²
        (1, 1e4, "wide_inertia"),  # kg, kg cm²
    ],
)
def test_units_are_noticed(masses, inertias, code):
    assert _codes(_text(masses, inertias)) == ([code] if code else [])


def test_a_ball_is_as_dense_as_it_is():
    """One ball: its density follows from its mass and moment of inertia alone."""
    for density, told in ((0.99 * DENSEST, []), (1.01 * DENSEST, ["heavy_links"])):
        radius = 0.05
        mass = density * 4 / 3 * np.pi * radius**3
        moment = 0.4 * mass * radius**2
        text = (
            '<robot name="r"><link name="base"/><link name="ball"><inertial>'
            f'<origin xyz="0.02 0.03 0"/><mass value="{mass}"/><inertia ixx="{moment}" '
            f'iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            '<joint name="a" type="continuous"><parent link="base"/><child link="ball"/>'
            '<axis xyz="0 0 1"/></joint></robot>'
        )
        assert _codes(text) == told


def test_point_masses_are_no_metal():
    text = re.sub(r'(i[xyz]{2})="[^"]*"', r'\1="0"', _text())
    assert _codes(text) == []


@pytest.mark.parametrize(
    "path", [*kinematics.gallery().values(), *MACHINES], ids=lambda p: p.stem
)
def test_no_machine_is_told(path):
    assert implausible_masses(_draft(path)) == []


@pytest.mark.slow
def test_no_public_robot_is_told():
    """Robots of example-robot-data, most of them with masses of their makers."""
    paths = robots()
    if not paths:
        pytest.skip("needs example-robot-data")
    told = {}
    for name, path in paths.items():
        with contextlib.suppress(LinkageError):  # a file that is refused
            told[name] = implausible_masses(_draft(path))
    assert len(told) > 20 and not any(told.values()), {k: v for k, v in told.items() if v}
