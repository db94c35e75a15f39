"""Conic programs, solved by Clarabel.

    minimise ½ xᵀ H x + q·x    so that    rows x + offset  lies in a product of cones

The solver is an interior-point method (P. J. Goulart, Y. Chen, Clarabel, 2024). Callers check
its answers. No other module calls it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from balance.support.tolerances import (
    SOLVER_INFEASIBILITY,
    SOLVER_RESIDUAL,
    SOLVER_RESIDUAL_FAST,
)
from kinematics.numerics.array_types import Array


class ConstraintBlock(NamedTuple):
    """A cone that some consecutive rows must lie in.

    Attributes:
        kind: ``"psd_triangle"``: positive semidefinite matrices, as vectors of `triangles`;
            ``"second_order"``: first entry at least the norm of the others;
            ``"nonnegative"``: entries not negative; ``"zero"``: entries zero.
        size: size of the matrices, or number of rows.
    """

    kind: Literal["psd_triangle", "second_order", "nonnegative", "zero"]
    size: int

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.size * (self.size + 1) // 2 if self.kind == "psd_triangle" else self.size


class ConicSolution(NamedTuple):
    """Result of the solver.

    Attributes:
        infeasible: whether the solver found that no x fulfils the constraints.
        x: the minimiser (n,), if there is one.
        dual: multipliers of the rows; a certificate if there is no x.
        error: the largest of the relative residuals and of the gap between primal and dual.
    """

    infeasible: bool
    x: Array
    dual: Array
    error: float


class _Columns(NamedTuple):
    """A sparse matrix by columns, with the attributes that Clarabel reads."""

    data: list[float]
    indices: list[int]
    indptr: list[int]
    nnz: int
    shape: tuple[int, int]
    has_canonical_format: bool = True


def solve_conic(
    q: Array,
    rows: Array,
    offset: Array,
    parts: Sequence[ConstraintBlock],
    H: Array | None = None,
    *,
    careful: bool = True,
    equilibrate: bool = False,
) -> ConicSolution:
    """Minimise ``½ xᵀ H x + q·x`` with ``rows x + offset`` in a product of cones.

    Args:
        q: linear part of the objective (n,).
        rows: rows of all cones, one after the other (rows, n).
        offset: constant part of the rows (rows,).
        H: quadratic part (n, n), symmetric and positive semidefinite; none by default.
        careful: solve to 1e-10 instead of 1e-9, and refine all linear systems; the fast
            setting saves a fifth of the time, and scales rows and columns.
        equilibrate: scale rows and columns in any case; by default they are as they are given
            if ``careful``.
    """
    import clarabel

    kinds = {
        "psd_triangle": clarabel.PSDTriangleConeT,
        "second_order": clarabel.SecondOrderConeT,
        "nonnegative": clarabel.NonnegativeConeT,
        "zero": clarabel.ZeroConeT,
    }
    settings = clarabel.DefaultSettings()
    accuracy = SOLVER_RESIDUAL if careful else SOLVER_RESIDUAL_FAST
    settings.verbose = settings.chordal_decomposition_enable = settings.presolve_enable = False
    settings.iterative_refinement_enable = careful
    settings.equilibrate_enable = equilibrate or not careful
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = accuracy
    settings.tol_infeas_abs = settings.tol_infeas_rel = SOLVER_INFEASIBILITY
    zero = _Columns([], [], [0] * (q.size + 1), 0, (q.size, q.size))
    quadratic = zero if H is None else _columns(np.triu(H))
    cones = [kinds[kind](size) for kind, size in parts]
    solution: Any = clarabel.DefaultSolver(
        quadratic, q.tolist(), _columns(-rows), offset.tolist(), cones, settings
    ).solve()
    primal, dual = solution.obj_val, solution.obj_val_dual
    gap = abs(primal - dual) / max(1.0, min(abs(primal), abs(dual)))
    return ConicSolution(
        "PrimalInfeasible" in str(solution.status),
        np.array(solution.x),
        np.array(solution.z),
        max(solution.r_prim, solution.r_dual, gap),
    )


def solve_cones(
    q: Array,
    cones: Sequence[tuple[Array, Array]],
    linear: Sequence[tuple[Array, Array]],
    H: Array | None = None,
) -> Array:
    """Minimise ``½ xᵀ H x + q·x`` within cones of second order and linear constraints, fast.

    Args:
        q: linear part of the objective (n,).
        cones: pairs of rows (m, n) and offsets (m,): the first entry of ``rows x + offset`` is
            at least the norm of the others.
        linear: pairs likewise, of which no entry is negative.
        H: quadratic part (n, n), symmetric and positive semidefinite; none by default.

    Returns:
        The minimiser (n,).
    """
    limits = tuple(np.concatenate(part) for part in zip(*linear, strict=True))
    rows, offsets = zip(*cones, limits, strict=True)
    parts = [ConstraintBlock("second_order", len(offset)) for offset in offsets[:-1]]
    parts.append(ConstraintBlock("nonnegative", len(offsets[-1])))
    stacked = np.concatenate(rows), np.concatenate(offsets)
    return solve_conic(q, *stacked, parts, H, careful=False).x


def triangles(matrices: Array) -> Array:
    """Convert symmetric matrices (..., k, k) to vectors (..., k (k + 1) / 2), k of 3, 4, 6, 8.

    A vector holds the upper triangle column by column, with off-diagonal entries times √2, so
    that inner products are the same.
    """
    *outer, k, _ = matrices.shape
    return np.asarray(matrices.reshape(*outer, k * k) @ TRIANGLES[k])


def _triangle_weights(k: int) -> Array:
    """Compute the weights (k², k (k + 1) / 2) of `triangles`; columns are orthonormal."""
    columns, rows = np.tril_indices(k)
    count = np.arange(columns.size)
    W = np.zeros((k, k, count.size))
    W[rows, columns, count] = W[columns, rows, count] = np.sqrt(0.5)
    W[range(k), range(k), count[rows == columns]] = 1.0
    return W.reshape(k * k, -1)


TRIANGLES = {k: _triangle_weights(k) for k in (3, 4, 6, 8)}


def _columns(matrix: Array) -> _Columns:
    """Convert a dense matrix to sparse columns."""
    height, width = matrix.shape
    flat = matrix.T.reshape(-1)
    filled = np.flatnonzero(flat)
    starts = np.searchsorted(filled, np.arange(width + 1) * height)
    data, rows = flat[filled].tolist(), (filled % max(height, 1)).tolist()
    return _Columns(data, rows, starts.tolist(), len(data), (height, width))


def block_diagonal(blocks: Sequence[Array]) -> Array:
    """Put matrices on the diagonal of a matrix."""
    shapes = np.array([block.shape for block in blocks])
    matrix, at = np.zeros(shapes.sum(axis=0)), np.zeros(2, dtype=int)
    for block in blocks:
        end = at + block.shape
        matrix[at[0] : end[0], at[1] : end[1]] = block
        at = end
    return matrix
