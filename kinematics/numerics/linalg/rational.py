"""Rational arithmetic: decimals, roots, π, half-angle tangents, vectors and null spaces.

A decimal is a rational number; an angle is not the angle of a rational rotation, and a
pitch per radian is not rational. Those are replaced by the nearest fractions with a
denominator of ``2**BITS``. A rational half-angle tangent t gives a rotation that is exactly
orthogonal (A. Cayley, 1846): ``cos θ = (1 - t²) / (1 + t²)``, ``sin θ = 2t / (1 + t²)``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import cache
from math import isqrt
from typing import TYPE_CHECKING, TypeVar

from kinematics.errors import ExactError
from kinematics.numerics.tolerances import DECIMAL_ROUND_OFF

if TYPE_CHECKING:
    from kinematics.numerics.array_types import Array

Vector = tuple[Fraction, ...]
Number = TypeVar("Number", Fraction, float)
Rows = Sequence[Sequence[Number]]
Pivot = Callable[[Rows[Number], Sequence[int]], tuple[int, int] | None]

BITS = 64
"""Replacements are multiples of ``2**-BITS``."""
# Longest accepted decimal, in characters: no measured number is longer.
MAX_DIGITS = 400
# Largest denominator of a simple fraction.
MAX_SIMPLE_DENOMINATOR = 1000
# Additional bits of the terms of series.
_GUARD = 64


def decimal(word: str) -> Fraction:
    """Convert a decimal text to the number; a number that underflows in double precision is 0.

    Raises:
        ExactError: the text is too long.
    """
    if len(word) > MAX_DIGITS:
        raise ExactError(f"a number of {len(word)} characters; write at most {MAX_DIGITS}")
    return Fraction(word) if float(word) else Fraction(0)


def count_digits(word: str) -> tuple[int, int]:
    """Count decimals and significant digits of a decimal number, with zeros at its end.

    Example:
        >>> from kinematics.numerics.linalg.rational import count_digits
        >>> count_digits("-0.0120e1")
        (3, 3)
    """
    mantissa, _, exponent = word.lower().partition("e")
    whole, _, fraction = mantissa.lstrip("+-").partition(".")
    places = len(fraction) - int(exponent or 0)
    return max(places, 0), len((whole + fraction).lstrip("0"))


def root(value: Fraction) -> Fraction | None:
    """Compute the square root of a rational number; None if it is not rational."""
    if type(value) is not Fraction:
        return None  # an irrational number: its root is not rational either
    a, b = isqrt(value.numerator), isqrt(value.denominator)
    return Fraction(a, b) if a * a == value.numerator and b * b == value.denominator else None


def rounds_root(value: Fraction) -> bool:
    """Return whether a number is the root of a simple fraction, rounded to double precision.

    Such as 0.8660254037844386 for √3/2: its square is within 1e-15 of a fraction with a
    denominator of up to 1000, and the number itself is not near one.
    """

    def gap(x: Fraction) -> Fraction:
        return abs(x.limit_denominator(MAX_SIMPLE_DENOMINATOR) - x)

    square = value * value
    near = gap(square) <= DECIMAL_ROUND_OFF * square
    return near and gap(value) > 100 * DECIMAL_ROUND_OFF


def nearby_fraction(value: Fraction) -> Fraction:
    """Round a number to the nearest multiple of ``2**-BITS``."""
    return Fraction(round(value * (1 << BITS)), 1 << BITS)


@cache
def pi() -> Fraction:
    """Compute π to ``2**-(BITS + 100)``: ``16 arctan(1/5) - 4 arctan(1/239)`` (J. Machin)."""
    unit = 1 << (BITS + 2 * _GUARD)

    def arctan(inverse: int) -> int:
        total, power, k = 0, unit // inverse, 0
        while power:
            total += (-1) ** k * (power // (2 * k + 1))
            power //= inverse * inverse
            k += 1
        return total

    return Fraction(16 * arctan(5) - 4 * arctan(239), unit)


def quarters(angle: Fraction) -> tuple[int, Fraction]:
    """Split an angle into quarter turns and a remainder of at most π/4 in size; radians."""
    count = round(angle / (pi() / 2))
    return count, angle - count * pi() / 2


def tangent(angle: Fraction) -> Fraction:
    """Compute the tangent of half an angle of at most π/4 in size, to ``2**-BITS``."""
    half = angle / 2
    unit = 1 << (BITS + _GUARD)
    x = round(half * unit)
    sine = cosine = 0
    term, k = unit, 0
    while term:
        if k % 2:
            sine += term * (-1) ** (k // 2)
        else:
            cosine += term * (-1) ** (k // 2)
        k += 1
        # Towards zero, so that the terms of a negative angle end too.
        size = abs(term) * abs(x) // (unit * k)
        term = size if (term < 0) == (x < 0) else -size
    return nearby_fraction(Fraction(sine, cosine))


def nearby_vector(x: Array) -> Vector:
    """Round numbers (n,) to the nearest multiples of ``2**-BITS``."""
    return tuple(nearby_fraction(Fraction(float(y))) for y in x)


def add_vectors(a: Vector, b: Vector, factor: Fraction | int = 1) -> Vector:
    """Compute ``a + factor b`` of vectors (n,)."""
    terms = b if factor == 1 else scale_vector(factor, b)
    return tuple(x + y for x, y in zip(a, terms, strict=True))


def scale_vector(factor: Fraction | int, a: Vector) -> Vector:
    """Compute ``factor a`` of a vector (n,)."""
    return tuple(factor * x for x in a)


def part_across(a: Vector, n: Vector) -> Vector:
    """Compute the part of a vector (3,) across another, of any length: ``a - n (a·n) / n²``."""
    return add_vectors(a, n, -dot(a, n) / dot(n, n))


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    """Compute the inner product ``Σ_i a_i b_i``.

    Args:
        a: vector (n,).
        b: vector (n,).
    """
    return sum((x * y for x, y in zip(a, b, strict=True) if x and y), Fraction(0))


def cross(a: Sequence[Fraction], b: Sequence[Fraction]) -> Vector:
    """Compute the cross product ``a × b`` (3,).

    Args:
        a: vector (3,).
        b: vector (3,).
    """
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def rational_bracket(a: Sequence[Fraction], b: Sequence[Fraction]) -> Vector:
    """Compute the Lie bracket of twists ``[ω_a × ω_b; v_a × ω_b + ω_a × v_b]`` (6,).

    Args:
        a: twist ``[ω_a; v_a]`` (6,).
        b: twist ``[ω_b; v_b]`` (6,).
    """
    moments = zip(cross(a[3:], b[:3]), cross(a[:3], b[3:]), strict=True)
    return cross(a[:3], b[:3]) + tuple(x + y for x, y in moments)


def leading_entry(rows: Rows, pivots: Sequence[int]) -> tuple[int, int] | None:
    """Choose the pivot of the row echelon form: the first column that does not vanish.

    Args:
        rows: rows without a pivot so far.
        pivots: columns of the pivots so far.

    Returns:
        Row in ``rows`` and column; None if all rows vanish.
    """
    first = pivots[-1] + 1 if pivots else 0
    columns = range(first, len(rows[0]) if rows else 0)
    return next(((i, c) for c in columns for i, row in enumerate(rows) if row[c]), None)


def echelon(
    rows: Iterable[Sequence[Number]], pivot: Pivot[Number] = leading_entry
) -> tuple[list[list[Number]], list[int]]:
    """Eliminate by Gauss-Jordan: independent rows, each 1 at its pivot, where others are 0.

    Args:
        rows: of equal length; numbers that can be divided, exact ones or not.
        pivot: chooses row and column of the next pivot from the rows that are left and the
            columns of the pivots so far; None if the rows left vanish. By default the result is
            the reduced row echelon form.

    Returns:
        The rows with a pivot, in the order in which the pivots were chosen, and the column
        of each.
    """
    remaining: list[list[Number]] = [list(row) for row in rows]
    done: list[list[Number]] = []
    pivots: list[int] = []
    while (entry := pivot(remaining, pivots)) is not None:
        row, column = remaining.pop(entry[0]), entry[1]
        row = [x / row[column] for x in row]
        # Products with zeros take as long as others, and rows are sparse.
        entries = [(c, x) for c, x in enumerate(row) if x]
        for other in remaining + done:
            if factor := other[column]:
                for c, x in entries:
                    other[c] -= factor * x
        done.append(row)
        pivots.append(column)
    return done, pivots


def rational_null_space(
    rows: Sequence[Sequence[Fraction]], columns: int, pivot: Pivot[Fraction] = leading_entry
) -> list[list[Fraction]]:
    """Compute a basis of the null space of rational rows.

    Each vector is 1 in a column without a pivot, where the others are 0.

    Args:
        rows: of ``columns`` entries each.
        pivot: as for `echelon`.

    Returns:
        Vectors of ``columns`` entries with which every row has product 0.
    """
    reduced, pivots = echelon(rows, pivot)
    basis = []
    for free in (c for c in range(columns) if c not in pivots):
        vector = [Fraction(int(c == free)) for c in range(columns)]
        for row, column in zip(reduced, pivots, strict=True):
            vector[column] = -row[free]
        basis.append(vector)
    return basis


def combination(x: Sequence[Fraction], vectors: Sequence[Sequence[Fraction]]) -> list[Fraction]:
    """Compute the linear combination ``Σ_i x_i vectors_i``.

    Args:
        x: coefficients (count,).
        vectors: of equal length n (count, n).
    """
    return [dot(x, column) for column in zip(*vectors, strict=True)]
