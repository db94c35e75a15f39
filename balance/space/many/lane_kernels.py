"""Compiled loop of `balance.space.many.many_geometries` over planar linkages of one input.

As many geometries as a vector has lanes are treated side by side: closure, momentum, transfers
and rank. Decisions are those of `balance.space.many.many_geometries_kernels`, which treats one
geometry after the other. Lanes in which a rank differs from that of most others are collected
and tried again among their kind; what is then left is left to that loop.
"""

from __future__ import annotations

import numpy as np

from balance.space.conditions.order_kernels import (
    EXPANSION_ORDERS,
    FIRST_EXPANSION_ORDER,
    FRESH_POSE_STEPS,
)
from balance.space.momentum.lane_regressor import lane_regressor
from balance.space.transfers.lane_transfers import fill_lane_transfers
from balance.support.tolerances import (
    DROPPED_CLEARLY,
    SHORT_CONVERGENCE_RADIUS,
    SWEEP_CLOSURE_RESIDUAL,
    SWEEP_PIVOT_CLEAR,
    SWEEP_REGULAR,
    SWEEP_SLOWEST,
)
from kinematics.closure.lane_poses import follow_lanes, radius_lanes
from kinematics.closure.lane_series import lane_series
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import VECTOR_WIDTH, broadcast, load_vector, store_vector
from kinematics.numerics.linalg.lane_pivoted_qr import (
    absorb_rows,
    append_lanes,
    rows_follow_lanes,
)
from kinematics.numerics.linalg.null_space import put_solutions
from kinematics.numerics.tolerances import RANK_MARGIN

# Fewest geometries that are worth it.
FEWEST_LANES = 3


@kernel(reference_counting=False)
def _load_lanes(geometries, which, screws, mimics, tolerances):
    """Copy geometries into lanes; unused lanes get the last of them.

    Args:
        geometries: in: screws, mimic relations, sizes of round-off, lengths of the frames.
        which: in: numbers of the geometries (≤ lanes,).
        screws: out: (n, 3, lanes).
        mimics: out: (rows, n, lanes).
        tolerances: out: relative sizes of round-off (lanes,).
    """
    for lane in range(VECTOR_WIDTH):
        g = which[min(lane, which.size - 1)]
        tolerances[lane] = geometries[2][g]
        for j in range(screws.shape[0]):
            for i in range(3):
                screws[j, i, lane] = geometries[0][g, j, i]
        for r in range(mimics.shape[0]):
            for j in range(mimics.shape[1]):
                mimics[r, j, lane] = geometries[1][g, r, j]


@kernel(reference_counting=False)
def _find_regular(diagonal, count, active, state):
    """Find the lanes whose loop matrix determines the dependent joints; give up the others.

    Args:
        diagonal: in: pivots of the loop matrices (nd, lanes).
        count: number of lanes in use.
        active: out: whether a lane is regular (lanes,).
        state: out: as in `LaneSweep`.
    """
    for lane in range(VECTOR_WIDTH):
        least, largest = np.inf, 0.0
        for d in range(diagonal.shape[0]):
            least = min(least, abs(diagonal[d, lane]))
            largest = max(largest, abs(diagonal[d, lane]))
        active[lane] = lane < count and least > SWEEP_REGULAR * largest
        state[lane] = active[lane] - 1


@kernel(reference_counting=False)
def _reduce_transfers(count, rigid, serial, factor, place):
    """Reduce the transfers to triangular factors; list the unknowns that are left, ascending.

    Args:
        count: number of transfers through joints, which the rows of ``serial`` hold.
        rigid: in: transfers between bodies of rigid parts (count, unknowns).
        serial: in, out: factors of the transfers, a `LaneFactor`.
        factor: out: those of the conditions, without rows; its columns are the unknowns left.
        place: workspace (unknowns,).

    Returns:
        The number of independent transfers.
    """
    unknowns = serial.F.shape[1]
    for r in range(rigid.shape[0]):
        for u in range(unknowns):
            store_vector(serial.F[count + r, u], 0, broadcast(rigid[r, u]))
    for lane in range(VECTOR_WIDTH):
        factor.limits[0, lane] = serial.limits[0, lane]
        serial.limits[1, lane], serial.limits[2, lane] = 1.0, 0.0
        for u in range(unknowns):
            serial.columns[u, lane] = u
    height = absorb_rows(serial, unknowns, 0, count + rigid.shape[0])
    for lane in range(VECTOR_WIDTH):
        factor.active[lane] = serial.active[lane]
        factor.limits[1, lane] = factor.limits[2, lane] = 0.0
        for k in range(unknowns):
            place[serial.columns[k, lane]] = k
        j = 0
        for u in range(unknowns):
            if place[u] >= height:
                factor.columns[j, lane] = u
                j += 1
    return height


