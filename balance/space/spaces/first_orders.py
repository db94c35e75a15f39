"""The first orders of a design space in one call of compiled code.

Transfers, the conditions of the orders of the first expansion and their null space, for one
linkage: in most linkages no other order is needed. Between separate calls of kernels, Python
would take longer than they do; so it would to name every array of the answer, which is done
when somebody asks for it.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from balance.space.conditions.collect import orders_suffice, ranks_that_count, ray_count
from balance.space.conditions.order_kernels import (
    FIRST_EXPANSION_ORDER,
    OrderResult,
    fresh_steps,
    generic_directions,
    orders_workspace,
    planar_conditions_up_to_order,
    spatial_conditions_up_to_order,
)
from balance.space.conditions.rank import Conditions, Pivots
from balance.space.momentum.regressor import parameters_per_body, rows_per_column
from balance.space.spaces.space_data import Order, rank_table
from balance.space.transfers.rigid_parts import number_rigid_parts
from balance.space.transfers.serial_part import (
    Transfers,
    enough_states,
    search_transfers,
    search_workspace,
)
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.null_space import put_solutions
from kinematics.numerics.linalg.pivoted_qr import (
    factor_workspace,
    refactor,
    round_off,
    smallest_pivot,
)

# Rows of the whole numbers of the answer: the order in which the columns of the transfers are
# eliminated, the columns left, the order of these, the rank after each order, and the owner of
# each transfer.
KNOWN_ORDER, COLUMNS, ORDER, RANKS, OWNERS = range(5)


def _first_orders_kernel(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def first_orders_kernel(
        chain, links, rigid_parts, origin, length, sizes, rays, orders, work, numbers, whole
    ):
        """Compute transfers, the conditions of the first orders, and their null space.

        Args:
            chain: in: arrays of the chain, as `Chain.walked`.
            links: in: link of each body (bodies,).
            rigid_parts: in: as from `number_rigid_parts`.
            origin: in: origin of the frame (3,), metres.
            length: unit of length of the frame, metres.
            sizes: parameters of each body; momentum components that count.
            rays: in: directions (count, width).
            orders: the highest order; whether to stop at the order that needs no other; number
                of steps to the fresh pose.
            work: workspaces of the search for transfers, of their factor, and of the orders.
            numbers: out: one after the other, in rows, the transfers (count, parameters),
                their triangular factor (serial, parameters), the factor of the conditions on
                the columns left (rank, p), and the null space (parameters, nullity).
            whole: out: rows `KNOWN_ORDER`, `COLUMNS`, `ORDER`, `RANKS`, `OWNERS`.

        Returns:
            Number of transfers, -1 if there is too little workspace for their search; rank of
            their factor; smallest size that a decision of the search kept, and largest one
            that it dropped; smallest pivot of the conditions; relative size of round-off; what
            the kernel of the orders returns.
        """
        searched, F, for_orders = work
        parent, screws, (size, rows) = chain[0], chain[1], sizes
        tolerance, total = round_off(origin, length), links.size * size
        outcome = search_transfers(parent, screws, rigid_parts, size, rows, tolerance, searched)
        transfers, owners, gap = searched[0], searched[1], searched[2]
        count = max(outcome, 0)
        for i in range(count):
            whole[OWNERS, i] = owners[i]
            for j in range(total):
                numbers[i * total + j] = transfers[i, j]
        # Known solutions are projected out: one unknown is left out for each of them.
        known_order, columns = whole[KNOWN_ORDER, :total], whole[COLUMNS, :total]
        for j in range(total):
            columns[j] = j
        rest = numbers[count * total :]
        known = rest[: total * total].reshape((total, total))
        serial = refactor(
            known[:0], transfers[:count], columns, tolerance, 1.0, F, known_order, known
        )[0]
        for j in range(serial):
            columns[known_order[j]] = -1
        p = 0
        for j in range(total):
            if columns[j] >= 0:
                columns[p] = columns[j]
                p += 1
        columns, order = columns[:p], whole[ORDER, :p]
        for j in range(p):
            order[j] = j
        rest = rest[serial * total :]
        factor = rest[: p * p].reshape((p, p))
        lower = factor[:0], order, columns, 0.0, 0.0, tolerance, 0
        result = whole[RANKS], order, factor
        if dim == 3:
            answer = planar_conditions_up_to_order(
                chain, links, rays, orders, lower, result, for_orders
            )
        else:
            answer = spatial_conditions_up_to_order(
                chain, links, rays, orders, lower, result, for_orders
            )
        rank = answer[0]
        solutions = F.reshape(F.size)[: (total - rank) * total].reshape((total - rank, total))
        put_solutions(known[:serial], factor[:rank], order, columns, solutions)
        basis = rest[rank * p :]
        for j in range(total):
            for i in range(total - rank):
                basis[j * (total - rank) + i] = solutions[i, j]
        least = smallest_pivot(factor[:rank], order)
        return outcome, serial, gap[0], gap[1], least, tolerance, answer

    return first_orders_kernel


_spatial_first_orders, _planar_first_orders = (
    _first_orders_kernel(6),
    _first_orders_kernel(3),
)


class FirstOrders:
    """What the first orders give: transfers, conditions and their null space.

    Arrays are named when they are asked for.

    Attributes:
        serial: number of independent transfers.
        settled: whether no other order is needed.
        pivots: sizes of the pivots of the conditions.
        suffice: whether neither other orders, nor more rays, nor finite poses are needed.
    """

    def __init__(
        self, setup: _Setup, numbers: Array, whole: IntArray, answer: tuple[Any, ...]
    ) -> None:
        """Keep the answer of the kernel, and decide whether it is enough."""
        self._setup, self._numbers, self._whole = setup, numbers, whole
        self._count, self.serial, kept, dropped, least, tolerance, of_orders = answer
        self._gap, self._of_orders = (kept, dropped), of_orders
        self._rank, scale, _, _, self.settled, radius, _, _, enough_rays, pose_found = of_orders
        self.pivots = Pivots(least, scale, tolerance)
        self.suffice = enough_rays and pose_found
        # Where all unknowns are determined, or orders were asked for, poses add nothing.
        if setup.stop and self._rank < setup.parameters - self.serial:
            self.suffice = self.suffice and orders_suffice(self.settled, radius, self.pivots)

    @cached_property
    def _parts(self) -> list[Array]:
        """The transfers, their factor, that of the conditions, and the null space."""
        total, rank = self._setup.parameters, self._rank
        parts, at = [], 0
        for rows, columns in (
            (self._count, total),
            (self.serial, total),
            (rank, total - self.serial),
            (total, total - rank),
        ):
            end = at + rows * columns
            parts.append(self._numbers[at:end].reshape(rows, columns))
            at = end
        return parts

    def transfers(self) -> Transfers:
        """Name the inertia transfers."""
        node, _, joints = self._setup.rigid_parts
        owners = self._whole[OWNERS, : self._count]
        return Transfers(self._parts[0], owners, joints, node, *self._gap)

    @cached_property
    def conditions(self) -> Conditions:
        """The conditions of these orders."""
        _, known, factor, _ = self._parts
        serial, p = len(known), factor.shape[1]
        scale, dropped = self._of_orders[1:3]
        return Conditions(
            factor,
            self._whole[ORDER, :p],
            self._whole[COLUMNS, :p],
            known,
            self._whole[KNOWN_ORDER, :serial],
            self.pivots.tolerance,
            scale,
            dropped,
        )

    @property
    def basis(self) -> Array:
        """Orthonormal null space, the transfers first (parameters, nullity)."""
        basis = self._parts[3]
        basis.setflags(write=False)
        return basis

    @property
    def orders(self) -> OrderResult:
        """The conditions as the orders after them need them."""
        _, _, _, done, settled, radius, _, _, enough_rays, pose_found = self._of_orders
        ranks = self._whole[RANKS, :done]
        return OrderResult(self.conditions, ranks, settled, radius, enough_rays, pose_found)

    def order_table(self) -> tuple[Order, ...]:
        """Tabulate rank and nullity after each order that counts."""
        ranks = self._whole[RANKS, : self._of_orders[3]].tolist()
        counting = ranks_that_count(ranks, self.settled and self._setup.stop)
        return rank_table(counting, self._setup.parameters)


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
    setup = chain.once(_set_up, force, max_order)
    if setup is None:
        return None
    purpose, frame = ("first orders", force, max_order), chain.frame
    work = chain.borrow(purpose, lambda: _workspace(chain, setup))
    numbers, whole = np.empty(setup.count_of_numbers), np.empty(setup.shape_of_whole, np.int64)
    answer = setup.compute(
        chain.walked,
        chain.links,
        setup.rigid_parts,
        frame.origin,
        frame.length,
        setup.sizes,
        setup.rays,
        setup.orders,
        work,
        numbers,
        whole,
    )
    chain.give_back(purpose, work)
    return FirstOrders(setup, numbers, whole, answer) if answer[0] >= 0 else None


class _Setup(NamedTuple):
    """What the call needs beside the geometry.

    Attributes:
        compute: the kernel of the plane, or of space.
        rigid_parts: as from `number_rigid_parts`.
        parameters: of all bodies.
        sizes: parameters of each body, and momentum components that count.
        rays: directions (count, width).
        stop: whether to stop at the order that needs no other.
        orders: the highest order, ``stop``, and the number of steps to the fresh pose.
        count_of_numbers: how many there are in the answer at most.
        shape_of_whole: rows and columns of its whole numbers.
    """

    compute: Any
    rigid_parts: tuple[IntArray, IntArray, IntArray]
    parameters: int
    sizes: tuple[int, int]
    rays: Array
    stop: bool
    orders: tuple[int, bool, int]
    count_of_numbers: int
    shape_of_whole: tuple[int, int]


def _set_up(chain: Chain, force: bool, max_order: int | None) -> _Setup | None:
    """Prepare calls for chains of one topology; None if bodies exchange parameters."""
    rigid_parts = chain.once(number_rigid_parts)
    node, _, joints = rigid_parts
    parts = node[chain.links].tolist()
    if joints.size in parts or len(set(parts)) < len(parts):
        return None
    size, rows = parameters_per_body(chain.planar, force), rows_per_column(chain.planar, force)
    total, goal = chain.links.size * size, FIRST_EXPANSION_ORDER
    if max_order is not None:
        goal = max_order
    transfers, stop = 2 * enough_states(joints.size, size), max_order is None
    return _Setup(
        compute=_planar_first_orders if chain.planar else _spatial_first_orders,
        rigid_parts=rigid_parts,
        parameters=total,
        sizes=(size, rows),
        rays=generic_directions(0, ray_count(chain, total, force), chain.width),
        stop=stop,
        orders=(goal, stop, fresh_steps(goal)),
        # A serial space of s and conditions of rank r take s t + r (t - s) + (t - r) t ≤ 2 t².
        count_of_numbers=total * (transfers + 2 * total),
        shape_of_whole=(5, max(total, goal + 1, transfers)),
    )


def _workspace(chain: Chain, setup: _Setup) -> tuple[Any, ...]:
    """Allocate the workspaces of the kernel."""
    total, (size, rows), (n, dim) = setup.parameters, setup.sizes, chain.screws.shape
    states = enough_states(n, size)
    return (
        search_workspace(n, dim, total, size, rows, states),
        factor_workspace(total, 2 * states),
        orders_workspace(chain, len(setup.rays), setup.orders[0], rows, size, total),
    )
