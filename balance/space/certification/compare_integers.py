"""Differences between the integers of floating point, of exact arithmetic, and of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.correct_integers import Evidence
from balance.space.spaces.design_space import DesignSpace
from kinematics.loading.meant.digits import file_digits
from kinematics.model.linkage import Notice


def list_differences(space: DesignSpace, evidence: Evidence) -> list[str]:
    """List the differences of the integers of a space from the exact ones, a line each.

    Args:
        space: the space by floating-point arithmetic.
        evidence: the findings of exact arithmetic.
    """
    exact, lines = evidence.exact, []
    ranks = [order.rank for order in space.orders]
    exact_ranks = exact.ranks + exact.ranks[-1:] * (len(ranks) - len(exact.ranks))
    apart = [
        k for k, pair in enumerate(zip(ranks, exact_ranks, strict=False)) if len({*pair}) > 1
    ]
    if apart:
        here, there = ([row[k] for k in apart] for row in (ranks, exact_ranks))
        orders = f"order{'s' if len(apart) > 1 else ''} {_list(apart)}"
        lines.append(f"{orders}: rank {_list(there)}, not {_list(here)}")
    if space.rank != exact.rank:
        lines.append(f"rank {exact.rank}, not {space.rank}")
    serial = len(evidence.independent)
    if serial != space.serial_nullity and evidence.use_exact_transfers(space.serial_nullity):
        lines.append(f"serial part {serial}, not {space.serial_nullity}")
    return lines


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))


def integers_differ(space: DesignSpace, certified: DesignSpace) -> bool:
    """Decide whether the integers of two spaces of one linkage differ."""
    if (space.rank, space.serial_nullity) != (certified.rank, certified.serial_nullity):
        return True
    ranks = {order.order: order.rank for order in certified.orders}
    return any(ranks.get(order.order, certified.rank) != order.rank for order in space.orders)


def add_correction_notice(space: DesignSpace, certified: CertifiedSpace) -> CertifiedSpace:
    """Add the notice ``corrected``, with the exact integers, if floating point finds others.

    It lists all of them: which of them floating point misses may depend on the processor.

    Args:
        space: the space by floating-point arithmetic.

    Returns:
        The certified space; unchanged if the integers are the same.
    """
    if not integers_differ(space, certified):
        return certified
    ranks = " ".join(str(order.rank) for order in certified.orders)
    text = (
        f"floating point alone finds other integers; exact arithmetic: rank {certified.rank}, "
        f"serial part {certified.serial_nullity}, ranks by order {ranks}"
    )
    tree = space.linkage.tree
    if tree is not None and file_digits(tree) is not None:
        text += (
            "; these are of the numbers as written: a pose inside the digits of the file may "
            "have fewer conditions at an order before the last"
        )
    codes = ("not_settled",) if certified.settled else ()
    kept = tuple(notice for notice in certified.notices if notice.code not in codes)
    return replace(certified, notices=(*kept, Notice("corrected", text)))
