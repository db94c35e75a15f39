"""The walk to geometries of lower rank, for many starts at once.

With M the momentum rows at poses around the reference pose and s, u, v the smallest singular
value that a generic geometry keeps and its vectors, ``s u = M v`` is to vanish. For fixed
masses v it changes by ``D = ∂(M v)/∂g``; the masses may change too, which takes the part of D
in the span of the other left singular vectors away (variable projection, G. H. Golub and
V. Pereyra, 1973):

    J = (1 - U' U'ᵀ) D,     (Jᵀ J + λ) δ = -Jᵀ s u       (Levenberg-Marquardt)

A step is kept if ``s / s_max`` falls. Directions that only move, turn or scale the linkage, or
change its pose, do not change s; λ keeps them small. `descend` does this for any such number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Protocol

import numpy as np

from balance.studies.discovery.lane_motion import Poses, follow_curves
from balance.studies.discovery.lane_regions import (
    lane_condition_rates,
    lane_condition_rows,
    poses_of_regions,
)
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array, Flags, IntArray

Watcher = Callable[[IntArray, LaneGeometry, Array], None]

# Way of the fastest joint and number of poses on each curve.
REACH, POSES = 0.6, 9
# Curves of a linkage with several inputs have fewer poses.
POSES_OF_MANY = 3
STEPS, LARGEST_STEP = 80, 0.25
# A walk has arrived if the smallest singular value falls below this part of the largest.
ARRIVED = 1e-9
# Closure residual up to which a lane has kept its way.
CLOSED = 1e-9
# A walk is given up if its singular value has not fallen by this factor in so many steps.
SLOW, PATIENCE = 0.7, 15


@dataclass(frozen=True, eq=False)
class LaneConditions:
    """Momentum rows and their singular value decomposition, lane by lane.

    Attributes:
        poses: the poses around the reference pose.
        U, values, Vt: decomposition of the rows (lanes, rows, p), (lanes, p), (lanes, p, p).
        usable: whether loops stayed closed (lanes,).
        regions: the poses of each region, where requirements have some.
    """

    poses: Poses
    U: Array
    values: Array
    Vt: Array
    usable: Flags
    regions: tuple[Poses, ...] = ()


@dataclass(frozen=True, eq=False)
class Walks:
    """Ends of walks.

    Attributes:
        geometry: where they ended.
        ratio: smallest kept singular value over the largest, or what else was to fall (lanes,).
        steps: number of steps tried (lanes,).
        arrived: whether the ratio fell far enough (lanes,).
    """

    geometry: LaneGeometry
    ratio: Array
    steps: IntArray
    arrived: Flags


def conditions_at(
    structure: TopologyArrays, geometry: LaneGeometry, reach: float = REACH, poses: int = 0
) -> LaneConditions:
    """Compute the conditions of geometries at poses around the reference pose.

    Args:
        reach: way of the fastest joint, radians.
        poses: number on each curve; by default as the walk has.
    """
    count = poses or (POSES if structure.width == 1 else POSES_OF_MANY)
    curves = follow_curves(structure, geometry, reach, count)
    regions = poses_of_regions(structure, geometry, curves, reach, count)
    usable = np.all([part.residual <= CLOSED for part in (curves, *regions)], axis=0)
    crossed = np.any([part.crossed for part in (curves, *regions)], axis=0)
    M = lane_condition_rows(structure, geometry, curves, regions)
    M[~usable] = 0.0
    U, values, Vt = _decompose(M, usable)
    return LaneConditions(replace(curves, crossed=crossed), U, values, Vt, usable, regions)


def _decompose(M: Array, usable: Flags) -> tuple[Array, Array, Array]:
    """Compute singular values; a lane whose iteration does not converge becomes unusable."""
    try:
        return np.linalg.svd(M, full_matrices=False)
    except np.linalg.LinAlgError:
        for lane in range(len(M)):
            try:
                np.linalg.svd(M[lane], full_matrices=False)
            except np.linalg.LinAlgError:
                M[lane], usable[lane] = 0.0, False
        return np.linalg.svd(M, full_matrices=False)


def generic_nullity(structure: TopologyArrays, geometry: LaneGeometry) -> int:
    """Compute the dimension of the design space that most geometries have.

    Args:
        geometry: a few random linkages.

    Raises:
        UsageError: the loops of none of them stay closed.
    """
    conditions = conditions_at(structure, geometry)
    values = conditions.values[conditions.usable]
    if not len(values):
        raise UsageError(
            f"the loops of none of {len(conditions.usable)} random geometries stay closed as "
            "they move: no walk can start; choose another topology"
        )
    counts = np.sum(values < 1e-10 * values[:, :1], axis=1)
    return int(np.median(counts))


def _limit(steps: Array) -> Array:
    """Shorten steps so that no component exceeds the largest step."""
    largest = np.max(np.abs(steps), axis=1, keepdims=True)
    return np.asarray(steps * np.minimum(1.0, LARGEST_STEP / np.maximum(largest, 1e-300)))


class Measured(Protocol):
    """What a walk lets fall, at some geometries.

    Attributes:
        ratio: a number that vanishes where a walk is to end (lanes,); infinite where loops do
            not stay closed.
    """

    @property
    def ratio(self) -> Array:
        """See above."""

    def terms(self, lanes: IntArray) -> tuple[Array, Array]:
        """Compute ``Jᵀ J`` and ``Jᵀ r`` of some lanes, where r is a vector of that length."""


@dataclass(frozen=True, eq=False)
class SmallestValue:
    """The smallest singular value that most geometries keep, over the largest.

    Attributes:
        structure: the topology.
        geometry: the linkages.
        conditions: theirs.
        kept: index of the singular value.
    """

    structure: TopologyArrays
    geometry: LaneGeometry
    conditions: LaneConditions
    kept: int

    @property
    def ratio(self) -> Array:
        """The value over the largest (lanes,)."""
        values = self.conditions.values
        with np.errstate(all="ignore"):
            return np.where(self.conditions.usable, values[:, self.kept] / values[:, 0], np.inf)

    def terms(self, lanes: IntArray) -> tuple[Array, Array]:
        """Compute ``Jᵀ J`` and ``Jᵀ s u``; see `Measured`."""
        conditions, kept = take_conditions(self.conditions, lanes), self.kept
        here = self.geometry.take(lanes)
        z = conditions.Vt[:, kept : kept + 1]
        D = lane_condition_rates(self.structure, here, conditions.poses, conditions.regions, z)[
            :, 0
        ]
        return step_terms(
            D,
            conditions.U[:, :, :kept],
            conditions.values[:, kept, None] * conditions.U[:, :, kept],
        )


def step_terms(D: Array, others: Array, r: Array) -> tuple[Array, Array]:
    """Compute ``Jᵀ J`` and ``Jᵀ r`` with ``J = (1 - Q Qᵀ) D``.

    Args:
        D: derivatives of the momentum of fixed masses (lanes, rows, changes).
        others: orthonormal columns Q that a change of the masses spans (lanes, rows, n).
        r: the momentum (lanes, rows).
    """
    J = D - others @ (np.swapaxes(others, 1, 2) @ D)
    transposed = np.swapaxes(J, 1, 2)
    return transposed @ J, (transposed @ r[..., None])[..., 0]


def walk_to_special(
    structure: TopologyArrays,
    start: LaneGeometry,
    nullity: int,
    *,
    reach: float = REACH,
    watch: Watcher | None = None,
) -> Walks:
    """Walk from each start to a geometry of larger nullity, as far as that goes.

    Args:
        nullity: that of most geometries.
        reach: way of the fastest joint at the poses, radians.
        watch: told of each step; see `descend`.

    Returns:
        The ends; a walk has arrived if its ratio is at most 1e-9.
    """
    kept = structure.unknowns - nullity - 1

    def measure(geometry: LaneGeometry) -> Measured:
        conditions = conditions_at(structure, geometry, reach)
        return SmallestValue(structure, geometry, conditions, kept)

    return descend(structure, start, measure, ARRIVED, watch)


def descend(
    structure: TopologyArrays,
    start: LaneGeometry,
    measure: Callable[[LaneGeometry], Measured],
    arrived: float,
    watch: Watcher | None = None,
) -> Walks:
    """Let a number fall by steps of Levenberg and Marquardt.

    Args:
        measure: computes the number at geometries.
        arrived: where a walk ends.
        watch: called at the start, and after each step, with the lanes that kept it, their
            geometries, and the number there.
    """
    geometry = LaneGeometry(*(array.copy() for array in structure.normalise(start)))
    lanes = len(geometry.points)
    damping = np.full(lanes, 1e-2)
    best, since, steps = np.full(lanes, np.inf), np.zeros(lanes, int), np.zeros(lanes, int)
    objective = measure(geometry)
    ratio = objective.ratio
    alive = np.flatnonzero(np.isfinite(ratio))
    terms = objective.terms(alive) if alive.size else (np.zeros((0, 1, 1)), np.zeros((0, 1)))
    if watch is not None and alive.size:
        watch(alive, geometry.take(alive), ratio[alive])
    for _ in range(STEPS):
        if not alive.size:
            break
        A, b = terms
        scale = np.einsum("lcc->l", A) / A.shape[1]
        eye = np.eye(A.shape[1]) * (damping[alive] * scale + 1e-300)[:, None, None]
        step = _limit(-np.linalg.solve(A + eye, b[..., None])[..., 0])
        tried = structure.change(geometry.take(alive), step)
        new = measure(tried)
        there = new.ratio
        fell = there < ratio[alive]
        steps[alive] += 1
        less, more = np.maximum(damping[alive] / 5.0, 1e-12), 4.0 * damping[alive]
        damping[alive] = np.where(fell, less, more)
        moved = alive[fell]
        geometry.put(moved, tried.take(fell))
        ratio[moved] = there[fell]
        if watch is not None and moved.size:
            watch(moved, tried.take(fell), there[fell])
        if fell.any():
            terms[0][fell], terms[1][fell] = new.terms(np.flatnonzero(fell))
        better = ratio < SLOW * best
        best, since = np.where(better, ratio, best), np.where(better, 0, since + 1)
        on = (ratio[alive] > arrived) & (since[alive] < PATIENCE) & (damping[alive] < 1e6)
        alive, terms = alive[on], (terms[0][on], terms[1][on])
    return Walks(geometry, ratio, steps, ratio <= arrived)


def _take_poses(poses: Poses, lanes: IntArray | Flags) -> Poses:
    """Select lanes."""
    return Poses(**{field.name: getattr(poses, field.name)[lanes] for field in fields(Poses)})


def take_conditions(conditions: LaneConditions, lanes: IntArray | Flags) -> LaneConditions:
    """Select lanes.

    Args:
        conditions: the conditions of all lanes.
    """
    return LaneConditions(
        _take_poses(conditions.poses, lanes),
        conditions.U[lanes],
        conditions.values[lanes],
        conditions.Vt[lanes],
        conditions.usable[lanes],
        tuple(_take_poses(poses, lanes) for poses in conditions.regions),
    )


def put_conditions(conditions: LaneConditions, lanes: IntArray, other: LaneConditions) -> None:
    """Replace the conditions of some lanes, in place.

    Args:
        conditions: the conditions of all lanes.
        other: the new conditions of these lanes.
    """
    pairs: list[tuple[object, object]] = [(conditions, other), (conditions.poses, other.poses)]
    pairs += zip(conditions.regions, other.regions, strict=True)
    for mine, new in pairs:
        for name, array in vars(mine).items():
            if isinstance(array, np.ndarray):
                array[lanes] = getattr(new, name)
