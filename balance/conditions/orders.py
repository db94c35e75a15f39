"""Orders at the reference pose and a finite pose that tells whether they are enough.

One compiled step of `balance.conditions.gathering`: closure, momentum and rank without
leaving the compiled code, for one linkage or for many of one topology.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.conditions.elimination import factor_of, gather, implied, room_for, take_factor
from balance.conditions.rank import Conditions
from balance.momentum import parameters_per_body, regressor, room, rows_per_column
from kinematics.closure import series
from kinematics.kernels import kernel
from kinematics.linkage import Chain
from kinematics.placement import follow_series, rates_along, series_radius

__all__ = ["FAR", "FIRST", "NEAR", "Stage", "along_rays", "generic", "stage"]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# The order to which the motion is expanded first.
FIRST = 3
# Series that converge no further than this, in radians, say little.
NEAR = 1e-2
# Steps to the pose that decides whether high orders are complete.
FAR = 4


@kernel
def generic(begin, end, width):
    """Unit directions of a fixed sequence without special relations; (count, width)."""
    directions = np.ones((end - begin, width))
    if width > 1:
        for i in range(begin, end):
            size = 0.0
            for w in range(width):
                directions[i - begin, w] = np.cos((i * width + w + 1.0) ** 2)
                size += directions[i - begin, w] ** 2
            for w in range(width):
                directions[i - begin, w] /= np.sqrt(size)
    return directions


@kernel
def _fresh_rows(
    parent, screws, ends, mimics, dependent, columns, moves, links, C, per, size, steps,
):  # fmt: skip
    """Rows at a finite pose, in a direction of its own; none if no pose is found.

    A step is within the radius of convergence, where a condition of high order that is
    still missing may be too small to see: then several are needed. With one coordinate the
    series C at the reference pose predicts the first step.
    """
    n, dim = screws.shape
    width = columns.shape[1]
    m = 4 if dim == 6 else 3
    ray = generic(100, 101, width)
    q, s, H = np.zeros(n), screws, np.empty((0, m, m))
    order = min(FIRST, C.shape[1] - 1)
    for step in range(steps):
        if step > 0 or width > 1:
            C = series(parent, s, ends, mimics, dependent, columns, moves, ray, order)[0]
        ahead, carried = np.empty((n, m, m)), np.empty((n, dim))
        q, length = follow_series(
            parent, screws, ends, mimics, dependent, q, C[-1], ray[0], np.inf, ahead, carried
        )
        if length == 0.0:
            break
        s, H = carried, ahead
    if H.shape[0] == 0:
        return np.empty((0, links.size * size))
    X = np.zeros((1, 1, width, per, links.size * size))
    still = np.zeros((1, width))
    _, V, T, _ = series(parent, s, ends, mimics, dependent, columns, moves, still, 0)
    regressor(0, 0, H, links, moves, V, T, room(V, links, moves), X)
    return X.reshape((width * per, links.size * size))


@kernel
def _rates(C, ray):
    """Radius of convergence along a ray, and the rate of the slowest joint over the fastest."""
    rates = np.empty(C.shape[:2])
    rates_along(C, ray, rates)
    least, largest = np.inf, 0.0
    for j in range(rates.shape[1]):
        least, largest = min(least, abs(rates[0, j])), max(largest, abs(rates[0, j]))
    return series_radius(rates), least / largest


@kernel
def stage(
    parent, screws, ends, mimics, dependent, columns, moves, links, rays, per, size,
    goal, stop, steps, R, permutation, scale, dropped, unknowns, floor, ranks,
):  # fmt: skip
    """The orders up to ``goal``, of which those of ``ranks`` are known.

    Returns:
        The factor, its permutation, its largest pivot and largest remainder; the rank after
        each order; whether they are settled; the radius of convergence; the mismatch of the
        loops; the rate of the slowest joint, relative to the fastest; whether there were
        enough rays, and whether a finite pose was found.
    """
    width, parameters = columns.shape[1], links.size * size
    H = np.empty((0, 4, 4)) if screws.shape[1] == 6 else np.empty((0, 3, 3))
    fresh = np.empty((0, parameters))
    found = np.zeros(goal + 1, np.int64)
    done = ranks.size
    for k in range(done):
        found[k] = ranks[k]
    rank, order = R.shape[0], permutation.copy()
    F = room_for(unknowns.size, rays.shape[0] * width * per)
    take_factor(R, order, F)
    settled, enough, placed = False, True, True
    reach = slowest = mismatch = 1.0
    # With several coordinates the last order costs most, and is needed least.
    for upto in range(goal - 1 if stop and width > 1 else goal, goal + 1):
        if settled or not (enough and placed):
            break
        C, V, T, open = series(
            parent, screws, ends, mimics, dependent, columns, moves, rays,
            upto if stop else max(upto, FIRST),
        )  # fmt: skip
        mismatch = 0.0
        for k in range(open.size):
            mismatch = max(mismatch, open[k])
        reach, slowest = _rates(C[0], rays[0])
        X = np.zeros((upto + 1, rays.shape[0], width, per, parameters))
        regressor(0, upto, H, links, moves, V, T, room(V, links, moves), X)
        rows = X.reshape((upto + 1, rays.shape[0] * width * per, parameters))
        while enough and placed and not settled and done <= upto:
            rank, scale, dropped, more, settled, enough = gather(
                F, order, rank, scale, dropped, rows[done:], unknowns, width * per, width, done,
                reach, fresh, stop, floor, found[done:],
            )  # fmt: skip
            done += more
            stalled = done > 1 and found[done - 1] == found[done - 2]
            if enough and not settled and fresh.shape[0] == 0 and (stalled or upto == goal):
                fresh = _fresh_rows(
                    parent, screws, ends, mimics, dependent, columns, moves, links, C, per,
                    size, steps,
                )  # fmt: skip
                placed = fresh.shape[0] > 0
                settled = placed and implied(
                    F, order, rank, fresh, unknowns, 1.0, floor, scale
                )
    settled = settled and enough and placed
    return (factor_of(F, order, rank), order, scale, dropped, found[:done].copy(), settled,
            reach, mismatch, slowest, enough, placed)  # fmt: skip


class Stage(NamedTuple):
    """The conditions of the orders up to one of them.

    Attributes:
        conditions: all of them.
        ranks: number of independent ones after each order.
        settled: whether no other order is needed.
        reach: radius of convergence of the series.
        enough: whether there were enough rays; if not, more are needed.
        placed: whether a finite pose was found where one was needed.
    """

    conditions: Conditions
    ranks: IntArray
    settled: bool
    reach: float
    enough: bool
    placed: bool


def along_rays(
    chain: Chain, rays: Array, force: bool, conditions: Conditions, ranks: IntArray,
    goal: int, stop: bool,
) -> Stage:  # fmt: skip
    """Add the orders up to ``goal`` to conditions that hold those before.

    Args:
        chain: the linkage without idle joints.
        rays: generic directions (count, width).
        force: whether only linear momentum counts.
        conditions: those of lower orders.
        ranks: how many were independent after each of these orders.
        goal: the highest order.
        stop: whether to stop at the order that needs no other.
    """
    R, permutation, scale, dropped, found, settled, reach, _, _, enough, placed = stage(
        chain.parent, chain.screws, chain.ends, chain.mimics, chain.dependent, chain.columns,
        chain.moves, chain.links, rays, rows_per_column(chain.planar, force),
        parameters_per_body(chain.planar, force), goal, stop, 1 if goal == FIRST else FAR,
        conditions.factor, conditions.permutation, conditions.scale, conditions.dropped,
        conditions.columns, conditions.floor, ranks,
    )  # fmt: skip
    more = conditions._replace(factor=R, permutation=permutation, scale=scale, dropped=dropped)
    return Stage(more, found, settled, reach, enough, placed)
