"""Find the numbers of a file that stand for roots, sines and cosines, to all their digits.

Read as such are, with 15 digits or more and no further away than these tell,

- zeros with round-off, simple fractions, and roots of small integers times a short decimal;
- sums ``(a + b √d) u`` of two multiples of a thousandth of the largest length, d = 2, 3;
- vectors that are another vector of the file, turned by multiples of 30 or 45 degrees about a
  coordinate axis: the legs of a robot with three- or sixfold symmetry;
- sines and cosines of rational parts of π, times a short decimal;
- angles that are rational parts of π.

A number of 16 digits is so near to one by chance once in 10^6 numbers or less. All of them are
in one field; see `kinematics.linalg.cyclotomic`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import floor, isqrt, lcm, log10, pi, ulp
from typing import NamedTuple

import numpy as np

from kinematics.linalg.cyclotomic import (
    MAX_DEGREE,
    FieldNumber,
    conductor_of_root,
    cosine_of_part,
    degree_of_field,
    root_of_integer,
    sine_of_part,
)
from kinematics.linalg.rational import MAX_DIGITS, Vector, decimal
from kinematics.model.linkage import Notice
from kinematics.urdf_elements.element import Element

__all__ = ["FileRoots", "read_roots"]

# Fewest significant digits of a number that may stand for a root.
MIN_DIGITS = 15
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
# Most numbers of a file with so many digits.
MAX_NUMBERS = 2000
# Largest error of an angle, radians, and largest denominator of its part of a turn.
ANGLE_ERROR, MAX_PARTS = 2.0**-51, 60

Key = tuple[int, str, int]


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
        """Write it."""
        return " + ".join(
            f"{factor}" if (kind, a) == ("root", 1)
            else f"{factor} √{a}" if kind == "root" else f"{factor} cos {Fraction(360 * a, n)}°"
            for factor, kind, a, n in self.terms
        )  # fmt: skip

    def within(self, N: int) -> Fraction:
        """Compute it in a field whose conductor is a multiple of its own."""
        total = Fraction(0)
        for factor, kind, a, n in self.terms:
            value = root_of_integer(a, N) if kind == "root" else cosine_of_part(a * (N // n), N)
            total += factor * value
        return total


@dataclass(frozen=True)
class FileRoots:
    """Numbers of a file that are read as roots, sines or cosines.

    Attributes:
        conductor: that of the field in which they are; 1 for fractions alone.
        numbers: their values, by identity of the element, attribute and place in it.
        notices: one for each of them and of the angles, ``read_as_root``.
        tried: number of relations that were tried.
    """

    conductor: int
    numbers: Mapping[Key, Fraction]
    notices: tuple[Notice, ...]
    tried: int

    def vector(self, item: Element | None, attribute: str, words: Iterable[str]) -> Vector:
        """Read the numbers of an attribute.

        Args:
            item: the element.
            attribute: its attribute.
            words: the numbers.
        """
        return tuple(
            self.numbers.get((id(item), attribute, k), decimal(word))
            for k, word in enumerate(words)
        )

    def half_angle(self, angle: float) -> tuple[int, Fraction] | None:
        """Find the quarter turns of an angle, and the tangent of half the rest.

        Args:
            angle: in radians.

        Returns:
            Both; None if they are not in the field.
        """
        part = _part_of_turn(angle)
        if part is None or self.conductor % lcm(4, part.denominator):
            return None
        quarter = round(part * 4)
        k = int((part - Fraction(quarter, 4)) * self.conductor)
        c, s = cosine_of_part(k, self.conductor), sine_of_part(k, self.conductor)
        return quarter, s / (1 + c)


@dataclass(frozen=True)
class _Word:
    """A number of many digits.

    Attributes:
        key: where it is.
        value: its decimals.
        error: how far it may be from the number it stands for.
        zero: up to which size it is zero with round-off.
    """

    key: Key
    value: Fraction
    error: Fraction
    zero: Fraction


def read_roots(tree: Element) -> FileRoots | None:
    """Find the numbers of a file that stand for roots, sines and cosines.

    Args:
        tree: the checked tree of a file.

    Returns:
        Their values in one field; None if there are none.
    """
    vectors = list(_vectors(tree))
    words = [word for _, entries in vectors for word in entries if word is not None]
    angles = [word for owner in _items(tree) for word in _angle_words(owner)]
    if not words and not angles or len(words) > MAX_NUMBERS:
        return None
    largest = max((abs(float(x)) for item, _ in vectors for x in item.values), default=1.0)
    reader = _Reader(largest)
    values: dict[Key, _Value] = {}
    for word in words:
        if value := reader.root(word):
            values[word.key] = value
    copies = dict(reader.copies(vectors, values))
    for word in words:
        if word.key not in values and word.key not in copies and (value := reader.cosine(word)):
            values[word.key] = value
    parts = {key: part for key, part in angles if part is not None}
    conductor = _choose_conductor(
        [value.conductor for value in values.values()]
        + [lcm(4, part.denominator) for part in parts.values()]
        + [copy.conductor for copy in copies.values()]
    )
    numbers = {
        key: value.within(conductor)
        for key, value in values.items() if conductor % value.conductor == 0
    }  # fmt: skip
    by_item = {item.key: item for item, _ in vectors}
    for key, copy in copies.items():
        if conductor % copy.conductor == 0:
            numbers[key] = copy.value(by_item, numbers, conductor)
    turned = [
        (key[0], str(float(2 * pi * part)), f"a turn by {part * 360} degrees")
        for key, part in parts.items() if conductor % lcm(4, part.denominator) == 0
    ]  # fmt: skip
    exact = {
        word.key for word in words if word.key in numbers and numbers[word.key] == word.value
    }
    numbers = {key: value for key, value in numbers.items() if key not in exact}
    if not numbers and not turned:
        return None
    labels = {id(item): item.label for item in _items(tree)}
    known = [
        (key[0], str(float(number)), values[key].text if key in values else copies[key].text)
        for key, number in numbers.items()
    ]
    notices = tuple(
        Notice("read_as_root", f"{labels[item]}: {number} is read as {text}")
        for item, number, text in known + turned
    )
    return FileRoots(conductor, numbers, notices, reader.tried)


def _choose_conductor(needed: list[int]) -> int:
    """Choose a conductor that serves most numbers, and has a field of small degree."""
    N = 1
    for conductor, _ in sorted(Counter(needed).items(), key=lambda x: (-x[1], x[0])):
        wider = lcm(N, conductor)
        if degree_of_field(wider) <= MAX_DEGREE:
            N = wider
    return N


class _Item(NamedTuple):
    """A vector of a file: where it is, and its decimals."""

    key: tuple[int, str]
    values: Vector


class _Copy(NamedTuple):
    """An entry of a vector that is another one turned about a coordinate axis."""

    source: tuple[int, str]
    axis: int
    turn: Fraction
    entry: int

    @property
    def text(self) -> str:
        """Write it."""
        return f"that of another vector, turned by {self.turn * 360} degrees"

    @property
    def conductor(self) -> int:
        """Conductor of the field of its sine and cosine."""
        return lcm(4, self.turn.denominator)

    def value(
        self, items: Mapping[tuple[int, str], _Item], numbers: Mapping[Key, Fraction], N: int
    ) -> Fraction:
        """Compute it.

        Args:
            items: vectors of the file.
            numbers: those that are read as roots.
            N: conductor of their field.
        """
        item = items[self.source]
        a, b = ((self.axis + k) % 3 for k in (1, 2))
        x, y = (numbers.get((*self.source, k), item.values[k]) for k in (a, b))
        k = int(self.turn * N)
        c, s = cosine_of_part(k, N), sine_of_part(k, N)
        return c * x - s * y if self.entry == a else s * x + c * y


class _Reader:
    """Relations of numbers, and how many were tried."""

    def __init__(self, largest: float) -> None:
        """Choose the unit of sums: 10^-k, about a thousandth of the largest number."""
        self.tried = 0
        exponent = floor(log10(max(largest, 1e-300)))
        self._unit = Fraction(10) ** (exponent - 3)
        steps = np.arange(-UNITS * 10, UNITS * 10 + 1)
        self._steps = {d: steps * float(np.sqrt(d)) for d in SUM_RADICANDS}

    def root(self, word: _Word) -> _Value | None:
        """Read a number as a simple fraction, a root times one, or a sum of both."""
        self.tried += SIMPLE
        simple = word.value.limit_denominator(SIMPLE)
        if abs(word.value) <= word.zero:
            return _Value(1, ())
        if abs(simple - word.value) <= word.error:
            return _Value(1, ((simple, "root", 1, 0),))
        for d in RADICANDS:
            self.tried += 1
            near = _root_near(d)
            factor = _short(word.value / near, word.error / near)
            if factor is not None:
                return _Value(conductor_of_root(d), ((factor, "root", d, 0),))
        return self._sum(word)

    def _sum(self, word: _Word) -> _Value | None:
        """Read a number as ``(a + b √d) u/2``."""
        scaled = 2 * word.value / self._unit
        if abs(scaled) > 40 * UNITS:
            return None
        for d, products in self._steps.items():
            self.tried += products.size
            rest = float(scaled) - products
            close = np.flatnonzero(np.abs(rest - np.rint(rest)) <= 1e-10)
            for k in close.tolist():
                a, b = round(rest[k]), k - UNITS * 10
                near = (a + b * _root_near(d)) * self._unit / 2
                if a and b and abs(near - word.value) <= word.error:
                    half = self._unit / 2
                    terms = (a * half, "root", 1, 0), (b * half, "root", d, 0)
                    return _Value(conductor_of_root(d), terms)
        return None

    def cosine(self, word: _Word) -> _Value | None:
        """Read a number as a cosine times a short decimal."""
        for N in CONDUCTORS:
            for k in range(1, (N + 3) // 4):
                near = _cosine_near(k, N)
                self.tried += 1
                factor = _short(word.value / near, word.error / near)
                if factor is not None:
                    part = Fraction(k, N)
                    return _Value(
                        part.denominator,
                        ((factor, "cosine", part.numerator, part.denominator),),
                    )
        return None

    def copies(
        self, vectors: list[tuple[_Item, list[_Word | None]]], known: Mapping[Key, _Value]
    ) -> Iterator[tuple[Key, _Copy]]:
        """Yield the entries of vectors that are others, turned.

        Args:
            vectors: vectors of the file, and their words of many digits.
            known: entries that are read otherwise.
        """
        done: list[tuple[_Item, list[_Word | None]]] = []
        for item, words in vectors:
            left = [word for word in words if word is not None and word.key not in known]
            if left and (copy := self._copied(item, words, done)) is not None:
                for word in left:
                    entry = word.key[2]
                    if entry != copy[1]:
                        yield word.key, _Copy(copy[0], copy[1], copy[2], entry)
            else:
                done.append((item, words))

    def _copied(
        self, item: _Item, words: list[_Word | None],
        others: list[tuple[_Item, list[_Word | None]]],
    ) -> tuple[tuple[int, str], int, Fraction] | None:  # fmt: skip
        """Find another vector, the axis about which it is turned, and the part of a turn."""
        error = 4 * max(ulp(float(abs(x))) for x in item.values)
        here = [float(x) for x in item.values]
        for other, _ in others:
            there = [float(x) for x in other.values]
            for axis in range(3):
                a, b = (axis + 1) % 3, (axis + 2) % 3
                if abs(here[axis] - there[axis]) > error:
                    continue
                square = there[a] ** 2 + there[b] ** 2
                if abs(here[a] ** 2 + here[b] ** 2 - square) > 8 * error * max(1, square):
                    continue
                for turn in TURNS:
                    self.tried += 1
                    c, s = np.cos(2 * pi * float(turn)), np.sin(2 * pi * float(turn))
                    if (
                        abs(c * there[a] - s * there[b] - here[a]) <= error
                        and abs(s * there[a] + c * there[b] - here[b]) <= error
                    ):
                        return other.key, axis, turn
        return None


def _root_near(d: int) -> Fraction:
    """Root of a number, to 2^-160."""
    return Fraction(isqrt(d << 320), 1 << 160)


def _cosine_near(k: int, N: int) -> Fraction:
    value = cosine_of_part(k, N)
    return value.nearby if isinstance(value, FieldNumber) else value


def _short(x: Fraction, error: Fraction) -> Fraction | None:
    """Round a number to a short decimal, or a simple part of one; None if it is not near."""
    size = Fraction(10) ** floor(log10(abs(float(x)) or 1.0))
    near = Fraction(round(x / size * SHORT)) / SHORT * size
    return near if near and abs(near - x) <= error else None


def _part_of_turn(angle: float) -> Fraction | None:
    """Find the rational part of a turn that an angle is; None if it is none."""
    part = Fraction(angle / (2 * pi)).limit_denominator(MAX_PARTS)
    near = abs(float(part) * 2 * pi - angle) <= ANGLE_ERROR * max(1.0, abs(angle))
    return part if near else None


def _items(tree: Element) -> Iterator[Element]:
    """Yield origins and axes of joints and loops."""
    for owner in tree.children:
        if owner.tag in ("joint", "loop"):
            for item in owner.walk():
                if item.tag in ("origin", "axis", "axis2"):
                    yield item


def _vectors(tree: Element) -> Iterator[tuple[_Item, list[_Word | None]]]:
    """Yield the vectors of a file, and their words of many digits."""
    for item in _items(tree):
        words = item.attributes.get("xyz", "").split()
        if len(words) != 3 or max(map(len, words)) > MAX_DIGITS:
            continue
        values = tuple(decimal(word) for word in words)
        round_off = Fraction(ulp(max(abs(float(x)) for x in values)))
        found: list[_Word | None] = []
        for k, (word, value) in enumerate(zip(words, values, strict=True)):
            places, digits = _count_digits(word)
            long = value and digits >= MIN_DIGITS
            error = max(round_off, Fraction(1, 2 * 10**places))
            word_of_root = _Word((id(item), "xyz", k), value, error, 4 * round_off)
            found.append(word_of_root if long else None)
        yield _Item((id(item), "xyz"), values), found


def _angle_words(item: Element) -> Iterator[tuple[Key, Fraction | None]]:
    """Yield the angles of an origin, as parts of a turn, that are not quarter turns."""
    for k, word in enumerate(item.attributes.get("rpy", "").split()):
        part = _part_of_turn(float(word)) if _count_digits(word)[1] >= MIN_DIGITS else None
        if part is not None and (4 * part).denominator > 1:
            yield (id(item), "rpy", k), part


def _count_digits(word: str) -> tuple[int, int]:
    """Count decimals and significant digits of a number."""
    mantissa, _, exponent = word.lower().partition("e")
    whole, _, fraction = mantissa.lstrip("+-").partition(".")
    places = len(fraction) - int(exponent or 0)
    return max(places, 0), len((whole + fraction).lstrip("0"))
