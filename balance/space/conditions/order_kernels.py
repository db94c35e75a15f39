"""Conditions of consecutive orders at the reference pose, checked at a finite pose.

One compiled step of `balance.space.conditions.collect`: closure, momentum and rank without
leaving the compiled code, for one linkage or for many of one topology.
"""

from __future__ import annotations

from functools import cache
from math import cos, sqrt
from typing import NamedTuple

import numpy as np

from balance.space.conditions.rank import Conditions
from balance.space.momentum.regressor import (
    moments_workspace,
    parameters_per_body,
    rows_per_column,
)
from balance.space.momentum.regressor_kernels import planar_regressor, spatial_regressor
from kinematics.closure.newton_kernels import follow_series, newton_workspace, radius_along
from kinematics.closure.series import planar_series, series_workspace, spatial_series
from kinematics.model.arrays import Chain, freeze
from kinematics.model.spatial.displacements import place_links
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import VECTOR_WIDTH
from kinematics.numerics.linalg.pivoted_qr import (
    Factor,
    append_rows,
    contains_rows,
    factor_workspace,
    put_factor,
    take_factor,
    update_factor,
)

# Highest orders of the expansions of the motion, tried one after the other.
EXPANSION_ORDERS = (3, 8, 20)
FIRST_EXPANSION_ORDER = EXPANSION_ORDERS[0]
# Number of steps to the pose that decides whether high orders are complete.
FRESH_POSE_STEPS = 4


@cache
def generic_directions(begin: int, end: int, width: int) -> Array:
    """Generate unit directions of a fixed sequence without special relations; (count, width).

    ``δ_i = c_i / |c_i|`` with ``c_iw = cos((i width + w + 1)²)``.

    Args:
        begin: number of the first direction.
        end: number after that of the last one.
    """
    if width == 1:
        return freeze(np.ones((end - begin, 1)))
    directions = []
    for i in range(begin, end):
        ray = [cos((i * width + w + 1.0) ** 2) for w in range(width)]
        size = sqrt(sum(x * x for x in ray))
        directions.append([x / size for x in ray])
    return freeze(np.reshape(directions, (end - begin, width)))


