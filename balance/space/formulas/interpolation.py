"""Rational functions of several variables from values modulo a prime.

Degrees come first: of each variable and of all together, along lines. Then numerator and
denominator are fitted to values at random points, and the coefficients are read as fractions.
Lengths are homogeneous. An angle is drawn as the tangent t of its half, and written in its
cosine and sine: polynomials of degree 2n in t over ``(1 + t²)^n`` are those of degree n in
these, with the sine at most once. A fit with many unknowns takes one variable after the other:
the terms that one fit needs are those that the next one tries (R. Zippel, 1979).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import product
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
UNKNOWNS_AT_ONCE = 80
"""Most unknowns of a fit of all variables at once."""

Sample = Callable[[Sequence[int]], list[int]]


class TooManyTermsError(Exception):
    """A fit has too many unknowns."""

    def __init__(self, unknowns: int) -> None:
        """Keep their number."""
        super().__init__(unknowns)
        self.unknowns = unknowns


def cosine_sine(t: int, p: int) -> tuple[int, int]:
    """Compute cosine and sine of an angle from the tangent of its half, modulo a prime."""
    scale = pow(1 + t * t, -1, p)
    return (1 - t * t) * scale % p, 2 * t * scale % p


def spread_point(point: Sequence[int], angles: Sequence[bool], p: int) -> list[int]:
    """Replace the half-angle tangents of a point by cosines and sines."""
    values: list[int] = []
    for x, angle in zip(point, angles, strict=True):
        values += cosine_sine(x, p) if angle else (x,)
    return values


class Degrees(NamedTuple):
    """Degrees of an entry: of numerator and denominator.

    Attributes:
        total: in all lengths together.
        single: in each variable; of an angle in its cosine and sine.
        angles: which variables are angles.
    """

    total: tuple[int, int]
    single: tuple[tuple[int, int], ...]
    angles: tuple[bool, ...]

    def monomials(self, side: int) -> list[Exponents]:
        """List the exponents that the numerator (0) or the denominator (1) can have."""
        limits = [
            pair[side]
            for pair, angle in zip(self.single, self.angles, strict=True)
            if not angle
        ]
        lengths = list(_monomials(self.total[side], limits))
        turns = [
            list(_powers_of_angle(pair[side]))
            for pair, angle in zip(self.single, self.angles, strict=True)
            if angle
        ]
        return [self._merge(chosen, e) for chosen in product(*turns) for e in lengths]

    def _merge(self, turns: Sequence[Exponents], lengths: Exponents) -> Exponents:
        of_turns, of_lengths = iter(turns), iter(lengths)
        out: list[int] = []
        for angle in self.angles:
            out += next(of_turns) if angle else (next(of_lengths),)
        return tuple(out)

    def unknowns(self) -> int:
        """Count the unknowns of a fit of all variables at once."""
        count = 0
        for side in (0, 1):
            sizes, limits = 1, []
            for pair, angle in zip(self.single, self.angles, strict=True):
                if angle:
                    sizes *= 2 * pair[side] + 1
                else:
                    limits.append(pair[side])
            count += sizes * _count_monomials(self.total[side], limits)
        return count


def _powers_of_angle(degree: int) -> Iterator[Exponents]:
    """List the exponents of cosine and sine up to a degree, the sine at most once."""
    for n in range(degree + 1):
        yield n, 0
        if n:
            yield n - 1, 1


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
        self,
        sample: Sample,
        angles: Sequence[bool],
        draw: Callable[[], list[int]],
        p: int,
        most_unknowns: int = 600,
    ) -> None:
        """Keep the function.

        Args:
            sample: computes the values of all entries at a point.
            angles: for each variable, whether it is the tangent of half an angle, not a length.
            draw: draws a point.
            p: the prime.
            most_unknowns: of a fit; its time grows with their cube.
        """
        self.sample, self.angles, self.draw, self.p = sample, tuple(angles), draw, p
        self.most_unknowns = most_unknowns
        self.variables = len(self.angles)
        # Angles first: that lengths are homogeneous cuts the last fit.
        self.order = sorted(range(self.variables), key=lambda i: not self.angles[i])
        self._base, self._slope = draw(), draw()
        self._lines: dict[int, list[list[int]]] = {}
        self._stages: dict[int, tuple[list[list[int]], list[list[int]]]] = {}

    def degrees(self, entries: Sequence[int]) -> dict[int, Degrees | None]:
        """Find the degrees of entries; None for those with more than lines can show."""
        along = [self._line_degrees(line, entries) for line in range(self.variables + 1)]
        out: dict[int, Degrees | None] = {}
        for e in entries:
            known = [pair for line in along if (pair := line[e]) is not None]
            if len(known) < len(along):
                out[e] = None
                continue
            single = [
                ((max(pair) + 1) // 2,) * 2 if angle else pair
                for pair, angle in zip(known[:-1], self.angles, strict=True)
            ]
            out[e] = Degrees(known[-1], tuple(single), self.angles)
        return out

    def divides_by(self, entry: int, degrees: Degrees) -> int:
        """Sum the degrees of the denominator of an entry in each variable."""
        total = 0
        for i, (pair, angle) in enumerate(zip(degrees.single, self.angles, strict=True)):
            if not angle or pair == (0, 0):
                total += pair[1]
                continue
            # Times (1 + t²)^n a polynomial in cosine and sine is one in t.
            column = []
            for k, row in enumerate(self._lines[i], 1):
                t = self._base[i] + k * self._slope[i]
                column.append(row[entry] * pow(1 + t * t, pair[0], self.p) % self.p)
            of_t = degrees_of_fraction(range(1, len(column) + 1), column, self.p)
            total += 2 * pair[0] if of_t is None else of_t[1]
        return total

    def _line_degrees(
        self, line: int, entries: Sequence[int]
    ) -> dict[int, tuple[int, int] | None]:
        """Find degrees along a line: of one variable, or the last one in all lengths."""
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
                (x + t * y) % self.p
                if line == i or (line == self.variables and not self.angles[i])
                else x
                for i, (x, y) in enumerate(zip(self._base, self._slope, strict=True))
            ]
            values.append(self.sample(point))
        return values

    def fit(self, entry: int, degrees: Degrees) -> tuple[Polynomial, Polynomial] | None:
        """Fit numerator and denominator of an entry; None if no fractions fit.

        Raises:
            TooManyTermsError: a fit has too many unknowns.
        """
        if degrees.unknowns() <= UNKNOWNS_AT_ONCE:
            terms = degrees.monomials(0), degrees.monomials(1)
            null = self._null_vector(entry, *terms, self.variables - 1)
        else:
            terms, null = self._fit_in_turn(entry, degrees)
        return None if null is None else _as_fractions(null, *terms, self.p)

    def _fit_in_turn(
        self, entry: int, degrees: Degrees
    ) -> tuple[tuple[list[Exponents], list[Exponents]], list[int] | None]:
        """Fit in more and more variables, with the others as they are at one point."""
        used = [g for g in self.order if degrees.single[g] != (0, 0)]
        zero = (0,) * (self.variables + sum(self.angles))
        terms = [[zero], [zero]]
        null: list[int] | None = None
        for place, group in enumerate(used):
            rest = [g for g in used[place + 1 :] if not self.angles[g]]
            for side in (0, 1):
                later = sum(degrees.single[g][side] for g in rest)
                terms[side] = self._more_terms(terms[side], group, side, degrees, later)
            null = self._null_vector(entry, terms[0], terms[1], self.order.index(group))
            if null is None:
                return (terms[0], terms[1]), None
            split = len(terms[0])
            kept = [
                [e for e, x in zip(each, part, strict=True) if x]
                for each, part in zip(terms, (null[:split], null[split:]), strict=True)
            ]
            null, terms = [x for x in null if x], kept
        return (terms[0], terms[1]), null

    def _more_terms(
        self,
        terms: Sequence[Exponents],
        group: int,
        side: int,
        degrees: Degrees,
        later: int,
    ) -> list[Exponents]:
        """Multiply terms by the powers of one more variable.

        Args:
            terms: in the variables before it.
            group: index of the variable.
            side: 0 for the numerator, 1 for the denominator.
            degrees: of the entry.
            later: degree that the lengths after it can add.
        """
        at = group + sum(self.angles[:group])
        lengths = [
            g + sum(self.angles[:g]) for g in range(self.variables) if not self.angles[g]
        ]
        out = []
        for e in terms:
            degree = sum(e[i] for i in lengths)
            if self.angles[group]:
                powers: list[Exponents] = list(_powers_of_angle(degrees.single[group][side]))
            else:
                least = max(degrees.total[side] - degree - later, 0)
                most = min(degrees.single[group][side], degrees.total[side] - degree)
                powers = [(n,) for n in range(least, most + 1)]
            out += [e[:at] + power + e[at + len(power) :] for power in powers]
        return out

    def _points(self, stage: int, count: int) -> tuple[list[list[int]], list[list[int]]]:
        """Sample points at which the variables up to a place in the order vary."""
        points, values = self._stages.setdefault(stage, ([], []))
        while len(points) < count:
            point = self.draw()
            for i in self.order[stage + 1 :]:
                point[i] = self._base[i]
            values.append(self.sample(point))
            points.append(spread_point(point, self.angles, self.p))
        return points, values

    def _null_vector(
        self, entry: int, up: Sequence[Exponents], down: Sequence[Exponents], stage: int
    ) -> list[int] | None:
        """Fit coefficients of numerator and denominator, up to a factor.

        Where an angle has an odd degree in t, several fractions are the same function: the one
        with the fewest terms counts.
        """
        p, count = self.p, len(up) + len(down)
        if count > self.most_unknowns:
            raise TooManyTermsError(count)
        points, values = self._points(stage, count + SPARE_POINTS)
        highest = [max(column) for column in zip(*up, *down, strict=True)]
        rows = []
        for point, value in zip(points[: count + SPARE_POINTS], values, strict=False):
            powers = _powers(point, highest, p)
            f = value[entry]
            row = [_monomial(powers, e, p) for e in up]
            rows.append(row + [-f * _monomial(powers, e, p) % p for e in down])
        solved, pivots = echelon_modulo(rows, range(count), p)
        best: list[int] | None = None
        for free in (c for c in range(count) if c not in pivots):
            null = [0] * count
            null[free] = 1
            for row, pivot in zip(solved, pivots, strict=True):
                null[pivot] = -row[free] % p
            if best is None or sum(map(bool, null)) < sum(map(bool, best)):
                best = null
        return best


def _powers(point: Sequence[int], highest: Sequence[int], p: int) -> list[list[int]]:
    powers = []
    for x, most in zip(point, highest, strict=True):
        row = [1]
        for _ in range(most):
            row.append(row[-1] * x % p)
        powers.append(row)
    return powers


def _monomial(powers: Sequence[Sequence[int]], exponents: Exponents, p: int) -> int:
    value = 1
    for row, n in zip(powers, exponents, strict=True):
        if n:
            value = value * row[n] % p
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
