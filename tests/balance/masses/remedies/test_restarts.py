"""Least matter from twenty random starts of another program, which knows no convexity.

Against the force, each link gets a mass m with the first moment s in a ball of radius R about
its frame c:

    least Σ m    with    |s - m c| ≤ R m    and no linear momentum at random poses.

The conditions are those of finite poses; the solver (SLSQP of SciPy) starts anywhere. Turning
counterweights have places and radii of gyration as unknowns, in which nothing is convex.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from balance.masses.remedies.counter_rotations.counter_rotary_masses import (
    apply_counter_rotary_masses,
)
from balance.masses.remedies.matter_on_links import apply_own_masses, apply_partial
from balance.masses.remedies.request import RemedyRequest
from balance.motion.verification.trajectory import random_motions
from tests.support.remedy_files import momentum, placed
from tests.support.remedy_requests import request_of_model

STARTS = 20
# Radii of the balls of all links, metres.
RADII = {"four_bar_general": 0.3, "two rods": 0.5}


def conditions(linkage):
    """Rows on ``[m, s_x, s_y]`` in the plane of all links, the right sides, frame origins."""
    plane = linkage.chain.frame.R
    centres = [plane @ linkage.places[body.name].pose[:3, 3] for body in linkage.bodies]
    (motion,) = random_motions(linkage, 1, 12, seed=5)
    rows, sides = [], []
    for q, qd in zip(motion.q, motion.qd, strict=True):
        poses, twists = placed(linkage, q, qd)
        blocks = []
        for body, centre in zip(linkage.bodies, centres, strict=True):
            (R, d), (w, v) = (
                (poses[body.link][:3, :3], poses[body.link][:3, 3]),
                np.split(twists[body.link], 2),
            )
            turn = np.cross(w, (R @ plane.T).T).T
            at_height = v + np.cross(w, d) + turn[:, 2] * centre[2]
            blocks.append(plane[:2] @ np.column_stack([at_height, turn[:, :2]]))
        rows.append(np.hstack(blocks))
        sides.append(-plane[:2] @ momentum(linkage, q, qd).sum(axis=0)[3:])
    A, b = np.vstack(rows), np.concatenate(sides)
    U, sizes, V = np.linalg.svd(A)
    rank = int((sizes > 1e-9 * sizes[0]).sum())
    return V[:rank], (U.T @ b)[:rank] / sizes[:rank], np.array(centres)[:, :2]


@pytest.mark.slow
@pytest.mark.parametrize("model", RADII)
def test_twenty_random_starts_agree(model):
    linkage, R = request_of_model(model).linkage, RADII[model]
    regions = {body.name: f"ball(0,0,0,{R})" for body in linkage.bodies}
    (applied,) = apply_own_masses(RemedyRequest(linkage, balance="force", regions=regions))
    assert applied.verdict == "feasible"
    rows, sides, centres = conditions(linkage)
    count = len(centres)
    # Unknowns m and t with s = m c + R t, so that all are masses.
    change = np.zeros((count, 3, count, 3))
    for k, c in enumerate(centres):
        change[k, :, k] = [[1.0, 0.0, 0.0], [c[0], R, 0.0], [c[1], 0.0, R]]
    rows = rows @ change.reshape(3 * count, 3 * count)

    # All that fulfils the conditions: a point, and directions.
    point = np.linalg.lstsq(rows, sides, rcond=None)[0]
    free = np.linalg.svd(rows)[2][len(rows) :].T

    def spare(y):
        """What is left of the reach of each link, in masses."""
        m, *t = (point + free @ y).reshape(count, 3).T
        return m - np.sqrt(t[0] ** 2 + t[1] ** 2 + 1e-12)

    rng, masses = np.random.default_rng(1), []
    for _ in range(STARTS):
        solved = minimize(
            lambda y: (point + free @ y)[::3].sum(),
            rng.uniform(-8.0, 8.0, free.shape[1]),
            method="SLSQP",
            constraints=[{"type": "ineq", "fun": spare}],
            options={"maxiter": 500, "ftol": 1e-9},
        )
        assert spare(solved.x).min() > -1e-5, solved.message
        masses.append(solved.fun)
    np.testing.assert_allclose(masses, applied.added_mass, rtol=0.01)


def planar_conditions(linkage, turning, gear):
    """Rows on ``[m, s_x, s_y, I]`` of each link, of each turning part, and on its J.

    A link with these parameters, about the point at the origin at the reference pose, has the
    momentum and the moment about the normal

        p = m v + ω × R s,    h = m d × v + d × (ω × R s) + R s × v + I ω,

    with v and ω of that point d; a part that turns -(N + 1) times has -(N + 1) J q̇ besides.

    Args:
        turning: names of the joints against which parts turn.
    """
    plane, normal = np.split(linkage.chain.frame.R, [2])
    links = [body.link for body in linkage.bodies]
    joints = linkage.positions_of(turning).tolist()
    (motion,) = random_motions(linkage, 1, 12, seed=5)
    rows, sides = [], []
    for q, qd in zip(motion.q, motion.qd, strict=True):
        poses, twists = placed(linkage, q, qd)
        columns = {}
        for link in links:
            R, d = poses[link][:3, :3], poses[link][:3, 3]
            w, v = twists[link][:3], twists[link][3:] + np.cross(twists[link][:3], d)
            across = R @ plane.T
            turned = np.cross(w, across.T).T
            moment = [
                normal @ np.cross(d, v),
                normal @ (np.cross(d, turned.T).T + np.cross(across.T, v).T),
                normal @ w,
            ]
            columns[link] = np.vstack(
                [
                    np.column_stack([plane @ v, plane @ turned, np.zeros(2)]),
                    np.concatenate([np.ravel(part) for part in moment]),
                ]
            )
        spins = np.zeros((3, len(joints)))
        spins[2] = -(gear + 1.0) * qd[joints]
        rows.append(np.hstack([*(columns[link] for link in [*links, *joints]), spins]))
        total = momentum(linkage, q, qd).sum(axis=0)
        sides.append(-np.concatenate([plane @ total[3:], normal @ total[:3]]))
    A, b = np.vstack(rows), np.concatenate(sides)
    U, sizes, V = np.linalg.svd(A, full_matrices=False)
    rank = int((sizes > 1e-9 * sizes[0]).sum())
    return V[:rank], (U.T @ b)[:rank] / sizes[:rank]


@pytest.mark.slow
@pytest.mark.parametrize("gear", [1.0, 4.0])
def test_turning_counterweights_of_random_starts_agree(gear):
    """Places, masses and gyrations of five parts: none ends lower, and the best end here."""
    linkage, R, rho = request_of_model("four_bar_general").linkage, 0.3, 0.2
    regions = {body.name: f"ball(0,0,0,{R})" for body in linkage.bodies}
    request = RemedyRequest(linkage, regions=regions, gear=gear, radius=rho)
    applied = next(apply_counter_rotary_masses(request))
    assert applied.verdict == "feasible", applied
    turning = [name.removesuffix("_rotor_joint") for name in applied.new_joints]
    rows, sides = planar_conditions(linkage, turning, gear)
    plane, count = linkage.chain.frame.R[:2], len(linkage.bodies)
    centres = {
        body.link: plane @ linkage.places[body.name].pose[:3, 3] for body in linkage.bodies
    }
    on = [*centres, *linkage.positions_of(turning).tolist()]
    middle = np.array([centres[link] for link in on])

    def parts(y):
        """Masses, places from the middle over R, and squares of gyrations over their most."""
        m, *u, k = y.reshape(len(on), 4).T
        return m, np.array(u).T, k

    def missed(y):
        m, u, k = parts(y)
        most = np.where(np.arange(len(on)) < count, R, rho)
        J = m * k * most**2
        p = middle + R * u
        z = np.column_stack([m, m[:, None] * p, m * (p**2).sum(axis=1) + J])
        return rows @ np.concatenate([z.ravel(), J[count:]]) - sides

    def spare(y):
        """A part of a link lies in its ball with its gyration, a turning one with its place."""
        _, u, k = parts(y)
        reach = 1.0 - (u**2).sum(axis=1)
        return np.where(np.arange(len(on)) < count, reach - k, reach)

    rng, masses = np.random.default_rng(2), []
    bounds = [(0.0, None), (-1.0, 1.0), (-1.0, 1.0), (0.0, 1.0)] * len(on)
    for _ in range(STARTS):
        start = np.column_stack(
            [
                rng.uniform(0.0, 20.0, len(on)),
                rng.uniform(-0.7, 0.7, (len(on), 2)),
                rng.uniform(0.0, 1.0, len(on)),
            ]
        )
        solved = minimize(
            lambda y: parts(y)[0].sum(),
            start.ravel(),
            method="SLSQP",
            bounds=bounds,
            constraints=[{"type": "eq", "fun": missed}, {"type": "ineq", "fun": spare}],
            options={"maxiter": 300, "ftol": 1e-7},
        )
        if np.abs(missed(solved.x)).max() < 1e-6 and spare(solved.x).min() > -1e-6:
            masses.append(solved.fun)
    # Equations that are not convex stop some starts, and local minima hold others.
    near = np.abs(np.array(masses) / applied.added_mass - 1.0) < 0.05
    assert near.sum() >= 2
    assert min(masses) > applied.added_mass * 0.999


@pytest.mark.slow
def test_larger_regions_do_better_where_matter_is_at_the_rim():
    """What is said of the rim is so, and matter within a budget says it too."""
    linkage = request_of_model("four_bar_general").linkage
    apply = {"force": apply_own_masses, "dynamic": apply_partial}
    for aim, remedy in apply.items():
        results = []
        for R in (0.1, 0.15):
            regions = {body.name: f"ball(0,0,0,{R})" for body in linkage.bodies}
            request = RemedyRequest(linkage, balance=aim, regions=regions, budget=2.0)
            results += remedy(request)
        small, large = results
        assert "at the rim of the regions of" in small.reason
        if aim == "force":
            assert large.added_mass < small.added_mass
        else:
            assert large.residual < small.residual
