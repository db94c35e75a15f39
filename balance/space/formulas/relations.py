"""Linear relations between the dimensions of a linkage, such as ``AB=CD`` or ``AB=2*BC``."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, pairwise
from typing import NamedTuple, TypeVar

from balance.space.formulas.modular_pose import Pair
from balance.space.formulas.notations import Variable
from balance.space.formulas.planar_parts import Dimension, PlanarParts
from balance.support.tolerances import FORMULA_RELATION
from kinematics.errors import ExactError, UsageError
from kinematics.numerics.linalg.rational import echelon

Combination = dict[int, Fraction]
T = TypeVar("T")


class DimensionRelation(NamedTuple):
    """A combination of dimensions that vanishes.

    Attributes:
        words: by letters of joints.
        terms: coefficients of dimensions.
    """

    words: str
    terms: Combination


class _Segment(NamedTuple):
    """The way between two joints of a part, on the x-axis of its frame or as one dimension."""

    letters: str
    terms: Combination
    value: complex


def segments(linkage: PlanarParts) -> Iterator[_Segment]:
    """List distances between joints that are linear in the dimensions, from the longest side.

    They are distances on lines through the origin of a frame, and points, which are complex.
    """
    for part in linkage.parts:
        turning = [k for k in part.joints if not linkage.joints[k].slides]
        for j, k in combinations(turning, 2):
            terms: Combination = {}
            kinds = set()
            value = 0j
            for joint, sign in ((k, 1), (j, -1)):
                if (dimension := part.points[joint]) is not None:
                    each = linkage.dimensions[dimension]
                    terms[dimension] = Fraction(sign)
                    value += sign * each.value
                    kinds.add(each.kind)
            if kinds != {"length"} and not (kinds == {"point"} and len(terms) == 1):
                continue
            letters = linkage.joints[j].letter + linkage.joints[k].letter
            if kinds == {"length"} and value.real < 0:
                terms, value = {i: -c for i, c in terms.items()}, -value
            if abs(value) > 0:
                yield _Segment(letters, terms, value)


def relations_in(linkage: PlanarParts) -> list[DimensionRelation]:
    """Find equal distances in a linkage, and equal points in frames of links."""
    distinct: list[_Segment] = []
    relations: list[DimensionRelation] = []
    for segment in segments(linkage):
        for other in distinct:
            if abs(segment.value - other.value) <= FORMULA_RELATION * abs(segment.value):
                words = f"{other.letters} = {segment.letters}"
                relations.append(
                    DimensionRelation(words, _difference(segment.terms, other.terms))
                )
                break
        else:
            distinct.append(segment)
    return relations


def _difference(a: Combination, b: Combination, factor: Fraction = Fraction(1)) -> Combination:
    terms = dict(a)
    for i, c in b.items():
        terms[i] = terms.get(i, Fraction(0)) - factor * c
    return {i: c for i, c in terms.items() if c}


def parse_relations(linkage: PlanarParts, texts: Sequence[str]) -> list[DimensionRelation]:
    """Parse relations of distances by letters or names: ``AB=CD``, ``l_crank=2*BC``.

    Raises:
        UsageError: a text is no relation.
        ExactError: it names no distance, or does not hold in the linkage.
    """
    known = {}
    for segment in segments(linkage):
        known[segment.letters] = segment.terms
        known[segment.letters[::-1]] = segment.terms
    for i, dimension in enumerate(linkage.dimensions):
        known[dimension.name] = {i: Fraction(1)}
    parsed = []
    for text, (a, factor), (b, other) in neighbours(texts, known, "distance"):
        scaled = {i: c * factor for i, c in a.items()}
        parsed.append(DimensionRelation(text, _difference(scaled, b, other)))
    for relation in parsed:
        _check_holds(linkage, relation)
    return [relation for relation in parsed if relation.terms]


def _check_holds(linkage: PlanarParts, relation: DimensionRelation) -> None:
    """Check that a relation holds in the linkage, with which formulas are compared."""
    parts = [float(c) * linkage.dimensions[i].value for i, c in relation.terms.items()]
    if abs(sum(parts)) > FORMULA_RELATION * sum(map(abs, parts)):
        raise ExactError(
            f"{linkage.source}: --where '{relation.words}' does not hold in the file: give a "
            "file with such dimensions"
        )


def neighbours(
    texts: Sequence[str], known: Mapping[str, T], noun: str
) -> Iterator[tuple[str, tuple[T, Fraction], tuple[T, Fraction]]]:
    """Parse relations, and yield their words and each two neighbouring sides.

    Args:
        known: what may stand on a side, by name; a side is one of its values, and a factor.
        noun: what one of them is called.

    Raises:
        UsageError: a text is no relation.
        ExactError: it names nothing that is known.
    """
    for text in (word.strip() for each in texts for word in each.split(",")):
        sides = [_side(text, side, known, noun) for side in text.split("=")]
        if len(sides) < 2:
            raise UsageError(f"--where '{text}': write AB=CD, or AB=2*CD")
        yield from ((text, *pair) for pair in pairwise(sides))


def _side(text: str, side: str, known: Mapping[str, T], noun: str) -> tuple[T, Fraction]:
    """Parse one side of a relation."""
    match = re.fullmatch(r"\s*(?:(\d+(?:/[1-9]\d*)?|\d+\.\d+)\s*\*\s*)?(\S+)\s*", side)
    if match is None or match[2] not in known:
        names = ", ".join(sorted(known))
        raise ExactError(f"--where '{text}': no {noun} '{side.strip()}': there are {names}")
    return known[match[2]], Fraction(match[1] or 1)


def write_sum(terms: Mapping[int, Fraction], dimensions: Sequence[Dimension]) -> str:
    """Write a sum of dimensions with fractions: ``l_a - 1/2 l_b``."""
    text = ""
    for j, c in sorted(terms.items()):
        factor = "" if abs(c) == 1 else f"{abs(c)} "
        sign = (" - " if c < 0 else " + ") if text else "-" * (c < 0)
        text += f"{sign}{factor}{dimensions[j].name}"
    return text


class FreeDimensions:
    """Dimensions under relations: some are free, the others are combinations of them.

    A free point has two variables: itself and its conjugate, or x and i y. The variable of an
    offset is i times it.

    Attributes:
        linkage: the parts.
        free: indices of the free dimensions.
        terms: each dimension as a combination of free ones.
        variables: of the formulas.
    """

    def __init__(
        self, linkage: PlanarParts, relations: Sequence[DimensionRelation], cartesian: bool
    ) -> None:
        """Solve the relations.

        Args:
            linkage: the parts.
            relations: between their dimensions.
            cartesian: whether variables of points are x and i y.

        Raises:
            ExactError: they leave a dimension zero.
        """
        self.linkage, self.cartesian = linkage, cartesian
        count = len(linkage.dimensions)
        backwards = range(count - 1, -1, -1)
        rows = [[r.terms.get(i, Fraction(0)) for i in backwards] for r in relations]
        solved, pivots = echelon(rows) if rows else ([], [])
        self.terms: dict[int, Combination] = {}
        for row, pivot in zip(solved, pivots, strict=True):
            self.terms[count - 1 - pivot] = {
                count - 1 - c: -row[c] for c in range(count) if c != pivot and row[c]
            }
        for i, terms in self.terms.items():
            if not terms:
                name = linkage.dimensions[i].name
                raise ExactError(f"relations leave no value but zero for {name}")
        self.free = [i for i in range(count) if i not in self.terms]
        self.terms |= {i: {i: Fraction(1)} for i in self.free}
        self.variables = [variable for i in self.free for variable in self._variables_of(i)]

    @property
    def angles(self) -> list[bool]:
        """Tell for each variable that it is no angle."""
        return [False] * len(self.variables)

    def spread(self, point: Sequence[int], p: int) -> list[int]:
        """Compute the values of the variables at a point: they are the point itself."""
        return [x % p for x in point]

    @property
    def special(self) -> bool:
        """Whether there are relations."""
        return len(self.free) < len(self.terms)

    def further_words(self) -> list[str]:
        """State relations that are not linear: there are none."""
        return []

    def _variables_of(self, i: int) -> list[Variable]:
        name, kind, *_ = self.linkage.dimensions[i]
        if kind != "point":
            return [Variable(name, "imaginary" if kind == "offset" else "real")]
        if self.cartesian:
            return [Variable(f"x{name[1:]}", "real"), Variable(f"y{name[1:]}", "imaginary")]
        return [Variable(name, "complex"), Variable(name, "conjugate")]

    def argument_names(self) -> list[str]:
        """List the names of the variables, each once."""
        return list(dict.fromkeys(variable.name for variable in self.variables))

    def equals(self, i: int) -> str:
        """Write a dimension that is not free in the free ones; empty for a free one."""
        if i in self.free:
            return ""
        return write_sum(self.terms[i], self.linkage.dimensions)

    def pairs(self, values: Sequence[int], p: int) -> list[Pair]:
        """Compute all dimensions from values of the variables, modulo a prime."""
        at = iter(values)
        free: dict[int, Pair] = {}
        for i in self.free:
            x, kind = next(at), self.linkage.dimensions[i].kind
            if kind == "point":
                y = next(at)
                free[i] = ((x + y) % p, (x - y) % p) if self.cartesian else (x, y)
            else:
                free[i] = x, -x % p if kind == "offset" else x
        out = []
        for i in range(len(self.linkage.dimensions)):
            terms = [
                (c.numerator * pow(c.denominator, -1, p), free[j])
                for j, c in self.terms[i].items()
            ]
            out.append(
                (sum(c * x for c, (x, _) in terms) % p, sum(c * y for c, (_, y) in terms) % p)
            )
        return out

    def values_in_file(self) -> list[complex]:
        """Return the values of the variables in the linkage."""
        out: list[complex] = []
        for i in self.free:
            _, kind, _, _, value = self.linkage.dimensions[i]
            if kind == "offset":
                out.append(1j * value.real)
            elif kind != "point":
                out.append(value)
            elif self.cartesian:
                out += [complex(value.real), 1j * value.imag]
            else:
                out += [value, value.conjugate()]
        return out

    def draw(self, p: int, rng: random.Random) -> list[int]:
        """Draw values of the variables modulo a prime."""
        return [rng.randrange(1, p) for _ in self.variables]