@kernel(reference_counting=False)
def _put_basis(lane, counts, serial, factor, lane_work, basis):
    """Write the orthonormal basis of one lane.

    Args:
        counts: number of transfers, of columns, and the rank.
        serial: in: factors of the transfers.
        factor: in: factors of the conditions.
        lane_work: workspace, a `OneLane`.
        basis: out: rows (nullity, unknowns).
    """
    height, p, rank = counts
    order, columns, serial_rows, R = lane_work
    for i in range(height):
        for j in range(serial_rows.shape[0]):
            serial_rows[i, serial.columns[j, lane]] = serial.F[i, j, lane] if j >= i else 0.0
    for j in range(p):
        order[j], columns[j] = j, factor.columns[j, lane]
        for i in range(rank):
            R[i, j] = factor.F[i, j, lane] if j >= i else 0.0
    put_solutions(serial_rows[:height], R[:rank, :p], order[:p], columns, basis)


@kernel(reference_counting=False)
def _settle(lane, g, counts, kmax, checks, factor, results):
    """Write the answers of a lane whose conditions are complete, if they are clear.

    Args:
        g: number of its geometry.
        counts: number of transfers, of columns, and the rank.
        kmax: highest order that adds a condition.
        checks: in: squares of the closure residuals (lanes,), and `radius_lanes` (4,
            lanes).
        factor: in: factors of the conditions.
        results: out: integers, smallest pivots and bases, as in the loop of one geometry.

    Returns:
        Whether they are clear.
    """
    height, p, rank = counts
    residual, radius = checks
    tolerance, scale = factor.limits[0, lane], factor.limits[1, lane]
    least, floor = np.inf, RANK_MARGIN * tolerance
    for i in range(rank):
        least = min(least, abs(factor.F[i, i, lane]))
    if rank < p:
        floor = max(floor, SWEEP_PIVOT_CLEAR)
    # Written so that a NaN leaves the geometry unsettled.
    if not (
        np.sqrt(residual[lane]) <= SWEEP_CLOSURE_RESIDUAL
        and radius[1, lane] >= SWEEP_SLOWEST
        and radius[0, lane] >= SHORT_CONVERGENCE_RADIUS
        and least >= floor * scale
        and factor.limits[2, lane] <= DROPPED_CLEARLY * tolerance * scale
    ):
        return False
    answers, kept, _ = results
    answers[g, 0], answers[g, 1] = rank, height + p - rank
    answers[g, 2], answers[g, 3] = height, kmax
    kept[g] = least / scale if rank > 0 else 1.0
    return True


@kernel(reference_counting=False)
def _fresh_rows(chain, links, steps, screws, mimics, C, orders, radius, fresh, active):
    """Write the momentum rows of every lane at a finite pose, some steps along its motion.

    Args:
        chain: in: arrays of the chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        screws: in: joint screws at the reference pose (n, 3, lanes).
        mimics: in: mimic relations (rows, n, lanes).
        C: in: joint rates of the series there (≥ orders, n, lanes).
        orders: how many orders of it count.
        radius: in: its radius of convergence (lanes,).
        fresh: out: a `FreshPose`.
        active: in, out: lanes that count; those that reach no pose do not any more (lanes,).
    """
    series, H, N, X, _, here, poses = fresh
    for j in range(screws.shape[0]):
        store_vector(poses.start[j], 0, broadcast(0.0))
    follow_lanes(chain, screws, mimics, C, orders, radius, series.factor, poses, active)
    for _ in range(1, steps):
        for j in range(screws.shape[0]):
            store_vector(poses.start[j], 0, load_vector(poses.q[j], 0))
        last = FIRST_EXPANSION_ORDER
        lane_series(0, last, chain, poses.screws, mimics, series)
        radius_lanes(series.C, last + 1, here)
        follow_lanes(
            chain, screws, mimics, series.C, last + 1, here[0], series.factor, poses, active
        )
    lane_series(0, 0, chain, poses.screws, mimics, series)
    lane_regressor(0, 0, poses.H, links, chain[5], series.T, H, N, X)


