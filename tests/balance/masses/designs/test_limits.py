"""Masses within a ball about the joints of each link: what it means, and both verdicts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.masses.designs.best_design import design
from balance.masses.designs.mass_regions import ball_of, middle_of, reach_of
from kinematics.closure.assembly.assemble import assemble
from tests.independent import reference
from tests.support import balls
from tests.support.drafts import axis_edge, linked
from tests.support.laws import sums
from tests.support.shapes import matrix

READ = [
    "four_bar_kite_balanced",
    "slider_crank",
    "five_bar",
    "three_rrr",
    "pantograph",
    "four_bar_spherical",
    "bennett",
    "six_bar_watt",
    "fuga_i",
]


def space_of(model, motion=None, **more):
    return design_space(kinematics.load(model), motion, **more)


# --- the ball -------------------------------------------------------------------------------


@pytest.mark.parametrize("spatial", [False, True])
@pytest.mark.parametrize("model", READ)
def test_balls_are_those_of_the_second_reading(model, spatial):
    """Joints and loops from the file, the smallest ball through them by another formula."""
    space = design_space(kinematics.load(model), spatial=spatial)
    mechanism, still = reference.load(model), balls.still(space)
    found = design(space, within=1.7).balls
    assert set(found) == set(space.bodies)
    for name, ball in found.items():
        places = balls.places(mechanism, name) @ still
        centre, radius = balls.ball(places, 1.7, space.length)
        assert np.linalg.norm(still @ ball.centre - centre) < 1e-9 * space.length
        assert ball.radius == pytest.approx(radius, rel=1e-9)


@pytest.mark.table(17)
@pytest.mark.parametrize("seed", range(30))
def test_the_middle_is_that_of_the_smallest_ball(seed):
    rng = np.random.default_rng(seed)
    d, count = 2 + seed % 2, int(rng.integers(1, 9))
    points = rng.uniform(-1.0, 1.0, (count, d))
    if seed % 5 == 0:  # on one line, or all in one place
        points = points[:1] + rng.choice([0.0, 1.0]) * rng.random((count, 1)) * points[-1:]
    points = np.vstack([points, points[: seed % 3]])
    centre, (known, radius) = middle_of(points), balls.smallest_ball(points)
    assert np.linalg.norm(centre - known) < 1e-9
    # No other centre is nearer to the furthest point.
    for step in rng.standard_normal((50, d)) * 10.0 ** rng.uniform(-6, 0, (50, 1)):
        assert np.linalg.norm(points - known - step, axis=1).max() > radius - 1e-12


def test_six_joints_on_a_circle_have_its_centre():
    angles = np.arange(6) * np.pi / 3.0 + 0.1
    points = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles]) + 5.0
    assert np.linalg.norm(middle_of(points) - 5.0) < 1e-12


def test_a_link_without_length_takes_the_characteristic_one():
    """One joint, and no mass or one on the joint; a centre of mass elsewhere is a length."""
    rng, z = np.random.default_rng(0), np.array([0.0, 0.0, 1.0])
    x = np.array([1.0, 0.0, 0.0])
    edges = [axis_edge("revolute", z, k * x, (k, k + 1), f"j{k}") for k in range(3)]
    linkage = assemble(linked(edges, [1, 2, 3], rng))
    space, last = design_space(linkage), linkage.bodies[2]
    for where, length in ((None, space.length), (2.0, space.length), (2.4, 0.4)):
        unit = np.zeros(10) if where is None else sums(np.ones(1), np.array([[where, 0, 7.0]]))
        ball = ball_of(space, replace(last, inertia=unit), 1.5)
        assert ball.radius * space.length == pytest.approx(1.5 * length)
    # Along the normal of a plane nothing counts; in space it does.
    spatial = design_space(linkage, spatial=True)
    ball = ball_of(spatial, replace(last, inertia=unit), 1.5)
    assert ball.radius * space.length == pytest.approx(1.5 * np.hypot(0.4, 7.0))


# --- exactness ------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("seed", range(20))
def test_what_fulfils_both_inequalities_is_point_masses_in_the_ball(seed, d):
    """P ⪰ 0 and tr(G P) ≥ 0: sufficient, also where the second is an equation."""
    rng = np.random.default_rng(seed)
    ball = balls.random_ball(rng, d)
    root = rng.standard_normal((d + 1, int(rng.integers(1, d + 2))))
    P = root @ root.T
    if np.sum(ball.form * P) < 0.0 or seed % 3 == 0:
        # The mass at which the distances are those of the radius, or more.
        e = np.append(ball.centre, 1.0)
        P += (max(0.0, -np.sum(ball.form * P)) / ball.radius**2 + seed % 2) * np.outer(e, e)
    masses, points = balls.point_masses_of(P, ball.form)
    assert np.abs(balls.moments(masses, points) - P).max() < 1e-8 * np.trace(P)
    away = np.linalg.norm(points - ball.centre, axis=1)
    assert (masses > 0.0).all() and away.max() < ball.radius * (1.0 + 1e-6)


@pytest.mark.parametrize("d", [2, 3])
def test_what_is_in_the_ball_fulfils_them(d):
    """Necessary; and the root mean square distance is what `reach_of` says."""
    rng = np.random.default_rng(d)
    for _ in range(30):
        ball = balls.random_ball(rng, d)
        masses, points = balls.cloud(rng, ball, 6)
        P = balls.moments(masses, points)
        assert np.sum(ball.form * P) >= 0.0
        squares = np.sum((points - ball.centre) ** 2, axis=1)
        known = np.sqrt(masses @ squares / masses.sum()) / ball.radius
        assert reach_of(ball, P) == pytest.approx(known, rel=1e-9) and known <= 1.0
    on = ball.centre + 1.01 * ball.radius * np.eye(d)
    assert np.sum(ball.form * balls.moments(np.ones(d), on)) < 0.0


@pytest.mark.table
@pytest.mark.parametrize(
    ("model", "motion", "more"),
    [
        ("four_bar_kite", None, {}),
        ("three_rsr", "u2=u3", {}),
        ("slider_crank", None, {}),
        ("four_bar_general", None, {"balance": "force"}),
        ("hprs", None, {"balance": "force"}),
        ("four_rrr", None, {"balance": "force"}),
        ("bennett", None, {"balance": "force"}),
    ],
)
@pytest.mark.parametrize("objective", [None, "mass", "inertia", "rotor"])
def test_designs_are_point_masses_in_their_balls(model, motion, more, objective):
    space = space_of(model, motion, **more)
    found = design(space, objective)
    if found.verdict == "infeasible":
        assert model == "hprs" and not found.multipliers.any()
        return
    assert found.verdict == "feasible" and found.residuals.reach <= 1.0 + 1e-8
    still = balls.still(space)
    for name, z in zip(space.bodies, found.z, strict=True):
        P, ball = matrix(z), found.balls[name]
        G = np.zeros((4, 4))
        c = still @ ball.centre
        G[:3, :3], G[:3, 3], G[3, :3], G[3, 3] = -still, c, c, ball.radius**2 - c @ c
        masses, points = balls.point_masses_of(P, G)
        assert np.abs(balls.moments(masses, points) - P).max() < 1e-8 * np.trace(P)
        away = np.linalg.norm((points - ball.centre) @ still, axis=1)
        assert away.max() <= ball.radius * (1.0 + 1e-6)
