"""The planar momentum regressor of many geometries side by side, one in each lane: a kernel.

Formulas and symbols are those of `balance.space.momentum.regressor`, for one coordinate. The
last axis of every array is that of the lanes.
"""

from __future__ import annotations

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import broadcast, load_vector, store_vector


@kernel(reference_counting=False)
def _displace(first, last, j, start, T, h):
    """Compute ``k H_k = Σ_a ω_a i H_{k-1-a} + V_{k-1}`` of a link, with i a quarter turn.

    Args:
        first: lowest order.
        last: highest order.
        start: in: displacements of the links (n, 4, lanes): cosine, sine, x, y; or none.
        T: in: link twists (orders, n, 3, lanes).
        h: in, out: of this link (orders, 4, lanes).
    """
    if first == 0:
        for i in range(4):
            value = broadcast(1.0 if i == 0 else 0.0)
            store_vector(h[0, i], 0, load_vector(start[j, i], 0) if start.size else value)
    for k in range(max(first, 1), last + 1):
        gx, gy, part = broadcast(0.0), broadcast(0.0), broadcast(1.0 / k)
        dx, dy = load_vector(T[k - 1, j, 1], 0), load_vector(T[k - 1, j, 2], 0)
        for a in range(k):
            omega, before = load_vector(T[a, j, 0], 0), h[k - 1 - a]
            gx = gx - omega * load_vector(before[1], 0)
            gy = gy + omega * load_vector(before[0], 0)
            dx = dx - omega * load_vector(before[3], 0)
            dy = dy + omega * load_vector(before[2], 0)
        store_vector(h[k, 0], 0, part * gx)
        store_vector(h[k, 1], 0, part * gy)
        store_vector(h[k, 2], 0, part * dx)
        store_vector(h[k, 3], 0, part * dy)


@kernel(reference_counting=False)
def _put_angular(k, h, n, x, turn):
    """Write the row of the angular momentum of one body, order k: Cauchy products of H and N.

    Args:
        k: the order.
        h: in: displacements (orders, 4, lanes).
        n: in: their rates (orders, 4, lanes).
        x: out: the entries of the body (4, lanes).
        turn: in: angular velocity of order k (lanes,).
    """
    m, u, v = broadcast(0.0), broadcast(0.0), broadcast(0.0)
    for a in range(k + 1):
        gx, gy = load_vector(h[a, 0], 0), load_vector(h[a, 1], 0)
        dx, dy = load_vector(h[a, 2], 0), load_vector(h[a, 3], 0)
        nx, ny = load_vector(n[k - a, 0], 0), load_vector(n[k - a, 1], 0)
        ex, ey = load_vector(n[k - a, 2], 0), load_vector(n[k - a, 3], 0)
        m = m + dx * ey - dy * ex
        u = u + gx * ey - gy * ex + dx * ny - dy * nx
        v = v + dx * nx + dy * ny - gx * ex - gy * ey
    store_vector(x[0], 0, m)
    store_vector(x[1], 0, u)
    store_vector(x[2], 0, v)
    store_vector(x[3], 0, load_vector(turn, 0))


@kernel(reference_counting=False)
def lane_regressor(first, last, start, links, moves, T, H, N, X):
    """Write the rows of orders first … last, of all bodies that move.

    Args:
        first: lowest order; H and N hold those below.
        last: highest order.
        start: in: displacements of the links (n, 4, lanes): cosine, sine, x, y; or none.
        links: in: link of each body (bodies,).
        moves: in: whether the column moves a link (n, 1).
        T: in: link twists (orders, n, 3, lanes).
        H: in, out: (bodies, orders, 4, lanes).
        N: in, out: (bodies, orders, 4, lanes).
        X: out: rows (orders, 3 or 2, bodies, 4 or 3, lanes); entries that are always 0 are
            not written.
    """
    force = X.shape[1] == 2
    p = 0 if force else 1
    for b in range(links.size):
        j, h, n = links[b], H[b], N[b]
        if j < 0 or not moves[j, 0]:
            continue
        _displace(first, last, j, start, T, h)
        # N_k = Σ_a ω_{k-a} i H_a + T_k
        for k in range(first, last + 1):
            nx, ny = broadcast(0.0), broadcast(0.0)
            ex, ey = load_vector(T[k, j, 1], 0), load_vector(T[k, j, 2], 0)
            for a in range(k + 1):
                omega = load_vector(T[k - a, j, 0], 0)
                nx = nx - omega * load_vector(h[a, 1], 0)
                ny = ny + omega * load_vector(h[a, 0], 0)
                ex = ex - omega * load_vector(h[a, 3], 0)
                ey = ey + omega * load_vector(h[a, 2], 0)
            store_vector(n[k, 0], 0, nx)
            store_vector(n[k, 1], 0, ny)
            store_vector(n[k, 2], 0, ex)
            store_vector(n[k, 3], 0, ey)
            x, y = X[k, p, b], X[k, p + 1, b]
            store_vector(x[0], 0, ex)
            store_vector(x[1], 0, nx)
            store_vector(x[2], 0, broadcast(0.0) - ny)
            store_vector(y[0], 0, ey)
            store_vector(y[1], 0, ny)
            store_vector(y[2], 0, nx)
            if not force:
                _put_angular(k, h, n, X[k, 0, b], T[k, j, 0])
