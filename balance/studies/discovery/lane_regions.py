"""Conditions of the requirements of a search, and their derivatives, lane by lane.

Geometries of a topology share no frame of a file, but each has one of its ground: the origin A
is the first turning joint of the ground, and d runs to the second one, or along a slider of the
ground where there is none. Directions x and y are those of d and of d turned by 90°, and
coordinates count in the length of d. With ``c = A + α d + β J d`` the components

    ξ - c × p,    (α d + β J d) · p        (moment about c; force along a direction)

are linear in A and d, so that they have derivatives as simple as themselves.
"""

from __future__ import annotations

import numpy as np

from balance.studies.discovery.lane_motion import (
    Poses,
    follow_curves,
    lane_momentum_rows,
    momentum_rates,
    reach_places,
)
from balance.studies.discovery.structure import (
    LaneGeometry,
    LaneRegion,
    MomentumRows,
    TopologyArrays,
)
from kinematics.numerics.array_types import Array


def whole_momentum(dim: int, force: bool) -> MomentumRows:
    """Give all components of the momentum, or of the linear one.

    Args:
        dim: number of components of the momentum, 3 or 6.
        force: whether linear momentum alone counts.
    """
    rows = np.eye(dim)[(1 if dim == 3 else 3) if force else 0 :]
    none = np.zeros((len(rows), dim, 2))
    return MomentumRows(rows, none, none)


def force_rows(x: float, y: float) -> MomentumRows:
    """Give the linear momentum along a direction of the frame of the ground, in the plane."""
    line = np.array([[[0.0, 0.0], [x, -y], [y, x]]])
    return MomentumRows(np.zeros((1, 3)), np.zeros((1, 3, 2)), line)


