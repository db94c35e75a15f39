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

from kinematics.arrays import Chain
from kinematics.closure import Series
from kinematics.kernels import kernel
from kinematics.models import LinkageLike, as_linkage
from kinematics.placement import Pose, expand_at, forward
from kinematics.pose import joint_positions, si_chain

__all__ = [
    "RegressorSeries",
    "moments_room",
    "momentum_regressor",
    "parameters_per_body",
    "planar_regressor",
    "regressor",
    "room",
    "rows_at",
    "rows_per_column",
    "spatial_regressor",
]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@kernel(reference_counting=False)
def spatial_regressor(first, last, start, links, moves, V, T, H, N, X):
    """Regressor rows of orders first … last; lower orders of H and N must be in place.

    H holds the columns of ``[R, d]``, and N those of its rate, ``[ω̂ R, e]``, and y. The
    displacements of the links at the pose are in ``start``; it is empty at the reference
    pose, where ``R = 1, d = 0`` makes for simpler terms.
    """
    rays, bodies = V.shape[0], H.shape[1]
    moved = start.shape[0] > 0
    width = moves.shape[1]
    force = X.shape[3] == 3
    p = 0 if force else 3
    for ray in range(rays):
        for b in range(bodies):
            j = links[b]
            if j < 0:
                continue
            h = H[ray, b]
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
    """Order k of the displacement: ``k H_k = Σ_{a<k} V̂_a H_{k-1-a}``."""
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
    """Order k of the rate ``T̂ H`` of a displacement, and of ``y = Rᵀ ω``."""
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
    """The term of the moment rows with ``R = 1`` and ``d = 0``."""
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
    """Add one term of the Cauchy products of the moment rows ξ."""
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
def planar_regressor(first, last, start, links, moves, V, T, H, N, X):
    """As `spatial_regressor` in the plane: H is ``(cos, sin, d_x, d_y)``, and N is its rate."""
    rays, bodies = V.shape[0], H.shape[1]
    width = moves.shape[1]
    force = X.shape[3] == 2
    p = 0 if force else 1
    for ray in range(rays):
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


def regressor(
    first: int, last: int, start: Array, links: IntArray, moves: NDArray[np.bool_], V: Array,
    T: Array, room: tuple[Array, Array], X: Array,
) -> None:  # fmt: skip
    """Add the rows of orders first … last to X (orders, rays, width, rows, parameters).

    ``room`` keeps what the next orders need; see `room`.
    """
    bodies = links.size
    x = X.reshape((*X.shape[:4], bodies, X.shape[4] // max(bodies, 1)))
    add = planar_regressor if V.shape[3] == 3 else spatial_regressor
    add(first, last, start, links, moves, V, T, *room, x)


def room(V: Array, links: IntArray, moves: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Room for the displacements of the bodies, and their rates, of all orders of V."""
    rays, orders = V.shape[:2]
    displacement, rate = ((4,), (4,)) if V.shape[3] == 3 else ((4, 3), (5, 3))
    return (
        np.empty((rays, links.size, orders, *displacement)),
        np.empty((rays, links.size, moves.shape[1], orders, *rate)),
    )


def moments_room(
    V: Array, links: IntArray, moves: NDArray[np.bool_], per: int, size: int
) -> tuple[Array, Array, Array, Array]:
    """As `room`, then the regressor, by bodies and as rows of each order; both zero."""
    rays, orders = V.shape[:2]
    width, bodies = moves.shape[1], links.size
    X = np.zeros((orders, rays, width, per, bodies, size))
    return *room(V, links, moves), X, X.reshape(orders, rays * width * per, bodies * size)


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
        self._chain, self._series = chain, series
        self._next = 0
        self._start = np.empty((0, 4, 4)) if pose is None else pose.H
        self._room = room(series.V, chain.links, chain.moves)
        rows = rows_per_column(chain.planar, force)
        parameters = chain.links.size * parameters_per_body(chain.planar, force)
        self._shape = (series.V.shape[0], chain.width, rows, parameters)

    def rows(self, last: int) -> Array:
        """Rows of the orders up to ``last`` that were not asked for before.

        Returns:
            Shape (orders, rays, width, rows per column, parameters).
        """
        chain, series, first = self._chain, self._series, self._next
        assert first <= last <= series.order
        self._next = last + 1
        X = np.zeros((last + 1 - first, *self._shape))
        regressor(
            first, last, self._start, chain.links, chain.moves, series.V, series.T, self._room,
            X,
        )  # fmt: skip
        return X


def rows_at(chain: Chain, pose: Pose, force: bool = False) -> Array:
    """The regressor at a finite pose, all columns below each other; (rows, parameters)."""
    rows = RegressorSeries(chain, expand_at(chain, pose), force, pose).rows(0)
    return rows.reshape(-1, rows.shape[-1])


def momentum_regressor(
    linkage: LinkageLike, q: ArrayLike | Mapping[str, float], *, spatial: bool | None = None
) -> Array:
    """Regressor X of the total momentum at a finite pose: ``h = Σ_w u̇_w X[w] z``.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
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
    linkage = as_linkage(linkage)
    chain = si_chain(linkage, not linkage.planar if spatial is None else spatial)
    pose = forward(chain, joint_positions(linkage, q)[chain.joints])
    X = rows_at(chain, pose)
    return X.reshape(chain.width, -1, X.shape[1])
