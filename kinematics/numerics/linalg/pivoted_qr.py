"""Rank-revealing QR by Householder reflections with column pivoting: compiled kernels.

The largest column comes first; elimination stops where the remainder is round-off (in the
spirit of T. F. Chan, 1987). The caller gives the relative tolerance of round-off.

Reflections act on rows in place, a vector of columns at a time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import VECTOR_WIDTH, broadcast, load_vector, store_vector
from kinematics.numerics.tolerances import (
    ELIMINATION_ROUND_OFF,
    RANK_RELATIVE,
    RANK_RELATIVE_PER_LENGTH,
)


class Factor(NamedTuple):
    """A triangular factor in a workspace, as kernels pass it to each other.

    Kernels make it of their arguments at no cost; from Python it would take 2 to 3 µs to pass.

    Attributes:
        F: workspace as from `factor_workspace`: rows of the factor, rows to append, columns
            in the order of elimination (≥ rank + m + 1, P), P a multiple of the vector width.
        permutation: that order, as numbers of the entries of ``columns`` (p,).
        columns: the parameters that the columns stand for (p,).
        tolerance: relative size of round-off.
    """

    F: Array
    permutation: IntArray
    columns: IntArray
    tolerance: float


@kernel(reference_counting=False)
def round_off(origin, length):
    """Compute the relative size of round-off in a frame with this origin and length.

    Coordinates of a linkage far from the origin of its file are rounded accordingly.

    Args:
        origin: of the frame (3,), metres.
        length: characteristic length, metres.
    """
    square = 0.0
    for i in range(3):
        square += (origin[i] / length) ** 2
    return max(RANK_RELATIVE, RANK_RELATIVE_PER_LENGTH * np.sqrt(square))


def factor_workspace(p: int, m: int) -> Array:
    """Make the workspace of a factor of p unknowns and m rows to append.

    Args:
        m: number of rows.

    Returns:
        Uninitialised array (p + m + 1, P), P a multiple of the vector width; its last row is
        scratch.
    """
    return np.empty((p + m + 1, -(-p // VECTOR_WIDTH) * VECTOR_WIDTH))


def _take_factor_by_arrays(R, permutation, F):
    """Copy a factor as `take_factor` does: all rows at once."""
    F[: len(R), : permutation.size] = R[:, permutation]
    F[: len(R), permutation.size :] = 0.0


@kernel(reference_counting=False, uncompiled=_take_factor_by_arrays)
def take_factor(R, permutation, F):
    """Copy a factor into a workspace: ``F[i, j] = R[i, permutation[j]]``.

    Args:
        R: in: the factor, its columns in their own order (rank, p).
        permutation: in: the order of elimination (p,).
        F: out: its first rows (≥ rank, P); columns from p on are zero.
    """
    for i in range(R.shape[0]):
        for j in range(permutation.size):
            F[i, j] = R[i, permutation[j]]
        for j in range(permutation.size, F.shape[1]):
            F[i, j] = 0.0


def _put_factor_by_arrays(F, permutation, rank, R):
    """Copy a factor as `put_factor` does: all rows at once."""
    R[:rank, permutation] = F[:rank, : permutation.size]


@kernel(reference_counting=False, uncompiled=_put_factor_by_arrays)
def put_factor(F, permutation, rank, R):
    """Copy a factor out of a workspace: ``R[i, permutation[j]] = F[i, j]``.

    Args:
        F: in: the workspace (≥ rank, P).
        permutation: in: the order of elimination (p,).
        rank: rows of the factor.
        R: out: its first rows, columns in their own order (≥ rank, p).
    """
    for i in range(rank):
        for j in range(permutation.size):
            R[i, permutation[j]] = F[i, j]


def _append_rows_by_arrays(factor, rank, rows, weight):
    """Append rows as `append_rows` does: all at once."""
    F, permutation, columns, _ = factor
    below = F[rank : rank + len(rows)]
    below[:, : columns.size] = weight * rows[:, columns[permutation]]
    below[:, columns.size :] = 0.0


@kernel(reference_counting=False, uncompiled=_append_rows_by_arrays)
def append_rows(factor, rank, rows, weight):
    """Append rows below a factor: ``F[rank + i, j] = weight rows[i, columns[permutation[j]]]``.

    Args:
        factor: in, out: a `Factor`.
        rank: its rows.
        rows: in: the rows (m, parameters).
        weight: a factor of all of them.
    """
    F, permutation, columns, _ = factor
    for i in range(rows.shape[0]):
        for j in range(columns.size):
            F[rank + i, j] = weight * rows[i, columns[permutation[j]]]
        for j in range(columns.size, F.shape[1]):
            F[rank + i, j] = 0.0


def _update_factor_by_arrays(factor, rank, m, scale):
    """Update a factor as `update_factor` does: LAPACK takes the columns eliminated before."""
    F, permutation, _, tolerance = factor
    p = permutation.size
    R = np.linalg.qr(F[: rank + m, :p], mode="r")
    end = len(R)
    F[:end, :p], F[end : rank + m] = R, 0.0
    scale = max(scale, np.abs(R.diagonal()[:rank]).max(initial=0.0))
    norms = np.einsum("ij,ij->j", R[rank:, rank:], R[rank:, rank:])
    while rank < end:
        pivot = int(norms.argmax())
        size = np.sqrt(norms[pivot])
        scale = max(scale, size)
        if size <= tolerance * scale:
            break
        swapped = [rank, rank + pivot]
        permutation[swapped] = permutation[swapped[::-1]]
        F[:end, swapped] = F[:end, swapped[::-1]]
        rest = F[rank:end, rank:p]
        v = rest[:, 0].copy()
        diagonal = -size if v[0] > 0.0 else size
        v[0] -= diagonal
        rest += v[:, None] * (v @ rest / (diagonal * v[0]))
        rest[:, 0], rest[0, 0] = 0.0, diagonal
        norms = np.einsum("ij,ij->j", rest[1:, 1:], rest[1:, 1:])
        rank += 1
    return rank, scale, np.sqrt(norms.sum())


@kernel(reference_counting=False, uncompiled=_update_factor_by_arrays)
def update_factor(factor, rank, m, scale):
    """Update a factor R with the m rows A below it: ``Qᵀ [R; A] = [R'; 0]``.

    The columns that the factor has eliminated stay its first; the others follow, largest
    remainder first, until no remainder exceeds ``tolerance * scale``.

    Args:
        factor: in, out: a `Factor`, the new rows below its own; the permutation too changes.
        rank: its rows.
        m: rows to absorb.
        scale: largest pivot so far.

    Returns:
        The rank, the largest pivot, and the norm of the remainder.
    """
    F, permutation, _, tolerance = factor
    p, P, end = permutation.size, F.shape[1], rank + m
    f = F.reshape(F.size)
    norms = f[f.size - P :]
    # Columns eliminated before: reflect row k and the new rows, |(R_kk, A_k)| on the diagonal.
    for k in range(rank):
        total = 0.0
        for i in range(rank, end):
            total += F[i, k] * F[i, k]
        if total > 0.0:
            size = np.sqrt(F[k, k] * F[k, k] + total)
            scale = max(scale, size)
            apply_reflector_sparse(f, P, k, rank, end, -size if F[k, k] > 0.0 else size)
    # Remainders of the other columns: norms_j = Σ_i A_ij².
    for c in range(rank // VECTOR_WIDTH * VECTOR_WIDTH, P, VECTOR_WIDTH):
        squares = broadcast(0.0)
        for i in range(rank, end):
            x = load_vector(f, i * P + c)
            squares = squares + x * x
        store_vector(norms, c, squares)
    # The column of the largest remainder next: swap it to the front, reflect the rows left.
    while True:
        remainder = 0.0
        pivot = rank
        for j in range(rank, p):
            remainder += norms[j]
            if norms[j] > norms[pivot]:
                pivot = j
        if rank == min(end, p):
            break
        size = np.sqrt(norms[pivot])
        scale = max(scale, size)
        if size <= tolerance * scale:
            break
        if pivot != rank:
            permutation[rank], permutation[pivot] = permutation[pivot], permutation[rank]
            for i in range(end):
                F[i, rank], F[i, pivot] = F[i, pivot], F[i, rank]
        apply_reflector(f, P, rank, end, -size if F[rank, rank] > 0.0 else size, norms)
        rank += 1
    return rank, scale, np.sqrt(remainder)


def _contains_rows_by_arrays(factor, rank, rows, weight, scale):
    """Decide as `contains_rows` does: by operations on whole rows."""
    F, permutation, columns, tolerance = factor
    p = permutation.size
    x = weight * np.cos((np.arange(len(rows)) + 1.0) ** 2) @ rows[:, columns[permutation]]
    size, growth = x @ x, 1.0
    for k in range(rank):
        multiplier = x[k] / F[k, k]
        growth = max(growth, abs(multiplier))
        x[k:] -= multiplier * F[k, k:p]
    limit = tolerance * max(scale, np.sqrt(size)) + ELIMINATION_ROUND_OFF * growth * scale
    return np.sqrt(x[rank:] @ x[rank:]) <= limit


@kernel(reference_counting=False, uncompiled=_contains_rows_by_arrays)
def contains_rows(factor, rank, rows, weight, scale):
    """Decide whether ``weight * rows`` follow from a factor: ``x = cᵀ rows`` is in its span.

    One generic combination of the rows is eliminated by the factor: if any of them adds a
    condition, so does almost every combination.

    Args:
        factor: in: a `Factor`; the last row of its workspace is out.
        rank: its rows.
        rows: in: the rows (m, parameters).
        weight: a factor of all of them.
        scale: largest pivot so far.

    Returns:
        Whether the remainder of x is round-off.
    """
    F, permutation, columns, tolerance = factor
    p, P = permutation.size, F.shape[1]
    f = F.reshape(F.size)
    x = f[f.size - P :]
    for j in range(P):
        x[j] = 0.0
    # x = Σ_i c_i rows_i, with c_i of a fixed sequence without special relations.
    for i in range(rows.shape[0]):
        c = weight * np.cos((i + 1.0) ** 2)
        for j in range(p):
            x[j] += c * rows[i, columns[permutation[j]]]
    size = 0.0
    for j in range(p):
        size += x[j] * x[j]
    # x -= (x_k / R_kk) R_k for every row of the factor.
    growth = 1.0
    for k in range(rank):
        multiplier = x[k] / F[k, k]
        growth = max(growth, abs(multiplier))
        factor = broadcast(-multiplier)
        for c in range(k // VECTOR_WIDTH * VECTOR_WIDTH, P, VECTOR_WIDTH):
            store_vector(x, c, load_vector(x, c) + factor * load_vector(f, k * P + c))
    remainder = 0.0
    for j in range(rank, p):
        remainder += x[j] * x[j]
    limit = tolerance * max(scale, np.sqrt(size)) + ELIMINATION_ROUND_OFF * growth * scale
    return np.sqrt(remainder) <= limit


@kernel(reference_counting=False)
def refactor(R, rows, columns, tolerance, scale, F, order, out):
    """Factor ``[R; rows]`` with all pivots chosen anew: ``Qᵀ [R; rows] = [R'; 0]``.

    Args:
        R: in: a factor, its columns in their own order (old, p).
        rows: in: rows (m, parameters).
        columns: in: the parameters that the columns of the factor stand for (p,).
        tolerance: relative size of round-off.
        scale: largest pivot so far.
        F: workspace as from `factor_workspace`.
        order: out: the order in which columns are eliminated (p,).
        out: out: the new factor, with its columns in their own order (≥ rank, p).

    Returns:
        The rank, the largest pivot, and the norm of the remainder.
    """
    old, end = R.shape[0], R.shape[0] + rows.shape[0]
    for j in range(order.size):
        order[j] = j
    take_factor(R, order, F)
    factor = Factor(F, order, columns, tolerance)
    append_rows(factor, old, rows, 1.0)
    rank, scale, remainder = update_factor(factor, 0, end, scale)
    put_factor(F, order, rank, out)
    return rank, scale, remainder


def updated_factor(
    R: Array, rows: Array, columns: IntArray, tolerance: float, scale: float
) -> tuple[Array, IntArray, float, float]:
    """Factor ``[R; rows]`` with all pivots chosen anew, in arrays of its own; see `refactor`.

    A factor that is only updated reveals the rank less and less well.

    Args:
        R: a factor, its columns in their own order (old, p).
        rows: rows to append (m, parameters).
        columns: the parameters that the columns of the factor stand for (p,).
        tolerance: relative size of round-off.
        scale: largest pivot so far.

    Returns:
        The factor with its columns in their own order (rank, p), the order in which they were
        eliminated (p,), the largest pivot, and the norm of the remainder that was cut off.
    """
    p = columns.size
    F, order, out = (
        factor_workspace(p, len(R) + len(rows)),
        np.empty(p, np.int64),
        np.empty((p, p)),
    )
    rank, scale, remainder = refactor(R, rows, columns, tolerance, scale, F, order, out)
    return out[:rank], order, scale, remainder


def rows_follow(
    R: Array,
    permutation: IntArray,
    rows: Array,
    columns: IntArray,
    tolerance: float,
    scale: float,
) -> bool:
    """Decide whether rows follow from a factor with its columns in their own order.

    Args:
        R: the factor (rank, p).
        permutation: the order in which its columns were eliminated (p,).
        rows: the rows (m, parameters).
        columns: the parameters that the columns of the factor stand for (p,).
        tolerance: relative size of round-off.
        scale: largest pivot so far.
    """
    F = factor_workspace(columns.size, 0)
    take_factor(R, permutation, F)
    follows: bool = contains_rows(
        Factor(F, permutation, columns, tolerance), len(R), rows, 1.0, scale
    )
    return follows


@kernel(reference_counting=False)
def smallest_pivot(R, permutation):
    """Find the smallest pivot of a triangular factor: ``min_i |R[i, permutation[i]]|``.

    Args:
        R: in: the factor, its columns in their own order (rank, p).
        permutation: in: the order of elimination (p,).

    Returns:
        Its size; infinite if there is none.
    """
    size = np.inf
    for i in range(R.shape[0]):
        size = min(size, abs(R[i, permutation[i]]))
    return size


@kernel(reference_counting=False)
def apply_reflector_sparse(f, P, k, begin, end, diagonal):
    """Apply ``I - v vᵀ / (d (r - d))`` to row k of a factor and to rows begin … end below.

    ``v = (r - d, A_k)`` turns column k into the diagonal d; r is the entry on the diagonal
    before. The many zeros in ``A_k`` are skipped.

    Args:
        f: in, out: workspace, flat (rows * P,).
        P: entries of a row, a multiple of the vector width.
        k: the row and column.
        begin: first row below.
        end: first row that is left out.
    """
    row = k * P
    head = f[row + k] - diagonal
    top, factor = broadcast(head), broadcast(1.0 / (diagonal * head))
    # The block with column k comes last: it holds the multipliers.
    for c in range(P - VECTOR_WIDTH, k // VECTOR_WIDTH * VECTOR_WIDTH - 1, -VECTOR_WIDTH):
        total = top * load_vector(f, row + c)
        for i in range(begin, end):
            x = f[i * P + k]
            if x != 0.0:
                total = total + broadcast(x) * load_vector(f, i * P + c)
        total = total * factor
        store_vector(f, row + c, load_vector(f, row + c) + top * total)
        for i in range(begin, end):
            x = f[i * P + k]
            if x != 0.0:
                store_vector(f, i * P + c, load_vector(f, i * P + c) + broadcast(x) * total)
    f[row + k] = diagonal
    for i in range(begin, end):
        f[i * P + k] = 0.0


@kernel(reference_counting=False)
def apply_reflector(f, P, k, end, diagonal, norms):
    """Apply ``I - v vᵀ / (d (r - d))`` to rows k … end; and compute norms below row k.

    Args:
        f: in, out: as in `apply_reflector_sparse`, as are the next four.
        P: entries of a row.
        k: the row and column.
        end: first row that is left out.
        norms: out: squared norms of the columns below row k (P,).
    """
    row = k * P
    head = f[row + k] - diagonal
    top, factor = broadcast(head), broadcast(1.0 / (diagonal * head))
    for c in range(P - VECTOR_WIDTH, k // VECTOR_WIDTH * VECTOR_WIDTH - 1, -VECTOR_WIDTH):
        total = top * load_vector(f, row + c)
        for i in range(k + 1, end):
            total = total + broadcast(f[i * P + k]) * load_vector(f, i * P + c)
        total = total * factor
        store_vector(f, row + c, load_vector(f, row + c) + top * total)
        squares = broadcast(0.0)
        for i in range(k + 1, end):
            x = load_vector(f, i * P + c) + broadcast(f[i * P + k]) * total
            store_vector(f, i * P + c, x)
            squares = squares + x * x
        store_vector(norms, c, squares)
    f[row + k] = diagonal
    for i in range(k + 1, end):
        f[i * P + k] = 0.0
