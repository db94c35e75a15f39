"""Joints at rest by symmetry, against rates at poses far away, in any frame."""

from fractions import Fraction
from itertools import islice

import numpy as np
import pytest

import kinematics
from balance.space.exact.chain import exact_chain
from balance.space.exact.idle_joints import joints_at_rest_by_symmetry
from kinematics.closure.assembly.assemble import moving_chain
from kinematics.closure.continuation import continue_along
from kinematics.files.urdf.rational_poses import RationalPose, rotation
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.model.motion import motion_of


def chain_of(name, motion):
    """A linkage under a motion in rational numbers."""
    linkage = kinematics.load(name)
    return exact_chain(linkage, exact_geometry(linkage), motion_of(linkage, motion))


def names_at_rest(name, motion):
    """Names of the joints that rest by symmetry."""
    joints = kinematics.load(name).joints
    return {joints[j].name for j in joints_at_rest_by_symmetry(chain_of(name, motion))}


def names_without_rate(name, motion):
    """Names of the joints that rest at poses far away, in floating point."""
    linkage = kinematics.load(name)
    moving = moving_chain(
        linkage,
        motion_of(linkage, motion),
        True,
        idle=np.zeros(len(linkage.joints), dtype=np.bool_),
    )
    rng, moved = np.random.default_rng(3), np.zeros(len(linkage.joints), dtype=np.bool_)
    for _ in range(3):
        ray = rng.standard_normal(moving.width)
        for pose in islice(continue_along(moving, ray, longest_step=0.2), 4):
            moved |= np.abs(pose.q) > 1e-9
    return {
        joint.name for joint, turned in zip(linkage.joints, moved, strict=True) if not turned
    }


@pytest.mark.parametrize(
    ("motion", "resting"),
    [
        ("u2=u3", {"elbow1_x", "elbow1_z"}),
        (None, set()),
        ("u2=-u3", set()),
        ("u2=2*u3", set()),
    ],
)
def test_a_ball_in_the_plane_of_symmetry_turns_about_its_normal(motion, resting):
    assert names_at_rest("three_rsr", motion) == resting
    assert names_without_rate("three_rsr", motion) == resting


def test_symmetry_does_not_depend_on_the_frame():
    chain = chain_of("three_rsr", "u2=u3")
    n, d = (Fraction(1), Fraction(-2), Fraction(3)), (Fraction(5), Fraction(7), Fraction(-1))
    moved = RationalPose(rotation(n, Fraction(2, 7)), d)
    turned = chain._replace(screws=tuple(moved.carry(screw) for screw in chain.screws))
    found = joints_at_rest_by_symmetry(chain)
    assert found and joints_at_rest_by_symmetry(turned) == found


def test_a_linkage_that_is_off_by_little_has_no_symmetry():
    chain = chain_of("three_rsr", "u2=u3")
    screws = list(chain.screws)
    screws[7] = tuple(x + Fraction(k == 4, 10**30) for k, x in enumerate(screws[7]))
    assert not joints_at_rest_by_symmetry(chain._replace(screws=tuple(screws)))
