"""Masses that bodies can have, between measured loads and the masses of the file.

Loads leave most parameters open, and noise may give values that no body has. The likeliest
masses minimise

    ½ |R (V' x - v)|² + ρ⁻² Σ_b d(P_b, P0_b)      d = tr(P0⁻¹ P) - log det(P0⁻¹ P) - 4

over all pseudo-inertias ``P_b ≻ 0``: the misfit in standard errors, and the log-det divergence
from the masses of the file (T. Lee, P. M. Wensing, F. C. Park, IEEE Transactions on Robotics
36(2), 2020, equation 20). Near P0 the divergence is ``½ |P0^-½ P P0^-½ - 1|²``, so ρ is the
standard deviation of the masses of the file, relative to them. The function is strictly convex
and grows without bound towards the boundary, so that Newton's method with a line search finds
its one minimum (S. Boyd, L. Vandenberghe, Convex Optimization, 2004, section 9.5). The inverse
of the second derivative there is the covariance of the parameters to first order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.identification.least_squares import LeastSquares
from balance.support.clarabel_adapter import TRIANGLES
from balance.support.tolerances import LIKELIEST_DECREMENT, PRIOR_FLAT, PRIOR_WIDENED
from kinematics.model.spatial.inertia import from_pseudo_inertia, pseudo_inertia
from kinematics.numerics.array_types import Array, Flags

# Most Newton steps, and halvings of a step.
MAX_STEPS = 300
MAX_HALVINGS = 60
# Part of the decrease to first order that a step has to reach.
SUFFICIENT = 1e-4
# Orthonormal basis of symmetric matrices (10, 4, 4).
BASIS = TRIANGLES[4].T.reshape(10, 4, 4)


class LikeliestMasses(NamedTuple):
    """Masses of all bodies, and how sure they are.

    Attributes:
        x: parameters in the units of the chain (bodies · 10,).
        root: matrix S of the covariance ``S S'`` of x (bodies · 10, bodies · 10).
    """

    x: Array
    root: Array

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
    J = fit.factor @ (fit.directions.T @ S)
    target = fit.factor @ (fit.estimate - fit.directions.T @ x0)
    try:
        found = _newton(J, target, bodies, 1.0 / share**2)
    except np.linalg.LinAlgError:
        return None
    if found is None:
        return None
    t, L = found
    return LikeliestMasses(x0 + S @ t, S @ np.linalg.inv(L))


def _newton(J: Array, target: Array, bodies: int, weight: float) -> tuple[Array, Array] | None:
    """Minimise ``½ |J t - target|² + weight Σ tr T_b - log det(1 + T_b)``, ``T_b = Σ t_i B_i``.

    Returns:
        t, and the triangular factor L with the second derivative ``L' L``.

    Raises:
        LinAlgError: round-off makes a matrix indefinite.
    """
    traces = np.einsum("iaa->i", BASIS)

    def matrices(t: Array) -> Array:
        return np.eye(4) + np.einsum("bi,iac->bac", t.reshape(bodies, 10), BASIS)

    def value(t: Array) -> float:
        values = np.linalg.eigvalsh(matrices(t)) - 1.0
        if values.min() <= -1.0:
            return np.inf
        misfit = J @ t - target
        # x - log(1 + x) without cancellation for values near 1.
        return float(0.5 * misfit @ misfit + weight * np.sum(values - np.log1p(values)))

    t, now = np.zeros(J.shape[1]), value(np.zeros(J.shape[1]))
    for _ in range(MAX_STEPS):
        inverse = np.linalg.inv(np.linalg.cholesky(matrices(t)))[:, None]
        D = inverse @ BASIS @ inverse.swapaxes(-1, -2)
        gradient = J.T @ (J @ t - target) + weight * (
            traces - np.einsum("biaa->bi", D)
        ).reshape(-1)
        flat = D.reshape(bodies, 10, 16)
        rows = np.zeros((bodies, 16, bodies, 10))
        rows[range(bodies), :, range(bodies)] = np.sqrt(weight) * flat.swapaxes(1, 2)
        stacked = np.concatenate([rows.reshape(16 * bodies, 10 * bodies), J])
        L = np.asarray(np.linalg.qr(stacked, mode="r"))
        down = -np.linalg.solve(L.T, gradient)
        decrement = float(np.linalg.norm(down))
        if not np.isfinite(decrement):
            return None
        if decrement <= LIKELIEST_DECREMENT:
            return t, L
        step, length = np.linalg.solve(L, down), 1.0
        for _ in range(MAX_HALVINGS):
            after = value(t + length * step)
            if after <= now - SUFFICIENT * length * decrement**2:
                break
            length *= 0.5
        else:
            # Round-off ends the descent.
            return (t, L) if decrement <= np.sqrt(LIKELIEST_DECREMENT) else None
        t, now = t + length * step, after
    return None
