"""Masses that bodies can have, between measured loads and the masses of the file.

Loads leave most parameters open, and noise may give values that no body has. The likeliest
masses minimise

    ½ |R (V' x - v)|² + ρ⁻² Σ_b d(P_b, P0_b)      d = tr(P0⁻¹ P) - log det(P0⁻¹ P) - 4

over all pseudo-inertias ``P_b ≻ 0``: the misfit in standard errors, and the log-det divergence
from the masses of the file (T. Lee, P. M. Wensing, F. C. Park, IEEE Transactions on Robotics
36(2), 2020, equation 20). Near P0 the divergence is ``½ |P0^-½ P P0^-½ - 1|²``, so ρ is the
standard deviation of the masses of the file, relative to them. The function is strictly convex
and grows without bound towards the boundary: Newton's method finds its one minimum. The inverse
of the second derivative there is the covariance of the parameters to first order.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from math import ceil, log
from typing import NamedTuple

import numpy as np

from balance.masses.identification.least_squares import LeastSquares
from balance.space.conditions.rank import singular_value_decomposition
from balance.support.clarabel_adapter import TRIANGLES
from balance.support.tolerances import (
    LIKELIEST_DECREMENT,
    LIKELIEST_ERRORS,
    LIKELIEST_STALLED,
    PRIOR_FLAT,
    PRIOR_WIDENED,
)
from kinematics.model.spatial.inertia import from_pseudo_inertia, pseudo_inertia
from kinematics.numerics.array_types import Array, Flags

# Most Newton steps for one weight, and changes of the length of a step.
MAX_STEPS = 100
MAX_HALVINGS = 60
# Slope at the end of a step over that at its start, both down the function.
FLAT = 0.3
# Factor of the weights from one stage to the next, and the Newton decrement, over the root of
# the weight, at which a stage ends.
WEIGHT_FACTOR = 10.0
NEAR = 0.2
# Orthonormal basis of symmetric matrices (10, 4, 4).
BASIS = TRIANGLES[4].T.reshape(10, 4, 4)


class LikeliestMasses(NamedTuple):
    """Masses of all bodies, and how sure they are.

    Attributes:
        x: parameters in the units of the chain (bodies · 10,).
        root: matrix S of the covariance ``S S'`` of x (bodies · 10, bodies · 10).
        followed: whether the loads count with their own standard errors; else they ask for
            masses so far from those of the file that round-off allows larger ones only.
    """

    x: Array
    root: Array
    followed: bool = True

    def spread(self, rows: Array) -> Array:
        """Compute standard errors (k,) of combinations of x, given as rows (k, parameters)."""
        return np.asarray(np.linalg.norm(rows @ self.root, axis=1))


def widened_pseudo_inertias(x: Array) -> tuple[Array, Flags]:
    """Return positive definite pseudo-inertias near those of the masses of a file.

    Args:
        x: parameters in the units of the chain (bodies, 10).

    Returns:
        Matrices (bodies, 4, 4), and which bodies were widened, since they are flat, thin or
        such as no body is.
    """
    P = pseudo_inertia(x)
    values, vectors = np.linalg.eigh(P)
    trace = np.abs(values).sum(axis=1)
    flat = values[:, 0] < PRIOR_FLAT * trace
    least = np.where(flat, PRIOR_WIDENED * trace, 0.0)
    raised = np.maximum(values, least[:, None])
    wide = np.einsum("bik,bk,bjk->bij", vectors, raised, vectors)
    return np.where(flat[:, None, None], wide, P), flat


def likeliest_masses(fit: LeastSquares, prior: Array, share: float) -> LikeliestMasses | None:
    """Find the likeliest masses; None if round-off keeps Newton's method from converging.

    Args:
        fit: what the loads determine.
        prior: positive definite pseudo-inertias of the file (bodies, 4, 4), units of the chain.
        share: ρ, standard deviation of the masses of the file relative to them.
    """
    C = np.linalg.cholesky(prior)[:, None]
    steps = from_pseudo_inertia(C @ BASIS @ C.swapaxes(-1, -2))
    bodies = len(prior)
    single = np.zeros((bodies, 10, bodies, 10))
    single[range(bodies), :, range(bodies)] = steps.swapaxes(1, 2)
    S = single.reshape(10 * bodies, 10 * bodies)
    x0 = from_pseudo_inertia(prior).reshape(-1)
    # Exact loads leave standard errors of round-off: in units of the file they are raised.
    U, size, Vt = singular_value_decomposition(fit.factor @ (fit.directions.T @ S))
    misfit = U.T @ (fit.factor @ (fit.estimate - fit.directions.T @ x0))
    for error in LIKELIEST_ERRORS:
        capped = np.minimum(size, 1.0 / error)
        J, target = capped[:, None] * Vt, (capped / size) * misfit
        with suppress(np.linalg.LinAlgError):
            minimum = _follow(J, target, bodies, 1.0 / share**2)
            if minimum is not None:
                t, L = minimum
                followed = error == LIKELIEST_ERRORS[0]
                return LikeliestMasses(x0 + S @ t, S @ np.linalg.inv(L), followed)
    return None


def _follow(J: Array, target: Array, bodies: int, weight: float) -> tuple[Array, Array] | None:
    """Minimise ``½ |J t - target|² + weight Σ tr T_b - log det(1 + T_b)``, ``T_b = Σ t_i B_i``.

    Weights descend to the one that is meant, so that Newton's method never starts far from its
    minimum (S. Boyd, L. Vandenberghe, Convex Optimization, 2004, section 11.3).

    Returns:
        t, and the triangular factor L with the second derivative ``L' L``; None if round-off
        keeps Newton's method from converging.

    Raises:
        LinAlgError: round-off makes a matrix indefinite.
    """
    first = max(weight, float(target @ target))
    stages = ceil(log(first / weight, WEIGHT_FACTOR)) if first > weight else 0
    t = np.zeros(J.shape[1])
    minimum = None
    for stage in range(stages, -1, -1):
        now = weight * WEIGHT_FACTOR**stage
        enough = LIKELIEST_DECREMENT if stage == 0 else NEAR * np.sqrt(now)
        minimum = _newton(J, target, bodies, now, t, enough)
        if minimum is None:
            return None
        t = minimum[0]
    return minimum


def _matrices(t: Array, bodies: int) -> Array:
    """Compute ``1 + T_b`` (bodies, 4, 4)."""
    return np.asarray(np.eye(4) + np.einsum("bi,iac->bac", t.reshape(bodies, 10), BASIS))


def _newton(
    J: Array, target: Array, bodies: int, weight: float, start: Array, enough: float
) -> tuple[Array, Array] | None:
    """Take Newton steps from a start until their decrement is small; see `_follow`."""
    t, before = start, np.inf
    for _ in range(MAX_STEPS):
        gradient, D = _slopes(J, target, bodies, weight, t)
        rows = np.zeros((bodies, 16, bodies, 10))
        flat = np.sqrt(weight) * D.reshape(bodies, 10, 16)
        rows[range(bodies), :, range(bodies)] = flat.swapaxes(1, 2)
        stacked = np.concatenate([rows.reshape(16 * bodies, 10 * bodies), J])
        L = np.asarray(np.linalg.qr(stacked, mode="r"))
        down = -np.linalg.solve(L.T, gradient)
        decrement = float(np.linalg.norm(down))
        if not np.isfinite(decrement):
            return None
        # Round-off ends the quadratic convergence: a step no longer halves the decrement.
        stalled = before <= LIKELIEST_STALLED and decrement > 0.5 * before
        if decrement <= enough or stalled:
            return t, L
        before = decrement
        step = np.linalg.solve(L, down)

        def slope(length: float, t: Array = t, step: Array = step) -> float:
            """Slope along the step; infinite where a matrix is not positive definite."""
            try:
                return float(_slopes(J, target, bodies, weight, t + length * step)[0] @ step)
            except np.linalg.LinAlgError:
                return np.inf

        t = t + _length(slope, decrement**2) * step
    return None


def _slopes(
    J: Array, target: Array, bodies: int, weight: float, t: Array
) -> tuple[Array, Array]:
    """Compute the gradient, and the matrices ``C⁻¹ B_i C⁻ᵀ`` (bodies, 10, 4, 4).

    Raises:
        LinAlgError: a matrix ``1 + T_b = C Cᵀ`` is not positive definite.
    """
    inverse = np.linalg.inv(np.linalg.cholesky(_matrices(t, bodies)))[:, None]
    D = inverse @ BASIS @ inverse.swapaxes(-1, -2)
    traces = np.einsum("iaa->i", BASIS) - np.einsum("biaa->bi", D)
    return J.T @ (J @ t - target) + weight * traces.reshape(-1), D


def _length(slope: Callable[[float], float], steepest: float) -> float:
    """Find the length of a step along which a convex function descends to near its minimum.

    Slopes decide, not values: where these are large, their differences are round-off.

    Args:
        slope: that of the function at a length of the step.
        steepest: minus the slope at its start.
    """
    low, high = 0.0, 1.0
    for _ in range(MAX_HALVINGS):
        now = slope(high)
        if now >= -FLAT * steepest:
            break
        low, high = high, 2.0 * high
    if now <= FLAT * steepest:
        return high
    for _ in range(MAX_HALVINGS):
        middle = 0.5 * (low + high)
        now = slope(middle)
        if abs(now) <= FLAT * steepest:
            return middle
        low, high = (middle, high) if now < 0.0 else (low, middle)
    return low
