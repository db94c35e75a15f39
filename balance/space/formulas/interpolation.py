"""Rational functions of several variables from values modulo a prime.

Degrees come first: of each variable and of all together, along lines. Then numerator and
denominator, which are homogeneous, are fitted to values at random points, with as many
unknowns as there are monomials of these degrees, and the coefficients are read as fractions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

from balance.space.formulas.polynomials import Exponents, Polynomial
from kinematics.numerics.linalg.prime_field import (
    degrees_of_fraction,
    echelon_modulo,
    fraction_of,
)

SAMPLES_OF_LINES = (6, 10, 18, 34)
"""Numbers of points on a line that are tried, until the degrees are known."""
SPARE_POINTS = 4
"""Points beyond the number of unknowns, which a wrong fit would not meet."""

Sample = Callable[[Sequence[int]], list[int]]


class Degrees(NamedTuple):
    """Degrees of an entry: of numerator and denominator.

    Attributes:
        total: in all variables together.
        single: in each variable.
    """

    total: tuple[int, int]
    single: tuple[tuple[int, int], ...]

    def monomials(self, side: int) -> list[Exponents]:
        """List the exponents that the numerator (0) or the denominator (1) can have."""
        limits = [pair[side] for pair in self.single]
        return list(_monomials(self.total[side], limits))

    def unknowns(self) -> int:
        """Count the unknowns of a fit."""
        limits = [[pair[side] for pair in self.single] for side in (0, 1)]
        return sum(
            _count_monomials(total, caps)
            for total, caps in zip(self.total, limits, strict=True)
        )


def _monomials(total: int, limits: Sequence[int]) -> Iterator[Exponents]:
    if not limits:
        if total == 0:
            yield ()
        return
    for n in range(min(total, limits[0]), -1, -1):
        if total - n <= sum(limits[1:]):
            for rest in _monomials(total - n, limits[1:]):
                yield (n, *rest)


def _count_monomials(total: int, limits: Sequence[int]) -> int:
    ways = [1] + [0] * total
    for limit in limits:
        ways = [sum(ways[max(n - limit, 0) : n + 1]) for n in range(total + 1)]
    return ways[total]


class Interpolation:
    """Rational functions that one function samples together, modulo one prime.

    Values are kept: entries share all points.
    """

    def __init__(
        self, sample: Sample, variables: int, draw: Callable[[], list[int]], p: int
    ) -> None:
        """Keep the function.

        Args:
            sample: computes the values of all entries at a point.
            variables: number of variables.
            draw: draws a point.
            p: the prime.
        """
        self.sample, self.variables, self.draw, self.p = sample, variables, draw, p
        self.points: list[list[int]] = []
        self.values: list[list[int]] = []
        self._base, self._slope = draw(), draw()
        self._lines: dict[int, list[list[int]]] = {}

    def degrees(self, entries: Sequence[int]) -> dict[int, Degrees | None]:
        """Find the degrees of entries; None for those with more than lines can show."""
        along = [self._line_degrees(line, entries) for line in range(self.variables + 1)]
        out: dict[int, Degrees | None] = {}
        for e in entries:
            pairs = [line[e] for line in along]
            known = [pair for pair in pairs if pair is not None]
            out[e] = Degrees(known[-1], tuple(known[:-1])) if len(known) == len(pairs) else None
        return out

    def _line_degrees(
        self, line: int, entries: Sequence[int]
    ) -> dict[int, tuple[int, int] | None]:
        """Find degrees along a line: of one variable, or the last one in all of them."""
        out: dict[int, tuple[int, int] | None] = {}
        missing = list(entries)
        for count in SAMPLES_OF_LINES:
            values = self._line_values(line, count)
            for e in missing:
                column = [row[e] for row in values]
                out[e] = degrees_of_fraction(range(1, count + 1), column, self.p)
            missing = [e for e in missing if out[e] is None]
            if not missing:
                break
        return out

    def _line_values(self, line: int, count: int) -> list[list[int]]:
        values = self._lines.setdefault(line, [])
        while len(values) < count:
            t = len(values) + 1
            point = [
                (x + t * y) % self.p if line in (i, self.variables) else x
                for i, (x, y) in enumerate(zip(self._base, self._slope, strict=True))
            ]
            values.append(self.sample(point))
        return values

    def fit(self, entry: int, degrees: Degrees) -> tuple[Polynomial, Polynomial] | None:
        """Fit numerator and denominator of an entry; None if no fractions fit."""
        p, up, down = self.p, degrees.monomials(0), degrees.monomials(1)
        count = len(up) + len(down)
        while len(self.points) < count + SPARE_POINTS:
            point = self.draw()
            self.values.append(self.sample(point))
            self.points.append(point)
        used = [i for i, pair in enumerate(degrees.single) if pair != (0, 0)]
        rows = []
        for point, values in zip(
            self.points[: count + SPARE_POINTS], self.values, strict=False
        ):
            powers = _powers(point, used, degrees, p)
            f = values[entry]
            row = [_monomial(powers, e, used, p) for e in up]
            rows.append(row + [-f * _monomial(powers, e, used, p) % p for e in down])
        solved, pivots = echelon_modulo(rows, range(count), p)
        if len(pivots) != count - 1:
            return None
        free = next(c for c in range(count) if c not in pivots)
        null = [0] * count
        null[free] = 1
        for row, pivot in zip(solved, pivots, strict=True):
            null[pivot] = -row[free] % p
        return _as_fractions(null, up, down, p)


def _powers(
    point: Sequence[int], used: Sequence[int], degrees: Degrees, p: int
) -> dict[int, list[int]]:
    powers = {}
    for i in used:
        row = [1]
        for _ in range(max(degrees.single[i])):
            row.append(row[-1] * point[i] % p)
        powers[i] = row
    return powers


def _monomial(
    powers: dict[int, list[int]], exponents: Exponents, used: Sequence[int], p: int
) -> int:
    value = 1
    for i in used:
        if n := exponents[i]:
            value = value * powers[i][n] % p
    return value


def _as_fractions(
    null: Sequence[int], up: Sequence[Exponents], down: Sequence[Exponents], p: int
) -> tuple[Polynomial, Polynomial] | None:
    """Read numerator and denominator from a null vector."""
    scale = next((x for x in null[len(up) :] if x), 0)
    if not scale:
        return None
    scale = pow(scale, -1, p)
    polynomials: list[Polynomial] = []
    for monomials, numbers in ((up, null[: len(up)]), (down, null[len(up) :])):
        polynomial: Polynomial = {}
        for e, x in zip(monomials, numbers, strict=True):
            fraction = fraction_of(x * scale % p, p)
            if fraction is None:
                return None
            if fraction:
                polynomial[e] = Fraction(fraction)
        polynomials.append(polynomial)
    return (polynomials[0], polynomials[1]) if all(polynomials) else None
