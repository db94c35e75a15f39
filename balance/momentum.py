"""The momentum regressor as a power series: the compiled kernels of the masses.

The momentum of all bodies about the origin of the inertial frame, for a unit rate of
coordinate w, is linear in their inertial parameters: ``h_w = X_w z``. With the displacement
``H = [[R, d], [0, 1]]`` of a body, its column twist ``[ω; v]``, and

    e = v + ω × d        velocity of the body's origin,
    N = ω̂ R              rate of R,
    y = Rᵀ ω             angular velocity in body axes,

the momentum ``[ξ; p] = ∫ [ρ × ρ̇; ρ̇] dm`` of the points ``ρ = R r + d`` is

    p = m e + N mc,
    ξ = m (d × e) + Σ_c (R_c × e + d × N_c) mc_c + Σ_cb E_cb R_c y_b.

Every product is a Cauchy product of series; H itself follows from the twist along the ray,
``k H_k = Σ_{a<k} V̂_a H_{k-1-a}``. A body has the parameters ``[m, mcx, mcy, mcz, Exx, Eyy,
Ezz, Exy, Exz, Eyz]`` and the rows ``[ξ; p]``; in a plane ``[m, mcx, mcy, Ezz]`` and
``[ξz, px, py]``; for force balance only m, mc and p. (J. J. de Jong, PhD thesis, University
of Twente, chapter 5, writes the same regressor with adjoint matrices.)
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics.closure import Pose, Series, expand_at, forward
from kinematics.kernels import kernel
from kinematics.linkage import Chain, Linkage
from kinematics.pose import joint_positions, si_chain

__all__ = ["RegressorSeries", "momentum_regressor", "parameters_per_body", "rows_per_column"]

Array = NDArray[np.float64]


@kernel
def _add_cross(a, b, out):
    """Add ``a × b`` to ``out``."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@kernel
def _spatial(first, last, H, links, moves, V, T, R, d, y, N, e, X):
    """Regressor rows of orders first … last; lower orders of R … e must be in place.

    R and N hold the columns of their matrices: ``R[..., c, :]`` is column c. H holds the
    displacements of the links at the pose; it is empty at the reference pose, where
    ``R = 1, d = 0`` makes for simpler terms.
    """
    moved = H.shape[0] > 0
    rays, _, bodies = R.shape[:3]
    width = moves.shape[1]
    force = X.shape[3] == 3
    p = 0 if force else 3
    size = 4 if force else 10
    for ray in range(rays):
        for b in range(bodies):
            j = links[b]
            if j < 0:
                continue
            Rb, db = R[ray, :, b], d[ray, :, b]
            if first == 0:
                for i in range(3):
                    db[0, i] = H[j, i, 3] if moved else 0.0
                    for c in range(3):
                        Rb[0, c, i] = H[j, i, c] if moved else (1.0 if i == c else 0.0)
            for k in range(max(first, 1), last + 1):
                _displacement(k, V[ray, :, j], Rb, db)
            for w in range(width):
                if not moves[j, w]:
                    continue
                t = T[ray, :, j, w]
                yb, Nb, eb = y[ray, :, b, w], N[ray, :, b, w], e[ray, :, b, w]
                for k in range(first, last + 1):
                    x = X[k - first, ray, w, :, b * size : (b + 1) * size]
                    _velocity(k, moved, t, Rb, db, yb[k], Nb[k], eb[k])
                    for i in range(3):
                        x[p + i, 0] = eb[k, i]
                        for c in range(3):
                            x[p + i, 1 + c] = Nb[k, c, i]
                    if force:
                        continue
                    start = 0
                    if not moved:
                        _add_moments_at_rest(yb[k], eb[k], x)
                        start = 1
                    for a in range(start, k + 1):
                        _add_moments(Rb[a], db[a], yb[k - a], Nb[k - a], eb[k - a], x)


@kernel
def _displacement(k, V, R, d):
    """Order k of the displacement: ``k H_k = Σ_{a<k} V̂_a H_{k-1-a}``."""
    R[k] = 0.0
    d[k] = V[k - 1, 3:]
    for a in range(k):
        omega = V[a, :3]
        _add_cross(omega, d[k - 1 - a], d[k])
        for c in range(3):
            _add_cross(omega, R[k - 1 - a, c], R[k, c])
    for i in range(3):
        d[k, i] /= k
        for c in range(3):
            R[k, c, i] /= k


