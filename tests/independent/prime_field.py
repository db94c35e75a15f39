"""Motion and momentum as power series modulo a prime, and elimination; no floating point.

Everything hangs from four points that move with a link: its place ``x_0``, and the columns
``x_1 … x_3`` of its rotation. A twist ``[ω; v]`` moves them by ``ẋ_0 = ω × x_0 + v`` and
``ẋ_a = ω × x_a``, and the momentum of the second moment ``∫ [1; r] [1; r]ᵀ dm`` is

    ξ_ij = x_i × ẋ_j + x_j × ẋ_i   (half of it for i = j),      p_0j = ẋ_j

Remainders are below 2³⁰, so that eight products add up in 64 bits.
"""

from __future__ import annotations

import numba
import numpy as np

PRIMES = (998244353, 1000000007)
kernel = numba.njit(cache=True)


@kernel
def _add_cross(out, a, b, p):
    """``out += a × b``."""
    out[0] = (out[0] + a[1] * b[2] + (p - a[2]) * b[1]) % p
    out[1] = (out[1] + a[2] * b[0] + (p - a[0]) * b[2]) % p
    out[2] = (out[2] + a[0] * b[1] + (p - a[1]) * b[0]) % p


@kernel
def inverse(a, p):
    """``a⁻¹`` by Fermat's theorem."""
    result, power, base = 1, p - 2, a % p
    while power:
        if power & 1:
            result = result * base % p
        base = base * base % p
        power >>= 1
    return result


@kernel
def absorb(basis, pivots, rank, rows, p):
    """Add rows to a reduced echelon basis (room, columns) with its pivot columns.

    Returns:
        The rank now. Row r of the basis is 1 in column ``pivots[r]``, where others are 0.
    """
    columns = basis.shape[1]
    row = np.empty(columns, np.int64)
    for i in range(rows.shape[0]):
        row[:] = rows[i]
        r = 0
        while r < rank:
            last = min(r + 7, rank)
            for c in range(columns):
                total = row[c]
                for q in range(r, last):
                    total += (p - rows[i, pivots[q]]) * basis[q, c]
                row[c] = total % p
            r = last
        lead = -1
        for c in range(columns):
            if row[c]:
                lead = c
                break
        if lead < 0:
            continue
        scale = inverse(row[lead], p)
        for c in range(columns):
            row[c] = row[c] * scale % p
        for q in range(rank):
            factor = p - basis[q, lead]
            if factor != p:
                for c in range(columns):
                    basis[q, c] = (basis[q, c] + factor * row[c]) % p
        basis[rank] = row
        pivots[rank] = lead
        rank += 1
    return rank


@kernel
def reduced(A, p):
    """Reduced row echelon form of A (rows, columns), and the row operations that give it.

    Returns:
        The form, the operations T (rows, rows), and the pivot column of each row, or -1.
    """
    rows, columns = A.shape
    # A and T beside each other. Numba takes seconds to compile the functions of NumPy that
    # make these arrays, and operations on whole rows.
    both, pivots = np.zeros((rows, columns + rows), np.int64), np.zeros(rows, np.int64)
    for i in range(rows):
        pivots[i] = -1
        both[i, columns + i] = 1
        for j in range(columns):
            both[i, j] = A[i, j]
    rank = 0
    for c in range(columns):
        at = rank
        while at < rows and both[at, c] == 0:
            at += 1
        if at == rows:
            continue
        for j in range(both.shape[1]):
            both[rank, j], both[at, j] = both[at, j], both[rank, j]
        scale = inverse(both[rank, c], p)
        for j in range(both.shape[1]):
            both[rank, j] = both[rank, j] * scale % p
        for i in range(rows):
            factor = p - both[i, c]
            if i != rank and factor != p:
                for j in range(both.shape[1]):
                    both[i, j] = (both[i, j] + factor * both[rank, j]) % p
        pivots[rank] = c
        rank += 1
    return both[:, :columns], both[:, columns:], pivots


@kernel
def _carried(s, X, screw, k, p):
    """Order k of the screw of a joint, moved by the points of the link that carries it."""
    for i in range(3):
        for a in range(3):
            s[k, i] = (s[k, i] + X[k, 1 + a, i] * screw[a]) % p
            s[k, 3 + i] = (s[k, 3 + i] + X[k, 1 + a, i] * screw[3 + a]) % p
    for a in range(k + 1):
        _add_cross(s[k, 3:], X[a, 0], s[k - a, :3], p)


