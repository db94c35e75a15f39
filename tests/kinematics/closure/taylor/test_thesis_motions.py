"""Printed Taylor motions come out; docs/reproduction.md lists the figures.

[J] J. J. de Jong, PhD thesis, University of Twente, chapter 4. The lengths of its arm and of
its five-bar are not printed: ours have the features that it names.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import kinematics
from kinematics import taylor_motion, tool
from kinematics.closure.assembly.assemble import assemble
from kinematics.closure.assembly.rereference import rereference
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import LinkageError, PoseError
from kinematics.model.chain import arrange_loops
from tests.independent.reference import closure, displacements, load
from tests.support.robots import arm, bennett

# An arm in the xz-plane with its wrist at (0, 0, 0.3); along y it is stretched at 1.4017 m.
ARM = (
    [(-1.5, 0, 0.3), (-1.5, 0, 0.3), (-0.7, 0, 1.0), (0, 0, 0.3), (0, 0, 0.3), (0, 0, 0.3)],
    [(0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, -1), (0, 1, 0), (0, 0, -1)],
)
STRETCHED = np.sqrt((np.hypot(0.8, 0.7) + np.hypot(0.7, 0.7)) ** 2 - 1.5**2)
TIP = np.array([0.5, 1.1, 0.0])
TWISTS = (0.6, 1.0)
SIDES = (1.0, np.sin(1.0) / np.sin(0.6))


# --- a serial robot along a line -----------------------------------------------------------


@pytest.fixture(scope="module")
def line(tmp_path_factory):
    """The file of the arm, and its inverse kinematics along y."""
    path = arm(tmp_path_factory.mktemp("arm"), *ARM)
    return path, tool(kinematics.load(path), "l6", "y")


def tracking(path, q, y):
    """How far the wrist is from where it should be (metres), and how far it has turned."""
    H = displacements(load(path), q[:6])[0][5]
    at = np.array(ARM[0][5])
    shift = H[:3, :3] @ at + H[:3, 3] - at - [0.0, y, 0.0]
    return np.linalg.norm(shift), np.linalg.norm(H[:3, :3] - np.eye(3)) / np.sqrt(2.0)


def test_the_arm_follows_the_line_to_the_end_of_its_workspace(line):
    """[J] Fig. 4.1: order 7 converges up to the edge of the workspace, and not beyond it."""
    path, linkage = line
    assert linkage.inputs == ("l6.y",) and linkage.mobility == 1
    errors = {}
    for order in (1, 3, 5, 7):
        motion = taylor_motion(linkage, order)
        for y in (0.35, 0.7, 1.05, 1.4):
            q = motion.evaluate([y])
            errors[order, y] = max(tracking(path, q, y))
    for y in (0.35, 0.7, 1.05):
        shrinking = [errors[order, y] for order in (1, 3, 5, 7)]
        assert shrinking == sorted(shrinking, reverse=True)
    assert errors[7, 0.35] < 4.6e-7 and errors[7, 0.7] < 2e-4 and errors[7, 1.05] < 6.7e-3
    edge = motion.distance([STRETCHED])
    assert 0.85 * edge < motion.radius < edge
    with pytest.raises(PoseError, match="cannot be closed"):
        joint_positions(linkage, [1.001 * STRETCHED])
    assert max(tracking(path, joint_positions(linkage, [1.4]), 1.4)) < 1e-8
    assert max(tracking(path, motion.evaluate([2.0]), 2.0)) > 1.0


# --- the five-bar --------------------------------------------------------------------------


@cache
def five_bar(order):
    return taylor_motion(tool(kinematics.load("five_bar"), "left_upper", "x,y", TIP), order)


def missed(q):
    """Distance between the tips of the two arms (metres), by an independent closure."""
    return np.linalg.norm(closure(load(kinematics.gallery()["five_bar"]), q[:4])[0][:3])


@pytest.mark.parametrize("path", [(1, 0), (0, 1), (1, 1), (1, -1)])
def test_the_five_bar_follows_four_paths(path):
    """[J] Fig. 4.2: both axes and both diagonals, order 7, on both sides of the start."""
    whole = five_bar(7)
    ray = np.array(path) / np.linalg.norm(path) * whole.scales[0]
    for sign in (1.0, -1.0):
        errors = []
        for share in (0.25, 0.5, 0.75, 1.0):
            u = sign * share * whole.radius * ray
            errors.append([missed(five_bar(order).evaluate(u)) for order in (1, 3, 5, 7)])
        errors = np.array(errors)
        assert (errors[0] < [2.5e-3, 4.3e-5, 1.2e-6, 3.5e-8]).all()
        assert (errors[:, 3] < [3.5e-8, 1e-5, 3e-4, 3.3e-3]).all()
        assert (np.diff(errors, axis=1) < 0.0).all() and (np.diff(errors, axis=0) > 0.0).all()


# --- the Bennett linkage -------------------------------------------------------------------


@cache
def collapsed(folder):
    return kinematics.load(bennett(folder, SIDES, TWISTS), inputs=["q1"])


def at(linkage, degrees):
    """The linkage with another reference pose."""
    chain = arrange_loops(linkage)
    q = joint_positions(linkage, np.radians([degrees])) / chain.units
    return assemble(rereference(linkage, chain, q), ["q1"])


@pytest.mark.parametrize(
    ("equations", "holds", "fails"), [((0, 1, 2), 6.5, 20.0), (None, 90.0, None)]
)
def test_bennett_near_its_collapsed_pose(equations, holds, fails, tmp_path_factory):
    """[J] Fig. 4.3: order 10, 0.4° from the collapsed pose; exact to 0.01° of all joints.

    The three equations of rotation are nearly dependent there; all six are not. The true
    angles are closed in small steps.
    """
    linkage = at(collapsed(tmp_path_factory.getbasetemp()), 0.4)
    motion = taylor_motion(linkage, 10, equations=equations)
    assert (motion.condition > 100.0) == (equations is not None)

    def off(degrees):
        u = np.radians([degrees])
        return np.degrees(np.abs(motion.evaluate(u) - joint_positions(linkage, u)).max())

    for sign in (1.0, -1.0):
        for share in (0.2, 0.5, 1.0):
            assert off(sign * share * holds) < 0.01
        if fails is not None:
            assert off(sign * fails) > 0.1
    if equations is None:
        assert off(30.0) < 1e-6


def test_bennett_moves_as_its_closed_form_says(tmp_path_factory):
    """Half-angle tangents keep a constant ratio, from 0.4° to 90°; [J] Eq. 4.34."""
    linkage = collapsed(tmp_path_factory.getbasetemp())
    ratios = []
    for degrees in (0.4, 6.0, 30.0, 90.0):
        q = joint_positions(linkage, np.radians([degrees]))
        ratios.append(np.tan(q[1] / 2.0) / np.tan(q[0] / 2.0))
    half = np.sin((TWISTS[1] - TWISTS[0]) / 2.0) / np.sin(sum(TWISTS) / 2.0)
    assert ratios == pytest.approx([-half] * 4, rel=1e-9)


def test_the_printed_length_does_not_move(tmp_path):
    """[J] page 71 rounds l2 = 1.4903 m to 1.5 m."""
    assert pytest.approx(1.4903, abs=5e-5) == SIDES[1]
    with pytest.raises(LinkageError):
        kinematics.load(bennett(tmp_path, (1.0, 1.5), TWISTS), inputs=["q1"])
