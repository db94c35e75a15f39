"""Least counterweights against the force, from twenty random starts of another program.

Each link gets a mass m with the first moment s in a ball of radius R about its frame c:

    least Σ m    with    |s - m c| ≤ R m    and no linear momentum at random poses.

The conditions are those of finite poses; the solver (SLSQP of SciPy) knows nothing of
convexity and starts anywhere.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from balance.masses.remedies.matter_on_links import apply_own_masses
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
