"""The momentum regressor as a power series; `momentum.regressor_kernels` computes it.

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
from numpy.typing import ArrayLike

from balance.space.momentum.regressor_kernels import planar_regressor, spatial_regressor
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import Pose, expand_at, forward_kinematics
from kinematics.closure.series import Series
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array, Flags, IntArray

# No displacements of links: `start` of a regressor at the reference pose.
NO_POSE = np.empty((0, 4, 4))


def body_regressors(
    first: int,
    last: int,
    start: Array,
    links: IntArray,
    moves: Flags,
    V: Array,
    T: Array,
    workspace: tuple[Array, Array],
    X: Array,
) -> None:
    """Add the rows of orders first … last of the regressor of all bodies to X.

    Args:
        first: lowest order; the workspace holds those below.
        last: highest order.
        start: displacements of the links at the pose (n, 4, 4), planar (n, 3, 3), or none of
            them at the reference pose.
        links: link of each body (bodies,).
        moves: whether a column moves a link (n, width).
        V: link twists along the rays (rays, orders, n, 6), planar (…, 3).
        T: link twists of the columns (rays, orders, n, width, 6), planar (…, 3).
        workspace: as from `regressor_workspace`; the next orders need it.
        X: in, out: zeros (orders from first, rays, width, rows, parameters).
    """
    orders, rays, width, rows, parameters = X.shape
    x = X.reshape(orders, rays, width, rows, links.size, parameters // max(links.size, 1))
    add = planar_regressor if V.shape[3] == 3 else spatial_regressor
    add(first, last, 0, rays, start, links, moves, V, T, *workspace, x)


def regressor_workspace(V: Array, links: IntArray, moves: Flags) -> tuple[Array, Array]:
    """Allocate displacements of the bodies, and their rates, for all orders of V.

    Args:
        V: link twists along the rays (rays, orders, n, 6 or 3).
        links: link of each body (bodies,).
        moves: whether a column moves a link (n, width).
    """
    rays, orders = V.shape[:2]
    displacement, rate = ((4,), (4,)) if V.shape[3] == 3 else ((4, 3), (5, 3))
    return (
        np.empty((rays, links.size, orders, *displacement)),
        np.empty((rays, links.size, moves.shape[1], orders, *rate)),
    )


def moments_workspace(
    V: Array, links: IntArray, moves: Flags, per: int, size: int
) -> tuple[Array, Array, Array, Array]:
    """Allocate the `regressor_workspace`, and zeros for the regressor, by bodies and as rows.

    Args:
        V: link twists along the rays (rays, orders, n, 6 or 3).
        links: link of each body (bodies,).
        moves: whether a column moves a link (n, width).
        per: momentum components of each column.
        size: parameters of each body.
    """
    rays, orders = V.shape[:2]
    width, bodies = moves.shape[1], links.size
    X = np.zeros((orders, rays, width, per, bodies, size))
    return (
        *regressor_workspace(V, links, moves),
        X,
        X.reshape(orders, rays * width * per, bodies * size),
    )


def parameters_per_body(planar: bool, force: bool) -> int:
    """Count the inertial parameters: 10, in a plane 4; for force balance 4, in a plane 3.

    Args:
        planar: whether only motion in the plane counts.
        force: whether only linear momentum counts.
    """
    return (3 if force else 4) if planar else (4 if force else 10)


def rows_per_column(planar: bool, force: bool) -> int:
    """Count the momentum components: 6, in a plane 3; for force balance 3, in a plane 2.

    Args:
        planar: whether only motion in the plane counts.
        force: whether only linear momentum counts.
    """
    return (2 if force else 3) if planar else (3 if force else 6)


def _row_shapes(chain: Chain) -> tuple[tuple[int, int, int], ...]:
    """Return width, rows per column and parameters, without and with ``force``."""
    n, kinds = chain.links.size, [(chain.planar, force) for force in (False, True)]
    return tuple((chain.width, rows_per_column(*k), n * parameters_per_body(*k)) for k in kinds)


class RegressorSeries:
    """The regressor of the total momentum, order by order, in the frame of the chain."""

    def __init__(
        self, chain: Chain, series: Series, force: bool = False, pose: Pose | None = None
    ) -> None:
        """Start at the reference pose, or at a finite pose with its own series."""
        self._chain, self._series, self._next = chain, series, 0
        self._start = NO_POSE if pose is None else pose.H
        self._shape = chain.once(_row_shapes)[force]
        self._workspace: tuple[Array, Array] | None = None

    def rows(self, last: int) -> Array:
        """Compute the rows of the orders up to ``last`` that were not computed before.

        Returns:
            Shape (orders, rays, width, rows per column, parameters), an array of its own.
        """
        chain, V, T, first = self._chain, self._series.V, self._series.T, self._next
        rays, orders = V.shape[:2]
        assert first <= last < orders
        self._next = last + 1
        purpose = "momentum", rays, orders
        # Displacements of lower orders stay in the workspace until the last order is done.
        workspace = self._workspace or chain.borrow(
            purpose, lambda: regressor_workspace(V, chain.links, chain.moves)
        )
        X = np.zeros((last + 1 - first, rays, *self._shape))
        body_regressors(first, last, self._start, chain.links, chain.moves, V, T, workspace, X)
        self._workspace = workspace if last + 1 < orders else None
        if self._workspace is None:
            chain.give_back(purpose, workspace)
        return X


def rows_at(chain: Chain, pose: Pose, force: bool = False) -> Array:
    """Compute the regressor at a finite pose, all columns below each other.

    Args:
        pose: a closed pose of it.
        force: whether only linear momentum counts.

    Returns:
        Shape (rows, parameters), in the frame and units of the chain.
    """
    rows = RegressorSeries(chain, expand_at(chain, pose), force, pose).rows(0)
    return rows.reshape(-1, rows.shape[-1])


def select_rows(X: Array, select: Array) -> Array:
    """Combine the momentum components of rows.

    Args:
        X: rows (..., width, components, parameters).
        select: combinations of the components (count, components).

    Returns:
        Shape (..., width, count, parameters).
    """
    return np.asarray(np.einsum("kr,...rp->...kp", select, X))


def momentum_regressor(
    linkage: LinkageLike, q: ArrayLike | Mapping[str, float], *, spatial: bool | None = None
) -> Array:
    """Compute the regressor X of the total momentum at a finite pose, ``h = Σ_w u̇_w X[w] z``.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: displacements from the reference pose, of all joints or of the inputs alone; see
            `kinematics.closure.joint_positions.joint_positions`; radians and metres.
        spatial: six rows and ten parameters per body; by default only if the linkage is
            not planar.

    Returns:
        Shape (mobility, 6, 10 bodies), rows ``[ξ; p]`` about the inertial origin in inertial
        axes; or (mobility, 3, 4 bodies), rows ``[ξz, px, py]`` in the axes of the plane.
        Parameters are those of the reference pose, as in `Body.inertia`; SI units.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, chapter 5.

    Example:
        >>> import balance
        >>> balance.momentum.momentum_regressor("robot.urdf", {"u1": 0.1}).shape
        (1, 3, 12)
    """
    linkage = as_linkage(linkage)
    chain = si_chain(linkage, not linkage.planar if spatial is None else spatial)
    pose = forward_kinematics(chain, joint_positions(linkage, q)[chain.joints])
    X = rows_at(chain, pose)
    return X.reshape(chain.width, -1, X.shape[1])
