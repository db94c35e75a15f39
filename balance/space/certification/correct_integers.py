"""A design space with the integers of exact arithmetic, and a basis that belongs to them.

Floating point loses a condition, or an inertia transfer, whose size is below round-off: the
product of two small angles, say. Exact arithmetic counts them; here the basis is computed again
with that many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from balance.space.conditions.collect import (
    CollectedConditions,
    add_pose_conditions,
    collect_conditions,
    relative_tolerance,
)
from balance.space.conditions.rank import singular_value_decomposition
from balance.space.exact.modular_ranks import ExactRanks
from balance.space.exact.proof import independent_transfers
from balance.space.exact.serial import ExactTransfer
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.space_data import Order, rank_table
from balance.space.transfers.serial_part import Transfers, serial_transfers
from balance.support.tolerances import KNOWN_RANK_RELATIVE
from kinematics.closure.assembly.assemble import moving_chain
from kinematics.model.arrays import Chain, Frame
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.exact_residuals import separate_rows
from kinematics.numerics.linalg.rational import combination, dot


class Evidence(NamedTuple):
    """Findings of exact arithmetic about a design space.

    Attributes:
        exact: ranks by order, lower bounds of the true ones.
        transfers: inertia transfers, none of which changes the momentum.
        independent: a largest independent subset of them.
        complete: whether they span the serial part; otherwise links without parameters
            branch, and there may be more.
        idle: numbers of the joints that do not move.
        in_doubt: those of them that are at rest at all orders computed, and not shown to be at
            rest at others.
        order: order up to which joints must be at rest, and loops close.
        inside_digits: whether the geometry is not that of the decimals of the file, but one
            inside the intervals of its digits.
    """

    exact: ExactRanks
    transfers: tuple[ExactTransfer, ...]
    independent: tuple[ExactTransfer, ...]
    complete: bool
    idle: tuple[int, ...]
    in_doubt: tuple[int, ...]
    order: int
    inside_digits: bool = False

    def use_exact_transfers(self, serial_nullity: int) -> bool:
        """Decide whether the independent transfers replace the serial part.

        They do if they span it, which is certain where the exact bounds of rank and nullity
        meet, or if they are more than the ``serial_nullity`` ones of floating point.
        """
        count = len(self.independent)
        met = self.exact.rank + count == self.exact.parameters
        return self.complete or met or count > serial_nullity

    @property
    def replaced(self) -> int:
        """Number of entries of the file that are not rational, round a root, or open a loop."""
        codes = [notice.code for notice in self.exact.notices]
        return codes.count("not_exact") + codes.count("open_in_decimals")

    @property
    def roots(self) -> int:
        """Number of entries of the file that are read as roots, sines or cosines."""
        return sum(notice.code == "read_as_root" for notice in self.exact.notices)

    @property
    def only_closed(self) -> bool:
        """Whether loops were closed that the decimals leave open, and nothing else replaced."""
        return all(notice.code != "not_exact" for notice in self.exact.notices)


def exact_orders(space: DesignSpace, exact: ExactRanks) -> tuple[Order, ...]:
    """Tabulate exact ranks up to the order that reaches the rank, or to the highest requested.

    Args:
        space: the space, which has the highest order requested.
        exact: ranks by exact arithmetic.
    """
    last = exact.kmax if space.highest_order is None else len(exact.ranks) - 1
    return rank_table(exact.ranks[: last + 1], exact.parameters)


def correct_integers(space: DesignSpace, evidence: Evidence) -> DesignSpace:
    """Give a design space the ranks and the serial part of exact arithmetic, with a basis.

    Args:
        space: the design space by floating-point arithmetic.
        evidence: the findings of exact arithmetic.

    Returns:
        The space with the exact integers; as it is, if exact arithmetic finds a lower rank by
        orders that are not settled.
    """
    exact = evidence.exact
    use_transfers = evidence.use_exact_transfers(space.serial_nullity)
    serial = len(evidence.independent) if use_transfers else space.serial_nullity
    if exact.rank < space.rank and not exact.settled:
        return space
    orders = exact_orders(space, exact)
    if (space.rank, space.serial_nullity) == (exact.rank, serial):
        settled = space.settled or exact.settled
        notices = tuple(x for x in space.notices if not settled or x.code != "not_settled")
        return replace(space, orders=orders, settled=settled, notices=notices)
    transfers = space.chain_transfers
    solutions = transfers.rows
    if use_transfers:
        transfers = _convert_transfers(space.chain, evidence, space.chain_transfers)
        solutions = _span(space.chain, evidence.exact, evidence.independent)
    gathered = _collect_as_many(space, solutions, exact)
    # Where floating point sees fewer conditions, the last directions are the least sure.
    nullity = exact.parameters - max(exact.rank, gathered.conditions.rank)
    return _with_conditions(space, gathered, transfers, orders, nullity)


def with_idle_joints(space: DesignSpace, idle: Sequence[int]) -> DesignSpace:
    """Compute a design space again with other joints idle.

    Args:
        idle: numbers of the joints that do not move.
    """
    linkage, force = space.linkage, space.balance == "force"
    still = np.isin(np.arange(len(linkage.joints)), np.array(idle, dtype=np.int64))
    chain = moving_chain(linkage, space.motion, not space.planar, idle=still)
    tolerance = relative_tolerance(chain)
    transfers = serial_transfers(chain, force, tolerance)
    gathered = collect_conditions(chain, transfers.rows, force, tolerance, space.highest_order)
    orders = rank_table(gathered.ranks, transfers.rows.shape[1])
    names = tuple(linkage.joints[j].name for j in idle)
    moved = replace(space, chain=chain, idle=names)
    return _with_conditions(moved, gathered, transfers, orders)


def with_more_poses(space: DesignSpace) -> DesignSpace:
    """Add the conditions of finite poses to a design space; itself if they add none.

    A space with conditions of poses has those of all that would be added.
    """
    if space.poses:
        return space
    force, conditions = space.balance == "force", space.decision.conditions
    more, poses, settled = add_pose_conditions(space.chain, force, conditions)
    if more.rank == conditions.rank:
        return space
    gathered = CollectedConditions(more, (), poses, settled)
    return _with_conditions(space, gathered, space.chain_transfers, space.orders)


def _collect_as_many(
    space: DesignSpace, solutions: Array, exact: ExactRanks
) -> CollectedConditions:
    """Collect as many conditions as the exact rank, beside known solutions.

    Where floating point finds more, the smallest pivots are round-off and are dropped. Where
    it finds fewer, the largest pivots below its limit are kept too.

    Args:
        solutions: rows of parameters that satisfy all conditions.
        exact: ranks by exact arithmetic.
    """
    chain, force, rank = space.chain, space.balance == "force", exact.rank
    tolerance = relative_tolerance(chain)
    gathered = collect_conditions(chain, solutions, force, tolerance, space.highest_order)
    for limit in (tolerance, KNOWN_RANK_RELATIVE):
        if gathered.conditions.rank >= rank:
            break
        conditions = gathered.conditions._replace(tolerance=limit)
        if space.highest_order is not None:
            gathered = collect_conditions(chain, solutions, force, limit, space.highest_order)
        else:
            conditions, poses, settled = add_pose_conditions(chain, force, conditions, rank)
            gathered = CollectedConditions(conditions, (), gathered.poses + poses, settled)
    conditions = gathered.conditions.first(rank)
    reached = conditions.rank == rank and exact.settled
    return gathered._replace(conditions=conditions, settled=gathered.settled or reached)


def _with_conditions(
    space: DesignSpace,
    gathered: CollectedConditions,
    transfers: Transfers,
    orders: tuple[Order, ...],
    nullity: int | None = None,
) -> DesignSpace:
    """Replace the conditions and transfers of a space.

    Args:
        orders: the new table of ranks.
        nullity: largest number of columns of the basis.
    """
    decision = gathered.conditions.decide()
    decision = decision.with_basis(decision.basis[:, :nullity])
    count = len(gathered.conditions.known)
    complete = decision.basis.shape[1] == count
    return replace(
        space,
        orders=orders,
        poses=gathered.poses,
        settled=gathered.settled or complete,
        serial_nullity=count,
        decision=decision,
        chain_transfers=transfers,
    )


def _convert_transfers(chain: Chain, evidence: Evidence, rounded: Transfers) -> Transfers:
    """Convert exact transfers to those of `balance.space.transfers`, owner by owner."""
    place = {joint: k for k, joint in enumerate(chain.joints.tolist())}
    groups: dict[int, list[ExactTransfer]] = {}
    for transfer in evidence.transfers:
        part = int(rounded.rigid_part[chain.links[transfer.target]])
        owner = -1 - part
        if transfer.joints:
            owner = int(rounded.owner_of_joint[place[transfer.joints[0]]])
        groups.setdefault(owner, []).append(transfer)
    rows = [_span(chain, evidence.exact, group) for group in groups.values()]
    owners = [np.full(len(block), owner) for owner, block in zip(groups, rows, strict=True)]
    width = rounded.rows.shape[1]
    return rounded._replace(
        rows=np.concatenate([np.empty((0, width)), *rows]),
        owner=np.concatenate([np.empty(0, np.int64), *owners]),
    )


def _span(chain: Chain, exact: ExactRanks, transfers: Sequence[ExactTransfer]) -> Array:
    """Compute orthonormal rows that span transfers, in the units of the moving chain.

    Vectors that floating point cannot tell apart are replaced by what is exactly left of them
    beside the others.
    """
    force = len(exact.chain.rows) < (3 if chain.planar else 6)
    frame = Frame(chain.frame.R, np.zeros(3), chain.frame.length)
    units = to_chain(np.eye(10), frame, chain.planar, force)
    independent = independent_transfers(exact.chain, transfers, exact.witness.prime)
    vectors = [_vector(chain, exact, units, transfer) for transfer in independent]
    if not vectors:
        return np.empty((0, units.shape[1] * chain.links.size))
    return singular_value_decomposition(separate_rows(vectors))[2][: len(vectors)]


def _vector(
    chain: Chain, exact: ExactRanks, units: Array, transfer: ExactTransfer
) -> list[Fraction]:
    """Write a transfer as parameters of all bodies, in the units of the moving chain."""
    origin = [Fraction(x) for x in chain.frame.origin.tolist()]
    z = _shift_to(origin, combination(transfer.z, exact.chain.parameters))
    moved = [dot([Fraction(x) for x in row], z) for row in units.T.tolist()]
    size = len(moved)
    vector = [Fraction(0)] * (size * len(exact.chain.links))
    for body, sign in ((transfer.target, 1), (transfer.source, -1)):
        if body >= 0:
            for p, value in enumerate(moved):
                vector[body * size + p] += sign * value
    return vector


def _shift_to(point: Sequence[Fraction], z: Sequence[Fraction]) -> list[Fraction]:
    """Shift the ten parameters z to another point o, by the parallel axis theorem.

    ``mc' = mc - m o``, ``E' = E - 2 (mc·o) 1 + mc oᵀ + o mcᵀ + m (o·o 1 - o oᵀ)``.
    """
    m, c, o = z[0], z[1:4], point
    both, square = 2 * dot(c, o), dot(o, o)
    moments = [z[4 + i] - both + 2 * c[i] * o[i] + m * (square - o[i] * o[i]) for i in range(3)]
    products = [
        z[k] + c[i] * o[j] + o[i] * c[j] - m * o[i] * o[j]
        for k, (i, j) in ((7, (0, 1)), (8, (0, 2)), (9, (1, 2)))
    ]
    return [m, *(x - m * y for x, y in zip(c, o, strict=True)), *moments, *products]
