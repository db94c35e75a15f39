"""The second route to the mobility of robot files agrees with the product, and with theory."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import kinematics
from kinematics import gallery
from tests.independent import robot_folder
from tests.independent.robot_folder import judge, mobility_of, other_mobility, run
from tests.support.sdf_text import sdf_of


def joint(name, kind, point, axis, before, after):
    H = np.eye(4)
    H[:3, 3] = point
    return name, kind, H, np.array(axis, dtype=float), before, after


def test_the_mobility_of_four_bars_and_of_an_arm():
    """Grashof's four-bar has one freedom; the same with three bars has none; an arm has two."""
    z, corners = (0, 0, 1), [(0, 0, 0), (0, 1, 0), (2, 1.5, 0), (2, 0, 0)]
    pairs = [(None, 0), (0, 1), (1, 2), (2, None)]
    bars = [
        joint(f"j{k}", "revolute", p, z, *pair)
        for k, (p, pair) in enumerate(zip(corners, pairs, strict=True))
    ]
    assert mobility_of(3, bars, []) == 1
    assert mobility_of(2, [*bars[:2], joint("j", "revolute", corners[2], z, 1, None)], []) == 0
    assert mobility_of(2, bars[:2], []) == 2
    assert mobility_of(2, bars[:2], [("j1", "j0", -1.0)]) == 1
    skew = [joint("b", "ball", corners[3], z, 2, None)]
    assert mobility_of(3, [*bars[:3], *skew], []) == 1


@pytest.mark.parametrize("name", ["four_bar_general", "five_bar", "six_bar_watt"])
def test_loops_in_sdf(name, tmp_path):
    path = tmp_path / "model.sdf"
    path.write_text(sdf_of(gallery()[name], "model"))
    mobility, why = other_mobility(path, False)
    assert not why and mobility == kinematics.load(path).mobility


def test_a_loop_that_is_open_in_the_file():
    """A triangle of bars of 2, 2 and 3 m, all drawn along x, closes elsewhere and turns."""
    z = (0, 0, 1)
    bars = [joint("a", "revolute", (0, 0, 0), z, None, 0)]
    bars += [joint("b", "revolute", (2, 0, 0), z, 0, 1)]
    bars += [joint("c", "revolute", (0, 0, 0), z, None, 2)]
    tips = [joint("x", "revolute", (x, 0, 0), z, 1, 2) for x in (4, 3)]
    closed = (*tips[0], tips[1][2])
    assert mobility_of(3, [*bars, closed], []) == 1
    assert mobility_of(3, [*bars, joint("d", "fixed", (0, 0, 0), z, None, 2), closed], []) == 0


def test_a_pose_that_is_singular():
    """A flat parallelogram of equal bars has two freedoms there, and one beside it."""
    z, corners = (0, 0, 1), [(0, 0, 0), (1, 0, 0), (3, 0, 0), (2, 0, 0)]
    pairs = [(None, 0), (0, 1), (1, 2), (2, None)]
    bars = [
        joint(f"j{k}", "revolute", p, z, *pair)
        for k, (p, pair) in enumerate(zip(corners, pairs, strict=True))
    ]
    assert mobility_of(3, bars, []) == 1


@pytest.mark.parametrize(
    ("code", "seconds", "other", "verdict"),
    [
        (0, 1, 3, "right"),
        (0, 1, 2, "differs"),
        (4, 1, 2, "unsure"),
        (3, 1, None, "refused"),
        (70, 1, None, "crashed"),
        (0, 21, 3, "slow"),
    ],
)
def test_verdicts(code, seconds, other, verdict):
    record = {"code": code, "seconds": seconds, "megabytes": 100, "other": other, "mobility": 3}
    assert judge(record) == verdict


@pytest.mark.slow
def test_a_command_that_computes_too_long_is_slow_and_one_that_waits_is_not(monkeypatch):
    monkeypatch.setattr(robot_folder, "TIMEOUT", 1)
    code, seconds, megabytes, *_ = run([sys.executable, "-c", "while True: pass"])
    record = {"code": code, "seconds": 25.0, "megabytes": megabytes}
    assert 0.9 < seconds < 3 and judge(record) == "slow"
    assert run([sys.executable, "-c", "import time; time.sleep(2)"])[0] == 0
