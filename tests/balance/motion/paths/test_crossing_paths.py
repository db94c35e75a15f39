"""Reactionless paths that cross: J. J. de Jong, PhD thesis, University of Twente, chapter 3."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import balance
from balance.app.answers.text.paths import paths_facts
from balance.motion.paths.branches import leading_directions
from balance.motion.paths.demand import Demand
from balance.motion.paths.meeting_poses import meeting_pose
from balance.motion.paths.rest_equations import RestEquations
from balance.motion.verification.given_motions import rest_to_rest
from kinematics import load
from tests.support.crossing_five_bar import crossing_five_bar, end_points
from tests.support.fuga import Masses, fuga

# Lower arms that ask for a left upper arm of 69.0 mm at 150.0°, as table 3.2 prints; by force
# balance (Eq. 3.61) the right one is then another. Symmetric ones, of upper arms at 150.0°;
# those that the table prints itself.
CORRECTED, SYMMETRIC, PRINTED = (0.10274, 88.84), (0.10392, 90.0), (0.140, 90.0)
# The end point 1 mm beyond the base line, seen from the elbows.
BEYOND = -1e-3


def deviations(found):
    """Of each path over ±100 mm: direction at the crossing, and deviation from straight."""
    for path in found.paths:
        points = end_points(found.linkage, path.q)
        middle = int(np.argmin(np.abs(path.s)))
        tangent = points[middle + 1] - points[middle - 1]
        tangent /= np.linalg.norm(tangent)
        off = points - points[middle]
        near = np.abs(off @ tangent) <= 0.1
        chord = points[near][-1] - points[near][0]
        chord /= np.linalg.norm(chord)
        aside = (points[near] - points[near][0]) @ [-chord[1], chord[0]]
        yield tangent, np.ptp(aside), points


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("lower", "angle", "straight"),
    [
        (CORRECTED, 89.6, (5e-4, 1.4e-3)),
        (SYMMETRIC, 90.0, (1e-9, 3e-4)),
        (PRINTED, 90.0, (1e-9, 3e-4)),
    ],
)
def test_two_paths_cross(lower, angle, straight):
    """Section 3.2 and Fig. 3.6, from the pose alone; the print measures 0.9 mm over 200 mm."""
    robot = crossing_five_bar(BEYOND, *lower)
    found = balance.find_paths(robot.linkage, length=1.2)
    (start,) = found.starts
    assert (found.dimension, start.kind, start.dimension) == (1, "crossing", 2)
    assert len(found.paths) == 2 and max(path.residual for path in found.paths) <= 1e-12
    (one, first, _), (two, second, _) = deviations(found)
    assert np.degrees(np.arccos(abs(one @ two))) == pytest.approx(angle, abs=0.03)
    assert np.all(np.sort([first, second]) <= straight)


def test_the_closed_forms_of_the_table():
    """Table 3.2 contradicts itself: 140 mm at 90° asks for other upper arms."""
    corrected = crossing_five_bar(BEYOND, *CORRECTED)
    assert corrected.com[0] == pytest.approx(0.0690, abs=5e-6)
    assert corrected.angle[0] == pytest.approx(150.0, abs=2e-3)
    printed = crossing_five_bar(BEYOND, *PRINTED)
    assert printed.com == pytest.approx([0.0766, 0.0766], abs=5e-5)
    assert printed.angle == pytest.approx([142.1, 142.1], abs=0.05)
    # The closed forms balance the pose: all rates of both inputs.
    for robot in (corrected, printed):
        M = balance.pose.momentum_matrix(robot.linkage, [0.0, 0.0])
        assert np.abs(M).max() < 1e-15


def bends(masses, start=(0.0, 0.0)):
    """Of arms that are mirror images, moment alone: angle between the paths, and both bends."""
    found = balance.find_paths(fuga(BEYOND, masses), [start], kept="moment", length=1.2)
    assert found.dimension == 1 and found.starts[0].kind == "crossing"
    (one, first, _), (two, second, _) = deviations(found)
    return np.degrees(np.arccos(abs(one @ two))), np.sort([first, second])


@pytest.mark.slow
def test_arms_that_are_mirror_images_without_moment():
    """69.0 mm at 150.0° and 1.461 g m²: the symmetry line, and a path straight to 0.2 mm."""
    angle, bent = bends(Masses((0.10274, 88.84), (0.069, 150.0), 1.4615e-3))
    assert angle == pytest.approx(90.0, abs=1e-6)
    assert bent[0] < 1e-9 and 1e-4 < bent[1] < 2e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("upper", "aside", "bend"),
    [((0.069, 150.0), 0.0481, 0.0126), ((0.0766, 142.1), 0.0691, 0.0202)],
)
def test_the_printed_lower_arms_bend_the_second_path(upper, aside, bend):
    """140 mm at 90° with 1.46 g m²: no crossing where it should be, but 48 or 69 mm aside."""
    linkage = fuga(BEYOND, Masses((0.140, 90.0), upper, 1.46e-3))
    found = balance.find_paths(linkage, kept="moment", length=2.0)
    assert len(found.paths) == 1 and found.starts[0].kind == "regular"
    (meeting,) = found.meetings
    angle, bent = bends(Masses((0.140, 90.0), upper, 1.46e-3), meeting.u)
    assert angle == pytest.approx(90.0, abs=1e-6)
    assert bent == pytest.approx([0.0, bend], abs=1e-4)
    place = end_points(linkage, meeting.q[None])[0]
    assert place == pytest.approx([BEYOND + aside, 0.0], abs=2e-4)


@pytest.mark.slow
def test_the_paths_do_not_shake_and_the_diagonal_does():
    """Shaking moments at most 1e-8 of that on the diagonal of the same length and time."""
    robot = crossing_five_bar(BEYOND, *CORRECTED)
    found = balance.find_paths(robot.linkage, length=1.2)
    quiet = [balance.motion.timed_path(robot.linkage, path, 0.4) for path in found.paths]
    ways = [path.direction / np.linalg.norm(path.direction) for path in found.paths]
    # Halfway between both directions one input stands still.
    diagonal = (ways[0] + ways[1]) * 0.25
    loud = rest_to_rest(robot.linkage, [-diagonal, diagonal], 0.4, 801)
    runs = balance.verify(robot.linkage, motions=[*quiet, loud]).runs
    moments = [run.sizes("moment").max() for run in runs]
    assert max(moments[:2]) <= 1e-8 * moments[2]
    assert moments[2] > 0.1


@pytest.mark.slow
def test_the_linkage_of_the_gallery_is_near_its_crossing():
    """The rounding of its table moves the crossing by less than 0.002."""
    found = balance.find_paths("fuga_i")
    (start,) = found.starts
    assert start.kind == "crossing" and 1e-4 < start.distance < 2e-3
    assert len(found.paths) == 2
    assert all(path.reactionless for path in found.paths)


def test_a_path_through_a_crossing_from_aside():
    """Started 0.3 away on the symmetry line, the path runs straight through the crossing."""
    found = balance.find_paths("fuga_i", [{"u1": 0.2, "u3": -0.2}], length=1.5)
    (path,) = found.paths
    assert path.reactionless and [event.kind for event in path.events].count("meeting") == 1
    (meeting,) = [event for event in path.events if event.kind == "meeting"]
    u = np.array([np.interp(meeting.s, path.s, column) for column in path.u.T])
    assert np.abs(u - found.meetings[0].u).max() < 1e-6
    assert np.abs(path.u.sum(axis=1)).max() < 1e-9  # on the symmetry line


def test_derivatives_of_the_equations_by_differences():
    """Of all parts of the momentum; central differences of step 1e-5 are right to 1e-9."""
    for demand in (
        Demand(),
        Demand("moment"),
        Demand("force"),
        Demand("attitude", balance.motion.FloatingBase(3.0, com=(0.1, 0.2, 0.0))),
    ):
        equations = RestEquations(load("two_rrr"), demand)
        here = equations.at(equations.close(np.zeros(equations.chain.parent.size)))
        found = equations.derivative(here.q)
        for i, step in enumerate(1e-5 * np.eye(equations.width)):
            ahead, behind = (equations.at(equations.move(here, s * step)).rows for s in (1, -1))
            change = (ahead - behind) / 2e-5
            assert np.abs(change - found[:, i]).max() < 1e-8 * max(1.0, here.scale)


def test_the_nearest_meeting_is_found_by_newtons_method():
    robot = crossing_five_bar(BEYOND, *CORRECTED)
    equations = RestEquations(robot.linkage, Demand())
    start = equations.at(equations.close(np.zeros(5)))
    aside = equations.at(equations.move(start, np.array([0.05, -0.02])))
    met, distance = meeting_pose(equations, aside, 1, 1.0)
    assert distance == pytest.approx(np.hypot(0.05, 0.02), abs=1e-9)
    assert np.abs(met.q - start.q).max() < 1e-9
    assert meeting_pose(equations, aside, 1, 0.01) is None


def test_leading_directions_move_one_input_each():
    N = np.linalg.qr(np.random.default_rng(0).standard_normal((6, 3)))[0]
    found = leading_directions(N)
    assert np.linalg.matrix_rank(found) == 3
    assert np.abs(found - found @ N @ N.T).max() < 1e-14
    assert (np.abs(found) < 1e-14).sum() >= 6


def test_a_meeting_names_few_of_many_directions():
    """Where the tangents are a cone, the search returns dozens of its lines."""
    solution = balance.find_paths(load("five_bar"), kept="moment", length=0.02)
    (start, *_) = solution.starts
    for count, more in ((4, ""), (44, " | and 40 more")):
        met = replace(
            start,
            q=start.q + 1.0,
            kind="crossing",
            directions=np.tile([0.6, 0.8], (count, 1)),
        )
        words = dict(paths_facts(replace(solution, meetings=(met,))))["meeting"]
        assert words.endswith("u1=0.6, u2=0.8" + more) and words.count("u2=0.8") == 4