@kernel
def _rates(C, lag, signs, form, T, pivots, start, k, w, p):
    """Order k of the rates for column w, which close the loops; whether they can.

    The loops ask for ``Σ ± S_0 C_k = -Σ ± lag``, where lag is ``Σ_{a>0} S_a C_{k-a}``.
    """
    b = np.zeros(T.shape[0], np.int64)
    for loop in range(signs.shape[0]):
        for e in range(signs.shape[1]):
            if signs[loop, e]:
                for i in range(6):
                    b[6 * loop + i] -= signs[loop, e] * lag[e, w, i]
    for i in range(b.size):
        b[i] %= p
    if k == 0:
        C[0, :, w] = start[:, w]
    for i in range(b.size):
        total = 0
        for j in range(b.size):
            total = (total + T[i, j] * b[j]) % p
        if pivots[i] < 0:
            if total:
                return False
            continue
        if k == 0:
            for e in range(signs.shape[1]):
                if e != pivots[i]:
                    total = (total + (p - form[i, e]) * start[e, w]) % p
        C[k, pivots[i], w] = total
    return True


@kernel
def _advance(X, V, ray, k, p):
    """Order k + 1 of the points of a link, from its twists along the ray."""
    along = np.zeros(6, np.int64)
    for a in range(k + 1):
        along[:] = 0
        for w in range(ray.size):
            for i in range(6):
                along[i] = (along[i] + V[a, w, i] * ray[w]) % p
        for i in range(4):
            _add_cross(X[k + 1, i], along[:3], X[k - a, i], p)
    share = inverse(k + 1, p)
    for i in range(3):
        X[k + 1, 0, i] += along[3 + i]
    for i in range(4):
        for j in range(3):
            X[k + 1, i, j] = X[k + 1, i, j] % p * share % p


@kernel
def motion(before, after, screws, signs, form, T, pivots, start, ray, order, p):
    """Points and twists of every node along the ray ``u = t δ`` in the columns ``start``.

    Args:
        before: node that carries each edge (e,).
        after: node that a tree edge moves, -1 for an edge that closes a loop (e,).
        screws: at the reference pose (e, 6).
        signs: of each edge along each loop (loops, e).
        form, T, pivots: of the loop matrix, its mimic relations last; see `reduced`.
        start: rates of the independent edges for each column (e, w).
        ray: δ (w,).
        order: the highest.
        p: the prime.

    Returns:
        Points (nodes, order + 2, 4, 3), twists (nodes, order + 1, w, 6), rates
        (order + 1, e, w), and the number of orders at which the loops close.
    """
    edges, width = start.shape
    nodes = 1
    for e in range(edges):
        nodes = max(nodes, after[e] + 1)
    X = np.zeros((nodes, order + 2, 4, 3), np.int64)
    V = np.zeros((nodes, order + 1, width, 6), np.int64)
    S = np.zeros((edges, order + 1, 6), np.int64)
    C = np.zeros((order + 1, edges, width), np.int64)
    lag = np.zeros((edges, width, 6), np.int64)
    X[:, 0, 1, 0] = X[:, 0, 2, 1] = X[:, 0, 3, 2] = 1
    for k in range(order + 1):
        for e in range(edges):
            _carried(S[e], X[before[e]], screws[e], k, p)
            for w in range(width):
                for i in range(6):
                    total = 0
                    for a in range(1, k + 1):
                        total = (total + S[e, a, i] * C[k - a, e, w]) % p
                    lag[e, w, i] = total
        for w in range(width):
            if not _rates(C, lag, signs, form, T, pivots, start, k, w, p):
                return X, V, C, k
        for e in range(edges):
            for w in range(width if after[e] >= 0 else 0):
                for i in range(6):
                    own = lag[e, w, i] + S[e, 0, i] * C[k, e, w]
                    V[after[e], k, w, i] = (V[before[e], k, w, i] + own) % p
        for n in range(nodes):
            _advance(X[n], V[n], ray, k, p)
    return X, V, C, order + 1


