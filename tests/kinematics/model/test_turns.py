"""Full turns are nothing to a revolute joint, in what is said of displacements."""

from __future__ import annotations

import re

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from kinematics.model.arrays import freeze
from kinematics.model.full_turns import position_text, unit_of_joint, wrap_turns
from kinematics.model.linkage import Joint
from tests.support.laws import altered, posed

JOINTS = [
    Joint(kind, kind, -1, freeze([0, 0, 1, 0, 0, 0]), freeze(np.zeros(3)))
    for kind in ("revolute", "prismatic", "helical")
]


@pytest.fixture
def swung(tmp_path):
    """A file so wide open that steps that close it may wind joints around."""
    rng = np.random.default_rng(41)
    angles = {joint: rng.uniform(-2, 2) for joint in ("u1", "q2", "q4")}
    path = altered("four_bar_general", tmp_path, posed(angles))
    assert np.abs(kinematics.load(path).displaced).max() > 1.0
    return path


def test_only_revolute_joints_turn():
    q = np.array([[7.0, 7.0, 7.0], [-20.0, -20.0, -20.0], [3.1, 0.0, -3.1]])
    within, turns = wrap_turns(JOINTS, q)
    assert turns.tolist() == [[1, 0, 0], [-3, 0, 0], [0, 0, 0]]
    assert np.array_equal(within[:, 1:], q[:, 1:])
    assert within[:, 0] + 2 * np.pi * turns[:, 0] == pytest.approx(q[:, 0], abs=1e-14)
    assert np.exp(1j * within[:, 0]) == pytest.approx(np.exp(1j * q[:, 0]), abs=1e-14)
    angles = np.random.default_rng(1).uniform(-100, 100, (1000, 3))
    assert np.abs(wrap_turns(JOINTS, angles)[0][:, 0]).max() <= np.pi


def test_positions_in_words():
    assert [unit_of_joint(joint) for joint in JOINTS] == ["rad", "m", "rad"]
    assert [position_text(joint, 6.5) for joint in JOINTS] == ["0.217 rad", "6.5 m", "6.5 rad"]
    assert position_text(JOINTS[0], 6.5, 6) == "0.216815 rad"


def test_what_closed_a_file_is_told_within_a_turn(swung):
    """And the joint that is named is the one that moved furthest so."""
    linkage = kinematics.load(swung)
    (told,) = (n.message for n in linkage.notices if n.code == "assembled")
    name, angle = re.search(r"joint '(\w+)' moved furthest, by (\S+) rad$", told).groups()
    apart = np.abs(np.angle(np.exp(1j * linkage.displaced)))
    assert name == linkage.joints[int(np.argmax(apart))].name
    assert abs(float(angle)) == pytest.approx(apart.max(), rel=1e-2)


def test_what_is_written_and_what_is_rounded_are_told_within_a_turn(swung, tmp_path, caplog):
    """``--write-closed`` names the joints that moved, exact arithmetic where they are."""
    out = tmp_path / "closed.urdf"
    main(["report", str(swung), "--exact", "--write-closed", str(out)])
    apart = sorted(np.abs(np.angle(np.exp(1j * kinematics.load(swung).displaced))))
    for code, pattern in (
        ("closed_pose", r" by (-?[\d.]+) rad"),
        ("not_exact", r"closed by Newton's method at (-?[\d.]+) rad"),
    ):
        told = " ".join(text for text in caplog.messages if text.startswith(code))
        angles = [abs(float(each)) for each in re.findall(pattern, told)]
        assert angles and max(angles) <= np.pi
        assert min(abs(angles[0] - each) for each in apart) < 1e-5
    assert np.abs(np.diff(apart)).min() > 1e-3
