"""Closed forms of numbers: fractions, roots, sines and cosines, and vectors that were turned.

Read as such are, where they are no further away than round-off,

- zeros, simple fractions, and roots of small integers times a short decimal;
- sums ``(a + b √d) u`` of two multiples of a thousandth of the largest length, d = 2, 3;
- vectors that are another one, or its mirror image, turned by multiples of 30 or 45 degrees
  about a coordinate axis: the legs of a robot with three- or sixfold symmetry;
- sines and cosines of rational parts of π, times a short decimal.

A number of 16 digits is so near to one by chance once in 10^6 numbers or less. All of them are
in one field; see `kinematics.numerics.linalg.cyclotomic`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product
from math import cos, floor, isqrt, lcm, log10, pi, sin, ulp
from typing import NamedTuple

import numpy as np

from kinematics.numerics.linalg.cyclotomic import (
    MAX_DEGREE,
    FieldNumber,
    conductor_of_root,
    cosine_of_part,
    degree_of_field,
    root_of_integer,
    sine_of_part,
)
from kinematics.numerics.linalg.rational import Vector

# Roots that are looked for: of these integers.
RADICANDS = (3, 2, 6, 5, 7, 10, 15)
# Those of sums of a number and a root.
SUM_RADICANDS = (3, 2)
# Denominators: of simple fractions, and of short decimals that are multiplied by a root.
SIMPLE, SHORT = 360, 12 * 10**4
# Multiples of the unit of sums, at most, and units in the largest length.
UNITS = 2000
# Conductors of sines and cosines: parts of 22.5, 18, 15, 360/28, 10 and 6 degrees.
CONDUCTORS = (16, 20, 24, 28, 36, 60)
# Angles between a vector and its copies, in parts of a turn.
TURNS = tuple(Fraction(k, 24) for k in range(24) if k % 2 == 0 or k % 3 == 0)
Key = tuple[Hashable, int]


class _Value(NamedTuple):
    """A number in closed form: ``Σ coefficient × kind``, and the conductor it needs.

    Attributes:
        conductor: that of its field.
        terms: coefficients of roots, ``("root", d, 0)``, or cosines, ``("cosine", k, N)``.
    """

    conductor: int
    terms: tuple[tuple[Fraction, str, int, int], ...]

    @property
    def text(self) -> str:
        """The sum in words."""
        return " + ".join(
            f"{factor}"
            if (kind, a) == ("root", 1)
            else f"{factor} √{a}"
            if kind == "root"
            else f"{factor} cos {Fraction(360 * a, n)}°"
            for factor, kind, a, n in self.terms
        )

    def within(self, N: int) -> Fraction:
        """Compute the number in a field whose conductor is a multiple of its own."""
        total = Fraction(0)
        for factor, kind, a, n in self.terms:
            value = root_of_integer(a, N) if kind == "root" else cosine_of_part(a * (N // n), N)
            total += factor * value
        return total


class NumberWord(NamedTuple):
    """A number of many digits.

    Attributes:
        key: the vector that it is in, and its place there.
        value: its decimals.
        error: how far it may be from the number it stands for.
        zero: up to which size it is zero with round-off.
    """

    key: Key
    value: Fraction
    error: Fraction
    zero: Fraction


class NumberVector(NamedTuple):
    """A vector of three numbers.

    Attributes:
        key: what it is known by.
        values: its decimals.
        words: those of many digits, None for others.
    """

    key: Hashable
    values: Vector
    words: tuple[NumberWord | None, ...]


class ClosedForms(NamedTuple):
    """Numbers in closed form, in one field.

    Attributes:
        conductor: that of the field; 1 for fractions alone.
        numbers: their values, by vector and place in it; those that differ from the decimals.
        texts: the same in words.
    """

    conductor: int
    numbers: Mapping[Key, Fraction]
    texts: Mapping[Key, str]


def read_closed_forms(
    vectors: Sequence[NumberVector], conductors: Sequence[int] = ()
) -> ClosedForms:
    """Find the numbers that stand for fractions, roots, sines and cosines.

    Args:
        vectors: vectors of three numbers.
        conductors: those of fields that are needed for other numbers.
    """
    words = [word for vector in vectors for word in vector.words if word is not None]
    reader = _Reader(max((abs(float(x)) for item in vectors for x in item.values), default=1.0))
    values: dict[Key, _Value] = {}
    for word in words:
        if value := reader.read_root(word):
            values[word.key] = value
    copies = dict(reader.find_copies(vectors, values))
    for word in words:
        if word.key in values or word.key in copies:
            continue
        if value := reader.read_cosine(word):
            values[word.key] = value
    conductor = _choose_conductor(
        [value.conductor for value in values.values()]
        + [copy.conductor for copy in copies.values()]
        + [*conductors]
    )
    numbers = {
        key: value.within(conductor)
        for key, value in values.items()
        if conductor % value.conductor == 0
    }
    by_key = {vector.key: vector for vector in vectors}
    for key, copy in copies.items():
        if conductor % copy.conductor == 0:
            numbers[key] = copy.value(by_key, numbers, conductor)
    decimals = {word.key: word.value for word in words}
    numbers = {key: value for key, value in numbers.items() if value != decimals[key]}
    texts = {key: (values[key] if key in values else copies[key]).text for key in numbers}
    return ClosedForms(conductor, numbers, texts)


def _choose_conductor(needed: list[int]) -> int:
    """Choose a conductor that serves most numbers, and has a field of small degree."""
    N = 1
    for conductor, _ in sorted(Counter(needed).items(), key=lambda x: (-x[1], x[0])):
        wider = lcm(N, conductor)
        if degree_of_field(wider) <= MAX_DEGREE:
            N = wider
    return N


class _Copy(NamedTuple):
    """An entry of a vector that is another one turned about a coordinate axis, or mirrored too.

    Attributes:
        source: the other vector.
        axis: number of the axis.
        turn: part of a turn.
        sign: -1 if the entry after that of the axis but one changes its sign before.
        entry: which entry.
    """

    source: Hashable
    axis: int
    turn: Fraction
    sign: int
    entry: int

    @property
    def text(self) -> str:
        """The source and the turn in words."""
        mirrored = "mirrored and " if self.sign < 0 else ""
        return f"that of another vector, {mirrored}turned by {self.turn * 360} degrees"

    @property
    def conductor(self) -> int:
        """Conductor of the field of its sine and cosine."""
        return lcm(4, self.turn.denominator)

    def value(
        self, vectors: Mapping[Hashable, NumberVector], numbers: Mapping[Key, Fraction], N: int
    ) -> Fraction:
        """Compute the entry.

        Args:
            numbers: those that are read as roots.
            N: conductor of their field.
        """
        source = vectors[self.source]
        a, b = ((self.axis + k) % 3 for k in (1, 2))
        if self.entry == self.axis:
            return numbers.get((self.source, self.axis), source.values[self.axis])
        x, y = (numbers.get((self.source, k), source.values[k]) for k in (a, b))
        k = int(self.turn * N)
        c, s = cosine_of_part(k, N), sine_of_part(k, N)
        y = self.sign * y
        return c * x - s * y if self.entry == a else s * x + c * y


class _Reader:
    """Reads numbers as roots, cosines, and entries of vectors that are others, turned."""

    def __init__(self, largest: float) -> None:
        """Choose the unit of sums: 10^-k, about a thousandth of the largest number."""
        exponent = floor(log10(max(largest, 1e-300)))
        self._unit = Fraction(10) ** (exponent - 3)
        steps = np.arange(-UNITS * 10, UNITS * 10 + 1)
        self._steps = {d: steps * float(np.sqrt(d)) for d in SUM_RADICANDS}

    def read_root(self, word: NumberWord) -> _Value | None:
        """Read a number as a simple fraction, a root times one, or a sum of both."""
        simple = word.value.limit_denominator(SIMPLE)
        if abs(word.value) <= word.zero:
            return _Value(1, ())
        if abs(simple - word.value) <= word.error:
            return _Value(1, ((simple, "root", 1, 0),))
        for d in RADICANDS:
            near = _approximate_root(d)
            factor = _round_to_short(word.value / near, word.error / near)
            if factor is not None:
                return _Value(conductor_of_root(d), ((factor, "root", d, 0),))
        return self._read_sum(word)

    def _read_sum(self, word: NumberWord) -> _Value | None:
        """Read a number as ``(a + b √d) u/2``."""
        scaled = 2 * word.value / self._unit
        if abs(scaled) > 40 * UNITS:
            return None
        for d, products in self._steps.items():
            difference = float(scaled) - products
            close = np.flatnonzero(np.abs(difference - np.rint(difference)) <= 1e-10)
            for k in close.tolist():
                a, b = round(difference[k]), k - UNITS * 10
                near = (a + b * _approximate_root(d)) * self._unit / 2
                if a and b and abs(near - word.value) <= word.error:
                    half = self._unit / 2
                    terms = (a * half, "root", 1, 0), (b * half, "root", d, 0)
                    return _Value(conductor_of_root(d), terms)
        return None

    def read_cosine(self, word: NumberWord) -> _Value | None:
        """Read a number as a cosine times a short decimal."""
        for N in CONDUCTORS:
            for k in range(1, (N + 3) // 4):
                near = _approximate_cosine(k, N)
                factor = _round_to_short(word.value / near, word.error / near)
                if factor is not None:
                    part = Fraction(k, N)
                    return _Value(
                        part.denominator,
                        ((factor, "cosine", part.numerator, part.denominator),),
                    )
        return None

    def find_copies(
        self, vectors: Sequence[NumberVector], numbers: Mapping[Key, _Value]
    ) -> Iterator[tuple[Key, _Copy]]:
        """Yield the entries of vectors that are others, turned.

        Args:
            numbers: entries that are read otherwise.
        """
        done: list[NumberVector] = []
        for vector in vectors:
            unread = [
                word for word in vector.words if word is not None and word.key not in numbers
            ]
            if unread and (copy := _find_source(vector, done)) is not None:
                for word in unread:
                    yield word.key, _Copy(*copy, word.key[1])
            else:
                done.append(vector)


def _find_source(
    vector: NumberVector, others: Sequence[NumberVector]
) -> tuple[Hashable, int, Fraction, int] | None:
    """Find another vector, the axis about which it is turned, part of a turn, and sign."""
    error = 4 * max(ulp(float(abs(x))) for x in vector.values)
    error = max(error, *(float(word.error) for word in vector.words if word is not None))
    here = [float(x) for x in vector.values]
    for other in others:
        there = [float(x) for x in other.values]
        for axis in range(3):
            a, b = (axis + 1) % 3, (axis + 2) % 3
            square = there[a] ** 2 + there[b] ** 2
            apart = abs(here[a] ** 2 + here[b] ** 2 - square) > 8 * error * max(1, square)
            if apart or abs(here[axis] - there[axis]) > error:
                continue
            for sign, turn in product((1, -1), TURNS):
                c, s = cos(2 * pi * float(turn)), sin(2 * pi * float(turn))
                x, y = there[a], sign * there[b]
                if max(abs(c * x - s * y - here[a]), abs(s * x + c * y - here[b])) <= error:
                    return other.key, axis, turn, sign
    return None


def _approximate_root(d: int) -> Fraction:
    """Compute the root of a whole number to 2^-160."""
    return Fraction(isqrt(d << 320), 1 << 160)


def _approximate_cosine(k: int, N: int) -> Fraction:
    value = cosine_of_part(k, N)
    return value.nearby if isinstance(value, FieldNumber) else value


def _round_to_short(x: Fraction, error: Fraction) -> Fraction | None:
    """Round a number to a short decimal, or a simple part of one; None if it is not near."""
    size = Fraction(10) ** floor(log10(abs(float(x)) or 1.0))
    near = Fraction(round(x / size * SHORT)) / SHORT * size
    return near if near and abs(near - x) <= error else None
