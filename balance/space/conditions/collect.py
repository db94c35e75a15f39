"""Collect all conditions on a linkage: orders at the reference pose, and then finite poses.

Derivatives of one order are taken along generic rays until another ray adds no condition.
Orders are added until the conditions have full column rank, or until a finite pose that was
not used adds none. Where the orders that can be computed are not enough, or the margin of the
rank is small, poses all around are added.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from math import comb
from typing import NamedTuple

import numpy as np

from balance.space.conditions.order_kernels import (
    EXPANSION_ORDERS,
    FRESH_POSE_STEPS,
    OrderResult,
    conditions_up_to_order,
    generic_directions,
)
from balance.space.conditions.rank import Conditions, Pivots
from balance.space.momentum.regressor import rows_at, rows_per_column, select_rows
from balance.support.tolerances import SHORT_CONVERGENCE_RADIUS
from kinematics.closure.continuation import continue_in_directions
from kinematics.closure.newton import Pose
from kinematics.errors import MobilityError
from kinematics.model.arrays import Chain, freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.pivoted_qr import round_off
from kinematics.numerics.tolerances import RANK_MARGIN

# Most poses in one batch, and most multiplications, rows times the square of the unknowns, to
# factor it: seconds. A large linkage has more rows in few poses than it has unknowns; those of
# hundreds of poses would only add round-off.
MAX_POSES_PER_BATCH = 256
MAX_WORK_PER_BATCH = 5e8
NO_RANKS = freeze([], np.int64)


class CollectedConditions(NamedTuple):
    """The conditions, and where they come from.

    Attributes:
        conditions: all of them.
        ranks: number of independent ones up to order 0, 1, 2 …
        poses: finite poses that were added.
        settled: whether they are all there are.
    """

    conditions: Conditions
    ranks: tuple[int, ...]
    poses: int
    settled: bool


def relative_tolerance(chain: Chain) -> float:
    """Compute the relative size of round-off in the frame of a chain."""
    return round_off(chain.frame.origin, chain.frame.length)


def collect_conditions(
    chain: Chain,
    solutions: Array,
    force: bool,
    tolerance: float,
    max_order: int | None,
    begun: OrderResult | None = None,
) -> CollectedConditions:
    """Collect conditions, order by order and then pose by pose, until no other is independent.

    Args:
        chain: the linkage without idle joints.
        solutions: rows of parameters that satisfy all conditions.
        force: whether only linear momentum counts.
        tolerance: relative size of round-off.
        max_order: orders to compute exactly, instead of as many as needed.
        begun: the conditions of the first expansion, or up to ``max_order``, if they are known.

    Raises:
        MobilityError: no finite pose is found to check the conditions at.
    """
    goals = EXPANSION_ORDERS if max_order is None else (max_order,)
    rays = ray_count(chain, solutions.shape[1], force)
    while True:
        directions = generic_directions(0, rays, chain.width)
        if begun is None:
            none = Conditions.given(solutions, tolerance)
            begun = conditions_up_to_order(
                chain, directions, force, none, NO_RANKS, goals[0], max_order is None
            )
        collected = _conditions_along(directions, chain, force, begun, goals, max_order is None)
        if collected is not None:
            break
        begun = None
        rays *= 2
    conditions, ranks, settled, radius = collected
    poses = 0
    if max_order is None and not conditions.complete:
        if not orders_suffice(settled, radius, conditions.pivots):
            conditions, poses, settled = add_pose_conditions(chain, force, conditions)
    return CollectedConditions(conditions, tuple(ranks), poses, settled)


def orders_suffice(settled: bool, radius: float, pivots: Pivots) -> bool:
    """Decide whether conditions at the reference pose need none at poses all around.

    Args:
        settled: whether a finite pose that was not used adds none.
        radius: radius of convergence, in units of the coordinates.
        pivots: those of the conditions.
    """
    near = radius < SHORT_CONVERGENCE_RADIUS or pivots.are_near_round_off(RANK_MARGIN)
    return settled and not near


def ranks_that_count(ranks: Sequence[int], settled: bool) -> Sequence[int]:
    """Leave out the last orders if they add nothing, and no other order is needed.

    Args:
        ranks: rank after each order.
        settled: whether no other order is needed, and none was asked for.
    """
    count = len(ranks)
    while settled and count > 1 and ranks[count - 1] == ranks[count - 2]:
        count -= 1
    return ranks[:count]


def _conditions_along(
    rays: Array, chain: Chain, force: bool, begun: OrderResult, goals: Sequence[int], stop: bool
) -> tuple[Conditions, Sequence[int], bool, float] | None:
    """Collect the conditions of all orders along rays.

    Args:
        begun: the conditions up to the first of ``goals``.
        goals: highest orders of the expansions.

    Returns:
        The conditions, the rank after each order, whether they are settled, and the radius of
        convergence; None if there are not enough rays.
    """
    step, later = begun, list(goals[1:])
    while True:
        if not step.enough_rays:
            return None
        if not step.pose_found:
            raise MobilityError(
                "no closed pose was found near the reference pose to check the conditions at; "
                "write the file at a pose further from a singularity"
            )
        if (step.settled and stop) or not later:
            break
        step = conditions_up_to_order(
            chain, rays, force, step.conditions, step.ranks, later.pop(0), stop
        )
    ranks = ranks_that_count(step.ranks.tolist(), step.settled and stop)
    return step.conditions, ranks, step.settled, step.convergence_radius


def conditions_by_order(
    chain: Chain, solutions: Array, force: bool, tolerance: float, last: int
) -> list[Conditions]:
    """Collect the conditions up to order 0, 1, … ``last`` at the reference pose.

    Each order is added to the conditions before it, so that all cost as much as the last.

    Args:
        chain: the linkage without idle joints.
        solutions: rows of parameters that satisfy all conditions.
        force: whether only linear momentum counts.
        tolerance: relative size of round-off.
        last: highest order of derivative.
    """
    rays = ray_count(chain, solutions.shape[1], force)
    while True:
        directions = generic_directions(0, rays, chain.width)
        conditions, ranks = Conditions.given(solutions, tolerance), NO_RANKS
        collected = []
        for order in range(last + 1):
            step = conditions_up_to_order(
                chain, directions, force, conditions, ranks, order, False
            )
            if not step.enough_rays:
                break
            conditions, ranks = step[:2]
            collected.append(conditions)
        if len(collected) > last:
            return collected
        rays *= 2


def ray_count(chain: Chain, unknowns: int, force: bool) -> int:
    """Compute how many rays to begin with: enough for orders 0 and 1, or for all unknowns."""
    rows = chain.width * rows_per_column(chain.planar, force)
    return min(comb(chain.width + 1, 2), 1 - (-unknowns // rows))


def add_pose_conditions(
    chain: Chain,
    force: bool,
    conditions: Conditions,
    least_rank: int = 0,
    select: Array | None = None,
) -> tuple[Conditions, int, bool]:
    """Add the conditions at finite poses, twice as many each time, until a batch adds none.

    At least two batches are added, and no other that is larger than the limits of a batch.

    Args:
        chain: the linkage without idle joints.
        force: whether only linear momentum counts.
        least: a rank that is known to be reached.
        select: combinations of the momentum components that count (count, components); all of
            them by default.

    Returns:
        The conditions, the number of poses used, and whether the conditions are settled.
    """
    poses = continue_in_directions(
        chain, generic_directions(101, 101 + chain.width, chain.width)
    )
    used, batch, settled, before = 0, FRESH_POSE_STEPS, False, -1
    most = _most_poses(chain, force, conditions)
    while batch <= most:
        rows = [
            selected_rows_at(here, pose, force, select) for here, pose in islice(poses, batch)
        ]
        if not rows:
            break
        used += len(rows)
        before = conditions.rank
        # Near a dead centre rows are large; normalised blocks keep the others visible.
        sizes = [np.linalg.norm(block) or 1.0 for block in rows]
        block = np.concatenate([block / size for block, size in zip(rows, sizes, strict=True)])
        conditions = conditions.append(block)
        # After full rank, one more batch improves the conditioning.
        stays = conditions.rank == before and conditions.rank >= least_rank
        if settled or (stays and batch > FRESH_POSE_STEPS and not conditions.ill_conditioned):
            return conditions, used, True
        settled = conditions.complete
        batch *= 2
    stays = conditions.rank == before and conditions.rank >= least_rank
    return conditions, used, settled or (stays and not conditions.ill_conditioned)


def selected_rows_at(chain: Chain, pose: Pose, force: bool, select: Array | None) -> Array:
    """Compute the conditions at a finite pose; see `add_pose_conditions`."""
    rows = rows_at(chain, pose, force)
    if select is None:
        return rows
    parts = rows.reshape(chain.width, -1, rows.shape[-1])
    return select_rows(parts, select).reshape(-1, rows.shape[-1])


def _most_poses(chain: Chain, force: bool, conditions: Conditions) -> float:
    """Compute the number of poses that a batch may have, at least that of two batches."""
    rows = chain.width * rows_per_column(chain.planar, force)
    work = rows * max(conditions.columns.size, 1) ** 2
    return max(2 * FRESH_POSE_STEPS, min(MAX_POSES_PER_BATCH, MAX_WORK_PER_BATCH / work))
