"""Numbers of a study with units, such as ``"30deg"`` or ``"90%:110%:31"``, in SI units."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from balance.support.units import UNITS, read_quantity
from kinematics.errors import UsageError

UNIT_OF_QUANTITY = {
    "length": "m",
    "angle": "rad",
    "mass": "kg",
    "inertia": "kg m²",
    "mass per length": "kg/m",
}
# Digits of a number that was converted: those of the decimals that a person would write.
DIGITS = 15
_PERCENTAGE = re.compile(r"([+-]?\d+(?:\.\d*)?)\s*%")


def quantity_of_path(path: str) -> str:
    """Name the quantity of a parameter, a key of `UNITS`; empty if it has none."""
    head, _, last = path.rpartition(".")
    if head.endswith(".inertia"):
        return "inertia"
    if last in ("roll", "pitch", "yaw"):
        return "angle"
    if head.endswith((".origin", ".com")):
        return "length"
    named = {"length": "length", "mass": "mass", "mass_per_length": "mass per length"}
    return named.get(last, "") if head else ""


def unit_of_path(path: str) -> str:
    """Name the SI unit of a parameter; empty if it has none."""
    return UNIT_OF_QUANTITY.get(quantity_of_path(path), "")


def quantities_of_path(path: str) -> tuple[str, ...]:
    """List the quantities that the values of a parameter may have a unit of.

    A name that is no path may be anything; an axis has no unit.
    """
    if "." not in path:
        return tuple(UNITS)
    return tuple(filter(None, [quantity_of_path(path)]))


def in_si(value: object, *quantities: str) -> Any:
    """Convert the texts of numbers, also in lists and tables, to numbers.

    Other values stay as they are.

    Args:
        quantities: keys of `UNITS`.

    Raises:
        UsageError: a number has a unit of another quantity, or one that is unknown.
    """
    if isinstance(value, Mapping):
        return {key: in_si(each, *quantities) for key, each in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [in_si(each, *quantities) for each in value]
    if not (isinstance(value, str) and value.strip().lstrip("+-.")[:1].isdigit()):
        return value
    try:
        return float(value)
    except ValueError:
        pass
    if not quantities:
        raise UsageError(f"'{value}': what varies here has no unit; write a number")
    return float(f"{read_quantity(value, *quantities):.{DIGITS}g}")


def resolve_percentages(value: object, value_in_model: Callable[[], float]) -> Any:
    """Convert percentages in texts, also in lists and tables, to numbers in SI units.

    Other values stay as they are.

    Args:
        value_in_model: computes the value of which they are percentages.
    """
    if isinstance(value, Mapping):
        return {k: resolve_percentages(each, value_in_model) for k, each in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [resolve_percentages(each, value_in_model) for each in value]
    if not (isinstance(value, str) and "%" in value):
        return value
    return _PERCENTAGE.sub(
        lambda match: f"{float(match[1]) * value_in_model() / 100.0:.{DIGITS}g}", value
    )
