"""The pseudo-inverse of a small matrix of full rank, compiled for Taylor expansions."""

from __future__ import annotations

import numpy as np

from kinematics.compiled.jit import kernel
from kinematics.compiled.simd import LANES, load, spread, store

__all__ = ["pseudo_inverse"]


@kernel
def pseudo_inverse(S, equations, dependent, G, W, v):
    """Pseudo-inverse of rows and columns of the loop matrix S, transposed and padded.

    Householder's reflections turn ``[A 1]`` into ``[R Qᵀ]``, all columns at a time. The
    condition number is the product of both Frobenius norms; it is infinite if the dependent
    joints are not determined, and 1 without any.

    Args:
        S: the loop matrix.
        equations: its rows that are solved.
        dependent: its columns.
        G: takes a row of lanes for each row of S; zero before.
        W: room for a row of lanes, as many as columns and rows, for each equation; zero.
        v: room for as many numbers as equations.

    Returns:
        The condition number.
    """
    m, nd = equations.size, dependent.size
    stride, lanes = -(-(nd + m) // LANES) * LANES, -(-nd // LANES) * LANES
    if nd == 0 or m < nd:
        return 1.0 if nd == 0 else np.inf
    size = inverse = 0.0
    for r in range(m):
        for d in range(nd):
            W[r * stride + d] = S[equations[r], dependent[d]]
            size += W[r * stride + d] ** 2
        W[r * stride + nd + r] = 1.0
    for k in range(nd):
        square = 0.0
        for r in range(k, m):
            v[r] = W[r * stride + k]
            square += v[r] * v[r]
        if square == 0.0:
            return np.inf
        norm = -np.sqrt(square) if v[k] > 0.0 else np.sqrt(square)
        v[k] -= norm
        factor = spread(1.0 / (norm * v[k]))
        for x in range(k // LANES * LANES, stride, LANES):
            dot = spread(0.0)
            for r in range(k, m):
                dot = dot + spread(v[r]) * load(W, r * stride + x)
            dot = dot * factor
            for r in range(k, m):
                store(W, r * stride + x, load(W, r * stride + x) + spread(v[r]) * dot)
    for k in range(nd - 1, -1, -1):
        pivot = 1.0 / W[k * stride + k]
        for d in range(k + 1, nd):
            v[d] = -W[k * stride + d]
        for x in range(nd // LANES * LANES, stride, LANES):
            row = load(W, k * stride + x)
            for d in range(k + 1, nd):
                row = row + spread(v[d]) * load(W, d * stride + x)
            store(W, k * stride + x, row * spread(pivot))
    for r in range(m):
        for d in range(nd):
            G[equations[r] * lanes + d] = W[d * stride + nd + r]
            inverse += W[d * stride + nd + r] ** 2
    _refine(S, equations, dependent, lanes, G, W, v)
    return np.sqrt(size * inverse)


@kernel
def _refine(S, equations, dependent, lanes, G, E, before):
    """A Newton step for the inverse P of A, transposed in G: ``P + (1 - P A) P``."""
    m, nd = equations.size, dependent.size
    for i in range(nd * lanes):
        E[i] = 0.0
    for e in range(nd):
        E[e * lanes + e] = 1.0
        for x in range(0, lanes, LANES):
            rest = load(E, e * lanes + x)
            for r in range(m):
                entry = -S[equations[r], dependent[e]]
                rest = rest + spread(entry) * load(G, equations[r] * lanes + x)
            store(E, e * lanes + x, rest)
    for r in range(m):
        row = equations[r] * lanes
        for e in range(nd):
            before[e] = G[row + e]
        for x in range(0, lanes, LANES):
            total = load(G, row + x)
            for e in range(nd):
                total = total + spread(before[e]) * load(E, e * lanes + x)
            store(G, row + x, total)
