"""Compiled loop of `balance.space.many.many_geometries`, one geometry after the other.

All workspaces belong to one thread; see `sweep_workspace`.
"""

from __future__ import annotations

import numpy as np

from balance.space.conditions.order_kernels import (
    EXPANSION_ORDERS,
    FRESH_POSE_STEPS,
    orders_workspace,
    planar_conditions_up_to_order,
    spatial_conditions_up_to_order,
)
from balance.space.transfers.serial_part import search_transfers, search_workspace
from balance.support.tolerances import (
    DROPPED_CLEARLY,
    KEPT_CLEARLY,
    SHORT_CONVERGENCE_RADIUS,
    SWEEP_CLOSURE_RESIDUAL,
    SWEEP_PIVOT_CLEAR,
    SWEEP_REGULAR,
    SWEEP_SLOWEST,
)
from kinematics.model.arrays import Chain
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.null_space import put_solutions
from kinematics.numerics.linalg.pivoted_qr import factor_workspace, refactor, smallest_pivot
from kinematics.numerics.linalg.skyline_qr import COUNT, ROWS, factor_envelope, fill_envelope
from kinematics.numerics.tolerances import RANK_MARGIN


@kernel(reference_counting=False)
def _loops_are_regular(screws, mimics, envelope, F, diagonal):
    """Decide whether the loop matrix S determines the dependent joints, by pivots of its QR.

    Args:
        screws: in: joint screws (n, dim).
        mimics: in: mimic relations (rows, n).
        envelope: in: envelope of S; see `kinematics.numerics.linalg.skyline_qr`.
        F: workspace for its factor.
        diagonal: out: its pivots (nd,).
    """
    fill_envelope(screws, mimics, envelope, F)
    factor_envelope(F, envelope, diagonal)
    least, largest = np.inf, 0.0
    for d in range(diagonal.size):
        least, largest = min(least, abs(diagonal[d])), max(largest, abs(diagonal[d]))
    return least > SWEEP_REGULAR * largest


@kernel(reference_counting=False)
def _sort_remaining(permutation, omitted, place, remaining):
    """Sort the entries of a permutation that follow the first ``omitted`` ones.

    Args:
        permutation: in: (p,).
        omitted: number of entries that are left out.
        place: workspace (≥ p,).
        remaining: out: the others, ascending (≥ p - omitted,).
    """
    for k in range(permutation.size):
        place[permutation[k]] = k
    count = 0
    for j in range(permutation.size):
        if place[j] >= omitted:
            remaining[count] = j
            count += 1


