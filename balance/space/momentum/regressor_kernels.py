"""The rows of the momentum regressor, order by order: compiled kernels.

The formulas are in `balance.space.momentum.regressor`.
"""

from __future__ import annotations

import numpy as np

from kinematics.model.spatial.screws import skew
from kinematics.numerics.compiled.jit import kernel


def _spatial_regressor_by_arrays(first, last, begin, end, start, links, moves, V, T, H, N, X):
    """Add rows as `spatial_regressor` does: those of all bodies and columns at once."""
    bodies = np.flatnonzero(links >= 0)
    joints, p = links[bodies], X.shape[3] - 3
    pose = start[joints, :3].swapaxes(1, 2) if len(start) else np.eye(4, 3)
    for ray in range(begin, end):
        h, n = H[ray, bodies], N[ray, bodies]
        v, t = V[ray, : last + 1, joints], T[ray, : last + 1, joints]
        # ω × of the columns in h, which are rows there, is a product with -ω̂ from the right.
        along, turns = skew(v[..., :3]), skew(t[..., :3])
        for k in range(first, last + 1):
            h[:, k] = 0.0 if k else pose
            for a in range(k):
                h[:, k] -= h[:, k - 1 - a] @ along[:, a] / k
            if k:
                h[:, k, 3] += v[:, k - 1, 3:] / k
            n[:, :, k] = 0.0
            n[:, :, k, 3] = t[:, k, :, 3:]
            for a in range(k + 1):
                n[:, :, k, :4] -= h[:, None, a] @ turns[:, k - a]
                n[:, :, k, 4] += t[:, k - a, :, :3] @ h[:, a, :3].swapaxes(1, 2)
            x = np.zeros((*n.shape[:2], *X.shape[3::2]))
            x[:, :, p:, :4] = n[:, :, k, [3, 0, 1, 2]].swapaxes(2, 3)
            for a in range(k + 1 if p else 0):
                _add_moments_by_arrays(h[:, a], n[:, :, k - a], x)
            X[k - first, ray][:, :, bodies] = x.transpose(1, 2, 0, 3)
        H[ray, bodies], N[ray, bodies] = h, n


def _add_moments_by_arrays(h, n, x):
    """Add one term of the moment rows ξ as `_add_moments` does.

    Args:
        h: in: an order of the displacements (bodies, 4, 3).
        n: in: an order of their rates (bodies, width, 5, 3).
        x: in, out: rows ``[ξ; p]`` (bodies, width, 6, 10).
    """
    arms, y = skew(h), n[:, :, 4, None]
    moments = np.einsum("bcij,bwj->bwic", arms, n[:, :, 3])
    moments[..., :3] -= (n[:, :, :3] @ arms[:, None, 3]).swapaxes(2, 3)
    x[:, :, :3, :4] += moments[..., [3, 0, 1, 2]]
    for place, (c, d) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)), 4):
        x[:, :, :3, place] += h[:, None, c] * y[..., d]
        if c != d:
            x[:, :, :3, place] += h[:, None, d] * y[..., c]


@kernel(reference_counting=False, uncompiled=_spatial_regressor_by_arrays)
def spatial_regressor(first, last, begin, end, start, links, moves, V, T, H, N, X):
    """Add the regressor rows of orders first … last; see `balance.space.momentum.regressor`.

    At the reference pose ``R = 1, d = 0`` makes for simpler terms.

    Args:
        first: lowest order; H and N hold those below.
        last: highest order.
        begin: the first ray.
        end: the ray after the last one.
        start: in: displacements of the links at the pose (n, 4, 4), or none of them.
        links: in: link of each body (bodies,).
        moves: in: whether a column moves a link (n, width).
        V: in: link twists along the rays (rays, orders, n, 6).
        T: in: link twists of the columns (rays, orders, n, width, 6).
        H: in, out: columns of ``[R, d]`` (rays, bodies, orders, 4, 3).
        N: in, out: columns of ``[ω̂ R, e]``, and y (rays, bodies, width, orders, 5, 3).
        X: in, out: rows (orders from first, rays, width, 6 or 3, bodies, 10 or 4), zeros.
    """
    bodies = H.shape[1]
    moved = start.shape[0] > 0
    width = moves.shape[1]
    force = X.shape[3] == 3
    p = 0 if force else 3
    for ray in range(begin, end):
        for b in range(bodies):
            j = links[b]
            if j < 0:
                continue
            h = H[ray, b]
            # H_0 is the displacement of the body at the pose.
            if first == 0:
                for c in range(4):
                    for i in range(3):
                        h[0, c, i] = start[j, i, c] if moved else (1.0 if i == c else 0.0)
            for k in range(max(first, 1), last + 1):
                _displacement(k, j, V[ray], h)
            for w in range(width):
                if not moves[j, w]:
                    continue
                n = N[ray, b, w]
                for k in range(first, last + 1):
                    x = X[k - first, ray, w]
                    # p_k = m e_k + N_k mc, and ξ_k = Σ_a of products of H_a and N_{k-a}
                    _velocity(k, moved, j, w, T[ray], h, n[k])
                    for i in range(3):
                        x[p + i, b, 0] = n[k, 3, i]
                        for c in range(3):
                            x[p + i, b, 1 + c] = n[k, c, i]
                    if force:
                        continue
                    if not moved:
                        _add_moments_at_rest(n[k], x, b)
                    for a in range(0 if moved else 1, k + 1):
                        _add_moments(h[a], n[k - a], x, b)


