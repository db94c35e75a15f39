"""Remedies of linkages that their file alone does not say: a fixed base, loops of a YAML file.

They are those of the same linkage written in one file, and that file is written.
"""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from balance.masses.remedies.compare import compare_request
from balance.masses.remedies.request import RemedyRequest
from balance.motion.verification.trajectory import random_motions
from tests.support.remedy_files import momentum
from tests.support.remedy_requests import SLENDER, rod
from tests.support.sidecar_text import PAIR, written

FLOATING = (
    '<joint name="loose" type="floating"><parent link="base"/><child link="hull"/></joint>'
    '<link name="hull"><inertial><mass value="5"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)


VERDICTS = {"own_masses": "feasible", "partial": "partial"}


def pendulum(floating):
    base = "hull" if floating else "base"
    rods = (
        rod("a", base, "0 0 0", 1.0, "0.5 0 0", SLENDER),
        rod("b", "a", "1 0 0", 1.0, "0.5 0 0", SLENDER),
    )
    start = FLOATING if floating else ""
    return f'<robot name="r"><link name="base"/>{start}{"".join(rods)}</robot>'


def frame(name, link, place):
    return (
        f'<link name="{name}"/><joint name="on_{name}" type="fixed"><origin xyz="{place}"/>'
        f'<parent link="{link}"/><child link="{name}"/></joint>'
    )


def four_bar_of_yaml(folder):
    parts = (
        rod("crank", "base", "0 0 0", 1.0, "0.2 0 0", SLENDER),
        rod("coupler", "crank", "0.4 0 0", 1.0, "0.5 0 0", SLENDER),
        rod("rocker", "base", "1 0 0", 1.0, "0.4 0 0", SLENDER),
        frame("tip_a", "coupler", "1 0 0"),
        frame("tip_b", "rocker", "0.8 0 0"),
    )
    text = f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>'
    path = written(folder, text, PAIR + "type: ['3d']\n")
    return kinematics.load(path, folder / "robot.yaml", ["j_crank"])


def floating_arm(folder):
    return kinematics.load(written(folder, pendulum(floating=True)), fix_base=True)


@pytest.mark.parametrize("made", [four_bar_of_yaml, floating_arm])
@pytest.mark.parametrize(
    "remedy", ["own_masses", pytest.param("partial", marks=pytest.mark.slow)]
)
def test_remedies_are_those_of_the_same_linkage_in_one_file(made, remedy, tmp_path):
    linkage = made(tmp_path)
    path = tmp_path / "whole.urdf"
    path.write_text(linkage.to_urdf())
    (applied,), (expected,) = (
        compare_request(RemedyRequest(each, balance="force"), [remedy]).results
        for each in (linkage, kinematics.load(path))
    )
    assert applied.verdict == expected.verdict == VERDICTS[remedy]
    assert applied.added_mass == pytest.approx(expected.added_mass, rel=1e-6)
    if remedy == "partial":
        return
    applied.to_urdf(tmp_path / "balanced.urdf")
    balanced = kinematics.load(tmp_path / "balanced.urdf", inputs=linkage.inputs)
    assert balanced.mobility == linkage.mobility
    (motion,) = random_motions(balanced, 1, 6)
    for q, qd in zip(motion.q, motion.qd, strict=True):
        of_bodies = momentum(balanced, q, qd)[:, 3:]
        assert np.linalg.norm(of_bodies.sum(axis=0)) < 1e-9 * np.abs(of_bodies).sum()


def test_the_command_line_fixes_the_base_of_remedies(tmp_path, capsys):
    path = str(written(tmp_path, pendulum(floating=True)))
    assert main(["remedies", path, "--only", "own_masses", "--balance", "force"]) == 3
    assert "--fix-base" in capsys.readouterr().err
    options = ["--balance", "force", "--only", "own_masses", "--fix-base"]
    assert main(["remedies", path, *options]) == 0
