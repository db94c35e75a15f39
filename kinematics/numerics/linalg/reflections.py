"""Householder reflections of rows in place, a vector of columns at a time: compiled kernels."""

from __future__ import annotations

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import VECTOR_WIDTH, broadcast, load_vector, store_vector


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
