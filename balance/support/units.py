"""Numbers with units, such as ``30deg``, ``12mm`` or ``7.85g/cm3``, in SI units."""

from __future__ import annotations

import math
import re

from kinematics.errors import UsageError

# What one unit is in SI units (radians, metres, kilograms, seconds, newtons), by quantity.
UNITS: dict[str, dict[str, float]] = {
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0, "rev": 2.0 * math.pi},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "in": 0.0254},
    "mass": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
    "mass per length": {"kg/m": 1.0, "g/m": 1e-3, "g/mm": 1.0, "g/cm": 0.1, "kg/mm": 1e3},
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3},
    "stiffness": {"N/m": 1.0, "N/mm": 1e3, "N/cm": 1e2, "kN/m": 1e3},
    "torque": {"Nm": 1.0, "Nmm": 1e-3, "kNm": 1e3, "mNm": 1e-3},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3, "g/cc": 1e3, "kg/dm3": 1e3, "t/m3": 1e3},
    "inertia": {"kgm2": 1.0, "kgmm2": 1e-6, "kgcm2": 1e-4, "gmm2": 1e-9, "gcm2": 1e-7},
    "angular velocity": {
        "rad/s": 1.0,
        "deg/s": math.pi / 180.0,
        "°/s": math.pi / 180.0,
        "rpm": 2.0 * math.pi / 60.0,
        "1/min": 2.0 * math.pi / 60.0,
        "hz": 2.0 * math.pi,
        "1/s": 2.0 * math.pi,
        "rev/s": 2.0 * math.pi,
    },
    "velocity": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2},
    "angular acceleration": {"rad/s2": 1.0, "deg/s2": math.pi / 180.0},
    "acceleration": {"m/s2": 1.0, "mm/s2": 1e-3},
}
NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
SUPERSCRIPTS = str.maketrans({"²": "2", "³": "3", "·": "", "*": "", "^": "", " ": ""})


class UnitNumber(float):
    """A number in SI units that was written with a unit.

    Attributes:
        quantity: its quantity, a key of `UNITS`.
    """

    quantity: str = ""


def read_quantity(text: str, *quantities: str) -> float:
    """Read a number with or without a unit.

    Args:
        text: a number in SI units, or with one of the units of the quantities: ``30deg``,
            ``12 mm``, ``7.85g/cm³``.
        quantities: keys of `UNITS`.

    Returns:
        The number in SI units; it may be infinite or NaN without a unit.

    Raises:
        UsageError: the text is no number, or has another unit; the message names those there
            are.

    Examples:
        >>> from balance.support.units import read_quantity
        >>> read_quantity("250 mm", "length"), read_quantity("0.5", "length", "angle")
        (0.25, 0.5)
    """
    try:
        return float(text)
    except ValueError:
        match = re.fullmatch(rf"\s*({NUMBER})\s*(\S.*?)\s*", text)
    if match is None:
        raise UsageError(f"'{text}' is not a number")
    quantity, factor = read_unit(match[2], *quantities)
    number = UnitNumber(float(match[1]) * factor)
    number.quantity = quantity
    return number


def length_in_si(value: float | str | None) -> float | None:
    """Convert a text of a length with a unit, such as ``"20mm"``, to metres.

    Other values stay as they are.

    Raises:
        UsageError: the text is no length.
    """
    return float(read_quantity(value, "length")) if isinstance(value, str) else value


def read_unit(unit: str, *quantities: str) -> tuple[str, float]:
    """Return the quantity of a unit, and what one of it is in SI units.

    Args:
        unit: text of the unit; ``²``, ``^2`` and ``2`` are the same.
        quantities: keys of `UNITS`, of which it has to be one.

    Raises:
        UsageError: it is a unit of another quantity, or none.
    """
    word = unit.translate(SUPERSCRIPTS)
    key_of = {name: key for key in quantities for name in UNITS[key]}
    for name in (word, word.lower()):
        if name in key_of:
            return key_of[name], UNITS[key_of[name]][name]
    others = [key for key, units in UNITS.items() if word in units]
    problem = f"is a unit of {others[0]}" if others else "is no unit that is known"
    raise UsageError(
        f"'{unit}' {problem}: write {' or '.join(quantities)} in {', '.join(key_of)}"
    )