@kernel(reference_counting=False)
def lane_sweep(topology, geometries, size, results, pending, work):
    """Find rank, nullity, serial nullity and kmax of those geometries that lanes settle.

    Args:
        topology: in: arrays of the chain, as `Chain.walked`; link of each body (bodies,);
            transfers, as from `lane_transfers`; transfers between bodies of rigid parts
            (count, parameters).
        geometries: in: joint screws (g, n, 3), mimic relations (g, rows, n), relative sizes of
            round-off (g,) and lengths of the frames (g,); see `place_geometry`.
        size: parameters of each body.
        results: out: the four integers (g, 4), -1 where unsettled; smallest pivots, relative
            to the largest (g,); orthonormal bases as rows (g, parameters, parameters), or
            (0, …).
        pending: workspace (g,).
        work: workspace, a `LaneSweep`.
    """
    chain, links, listed, rigid = topology
    answers, lengths, count = results[0], geometries[3], 0
    screws, mimics, series, H, N, X, all_rows, radius = work[:8]
    fresh, serial, factor, weight, ranks, state, lane_work = work[8:]
    unknowns, active = factor.F.shape[1], factor.active
    for g in range(lengths.size):
        answers[g, 0] = -1
        if lengths[g] > 0.0:
            pending[count] = g
            count += 1
    # Lanes that differ from most others are tried again among their kind.
    first, end, deferred = 0, count, 0
    while True:
        if first >= end:
            first, end, deferred = 0, deferred, 0
        which = pending[first : min(first + VECTOR_WIDTH, end)]
        first += which.size
        if which.size < FEWEST_LANES:
            if deferred == 0:
                break
            continue
        _load_lanes(geometries, which, screws, mimics, serial.limits[0])
        lane_series(0, 0, chain, screws, mimics, series)
        _find_regular(series.factor.diagonal, which.size, serial.active, state)
        fill_lane_transfers(listed, size, screws, serial.F)
        height = _reduce_transfers(listed.shape[0], rigid, serial, factor, lane_work.order)
        p, rank, begin, open_lanes = unknowns - height, 0, 0, which.size
        for stage in range(len(EXPANSION_ORDERS)):
            goal, has_fresh = EXPANSION_ORDERS[stage], False
            if open_lanes == 0:
                break
            lane_series(max(begin, 1), goal, chain, screws, mimics, series)
            lane_regressor(begin, goal, fresh.poses.H[:0], links, chain[5], series.T, H, N, X)
            radius_lanes(series.C, goal + 1, radius)
            for k in range(begin, goal + 1):
                before, rows = rank, all_rows[k]
                for lane in range(VECTOR_WIDTH):
                    weight[lane] = radius[0, lane] ** k
                append_lanes(factor, p, rank, rows, weight)
                rank = absorb_rows(factor, p, rank, rows.shape[0])
                ranks[k] = rank
                # A stalled rank, and that after the last order, are checked at a finite pose.
                if rank < p and not has_fresh and (k == goal or (k > 0 and rank == before)):
                    _fresh_rows(
                        chain,
                        links,
                        1 if stage == 0 else FRESH_POSE_STEPS,
                        screws,
                        mimics,
                        series.C,
                        goal + 1,
                        radius[0],
                        fresh,
                        active,
                    )
                    has_fresh = True
                if rank < p and not has_fresh:
                    continue
                rows_follow_lanes(factor, p, rank, fresh.rows)
                kmax = k
                while kmax > 0 and ranks[kmax] == ranks[kmax - 1]:
                    kmax -= 1
                open_lanes, counts = 0, (height, p, rank)
                for lane in range(which.size):
                    if active[lane] and (rank == p or factor.limits[3, lane] >= 0.0):
                        active[lane], state[lane], g = 0, -1, which[lane]
                        if _settle(
                            lane, g, counts, kmax, (series.residual, radius), factor, results
                        ):
                            state[lane] = 1
                            if results[2].shape[0] > 0:
                                basis = results[2][g, : unknowns - rank]
                                _put_basis(lane, counts, serial, factor, lane_work, basis)
                    open_lanes += active[lane]
                if open_lanes == 0:
                    break
            begin = goal + 1
        settled = 0
        for lane in range(which.size):
            settled += state[lane] == 1
        for lane in range(which.size if settled else 0):
            if state[lane] == 0:
                pending[deferred] = which[lane]
                deferred += 1
