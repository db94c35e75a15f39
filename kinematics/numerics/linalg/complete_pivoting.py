"""Gauss-Jordan elimination with complete pivoting, which keeps exact numbers short.

A row of fractions is kept as whole numbers over one denominator, and only entries that do not
vanish: a step then reduces a row by one common divisor, in place of each of its entries. The
largest entry of a row is searched again only where the row changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import Any, NamedTuple

from kinematics.numerics.linalg.rational import Rows


class _Row(NamedTuple):
    """The entries of a row that do not vanish, times its denominator.

    Attributes:
        entries: whole numbers by column; numbers of a field if any number is not rational.
        denominator: positive; 1 for numbers of a field.
        size: of the largest entry of the row.
        column: the first one with an entry of that size.
    """

    entries: dict[int, Any]
    denominator: int
    size: Fraction
    column: int


def eliminate_by_largest(rows: Rows[Fraction]) -> tuple[list[list[Fraction]], list[int]]:
    """Eliminate by Gauss-Jordan: the pivot is the first of the largest entries that are left.

    Args:
        rows: of equal length; rational numbers, or numbers of one field.

    Returns:
        Independent rows, each 1 at its pivot, where all the others vanish, in the order in
        which the pivots were chosen; and the column of each pivot.
    """
    rational = all(type(x) is Fraction for row in rows for x in row)
    remaining = [_row_of(row, rational) for row in rows if any(row)]
    done: list[_Row] = []
    pivots: list[int] = []
    while remaining:
        sizes = [row.size for row in remaining]
        top = _divide_by_pivot(remaining.pop(sizes.index(max(sizes))))
        reduced = [_eliminate(row, top) for row in remaining]
        remaining = [row for row in reduced if row.entries]
        done = [_eliminate(row, top) for row in done]
        pivots.append(top.column)
        done.append(top)
    return [_fractions(row, len(rows[0])) for row in done], pivots


def _row_of(row: Sequence[Fraction], rational: bool) -> _Row:
    """Convert a row of fractions."""
    entries = {c: x for c, x in enumerate(row) if x}
    if not rational:
        return _measured(entries, 1)
    denominator = lcm(*(x.denominator for x in entries.values()))
    whole = {c: x.numerator * (denominator // x.denominator) for c, x in entries.items()}
    return _measured(whole, denominator)


def _measured(entries: dict[int, Any], denominator: int) -> _Row:
    """Make a row with the size and the column of its largest entry."""
    largest = max(map(abs, entries.values()), default=0)
    column = min((c for c, x in entries.items() if abs(x) == largest), default=-1)
    size = Fraction(largest, denominator) if isinstance(largest, int) else largest
    return _Row(entries, denominator, size, column)


def _divide_by_pivot(row: _Row) -> _Row:
    """Divide a row by its largest entry."""
    pivot = row.entries[row.column]
    if not isinstance(pivot, int):
        return row._replace(entries={c: x / pivot for c, x in row.entries.items()})
    sign = 1 if pivot > 0 else -1
    return row._replace(
        entries={c: sign * x for c, x in row.entries.items()}, denominator=abs(pivot)
    )


def _eliminate(row: _Row, top: _Row) -> _Row:
    """Subtract the multiple of a row that is 1 at its pivot so that the pivot vanishes."""
    factor = row.entries.get(top.column)
    if factor is None:
        return row
    times = top.denominator
    if isinstance(factor, int):
        common = gcd(factor, times)
        factor, times = factor // common, times // common
    entries = {c: times * x for c, x in row.entries.items()}
    for c, x in top.entries.items():
        entries[c] = entries.get(c, 0) - factor * x
    entries = {c: x for c, x in entries.items() if x}
    denominator = times * row.denominator
    if isinstance(factor, int):
        common = gcd(denominator, *entries.values())
        entries = {c: x // common for c, x in entries.items()}
        denominator //= common
    return _measured(entries, denominator)


def _fractions(row: _Row, columns: int) -> list[Fraction]:
    """Convert a row back, with the entries that vanish."""
    zero = Fraction(0)
    if row.denominator == 1:
        return [row.entries.get(c, zero) * Fraction(1) for c in range(columns)]
    return [
        Fraction(row.entries[c], row.denominator) if c in row.entries else zero
        for c in range(columns)
    ]
