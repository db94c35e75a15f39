"""Bounds on principal moments: by random orientations, and the bodies at the bounds.

[J] J. J. de Jong, PhD thesis, University of Twente, Eqs. 3.29 to 3.35 and 3.41 to 3.47.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from balance.motion.pose.principal_moments import (
    critical_moment,
    inertia_from_moments,
    momentum_margins,
)
from kinematics.errors import UsageError
from tests.support.laws import relative


def body(rng, equal=None):
    """Principal moments of a body that can exist, sorted, some of them equal."""
    second = np.sort(rng.uniform(0.1, 1.0, 3))
    if equal is not None:
        second[equal] = second[equal + 1]
    return second.sum() - second


@pytest.mark.parametrize("equal", [None, 0, 1])
def test_momenta_of_all_orientations_are_inside_and_come_back(equal):
    rng = np.random.default_rng(3)
    for _ in range(100):
        g, R = body(rng, equal), Rotation.random(random_state=rng).as_matrix()
        w = rng.standard_normal(3)
        xi = R.T @ np.diag(g) @ R @ w
        assert momentum_margins(rng.permutation(g), w, xi).min() > -1e-12
        assert w @ xi > 0.0  # Eq. 3.35
        G = inertia_from_moments(g, w, xi)
        assert relative(G @ w, xi) < 1e-8
        assert relative(np.linalg.eigvalsh(G), g[::-1]) < 1e-8


def test_along_the_angular_velocity_one_moment_is_fixed():
    """[J] special case 2, and Eq. 3.47 for three equal moments."""
    for g in ([3.0, 2.0, 1.5], [2.0, 2.0, 2.0]):
        w = np.array([0.3, -0.2, 0.9])
        G = inertia_from_moments(g, w, 2.0 * w)
        assert relative(G @ w, 2.0 * w) < 1e-12
        assert relative(np.linalg.eigvalsh(G), np.sort(g)) < 1e-12


def test_what_is_outside_the_bounds_has_no_orientation():
    """Points of the ball without its cavities are those that some orientation reaches."""
    rng = np.random.default_rng(4)
    inside = 0
    for _ in range(300):
        g, w = body(rng), np.array([0.0, 0.0, 1.0])
        xi = np.array([rng.uniform(-0.5, 0.5), 0.0, rng.uniform(g[2], g[0])])
        # (ω_i²) of the principal axes, by Cramer's rule; all must be positive.
        V, right = np.vander(g, 3, increasing=True).T, [1.0, w @ xi, xi @ xi]
        squares = [
            np.linalg.det(np.where(np.arange(3) == k, np.array(right)[:, None], V))
            for k in range(3)
        ] / np.linalg.det(V)
        reachable = squares.min() > 0.0
        margin = momentum_margins(g, w, xi)[:3].min()
        assert (margin > 0.0) == reachable
        inside += reachable
        if margin < -1e-3:
            with pytest.raises(UsageError, match="no orientation"):
                inertia_from_moments(g, w, xi)
    assert 30 < inside < 250


def test_critical_moments_lie_on_the_bounds_and_the_first_bounds_from_either_side():
    """[J] Eq. 3.32 prints g1 ≤ g1,crit; that holds for ω·ξ > g2 |ω|² alone."""
    rng = np.random.default_rng(5)
    sides = set()
    for _ in range(200):
        g, R = body(rng), Rotation.random(random_state=rng).as_matrix()
        w = rng.standard_normal(3)
        xi = R.T @ np.diag(g) @ R @ w
        first, second, third = (critical_moment(g[k], w, xi) for k in (1, 2, 0))
        assert g[1] <= second * (1 + 1e-12) and g[2] <= third * (1 + 1e-12)
        above = w @ xi > g[1] * (w @ w)
        assert (g[0] <= first) == above
        sides.add(bool(above))
        for pair in ((first, g[1]), (second, g[2]), (third, g[0])):
            a, b = pair
            assert abs((xi - a * w) @ (xi - b * w)) < 1e-9 * (1 + abs(a)) ** 2 * (w @ w) * 10
    assert sides == {True, False}
