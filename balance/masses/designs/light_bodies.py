"""More mass for bodies that are lighter than air, as solids of their inertia."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from balance.space.inertial_parameters.body_inertia import BodyInertia

if TYPE_CHECKING:
    from balance.masses.designs.best_design import Design

Bounds = Mapping[str, tuple[float, float]]
# Least and largest mass over that of a body lighter than air.
LEAST, LARGEST = 10.0, 100.0


def bounds_of_more_mass(design: Design, solve: Callable[[Bounds], Design]) -> Bounds:
    """Find bounds that give all bodies lighter than air more mass, and have a design.

    Args:
        design: a design.
        solve: finds a design with other bounds.

    Returns:
        Least and largest masses, kg, of two digits, by name; empty if there is no such design,
        or a body has bounds already.
    """
    light = [body for body in design.bodies if body.name in design.lighter_than_air]
    more = {body.name: (_of(body, LEAST), _of(body, LARGEST)) for body in light}
    if not more or not more.keys().isdisjoint(design.bounds):
        return {}
    return more if solve({**design.bounds, **more}).z is not None else {}


def more_mass_words(bounds: Bounds) -> list[str]:
    """Write bounds of `bounds_of_more_mass` as an argument of `design`; nothing without any."""
    each = (f"{name!r}: ({low:g}, {high:g})" for name, (low, high) in bounds.items())
    return [f"bounds={{{', '.join(each)}}} has more mass there"] if bounds else []


def _of(body: BodyInertia, times: float) -> float:
    """Return a multiple of the mass of a body, of two digits."""
    return float(f"{times * body.mass:.2g}")