@kernel
def _velocity(k, moved, T, R, d, y, N, e):
    """Order k of ``y = Rᵀ ω``, ``N = ω̂ R`` and ``e = v + ω × d``."""
    start = 0 if moved else 1
    for i in range(3):
        e[i] = T[k, 3 + i]
        y[i] = 0.0 if moved else T[k, i]
        N[i, i] = 0.0
    w0, w1, w2 = (0.0, 0.0, 0.0) if moved else (T[k, 0], T[k, 1], T[k, 2])
    N[0, 1], N[1, 2], N[2, 0] = w2, w0, w1
    N[1, 0], N[2, 1], N[0, 2] = -w2, -w0, -w1
    for a in range(start, k + 1):
        w0, w1, w2 = T[k - a, 0], T[k - a, 1], T[k - a, 2]
        d0, d1, d2 = d[a, 0], d[a, 1], d[a, 2]
        e[0] += w1 * d2 - w2 * d1
        e[1] += w2 * d0 - w0 * d2
        e[2] += w0 * d1 - w1 * d0
        for c in range(3):
            r0, r1, r2 = R[a, c, 0], R[a, c, 1], R[a, c, 2]
            N[c, 0] += w1 * r2 - w2 * r1
            N[c, 1] += w2 * r0 - w0 * r2
            N[c, 2] += w0 * r1 - w1 * r0
            y[c] += w0 * r0 + w1 * r1 + w2 * r2


@kernel
def _add_moments_at_rest(y, e, x):
    """The term of the moment rows with ``R = 1`` and ``d = 0``."""
    x[1, 3] += e[0]
    x[2, 1] += e[1]
    x[0, 2] += e[2]
    x[2, 2] -= e[0]
    x[0, 3] -= e[1]
    x[1, 1] -= e[2]
    for i in range(3):
        x[i, 4 + i] += y[i]
    x[0, 7] += y[1]
    x[1, 7] += y[0]
    x[0, 8] += y[2]
    x[2, 8] += y[0]
    x[1, 9] += y[2]
    x[2, 9] += y[1]


@kernel
def _add_moments(R, d, y, N, e, x):
    """Add one term of the Cauchy products of the moment rows ξ."""
    y0, y1, y2 = y[0], y[1], y[2]
    for i in range(3):
        u, v = (i + 1) % 3, (i + 2) % 3
        du, dv, eu, ev = d[u], d[v], e[u], e[v]
        x[i, 0] += du * ev - dv * eu
        for c in range(3):
            x[i, 1 + c] += R[c, u] * ev - R[c, v] * eu + du * N[c, v] - dv * N[c, u]
        r0, r1, r2 = R[0, i], R[1, i], R[2, i]
        x[i, 4] += r0 * y0
        x[i, 5] += r1 * y1
        x[i, 6] += r2 * y2
        x[i, 7] += r0 * y1 + r1 * y0
        x[i, 8] += r0 * y2 + r2 * y0
        x[i, 9] += r1 * y2 + r2 * y1


@kernel
def _planar(first, last, H, links, moves, V, T, R, d, n, e, X):
    """Regressor rows of orders first … last in the plane; R is (cos, sin) and n = ω R."""
    rays, _, bodies = R.shape[:3]
    width = moves.shape[1]
    force = X.shape[3] == 2
    p = 0 if force else 1
    size = 3 if force else 4
    for ray in range(rays):
        for b in range(bodies):
            j = links[b]
            if j < 0:
                continue
            g, db = R[ray, :, b], d[ray, :, b]
            if first == 0:
                g[0, 0], g[0, 1], db[0, 0], db[0, 1] = 1.0, 0.0, 0.0, 0.0
                if H.shape[0] > 0:
                    g[0, 0], g[0, 1] = H[j, 0, 0], H[j, 1, 0]
                    db[0, 0], db[0, 1] = H[j, 0, 2], H[j, 1, 2]
            for k in range(max(first, 1), last + 1):
                gx = gy = 0.0
                dx, dy = V[ray, k - 1, j, 1], V[ray, k - 1, j, 2]
                for a in range(k):
                    omega = V[ray, a, j, 0]
                    gx -= omega * g[k - 1 - a, 1]
                    gy += omega * g[k - 1 - a, 0]
                    dx -= omega * db[k - 1 - a, 1]
                    dy += omega * db[k - 1 - a, 0]
                g[k, 0], g[k, 1] = gx / k, gy / k
                db[k, 0], db[k, 1] = dx / k, dy / k
            for w in range(width):
                if not moves[j, w]:
                    continue
                nb, eb = n[ray, :, b, w], e[ray, :, b, w]
                for k in range(first, last + 1):
                    nx = ny = 0.0
                    ex, ey = T[ray, k, j, w, 1], T[ray, k, j, w, 2]
                    for a in range(k + 1):
                        omega = T[ray, k - a, j, w, 0]
                        nx += omega * g[a, 0]
                        ny += omega * g[a, 1]
                        ex -= omega * db[a, 1]
                        ey += omega * db[a, 0]
                    nb[k, 0], nb[k, 1], eb[k, 0], eb[k, 1] = nx, ny, ex, ey
                    x = X[k - first, ray, w, :, b * size : (b + 1) * size]
                    x[p, 0], x[p, 1], x[p, 2] = ex, -ny, -nx
                    x[p + 1, 0], x[p + 1, 1], x[p + 1, 2] = ey, nx, -ny
                    if force:
                        continue
                    x[0, 3] = T[ray, k, j, w, 0]
                    for a in range(k + 1):
                        gx, gy, dx, dy = g[a, 0], g[a, 1], db[a, 0], db[a, 1]
                        ex, ey = eb[k - a, 0], eb[k - a, 1]
                        nx, ny = nb[k - a, 0], nb[k - a, 1]
                        x[0, 0] += dx * ey - dy * ex
                        x[0, 1] += gx * ey - gy * ex + dx * nx + dy * ny
                        x[0, 2] -= gx * ex + gy * ey + dx * ny - dy * nx


