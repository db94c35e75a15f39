"""Householder QR of the loop matrices of many geometries side by side, one in each lane.

The envelope is that of `kinematics.numerics.linalg.skyline_qr`, which treats one geometry. The
last axis of every array is that of the lanes, `VECTOR_WIDTH` numbers long. Where a column is 0,
all results of its lane are NaN.
"""

from __future__ import annotations

from typing import NamedTuple

from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import (
    broadcast,
    choose_greater,
    lanes,
    load_vector,
    square_root,
    store_vector,
)
from kinematics.numerics.linalg.skyline_qr import (
    BELOW,
    COLUMN,
    COUNT,
    ENTRIES,
    HEIGHT,
    IN_LOOPS,
    MEMBER,
    PLACE,
    RIGHT,
    ROWS,
    SIGN,
    TOP,
)


class LoopFactor(NamedTuple):
    """Factors of loop matrices in lanes, and a right-hand side.

    Attributes:
        F: columns from their tops on (nd, height, lanes).
        diagonal: R's diagonal (nd, lanes).
        scales: ``1 / (r v_1)`` of each reflection (nd, lanes).
        b: right-hand side by rows of the envelope, or the solution (rows, lanes).
    """

    F: Array
    diagonal: Array
    scales: Array
    b: Array


def loop_factor_workspace(envelope: IntArray, count: int) -> LoopFactor:
    """Allocate factors in lanes.

    Args:
        envelope: the table of `kinematics.numerics.linalg.skyline_qr`.
        count: number of dependent joints.
    """
    height, rows = envelope[COUNT, HEIGHT : ROWS + 1].tolist()
    return LoopFactor(
        lanes(count, height),
        lanes(count),
        lanes(count),
        lanes(max(rows, count)),
    )


@kernel(reference_counting=False)
def factor_loops(screws, mimics, envelope, factor):
    """Compute the QR of the loop matrices of all lanes.

    Args:
        screws: in; joint screws (n, 3 or 6, lanes), chain units.
        mimics: in; relations between joint positions (g, n, lanes).
        envelope: in; the table.
        factor: out; a `LoopFactor`.
    """
    F, diagonal, scales, _ = factor
    top, below, right = envelope[TOP], envelope[BELOW], envelope[RIGHT]
    zero, one = broadcast(0.0), broadcast(1.0)
    for c in range(F.shape[0]):
        for i in range(F.shape[1]):
            store_vector(F[c, i], 0, zero)
    for e in range(envelope[COUNT, ENTRIES]):
        c, at = envelope[COLUMN, e], envelope[PLACE, e]
        j, sign = envelope[MEMBER, e], envelope[SIGN, e]
        if e >= envelope[COUNT, IN_LOOPS]:
            store_vector(F[c, at], 0, load_vector(mimics[sign, j], 0))
            continue
        side = broadcast(1.0 * sign)
        for i in range(screws.shape[1]):
            store_vector(F[c, at + i], 0, side * load_vector(screws[j, i], 0))
    for k in range(F.shape[0]):
        begin, size = k - top[k], below[k] - k
        squares = zero
        for i in range(begin, begin + size):
            x = load_vector(F[k, i], 0)
            squares = squares + x * x
        head, r = load_vector(F[k, begin], 0), square_root(squares)
        r = choose_greater(head, zero, zero - r, r)
        head = head - r
        scale = one / (r * head)
        store_vector(diagonal[k], 0, r)
        store_vector(scales[k], 0, scale)
        store_vector(F[k, begin], 0, head)
        # y ← y + v (v · y) / (r v_1) for the columns that share rows with this one
        for j in range(k + 1, right[k]):
            y, dot = k - top[j], zero
            for i in range(size):
                dot = dot + load_vector(F[k, begin + i], 0) * load_vector(F[j, y + i], 0)
            dot = dot * scale
            for i in range(size):
                store_vector(
                    F[j, y + i],
                    0,
                    load_vector(F[j, y + i], 0) + dot * load_vector(F[k, begin + i], 0),
                )


@kernel(reference_counting=False)
def solve_loops(envelope, factor, residual):
    """Compute the least-squares solutions x of ``S x = b`` from the factors of S.

    Args:
        envelope: in; the table.
        factor: in; a `LoopFactor`; its ``b`` is out: x by columns of the envelope.
        residual: in and out; square of the largest residual so far (lanes,).
    """
    F, diagonal, scales, b = factor
    top, below = envelope[TOP], envelope[BELOW]
    columns, squares = F.shape[0], broadcast(0.0)
    # b ← Qᵀ b, one reflection after the other
    for k in range(columns):
        begin, size, dot = k - top[k], below[k] - k, broadcast(0.0)
        for i in range(size):
            dot = dot + load_vector(F[k, begin + i], 0) * load_vector(b[k + i], 0)
        dot = dot * load_vector(scales[k], 0)
        for i in range(size):
            store_vector(
                b[k + i],
                0,
                load_vector(b[k + i], 0) + dot * load_vector(F[k, begin + i], 0),
            )
    for i in range(columns, envelope[COUNT, ROWS]):
        x = load_vector(b[i], 0)
        squares = squares + x * x
    # R x = b, by columns, the last one first
    for k in range(columns - 1, -1, -1):
        x = load_vector(b[k], 0) / load_vector(diagonal[k], 0)
        store_vector(b[k], 0, x)
        for i in range(top[k], k):
            store_vector(b[i], 0, load_vector(b[i], 0) - x * load_vector(F[k, i - top[k]], 0))
    before = load_vector(residual, 0)
    store_vector(residual, 0, choose_greater(before, squares, before, squares))
