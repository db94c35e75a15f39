"""Without named inputs the joints on the base drive, where they are a set of inputs."""

import numpy as np
import pytest

from kinematics import ScrewJoint, from_screws

# A five-bar: base pivots A and E, elbows B and D, tool C.
A, B, C, D, E = (0, 0, 0), (-0.2, 0.3, 0), (0.2, 0.7, 0), (0.7, 0.35, 0), (0.4, 0, 0)


def hinge(name, parent, child, point):
    return ScrewJoint(name, parent, child, point=point)


def test_both_cranks_of_a_five_bar_drive_it():
    """The elbow of the first crank stands before the second crank in the file."""
    joints = [
        hinge("crank_left", "base", "left", A),
        hinge("elbow_left", "left", "arm_left", B),
        hinge("crank_right", "base", "right", E),
        hinge("elbow_right", "right", "arm_right", D),
    ]
    linkage = from_screws(joints, [hinge("tool", "arm_left", "arm_right", C)])
    assert linkage.inputs == ("crank_left", "crank_right")


def test_a_crank_that_closes_the_loop_on_the_base_drives():
    joints = [
        hinge("crank_left", "base", "left", A),
        hinge("elbow_left", "left", "arm_left", B),
        hinge("tool", "arm_left", "arm_right", C),
        hinge("elbow_right", "arm_right", "right", D),
    ]
    linkage = from_screws(joints, [hinge("crank_right", "right", "base", E)])
    assert linkage.inputs == ("crank_left", "crank_right")


def test_joints_on_the_base_that_depend_on_each_other_are_completed():
    """The rocker of a four-bar follows its crank: the pendulum on its coupler is the other."""
    joints = [
        hinge("crank", "base", "crank", A),
        hinge("pin", "crank", "coupler", B),
        hinge("pendulum", "coupler", "bob", C),
        hinge("rocker", "base", "rocker", E),
    ]
    linkage = from_screws(joints, [hinge("pin_2", "coupler", "rocker", D)])
    assert linkage.inputs == ("crank", "pendulum")


@pytest.mark.parametrize("named", ["elbow_left", "crank_left"])
def test_inputs_that_are_named_stay_and_a_crank_completes_them(named):
    joints = [
        hinge("crank_left", "base", "left", A),
        hinge("elbow_left", "left", "arm_left", B),
        hinge("elbow_right", "right", "arm_right", D),
        hinge("crank_right", "base", "right", E),
    ]
    loop = hinge("tool", "arm_left", "arm_right", C)
    linkage = from_screws(joints, [loop], inputs=[named])
    assert linkage.inputs[0] == named and linkage.inputs[1].startswith("crank")


def test_a_chain_keeps_its_joints_in_the_order_of_the_file():
    points = np.array([A, B, C])
    names = ["base", "upper", "lower", "hand"]
    joints = [
        hinge(f"j{k}", names[k], names[k + 1], tuple(point)) for k, point in enumerate(points)
    ]
    assert from_screws(joints).inputs == ("j0", "j1", "j2")
