"""Materials by name, with their densities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from balance.support.units import read_quantity
from kinematics.error_text import did_you_mean
from kinematics.errors import UsageError

MATERIALS = {
    "steel": 7850.0,
    "aluminium": 2700.0,
    "brass": 8500.0,
    "titanium": 4430.0,
    "tungsten": 19250.0,
    "lead": 11340.0,
}
"""Densities of materials, kg/m³."""

Density: TypeAlias = float | str | Mapping[str, float | str] | None
"""kg/m³, a material, a text such as ``"7.85 g/cm³"``, or one of these by link; None for any."""


def density_in_si(value: Any) -> Any:
    """Convert names of materials and texts with a unit to kg/m³, also by link in a table.

    Other values stay as they are.

    Raises:
        UsageError: there is no such material, or no such unit of density.
    """
    if isinstance(value, Mapping):
        return {name: density_in_si(each) for name, each in value.items()}
    if not isinstance(value, str):
        return value
    word = value.strip().lower()
    if word in MATERIALS:
        return MATERIALS[word]
    if word[:1].isalpha():
        meant = did_you_mean(word, MATERIALS)
        raise UsageError(
            f"'{value}' is no material that is known{meant}; materials are "
            f"{', '.join(MATERIALS)}"
        )
    return float(read_quantity(value, "density"))
