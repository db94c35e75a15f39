"""The size of a part for the least matter, between two bounds."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, floor, isfinite, log

from balance.support.tolerances import MASSES_EQUAL
from kinematics.numerics.linalg.ties import rank_least_first

# Steps of a size of 1 that are told apart, and where the search ends, of a size.
STEPS, FINE = 100, 5e-3
# Mass that stands for none, over the largest one: finite, so that differences are numbers.
NO_MATTER = 1e6


def lightest_between(mass_of: Callable[[float], float], least: float, largest: float) -> float:
    """Search for the size between two bounds that takes the least matter.

    The logarithm of the size is followed by the method of Brent to a least mass, which is
    compared with those at the bounds.

    Args:
        mass_of: computes the least matter of a size, kg; infinite if none balances.
        least: the least size.
        largest: the largest size.

    Returns:
        The size, of two decimals between the bounds; the first one if no size has matter.

    Source:
        R. P. Brent, Algorithms for Minimization without Derivatives, 1973.

    Example:
        >>> from balance.masses.remedies.size_search import lightest_between
        >>> lightest_between(lambda size: abs(size - 0.417), 0.25, 1.0)
        0.42
    """
    from scipy.optimize import minimize_scalar

    masses = {size: mass_of(size) for size in (largest, least)}

    def finite(x: float) -> float:
        mass = mass_of(exp(x))
        known = filter(isfinite, masses.values())
        return mass if isfinite(mass) else NO_MATTER * max(known, default=1.0)

    solved = minimize_scalar(
        finite, bounds=(log(least), log(largest)), method="bounded", options={"xatol": FINE}
    )
    steps = floor(exp(float(solved.x)) * STEPS)
    for count in (steps, steps + 1):
        inside = min(max(count / STEPS, least), largest)
        if inside not in masses:
            masses[inside] = mass_of(inside)
    order = rank_least_first(list(masses.values()), relative=MASSES_EQUAL)
    return list(masses)[order[0]]
