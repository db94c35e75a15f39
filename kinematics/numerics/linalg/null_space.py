"""Null spaces of small matrices and of triangular factors, as orthonormal rows: kernels."""

from __future__ import annotations

import numpy as np

from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.tolerances import ORTHONORMAL_ROUND_OFF


@kernel(reference_counting=False)
def null_space(A, m, n, tolerance, order, out, gap):
    """Solve ``A x = 0`` for m conditions on n unknowns; orthonormal solutions.

    Complete pivoting, which small matrices can afford: pivots up to ``tolerance`` times the
    largest pivot, or times 1, are round-off.

    Args:
        A: in: the conditions (≥ m, ≥ n); destroyed.
        tolerance: relative size of round-off.
        order: workspace (≥ n,).
        out: out: the solutions as rows (≥ n, ≥ n).
        gap: in, out: smallest size that was kept, and largest that was dropped, so far (2,).

    Returns:
        How many solutions there are.
    """
    for j in range(n):
        order[j] = j
    row = column = rank = 0
    scale, largest = 1.0, -1.0
    for i in range(m):
        for j in range(n):
            if abs(A[i, j]) > largest:
                largest, row, column = abs(A[i, j]), i, j
    # Gauss elimination: A_i -= (A_ik / A_kk) A_k below pivot k, the largest entry left.
    while rank < min(m, n):
        scale = max(scale, largest)
        if largest <= tolerance * scale:
            gap[1] = max(gap[1], largest / scale)
            break
        gap[0] = min(gap[0], largest / scale)
        if row != rank:
            for j in range(rank, n):
                A[rank, j], A[row, j] = A[row, j], A[rank, j]
        if column != rank:
            order[rank], order[column] = order[column], order[rank]
            for i in range(m):
                A[i, rank], A[i, column] = A[i, column], A[i, rank]
        largest = -1.0
        for i in range(rank + 1, m):
            multiplier = A[i, rank] / A[rank, rank]
            for j in range(rank + 1, n):
                A[i, j] -= multiplier * A[rank, j]
                if abs(A[i, j]) > largest:
                    largest, row, column = abs(A[i, j]), i, j
        rank += 1
    # A solution for each free unknown, which is 1: x_k = -(Σ_j A_kj x_j) / A_kk upwards.
    for free in range(rank, n):
        x = out[free - rank]
        for j in range(n):
            x[j] = 0.0
        x[order[free]] = 1.0
        for k in range(rank - 1, -1, -1):
            total = A[k, free]
            for j in range(k + 1, rank):
                total += A[k, j] * x[order[j]]
            x[order[k]] = -total / A[k, k]
    orthonormal(out, n - rank, n)
    return n - rank


def _orthonormal_by_arrays(rows, count, n):
    """Make the first rows orthonormal as `orthonormal` does: off all rows before at once.

    Args:
        rows: in, out: the rows (≥ count, ≥ n).
    """
    for i in range(count):
        x, before = rows[i, :n], np.inf
        size = x @ x
        while size < 0.25 * before:
            before = size
            x -= (rows[:i, :n] @ x) @ rows[:i, :n]
            size = x @ x
        x /= np.sqrt(size)


@kernel(reference_counting=False, uncompiled=_orthonormal_by_arrays)
def orthonormal(rows, count, n):
    """Make the first rows orthonormal: ``x_i -= Σ_{k<i} (x_i · x_k) x_k``, of size 1.

    A row that lost more than half its size to the others is treated twice (J. W. Daniel et
    al., 1976).

    Args:
        rows: in, out: the rows (≥ count, ≥ n).
    """
    # Project row i off every row k before it; repeat while it loses size.
    for i in range(count):
        x = rows[i]
        size = 0.0
        for j in range(n):
            size += x[j] * x[j]
        before = np.inf
        while size < 0.25 * before:
            before = size
            for k in range(i):
                y = rows[k]
                dot = 0.0
                for j in range(n):
                    dot += x[j] * y[j]
                if dot != 0.0:
                    for j in range(n):
                        x[j] -= dot * y[j]
            size = 0.0
            for j in range(n):
                size += x[j] * x[j]
        for j in range(n):
            x[j] /= np.sqrt(size)


