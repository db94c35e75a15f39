"""Loads of a linkage along motions, before and after counterweights."""

from __future__ import annotations

from dataclasses import replace

from balance.masses.counterweights.counterweights_result import Counterweights
from balance.motion.verification.before_after import compare_masses
from balance.motion.verification.given_motions import Motions


def with_loads(
    counterweights: Counterweights, motions: Motions | None = None
) -> Counterweights:
    """Add the loads along motions to counterweights that balance.

    Args:
        motions: by default the random ones of `balance.verify`.

    Raises:
        LinkageError: see `balance.verify`.
    """
    space = counterweights.space
    assert counterweights.z is not None
    along = compare_masses(
        space.linkage,
        counterweights.z,
        motions=motions,
        motion=space.motion,
        balance=space.balance,
    )
    return replace(counterweights, along=along)
