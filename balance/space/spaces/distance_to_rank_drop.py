"""Distance of a geometry from one of lower rank, to first order.

The smallest singular value that counts, σ, vanishes where the geometry is special in one
more way. Its derivative along a change of geometry is ``uᵀ (∂X/∂g) v`` with its singular
vectors u and v (G. W. Stewart and J.-G. Sun, 1990), so the nearest such geometry is about
``σ / |∂σ/∂g|`` away.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import comb

import numpy as np

from balance.space.conditions.rank import singular_value_decomposition
from balance.space.momentum.regressor import (
    RegressorSeries,
    parameters_per_body,
    rows_per_column,
)
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.condition_gradients import ConditionGradients
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import CHANGE_OPENS_LOOPS, FIRST_ORDER_CHANGE, JOINTS_COINCIDE
from kinematics.closure.newton import radius_of_convergence
from kinematics.closure.series import expand
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import alike_groups

# Largest rows times squared columns of the conditions, which take a few seconds.
MAX_DECOMPOSITION_WORK = 3e9


def distance_to_rank_drop(space: DesignSpace | LinkageLike) -> float:
    """Estimate the distance of a geometry from the nearest one of lower rank, to first order.

    ``σ / |∂σ/∂g|`` with the smallest singular value σ that counts, at the order that reaches
    the rank, and the changes of geometry g after which the loops still close. Joints at one
    point move together, and joints on one axis turn together.

    Args:
        space: a design space, or a linkage, its path or its name.

    Returns:
        Root of the sum of squares of the changes, in characteristic lengths and radians;
        infinite if there is none near, if no order reaches the rank, or if the conditions
        are too many to decompose.

    Source:
        G. W. Stewart and J.-G. Sun, Matrix Perturbation Theory, 1990, for ``∂σ/∂g``.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf")
        >>> round(balance.space.distance_to_rank_drop(space), 4)
        0.15
    """
    space = as_space(space)
    linkage, chain, order, rank = space.linkage, space.chain, space.kmax, space.rank
    if order is None or rank == 0:
        return np.inf
    force = space.balance == "force"
    columns = chain.links.size * parameters_per_body(chain.planar, force)
    rows = chain.width * rows_per_column(chain.planar, force)
    rays = spanning_rays(chain.width, order, 2 - (-columns // rows))
    if len(rays) * (order + 1) * rows * columns**2 > MAX_DECOMPOSITION_WORK:
        return np.inf
    series = expand(chain, rays, order)
    weights = radius_of_convergence(series.C[0] @ rays[0]) ** np.arange(order + 1.0)
    X = RegressorSeries(chain, series, force).rows(order)
    X *= weights.reshape(-1, 1, 1, 1, 1)
    U, values, Vt = singular_value_decomposition(X.reshape(-1, columns))
    if not 0 < rank <= values.size:
        return np.inf
    u, v = U[:, rank - 1].reshape(X.shape[:-1]), Vt[rank - 1].reshape(chain.links.size, -1)
    slopes, changes = (
        ConditionGradients(chain, rays, series, force),
        rates_of_changes(linkage, chain),
    )
    residual = np.einsum("gnd,fnd->gf", changes, slopes.of_closure(weights))
    closed = np.sqrt(np.sum(residual**2, axis=1)) <= CHANGE_OPENS_LOOPS
    along = slopes.of_momentum(u * weights.reshape(-1, 1, 1, 1), v)
    square = float(np.sum(np.einsum("gnd,nd->g", changes[closed], along) ** 2))
    nearest = float(values[rank - 1]) / square**0.5 if square > 0.0 else np.inf
    return nearest if nearest < FIRST_ORDER_CHANGE else np.inf


def spanning_rays(width: int, order: int, enough: int) -> Array:
    """Generate rays of length 1 (rays, w) that span all derivatives, or ``enough`` of them.

    Args:
        order: the highest order of derivative.
        enough: largest number of rays.
    """
    count = min(comb(width + order, order + 1), enough)
    rays = np.random.default_rng(107).standard_normal((count, width))
    return np.asarray(rays / np.sqrt(np.sum(rays**2, axis=1, keepdims=True)))


def rates_of_changes(linkage: Linkage, chain: Chain) -> Array:
    """Compute the rates of all screws for each change of the geometry.

    Args:
        chain: its joints that move.

    Returns:
        Shape (changes, n, 6 or 3), in the frame and units of the chain.
    """
    return np.reshape(list(_changes(linkage, chain)), (-1, *chain.screws.shape))


def _changes(linkage: Linkage, chain: Chain) -> Iterator[Array]:
    """Yield the rates of all screws (n, 6 or 3), change by change."""
    frame, planar = chain.frame, chain.planar
    points = np.array([linkage.joints[j].point for j in chain.joints])
    points = (points - frame.origin) @ frame.R.T / frame.length
    spatial = np.zeros((len(points), 6))
    spatial[:, slice(2, 5) if planar else slice(0, 6)] = chain.screws
    for group in _groups(points):
        for axis in np.eye(3)[: 2 if planar else 3]:
            yield _rates(spatial, group, np.concatenate([np.zeros(3), axis]), planar)
    turning = np.where(np.any(spatial[:, :3] != 0.0, axis=1)[:, None], spatial, np.nan)
    for group in [] if planar else _groups(turning):
        n = spatial[group[0], :3]
        for axis in np.linalg.svd(n[None])[2][1:]:
            twist = np.concatenate([axis, np.cross(points[group[0]], axis)])
            yield _rates(spatial, group, twist, planar)


def _groups(rows: Array) -> list[list[int]]:
    """Group the indices of equal rows; those with NaN belong to no group."""
    whole = np.flatnonzero(~np.isnan(rows).any(axis=1))
    near = alike_groups(rows[whole], lambda u, v: np.abs(u - v).max(axis=1) <= JOINTS_COINCIDE)
    return [whole[group].tolist() for group in near]


def _rates(spatial: Array, group: list[int], twist: Array, planar: bool) -> Array:
    """Compute the rates of the screws if those of a group move with a twist."""
    out = np.zeros_like(spatial)
    w, v = twist[:3], twist[3:]
    for j in group:
        n, m = spatial[j, :3], spatial[j, 3:]
        out[j] = np.concatenate([np.cross(w, n), np.cross(v, n) + np.cross(w, m)])
    return out[:, 2:5] if planar else out
