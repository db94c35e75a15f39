"""Decide which numbers of a file stand for a multiple of π/12, and for which one.

A number x with d decimals stands for ``k π/12`` in four cases. A number y with D decimals is
called a shortened c if ``y - c`` is in the interval ``(-1, 1/2] 10^-D``: c rounded, or cut off.

1. x is within 1e-11 rad of ``k π/12``: programs differ by that much in the last digits.
2. x is a shortened ``k π/12``: 1.5708, 1.5707, 3.142.
3. x is ``m y`` to the last digit of a double, or a shortened ``m y`` with D <= d, where
   ``m c = k π/12`` and

   - y is a shortened c = π with D = 2 to 16, and 12 m is whole: 1.57075 = 3.1415 / 2;
   - y is a shortened c = π/2 with D = 2 to 16, and m is whole: 3.14158 = 2 × 1.57079;
   - y is a shortened c = π/180 with D = 5 to 16, and m is whole: 1.57077 = 90 × 0.017453.

4. x is one of the two single-precision numbers next to ``k π/12``, to its decimals if there are
   7 or more: 1.5707963705062866.

Few decimals are shared by many angles. With three (of x, or of y) only angles up to 2π count,
with two of x only multiples of π/2 among them: 0.26 and 10.472 may well be meant. So may a
number of all digits that is 1e-10 from π/2: it may come from a pose that a program closed.
In a file whose angles are written with six digits, say, constants have as many: 1.8328 there is
1.83280, and not 3.142 × 7/12.
Intervals are those of positive angles; those of negative ones are mirror images.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from fractions import Fraction
from math import floor, log10

from kinematics.numerics.linalg.rational import MAX_DIGITS, decimal, pi
from kinematics.numerics.tolerances import (
    ANGLE_ROUND_OFF,
    DECIMAL_ROUND_OFF,
    EXACT_ANGLE_ERROR,
    ROUNDED_ANGLE_RELATIVE,
)

# Largest angle that may stand for a multiple of π/12, rad: a larger one is not a design value.
MAX_ROUNDED_ANGLE = 1e3
# Multiple of π/12 up to which numbers of three decimals, or of two, stand for it: 2π.
MAX_FEW_DECIMALS = 24
# Most decimals of a rounded constant: more are all that a double has.
MAX_DECIMALS = 16
# Constants that are rounded before they are multiplied, as fractions of π, and the least number
# of their decimals.
_CONSTANTS = ((Fraction(1), 2), (Fraction(1, 2), 2), (Fraction(1, 180), 5))

_TWELFTH = math.pi / 12


def nearest_twelfth(word: str, digits: int = 0) -> int:
    """Find the k ≠ 0 for which a number stands for ``k π/12``, by the rules of this module.

    Args:
        word: a finite decimal number, in radians.
        digits: significant digits that all constants have; 0 if that is not known.

    Returns:
        k, or 0 if there is none.
    """
    x = float(word)
    k = round(x / _TWELFTH) if abs(x) <= MAX_ROUNDED_ANGLE and len(word) <= MAX_DIGITS else 0
    error = abs(x - k * _TWELFTH)
    if not k or error <= ANGLE_ROUND_OFF:
        return k
    if error > ROUNDED_ANGLE_RELATIVE * abs(x):
        return 0
    size, multiple, places = abs(decimal(word)), abs(k), _decimals(word)
    rounded = _is_written(size, multiple * pi() / 12, multiple, places, digits)
    return k if rounded or _is_single(size, multiple * pi() / 12, places) else 0


def exact_angle(word: str) -> Fraction:
    """Convert an angle to a fraction: its decimals, or the multiple of π/12 within 1e-12 rad.

    All digits of a double, and noise such as 1.2e-16, stand for such a multiple. π is the
    fraction `kinematics.numerics.linalg.rational.pi`.
    """
    value = decimal(word)
    multiple = round(value / (pi() / 12)) * pi() / 12
    return multiple if abs(value - multiple) <= EXACT_ANGLE_ERROR else value


def _decimals(word: str) -> int:
    """Count the decimals of a number, without zeros at its end."""
    mantissa, _, exponent = word.lower().partition("e")
    whole, _, fraction = mantissa.partition(".")
    digits = whole + fraction
    return len(digits.rstrip("0")) - len(whole) - int(exponent or 0)


def _is_written(x: Fraction, angle: Fraction, k: int, places: int, digits: int) -> bool:
    """Return whether x is an angle, or a rounded constant times a number, as written."""
    if not _enough_decimals(places, k):
        return False
    if x in _shortened(angle, places):
        return True
    return any(
        abs(x - value) <= DECIMAL_ROUND_OFF * x
        or (decimals <= places and x in _shortened(value, places))
        for decimals, value in _products(k, digits)
    )


def _enough_decimals(places: int, k: int) -> bool:
    """Return whether so many decimals tell ``k π/12`` from other angles."""
    few = places < 4
    return places >= 2 and not (few and k > MAX_FEW_DECIMALS) and not (places == 2 and k % 6)


def _products(k: int, significant: int) -> Iterator[tuple[int, Fraction]]:
    """Yield ``k π/12`` with shortened constants, and the number of their decimals."""
    for part, least in _CONSTANTS:
        least = max(least, significant - floor(log10(float(part) * math.pi)) - 1)
        factor = Fraction(k, 12) / part
        if part == 1 or factor.denominator == 1:
            first = max(least, 2 if k <= MAX_FEW_DECIMALS else 4)
            for digits in range(first, MAX_DECIMALS + 1):
                for value in _shortened(part * pi(), digits):
                    yield digits, factor * value


def _shortened(value: Fraction, places: int) -> tuple[Fraction, Fraction]:
    """Round a positive number to so many decimals, halves upwards, and cut it off there."""
    unit = Fraction(10) ** -places
    return (value + unit / 2) // unit * unit, value // unit * unit


def _is_single(x: Fraction, angle: Fraction, places: int) -> bool:
    """Return whether x is a single-precision number next to an angle, to all its decimals."""
    (bits,) = struct.unpack("<i", struct.pack("<f", float(angle)))
    near = [struct.unpack("<f", struct.pack("<i", bits + step))[0] for step in (-1, 0, 1)]
    below = max(value for value in near if value <= angle)
    above = min(value for value in near if value >= angle)
    unit = Fraction(10) ** -places
    return any(
        float(x) == value or (places >= 7 and abs(x - Fraction(value)) <= unit / 2)
        for value in (below, above)
    )