@kernel(inline=True, reference_counting=False)
def _displacement(k, j, V, H):
    """Compute order k of a displacement: ``k H_k = Σ_{a<k} V̂_a H_{k-1-a}``.

    Args:
        k: the order, ≥ 1.
        V: in: link twists (orders, n, 6).
        H: in, out: columns of ``[R, d]`` (orders, 4, 3).
    """
    for i in range(3):
        H[k, 0, i] = H[k, 1, i] = H[k, 2, i] = 0.0
        H[k, 3, i] = V[k - 1, j, 3 + i]
    for a in range(k):
        w0, w1, w2 = V[a, j, 0], V[a, j, 1], V[a, j, 2]
        for c in range(4):
            h0, h1, h2 = H[k - 1 - a, c, 0], H[k - 1 - a, c, 1], H[k - 1 - a, c, 2]
            H[k, c, 0] += w1 * h2 - w2 * h1
            H[k, c, 1] += w2 * h0 - w0 * h2
            H[k, c, 2] += w0 * h1 - w1 * h0
    for c in range(4):
        for i in range(3):
            H[k, c, i] /= k


@kernel(inline=True, reference_counting=False)
def _velocity(k, moved, j, w, T, H, N):
    """Compute order k of the rate of a displacement, and of y: ``N_k = Σ_a T̂_{k-a} H_a``.

    Args:
        k: the order.
        moved: whether H_0 is another displacement than none.
        w: the column.
        T: in: link twists of the columns (orders, n, width, 6).
        H: in: columns of ``[R, d]`` (orders, 4, 3).
        N: out: columns of ``[ω̂ R, e]``, and ``y = Rᵀ ω`` (5, 3).
    """
    t = T[k, j, w]
    w0, w1, w2 = (0.0, 0.0, 0.0) if moved else (t[0], t[1], t[2])
    N[0, 0], N[0, 1], N[0, 2] = 0.0, w2, -w1
    N[1, 0], N[1, 1], N[1, 2] = -w2, 0.0, w0
    N[2, 0], N[2, 1], N[2, 2] = w1, -w0, 0.0
    N[3, 0], N[3, 1], N[3, 2] = t[3], t[4], t[5]
    N[4, 0], N[4, 1], N[4, 2] = w0, w1, w2
    for a in range(0 if moved else 1, k + 1):
        t = T[k - a, j, w]
        w0, w1, w2 = t[0], t[1], t[2]
        for c in range(4):
            h0, h1, h2 = H[a, c, 0], H[a, c, 1], H[a, c, 2]
            N[c, 0] += w1 * h2 - w2 * h1
            N[c, 1] += w2 * h0 - w0 * h2
            N[c, 2] += w0 * h1 - w1 * h0
            if c < 3:
                N[4, c] += w0 * h0 + w1 * h1 + w2 * h2


@kernel(inline=True, reference_counting=False)
def _add_moments_at_rest(N, x, b):
    """Add the term of the moment rows ξ with ``R = 1`` and ``d = 0``.

    Args:
        N: in: as from `_velocity` (5, 3).
        x: in, out: rows ``[ξ; p]`` (6, bodies, 10).
    """
    e, y = N[3], N[4]
    x[1, b, 3] += e[0]
    x[2, b, 1] += e[1]
    x[0, b, 2] += e[2]
    x[2, b, 2] -= e[0]
    x[0, b, 3] -= e[1]
    x[1, b, 1] -= e[2]
    for i in range(3):
        x[i, b, 4 + i] += y[i]
    x[0, b, 7] += y[1]
    x[1, b, 7] += y[0]
    x[0, b, 8] += y[2]
    x[2, b, 8] += y[0]
    x[1, b, 9] += y[2]
    x[2, b, 9] += y[1]


