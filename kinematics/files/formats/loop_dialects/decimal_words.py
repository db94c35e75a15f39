"""Write rational numbers as decimals."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

from kinematics.errors import ExactError
from kinematics.numerics.linalg.rational import decimal

# Most digits after the point of a decimal that is written exactly.
MAX_PLACES = 60
# Digits of the division; numbers are below 1e300.
_PRECISION = 500


def decimal_word(x: Fraction) -> str:
    """Write a number: exactly if a few digits suffice, else to the 17 digits of a double."""
    rest, places = x.denominator, 0
    while rest % 10 == 0:
        rest, places = rest // 10, places + 1
    for factor in (2, 5):
        while rest % factor == 0 and places <= MAX_PLACES:
            rest, places = rest // factor, places + 1
    if rest > 1 or places > MAX_PLACES:
        return repr(float(x))
    with localcontext() as context:
        context.prec = _PRECISION
        return format(Decimal(x.numerator) / Decimal(x.denominator), "f")


def word_value(word: str) -> Fraction:
    """Convert a finite decimal to a number: exactly, unless it has hundreds of digits."""
    try:
        return decimal(word)
    except ExactError:
        return Fraction(float(word))
