"""Loads at many samples at once, beside the series of the product and Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.motion.quiet.sampled_loads import SampledLinkage
from balance.motion.verification.joint_reactions import joint_reactions
from balance.motion.verification.shaking_wrench import inertia_loads, mass_parameters
from balance.motion.verification.trajectory import random_motions
from kinematics.closure.joint_positions import si_chain
from tests.support.laws import relative
from tests.support.planned_arms import TASKS, planar_arm, six_axes, torques

GRAVITY = np.array([0.3, -1.0, -9.81])


def sampled(linkage, count=6, gravity=GRAVITY):
    """A linkage, poses of a random motion, and the motion."""
    model = SampledLinkage.of(linkage, gravity)
    motion = next(random_motions(linkage, 1, count))
    return model, model.close(motion.q), motion


@pytest.mark.table(3)
@pytest.mark.parametrize("name", [*TASKS, "stewart_6ups", "three_rsr", "four_bar_chain"])
def test_shaking_is_that_of_the_series(name):
    linkage = TASKS[name][0]() if name in TASKS else kinematics.load(name)
    model, poses, motion = sampled(linkage)
    loads = model.loads(poses, motion.ud[..., None], motion.udd[..., None])[..., 0]
    series = balance.motion.shaking(linkage, motion.u, motion.ud, motion.udd)
    assert relative(loads[:, :6], series) < 1e-11


@pytest.mark.parametrize("arm", [lambda: planar_arm(3), six_axes])
def test_torques_are_those_of_pinocchio(arm):
    linkage = arm()
    model, poses, motion = sampled(linkage)
    loads = model.loads(poses, motion.ud[..., None], motion.udd[..., None])[..., 0]
    theirs = torques(linkage, motion.u, motion.ud, motion.udd, GRAVITY)
    assert relative(loads[:, 6:], theirs) < 1e-10


def test_torques_of_loops_are_those_of_the_joint_reactions():
    linkage = kinematics.load("five_bar")
    model, poses, motion = sampled(linkage, gravity=np.zeros(3))
    loads = model.loads(poses, motion.ud[..., None], motion.udd[..., None])[..., 0]
    chain = si_chain(linkage, spatial=True)
    inertia = inertia_loads(chain, mass_parameters(linkage), motion.q, motion.ud, motion.udd)
    motors = joint_reactions(chain, inertia).motors[:, linkage.positions_of(linkage.inputs)]
    assert relative(loads[:, 6:], motors) < 1e-10


@pytest.mark.parametrize("name", ["planar_3r", "five_bar"])
def test_derivatives_are_those_of_a_line(name):
    """Along a line of positions, velocities and accelerations at once."""
    model, poses, motion = sampled(TASKS[name][0]())
    state = np.stack([motion.u, motion.ud, motion.udd])
    loads = model.sample(poses, *state)
    way = np.random.default_rng(1).standard_normal(state.shape)
    pieces = zip((loads.by_u, loads.by_ud, loads.by_udd), way, strict=True)
    slope = sum(np.einsum("nij,nj->ni", by, step) for by, step in pieces)
    ends = []
    for side in (-1.0, 1.0):
        u, ud, udd = state + side * 1e-4 * way
        ends.append(model.loads(model.near(poses, u), ud[..., None], udd[..., None])[..., 0])
    assert relative(slope, (ends[1] - ends[0]) / 2e-4) < 1e-5


def test_a_pose_beyond_reach_is_none():
    model, poses, _ = sampled(kinematics.load("five_bar"))
    far = np.tile([3.0, -3.0], (len(poses.q), 1))
    assert model.near(poses, far) is None