def _orders_kernel(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def orders_kernel(chain, links, rays, orders, lower, result, workspaces):
        """Collect the conditions of orders up to the highest, after those that are known.

        The step to a fresh pose stays within the radius of convergence. A missing condition of
        high order may be too small to see there, so that several steps are needed. With one
        coordinate the series at the reference pose predicts the first step.

        Args:
            chain: in: arrays of the chain, as `Chain.walked`.
            links: in: link of each body (bodies,).
            rays: in: directions (count, width).
            orders: the highest order; whether to stop at the order that needs no other; number
                of steps to the fresh pose.
            lower: in: the factor of the conditions of lower orders, its permutation, and the
                parameters of its columns; its largest pivot, and the largest remainder that was
                cut off; the relative size of round-off; how many orders it holds.
            result: out: the rank after each order (orders,), which holds the ranks of the known
                orders on entry; the permutation (p,); the factor (≥ rank, p).
            workspaces: as from `orders_workspace`.

        Returns:
            The rank, the largest pivot and largest remainder; number of orders done; whether
            they are settled; the radius of convergence; the mismatch of the loops; the rate of
            the slowest joint, relative to the fastest; whether there were enough rays, and
            whether a finite pose was found.
        """
        goal, stop, steps = orders
        R, permutation, unknowns, scale, dropped, tolerance, done = lower
        ranks, order, out = result
        flat, for_series, (H, N, X, rows), near, (H1, N1, X1, rows1), for_steps, poses = (
            workspaces
        )
        parent, screws, _, _, columns, moves, _ = chain
        start, q, pose, carried, none, ray = poses
        _, _, _, V, C, T, residual = for_series
        count, width, per = rays.shape[0], columns.shape[1], X.shape[3]
        m, rank = count * width * per, R.shape[0]
        for k in range(permutation.size):
            order[k] = permutation[k]
        p = unknowns.size
        padded = -(-p // VECTOR_WIDTH) * VECTOR_WIDTH
        F = flat[: (p + m + 1) * padded].reshape((p + m + 1, padded))
        factor = Factor(F, order, unknowns, tolerance)
        take_factor(R, order, F)
        settled, enough_rays, pose_found, fresh = False, True, True, rows[0, :0]
        radius = slowest = mismatch = 1.0
        begin = 0
        # With several coordinates the last order costs most, and is needed least.
        for upto in range(goal - 1 if stop and width > 1 else goal, goal + 1):
            if settled or not (enough_rays and pose_found):
                break
            top = upto if stop else max(upto, FIRST_EXPANSION_ORDER)
            here, turned = V[:count], T[:count]
            # Series of the motion, and rows X_k of the regressor, for orders begin … upto.
            for k in range(begin, upto + 1):
                for i in range(m):
                    for j in range(rows.shape[2]):
                        rows[k, i, j] = 0.0
            if dim == 3:
                planar_series(begin, top, chain, screws, rays, for_series)
                planar_regressor(begin, upto, none, links, moves, here, turned, H, N, X[begin:])
            else:
                spatial_series(begin, top, chain, screws, rays, for_series)
                spatial_regressor(
                    begin, upto, none, links, moves, here, turned, H, N, X[begin:]
                )
            begin = upto + 1
            # mismatch = max_k |residual_k|
            mismatch = 0.0
            for k in range(top + 1):
                mismatch = max(mismatch, residual[k])
            rates = for_steps[2]
            radius = radius_along(C[0, : top + 1], rays[0], rates)
            # slowest = min_j |rate_j| / max_j |rate_j|
            least, largest = np.inf, 0.0
            for j in range(parent.size):
                rate = abs(rates[0, j])
                least, largest = min(least, rate), max(largest, rate)
            slowest = least / largest
            while enough_rays and pose_found and not settled and done <= upto:
                series = RaySeries(rows[done : upto + 1], m, width * per, width, done, radius)
                rank, scale, dropped, more, settled, enough_rays = collect_orders(
                    factor, rank, scale, dropped, series, fresh, stop, ranks[done:]
                )
                done += more
                stalled = done > 1 and ranks[done - 1] == ranks[done - 2]
                if not enough_rays or settled or fresh.shape[0] > 0:
                    continue
                if not stalled and upto < goal:
                    continue
                # Steps along the ray to a finite pose, and the rows X_0 there.
                pose_found, s = False, screws
                for j in range(parent.size):
                    start[j] = 0.0
                for step in range(steps):
                    if step == 0 and width == 1:
                        ahead = C[count - 1, : top + 1]
                    else:
                        last = min(FIRST_EXPANSION_ORDER, top)
                        if dim == 3:
                            planar_series(0, last, chain, s, ray, near)
                        else:
                            spatial_series(0, last, chain, s, ray, near)
                        ahead = near[4][0, : last + 1]
                    length = follow_series(
                        chain, start, ahead, ray[0], np.inf, q, pose, carried, for_steps
                    )
                    if length == 0.0:
                        if pose_found:
                            place_links(parent, screws, start, pose, carried, for_steps[3][0])
                        break
                    pose_found, s = True, carried
                    for j in range(parent.size):
                        start[j] = q[j]
                if not pose_found:
                    continue
                fresh = rows1[0]
                for i in range(fresh.shape[0]):
                    for j in range(fresh.shape[1]):
                        fresh[i, j] = 0.0
                if dim == 3:
                    planar_series(0, 0, chain, s, ray, near)
                    planar_regressor(0, 0, pose, links, moves, near[3], near[5], H1, N1, X1)
                else:
                    spatial_series(0, 0, chain, s, ray, near)
                    spatial_regressor(0, 0, pose, links, moves, near[3], near[5], H1, N1, X1)
                settled = contains_rows(factor, rank, fresh, 1.0, scale)
        put_factor(F, order, rank, out)
        settled = settled and enough_rays and pose_found
        return (
            rank, scale, dropped, done, settled, radius, mismatch, slowest, enough_rays,
            pose_found,
        )  # fmt: skip

    return orders_kernel


spatial_conditions_up_to_order, planar_conditions_up_to_order = (
    _orders_kernel(6),
    _orders_kernel(3),
)


def fresh_steps(goal: int) -> int:
    """Give the number of steps to the pose at which conditions up to an order are checked."""
    return 1 if goal == FIRST_EXPANSION_ORDER else FRESH_POSE_STEPS


def orders_workspace(
    chain: Chain, rays: int, goal: int, per: int, size: int, unknowns: int
) -> tuple[object, ...]:
    """Allocate the workspace for the conditions of several orders.

    Args:
        rays: largest number of rays.
        goal: the highest order.
        per: momentum components of each column.
        size: parameters of each body.
        unknowns: columns of the factor.
    """
    n, m = chain.parent.size, 3 if chain.planar else 4
    series, near = (
        series_workspace(chain, rays, max(goal, FIRST_EXPANSION_ORDER)),
        series_workspace(chain, 1, FIRST_EXPANSION_ORDER),
    )
    moments = moments_workspace(series[3][:, : goal + 1], chain.links, chain.moves, per, size)
    fresh = moments_workspace(near[3][:, :1], chain.links, chain.moves, per, size)
    ahead = (
        np.empty(n), np.empty(n), np.empty((n, m, m)), np.empty(chain.screws.shape),
        np.empty((0, m, m)), generic_directions(100, 101, chain.width),
    )  # fmt: skip
    flat = factor_workspace(unknowns, rays * chain.width * per).ravel()
    return (
        flat,
        series,
        moments,
        near,
        fresh,
        newton_workspace(chain, max(goal, FIRST_EXPANSION_ORDER) + 1),
        ahead,
    )


class OrderResult(NamedTuple):
    """The conditions of the orders up to one of them.

    Attributes:
        conditions: all of them.
        ranks: number of independent ones after each order.
        settled: whether no other order is needed.
        convergence_radius: radius of convergence of the series.
        enough_rays: whether there were enough rays; if not, more are needed.
        pose_found: whether a finite pose was found where one was needed.
    """

    conditions: Conditions
    ranks: IntArray
    settled: bool
    convergence_radius: float
    enough_rays: bool
    pose_found: bool


def conditions_up_to_order(
    chain: Chain, rays: Array, force: bool, conditions: Conditions, ranks: IntArray,
    goal: int, stop: bool,
) -> OrderResult:  # fmt: skip
    """Add the conditions of orders up to ``goal`` to those of lower orders.

    Args:
        chain: the linkage without idle joints.
        rays: generic directions (count, width).
        force: whether only linear momentum counts.
        conditions: those of lower orders.
        ranks: number of independent conditions after each of these orders.
        goal: the highest order.
        stop: whether to stop at the order that needs no other.
    """
    per, size = rows_per_column(chain.planar, force), parameters_per_body(chain.planar, force)
    unknowns, done = conditions.columns.size, ranks.size
    all_ranks, order = np.zeros(goal + 1, np.int64), np.empty(unknowns, np.int64)
    all_ranks[:done] = ranks
    out = np.empty((unknowns, unknowns))
    shape = len(rays), goal, per, size, unknowns
    workspaces = chain.borrow(shape, lambda: orders_workspace(chain, *shape))
    orders_kernel = (
        planar_conditions_up_to_order if chain.planar else spatial_conditions_up_to_order
    )
    lower = (
        conditions.factor, conditions.permutation, conditions.columns, conditions.scale,
        conditions.dropped, conditions.tolerance, done,
    )  # fmt: skip
    orders = goal, stop, fresh_steps(goal)
    rank, scale, dropped, done, settled, radius, _, _, enough_rays, pose_found = orders_kernel(
        chain.walked, chain.links, rays, orders, lower, (all_ranks, order, out), workspaces
    )
    chain.give_back(shape, workspaces)
    more = conditions._replace(
        factor=out[:rank], permutation=order, scale=scale, dropped=dropped
    )
    return OrderResult(more, all_ranks[:done], settled, radius, enough_rays, pose_found)


class RaySeries(NamedTuple):
    """Rows of the regressor's series along rays, as kernels pass them to each other.

    Attributes:
        rows: shape (orders, ≥ rays * per_ray, parameters), non-dimensional.
        total: rows of all rays.
        per_ray: rows of each ray.
        width: number of coordinates.
        first: the first of the orders.
        radius: radius of convergence, in units of the coordinates.
    """

    rows: Array
    total: int
    per_ray: int
    width: int
    first: int
    radius: float


@kernel(reference_counting=False)
def collect_orders(factor, rank, scale, dropped, series, fresh, stop, ranks):
    """Collect the conditions of consecutive orders, along as many rays as needed.

    ``C(w + k - 1, k)`` generic rays span all derivatives of order k in w coordinates. Fewer
    are enough once the rows of one more ray follow from the others. Rows of order k are
    weighted by ``radius**k``. Fresh rows, of a finite pose, decide whether another order is
    needed. Without fresh rows, only a full column rank settles that.

    Args:
        factor: in, out: a `Factor`, with workspace for the rows of all rays.
        rank: its rows.
        dropped: the largest remainder that was cut off.
        series: in: a `RaySeries`.
        fresh: in: rows of a finite pose (m, parameters), or none of them.
        stop: whether to stop at the order that needs no other; without fresh rows, at the
            first one that adds nothing.
        ranks: out: the rank after each order (orders,).

    Returns:
        The rank, largest pivot and largest remainder; number of orders collected; whether
        no other order is needed, and whether there were enough rays.
    """
    rows, total, per_ray, width, first, radius = series
    orders, p = rows.shape[0], factor.columns.size
    settled = False
    done = 0
    for k in range(orders):
        # weight = radius**(first + k), every = C(width + first + k - 1, first + k)
        weight, every = 1.0, 1
        for i in range(first + k):
            weight *= radius
            every = every * (width + i) // (i + 1)
        used = 0
        before = rank
        # Twice as many rays each time, until the rows of the next one follow.
        while used < every and rank < p:
            wanted = 2 * used if used > 0 else -(-(p - rank) // per_ray)
            wanted = min(every, max(wanted, 1))
            if (wanted if wanted == every else wanted + 1) * per_ray > total:
                return rank, scale, dropped, done, False, False
            new = rows[k, used * per_ray : wanted * per_ray]
            append_rows(factor, rank, new, weight)
            rank, scale, remainder = update_factor(factor, rank, new.shape[0], scale)
            dropped = max(dropped, remainder)
            used = wanted
            next_ray = rows[k, used * per_ray : (used + 1) * per_ray]
            if used < every and contains_rows(factor, rank, next_ray, weight, scale):
                break
        ranks[k] = rank
        done += 1
        settled = rank == p
        if not settled and fresh.shape[0] > 0:
            settled = contains_rows(factor, rank, fresh, 1.0, scale)
        if stop and (settled or (fresh.shape[0] == 0 and rank == before)):
            break
    return rank, scale, dropped, done, settled, True
