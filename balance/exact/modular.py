"""Motion and momentum as power series over a prime field: the compiled kernels of exactness.

The recursions of motion and of momentum use sums, products, divisions by the order and one
linear system, so they run on remainders modulo a prime p as they do on rational numbers:

    V_j        = V_parent + s_j q̇_j
    k s_{j,k}  = Σ_{a<k} ad(V_{parent,a}) s_{j,k-1-a}
    S_0 C_k    = -Σ_{a≥1} S_a C_{k-a}            (each loop, A minus B)
    k H_k      = Σ_{a<k} V̂_a H_{k-1-a}
    N_w        = T̂_w H
    H P N_wᵀ - N_w P Hᵀ = -[[ξ̂_w, p_w], [-p_wᵀ, 0]]

with ``P = [[½tr(E)1 - E, mc], [mcᵀ, m]]``. Nothing is rounded, and a rank is the number of
pivots of an elimination. Primes below 2^30 leave room for eight products in 64 bits.
(J. J. de Jong, PhD thesis, University of Twente, chapters 4 and 5.)

All numbers are remainders ``0 … p - 1`` in 64-bit integers; screws and twists have six
components, angular first, in the inertial frame.
"""

from __future__ import annotations

import numpy as np

from kinematics.kernels import kernel

__all__ = ["PRIMES", "absorb", "eliminate", "fill_loop_matrix", "gather", "momentum", "series"]

PRIMES = (1073741789, 1073741783, 1073741741, 1073741723)
"""The largest primes below 2^30."""


@kernel
def _inverse(a, p):
    """Inverse of ``a`` by Fermat's theorem: ``a^(p-2)``."""
    result, base, exponent = 1, a % p, p - 2
    while exponent > 0:
        if exponent & 1:
            result = result * base % p
        base = base * base % p
        exponent >>= 1
    return result


@kernel
def eliminate(A, columns, p):
    """Gauss-Jordan elimination of the first columns of A in place; returns their rank."""
    rank = 0
    for c in range(columns):
        pivot = rank
        while pivot < A.shape[0] and A[pivot, c] == 0:
            pivot += 1
        if pivot == A.shape[0]:
            continue
        factor = _inverse(A[pivot, c], p)
        for j in range(A.shape[1]):
            value = A[pivot, j]
            A[pivot, j] = A[rank, j]
            A[rank, j] = value * factor % p
        for i in range(A.shape[0]):
            factor = A[i, c]
            if i != rank and factor != 0:
                for j in range(A.shape[1]):
                    A[i, j] = (A[i, j] + (p - factor) * A[rank, j]) % p
        rank += 1
    return rank


