"""The pseudo-inverses of many small matrices side by side, one in each lane: a kernel.

As `kinematics.numerics.linalg.pseudo_inverse`, which treats one matrix. The last axis of every
array is that of the lanes.
"""

from __future__ import annotations

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import (
    broadcast,
    choose_greater,
    load_vector,
    square_root,
    store_vector,
)


@kernel(reference_counting=False)
def lane_pseudo_inverse(A, W, P, E, condition):
    """Compute ``A⁺ = R⁻¹ Qᵀ`` by Householder's reflections, and refine it by a Newton step.

    Args:
        A: in; the matrices (m, d, lanes).
        W: workspace (m, d + m, lanes).
        P: out; the pseudo-inverses (d, m, lanes).
        E: workspace (d, d + 1, lanes).
        condition: out; product of the Frobenius norms of both (lanes,), a NaN or infinity
            where A does not determine d unknowns.
    """
    (m, nd), zero, one = A.shape[:2], broadcast(0.0), broadcast(1.0)
    size, inverse = zero, zero
    # W = [A 1]
    for r in range(m):
        for d in range(nd):
            x = load_vector(A[r, d], 0)
            size = size + x * x
            store_vector(W[r, d], 0, x)
        for e in range(m):
            store_vector(W[r, nd + e], 0, one if e == r else zero)
    # W = [R Qᵀ]: rows k … m of each column y become y + v (v · y) / (norm v_k).
    for k in range(nd):
        squares, head = zero, load_vector(W[k, k], 0)
        for r in range(k, m):
            x = load_vector(W[r, k], 0)
            squares = squares + x * x
        norm = square_root(squares)
        norm = choose_greater(head, zero, zero - norm, norm)
        head = head - norm
        scale = one / (norm * head)
        for c in range(k + 1, nd + m):
            top = load_vector(W[k, c], 0)
            dot = head * top
            for r in range(k + 1, m):
                dot = dot + load_vector(W[r, k], 0) * load_vector(W[r, c], 0)
            dot = dot * scale
            store_vector(W[k, c], 0, top + head * dot)
            for r in range(k + 1, m):
                x = load_vector(W[r, c], 0) + load_vector(W[r, k], 0) * dot
                store_vector(W[r, c], 0, x)
        store_vector(W[k, k], 0, norm)
    # R⁻¹ Qᵀ: rows from the last one on
    for k in range(nd - 1, -1, -1):
        pivot = one / load_vector(W[k, k], 0)
        for r in range(m):
            x = load_vector(W[k, nd + r], 0)
            for d in range(k + 1, nd):
                x = x - load_vector(W[k, d], 0) * load_vector(P[d, r], 0)
            x = x * pivot
            store_vector(P[k, r], 0, x)
            inverse = inverse + x * x
    # E = 1 - P A
    for d in range(nd):
        for e in range(nd):
            x = one if d == e else zero
            for r in range(m):
                x = x - load_vector(P[d, r], 0) * load_vector(A[r, e], 0)
            store_vector(E[d, e], 0, x)
    # P ← P + E P, a column at a time
    for r in range(m):
        for d in range(nd):
            x = load_vector(P[d, r], 0)
            for e in range(nd):
                x = x + load_vector(E[d, e], 0) * load_vector(P[e, r], 0)
            store_vector(E[d, nd], 0, x)
        for d in range(nd):
            store_vector(P[d, r], 0, load_vector(E[d, nd], 0))
    store_vector(condition, 0, square_root(size * inverse))
