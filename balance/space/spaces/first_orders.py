"""The first orders of a design space in one call of compiled code.

Transfers, the conditions of the orders of the first expansion and their null space, for one
linkage: in most linkages no other order is needed. Between separate calls of kernels, Python
would take longer than they do.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from balance.space.conditions.collect import ray_count, relative_tolerance
from balance.space.conditions.order_kernels import (
    FIRST_EXPANSION_ORDER,
    OrderResult,
    fresh_steps,
    generic_directions,
    orders_workspace,
    planar_conditions_up_to_order,
    spatial_conditions_up_to_order,
)
from balance.space.conditions.rank import Conditions, Decision
from balance.space.momentum.regressor import parameters_per_body, rows_per_column
from balance.space.transfers.compute_transfers import (
    Transfers,
    enough_states,
    search_transfers,
    search_workspace,
)
from balance.space.transfers.rigid_parts import number_rigid_parts
from kinematics.model.arrays import Chain, freeze
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.null_space import put_solutions
from kinematics.numerics.linalg.pivoted_qr import factor_workspace, refactor


def _first_orders_kernel(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def first_orders_kernel(
        chain, links, rigid_parts, sizes, tolerance, rays, orders, out, work
    ):
        """Compute transfers, the conditions of the first orders, and their null space.

        Args:
            chain: in: arrays of the chain, as `Chain.walked`.
            links: in: link of each body (bodies,).
            rigid_parts: in: as from `number_rigid_parts`.
            sizes: parameters of each body; momentum components that count.
            tolerance: relative size of round-off.
            rays: in: directions (count, width).
            orders: the highest order; whether to stop at the order that needs no other; number
                of steps to the fresh pose.
            out: out: transfers as a triangular factor, and the order in which its columns are
                eliminated; the columns left, the factor of the conditions on them, and the
                order likewise; the null space as rows; the rank after each order. Those of two
                dimensions are flat, and have a place for all parameters in each row.
            work: workspaces of the search for transfers, of their factor, and of the orders.

        Returns:
            Number of transfers, -1 if there is too little workspace for their search; rank of
            their factor; what the kernel of the orders returns.
        """
        known, known_order, columns, factor, order, basis, ranks = out
        searched, F, for_orders = work
        parent, screws = chain[0], chain[1]
        size, rows = sizes
        count = search_transfers(parent, screws, rigid_parts, size, rows, tolerance, searched)
        transfers, total = searched[0][: max(count, 0)], known_order.size
        # Known solutions are projected out: one unknown is left out for each of them.
        for j in range(total):
            columns[j] = j
        square = known.reshape((total, total))
        serial = refactor(
            square[:0], transfers, columns, tolerance, 1.0, F, known_order, square
        )[0]
        for j in range(serial):
            columns[known_order[j]] = -1
        p = 0
        for j in range(total):
            if columns[j] >= 0:
                columns[p] = columns[j]
                p += 1
        columns, order = columns[:p], order[:p]
        for j in range(p):
            order[j] = j
        conditions = factor[: p * p].reshape((p, p))
        lower = conditions[:0], order, columns, 0.0, 0.0, tolerance, 0
        result = ranks, order, conditions
        if dim == 3:
            answer = planar_conditions_up_to_order(
                chain, links, rays, orders, lower, result, for_orders
            )
        else:
            answer = spatial_conditions_up_to_order(
                chain, links, rays, orders, lower, result, for_orders
            )
        solutions = basis[: (total - answer[0]) * total].reshape((total - answer[0], total))
        put_solutions(square[:serial], conditions[: answer[0]], order, columns, solutions)
        return count, serial, answer

    return first_orders_kernel


_spatial_first_orders, _planar_first_orders = (
    _first_orders_kernel(6),
    _first_orders_kernel(3),
)


class FirstOrders(NamedTuple):
    """What the first orders give.

    Attributes:
        transfers: inertia transfers.
        orders: the conditions, and whether they are all there are.
        decision: the null space of these conditions.
    """

    transfers: Transfers
    orders: OrderResult
    decision: Decision


def first_orders(chain: Chain, force: bool, max_order: int | None) -> FirstOrders | None:
    """Compute the transfers, and the conditions of the first orders, of a chain.

    Args:
        chain: the linkage without idle joints.
        force: whether only linear momentum counts.
        max_order: the highest order, computed exactly; None for the first expansion.

    Returns:
        They and their null space; None if bodies of one rigid part share parameters, or the
        workspace is too small.
    """
    parts = chain.once(number_rigid_parts)
    if chain.once(_bodies_share_parts):
        return None
    size, rows = parameters_per_body(chain.planar, force), rows_per_column(chain.planar, force)
    total, goal = chain.links.size * size, FIRST_EXPANSION_ORDER
    if max_order is not None:
        goal = max_order
    count = ray_count(chain, total, force)
    shape = "first orders", count, goal, rows, size
    tolerance = relative_tolerance(chain)
    work = chain.borrow(shape, lambda: _workspace(chain, count, goal, rows, size))
    out = (
        np.empty(total * total), np.empty(total, np.int64), np.empty(total, np.int64),
        np.empty(total * total), np.empty(total, np.int64), np.empty(total * total),
        np.zeros(goal + 1, np.int64),
    )  # fmt: skip
    first_orders_kernel = _planar_first_orders if chain.planar else _spatial_first_orders
    transfers, serial, answer = first_orders_kernel(
        chain.walked, chain.links, parts, (size, rows), tolerance,
        generic_directions(0, count, chain.width), (goal, max_order is None, fresh_steps(goal)),
        out, work,
    )  # fmt: skip
    results = None
    if transfers >= 0:
        results = _results(chain, out, work[0], transfers, serial, answer, tolerance)
    chain.give_back(shape, work)
    return results


def _results(
    chain: Chain, out: tuple[Any, ...], searched: tuple[Any, ...], count: int, serial: int,
    answer: tuple[Any, ...], tolerance: float,
) -> FirstOrders:  # fmt: skip
    """Name the results of the kernel; see there."""
    known, known_order, columns, factor, order, basis, ranks = out
    rank, scale, dropped, done, settled, radius, _, _, enough_rays, pose_found = answer
    total = known_order.size
    p, nullity = total - serial, total - rank
    conditions = Conditions(
        factor[: rank * p].reshape(rank, p), order[:p], columns[:p],
        known[: serial * total].reshape(serial, total), known_order[:serial], tolerance,
        scale, dropped,
    )  # fmt: skip
    rows, owner, (kept, lost) = (
        searched[0][:count].copy(),
        searched[1][:count].copy(),
        searched[2],
    )
    node, _, joints = chain.once(number_rigid_parts)
    transfers = Transfers(rows, owner, joints, node, float(kept), float(lost))
    orders = OrderResult(conditions, ranks[:done], settled, radius, enough_rays, pose_found)
    decision = Decision(conditions, freeze(basis[: nullity * total].reshape(nullity, total).T))
    return FirstOrders(transfers, orders, decision)


def _workspace(chain: Chain, rays: int, goal: int, rows: int, size: int) -> tuple[Any, ...]:
    """Allocate the workspaces of the kernel."""
    total, (n, dim) = chain.links.size * size, chain.screws.shape
    states = enough_states(n, size)
    return (
        search_workspace(n, dim, total, size, rows, states),
        factor_workspace(total, 2 * states),
        orders_workspace(chain, rays, goal, rows, size, total),
    )


def _bodies_share_parts(chain: Chain) -> bool:
    """Whether bodies are fixed to one another or to the ground, and exchange parameters."""
    node, _, joints = chain.once(number_rigid_parts)
    parts = node[chain.links].tolist()
    return joints.size in parts or len(set(parts)) < len(parts)
