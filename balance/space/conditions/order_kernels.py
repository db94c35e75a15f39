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


def _ray_kernel(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def ray_kernel(ray, first, last, far, chain, screws, start, links, rays, series, moments):
        """Expand the motion along one ray, and the rows of the regressor.

        Args:
            ray: number of the ray; ray 0 comes first.
            first: first order that is not known.
            last: last order of the rows.
            far: last order of the motion.
            chain: in: arrays of the chain, as `Chain.walked`.
            screws: in: joint screws at the pose (n, dim).
            start: in: displacements of the links at the pose, or none of them.
            links: in: link of each body (bodies,).
            rays: in: directions (count, width).
            series: in, out: as from `series_workspace`.
            moments: in, out: as from `moments_workspace`.
        """
        _, _, _, _, _, moves, _ = chain
        _, _, _, V, _, T, _ = series
        H, N, X, rows = moments
        per_ray = moves.shape[1] * X.shape[3]
        rows[first : last + 1, ray * per_ray : (ray + 1) * per_ray] = 0.0
        end, new = ray + 1, X[first:]
        if dim == 3:
            planar_series(first, far, ray, end, chain, screws, rays, series)
            planar_regressor(first, last, ray, end, start, links, moves, V, T, H, N, new)
        else:
            spatial_series(first, far, ray, end, chain, screws, rays, series)
            spatial_regressor(first, last, ray, end, start, links, moves, V, T, H, N, new)

    return ray_kernel


_expand_spatial_ray, _expand_planar_ray = _ray_kernel(6), _ray_kernel(3)


def _orders_kernel(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def orders_kernel(chain, links, rays, orders, lower, result, workspaces):
        """Collect the conditions of orders up to the highest, after those that are known.

        Rays are expanded as far as conditions need them: the first one to the highest order,
        which gives the radius of convergence. Rows of order k are weighted by ``radius**k``.

        The step to a fresh pose stays within that radius. A missing condition of high order may
        be too small to see there, so that several steps are needed. With one coordinate the
        series at the reference pose predicts the first step.

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
            they are settled; the radius of convergence; the largest closure residual; the rate
            of the slowest joint, relative to the fastest; whether there were enough rays, and
            whether a finite pose was found.
        """
        goal, stop, steps = orders
        R, permutation, unknowns, scale, dropped, tolerance, done = lower
        ranks, order, out = result
        flat, known, for_series, moments, near, fresh_moments, for_steps, poses = workspaces
        parent, screws, _, _, columns, _, _ = chain
        start, q, pose, carried, none, ray = poses
        _, _, _, _, C, _, residual = for_series
        _, _, _, _, near_C, _, _ = near
        _, _, X, rows = moments
        _, _, _, fresh_rows = fresh_moments
        _, _, rates, displacements = for_steps
        count, width, per = rays.shape[0], columns.shape[1], X.shape[3]
        per_ray, rank = width * per, R.shape[0]
        for k in range(permutation.size):
            order[k] = permutation[k]
        p = unknowns.size
        padded, lines = -(-p // VECTOR_WIDTH) * VECTOR_WIDTH, p + count * per_ray + 1
        F = flat[: lines * padded].reshape((lines, padded))
        factor = Factor(F, order, unknowns, tolerance)
        take_factor(R, order, F)
        settled, enough_rays, pose_found, fresh = False, True, True, rows[0, :0]
        radius = slowest = 1.0
        # Number of orders that are known along each ray.
        for i in range(count):
            known[i] = 0
        top = 0
        # With several coordinates the last order costs most, and is needed least.
        for upto in range(goal - 1 if stop and width > 1 else goal, goal + 1):
            if settled or not (enough_rays and pose_found):
                break
            top = upto if stop else max(upto, FIRST_EXPANSION_ORDER)
            if dim == 3:
                _expand_planar_ray(
                    0,
                    known[0],
                    upto,
                    top,
                    chain,
                    screws,
                    none,
                    links,
                    rays,
                    for_series,
                    moments,
                )
            else:
                _expand_spatial_ray(
                    0,
                    known[0],
                    upto,
                    top,
                    chain,
                    screws,
                    none,
                    links,
                    rays,
                    for_series,
                    moments,
                )
            known[0] = upto + 1
            radius = radius_along(C[0, : top + 1], rays[0], rates)
            # slowest = min_j |rate_j| / max_j |rate_j|
            least, largest = np.inf, 0.0
            for j in range(parent.size):
                rate = abs(rates[0, j])
                least, largest = min(least, rate), max(largest, rate)
            slowest = least / largest
            while enough_rays and pose_found and done <= upto and not (settled and stop):
                k, before, used, ready = done, rank, 0, 0
                # weight = radius**k, every = C(width + k - 1, k)
                weight, every = 1.0, 1
                for i in range(k):
                    weight *= radius
                    every = every * (width + i) // (i + 1)
                needed = 1
                while 0 < needed <= count:
                    for i in range(ready, needed):
                        if known[i] > k:
                            continue
                        if dim == 3:
                            _expand_planar_ray(
                                i,
                                known[i],
                                k,
                                k,
                                chain,
                                screws,
                                none,
                                links,
                                rays,
                                for_series,
                                moments,
                            )
                        else:
                            _expand_spatial_ray(
                                i,
                                known[i],
                                k,
                                k,
                                chain,
                                screws,
                                none,
                                links,
                                rays,
                                for_series,
                                moments,
                            )
                        known[i] = k + 1
                    ready = needed
                    rank, scale, dropped, used, needed = collect_order(
                        factor,
                        rank,
                        scale,
                        dropped,
                        rows[k, : ready * per_ray],
                        per_ray,
                        weight,
                        used,
                        every,
                    )
                enough_rays = needed == 0
                if not enough_rays:
                    continue
                ranks[k] = rank
                done += 1
                settled = rank == p
                if not settled and fresh.shape[0] > 0:
                    settled = contains_rows(factor, rank, fresh, 1.0, scale)
                stalled = stop and rank == before
                if settled or fresh.shape[0] > 0 or not (stalled or done > upto):
                    continue
                if upto < goal and not (done > 1 and rank == before):
                    continue
                # Steps along the ray to a finite pose, and the rows X_0 there.
                pose_found, s = False, screws
                for j in range(parent.size):
                    start[j] = 0.0
                for step in range(steps):
                    if step == 0 and width == 1:
                        ahead = C[0, : top + 1]
                    else:
                        last = min(FIRST_EXPANSION_ORDER, top)
                        if dim == 3:
                            planar_series(0, last, 0, 1, chain, s, ray, near)
                        else:
                            spatial_series(0, last, 0, 1, chain, s, ray, near)
                        ahead = near_C[0, : last + 1]
                    length = follow_series(
                        chain, start, ahead, ray[0], np.inf, q, pose, carried, for_steps
                    )
                    if length == 0.0:
                        if pose_found:
                            place_links(parent, screws, start, pose, carried, displacements[0])
                        break
                    pose_found, s = True, carried
                    for j in range(parent.size):
                        start[j] = q[j]
                if not pose_found:
                    continue
                fresh = fresh_rows[0]
                if dim == 3:
                    _expand_planar_ray(
                        0, 0, 0, 0, chain, s, pose, links, ray, near, fresh_moments
                    )
                else:
                    _expand_spatial_ray(
                        0, 0, 0, 0, chain, s, pose, links, ray, near, fresh_moments
                    )
                settled = contains_rows(factor, rank, fresh, 1.0, scale)
        put_factor(F, order, rank, out)
        settled = settled and enough_rays and pose_found
        # largest_residual = max_k |residual_k|
        largest_residual = 0.0
        for k in range(top + 1):
            largest_residual = max(largest_residual, residual[k])
        return (
            rank,
            scale,
            dropped,
            done,
            settled,
            radius,
            largest_residual,
            slowest,
            enough_rays,
            pose_found,
        )

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
        np.empty(n),
        np.empty(n),
        np.empty((n, m, m)),
        np.empty(chain.screws.shape),
        np.empty((0, m, m)),
        generic_directions(100, 101, chain.width),
    )
    flat = factor_workspace(unknowns, rays * chain.width * per).ravel()
    return (
        flat,
        np.empty(rays, np.int64),
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
    chain: Chain,
    rays: Array,
    force: bool,
    conditions: Conditions,
    ranks: IntArray,
    goal: int,
    stop: bool,
) -> OrderResult:
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
        conditions.factor,
        conditions.permutation,
        conditions.columns,
        conditions.scale,
        conditions.dropped,
        conditions.tolerance,
        done,
    )
    orders = goal, stop, fresh_steps(goal)
    rank, scale, dropped, done, settled, radius, _, _, enough_rays, pose_found = orders_kernel(
        chain.walked, chain.links, rays, orders, lower, (all_ranks, order, out), workspaces
    )
    chain.give_back(shape, workspaces)
    more = conditions._replace(
        factor=out[:rank], permutation=order, scale=scale, dropped=dropped
    )
    return OrderResult(more, all_ranks[:done], settled, radius, enough_rays, pose_found)


@kernel(reference_counting=False)
def collect_order(factor, rank, scale, dropped, rows, per_ray, weight, used, every):
    """Collect the conditions of one order, along as many rays as needed.

    ``C(w + k - 1, k)`` generic rays span all derivatives of order k in w coordinates. Fewer
    are enough once the rows of one more ray follow from the others.

    Args:
        factor: in, out: a `Factor`, with workspace for the rows of all rays.
        rank: its rows.
        dropped: the largest remainder that was cut off.
        rows: in: rows of the rays that are ready (rays * per_ray, parameters).
        per_ray: rows of each ray.
        weight: a factor of all rows.
        used: rays whose conditions the factor has.
        every: number of rays that span all derivatives.

    Returns:
        The rank, largest pivot and largest remainder; number of rays used; number of rays that
        have to be ready to go on, 0 if none.
    """
    p = factor.columns.size
    # Twice as many rays each time, until the rows of the next one follow.
    while used < every and rank < p:
        wanted = 2 * used if used > 0 else -(-(p - rank) // per_ray)
        wanted = min(every, max(wanted, 1))
        needed = wanted if wanted == every else wanted + 1
        if needed * per_ray > rows.shape[0]:
            return rank, scale, dropped, used, needed
        new = rows[used * per_ray : wanted * per_ray]
        append_rows(factor, rank, new, weight)
        rank, scale, remainder = update_factor(factor, rank, new.shape[0], scale)
        dropped = max(dropped, remainder)
        used = wanted
        next_ray = rows[used * per_ray : (used + 1) * per_ray]
        if used < every and contains_rows(factor, rank, next_ray, weight, scale):
            break
    return rank, scale, dropped, used, 0
