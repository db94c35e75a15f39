"""The interval of each number of a file: half a unit of its last digit.

Writers drop zeros at the end of a number, so the last digit is that of the file: a number x of
a file whose numbers have up to F decimals and D significant digits is known to
``max(10^-F, 10^(e - D + 1))`` with ``10^e ≤ |x| < 10^(e+1)``, which holds for formats of fixed
decimals and of fixed significant digits. Whole numbers are exact. A number that is shorter than
both by `EXACT_ZEROS` digits or more is exact: so many zeros do not come from rounding. Where
many numbers of a file are short, they are design values, and `EXACT_ZEROS_OF_MANY` digits
suffice. A file of short numbers is one of design values, unless an axis shows rounding: its
length is one to its digits, and not exactly.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from math import floor, log10, ulp
from typing import NamedTuple

from kinematics.files.urdf.nominal_angles import nearest_twelfth
from kinematics.files.urdf.read_roots import frame_items
from kinematics.model.document.element import Element
from kinematics.numerics.linalg.rational import decimal

# Fewest significant digits of a file whose numbers may be rounded: shorter ones are design
# values.
MIN_DIGITS = 6
# Fewest significant digits of an axis that shows whether numbers are rounded.
MIN_AXIS_DIGITS = 3
# Zeros at the end of a number that do not come from rounding: one in 10^5 does.
EXACT_ZEROS = 5
# The same in a file in which so large a part of the numbers is short by as many digits; of
# rounded numbers, one in a hundred is.
EXACT_ZEROS_OF_MANY, MANY = 2, 0.2
# Half unit, in radians or parts of the lower quartile of lengths: larger ones are no
# rounding.
COARSE = 1e-3
# Digits with which a number stands for a double and its neighbours.
DOUBLE_DIGITS = 16
# Size of numbers that do not tell the digits of a file, and of those that are zero to the
# round-off of a double below one.
TINY, ZERO = 1e-15, 2.0**-54
# Zeros, or nines, in a row before the last digits of a number that is off on purpose:
# ``0.500000000001``. Of rounded numbers, one in a million has them.
RUN = 6
_OFF_ON_PURPOSE = re.compile(rf"(?<=[0-9])(?:0{{{RUN},}}|9{{{RUN},}})[0-9]{{1,4}}$")
# In a file of which many numbers are design values, one whose last digits are within so many
# units of zero, in so many digits, is off on purpose, too: ``8.79999`` and ``11.55999`` are 8.8
# and 11.56 less a unit. Of rounded numbers, one in two hundred is.
OFF_BY_UNITS = ((9, 4), (1, 3))


class FileDigits(NamedTuple):
    """Digits of the numbers of a file.

    Attributes:
        decimals: most digits after the point, F.
        significant: most significant digits, D.
        exact_zeros: digits by which an exact number is shorter than both.
        size: lower quartile of its lengths.
    """

    decimals: int
    significant: int
    exact_zeros: int = EXACT_ZEROS
    size: float = 1.0

    def half_unit(self, word: str, length: bool = True) -> float:
        """Compute half the width of the interval of a number, 0 if it is exact.

        Args:
            length: whether it is a length, or else an angle or part of a direction.
        """
        places, digits = _count_digits(word)
        if not places:
            return 0.0
        short = self.decimals - places, self.significant - digits
        if min(short) >= self.exact_zeros or abs(float(word)) < TINY:
            return 0.0
        if digits < DOUBLE_DIGITS and self._is_off_on_purpose(word):
            return 0.0
        size = abs(float(word))
        exponent = floor(log10(size)) - self.significant + 1
        half: float = 0.5 * max(10.0**-self.decimals, 10.0**exponent)
        coarse = half > COARSE * (self.size if length else 1.0)
        if coarse and self.decimals <= -exponent:
            return 0.0
        return max(half, ulp(size)) if digits >= DOUBLE_DIGITS else half

    def _is_off_on_purpose(self, word: str) -> bool:
        """Whether a number is short but for its last digits, as doubles are by round-off."""
        mantissa = word.lower().partition("e")[0].replace(".", "").lstrip("+-0").rstrip("0")
        if _OFF_ON_PURPOSE.search(mantissa):
            return True
        if self.exact_zeros != EXACT_ZEROS_OF_MANY:
            return False
        return any(
            len(mantissa) > places
            and min(int(mantissa) % 10**places, -int(mantissa) % 10**places) <= units
            for units, places in OFF_BY_UNITS
        )


EXACT = FileDigits(0, 0, exact_zeros=-1000)
"""Those of a file whose numbers are all exact."""

DOUBLES = FileDigits(DOUBLE_DIGITS, DOUBLE_DIGITS)
"""Those of a file of short numbers, and of zeros with the round-off of doubles."""


def file_digits(tree: Element, fewest: int = MIN_DIGITS) -> FileDigits | None:
    """Find the digits of the origins and axes of a file.

    Args:
        tree: the checked tree of a file.
        fewest: significant digits of a file whose numbers may be rounded.

    Returns:
        The digits; None if all numbers are short, and so exact.
    """
    numbers = [word for word in _geometry_words(tree) if float(word)]
    words = [word for word in numbers if abs(float(word)) >= TINY]
    counts = [count for word in words if (count := _count_digits(word))[0]]
    decimals, significant = (max((x[k] for x in counts), default=0) for k in (0, 1))
    significant = min(significant, DOUBLE_DIGITS + 1)
    if significant < fewest and not _has_rounded_axis(tree):
        return DOUBLES if any(abs(float(word)) < ZERO for word in numbers) else None
    short = sum(min(decimals - x, significant - y) >= EXACT_ZEROS_OF_MANY for x, y in counts)
    many = short > MANY * len(counts)
    exact_zeros = EXACT_ZEROS_OF_MANY if many else EXACT_ZEROS
    sizes = (abs(float(x)) for x in _words_of(tree, ("origin",), "xyz"))
    lengths = sorted(x for x in sizes if x >= TINY) or [1.0]
    size = lengths[len(lengths) // 4]
    return FileDigits(decimals, significant, exact_zeros, size)


def half_unit_of_file(tree: Element, digits: FileDigits, size: float) -> float:
    """Find the largest half unit of the numbers of a file that are not exact.

    Unlike `rounding_of_file`, which measures each kind of numbers by its own digits, it takes
    design values as exact: they leave nothing open.

    Args:
        tree: the checked tree of a file.
        digits: those of the file.
        size: length of which the units of origins are parts, metres.

    Returns:
        The half unit, in radians and parts of the size.
    """
    angles = [*_words_of(tree, ("origin",), "rpy"), *_words_of(tree, ("axis", "axis2"), "xyz")]
    lengths = _words_of(tree, ("origin",), "xyz")
    widths = [digits.half_unit(word, False) for word in angles if float(word)]
    widths += [digits.half_unit(word) / size for word in lengths if float(word)]
    return max(widths, default=0.0)


def rounding_of_file(tree: Element, size: float) -> float:
    """Find the largest half unit of the last digits of origins, angles and axes.

    Digits are those of each kind of numbers: a file may have angles of five digits beside
    origins of sixteen.

    Args:
        tree: the checked tree of a file.
        size: length of which the units of origins are parts, metres.

    Returns:
        The half unit, in radians and parts of the size.
    """
    largest = 0.0
    for tags, name, unit in (
        (("origin",), "xyz", size),
        (("origin",), "rpy", 1.0),
        (("axis", "axis2"), "xyz", 1.0),
    ):
        words = [word for word in _words_of(tree, tags, name) if abs(float(word)) >= TINY]
        counts = [_count_digits(word) for word in words]
        if not any(places for places, _ in counts):
            continue
        decimals, significant = (max(x[k] for x in counts) for k in (0, 1))
        for word in words:
            exponent = floor(log10(abs(float(word)))) - significant + 1
            half = 0.5 * max(10.0**-decimals, 10.0**exponent)
            largest = max(largest, half / unit)
    return largest


def _words_of(tree: Element, tags: tuple[str, ...], name: str) -> Iterator[str]:
    """Yield the numbers of an attribute, without angles that stand for multiples of π/12."""
    for item in frame_items(tree, tags):
        for word in item.attributes.get(name, "").split():
            if name != "rpy" or not nearest_twelfth(word):
                yield word


def _geometry_words(tree: Element) -> Iterator[str]:
    """Yield the numbers of origins and axes, without those that stand for multiples of π/12."""
    yield from _words_of(tree, ("origin", "axis", "axis2"), "xyz")
    yield from _words_of(tree, ("origin",), "rpy")


def _has_rounded_axis(tree: Element) -> bool:
    """Whether the length of an axis is one to its digits, and not exactly."""
    items = (item for owner in tree.children for item in owner.walk())
    for item in items:
        if item.tag not in ("axis", "axis2"):
            continue
        words = item.attributes.get("xyz", "").split()
        counts = [_count_digits(word) for word in words]
        if max((digits for _, digits in counts), default=0) < MIN_AXIS_DIGITS:
            continue
        numbers = [decimal(word) for word in words]
        off = abs(sum((x * x for x in numbers), Fraction(-1)))
        unit = Fraction(1, 10 ** max(places for places, _ in counts))
        if 0 < off <= unit * sum(map(abs, numbers), Fraction(0)):
            return True
    return False


def _count_digits(word: str) -> tuple[int, int]:
    """Count decimals and significant digits of a number, without zeros at its end."""
    mantissa, _, exponent = word.lower().partition("e")
    whole, _, fraction = mantissa.lstrip("+-").partition(".")
    digits = (whole + fraction).rstrip("0")
    places = len(digits) - len(whole) - int(exponent or 0)
    return max(places, 0), len(digits.lstrip("0"))
