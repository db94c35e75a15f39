"""Rows that double precision tells apart, with the span of exact ones that it does not.

A row that is in the span of others up to round-off is replaced by what is exactly left of it
when their combination is subtracted. Coefficients are rounded, and what is left is computed in
whole numbers, so that each pass adds the digits of a double, as iterative refinement does
(J. H. Wilkinson, "Rounding Errors in Algebraic Processes", 1963). Elimination in fractions
would multiply the lengths of numbers instead, by the number of rows; it is left for numbers of
a field.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import frexp, lcm, ldexp
from typing import NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.complete_pivoting import eliminate_by_largest
from kinematics.numerics.linalg.cyclotomic import FieldNumber
from kinematics.numerics.linalg.rational import Rows

# Distance of a unit row from the span of those before it from which it counts as apart.
APART = 0.1
# Bits of a rounded coefficient.
BITS = 53


class _Row(NamedTuple):
    """A row of whole numbers, of any length, and the unit row along it.

    Attributes:
        entries: those that do not vanish, by column.
        exponent: the row is ``length 2^exponent unit``.
        length: between 1/2 and the root of the number of entries.
        unit: the rounded unit row (columns,).
    """

    entries: dict[int, int]
    exponent: int
    length: float
    unit: Array


def separate_rows(rows: Rows[Fraction]) -> Array:
    """Compute unit rows that span exact ones, of which none is nearly in the span of others.

    Args:
        rows: independent rows of equal length; rational numbers, or numbers of one field.

    Returns:
        As many unit rows (rows, columns), correct to the last bits.

    Raises:
        ValueError: a row is a combination of others.

    Example:
        >>> from fractions import Fraction
        >>> from kinematics.numerics.linalg.exact_residuals import separate_rows
        >>> small = Fraction(1, 10**40)
        >>> rows = [[Fraction(1), Fraction(1)], [Fraction(1), 1 + small]]
        >>> abs(separate_rows(rows)).round(3).tolist()
        [[0.707, 0.707], [0.707, 0.707]]
    """
    if any(isinstance(x, FieldNumber) for row in rows for x in row):
        return _separate_field_rows(rows)
    columns = len(rows[0]) if len(rows) else 0
    apart = [_measured(_whole_numbers(row), columns) for row in rows]
    while True:
        units = np.array([row.unit for row in apart]).reshape(len(rows), columns)
        first, others = _split(units)
        if not others:
            return units
        solution = np.linalg.lstsq(units[first].T, units[others].T, rcond=None)[0]
        before = [apart[i] for i in first]
        for i, coefficients in zip(others, solution.T.tolist(), strict=True):
            apart[i] = _measured(_residual(apart[i], before, coefficients), columns)


def _separate_field_rows(rows: Rows[Fraction]) -> Array:
    """Compute unit rows of numbers of a field, by elimination if they are not apart."""
    units = _unit_rows(rows)
    return units if not _split(units)[1] else _unit_rows(eliminate_by_largest(rows)[0])


def _unit_rows(rows: Rows[Fraction]) -> Array:
    floats = np.array(rows, dtype=np.float64)
    return np.asarray(floats / np.linalg.norm(floats, axis=1, keepdims=True))


def _split(units: Array) -> tuple[list[int], list[int]]:
    """Split unit rows into those apart from the ones before, the furthest first, and others."""
    from scipy.linalg import qr

    if not len(units):
        return [], []
    R, order = qr(units.T, mode="r", pivoting=True)
    distances = np.zeros(len(units))
    diagonal = np.abs(np.diagonal(R))
    distances[: diagonal.size] = diagonal
    count = int(np.sum(distances > APART))
    return sorted(order[:count].tolist()), sorted(order[count:].tolist())


def _whole_numbers(row: Sequence[Fraction]) -> dict[int, int]:
    """Multiply a row by its common denominator."""
    entries = {c: x for c, x in enumerate(row) if x}
    common = lcm(*(x.denominator for x in entries.values()))
    return {c: x.numerator * (common // x.denominator) for c, x in entries.items()}


def _measured(entries: dict[int, int], columns: int) -> _Row:
    """Measure a row, without the powers of two that all of its entries have.

    Raises:
        ValueError: it has no entries.
    """
    if not entries:
        raise ValueError("a row is a combination of others")
    shift = min((x & -x).bit_length() - 1 for x in entries.values())
    entries = {c: x >> shift for c, x in entries.items()}
    exponent = max(x.bit_length() for x in entries.values())
    unit, scale = np.zeros(columns), 1 << exponent
    unit[list(entries)] = [x / scale for x in entries.values()]
    length = float(np.linalg.norm(unit))
    return _Row(entries, exponent, length, unit / length)


def _residual(row: _Row, others: Sequence[_Row], coefficients: list[float]) -> dict[int, int]:
    """Subtract a combination of unit rows from a unit row, times a power of two, exactly."""
    factors: list[tuple[int, int, dict[int, int]]] = []
    for other, coefficient in zip(others, coefficients, strict=True):
        fraction, exponent = frexp(coefficient * row.length / other.length)
        if fraction:
            power = exponent - BITS + row.exponent - other.exponent
            factors.append((int(ldexp(fraction, BITS)), power, other.entries))
    low = min([0, *(power for _, power, _ in factors)])
    total = {c: x << -low for c, x in row.entries.items()}
    for factor, power, entries in factors:
        times = factor << (power - low)
        for c, x in entries.items():
            total[c] = total.get(c, 0) - times * x
    return {c: x for c, x in total.items() if x}
