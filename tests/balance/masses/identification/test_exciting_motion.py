"""Exciting motions: limits, rest at both ends, and better than random ones."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.identification.load_rows import load_rows
from balance.motion.verification.given_motions import from_csv
from balance.space.inertial_parameters.conversions import to_chain
from balance.support.options import GRAVITY
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import UsageError


@pytest.fixture(scope="module")
def plan():
    return balance.masses.exciting_motion(
        "five_bar", 2.0, harmonics=3, velocity={"u1": 1.5}, acceleration=9.0, tries=24, seed=3
    )


def test_it_starts_and_ends_at_rest_within_its_limits(plan):
    time, u, ud, udd = plan.samples(2001)
    ends = [0, -1]
    for values in (u, ud, udd):
        assert np.abs(values[ends]).max() < 1e-12
    assert np.abs(ud[:, 0]).max() <= 1.5 and np.abs(udd).max() <= 9.0
    # One limit is reached: a smaller motion excites less.
    assert np.abs(ud[:, 0]).max() > 0.99 * 1.5 or np.abs(udd).max() > 0.99 * 9.0
    step = time[1] - time[0]
    assert np.abs(np.gradient(u, step, axis=0) - ud)[2:-2].max() < 1e-4
    assert np.abs(np.gradient(ud, step, axis=0) - udd)[2:-2].max() < 1e-3


def test_it_excites_more_than_random_motions(plan):
    assert plan.excitation.error < 0.9 * plan.random.error
    assert plan.tries <= 24 and "best of" in plan.words


def test_the_errors_that_it_promises_are_those_of_a_measurement(plan):
    """The condition, from noise that is drawn and estimated."""
    linkage = kinematics.load("five_bar")
    way = plan.trajectory
    length, middle = plan.space.length, linkage.spatial_chain.frame.origin
    chain = input_chain(linkage)
    z = np.array([body.inertia for body in linkage.bodies])
    x = to_chain(z, chain.frame, False, False).reshape(-1)
    wrench = load_rows(linkage, way, np.array(GRAVITY), middle).wrench @ x
    force, moment = wrench[:, :3], wrench[:, 3:]
    rng, noise = np.random.default_rng(1), 1e-3
    force = force + noise * rng.normal(size=force.shape)
    moment = moment + noise * length * rng.normal(size=moment.shape)
    names = ("fx", "fy", "fz", "mx", "my", "mz")
    loads = dict(zip(names, np.hstack([force, moment]).T, strict=True))
    found = balance.identify(
        linkage, way, {"time": way.time, **loads}, about=middle, on_linkage=True
    )
    assert found.complete
    ratio = found.condition / plan.excitation.condition
    assert 0.7 < ratio < 1.4


def test_its_table_is_read_again(plan, tmp_path):
    path = tmp_path / "motion.csv"
    plan.table(path)
    linkage = kinematics.load("five_bar")
    read = from_csv(linkage, path)
    u, ud, udd = plan.path.at(read.time)
    assert np.abs(read.u - u).max() < 1e-12
    assert np.abs(read.ud - ud).max() < 1e-9 and np.abs(read.udd - udd).max() < 1e-7


@pytest.mark.slow
def test_limits_of_joints_that_follow_are_kept(tmp_path):
    text = kinematics.gallery()["four_bar_general"].read_text("utf-8")
    free = balance.masses.exciting_motion("four_bar_general", 2.0, tries=12)
    joint = [j.name for j in free.space.linkage.joints].index("q2")
    reach = np.abs(free.trajectory.q[:, joint]).max()
    limited = tmp_path / "limited.urdf"
    tag = '<joint name="q2" type="continuous">'
    assert tag in text
    limit = f'<limit lower="{-0.3 * reach}" upper="{0.3 * reach}" effort="1" velocity="9"/>'
    limited.write_text(text.replace(tag, f'<joint name="q2" type="revolute">{limit}'), "utf-8")
    plan = balance.masses.exciting_motion(limited, 2.0, tries=12)
    assert np.abs(plan.trajectory.q[:, joint]).max() <= 0.3 * reach


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"duration": 0.0}, "not above 0"),
        ({"harmonics": 1}, "needs two or more"),
        ({"tries": 0}, "at least one motion"),
        ({"velocity": {"ghost": 1.0}}, "'ghost' is no input"),
        ({"acceleration": -1.0}, "must be above 0"),
    ],
)
def test_what_cannot_be_planned_is_told(options, told):
    with pytest.raises(UsageError, match=told):
        balance.masses.exciting_motion("five_bar", **options)