@kernel(inline=True, reference_counting=False)
def _add_moments(H, N, x, b):
    """Add one term of the Cauchy products of the moment rows ξ.

    Args:
        H: in: an order of the displacement (4, 3).
        N: in: an order of its rate, as from `_velocity` (5, 3).
        x: in, out: rows ``[ξ; p]`` (6, bodies, 10).
    """
    y0, y1, y2 = N[4, 0], N[4, 1], N[4, 2]
    for i in range(3):
        u, v = (i + 1) % 3, (i + 2) % 3
        du, dv, eu, ev = H[3, u], H[3, v], N[3, u], N[3, v]
        x[i, b, 0] += du * ev - dv * eu
        for c in range(3):
            x[i, b, 1 + c] += H[c, u] * ev - H[c, v] * eu + du * N[c, v] - dv * N[c, u]
        r0, r1, r2 = H[0, i], H[1, i], H[2, i]
        x[i, b, 4] += r0 * y0
        x[i, b, 5] += r1 * y1
        x[i, b, 6] += r2 * y2
        x[i, b, 7] += r0 * y1 + r1 * y0
        x[i, b, 8] += r0 * y2 + r2 * y0
        x[i, b, 9] += r1 * y2 + r2 * y1


@kernel(reference_counting=False)
def planar_regressor(first, last, begin, end, start, links, moves, V, T, H, N, X):
    """Add the regressor rows of orders first … last in the plane; as `spatial_regressor`.

    H is ``(cos, sin, d_x, d_y)``, and N is its rate.

    Args:
        first: lowest order; H and N hold those below.
        last: highest order.
        begin: the first ray.
        end: the ray after the last one.
        start: in: displacements of the links (n, 3, 3), or none of them.
        links: in: link of each body (bodies,).
        moves: in: whether a column moves a link (n, width).
        V: in: link twists along the rays (rays, orders, n, 3).
        T: in: link twists of the columns (rays, orders, n, width, 3).
        H: in, out: (rays, bodies, orders, 4).
        N: in, out: (rays, bodies, width, orders, 4).
        X: in, out: rows (orders from first, rays, width, 3 or 2, bodies, 4 or 3), zeros.
    """
    bodies = H.shape[1]
    width = moves.shape[1]
    force = X.shape[3] == 2
    p = 0 if force else 1
    for ray in range(begin, end):
        for b in range(bodies):
            j = links[b]
            if j < 0:
                continue
            h = H[ray, b]
            if first == 0:
                h[0, 0], h[0, 1], h[0, 2], h[0, 3] = 1.0, 0.0, 0.0, 0.0
                if start.shape[0] > 0:
                    h[0, 0], h[0, 1] = start[j, 0, 0], start[j, 1, 0]
                    h[0, 2], h[0, 3] = start[j, 0, 2], start[j, 1, 2]
            # k H_k = Σ_a ω_a i H_{k-1-a} + V_{k-1}, with i a quarter turn.
            for k in range(max(first, 1), last + 1):
                gx = gy = 0.0
                dx, dy = V[ray, k - 1, j, 1], V[ray, k - 1, j, 2]
                for a in range(k):
                    omega = V[ray, a, j, 0]
                    gx -= omega * h[k - 1 - a, 1]
                    gy += omega * h[k - 1 - a, 0]
                    dx -= omega * h[k - 1 - a, 3]
                    dy += omega * h[k - 1 - a, 2]
                h[k, 0], h[k, 1], h[k, 2], h[k, 3] = gx / k, gy / k, dx / k, dy / k
            for w in range(width):
                if not moves[j, w]:
                    continue
                n = N[ray, b, w]
                # N_k = Σ_a ω_{k-a} i H_a + T_k
                for k in range(first, last + 1):
                    nx = ny = 0.0
                    ex, ey = T[ray, k, j, w, 1], T[ray, k, j, w, 2]
                    for a in range(k + 1):
                        omega = T[ray, k - a, j, w, 0]
                        nx -= omega * h[a, 1]
                        ny += omega * h[a, 0]
                        ex -= omega * h[a, 3]
                        ey += omega * h[a, 2]
                    n[k, 0], n[k, 1], n[k, 2], n[k, 3] = nx, ny, ex, ey
                    x = X[k - first, ray, w]
                    x[p, b, 0], x[p, b, 1], x[p, b, 2] = ex, nx, -ny
                    x[p + 1, b, 0], x[p + 1, b, 1], x[p + 1, b, 2] = ey, ny, nx
                    if force:
                        continue
                    x[0, b, 3] = T[ray, k, j, w, 0]
                    for a in range(k + 1):
                        gx, gy, dx, dy = h[a, 0], h[a, 1], h[a, 2], h[a, 3]
                        nx, ny, ex, ey = n[k - a, 0], n[k - a, 1], n[k - a, 2], n[k - a, 3]
                        x[0, b, 0] += dx * ey - dy * ex
                        x[0, b, 1] += gx * ey - gy * ex + dx * ny - dy * nx
                        x[0, b, 2] += dx * nx + dy * ny - gx * ex - gy * ey
