"""The last steps to a special geometry, and the decision that it is one.

Far from the reference pose, where a meeting of motions (a node) near it no longer counts, all
masses y of the larger design space are carried along: with ``r = M y`` and J as in
`balance.studies.discovery.walk`, stacked for all y, ``δ = -J⁺ r``. The rank of J is the
codimension of the family: the number of equations that the geometry fulfils.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from balance.studies.discovery.lane_regions import lane_condition_rates
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.walk import (
    LaneConditions,
    conditions_at,
    put_conditions,
    take_conditions,
)
from kinematics.numerics.array_types import Array, Flags, IntArray

# Way of the fastest joint, and poses on each curve.
FAR, FAR_POSES, FAR_POSES_OF_MANY = 1.2, 14, 5
# How often the way is halved if it crosses a meeting of motions.
HALVINGS = 3
STEPS = 10
# How often a decision moves on to a pose that is farther from a node.
AWAY = 2
# Singular values up to this part of the largest are taken for the drop, at first.
DROP = 1e-5
# Singular values of an exact drop over the largest, and those above the gap.
EXACT, KEPT = 1e-14, 1e-7
# Those of an exact drop over the whole way, which round-off spoils more. Near a special
# geometry they are small on a short way: 1e-14 with lengths off by 7e-4, 3e-11 on the whole.
WIDE = 3e-13
# Singular values of J that count, relative to the largest.
CHANGES = 1e-7
# Those that count for the codimension, and those that clearly do not.
COUNTED, NOT_COUNTED = 1e-8, 3e-11
STILL = 1e-11
# Longest step that is left at a special geometry: 6e-6 beside a parallelogram off by 3e-5.
SETTLED = 1e-7


@dataclass(frozen=True, eq=False)
class Ends:
    """Decisions on the ends of walks.

    Attributes:
        geometry: the polished geometries.
        nullity: dimension of the design space (lanes,); -1 where nothing is decided.
        codimension: number of equations on the geometry (lanes,).
        dropped: largest singular value of the drop, over the largest (lanes,).
        gap: smallest singular value that is kept, over the largest (lanes,).
        clear: whether no singular value is near the limit, so that the nullity is beyond
            doubt (lanes,).
        special: whether the drop is exact, clear, and the same from another pose (lanes,).
    """

    geometry: LaneGeometry
    nullity: IntArray
    codimension: IntArray
    dropped: Array
    gap: Array
    clear: Flags
    special: Flags

    def take(self, lanes: IntArray) -> Ends:
        """Select lanes by indices."""
        return Ends(
            self.geometry.take(lanes),
            self.nullity[lanes],
            self.codimension[lanes],
            self.dropped[lanes],
            self.gap[lanes],
            self.clear[lanes],
            self.special[lanes],
        )


def _geometry_at(
    structure: TopologyArrays,
    geometry: LaneGeometry,
    conditions: LaneConditions,
    pose: IntArray,
) -> LaneGeometry:
    """Take another pose as the reference pose.

    Args:
        conditions: conditions, whose poses are used.
        pose: number of the pose of each lane.
    """
    lanes = np.arange(len(pose))
    H = conditions.poses.H[lanes, pose][:, structure.parent]
    k = 2 if structure.planar else 3
    points, axes = geometry.points.copy(), geometry.axes.copy()
    points[..., :k] = (H[..., :k, :k] @ points[..., :k, None])[..., 0] + H[..., :k, k]
    turned = (H[..., :k, :k] @ axes[..., :k, None])[..., 0]
    free = structure.free_axes
    axes[..., :k] = np.where(free[:, None], axes[..., :k], turned)
    return structure.normalise(LaneGeometry(points, axes))


def _far_poses(structure: TopologyArrays) -> int:
    """Return the number of poses on each far curve."""
    return FAR_POSES if structure.width == 1 else FAR_POSES_OF_MANY


def move_away(
    structure: TopologyArrays, geometry: LaneGeometry
) -> tuple[LaneGeometry, IntArray]:
    """Take a pose away from the first one as the reference pose of ends of walks.

    A walk that goes on from there does not arrive again if it has only come near a meeting of
    motions at its own pose. Where requirements name that pose, it stays.

    Args:
        geometry: ends of walks that have arrived, one at least.

    Returns:
        The geometries that can be moved, and the numbers of their lanes.
    """
    conditions = far_conditions(structure, geometry)
    if structure.pinned:
        return geometry.take(conditions.usable), np.flatnonzero(conditions.usable)
    curves = conditions.poses.q.shape[1] // _far_poses(structure)
    pose = np.full(len(geometry.points), curves * (_far_poses(structure) // 2))
    moved = _geometry_at(structure, geometry, conditions, pose)
    return moved.take(conditions.usable), np.flatnonzero(conditions.usable)


def far_conditions(
    structure: TopologyArrays, geometry: LaneGeometry, *, clearly: bool = False
) -> LaneConditions:
    """Compute the conditions far around the reference pose, but short of meetings of motions.

    Args:
        clearly: whether to halve the way, too, while a singular value is between those of a
            drop and the others: polished geometries are then decided, and the others not.
    """
    count = _far_poses(structure)
    conditions = conditions_at(structure, geometry, FAR, count)
    for half in range(1, HALVINGS + 1):
        grey = (conditions.values > EXACT * conditions.values[:, :1]) & (
            conditions.values < KEPT * conditions.values[:, :1]
        )
        lost = np.flatnonzero(
            conditions.poses.crossed | ~conditions.usable | (clearly & grey.any(axis=1))
        )
        if not lost.size:
            break
        nearer = conditions_at(structure, geometry.take(lost), FAR / 2**half, count)
        put_conditions(conditions, lost, nearer)
    return conditions


def _count_dropped(values: Array, limit: float) -> IntArray:
    """Count the singular values (lanes, p) up to ``limit`` times the largest.

    Args:
        values: singular values, the largest first.
    """
    return np.asarray(np.sum(values <= limit * values[:, :1], axis=1))


def _stacked(
    structure: TopologyArrays, geometry: LaneGeometry, conditions: LaneConditions, nullity: int
) -> tuple[Array, Array]:
    """Compute J and r, stacked for all masses of the design space."""
    kept = structure.unknowns - nullity
    z = conditions.Vt[:, kept:]
    D = lane_condition_rates(structure, geometry, conditions.poses, conditions.regions, z)
    U = conditions.U[:, None, :, :kept]
    J = D - U @ (np.swapaxes(U, -1, -2) @ D)
    r = conditions.values[:, kept:, None] * np.swapaxes(conditions.U[:, :, kept:], 1, 2)
    return J.reshape(len(J), -1, J.shape[-1]), r.reshape(len(r), -1)


def _pseudo_step(J: Array, r: Array) -> Array:
    """Compute ``-J⁺ r`` by the eigenvectors of ``Jᵀ J``."""
    transposed = np.swapaxes(J, 1, 2)
    values, Q = np.linalg.eigh(transposed @ J)
    counts = values > CHANGES**2 * np.maximum(values[:, -1:], 1e-300)
    inverse = np.where(counts, 1.0 / np.where(counts, values, 1.0), 0.0)
    right = np.swapaxes(Q, 1, 2) @ (transposed @ r[..., None])
    return -(Q @ (inverse[..., None] * right))[..., 0]


def _codimension(J: Array) -> tuple[IntArray, Flags]:
    """Count the independent equations on the geometry, and whether the count is clear.

    Near a special geometry that touches another set, J has small singular values between
    those that count and those of round-off.
    """
    R = np.linalg.qr(J, mode="r")
    values = np.linalg.svd(R, compute_uv=False)
    relative = values / np.maximum(values[:, :1], 1e-300)
    counts = relative > COUNTED
    return counts.sum(axis=1), ~np.any((relative > NOT_COUNTED) & ~counts, axis=1)


def polish(structure: TopologyArrays, geometry: LaneGeometry, generic: int) -> Ends:
    """Polish the ends of walks, and decide whether they are special.

    Args:
        geometry: ends of walks that have arrived.
        generic: nullity of most geometries.
    """
    geometry = LaneGeometry(*(array.copy() for array in geometry))
    conditions = far_conditions(structure, geometry)
    nullity = np.where(conditions.usable, _count_dropped(conditions.values, DROP), -1)
    nullity = np.where(conditions.usable, np.maximum(nullity, generic + 1), -1)
    for number in np.unique(nullity[nullity > generic]).tolist():
        lanes = np.flatnonzero(nullity == number)
        ends = _gauss_newton(structure, geometry.take(lanes), number)
        geometry.put(lanes, ends)
    return decide_special(structure, geometry, generic)


def _gauss_newton(
    structure: TopologyArrays, geometry: LaneGeometry, nullity: int
) -> LaneGeometry:
    """Step until the geometries no longer change; all have one nullity."""
    geometry = LaneGeometry(*(array.copy() for array in geometry))
    alive = np.arange(len(geometry.points))
    for _ in range(STEPS):
        here = geometry.take(alive)
        conditions = far_conditions(structure, here)
        alive, here = alive[conditions.usable], here.take(conditions.usable)
        if not alive.size:
            break
        conditions = take_conditions(conditions, conditions.usable)
        if not alive.size:
            break
        step = _pseudo_step(*_stacked(structure, here, conditions, nullity))
        largest = np.abs(step).max(axis=1)
        geometry.put(
            alive,
            structure.change(
                here, step * np.minimum(1.0, 0.3 / np.maximum(largest, 1e-300))[:, None]
            ),
        )
        alive = alive[largest > STILL]
        if not alive.size:
            break
    return geometry


def decide_special(structure: TopologyArrays, geometry: LaneGeometry, generic: int) -> Ends:
    """Decide nullity and codimension of geometries, away from nodes and from another pose.

    Args:
        generic: nullity of most geometries.
    """
    poses = [geometry]
    for _ in range(AWAY):
        poses.append(_away(structure, poses[-1]))
    geometry = poses[-1]
    conditions = far_conditions(structure, geometry, clearly=True)
    nullity = np.where(conditions.usable, _count_dropped(conditions.values, EXACT), -1)
    dropped, gap = _around(conditions.values, nullity)
    clear = conditions.usable & (gap >= KEPT)
    special = clear & (nullity > generic)
    wide = far_conditions(structure, geometry)
    special &= wide.usable & (_around(wide.values, nullity)[0] <= WIDE)
    special &= _agrees(structure, geometry, conditions, nullity)
    codimension = np.full(len(nullity), -1)
    for here in poses:
        lanes = np.flatnonzero(special)
        counts, sure, settled = _codimensions(structure, here.take(lanes), nullity[lanes])
        codimension[lanes] = np.maximum(codimension[lanes], np.where(sure, counts, -1))
        special[lanes] &= settled
    special &= codimension >= 0
    return Ends(poses[0], nullity, codimension, dropped, gap, clear, special)


def _codimensions(
    structure: TopologyArrays, geometry: LaneGeometry, nullity: IntArray
) -> tuple[IntArray, Flags, Flags]:
    """Compute the rank of J at one pose, whether it is clear, and whether no step is left."""
    counts, (sure, settled) = np.zeros(len(nullity), int), np.zeros((2, len(nullity)), bool)
    if not len(nullity):
        return counts, sure, settled
    conditions = far_conditions(structure, geometry, clearly=True)
    for number in np.unique(nullity).tolist():
        lanes = np.flatnonzero(conditions.usable & (nullity == number))
        if lanes.size:
            J, r = _stacked(
                structure, geometry.take(lanes), take_conditions(conditions, lanes), number
            )
            counts[lanes], sure[lanes] = _codimension(J)
            settled[lanes] = np.abs(_pseudo_step(J, r)).max(axis=1) <= SETTLED
    # Place, size and pose are no equations: more is what round-off leaves.
    same = 4 if structure.planar else 3 if structure.spherical else 7
    unpinned = 0 if structure.pinned else structure.width
    sure &= counts <= len(structure.shifts) - same - unpinned
    return counts, sure, settled | ~conditions.usable


def _away(structure: TopologyArrays, geometry: LaneGeometry) -> LaneGeometry:
    """Take the pose with the largest determinant of S as the reference pose, if any may be."""
    if structure.pinned:
        return geometry
    conditions = far_conditions(structure, geometry)
    regular = np.abs(np.linalg.det(np.nan_to_num(conditions.poses.S)))
    moved = _geometry_at(structure, geometry, conditions, np.argmax(regular, axis=1))
    lanes = np.flatnonzero(conditions.usable)
    geometry = LaneGeometry(*(array.copy() for array in geometry))
    geometry.put(lanes, moved.take(lanes))
    return geometry


def _agrees(
    structure: TopologyArrays,
    geometry: LaneGeometry,
    conditions: LaneConditions,
    nullity: IntArray,
) -> Flags:
    """Decide whether the nullity is the same from a pose on one of the first two curves.

    Where the reference pose must stay, it is to be the same on half the way.
    """
    if structure.pinned:
        other = conditions_at(structure, geometry, 0.5 * FAR, _far_poses(structure))
        return other.usable & (_count_dropped(other.values, EXACT) == nullity)
    agrees = np.zeros(len(nullity), bool)
    curves = conditions.poses.q.shape[1] // _far_poses(structure)
    for curve in range(2):
        pose = curves * (_far_poses(structure) // 4) + curve
        moved = _geometry_at(structure, geometry, conditions, np.full(len(nullity), pose))
        other = far_conditions(structure, moved, clearly=True)
        agrees |= other.usable & (_count_dropped(other.values, EXACT) == nullity)
    return agrees


def _around(values: Array, nullity: IntArray) -> tuple[Array, Array]:
    """Read the singular values next to the gap, over the largest (lanes,)."""
    lanes, p = values.shape
    relative = values / np.maximum(values[:, :1], 1e-300)
    first = np.clip(p - nullity, 0, p - 1)
    above = np.clip(first - 1, 0, p - 1)
    rows = np.arange(lanes)
    return relative[rows, first], relative[rows, above]
