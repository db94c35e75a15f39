"""Pantographs whose links turn in a constant ratio: masses for a chain and a ratio."""

from __future__ import annotations

import math
from dataclasses import replace

from balance.motion.motion_tolerances import SYNTHESIS_LINK_FLAT
from balance.studies.synthesis.balanced_pantograph import BalancedPantograph
from balance.studies.synthesis.pantograph import (
    PantographMasses,
    decouple,
    default_masses,
    match_ratio,
)
from balance.studies.synthesis.rr_chain import RRChain

# Least angle between the links at which link 2 keeps pointing to the tool.
CLEAR = math.radians(15.0)


def balance_chain(
    chain: RRChain, ratio: float, masses: PantographMasses | None = None
) -> BalancedPantograph:
    """Find masses with which the links of a chain turn in a ratio without momentum.

    The centre of link 3 is moved until C vanishes, and a moment of inertia is raised until
    ``-J2/J1`` is the ratio. Link 2 points from the moving pivot to the tool; if the
    parallelogram would be nearly flat on the way, and the payload does not forbid it, in the
    direction in which it stays furthest from that.

    Args:
        masses: to begin with; in proportion to the chain by default.

    Returns:
        The pantograph.

    Raises:
        SynthesisError: the ratio is positive.
        UsageError: a mass is none.
    """
    given = masses or default_masses(chain.length, abs(chain.reach))
    given.check()
    start = BalancedPantograph(chain, decouple(given, chain.length))
    if given.s5 is None:
        start = replace(start, link_angle=_link_angle(start.deltas))
    matched = match_ratio(start.masses, chain.length, start.payload, ratio)
    return replace(start, masses=matched)


def _link_angle(deltas: tuple[float, ...]) -> float:
    """Choose the angle from the line to the tool to link 2."""
    low, high = min(deltas), max(deltas)
    if math.floor((low - CLEAR) / math.pi) == math.floor((high + CLEAR) / math.pi):
        return 0.0
    # δ falls by as much as link 2 is turned. Its middle goes to a right angle, or, if it passes
    # a change point anyway, its value at the first position, which is the pose of the file.
    clear = high - low < math.pi - 2.0 * SYNTHESIS_LINK_FLAT
    middle = 0.5 * (low + high) if clear else deltas[0]
    return math.remainder(middle - 0.5 * math.pi, math.pi)
