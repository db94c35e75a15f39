"""Convex problems over cones: the one place that calls the solver Clarabel.

    minimise ½ xᵀ H x + q·x    so that    rows x + offset  lies in a product of cones

The solver is an interior-point method (P. J. Goulart, Y. Chen, Clarabel, 2024); what it
returns is never taken at its word, but checked by whoever asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["TRIANGLES", "ConicSolution", "ConstraintBlock", "solve_conic", "triangles"]

Array = NDArray[np.float64]

# Accuracy of a certificate from the solver, before it is polished.
INFEASIBLE = 1e-10


class ConstraintBlock(NamedTuple):
    """A cone that some consecutive rows must lie in.

    Attributes:
        kind: ``"matrix"``: symmetric matrices that are positive semidefinite, as
            `triangles` writes them; ``"lorentz"``: first entry at least the size of the
            others; ``"line"``: entries not negative.
        size: of the matrices, or number of rows.
    """

    kind: Literal["matrix", "lorentz", "line"]
    size: int

    @property
    def rows(self) -> int:
        """How many rows it takes."""
        return self.size * (self.size + 1) // 2 if self.kind == "matrix" else self.size


class ConicSolution(NamedTuple):
    """What the solver found.

    Attributes:
        infeasible: whether it holds that no x fulfils the constraints.
        x: the minimiser (n,), if not.
        dual: multipliers of the rows; a certificate if there is no x.
    """

    infeasible: bool
    x: Array
    dual: Array


class _Columns(NamedTuple):
    """A sparse matrix by columns, with the attributes that the solver reads."""

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
) -> ConicSolution:
    """Solve one problem.

    Args:
        q: linear part of the objective (n,).
        rows: of all cones, one after the other (rows, n).
        offset: what is added to them (rows,).
        parts: the cones.
        H: quadratic part (n, n), symmetric and positive semidefinite; none by default.
        careful: solve to 1e-10 instead of 1e-9, and refine all linear systems; without, an
            answer comes a fifth sooner.
    """
    import clarabel

    kinds = {
        "matrix": clarabel.PSDTriangleConeT,
        "lorentz": clarabel.SecondOrderConeT,
        "line": clarabel.NonnegativeConeT,
    }
    settings, accuracy = clarabel.DefaultSettings(), 1e-10 if careful else 1e-9
    settings.verbose = settings.chordal_decomposition_enable = settings.presolve_enable = False
    settings.iterative_refinement_enable, settings.equilibrate_enable = careful, not careful
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = accuracy
    settings.tol_infeas_abs = settings.tol_infeas_rel = INFEASIBLE
    none = _Columns([], [], [0] * (q.size + 1), 0, (q.size, q.size))
    quadratic = none if H is None else _columns(np.triu(H))
    cones = [kinds[kind](size) for kind, size in parts]
    found: Any = clarabel.DefaultSolver(
        quadratic, q.tolist(), _columns(-rows), offset.tolist(), cones, settings
    ).solve()
    infeasible = "PrimalInfeasible" in str(found.status)
    return ConicSolution(infeasible, np.array(found.x), np.array(found.z))


def triangles(matrices: Array) -> Array:
    """Symmetric matrices (..., k, k) as vectors of the same inner product, k being 3 or 4.

    The upper triangle column by column, with √2 before what is off the diagonal; shape
    (..., k (k + 1) / 2).
    """
    *outer, k, _ = matrices.shape
    return np.asarray(matrices.reshape(*outer, k * k) @ TRIANGLES[k])


def _triangle(k: int) -> Array:
    """Orthonormal columns (k², k (k + 1) / 2) that write symmetric matrices as vectors."""
    columns, rows = np.tril_indices(k)
    count = np.arange(columns.size)
    W = np.zeros((k, k, count.size))
    W[rows, columns, count] = W[columns, rows, count] = np.sqrt(0.5)
    W[range(k), range(k), count[rows == columns]] = 1.0
    return W.reshape(k * k, -1)


TRIANGLES = {k: _triangle(k) for k in (3, 4)}


def _columns(matrix: Array) -> _Columns:
    height, width = matrix.shape
    flat = matrix.T.reshape(-1)
    filled = np.flatnonzero(flat)
    starts = np.searchsorted(filled, np.arange(width + 1) * height)
    data, rows = flat[filled].tolist(), (filled % max(height, 1)).tolist()
    return _Columns(data, rows, starts.tolist(), len(data), (height, width))
