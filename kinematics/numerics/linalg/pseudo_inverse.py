"""The pseudo-inverse of a small matrix of full rank, compiled for Taylor expansions.

``A = Q R`` by Householder's reflections, ``A⁺ = R⁻¹ Qᵀ``, refined by one Newton step.
"""

from __future__ import annotations

import numpy as np

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import VECTOR_WIDTH, broadcast, load_vector, store_vector


@kernel(inline=True, reference_counting=False)
def pseudo_inverse(S, equations, dependent, G, W, v):
    """Compute the pseudo-inverse of rows and columns of the loop matrix S, transposed.

    Householder's reflections turn ``[A 1]`` into ``[R Qᵀ]``, all columns at a time; then
    ``A⁺ = R⁻¹ Qᵀ`` by back substitution. The condition number is the product of the Frobenius
    norms of A and A⁺.

    Args:
        S: in; the loop matrix (rows, n), chain units.
        equations: in; its rows that are solved (m,).
        dependent: in; its columns (d,).
        G: in, zeros; out, the pseudo-inverse, transposed and flat: for each row of S a row of
            n numbers, rounded up to whole vectors, zeros but for the dependent columns.
        W: workspace, zeros; for each equation a row of d + m numbers, rounded up likewise.
        v: workspace (m,).

    Returns:
        The condition number; infinite if the equations do not determine the dependent joints,
        and 1 if there are none.
    """
    m, nd = equations.size, dependent.size
    if nd == 0 or m < nd:
        return 1.0 if nd == 0 else np.inf
    stride, lanes = W.size // m, G.size // S.shape[0]
    size = inverse = 0.0
    # W = [A 1]
    for r in range(m):
        row, square = W[r * stride : (r + 1) * stride], 0.0
        for d in range(nd):
            row[d] = S[equations[r], dependent[d]]
            square += row[d] * row[d]
        row[nd + r] = 1.0
        size += square
    # W = [R Qᵀ]: rows k … m of each column y become y + v (v · y) / (norm v_k). Reflections are
    # applied to whole vectors of columns side by side: one column at a time, as in
    # `skyline_qr.factor_envelope`, takes 1.4 times as long for 3 unknowns and 2.5 for
    # 30. To make them by a kernel shared with that file takes a fifth longer for 30 unknowns.
    for k in range(nd):
        square = 0.0
        for r in range(k, m):
            v[r] = W[r * stride + k]
            square += v[r] * v[r]
        if square == 0.0:
            return np.inf
        norm = -np.sqrt(square) if v[k] > 0.0 else np.sqrt(square)
        v[k] -= norm
        factor = broadcast(1.0 / (norm * v[k]))
        for x in range(k // VECTOR_WIDTH * VECTOR_WIDTH, stride, VECTOR_WIDTH):
            dot = broadcast(0.0)
            for r in range(k, m):
                dot = dot + broadcast(v[r]) * load_vector(W, r * stride + x)
            dot = dot * factor
            for r in range(k, m):
                store_vector(
                    W, r * stride + x, load_vector(W, r * stride + x) + broadcast(v[r]) * dot
                )
    # R⁻¹ Qᵀ: rows from the last one on
    for k in range(nd - 1, -1, -1):
        pivot = 1.0 / W[k * stride + k]
        for d in range(k + 1, nd):
            v[d] = -W[k * stride + d]
        for x in range(nd // VECTOR_WIDTH * VECTOR_WIDTH, stride, VECTOR_WIDTH):
            row = load_vector(W, k * stride + x)
            for d in range(k + 1, nd):
                row = row + broadcast(v[d]) * load_vector(W, d * stride + x)
            store_vector(W, k * stride + x, row * broadcast(pivot))
    # the transpose
    for r in range(m):
        column, square = G[equations[r] * lanes : (equations[r] + 1) * lanes], 0.0
        for d in range(nd):
            entry = W[d * stride + nd + r]
            column[dependent[d]] = entry
            square += entry * entry
        inverse += square
    _refine_inverse(S, equations, dependent, lanes, G, W, v)
    return np.sqrt(size * inverse)


@kernel(inline=True, reference_counting=False)
def _refine_inverse(S, equations, dependent, lanes, G, E, before):
    """Refine the inverse P of A by a Newton step, in place: ``P ← P + (1 - P A) P``.

    Args:
        S: in; the loop matrix (rows, n).
        equations: in; its rows that are solved (m,).
        dependent: in; its columns (d,).
        lanes: length of the rows of G and E, whole vectors.
        G: in and out; P, transposed: a row for each row of S.
        E: workspace, d rows or more: the transpose of ``1 - P A``, spread like G.
        before: workspace (d or more,).
    """
    m, nd = equations.size, dependent.size
    # E = (1 - P A)ᵀ
    for i in range(nd * lanes):
        E[i] = 0.0
    for e in range(nd):
        E[e * lanes + dependent[e]] = 1.0
        for x in range(0, lanes, VECTOR_WIDTH):
            rest = load_vector(E, e * lanes + x)
            for r in range(m):
                entry = -S[equations[r], dependent[e]]
                rest = rest + broadcast(entry) * load_vector(G, equations[r] * lanes + x)
            store_vector(E, e * lanes + x, rest)
    # Pᵀ ← Pᵀ + Pᵀ E
    for r in range(m):
        row = equations[r] * lanes
        for e in range(nd):
            before[e] = G[row + dependent[e]]
        for x in range(0, lanes, VECTOR_WIDTH):
            total = load_vector(G, row + x)
            for e in range(nd):
                total = total + broadcast(before[e]) * load_vector(E, e * lanes + x)
            store_vector(G, row + x, total)
