"""Rank-revealing QR of many small matrices side by side, one in each lane.

Eliminations and decisions are those of `kinematics.numerics.linalg.pivoted_qr`. Columns stay in
the order of elimination, which differs from lane to lane; the rank must be the same in all:
lanes in which it differs from that of most others are no longer active. The last axis of every
array is that of the lanes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import (
    VECTOR_WIDTH,
    broadcast,
    choose_greater,
    lanes,
    load_vector,
    square_root,
    store_vector,
)
from kinematics.numerics.tolerances import ELIMINATION_ROUND_OFF


class LaneFactor(NamedTuple):
    """Factors in lanes.

    Attributes:
        F: rows of the factor, then rows to absorb (rows, ≥ p, lanes).
        columns: the unknown that each column stands for (≥ p, lanes).
        norms: squared norms of the remainders, or a combination of rows (≥ p, lanes).
        combined: the same combination by unknowns (unknowns, lanes).
        limits: relative size of round-off, largest pivot, largest remainder that was cut off;
            then workspace (6, lanes).
        active: whether a lane follows the others (lanes,).
    """

    F: Array
    columns: IntArray
    norms: Array
    combined: Array
    limits: Array
    active: IntArray


def lane_factor_workspace(unknowns: int, m: int) -> LaneFactor:
    """Allocate factors in lanes.

    Args:
        m: number of rows to absorb at once, at most.
    """
    W = VECTOR_WIDTH
    return LaneFactor(
        lanes(unknowns + m, unknowns),
        np.zeros((unknowns, W), np.int64),
        lanes(unknowns),
        lanes(unknowns),
        lanes(6),
        np.zeros(W, np.int64),
    )


@kernel(reference_counting=False)
def append_lanes(factor, p, rank, rows, weight):
    """Append rows below the factors, in the order of their columns.

    Args:
        factor: in and out; a `LaneFactor`.
        p: number of columns.
        rank: rows of the factors.
        rows: in; the rows (m, unknowns, lanes).
        weight: in; a factor of all of them (lanes,).
    """
    F, columns = factor.F, factor.columns
    for i in range(rows.shape[0]):
        for j in range(p):
            for lane in range(VECTOR_WIDTH):
                F[rank + i, j, lane] = weight[lane] * rows[i, columns[j, lane], lane]


@kernel(reference_counting=False)
def _reflect(F, k, begin, end, p, size, norms):
    """Reflect row k and rows begin … end, so that column k becomes its diagonal.

    Args:
        F: in and out; as in `LaneFactor`.
        k: the row and column.
        begin: first row below it.
        end: first row that is left out.
        p: number of columns.
        size: in; norm of column k in these rows (lanes,).
        norms: out; squared norms of the later columns in rows begin … end (≥ p, lanes).
    """
    zero, d, head = broadcast(0.0), load_vector(size, 0), load_vector(F[k, k], 0)
    d = choose_greater(head, zero, zero - d, d)
    head = head - d
    scale = broadcast(1.0) / (d * head)
    for j in range(k + 1, p):
        top = load_vector(F[k, j], 0)
        dot, squares = head * top, zero
        for i in range(begin, end):
            dot = dot + load_vector(F[i, k], 0) * load_vector(F[i, j], 0)
        dot = dot * scale
        store_vector(F[k, j], 0, top + head * dot)
        for i in range(begin, end):
            x = load_vector(F[i, j], 0) + load_vector(F[i, k], 0) * dot
            store_vector(F[i, j], 0, x)
            squares = squares + x * x
        store_vector(norms[j], 0, squares)
    store_vector(F[k, k], 0, d)


@kernel(reference_counting=False)
def _find_pivots(factor, rank, p):
    """Find the largest remainder of every lane, and the sum of all.

    Args:
        factor: in and out; a `LaneFactor`. Lines 3, 4, 5 of its limits are out: the largest
            squared norm, the column that has it, and the sum.
        rank: first column that is left.
        p: number of columns.
    """
    norms, limits = factor.norms, factor.limits
    best, where, total = broadcast(-1.0), broadcast(1.0 * rank), broadcast(0.0)
    for j in range(rank, p):
        size = load_vector(norms[j], 0)
        total = total + size
        where = choose_greater(size, best, broadcast(1.0 * j), where)
        best = choose_greater(size, best, size, best)
    store_vector(limits[3], 0, best)
    store_vector(limits[4], 0, where)
    store_vector(limits[5], 0, total)


@kernel(reference_counting=False)
def _most_have_a_pivot(limits, active):
    """Decide by majority whether another column is eliminated; the others stop being active.

    Args:
        limits: in and out; as in `LaneFactor`; line 3 is out: the sizes of the pivots.
        active: in and out; which lanes count (lanes,).
    """
    count = kept = 0
    store_vector(limits[3], 0, square_root(load_vector(limits[3], 0)))
    for lane in range(VECTOR_WIDTH):
        limits[1, lane] = max(limits[1, lane], limits[3, lane])
        if active[lane]:
            count += 1
            kept += limits[3, lane] > limits[0, lane] * limits[1, lane]
    keep = 2 * kept > count
    for lane in range(VECTOR_WIDTH):
        if (limits[3, lane] > limits[0, lane] * limits[1, lane]) != keep:
            active[lane] = 0
    return keep


@kernel(reference_counting=False)
def _swap_pivots(factor, rank, end):
    """Swap column ``rank`` of every lane with that of its pivot.

    Args:
        factor: in and out; a `LaneFactor`; line 4 of its limits has the pivots.
        rank: the column.
        end: number of rows.
    """
    F, columns = factor.F, factor.columns
    for lane in range(VECTOR_WIDTH):
        j = int(factor.limits[4, lane])
        if j == rank:
            continue
        columns[rank, lane], columns[j, lane] = columns[j, lane], columns[rank, lane]
        for i in range(end):
            F[i, rank, lane], F[i, j, lane] = F[i, j, lane], F[i, rank, lane]


@kernel(reference_counting=False)
def absorb_rows(factor, p, rank, m):
    """Update the factors with the m rows below them; see `update_factor`.

    Args:
        factor: in and out; a `LaneFactor`.
        p: number of columns.
        rank: rows of the factors.
        m: rows to absorb.

    Returns:
        The rank of the active lanes.
    """
    F, _, norms, _, limits, active = factor
    end = rank + m
    # Columns eliminated before: reflect row k and the new rows.
    for k in range(rank):
        x = load_vector(F[k, k], 0)
        squares = x * x
        for i in range(rank, end):
            x = load_vector(F[i, k], 0)
            squares = squares + x * x
        size, largest = square_root(squares), load_vector(limits[1], 0)
        store_vector(limits[1], 0, choose_greater(size, largest, size, largest))
        store_vector(limits[3], 0, size)
        _reflect(F, k, rank, end, p, limits[3], norms)
    # The last of these reflections leaves the norms of the other columns.
    for j in range(rank, p if rank == 0 else rank):
        squares = broadcast(0.0)
        for i in range(end):
            x = load_vector(F[i, j], 0)
            squares = squares + x * x
        store_vector(norms[j], 0, squares)
    while True:
        _find_pivots(factor, rank, p)
        if rank == min(end, p) or not _most_have_a_pivot(limits, active):
            break
        _swap_pivots(factor, rank, end)
        _reflect(F, rank, rank + 1, end, p, limits[3], norms)
        rank += 1
    remainder, dropped = square_root(load_vector(limits[5], 0)), load_vector(limits[2], 0)
    store_vector(limits[2], 0, choose_greater(remainder, dropped, remainder, dropped))
    return rank


@kernel(reference_counting=False)
def rows_follow_lanes(factor, p, rank, rows):
    """Decide whether rows follow from the factor of each lane; see `contains_rows`.

    Args:
        factor: in; a `LaneFactor`. Line 3 of its limits is out: positive where they follow.
        p: number of columns.
        rank: rows of the factors.
        rows: in; the rows (m, unknowns, lanes).
    """
    F, columns, x, combined, limits, _ = factor
    zero = broadcast(0.0)
    for u in range(combined.shape[0]):
        total = zero
        for i in range(rows.shape[0]):
            total = total + broadcast(np.cos((i + 1.0) ** 2)) * load_vector(rows[i, u], 0)
        store_vector(combined[u], 0, total)
    for j in range(p):
        for lane in range(VECTOR_WIDTH):
            x[j, lane] = combined[columns[j, lane], lane]
    squares, growth, remainder = zero, broadcast(1.0), zero
    for j in range(p):
        entry = load_vector(x[j], 0)
        squares = squares + entry * entry
    # x -= (x_k / R_kk) R_k for every row of the factor.
    for k in range(rank):
        multiplier = load_vector(x[k], 0) / load_vector(F[k, k], 0)
        size = choose_greater(zero, multiplier, zero - multiplier, multiplier)
        growth = choose_greater(size, growth, size, growth)
        for j in range(k + 1, p):
            rest = load_vector(x[j], 0) - multiplier * load_vector(F[k, j], 0)
            store_vector(x[j], 0, rest)
    for j in range(rank, p):
        entry = load_vector(x[j], 0)
        remainder = remainder + entry * entry
    size, scale = square_root(squares), load_vector(limits[1], 0)
    limit = load_vector(limits[0], 0) * choose_greater(size, scale, size, scale)
    limit = limit + broadcast(ELIMINATION_ROUND_OFF) * growth * scale
    # Positive, not zero, where both vanish: nothing is left of rows that are 0.
    store_vector(limits[3], 0, limit - square_root(remainder))