@kernel
def momentum(X, V, pairs, rows, parameters, p):
    """Coefficients of the momentum of every node; (order + 1, w, rows, nodes, parameters).

    Args:
        X: points, from `motion`.
        V: twists.
        pairs: i, j and the number of the parameter to which they belong (pairs, 3).
        rows: which of ``[ξ; p]`` count.
        parameters: how many a body has.
        p: the prime.
    """
    nodes, orders, width, _ = V.shape
    M = np.zeros((orders, width, rows.size, nodes, parameters), np.int64)
    D, h = np.zeros((orders, 4, 3), np.int64), np.zeros(6, np.int64)
    for n in range(nodes):
        for w in range(width):
            D[:] = 0
            for k in range(orders):
                for i in range(4):
                    for a in range(k + 1):
                        _add_cross(D[k, i], V[n, a, w, :3], X[n, k - a, i], p)
                for i in range(3):
                    D[k, 0, i] = (D[k, 0, i] + V[n, k, w, 3 + i]) % p
            for k in range(orders):
                for q in range(pairs.shape[0]):
                    i, j, at = pairs[q]
                    h[:] = 0
                    for a in range(k + 1):
                        _add_cross(h[:3], X[n, a, i], D[k - a, j], p)
                        if i != j:
                            _add_cross(h[:3], X[n, a, j], D[k - a, i], p)
                    if i == 0:
                        h[3:] = D[k, j]
                    for r in range(rows.size):
                        M[k, w, r, n, at] = (M[k, w, r, n, at] + h[rows[r]]) % p
    return M


@kernel
def _displaced(E, n, v, tau, p):
    """Points E (4, 3) at the reference pose, moved by a joint with the screw ``[n; v]``.

    It turns by the angle whose half has the tangent ``|n| τ``, so that
    ``R = 1 + 2 (τ n̂ + τ² n̂²) / (1 + τ² n²)``; or slides by ``τ v`` if n vanishes.
    """
    E[:] = 0
    E[1, 0] = E[2, 1] = E[3, 2] = 1
    square = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) % p * (tau * tau % p) % p
    if n[0] == 0 and n[1] == 0 and n[2] == 0:
        for c in range(3):
            E[0, c] = tau * v[c] % p
        return
    share = 2 * inverse(1 + square, p) % p
    once, twice = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for i in range(4):
        once[:] = 0
        twice[:] = 0
        if i:
            _add_cross(once, n, E[i], p)
        else:
            # The axis is at rest: its points r have r × n = v.
            once[:] = v
        _add_cross(twice, n, once, p)
        for c in range(3):
            more = (tau * once[c] + tau * tau % p * twice[c]) % p
            E[i, c] = (E[i, c] + share * more) % p


@kernel
def free_momentum(below, above, screws, steps, rates, pairs, rows, parameters, p):
    """Momentum of every slot of a tree at a finite pose with given rates.

    Args:
        below, above: slots that each joint connects, in an order away from slot 0 (e,).
        screws: at the reference pose (e, 6).
        steps: τ of each joint (e,); see `_displaced`.
        rates: of each joint (e,).
        pairs, rows, parameters: as for `momentum`.
        p: the prime.

    Returns:
        Shape (rows, slots, parameters).
    """
    slots = 1
    for e in range(below.size):
        slots = max(slots, above[e] + 1)
    X, V = np.zeros((slots, 1, 4, 3), np.int64), np.zeros((slots, 1, 1, 6), np.int64)
    E, s = np.zeros((4, 3), np.int64), np.zeros((1, 6), np.int64)
    X[0, 0, 1, 0] = X[0, 0, 2, 1] = X[0, 0, 3, 2] = 1
    for e in range(below.size):
        at, to = below[e], above[e]
        s[:] = 0
        _carried(s, X[at], screws[e], 0, p)
        for c in range(6):
            V[to, 0, 0, c] = (V[at, 0, 0, c] + s[0, c] * rates[e]) % p
        _displaced(E, screws[e, :3], screws[e, 3:], steps[e], p)
        for i in range(4):
            for c in range(3):
                total = X[at, 0, 0, c] if i == 0 else 0
                for a in range(3):
                    total = (total + X[at, 0, 1 + a, c] * E[i, a]) % p
                X[to, 0, i, c] = total
    return momentum(X, V, pairs, rows, parameters, p)[0, 0]
