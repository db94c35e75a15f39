"""Round-off in the axes of a file is zero, as multiples of π/12 are among its angles."""

import json
from pathlib import Path

import pytest

import kinematics
from balance.app.cli.main import main
from kinematics.files.formats.robot_files import read_files
from kinematics.files.urdf.read_options import ReadOptions
from tests.support.urdf_text import UNIT_INERTIA, along, joint, link, loop, saved

NOISE = Path(__file__).parents[3] / "data" / "near_special" / "noise_1e-15_axis.urdf"


def axes(path, angles="nominal"):
    tree = read_files(path, None, ReadOptions(angles=angles)).tree
    return [item.attributes["xyz"] for item in tree.walk() if item.tag.startswith("axis")]


@pytest.mark.parametrize(("option", "rank"), [([], 10), (["--as-written"], 12)])
def test_the_ranks_of_parallel_axes(option, rank, capsys):
    """Two parallel joints have 10 conditions in space; two skew ones have 12."""
    assert main(["report", str(NOISE), "--spatial", "--json", *option]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["rank"], found["certainty"]) == (rank, "proved")
    told = [notice["code"] for notice in found["warnings"]]
    assert ("axis_noise" in told) == (not option)


@pytest.mark.parametrize(
    ("words", "read"),
    [
        ("3.2e-15 -2.9e-15 1", "0 0 1"),
        ("-2e3 1.5e-10 0", "-2e3 0 0"),
        ("0.6 -0.8 1e-17", "0.6 -0.8 0"),
        ("1e-20 0 -3e-20", "1e-20 0 -3e-20"),
        ("2e-12 0 1", "2e-12 0 1"),
        ("0 0 1.0", "0 0 1.0"),
        ("0.00000000000001 0 1", "0.00000000000001 0 1"),
    ],
)
def test_which_components_are_round_off(tmp_path, words, read):
    """The words of the others stay as they are."""
    axis = f'<axis xyz="{words}"/>'
    parts = [
        link("base"),
        link("a", **UNIT_INERTIA),
        link("b", **UNIT_INERTIA),
        joint("j", "revolute", "base", "a", more=axis),
        joint("i", "revolute", "a", "b", along([1, 0, 0]), more=axis),
        loop("k", "revolute", ("base", "b"), more=axis),
    ]
    path = saved(tmp_path, *parts)
    assert axes(path) == [read] * 3 and axes(path, "as_written") == [words] * 3


def test_a_remark_names_the_axes():
    (told,) = [x.message for x in kinematics.load(NOISE).notices if x.code == "axis_noise"]
    assert "joint 'j2' (line 5)" in told and "--as-written" in told and "j1" not in told


def origins(path, angles="nominal"):
    tree = read_files(path, None, ReadOptions(angles=angles)).tree
    owners = [item for item in tree.walk() if item.tag in ("joint", "predecessor", "successor")]
    return [
        dict(part.attributes) for x in owners for part in x.children if part.tag == "origin"
    ]


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ({"xyz": "1 2.2e-16 -2E-14"}, {"xyz": "1 0 0"}),
        ({"xyz": "1 2e-13 0"}, {"xyz": "1 2e-13 0"}),
        ({"xyz": "1 0.00000000000001 0"}, {"xyz": "1 0.00000000000001 0"}),
        ({"xyz": "1 0 0", "rpy": "3e-15 -4E-14 0.3"}, {"xyz": "1 0 0", "rpy": "0 0 0.3"}),
        ({"xyz": "1 0 0", "rpy": "3e-12 0 0"}, {"xyz": "1 0 0", "rpy": "3e-12 0 0"}),
    ],
)
def test_which_numbers_of_origins_are_round_off(tmp_path, written, read):
    """In joints and at both ends of loops; ``as_written`` takes them."""
    origin = "<origin " + " ".join(f'{k}="{v}"' for k, v in written.items()) + "/>"
    parts = [link("base"), link("a", **UNIT_INERTIA), link("b", **UNIT_INERTIA)]
    for name, before, after in (("j", "base", "a"), ("i", "a", "b")):
        parts.append(
            f'<joint name="{name}" type="revolute"><parent link="{before}"/>{origin}'
            f'<child link="{after}"/><axis xyz="0 0 1"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    parts.append(
        f'<loop name="k" type="revolute"><predecessor link="b">{origin}</predecessor>'
        f'<successor link="base">{origin}</successor><axis xyz="0 0 1"/></loop>'
    )
    path = saved(tmp_path, *parts)
    assert origins(path) == [read] * 4 and origins(path, "as_written") == [written] * 4
    remarks = read_files(path, None, ReadOptions()).remarks
    assert ("origin_noise" in {code for code, _ in remarks}) == (written != read)
