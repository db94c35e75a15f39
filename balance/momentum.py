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
def _spatial(k, links, moves, V, T, R, d, y, N, e, X):
    """Regressor rows of order k; lower orders of R, d, y, N, e must be in place.

    R and N hold the columns of their matrices: ``R[..., c, :]`` is column c.
    """
    rays, _, bodies = R.shape[:3]
    width = moves.shape[1]
    force = X.shape[2] == 3
    p = 0 if force else 3
    size = 4 if force else 10
    for ray in range(rays):
        for b in range(bodies):
            j = links[b]
            if j < 0:
                continue
            Rb, db = R[ray, :, b], d[ray, :, b]
            if k > 0:
                Rb[k] = 0.0
                db[k] = V[ray, k - 1, j, 3:]
                for a in range(k):
                    omega = V[ray, a, j, :3]
                    _add_cross(omega, db[k - 1 - a], db[k])
                    for c in range(3):
                        _add_cross(omega, Rb[k - 1 - a, c], Rb[k, c])
                db[k] /= k
                Rb[k] /= k
            for w in range(width):
                if not moves[j, w]:
                    continue
                yb, Nb, eb = y[ray, :, b, w], N[ray, :, b, w], e[ray, :, b, w]
                x = X[ray, w, :, b * size : (b + 1) * size]
                yb[k] = 0.0
                Nb[k] = 0.0
                eb[k] = T[ray, k, j, w, 3:]
                for a in range(k + 1):
                    omega = T[ray, k - a, j, w, :3]
                    _add_cross(omega, db[a], eb[k])
                    for c in range(3):
                        _add_cross(omega, Rb[a, c], Nb[k, c])
                        yb[k, c] += (
                            Rb[a, c, 0] * omega[0] + Rb[a, c, 1] * omega[1] + Rb[a, c, 2] * omega[2]
                        )
                for i in range(3):
                    x[p + i, 0] = eb[k, i]
                    for c in range(3):
                        x[p + i, 1 + c] = Nb[k, c, i]
                if force:
                    continue
                for a in range(k + 1):
                    _add_moments(Rb[a], db[a], yb[k - a], Nb[k - a], eb[k - a], x)


@kernel
def _add_moments(R, d, y, N, e, x):
    """Add one term of the Cauchy products of the moment rows ξ."""
    for i in range(3):
        u, v = (i + 1) % 3, (i + 2) % 3
        x[i, 0] += d[u] * e[v] - d[v] * e[u]
        for c in range(3):
            x[i, 1 + c] += (
                R[c, u] * e[v] - R[c, v] * e[u] + d[u] * N[c, v] - d[v] * N[c, u]
            )
            x[i, 4 + c] += R[c, i] * y[c]
        x[i, 7] += R[0, i] * y[1] + R[1, i] * y[0]
        x[i, 8] += R[0, i] * y[2] + R[2, i] * y[0]
        x[i, 9] += R[1, i] * y[2] + R[2, i] * y[1]


@kernel
def _planar(k, links, moves, V, T, R, d, n, e, X):
    """Regressor rows of order k in the plane; R is (cos, sin) and n = ω R."""
    rays, _, bodies = R.shape[:3]
    width = moves.shape[1]
    force = X.shape[2] == 2
    p = 0 if force else 1
    size = 3 if force else 4
    for ray in range(rays):
        for b in range(bodies):
            j = links[b]
            if j < 0:
                continue
            g, db = R[ray, :, b], d[ray, :, b]
            if k > 0:
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
                nx = ny = 0.0
                ex, ey = T[ray, k, j, w, 1], T[ray, k, j, w, 2]
                for a in range(k + 1):
                    omega = T[ray, k - a, j, w, 0]
                    nx += omega * g[a, 0]
                    ny += omega * g[a, 1]
                    ex -= omega * db[a, 1]
                    ey += omega * db[a, 0]
                nb[k, 0], nb[k, 1], eb[k, 0], eb[k, 1] = nx, ny, ex, ey
                x = X[ray, w, :, b * size : (b + 1) * size]
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
        rays, orders = series.V.shape[:2]
        bodies, width = chain.links.size, chain.width
        shape = (rays, orders, bodies)
        if chain.planar:
            self._R, self._d = np.empty((*shape, 2)), np.empty((*shape, 2))
            self._state = [np.empty((*shape, width, 2)) for _ in range(2)]
            self._R[:, 0], self._d[:, 0] = (1.0, 0.0), 0.0
        else:
            self._R, self._d = np.empty((*shape, 3, 3)), np.empty((*shape, 3))
            self._state = [np.empty((*shape, width, *s)) for s in ((3,), (3, 3), (3,))]
            self._R[:, 0], self._d[:, 0] = np.eye(3), 0.0
        if pose is not None:
            for b, link in enumerate(chain.links):
                if link >= 0:
                    H = pose.H[link]
                    self._R[:, 0, b] = H[:2, 0] if chain.planar else H[:3, :3].T
                    self._d[:, 0, b] = H[:-1, -1]
        self._next = 0

    def rows(self, order: int) -> Array:
        """Rows of one order; orders must be asked for one after another, from 0.

        Returns:
            Shape (rays, width, rows per column, parameters).
        """
        assert order == self._next
        self._next += 1
        chain, series = self.chain, self.series
        planar = chain.planar
        X = np.zeros((
            len(series.V), chain.width, rows_per_column(planar, self.force),
            chain.links.size * parameters_per_body(planar, self.force),
        ))  # fmt: skip
        run = _planar if planar else _spatial
        run(order, chain.links, chain.moves, series.V, series.T, self._R, self._d, *self._state, X)
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
    return RegressorSeries(chain, expand_at(chain, pose), pose=pose).rows(0)[0]
