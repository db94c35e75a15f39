"""Loads of a linkage along motions, before and after matter is added for a budget."""

from __future__ import annotations

from balance.masses.partial.partial_balance import PartialBalance
from balance.motion.verification.before_after import BeforeAfter, compare_masses


def loads_of(design: PartialBalance) -> BeforeAfter:
    """Compute the loads along the motions of a design that lets a linkage shake least.

    Raises:
        LinkageError: see `balance.verify`.
    """
    assert design.z is not None
    space = design.space
    return compare_masses(
        space.linkage,
        design.z,
        motions=design.motions,
        balance=space.balance,
        about=design.point,
    )
