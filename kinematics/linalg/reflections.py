"""Householder reflections of rows in place, several columns at a time: compiled kernels."""

from __future__ import annotations

from kinematics.compiled.jit import kernel
from kinematics.compiled.simd import LANES, load, spread, store

__all__ = ["fold", "reflect"]


@kernel(reference_counting=False)
def fold(f, P, k, begin, end, diagonal):
    """Apply ``I - v vᵀ / (d (r - d))`` to row k of a factor and to rows begin … end below.

    ``v = (r - d, A_k)`` turns column k into the diagonal d; r is the entry on the diagonal
    before. Zeros in ``A_k``, of which there are many, are skipped.

    Args:
        f: in, out: workspace, flat (rows * P,).
        P: entries of a row, a multiple of the vector width.
        k: the row and column.
        begin: first row below.
        end: first row that is left out.
        diagonal: d.
    """
    row = k * P
    head = f[row + k] - diagonal
    top, factor = spread(head), spread(1.0 / (diagonal * head))
    # The block with column k comes last: it holds the multipliers.
    for c in range(P - LANES, k // LANES * LANES - 1, -LANES):
        total = top * load(f, row + c)
        for i in range(begin, end):
            x = f[i * P + k]
            if x != 0.0:
                total = total + spread(x) * load(f, i * P + c)
        total = total * factor
        store(f, row + c, load(f, row + c) + top * total)
        for i in range(begin, end):
            x = f[i * P + k]
            if x != 0.0:
                store(f, i * P + c, load(f, i * P + c) + spread(x) * total)
    f[row + k] = diagonal
    for i in range(begin, end):
        f[i * P + k] = 0.0


@kernel(reference_counting=False)
def reflect(f, P, k, end, diagonal, norms):
    """Apply ``I - v vᵀ / (d (r - d))`` to rows k … end; norms of what is left below row k.

    Args:
        f: in, out: as in `fold`, as are the next four.
        P: entries of a row.
        k: the row and column.
        end: first row that is left out.
        diagonal: d.
        norms: out: squared norms of the columns below row k (P,).
    """
    row = k * P
    head = f[row + k] - diagonal
    top, factor = spread(head), spread(1.0 / (diagonal * head))
    for c in range(P - LANES, k // LANES * LANES - 1, -LANES):
        total = top * load(f, row + c)
        for i in range(k + 1, end):
            total = total + spread(f[i * P + k]) * load(f, i * P + c)
        total = total * factor
        store(f, row + c, load(f, row + c) + top * total)
        squares = spread(0.0)
        for i in range(k + 1, end):
            x = load(f, i * P + c) + spread(f[i * P + k]) * total
            store(f, i * P + c, x)
            squares = squares + x * x
        store(norms, c, squares)
    f[row + k] = diagonal
    for i in range(k + 1, end):
        f[i * P + k] = 0.0