def parameters_per_body(planar: bool, force: bool) -> int:
    """Inertial parameters that count: 10, in a plane 4; for force balance 4, in a plane 3."""
    return (3 if force else 4) if planar else (4 if force else 10)


def rows_per_column(planar: bool, force: bool) -> int:
    """Momentum components that count: 6, in a plane 3; for force balance 3, in a plane 2."""
    return (2 if force else 3) if planar else (3 if force else 6)


class RegressorSeries:
    """The regressor of the total momentum, order by order, in the frame of the chain."""

    def __init__(
        self, chain: Chain, series: Series, force: bool = False, pose: Pose | None = None
    ) -> None:
        """Start at the reference pose, or at a finite pose with its own series."""
        self.chain, self.series, self.force = chain, series, force
        self._next = 0
        self._H = np.empty((0, 4, 4)) if pose is None else pose.H
        rays, orders = series.V.shape[:2]
        at, width = (rays, orders, chain.links.size), chain.width
        if chain.planar:
            shapes = (*at, 2), (*at, 2), (*at, width, 2), (*at, width, 2)
        else:
            rates = (*at, width, 3), (*at, width, 3, 3), (*at, width, 3)
            shapes = (*at, 3, 3), (*at, 3), *rates
        self._state = tuple(map(np.empty, shapes))

    def rows(self, last: int) -> Array:
        """Rows of the orders up to ``last`` that were not asked for before.

        Returns:
            Shape (orders, rays, width, rows per column, parameters).
        """
        chain, series, first = self.chain, self.series, self._next
        assert first <= last <= series.order
        self._next = last + 1
        columns = chain.links.size * parameters_per_body(chain.planar, self.force)
        rows = rows_per_column(chain.planar, self.force)
        X = np.zeros((last + 1 - first, len(series.V), chain.width, rows, columns))
        run = _planar if chain.planar else _spatial
        run(
            first, last, self._H, chain.links, chain.moves, series.V, series.T,
            *self._state, X,
        )  # fmt: skip
        return X


def momentum_regressor(
    linkage: Linkage, q: ArrayLike | Mapping[str, float], *, spatial: bool | None = None
) -> Array:
    """Regressor X of the total momentum at a finite pose: ``h = Σ_w u̇_w X[w] z``.

    Args:
        linkage: an assembled linkage.
        q: displacements from the reference pose, of all joints or of the inputs alone; see
            `kinematics.pose.joint_positions`.
        spatial: six rows and ten parameters per body; by default only if the linkage is
            not planar.

    Returns:
        Shape (mobility, 6, 10 bodies), rows ``[ξ; p]`` about the inertial origin in inertial
        axes; or (mobility, 3, 4 bodies), rows ``[ξz, px, py]`` in the axes of the plane.
        Parameters are those of the reference pose, as in `Body.inertia`; SI units.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.
    """
    chain = si_chain(linkage, not linkage.planar if spatial is None else spatial)
    pose = forward(chain, joint_positions(linkage, q)[chain.joints])
    return RegressorSeries(chain, expand_at(chain, pose), pose=pose).rows(0)[0, 0]
