"""Shaking within tolerances: bounds, draws of real linkages, by hand, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import balance
import kinematics
from balance.motion.manufacture.analyse import directions, worst_case
from balance.motion.manufacture.deviations import (
    Tolerances,
    deviating_loads,
    deviations_of,
)
from balance.motion.verification.trajectory import drive, random_motions
from kinematics.errors import LinkageError, UsageError
from tests.independent import reference
from tests.independent.measured_loads import load_regressor
from tests.support.laws import point_masses, sums

MACHINES = (
    "four_bar_general",
    "four_bar_kite_balanced",
    "five_bar",
    "slider_crank",
    "rusr",
    "six_bar_watt",
    "six_bar_stephenson",
    "three_rrr",
    "double_pendulum_counter_rotary",
    "four_bar_parallelogram",
)


def displaced(z, d):
    """Parameters of a body whose points are all displaced by d."""
    m, mc = z[0], z[1:4]
    E = np.array([[z[4], z[7], z[8]], [z[7], z[5], z[9]], [z[8], z[9], z[6]]])
    S = 0.5 * np.trace(E) * np.eye(3) - E
    S = S + np.outer(mc, d) + np.outer(d, mc) + m * np.outer(d, d)
    E = np.trace(S) * np.eye(3) - S
    entries = [E[0, 0], E[1, 1], E[2, 2], E[0, 1], E[0, 2], E[1, 2]]
    return np.array([m, *(mc + m * d), *entries])


def drawn_peaks(linkage, ways, mass, com, count, seed, point, corners=False):
    """Peak force and moment of linkages within tolerances, each computed anew."""
    rng = np.random.default_rng(seed)
    z = np.array([body.inertia for body in linkage.bodies])
    frames = [body.frame[:3, :3] for body in linkage.bodies]
    # Loads per parameter: shaking is linear in them.
    units = np.eye(z.size).reshape(-1, *z.shape)
    rows = [
        np.stack(
            [balance.motion.shaking(linkage, way.u, way.ud, way.udd, unit) for unit in units],
            axis=2,
        )
        for way in ways
    ]
    rows = np.concatenate(rows)
    rows[:, :3] -= np.cross(point, rows[:, 3:].swapaxes(1, 2)).swapaxes(1, 2)
    peaks = []
    for _ in range(count):
        made = []
        for own, R in zip(z, frames, strict=True):
            share, d = rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0, 3)
            if corners:
                share, d = np.sign(share), np.sign(d)
            made.append((1.0 + mass * share) * displaced(own, R @ (com * d)))
        wrench = rows @ np.concatenate(made)
        peaks.append(np.linalg.norm(wrench.reshape(-1, 2, 3), axis=2).max(axis=0))
    return np.array(peaks)[:, ::-1]


@pytest.mark.slow
@pytest.mark.parametrize("name", MACHINES)
def test_no_linkage_within_the_tolerances_shakes_more(name):
    """Draws from the inside and from the corners; what is reached is close to the bound."""
    linkage = kinematics.load(name)
    ways = list(random_motions(linkage, 2, 40))
    point = linkage.spatial_chain.frame.origin
    found = balance.motion.shaking_tolerance(
        linkage, mass=0.02, com=1e-3, motions=ways, draws=2000
    )
    most = []
    for corners in (False, True):
        peaks = drawn_peaks(linkage, ways, 0.02, 1e-3, 10_000, 1, point, corners)
        for spread, drawn in ((found.force, peaks[:, 0]), (found.moment, peaks[:, 1])):
            assert drawn.max() <= spread.bound * (1.0 + 1e-9)
            assert spread.nominal <= spread.reached <= spread.bound
            assert spread.reached >= 0.9 * spread.bound
            most.append(drawn.max() / spread.bound)
            if not corners:
                for quantile, value in ((50, spread.median), (95, spread.high)):
                    true = np.percentile(drawn, quantile)
                    assert abs(value - true) < 0.05 * true
    # The largest of all draws is within 10 % of the bound.
    assert max(most[0], most[2]) > 0.9 and max(most[1], most[3]) > 0.9, most
    assert found.proved


def test_a_crank_by_hand():
    """One body that turns at constant speed: ``m ω² r``, r longer by the tolerance."""
    linkage = kinematics.from_dh(
        [[0.0, 0.0, 0.5, 0.0]], bodies={"link1": (2.0, (-0.3, 0.0, 0.0), 0.01 * np.eye(3))}
    )
    time = np.linspace(0.0, 1.0, 50)
    speed = 3.0 + 0.0 * time
    way = drive(linkage, time, (3.0 * time)[:, None], speed[:, None], 0.0 * speed[:, None])
    radius = float(np.linalg.norm(linkage.bodies[0].inertia[1:3]) / 2.0)
    found = balance.motion.shaking_tolerance(linkage, mass=0.1, com=0.01, motions=[way])
    assert abs(found.force.nominal - 2.0 * 9.0 * radius) < 1e-9
    worst = 1.1 * 2.0 * 9.0 * np.hypot(radius + 0.01, 0.01)
    assert found.force.reached <= worst * (1.0 + 1e-9) <= found.force.bound * (1.0 + 1e-9)
    assert found.force.bound < 1.002 * worst
    shares = {share.deviation.kind: share.force for share in found.shares}
    assert abs(shares["mass"] - 0.1 * 18.0 * radius) < 0.01 * shares["mass"]


def test_axes_that_are_displaced_by_another_route():
    """Momenta of point masses of a linkage with a displaced joint, by differences."""
    linkage = kinematics.load("four_bar_general")
    (way,) = random_motions(linkage, 1, 60)
    tolerance, step = 1e-4, 1e-4
    bounds = Tolerances(length=tolerance)
    deviations = deviations_of(linkage, bounds)
    time = way.time[[20, 21, 22]]
    there = drive(linkage, time, *way.path.at(time))
    found = deviating_loads(linkage, there, bounds, deviations, np.zeros(3))
    mechanism = reference.load(kinematics.gallery()["four_bar_general"], linkage.inputs)
    order = [mechanism.bodies.index(body.name) for body in linkage.bodies]
    z = np.zeros((len(order), 10))
    z[order] = [body.inertia for body in linkage.bodies]

    def path(now):
        u, ud, _ = way.path.at(np.array([now]))
        return u[0], ud[0]

    def loads(joint, shift):
        twists = mechanism.twists.copy()
        twists[joint, :3, 3] += np.cross(shift, [0.0, 0.0, 1.0])
        moved = replace(mechanism, twists=twists)
        return load_regressor(moved, path, time, np.zeros(3)) @ z.reshape(-1)

    for name in ("u1", "q2"):
        joint = mechanism.joints.index(name)
        owner = [item.name for item in deviations].index(name)
        columns = [k for k, item in enumerate(found.owners) if item == owner]
        for column, axis in zip(columns, np.eye(3), strict=False):
            slope = (loads(joint, step * axis) - loads(joint, -step * axis)) / (2.0 * step)
            expected = tolerance * np.roll(slope, 3, axis=1)
            error = np.abs(found.columns[:, :, column] - expected).max()
            assert error < 1e-5 * np.abs(expected).max()


def test_lengths_count_to_first_order():
    found = balance.motion.shaking_tolerance(
        "four_bar_general", length=1e-4, trajectories=1, draws=500
    )
    assert not found.proved and "to first order in lengths" in found.words
    assert {share.deviation.kind for share in found.shares} == {"length"}
    assert found.force.nominal < found.force.reached <= found.force.bound
    assert found.force.largest <= found.force.bound
    assert found.force.reached < 1.05 * found.force.nominal


def test_the_grid_of_directions_covers_the_sphere():
    units, cosine = directions()
    rng = np.random.default_rng(0)
    some = rng.normal(size=(500, 3))
    some /= np.linalg.norm(some, axis=1)[:, None]
    nearest = (some @ units.T).max(axis=1)
    assert nearest.min() >= cosine
    assert nearest.min() < 1.0 - 0.2 * (1.0 - cosine)


def test_the_worst_case_of_all_corners():
    """All vertices of a box of ten sides, tried one by one."""
    rng = np.random.default_rng(4)
    F, C = rng.normal(size=(5, 3)), rng.normal(size=(5, 3, 10))
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 10)).reshape(10, -1)
    true = np.linalg.norm(F[:, :, None] + C @ corners, axis=1).max()
    found = worst_case(F, C, np.zeros(5))
    assert found.least <= true * (1.0 + 1e-12) and true <= found.most
    assert found.most < 1.001 * true and found.least > 0.999 * true


def test_a_cloud_that_is_displaced():
    rng = np.random.default_rng(2)
    masses, points = point_masses(rng, 6)
    d = np.array([0.1, -0.2, 0.3])
    moved = displaced(sums(masses, points), d)
    np.testing.assert_allclose(moved, sums(masses, points + d), rtol=1e-12, atol=1e-12)


def test_a_turn_of_the_crank_is_the_motion():
    """The nominal peak is that of Pinocchio along the same turn."""
    model = "four_bar_general"
    options = {"mass": 0.02, "draws": 20}
    spread = balance.motion.shaking_tolerance(model, speed="300rpm", **options)
    peak = balance.verify(model, speed="300rpm").force
    assert spread.force.nominal == pytest.approx(peak, rel=1e-9)
    with pytest.raises(ValueError, match="either a speed or motions"):
        balance.motion.shaking_tolerance(model, speed=10.0, motions="a.csv", **options)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({}, "give a tolerance above 0"),
        ({"mass": 1.0}, "is not a part from 0 up to 1"),
        ({"com": -1e-3}, "is not 0 or more"),
        ({"length": np.inf}, "is not 0 or more"),
    ],
)
def test_what_cannot_be_asked_is_told(options, told):
    with pytest.raises(UsageError, match=told):
        balance.motion.shaking_tolerance("four_bar_general", **options)


def test_overconstrained_loops_do_not_close_with_other_lengths():
    with pytest.raises(LinkageError, match="overconstrained"):
        balance.motion.shaking_tolerance("bennett", length=1e-4, trajectories=1)