def _sweep_kernel(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def sweep(topology, geometries, sizes, results, workspaces):
        """Find rank, nullity, serial nullity and kmax of each geometry; rank -1 if unsettled.

        Args:
            topology: in: arrays of the chain, as `Chain.walked`; rigid parts, as from
                `number_rigid_parts`; link of each body (bodies,); transfers between bodies of
                rigid parts (count, parameters); directions (rays, width).
            geometries: in: joint screws (g, n, dim), mimic relations (g, rows, n), relative
                sizes of round-off (g,) and lengths of the frames (g,); see `place_geometry`.
            sizes: rays to begin with, momentum components that count, parameters of each body.
            results: in, out: the four integers (g, 4), -1 where unknown; smallest pivots,
                relative to the largest
                (g,); orthonormal bases as rows (g, parameters, parameters), or (0, …).
            workspaces: as from `sweep_workspace`.
        """
        chain, rigid_parts, links, rigid, rays = topology
        screws, mimics, tolerances, lengths = geometries
        fewest, per, size = sizes
        answers, kept, bases = results
        parent, _, ends, _, columns, moves, envelope = chain
        for_orders, for_search, numbers, flat, diagonal, serial, out = workspaces
        unknowns, transfers, nd = links.size * size, for_search[0], diagonal.size
        all_columns, order, remaining = numbers[0], numbers[1], numbers[2]
        ranks, permutations = numbers[3], numbers[4]
        _, _, (F, _, _, _, _, _, _), _, _, _, _, _ = for_orders[0]
        for g in range(screws.shape[0]):
            if answers[g, 0] >= 0:
                continue
            s, m, tolerance = screws[g], mimics[g], tolerances[g]
            if (
                lengths[g] <= 0.0
                or envelope[COUNT, ROWS] < nd
                or not _loops_are_regular(s, m, envelope, F, diagonal)
            ):
                continue
            # The serial space: transfers, reduced to a triangular factor.
            count = search_transfers(parent, s, rigid_parts, size, per, tolerance, for_search)
            gap = for_search[2]
            if count < 0 or gap[0] < KEPT_CLEARLY or gap[1] > DROPPED_CLEARLY * tolerance:
                continue
            for j in range(unknowns):
                all_columns[j] = j
            height, _, _ = refactor(
                rigid,
                transfers[:count],
                all_columns[:unknowns],
                tolerance,
                1.0,
                flat,
                order[:unknowns],
                serial,
            )
            _sort_remaining(order[:unknowns], height, ranks, remaining)
            p = unknowns - height
            here = (parent, s, ends, m, columns, moves, envelope)
            # The conditions, up to higher orders each time until they are settled, along twice
            # as many rays each time until they are enough.
            count, stage = fewest, 0
            rank, scale, dropped, done, settled = 0, 0.0, 0.0, 0, False
            radius = residual = slowest = 1.0
            permutation = permutations[:p]
            result = ranks, permutation, out
            while count <= rays.shape[0] and stage < len(EXPANSION_ORDERS):
                if stage == 0:
                    rank, scale, dropped, done = 0, 0.0, 0.0, 0
                    for k in range(p):
                        permutation[k] = k
                orders = EXPANSION_ORDERS[stage], True, 1 if stage == 0 else FRESH_POSE_STEPS
                lower = out[:rank], permutation, remaining[:p], scale, dropped, tolerance, done
                if dim == 3:
                    answer = planar_conditions_up_to_order(
                        here, links, rays[:count], orders, lower, result, for_orders[stage]
                    )
                else:
                    answer = spatial_conditions_up_to_order(
                        here, links, rays[:count], orders, lower, result, for_orders[stage]
                    )
                rank, scale, dropped, done, settled, radius = answer[:6]
                residual, slowest, enough, pose_found = answer[6:]
                if settled or not pose_found:
                    break
                if enough:
                    stage += 1
                else:
                    count, stage = 2 * count, 0
            # Written so that a NaN leaves the geometry unsettled.
            if count > rays.shape[0] or not (
                settled and residual <= SWEEP_CLOSURE_RESIDUAL and slowest >= SWEEP_SLOWEST
            ):
                continue
            R = out[:rank]
            least = smallest_pivot(R, permutation)
            floor = RANK_MARGIN * tolerance
            if rank < p:
                floor = max(floor, SWEEP_PIVOT_CLEAR)
            clear = least >= floor * scale and dropped <= DROPPED_CLEARLY * tolerance * scale
            if radius < SHORT_CONVERGENCE_RADIUS or not clear:
                continue
            kmax = done - 1
            while kmax > 0 and ranks[kmax] == ranks[kmax - 1]:
                kmax -= 1
            answers[g, 0], answers[g, 1] = rank, unknowns - rank
            answers[g, 2], answers[g, 3] = height, kmax
            kept[g] = least / scale if rank > 0 else 1.0
            if bases.shape[0] > 0:
                basis = bases[g, : unknowns - rank]
                put_solutions(serial[:height], R, permutation, remaining, basis)

    return sweep


spatial_sweep, planar_sweep = _sweep_kernel(6), _sweep_kernel(3)


def sweep_workspace(
    chain: Chain, rays: int, rigid: int, per: int, size: int
) -> tuple[object, ...]:
    """Allocate the workspace for a sweep.

    Args:
        chain: one of the linkages.
        rigid: transfers between bodies of rigid parts.
        per: momentum components of each column.
        size: parameters of each body.
    """
    n, dim = chain.screws.shape
    unknowns, transfers = chain.links.size * size, 4 * (2 * n + size)
    return (
        tuple(
            orders_workspace(chain, rays, goal, per, size, unknowns)
            for goal in EXPANSION_ORDERS
        ),
        search_workspace(n, dim, unknowns, size, per, transfers),
        np.empty((5, max(unknowns, EXPANSION_ORDERS[-1] + 1)), np.int64),
        factor_workspace(unknowns, rigid + 2 * transfers),
        np.empty(chain.dependent.size),
        np.empty((unknowns, unknowns)),
        np.empty((unknowns, unknowns)),
    )
