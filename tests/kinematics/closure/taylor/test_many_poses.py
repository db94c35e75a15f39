"""Taylor expansions about many poses: those of the linkage that has each as its reference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinematics import load, taylor_motion, taylor_motion_many, tool
from kinematics.closure.assembly.assemble import assemble
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import PoseError
from kinematics.model.arrays import freeze
from kinematics.model.spatial.screws import Ad
from kinematics.numerics.compiled.simd import VECTOR_WIDTH

pytestmark = pytest.mark.lanes

NAMES = (
    "four_bar_general",
    "five_bar",
    "three_rsr",
    "slider_crank",
    "bennett",
    "four_rrr",
    "hprs",
)


def with_reference_pose(linkage, q):
    """The linkage with its screws carried to a pose."""
    H = forward_kinematics(si_chain(linkage, True), q).H
    before = [H[joint.parent] if joint.parent >= 0 else np.eye(4) for joint in linkage.joints]
    joints = tuple(
        replace(
            joint,
            screw=freeze(Ad(h) @ joint.screw),
            point=freeze(h[:3, :3] @ joint.point + h[:3, 3]),
        )
        for joint, h in zip(linkage.joints, before, strict=True)
    )
    return assemble(replace(linkage, joints=joints), linkage.inputs)


def closed_poses(linkage, count, seed, size=0.05):
    """Displacements of the inputs at random, and the positions of all joints there."""
    rng = np.random.default_rng(seed)
    inputs = size * rng.standard_normal((count, linkage.mobility))
    return inputs, np.array([joint_positions(linkage, u) for u in inputs])


@pytest.mark.parametrize("name", NAMES)
def test_every_pose_as_reference_pose(name):
    linkage = load(name)
    _, poses = closed_poses(linkage, 3, seed=301)
    found = taylor_motion_many(linkage, poses, 4)
    assert np.array_equal(found.coefficients[:, 0], poses)
    for q, coefficients in zip(poses, found.coefficients, strict=True):
        one = taylor_motion(with_reference_pose(linkage, q), 4)
        assert one.joints == found.joints and np.array_equal(one.exponents, found.exponents)
        size = np.abs(one.coefficients).max()
        assert np.abs(one.coefficients - coefficients)[1:].max() < 1e-13 * size


def test_more_poses_than_lanes_and_a_point_next_to_each():
    """Newton's method closes the loops there, without any series in the inputs."""
    linkage, count = load("five_bar"), 2 * VECTOR_WIDTH + 3
    inputs, poses = closed_poses(linkage, count, seed=302)
    steps = 0.01 * np.random.default_rng(303).standard_normal(inputs.shape)
    found = taylor_motion_many(linkage, poses, 8)
    true = [joint_positions(linkage, u) for u in inputs + steps]
    assert np.abs(found.evaluate(steps) - true).max() < 1e-12
    again = taylor_motion_many(linkage, poses[-1:], 8)
    assert np.array_equal(again.coefficients[0], found.coefficients[-1])


def test_inverse_kinematics_along_a_line():
    """A point of the platform is the input, along a line with two coordinates."""
    linkage = load("five_bar")
    body = linkage.bodies[1].name
    moved = tool(linkage, body, "x,y", [0.3, 1.2, 0.0])
    names = [joint.name for joint in moved.joints]
    line = f"{moved.inputs[1]}=0.5*{moved.inputs[0]}"
    one = taylor_motion(moved, 8, line)
    poses = np.array([one.polish([s]) for s in (-0.02, 0.0, 0.03)])
    found = taylor_motion_many(moved, poses, 8, line)
    assert found.coefficients.shape == (3, 9, len(names))
    assert found.motion.inputs == moved.inputs
    size = np.abs(one.coefficients).max()
    assert np.abs(found.coefficients[1] - one.coefficients).max() < 1e-13 * size
    assert np.abs(found.evaluate([0.01])[0] - one.polish([-0.01])).max() < 1e-12


def test_bad_poses_are_refused():
    linkage = load("four_bar_general")
    _, poses = closed_poses(linkage, 3, seed=304)
    with pytest.raises(PoseError, match=r"4 finite joint positions each, .* shape \(4,\)"):
        taylor_motion_many(linkage, poses[0], 3)
    opened = poses.copy()
    opened[1, 2] += 0.1
    with pytest.raises(PoseError, match="pose 1 leaves the loops open by 0"):
        taylor_motion_many(linkage, opened, 3)
    with pytest.raises(PoseError, match="finite"):
        taylor_motion_many(linkage, poses * np.nan, 3)
    with pytest.raises(ValueError, match="the order is at least 1"):
        taylor_motion_many(linkage, poses, 0)


def test_a_pose_that_determines_no_motion_has_no_coefficients():
    """A parallelogram flattened onto its base."""
    linkage = load("four_bar_parallelogram")
    points = {joint.name: joint.point for joint in linkage.joints}
    crank, base = points["q2"] - points["u1"], points["q4"] - points["u1"]
    angle = np.arctan2(base[1], base[0]) - np.arctan2(crank[1], crank[0])
    # Its joints turn in proportion.
    flat = joint_positions(linkage, [0.1]) * (angle / 0.1)
    found = taylor_motion_many(linkage, [flat, np.zeros(4)], 3)
    assert not found.condition[0] < 1e8 and np.isnan(found.coefficients[0, 1:]).all()
    assert found.condition[1] < 1e3 and np.isfinite(found.coefficients[1]).all()