@kernel
def _add_bracket(V, s, p, out):
    """Add ``ad(V) s`` to ``out``."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turn = V[j] * s[k] + (p - V[k]) * s[j]
        shift = V[3 + j] * s[k] + (p - V[3 + k]) * s[j]
        shift += V[j] * s[3 + k] + (p - V[k]) * s[3 + j]
        out[i] = (out[i] + turn) % p
        out[3 + i] = (out[3 + i] + shift) % p


@kernel
def fill_loop_matrix(parent, screws, ends, mimics, dependent, p, A):
    """Columns of the dependent joints, and a unit matrix beside them.

    The rows are those of the loops, A minus B, and below them the mimic relations.
    """
    A[:] = 0
    for row in range(A.shape[0]):
        A[row, dependent.size + row] = 1
    for loop in range(ends.shape[0]):
        for side in range(2):
            j = ends[loop, side]
            while j >= 0:
                for c in range(dependent.size):
                    if dependent[c] == j:
                        for i in range(6):
                            value = screws[j, i] if side == 0 else p - screws[j, i]
                            A[loop * 6 + i, c] = (A[loop * 6 + i, c] + value) % p
                j = parent[j]
    base = ends.shape[0] * 6
    for row in range(mimics.shape[0]):
        for c in range(dependent.size):
            A[base + row, c] = mimics[row, dependent[c]]


@kernel
def series(parent, screws, ends, mimics, dependent, columns, rays, order, p):
    """Twists of all links as series along rays ``u = t δ``, to an order, modulo p.

    Args:
        parent: link before each joint, -1 for the ground (n,).
        screws: joint screws at the reference pose, of any length (n, 6).
        ends: the two links welded by each loop (loops, 2).
        mimics: linear relations between joint rates (g, n).
        dependent: joints whose rates follow from the loops (d,).
        columns: rates of the other joints for each column (n, w); zero for dependent ones.
        rays: directions δ (rays, w).
        order: highest order.
        p: the prime.

    Returns:
        Twists V along the rays (rays, order + 1, n, 6); twists T for unit rates
        (rays, order + 1, n, w, 6); and the number of orders, from 0, at which all loops
        close, or -1 if the screws of the dependent joints are dependent modulo p.
    """
    n, width = columns.shape
    loops, nd = ends.shape[0], dependent.size
    rows = 6 * loops + mimics.shape[0]
    A = np.empty((rows, nd + rows), np.int64)
    fill_loop_matrix(parent, screws, ends, mimics, dependent, p, A)
    regular = eliminate(A, nd, p) == nd
    S = np.zeros((order + 1, n, 6), np.int64)
    V = np.zeros((rays.shape[0], order + 1, n, 6), np.int64)
    C = np.zeros((order + 1, n, width), np.int64)
    T = np.zeros((rays.shape[0], order + 1, n, width, 6), np.int64)
    b = np.zeros(rows, np.int64)
    extra = np.zeros((n, 6), np.int64)
    closed = order + 1 if regular else -1
    for ray in range(rays.shape[0]):
        v = V[ray]
        C[:] = 0
        S[:] = 0
        for k in range(order + 1):
            if not regular:
                break
            for j in range(n):
                if k == 0:
                    for i in range(6):
                        S[0, j, i] = screws[j, i]
                elif parent[j] >= 0:
                    for a in range(k):
                        _add_bracket(v[a, parent[j]], S[k - 1 - a, j], p, S[k, j])
            if k > 0:
                factor = _inverse(k, p)
                for j in range(n):
                    for i in range(6):
                        S[k, j, i] = S[k, j, i] * factor % p
            for w in range(width):
                t = T[ray, k, :, w]
                for j in range(n):
                    # Order k of the twists, without the rates of order k.
                    if k == 0:
                        C[0, j, w] = columns[j, w]
                    for i in range(6):
                        total = t[parent[j], i] if parent[j] >= 0 else 0
                        for a in range(min(k, 1), k + 1):
                            total = (total + S[a, j, i] * C[k - a, j, w]) % p
                        t[j, i] = total
                # Their mismatch at the welds gives those rates.
                for loop in range(loops):
                    e, f = ends[loop, 0], ends[loop, 1]
                    for i in range(6):
                        there = t[f, i] if f >= 0 else 0
                        here = t[e, i] if e >= 0 else 0
                        b[loop * 6 + i] = (there + p - here) % p
                for row in range(mimics.shape[0]):
                    b[loops * 6 + row] = 0
                    if k == 0:
                        for j in range(n):
                            m = mimics[row, j] * columns[j, w] % p
                            b[loops * 6 + row] = (b[loops * 6 + row] + p - m) % p
                for i in range(rows):
                    total = 0
                    for r in range(rows):
                        total = (total + A[i, nd + r] * b[r]) % p
                    if i < nd:
                        C[k, dependent[i], w] = total
                    elif total != 0:
                        closed = min(closed, k)
                for j in range(n):
                    rate = C[k, j, w]
                    if k == 0:
                        rate = (rate + p - columns[j, w]) % p
                    for i in range(6):
                        carried = extra[parent[j], i] if parent[j] >= 0 else 0
                        extra[j, i] = (carried + screws[j, i] * rate) % p
                        t[j, i] = (t[j, i] + extra[j, i]) % p
                        v[k, j, i] = (v[k, j, i] + t[j, i] * rays[ray, w]) % p
    return V, T, closed


@kernel
def _times_twist(t, A, p, out):
    """Add ``[ω × R, ω × d]`` to ``out`` (3, 4), for a twist t and ``A = [R, d]``."""
    for c in range(4):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            total = t[j] * A[k, c] + (p - t[k]) * A[j, c]
            out[i, c] = (out[i, c] + total) % p


@kernel
def momentum(links, V, T, p):
    """Regressor of the momentum of all bodies along rays, from the twists of `series`.

    Returns remainders (rays, orders, w, 6, 10 bodies): rows ``[ξ; p]``, and for each body the
    parameters ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]``.
    """
    rays, orders, _, width, _ = T.shape
    X = np.zeros((rays, orders, width, 6, 10 * links.size), np.int64)
    H = np.zeros((orders, 3, 4), np.int64)
    N = np.zeros((orders, 3, 4), np.int64)
    for ray in range(rays):
        for body in range(links.size):
            j = links[body]
            H[:] = 0
            for i in range(3):
                H[0, i, i] = 1
            for k in range(1, orders):
                for a in range(k):
                    _times_twist(V[ray, a, j], H[k - 1 - a], p, H[k])
                factor = _inverse(k, p)
                for i in range(3):
                    H[k, i, 3] = (H[k, i, 3] + V[ray, k - 1, j, 3 + i]) % p
                    for c in range(4):
                        H[k, i, c] = H[k, i, c] * factor % p
            for w in range(width):
                N[:] = 0
                for k in range(orders):
                    for i in range(3):
                        N[k, i, 3] = T[ray, k, j, w, 3 + i]
                    for a in range(k + 1):
                        _times_twist(T[ray, a, j, w], H[k - a], p, N[k])
                    x = X[ray, k, w, :, 10 * body : 10 * body + 10]
                    _linear(N[k], x)
                    for a in range(k + 1):
                        _angular(H[a], N[k - a], p, x)
                    _to_tensor(p, x)
    return X


@kernel
def _linear(N, x):
    """Rows p: the last column of ``N P``."""
    for i in range(3):
        x[3 + i, 0] = N[i, 3]
        for c in range(3):
            x[3 + i, 1 + c] = N[i, c]


@kernel
def _angular(H, N, p, x):
    """Add one product of orders to the rows ξ of ``N P Hᵀ - H P Nᵀ``, by entries of P.

    Columns: m, mc, then the second moments Σxx, Σyy, Σzz, Σxy, Σxz, Σyz.
    """
    for i in range(3):
        # ξ_i = (H P Nᵀ)[j, k] - (H P Nᵀ)[k, j]
        j, k = (i + 1) % 3, (i + 2) % 3
        for a in range(4):
            for b in range(a, 4):
                total = H[j, a] * N[k, b] + (p - H[k, a]) * N[j, b]
                if a != b:
                    total += H[j, b] * N[k, a] + (p - H[k, b]) * N[j, a]
                if b < 3:
                    column = 4 + a if a == b else 6 + a + b
                else:
                    column = 1 + a if a < 3 else 0
                x[i, column] = (x[i, column] + total) % p


@kernel
def _to_tensor(p, x):
    """Columns of the second moments ``Σ = ½tr(E)1 - E`` turned into those of E."""
    half = (p + 1) // 2
    for i in range(3):
        a, b, c = x[i, 4], x[i, 5], x[i, 6]
        x[i, 4] = (b + c + p - a) * half % p
        x[i, 5] = (c + a + p - b) * half % p
        x[i, 6] = (a + b + p - c) * half % p
        for column in range(7, 10):
            x[i, column] = (p - x[i, column]) % p


@kernel
def absorb(row, echelon, pivots, rank, p):
    """Reduce ``row`` in place by ``rank`` rows of an echelon; append it unless it vanishes."""
    columns = row.size
    for r in range(rank):
        factor = row[pivots[r]]
        if factor != 0:
            for c in range(pivots[r], columns):
                row[c] = (row[c] + (p - factor) * echelon[r, c]) % p
    for c in range(columns):
        if row[c] != 0:
            factor = _inverse(row[c], p)
            for d in range(columns):
                echelon[rank, d] = row[d] * factor % p
            pivots[rank] = c
            return True
    return False


@kernel
def gather(X, spanning, p):
    """Ranks of the conditions up to each order, along as many rays as it takes.

    Args:
        X: rows (orders, rays, rows, columns), overwritten.
        spanning: number of rays that span all derivatives of each order (orders,).
        p: the prime.

    Returns:
        The rank after each order; order, ray, row and column of each pivot (rank, 4); and
        whether there were enough rays: an order is complete once another ray adds nothing.
    """
    orders, rays, rows, columns = X.shape
    echelon = np.zeros((min(columns, orders * rays * rows), columns), np.int64)
    pivots = np.zeros(len(echelon), np.int64)
    found = np.zeros((len(echelon), 4), np.int64)
    ranks = np.zeros(orders, np.int64)
    rank, enough = 0, True
    for k in range(orders):
        complete = False
        for ray in range(rays):
            before = rank
            for r in range(rows):
                if rank < len(echelon) and absorb(X[k, ray, r], echelon, pivots, rank, p):
                    found[rank, 0], found[rank, 1] = k, ray
                    found[rank, 2], found[rank, 3] = r, pivots[rank]
                    rank += 1
            complete = rank == before or ray + 1 >= spanning[k] or rank == columns
            if complete:
                break
        enough = enough and complete
        ranks[k] = rank
    return ranks, found[:rank], enough
