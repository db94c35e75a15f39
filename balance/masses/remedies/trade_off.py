"""The trade-off of a remedy: added mass against the inertia that the inputs feel.

The momenta, the added mass and the inertia that inputs feel at the reference pose are all
linear in the added matter, which is a measure in convex sets of measures: for one geometry of a
remedy, the masses and inertias that can be reached are a convex set. Each point of its lower
border minimises ``inertia + price mass`` for some price, as a convex program, whose dual bounds
every other design:

    inertia + price mass ≥ (1 - gap) (inertia + price mass at the point).

The gear is the one size of counter-rotations in which this is not convex as it stands. A
smaller gear takes heavier rotors, which the inputs feel less: several gears are tried.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from balance.masses.counterweights.counterweights import counterweights
from balance.masses.remedies.least_matter import LeastMatter

if TYPE_CHECKING:
    from balance.masses.remedies.request import RemedyRequest

# Prices of mass, in squares of the characteristic length: from the one that makes nearly the
# least mass to the one that makes nearly the least inertia.
PRICES = 1.0, 1e-3
# Part of the inertia by which the next point must be better.
VISIBLY_LESS = 5e-3
# Gears that are tried, over the one of the request, which is the largest that may be built.
GEAR_SHARES = 0.5, 0.25


class TradeOff(NamedTuple):
    """One point of the trade-off.

    Attributes:
        added_mass: kg.
        inertia: sum of the inertias that the inputs feel at the reference pose, kg m²; those of
            sliding inputs count times the square of the characteristic length.
        gear: gear of the counter-rotations.
        price: price of mass for which ``inertia + price mass`` is least, m²; None for the least
            mass.
        gap: largest part of that sum, or of the least mass, by which it may exceed the minimum.
    """

    added_mass: float
    inertia: float
    gear: float
    price: float | None
    gap: float


def prices_of(count: int) -> list[float]:
    """List the prices of all points but the first, squares of the characteristic length."""
    prices: list[float] = np.geomspace(*PRICES, count - 1).tolist()
    return prices


def trade_off_of(
    request: RemedyRequest, least: LeastMatter, links: Sequence[str], first: TradeOff
) -> tuple[TradeOff, ...]:
    """Compute points between the least mass and the least inertia, for one geometry.

    Args:
        request: the number of points to compute, from 2 up, and the density of matter.
        least: the least matter that balances, for its space and its regions.
        links: links that may get matter.
        first: the point of least mass.

    Returns:
        The points that no other one beats in both, the lightest first.
    """
    matter = least.matter
    space, regions = matter.space, dict(matter.regions)
    parts = first.added_mass - matter.added_mass
    points = [first]
    for price in prices_of(request.trade_off):
        answer = counterweights(
            space,
            links,
            regions,
            "rotor",
            price_of_mass=price,
            density=request.density,
            thickness=request.thickness,
            relax=False,
        )
        if answer.verdict == "feasible" and answer.value is not None:
            mass, area = answer.added_mass + parts, space.length**2
            gap = answer.gap or 0.0
            points.append(TradeOff(mass, answer.value, first.gear, price * area, gap))
    return best_points(points)


def best_points(points: Iterable[TradeOff]) -> tuple[TradeOff, ...]:
    """Leave out points whose inertia a lighter one beats, or nearly equals."""
    kept: list[TradeOff] = []
    for point in sorted(points, key=lambda each: (each.added_mass, each.inertia)):
        if not kept or point.inertia < kept[-1].inertia * (1.0 - VISIBLY_LESS):
            kept.append(point)
    return tuple(kept)