def extend(known_rows: Array, without: IntArray, factor: Array, columns: IntArray) -> Array:
    """Extend rows of a factor to all unknowns, so that they vanish on rows that are known.

    ``extended @ known_rows.T = 0``. Columns ``without`` of ``known_rows`` are upper triangular.

    Args:
        known_rows: rows, of all unknowns (s, count).
        without: the unknowns that the factor does not have (s,).
        factor: rows of the factor (rank, p).
        columns: the unknowns that its columns stand for (p,).

    Returns:
        Rows of all unknowns (rank, count).
    """
    rows = np.zeros((len(factor), known_rows.shape[1]))
    rows[:, columns] = factor
    for k in range(len(known_rows) - 1, -1, -1):
        rows[:, without[k]] = -(rows @ known_rows[k]) / known_rows[k, without[k]]
    return rows


def _put_solutions_by_arrays(solutions, factor, permutation, columns, out):
    """Solve as `put_solutions` does: for all free unknowns at once.

    Args:
        solutions: in: as there, as are the next three.
        out: out: as there.
    """
    s, rank = len(solutions), len(factor)
    R = factor[:, permutation]
    out[:s], out[s:] = solutions, 0.0
    x = np.eye(permutation.size)[rank:]
    for k in range(rank - 1, -1, -1):
        x[:, k] = -(x[:, k + 1 :] @ R[k, k + 1 :]) / R[k, k]
    out[s:, columns[permutation]] = x
    _orthonormal_by_arrays(out, *out.shape)
    out[np.abs(out) < ORTHONORMAL_ROUND_OFF] = 0.0


@kernel(reference_counting=False, uncompiled=_put_solutions_by_arrays)
def put_solutions(solutions, factor, permutation, columns, out):
    """Solve ``R x = 0`` for a triangular factor; orthonormal solutions, after those known.

    Args:
        solutions: in: those known, as rows (s, count).
        factor: in: R, its columns in their own order (rank, p).
        permutation: in: the order of elimination (p,).
        columns: in: the unknowns that the columns of R stand for (p,).
        out: out: the solutions as rows (s + p - rank, count); entries of round-off are 0.
    """
    s, count = solutions.shape
    rank, p = factor.shape[0], permutation.size
    for i in range(out.shape[0]):
        for j in range(count):
            out[i, j] = solutions[i, j] if i < s else 0.0
    # x_k = -(Σ_j R_kj x_j) / R_kk upwards, with 1 for one free unknown.
    for free in range(rank, p):
        x = out[s + free - rank]
        x[columns[permutation[free]]] = 1.0
        for k in range(rank - 1, -1, -1):
            total = factor[k, permutation[free]]
            for j in range(k + 1, rank):
                total += factor[k, permutation[j]] * x[columns[permutation[j]]]
            x[columns[permutation[k]]] = -total / factor[k, permutation[k]]
    orthonormal(out, out.shape[0], count)
    for i in range(out.shape[0]):
        for j in range(count):
            if abs(out[i, j]) < ORTHONORMAL_ROUND_OFF:
                out[i, j] = 0.0


def known_and_null_space(
    solutions: Array, factor: Array, permutation: IntArray, columns: IntArray
) -> Array:
    """Append the null space of a factor to solutions that are known; orthonormal rows.

    Args:
        solutions: those known, as rows (s, count).
        factor: R, its columns in their own order (rank, p).
        permutation: the order of elimination (p,).
        columns: the unknowns that the columns of R stand for (p,).

    Returns:
        Solutions as rows (s + p - rank, count), those known first.
    """
    rank, p = factor.shape
    out = np.empty((len(solutions) + p - rank, solutions.shape[1]))
    put_solutions(solutions, factor, permutation, columns, out)
    return out
