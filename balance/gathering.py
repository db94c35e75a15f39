"""All the conditions on a linkage: orders at the reference pose, and poses if need be.

Derivatives of one order are gathered along generic rays until another ray adds no condition;
orders are gathered until the conditions are complete, or until a finite pose that was not
used adds none. Where the orders that can be computed are not enough, or decide by little,
poses all around are added.
"""

from __future__ import annotations

from itertools import islice
from math import comb, hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.elimination import FLOOR
from balance.momentum import RegressorSeries, rows_at, rows_per_column
from balance.rank import Conditions
from kinematics.closure import Series, expand
from kinematics.errors import MobilityError
from kinematics.linkage import Chain
from kinematics.placement import radius
from kinematics.walk import walk, wander

__all__ = ["Gathered", "gather_conditions", "round_off"]

Array = NDArray[np.float64]

# Orders to which the motion is expanded, one after the other as they are needed.
EXPANSIONS = (3, 8, 20)
# Steps to the pose that decides whether high orders are complete.
FAR = 4
# Most poses that are looked at together.
POSES = 256
# Series that converge no further than this, in radians, say little.
NEAR = 1e-2
NOTHING = np.empty((0, 0))


class Gathered(NamedTuple):
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


def round_off(chain: Chain) -> float:
    """Relative size of what counts as round-off.

    The coordinates of a linkage far from the origin of its file are rounded accordingly.
    """
    away = hypot(*chain.frame.origin.tolist()) / chain.frame.length
    return max(FLOOR, 2.0**-50 * away)


def gather_conditions(
    chain: Chain, known: Array, force: bool, floor: float, max_order: int | None
) -> Gathered:
    """Conditions until they are all there are.

    Args:
        chain: the linkage without idle joints.
        known: rows of parameters that fulfil all conditions.
        force: whether only linear momentum counts.
        floor: relative size of round-off.
        max_order: orders to compute exactly, instead of as many as needed.

    Raises:
        MobilityError: no finite pose is found to check the conditions at.
    """
    none = Conditions.beside(known, floor)
    last = EXPANSIONS[-1] if max_order is None else max_order
    rows = chain.width * rows_per_column(chain.planar, force)
    rays = min(comb(chain.width + 1, 2), 1 - (-known.shape[1] // rows))
    while True:
        directions = _generic(rays, chain.width)
        found = _along(directions, chain, force, none, last, max_order is None)
        if found is not None:
            break
        rays *= 2
    conditions, ranks, settled, reach = found
    poses = 0
    if max_order is None and not conditions.complete:
        if not settled or reach < NEAR or conditions.thin:
            conditions, poses, settled = _with_poses(chain, force, conditions)
    return Gathered(conditions, tuple(ranks), poses, settled)


def _along(
    directions: Array, chain: Chain, force: bool, conditions: Conditions, last: int, stop: bool
) -> tuple[Conditions, list[int], bool, float] | None:
    """Conditions along rays: their ranks, settled or not, the radius of convergence.

    None if there are not enough rays.
    """
    ranks: list[int] = []
    settled, reach = False, 1.0
    for goal in EXPANSIONS if stop else (last,):
        series = expand(chain, directions, max(goal, EXPANSIONS[0]))
        reach = radius(series.C[0] @ directions[0])
        regressor = RegressorSeries(chain, series, force)
        fresh = NOTHING
        # With several coordinates the last order costs most, and is needed least.
        for upto in (goal - 1, goal) if stop and chain.width > 1 else (goal,):
            first = len(ranks)
            rows = regressor.rows(upto)[first - upto - 1 :]
            while not settled and len(rows):
                conditions, found, settled, enough = conditions.with_orders(
                    rows, first, reach, fresh, stop
                )
                if not enough:
                    return None
                ranks += found.tolist()
                first, rows = first + found.size, rows[found.size :]
                stalled = ranks[-1:] == ranks[-2:-1]
                if not settled and not len(fresh) and (stalled or upto == goal):
                    steps = 1 if goal == EXPANSIONS[0] else FAR
                    fresh = _fresh_rows(chain, force, steps, series)
                    settled = conditions.imply(fresh)
        if settled and stop:
            break
    while settled and stop and len(ranks) > 1 and ranks[-1] == ranks[-2]:
        ranks.pop()
    return conditions, ranks, settled, reach


def _fresh_rows(chain: Chain, force: bool, steps: int, known: Series) -> Array:
    """Rows at a finite pose, in a direction of its own; (rows, columns).

    A step is within the radius of convergence, where a condition of high order that is
    still missing may be too small to see: then several are needed.

    Args:
        chain: the linkage as arrays.
        force: whether only linear momentum counts.
        steps: how many steps away from the reference pose.
        known: series there; used where a chain has only one direction to move in.
    """
    ray = _generic(101, chain.width)[-1]
    poses = list(islice(walk(chain, ray, known if chain.width == 1 else None), steps))
    if not poses:
        raise MobilityError(
            "no closed pose was found near the reference pose to check the conditions at; "
            "write the file at a pose further from a singularity"
        )
    return rows_at(chain, poses[-1], force)


def _with_poses(
    chain: Chain, force: bool, conditions: Conditions
) -> tuple[Conditions, int, bool]:
    """Conditions at ever more poses, until as many again add none.

    Returns:
        The conditions, how many poses were used, and whether that settles them.
    """
    poses = wander(chain, _generic(101 + chain.width, chain.width)[101:])
    used, batch, settled, before = 0, FAR, False, -1
    while batch <= POSES:
        rows = [rows_at(here, pose, force) for here, pose in islice(poses, batch)]
        if not rows:
            break
        used += len(rows)
        before = conditions.rank
        # Where a joint is near a dead centre rows are large, and must not drown the others.
        sizes = [np.linalg.norm(block) or 1.0 for block in rows]
        block = np.concatenate([block / size for block, size in zip(rows, sizes, strict=True)])
        conditions = conditions.and_also(block)
        # As many again make a complete answer a well-conditioned one.
        if settled or (conditions.rank == before and batch > FAR and not conditions.thin):
            return conditions, used, True
        settled = conditions.complete
        batch *= 2
    return conditions, used, settled or (conditions.rank == before and not conditions.thin)


def _generic(count: int, width: int) -> Array:
    """Unit directions of a fixed sequence without special relations; (count, width)."""
    if width == 1:
        return np.ones((count, 1))
    directions = np.cos(np.arange(1.0, count * width + 1.0) ** 2).reshape(count, width)
    return directions / np.sqrt(np.sum(directions**2, axis=1, keepdims=True))
