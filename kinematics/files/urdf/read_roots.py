"""Find the numbers of a file that stand for roots, sines and cosines, to all their digits.

They have 15 digits or more; see `kinematics.files.urdf.closed_forms` for their forms. Angles
that are rational parts of a turn are read as such.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm, pi, ulp

from kinematics.files.urdf.closed_forms import NumberVector, NumberWord, read_closed_forms
from kinematics.model.document.element import Element
from kinematics.model.linkage import Notice
from kinematics.numerics.linalg.cyclotomic import cosine_of_part, sine_of_part
from kinematics.numerics.linalg.rational import MAX_DIGITS, Vector, count_digits, decimal

# Fewest significant digits of a number that may stand for a root.
MIN_DIGITS = 15
# Most numbers of a file with so many digits.
MAX_NUMBERS = 2000
# Largest error of an angle, radians, and largest denominator of its part of a turn.
ANGLE_ERROR, MAX_PARTS = 2.0**-51, 60


@dataclass(frozen=True)
class FileRoots:
    """Numbers of a file that are read as roots, sines or cosines.

    Attributes:
        conductor: that of the field in which they are; 1 for fractions alone.
        numbers: their values, by identity of the element and attribute, and place in it.
        notices: one for each of them and of the angles, ``read_as_root``.
    """

    conductor: int
    numbers: Mapping[tuple[Hashable, int], Fraction]
    notices: tuple[Notice, ...]

    def vector(self, item: Element | None, attribute: str, words: Iterable[str]) -> Vector:
        """Read the numbers of an attribute."""
        return tuple(
            self.numbers.get(((id(item), attribute), k), decimal(word))
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


def read_roots(tree: Element) -> FileRoots | None:
    """Find the numbers of a file that stand for roots, sines and cosines.

    Args:
        tree: the checked tree of a file.

    Returns:
        Their values in one field; None if there are none.
    """
    vectors = list(_vectors(tree))
    angles = [angle for item in frame_items(tree) for angle in _angle_words(item)]
    count = sum(word is not None for vector in vectors for word in vector.words)
    if not count and not angles or count > MAX_NUMBERS:
        return None
    forms = read_closed_forms(vectors, [lcm(4, part.denominator) for _, part in angles])
    conductor = forms.conductor
    parts = [(item, part) for item, part in angles if conductor % lcm(4, part.denominator) == 0]
    if not forms.numbers and not parts:
        return None
    labels: dict[Hashable, str] = {(id(item), "xyz"): item.label for item in frame_items(tree)}
    texts = [
        f"{labels[key[0]]}: {float(number)} is read as {forms.texts[key]}"
        for key, number in forms.numbers.items()
    ]
    texts += [
        f"{item.label}: {float(2 * pi * part)} is read as a turn by {part * 360} degrees"
        for item, part in parts
    ]
    notices = tuple(Notice("read_as_root", text) for text in texts)
    return FileRoots(conductor, forms.numbers, notices)


def has_many_digits(tree: Element) -> bool:
    """Whether numbers of a file have so many digits that roots are told from others.

    Args:
        tree: the checked tree of a file.
    """
    vectors = (item.attributes.get("xyz", "") for item in frame_items(tree))
    return any(count_digits(word)[1] >= MIN_DIGITS for xyz in vectors for word in xyz.split())


def _part_of_turn(angle: float) -> Fraction | None:
    """Find the rational part of a turn that an angle is; None if it is none."""
    part = Fraction(angle / (2 * pi)).limit_denominator(MAX_PARTS)
    near = abs(float(part) * 2 * pi - angle) <= ANGLE_ERROR * max(1.0, abs(angle))
    return part if near else None


def frame_items(
    tree: Element, tags: Sequence[str] = ("origin", "axis", "axis2")
) -> Iterator[Element]:
    """Yield origins and axes of joints and loops."""
    for owner in tree.children:
        if owner.tag in ("joint", "loop"):
            for item in owner.walk():
                if item.tag in tags:
                    yield item


def _vectors(tree: Element) -> Iterator[NumberVector]:
    """Yield the vectors of a file."""
    for item in frame_items(tree):
        words = item.attributes.get("xyz", "").split()
        if len(words) != 3 or max(map(len, words)) > MAX_DIGITS:
            continue
        key, values = (id(item), "xyz"), tuple(decimal(word) for word in words)
        round_off = Fraction(ulp(max(abs(float(x)) for x in values)))
        numbers: list[NumberWord | None] = []
        for k, (word, value) in enumerate(zip(words, values, strict=True)):
            places, digits = count_digits(word)
            error = max(round_off, Fraction(1, 2 * 10**places))
            many = value and digits >= MIN_DIGITS
            numbers.append(NumberWord((key, k), value, error, 4 * round_off) if many else None)
        yield NumberVector(key, values, tuple(numbers))


def _angle_words(item: Element) -> Iterator[tuple[Element, Fraction]]:
    """Yield the angles of an origin that are parts of a turn, but no quarter turns."""
    for word in item.attributes.get("rpy", "").split():
        part = _part_of_turn(float(word)) if count_digits(word)[1] >= MIN_DIGITS else None
        if part is not None and (4 * part).denominator > 1:
            yield item, part
