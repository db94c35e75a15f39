"""More mass for bodies that are lighter than air, as solids of their inertia."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from kinematics.wording import first_names

Bounds = Mapping[str, tuple[float, float]]
# Least and largest mass over that of a body lighter than air.
LEAST, LARGEST = 10.0, 100.0


def bounds_of_more_mass(
    masses: Mapping[str, float], bounds: Bounds, solve: Callable[[Bounds], object]
) -> Bounds:
    """Find bounds that give bodies more mass, and have a design.

    Args:
        masses: of the bodies lighter than air, kg, by name.
        bounds: of the design.
        solve: finds the masses with other bounds; None without a design.

    Returns:
        Least masses, kg, of two digits, and largest ones, those of the bounds where they are
        not less, by name; empty if there is no such design.
    """
    more = {}
    for name, mass in masses.items():
        low, high = (float(f"{times * mass:.2g}") for times in (LEAST, LARGEST))
        given = bounds[name][1] if name in bounds else high
        more[name] = low, given if given >= low else high
    return more if more and solve({**bounds, **more}) is not None else {}


def light_text(names: Sequence[str]) -> str:
    """Say which bodies are lighter than air; nothing without any."""
    if not names:
        return ""
    return f"lighter than air as a solid: {first_names(names)} (bounds= gives more mass)"


def more_mass_words(bounds: Bounds) -> list[str]:
    """Write bounds of `bounds_of_more_mass` as an argument of `design`; nothing without any."""
    each = (f"{name!r}: ({low:g}, {high:g})" for name, (low, high) in bounds.items())
    return [f"bounds={{{', '.join(each)}}} has more mass there"] if bounds else []
