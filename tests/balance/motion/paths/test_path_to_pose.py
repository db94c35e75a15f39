"""Paths without reaction to a pose, turns of a base that floats, and paths within a tolerance.

The satellites' turning is by Pinocchio's centroidal map on a free-flyer.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.motion import FloatingBase
from balance.motion.paths.path import segments_table
from balance.motion.verification.given_motions import from_csv
from kinematics.errors import LinkageError
from tests.support.covering import number_of_cases
from tests.support.floating_arms import (
    arm_in_line,
    arm_in_space,
    attitude_after,
    turning_rates,
)
from tests.support.fuga import Masses, fuga

SATELLITE = FloatingBase(10.0, 1.0)


def check_the_attitude(arm, start, end):
    """The base does not turn along a path to a pose."""
    solution = balance.path_to_pose(arm, end, start, kept="attitude", base=SATELLITE)
    assert solution.paths, solution.reason
    (path,) = solution.paths
    assert path.u[[0, -1]] == pytest.approx(np.array([start, end]), abs=1e-12)
    assert path.residual <= 1e-9
    turned = turning_rates(arm, SATELLITE, path.u, path.rates)
    held = np.abs(turning_rates(arm, SATELLITE, path.u, np.abs(path.rates))).max()
    assert np.abs(turned).max() <= 1e-9 * max(held, 1e-3)


def test_an_arm_reaches_a_pose_and_its_satellite_does_not_turn():
    check_the_attitude(arm_in_line(7), np.zeros(7), [0.3, -0.2, 0.4, 0.1, -0.3, 0.2, 0.1])


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 4, 5, 6, 7])
def test_many_poses_are_reached(count):
    """Twenty of them with ``ALL_CASES=1``."""
    rng = np.random.default_rng(count)
    for _ in range(number_of_cases(1, 4)):
        check_the_attitude(arm_in_line(count), *rng.uniform(-1.0, 1.0, (2, count)))


@pytest.mark.slow
def test_six_joints_in_space_reach_a_pose():
    """Three rates are free; the path is ten times as long as the straight line."""
    ends = np.random.default_rng(1).uniform(-1.2, 1.2, (2, 2, 6))[1]
    check_the_attitude(arm_in_space(6), *ends)


def test_a_satellite_is_turned_by_its_arm():
    """The arm returns to its pose, as that of a falling cat; by the simulation of us."""
    arm = arm_in_line(3)
    start, base = [0.5, 0.4, 0.2], FloatingBase(2.0, 0.3)
    solution = balance.path_to_pose(arm, start, start, base=base, turn=0.5)
    assert solution.paths and solution.target.turn == pytest.approx([0, 0, 0.5])
    (path,) = solution.paths
    assert path.attitude[-1] == pytest.approx([0, 0, 0.5]) and path.residual <= 1e-9
    assert path.u[[0, -1]] == pytest.approx(np.array([start, start]), abs=1e-12)
    motion = balance.motion.timed_path(arm, path, 2.0)
    simulated = balance.motion.simulate_floating_base(arm, base, motions=motion)
    assert simulated.samples.rotation[-1] == pytest.approx([0, 0, 0.5], abs=1e-6)


@pytest.mark.slow
def test_a_turn_in_space():
    """Pose and attitude at once, by Pinocchio."""
    import pinocchio as pin

    arm, turn = arm_in_space(7), np.array([0.2, -0.3, 0.4])
    end = [0.2, -0.4, 0.3, 0.5, -0.2, 0.1, 0.3]
    solution = balance.path_to_pose(arm, end, base=SATELLITE, turn=turn)
    assert solution.paths, solution.reason
    (path,) = solution.paths
    assert path.u[-1] == pytest.approx(end, abs=1e-12) and path.residual <= 1e-9
    assert pin.log3(attitude_after(arm, SATELLITE, path)) == pytest.approx(turn, abs=1e-7)


def test_a_force_would_move_the_centre_of_mass():
    """Without one it stays: a bound, not a search."""
    solution = balance.path_to_pose(arm_in_line(7), {"q1": 0.5}, kept="force")
    assert not solution.paths and "the centre of mass is" in solution.reason
    solution = balance.path_to_pose(arm_in_line(3), {"q1": 0.5}, [0.1, 0.2, 0.3])
    assert not solution.paths and "full column rank" in solution.reason


@pytest.mark.slow
def test_a_pose_beyond_a_meeting_of_paths(tmp_path):
    """Two paths of Fuga cross: the linkage rests where they meet, and turns off."""
    linkage = kinematics.load("fuga_i")
    first, second = balance.find_paths(linkage).paths
    ends = second.u[len(second.u) * 3 // 4], first.u[len(first.u) // 4]
    solution = balance.path_to_pose(linkage, ends[1], ends[0])
    assert [path.reactionless for path in solution.paths] == [True, True]
    corner = balance.find_paths(linkage).starts[0].u
    stops = [path.u[[0, -1]] for path in solution.paths]
    assert stops[0] == pytest.approx(np.array([ends[0], corner]), abs=1e-6)
    assert stops[1] == pytest.approx(np.array([corner, ends[1]]), abs=1e-6)
    table = tmp_path / "path.csv"
    table.write_bytes(segments_table(linkage, solution.paths))
    (run,) = balance.verify(linkage, motions=[from_csv(linkage, table)]).runs
    straight = balance.motion.rest_to_rest(linkage, np.array(ends), duration=2.0)
    (other,) = balance.verify(linkage, motions=[straight]).runs
    assert run.peak("moment") < 1e-3 * other.peak("moment")


@pytest.mark.slow
def test_printed_masses_have_paths_within_a_tolerance():
    """[J] table 3.2 as printed: no path without reaction, one within a tenth."""
    linkage = fuga(0.0, Masses((0.140, 90.0), (0.069, 150.0), 1.46e-3))
    assert not balance.find_paths(linkage).paths
    assert "is above 0.02" in balance.find_paths(linkage, tolerance=0.02).reason
    solution = balance.find_paths(linkage, tolerance=0.1)
    (path,) = solution.paths
    assert 0.01 < path.residual <= 0.1 * (1 + 1e-6) and path.reactionless
    # At the start the moving base feels no other rates less.
    start = path.u[int(np.abs(path.s).argmin())]
    shares = []
    for angle in np.linspace(0.0, np.pi, 181):
        way = np.array([np.cos(angle), np.sin(angle)])
        h = balance.pose.momentum_matrix(linkage, start) @ way
        h[:3] /= linkage.spatial_chain.frame.length
        shares.append((np.linalg.norm(h), angle))
    quietest = min(shares)[1]
    direction = path.direction / np.linalg.norm(path.direction)
    assert abs(direction @ [np.cos(quietest), np.sin(quietest)]) > 0.999


def test_a_tolerance_is_where_a_path_ends():
    linkage = kinematics.load("five_bar")
    exact = balance.find_paths("fuga_i", tolerance=0.2, length=0.1)
    assert exact.demand.tolerance == 0.0 and exact.paths[0].residual < 1e-9
    assert not balance.find_paths(linkage, tolerance=1e-3, length=0.1).paths


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"end": {}}, "the two poses are one"),
        ({"turn": 0.3}, "give its mass too"),
        ({"kept": "turned", "base": SATELLITE}, "give the turn of the base"),
        ({"turn": [0.1, 0.0, 0.0], "base": SATELLITE}, "about the normal of its plane"),
        ({"turn": [0.1, 0.2], "base": SATELLITE}, "an angle, or a rotation vector"),
        ({"turn": 0.3, "base": FloatingBase(2.0)}, "needs moments of inertia"),
        ({"end": {"ghost": 1.0}}, "ghost is not an input"),
    ],
)
def test_bad_words_are_refused(options, words):
    given = {"end": {"q1": 0.2}} | options
    with pytest.raises(LinkageError, match=words):
        balance.path_to_pose(arm_in_line(3), **given)