def moment_rows(x: float, y: float) -> MomentumRows:
    """Give the angular momentum about a point of the frame of the ground, in the plane."""
    origin = np.array([[[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]])
    line = np.array([[[0.0, 0.0], [y, x], [-x, y]]])
    return MomentumRows(np.array([[1.0, 0.0, 0.0]]), origin, line)


def frame_of(structure: TopologyArrays, geometry: LaneGeometry) -> tuple[Array, Array]:
    """Compute origin A and line d of the frame of the ground, both (lanes, 2)."""
    first, second = structure.frame
    A = geometry.points[:, first, :2]
    if structure.sliding[second]:
        return A, geometry.axes[:, second, :2]
    return A, geometry.points[:, second, :2] - A


def _frame_rates(structure: TopologyArrays, geometry: LaneGeometry) -> tuple[Array, Array]:
    """Differentiate A and d with respect to all changes (lanes, changes, 2)."""
    first, second = structure.frame
    lanes = len(geometry.points)
    A = (structure.shifts * structure.moved[:, first, None])[:, :2]
    A = np.broadcast_to(A, (lanes, *A.shape))
    if structure.sliding[second]:
        turns = structure.turns * structure.moved[:, second, None]
        return A, np.cross(turns[None], geometry.axes[:, None, second])[..., :2]
    return A, (structure.shifts * structure.moved[:, second, None])[:, :2] - A


def poses_of_regions(
    structure: TopologyArrays, geometry: LaneGeometry, curves: Poses, reach: float, count: int
) -> tuple[Poses, ...]:
    """Compute the poses of each region.

    Args:
        curves: poses of the motion with all freedoms.
        reach: way of the fastest joint on curves, radians.
        count: number of poses on each curve.
    """
    return tuple(
        reach_places(whole, geometry, structure.inputs, region.places)
        if len(region.places)
        else follow_curves(whole, geometry, reach, count)
        if len(region.relations)
        else curves
        for whole, region in zip(structure.of_regions, structure.regions, strict=True)
    )


def _components(
    structure: TopologyArrays, geometry: LaneGeometry, rows: MomentumRows
) -> tuple[Array, Array]:
    """Compute S (lanes, rows, dim), and its derivatives (lanes, rows, dim, changes)."""
    if not structure.frame:
        shape = (len(geometry.points), *rows.fixed.shape)
        S = np.broadcast_to(rows.fixed, shape)
        return S, np.zeros((*shape, len(structure.shifts)))
    (A, d), (dA, dd) = frame_of(structure, geometry), _frame_rates(structure, geometry)
    S = np.einsum("rik,lk->lri", rows.by_origin, A) + np.einsum("rik,lk->lri", rows.by_line, d)
    rates = np.einsum("rik,lck->lric", rows.by_origin, dA)
    return rows.fixed + S, rates + np.einsum("rik,lck->lric", rows.by_line, dd)


def lane_condition_rows(
    structure: TopologyArrays,
    geometry: LaneGeometry,
    curves: Poses,
    regions: tuple[Poses, ...],
) -> Array:
    """Compute the rows of all conditions (lanes, rows, unknowns).

    Args:
        curves: poses of the motion with all freedoms.
        regions: from `poses_of_regions`.
    """
    if not structure.regions:
        return lane_momentum_rows(structure, curves)
    blocks = []
    for whole, region, poses in _regions(structure, regions):
        S, _ = _components(structure, geometry, region.components)
        h = _along(region, _by_pose(lane_momentum_rows(whole, poses), poses, 1))
        rows = np.einsum("lrd,lpwdx->lpwrx", S, h)
        blocks.append(rows.reshape(len(rows), -1, rows.shape[-1]))
    return _padded(structure, np.concatenate(blocks, axis=1))


def lane_condition_rates(
    structure: TopologyArrays,
    geometry: LaneGeometry,
    curves: Poses,
    regions: tuple[Poses, ...],
    z: Array,
) -> Array:
    """Differentiate what given masses leave of the conditions, with respect to all changes.

    Args:
        curves: poses of the motion with all freedoms.
        regions: from `poses_of_regions`.
        z: parameters of all bodies, several sets for each lane (lanes, sets, unknowns).

    Returns:
        Shape (lanes, sets, rows, changes).
    """
    if not structure.regions:
        return momentum_rates(structure, geometry, curves, z)
    blocks = []
    for whole, region, poses in _regions(structure, regions):
        S, dS = _components(structure, geometry, region.components)
        rates = momentum_rates(whole, geometry, poses, z)
        dh = _along(region, _by_pose(rates, poses, 2))
        h = _along(region, _by_pose(lane_momentum_rows(whole, poses), poses, 1))
        out = np.einsum("lrd,lspwdc->lspwrc", S, dh)
        out += np.einsum("lrdc,lpwds->lspwrc", dS, h @ np.swapaxes(z, 1, 2)[:, None, None])
        blocks.append(out.reshape(*out.shape[:2], -1, out.shape[-1]))
    return _padded(structure, np.concatenate(blocks, axis=2))


def _padded(structure: TopologyArrays, rows: Array) -> Array:
    """Add rows of zeros (…, rows, n), so that there are as many as unknowns."""
    missing = structure.unknowns - rows.shape[-2]
    if missing <= 0:
        return rows
    zeros = np.zeros((*rows.shape[:-2], missing, rows.shape[-1]))
    return np.concatenate([rows, zeros], axis=-2)


def _regions(
    structure: TopologyArrays, poses: tuple[Poses, ...]
) -> zip[tuple[TopologyArrays, LaneRegion, Poses]]:
    """Go through the regions with their motions and their poses."""
    return zip(structure.of_regions, structure.regions, poses, strict=True)


def _by_pose(rows: Array, poses: Poses, lead: int) -> Array:
    """Split rows of the momentum by pose, freedom and component.

    Args:
        rows: shape (…, poses · width · dim, n).
        poses: their poses.
        lead: number of leading dimensions.
    """
    count, width = poses.C.shape[1], poses.C.shape[-1]
    return rows.reshape(*rows.shape[:lead], count, width, -1, rows.shape[-1])


def _along(region: LaneRegion, rows: Array) -> Array:
    """Keep the directions in which a region moves, of rows (…, poses, width, dim, n)."""
    if not len(region.places):
        return rows
    return np.asarray(np.einsum("pwd,...pwin->...pdin", region.tangents, rows))
