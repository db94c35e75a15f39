"""The nearest design to the masses in the file, by the log-det divergence of pseudo-inertias.

The distance of a body P from the one in the file, P0, is twice the Bregman divergence of the
function ``-log det``, also called Burg's or Stein's,

    d(P) = 2 (tr(P0⁻¹ P) - log det(P0⁻¹ P) - k)        for matrices (k, k).

Another link frame or another unit turns both matrices into ``A P Aᵀ``, which leaves d as it is.
To second order d is the square of the affine-invariant distance ``|log(P0^-½ P P0^-½)|``, which
has the same invariance but is not convex in P. d is convex, grows without bound towards the
boundary of the cone and at infinity, and is 0 for P0 alone. Its minimum over a linear space
with linear inequalities is therefore a global one, and the only one. (T. Lee, P. M. Wensing,
F. C. Park, IEEE Transactions on Robotics 36(2), 2020, identify robots with this divergence; for
its properties: I. S. Dhillon, J. A. Tropp, SIAM Journal on Matrix Analysis and Applications
29(4), 2007.)

The sum of d/2 over the bodies is self-concordant, so damped Newton steps converge from every
interior point. With limits of density, which are convex, each step minimises the same quadratic
model within their cones, measured by the bodies of the last step. With the Newton decrement λ
below 0.68 the sum exceeds its minimum by at most λ² (Y. Nesterov, Lectures on Convex
Optimization, 2018, section 5.2; with constraints: Q. Tran-Dinh, A. Kyrillidis, V. Cevher,
Journal of Machine Learning Research 16, 2015).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from balance.masses.designs.density_cone import (
    DensityRows,
    UnitOfMass,
    density_rows,
    widen,
)
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic, triangles
from balance.support.tolerances import NEWTON_DECREMENT_LEAST, NEWTON_DECREMENT_STALLED
from kinematics.numerics.array_types import Array

# Most Newton steps; each lowers the sum by at least 0.02 until they converge quadratically.
MAX_STEPS = 200
# Newton decrement below which full steps converge.
FULL_STEP = 0.25


def file_distance(P: Array, file: Array) -> float:
    """Compute ``2 Σ_b (tr(P0_b⁻¹ P_b) - log det(P0_b⁻¹ P_b) - k)``.

    Args:
        P: positive definite pseudo-inertias (bodies, k, k).
        file: those of the file, in the same frame and unit.

    Returns:
        The distance, without a unit: 0 for equal matrices, positive for others.
    """
    whiten = np.linalg.inv(np.linalg.cholesky(file))
    values = np.linalg.eigvalsh(whiten @ P @ whiten.swapaxes(-1, -2))
    # x - log(1 + x) without cancellation for values near 1.
    return float(2.0 * np.sum((values - 1.0) - np.log1p(values - 1.0)))


def minimise_distance(
    blocks: Array,
    constant: Array,
    file: Array,
    lines: Array,
    offset: Array,
    start: Array,
    densities: Mapping[int, float] | None = None,
) -> Array | None:
    """Minimise the distance over ``P_b = constant_b + blocks_b · v``, ``lines v + offset ≥ 0``.

    Args:
        blocks: matrices of each coordinate (bodies, n, k, k).
        constant: constant matrices (bodies, k, k).
        file: pseudo-inertias of the file (bodies, k, k), positive definite.
        lines: rows of the inequalities (rows, n).
        offset: their constants (rows,).
        start: coordinates (n,) that fulfil them, with positive definite matrices.
        densities: κ of `balance.masses.designs.density` by position of the body, in the units
            of the matrices, which the bodies at ``start`` fulfil too; none by default.

    Returns:
        The minimiser (n,); None if round-off keeps the Newton steps from converging.
    """
    kappas = densities or {}

    def limits_at(v: Array) -> DensityRows | None:
        P = constant + np.einsum("bnij,n->bij", blocks, v)
        return limit_rows(blocks, P, kappas, P) if kappas else None

    whiten = np.linalg.inv(np.linalg.cholesky(file))
    fixed = whiten @ constant @ whiten.swapaxes(-1, -2)
    whiten = whiten[:, None]
    whitened = whiten @ blocks @ whiten.swapaxes(-1, -2)
    try:
        return _take_newton_steps(whitened, fixed, lines, offset, start, limits_at)
    except np.linalg.LinAlgError:
        return None


def limit_rows(
    blocks: Array,
    references: Array,
    densities: Mapping[int, float],
    constant: Array | None = None,
) -> DensityRows:
    """Build the cones of limits of density for ``P_b = constant_b + blocks_b · v``.

    Args:
        blocks: matrices of each coordinate (bodies, n, k, k).
        references: positive definite matrices that measure the bodies (bodies, k, k).
        densities: κ by position of the body, in the units of the matrices.
        constant: constant matrices (bodies, k, k); none by default.
    """
    limited = sorted(densities)
    return density_rows(
        blocks[limited],
        references[limited],
        UnitOfMass(np.zeros(blocks.shape[1]), 1.0),
        [densities[b] for b in limited],
        None if constant is None else constant[limited],
    )


def _take_newton_steps(
    blocks: Array,
    fixed: Array,
    lines: Array,
    offset: Array,
    start: Array,
    limits_at: Callable[[Array], DensityRows | None],
) -> Array | None:
    """Minimise the distance from the identity; see `minimise_distance`.

    Args:
        limits_at: builds the rows of a step from coordinates v.

    Raises:
        LinAlgError: round-off makes the Hessian singular, or a matrix indefinite.
    """
    v, before = start.copy(), np.inf
    for _ in range(MAX_STEPS):
        L, down = _newton_system(blocks, fixed + np.einsum("bnij,n->bij", blocks, v))
        y = _constrained_step(down, lines, lines @ v + offset, L, limits_at(v))
        decrement = float(np.linalg.norm(y))
        if not np.isfinite(decrement):
            return None
        # Round-off ends the quadratic convergence: a step no longer halves the decrement.
        stalled = before <= NEWTON_DECREMENT_STALLED and decrement > 0.5 * before
        if decrement <= NEWTON_DECREMENT_LEAST or stalled:
            return v
        before = decrement
        length = 1.0 if decrement <= FULL_STEP else 1.0 / (1.0 + decrement)
        v = v + length * np.linalg.solve(L.T, y)
    return None


def _newton_system(blocks: Array, P: Array) -> tuple[Array, Array]:
    """Compute the factor L of the Hessian ``L Lᵀ``, and ``-L⁻¹`` times the gradient.

    With ``P = C Cᵀ`` and ``D_i = C⁻¹ B_i C⁻ᵀ`` the gradient is ``Σ_b tr(B_i) - tr(D_i)`` and
    the Hessian ``Σ_b <D_i, D_j>``.
    """
    C = np.linalg.inv(np.linalg.cholesky(P))[:, None]
    D = C @ blocks @ C.swapaxes(-1, -2)
    rows = triangles(D).transpose(0, 2, 1).reshape(-1, D.shape[1])
    L = np.asarray(np.linalg.qr(rows, mode="r")).T
    return L, -np.linalg.solve(L, np.einsum("bnii->n", blocks - D))


def _constrained_step(
    down: Array, lines: Array, inside: Array, L: Array, limits: DensityRows | None
) -> Array:
    """Minimise ``½ |y|² - down·y`` for a step ``L⁻ᵀ y`` within the constraints: Newton's step.

    Args:
        lines: rows of the inequalities (rows, n).
        inside: their values before the step (rows,).
        limits: rows of the limits of density.
    """
    n = down.size
    lines = np.asarray(np.linalg.solve(L, lines.T)).T
    if limits is None and (not len(lines) or np.all(lines @ down + inside >= 0.0)):
        return down
    size = np.linalg.norm(lines, axis=1)
    size = np.where(size > 0.0, size, 1.0)
    rows, offset = lines / size[:, None], inside / size
    parts = [ConstraintBlock("nonnegative", len(lines))] if len(lines) else []
    q, H = -down, np.eye(n)
    if limits is not None:
        more = limits.rows.copy()
        more[:, :n] = np.linalg.solve(L, more[:, :n].T).T
        width = more.shape[1]
        rows = np.concatenate([widen(rows, width), more])
        offset = np.append(offset, limits.offset)
        parts += limits.parts
        q, H = widen(q, width), np.diag(widen(np.ones(n), width))
    return solve_conic(q, rows, offset, parts, H).x[:n]
