"""Ranks of a design space by exact arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from balance.space.exact.chain import exact_chain
from balance.space.exact.modular_ranks import ExactRanks, ranks_of
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import Balance
from kinematics.files.urdf.rational_screws import Geometry, of_lowest_rank
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion, motion_of


def exact_ranks(
    model: DesignSpace | LinkageLike,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance = "dynamic",
    max_order: int | None = None,
    *,
    spatial: bool = False,
    expected: int = 0,
) -> ExactRanks:
    """Compute the rank of the balance conditions by order, exactly, without a tolerance.

    The conditions are computed modulo two primes, from the decimals of the file. A rank
    modulo a prime is a lower bound of the true rank.

    Args:
        model: a design space, whose options are then used; or a linkage that was read from a
            file with closed loops, or what `kinematics.load` accepts.
        motion: restriction of the inputs of a linkage; see `design_space`.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        max_order: compute exactly the orders 0 … max_order, instead of as many as needed.
        spatial: count all ten parameters per body, even if the linkage is planar.
        expected: a rank that is known or believed to be reached. Without it, orders are
            added until three in a row add nothing.

    Returns:
        Ranks by order, each a lower bound of the true one, with their witness modulo a prime.

    Raises:
        ExactError: the linkage is not from a file with closed loops, or its loops do not
            close exactly, or relations of rates need too many square roots.
        MotionError: a relation is wrong, or the motion is that of other inputs.
        MobilityError: the linkage cannot follow the motion.
        ValueError: options are given with a design space, which has its own.

    Source:
        The conditions are those of J. J. de Jong, PhD thesis, University of Twente, chapter 5.

    Example:
        >>> import balance
        >>> exact = balance.checks.exact_ranks("robot.urdf")
        >>> exact.ranks, exact.kmax
        ((3, 6, 7, 8, 8, 8, 8), 3)
    """
    if isinstance(model, DesignSpace):
        if (motion, balance, max_order, spatial, expected) != (None, "dynamic", None, False, 0):
            raise ValueError(
                "a design space has its own options: give a linkage to change them"
            )
        ranks = tuple(order.rank for order in model.orders)
        return _lowest_ranks(
            model.linkage,
            **model.options,
            expected=model.rank,
            confirms=lambda exact: exact.rank == model.rank and _begins(exact.ranks, ranks),
        )
    linkage = as_linkage(model)
    return _lowest_ranks(
        linkage, motion, balance, max_order, spatial, expected, lambda _: False
    )


def _begins(ranks: Sequence[int], others: Sequence[int]) -> bool:
    """Whether ranks by order are the same at all orders that both have."""
    return all(a == b for a, b in zip(ranks, others, strict=False))


def _lowest_ranks(
    linkage: Linkage,
    motion: Motion | str | Sequence[str] | None,
    balance: Balance,
    max_order: int | None,
    spatial: bool,
    expected: int,
    confirms: Callable[[ExactRanks], bool],
) -> ExactRanks:
    """Compute exact ranks of the geometry that a linkage means; see `exact_ranks`."""

    def ranks(geometry: Geometry) -> ExactRanks:
        chain = exact_chain(
            linkage, geometry, motion_of(linkage, motion), balance == "force", spatial
        )
        return ranks_of(linkage.source, chain, geometry.notices, max_order, expected)

    return of_lowest_rank(linkage, ranks, lambda exact: (exact.rank, *exact.ranks), confirms)


def rank_of_geometry(space: DesignSpace, geometry: Geometry) -> int:
    """Compute the exact rank of the conditions of a space in a geometry.

    Raises:
        ExactError: the loops do not close in it.
    """
    linkage = space.linkage
    chain = exact_chain(
        linkage, geometry, space.motion, space.balance == "force", not space.planar
    )
    return ranks_of(linkage.source, chain, (), space.highest_order).rank
