"""Dimensions of spatial linkages as variables: lengths, and cosines and sines of angles.

The one relation that is no equality is G. T. Bennett's (1903): opposite links of a loop of four
joints are equal, and lengths are to each other as the sines of twists.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple

import numpy as np

from balance.space.formulas.interpolation import cosine_sine, spread_point
from balance.space.formulas.notations import Variable
from balance.space.formulas.relations import DimensionRelation, neighbours, write_sum
from balance.space.formulas.spatial_parts import SpatialParts
from balance.space.formulas.spatial_pose import Value
from balance.support.tolerances import FORMULA_RELATION
from kinematics.errors import ExactError
from kinematics.numerics.linalg.rational import echelon


class BennettLoop(NamedTuple):
    """Dimensions of a Bennett linkage: of the first two moving links.

    Attributes:
        first_length, first_twist: of the first link, and of the third one.
        second_length, second_twist: of the second link, and of the ground.
    """

    first_length: int
    first_twist: int
    second_length: int
    second_twist: int


def bennett_loop(
    linkage: SpatialParts,
) -> tuple[BennettLoop, list[DimensionRelation]] | None:
    """Find the relations of a Bennett linkage; None where the moving links do not have them."""
    if not linkage.closed or len(linkage.joints) != 4:
        return None
    if any(joint.kind != "revolute" or joint.constant is not None for joint in linkage.joints):
        return None
    places = [next(iter(part.places.values())) for part in linkage.parts[1:]]
    lengths = [place.normal for place in places]
    twists = [place.twist for place in places]
    if None in lengths or None in twists:
        return None
    a = [linkage.dimensions[i].value.real for i in lengths if i is not None]
    alpha = [linkage.dimensions[i].value.real for i in twists if i is not None]
    pairs = (
        (a[0], a[2]),
        (alpha[0], alpha[2]),
        (a[0] * np.sin(alpha[1]), a[1] * np.sin(alpha[0])),
    )
    if any(abs(x - y) > FORMULA_RELATION * abs(x) for x, y in pairs):
        return None
    indices = [lengths[0], twists[0], lengths[1], twists[1]]
    loop = BennettLoop(*(i for i in indices if i is not None))
    relations = []
    for i, j in ((lengths[0], lengths[2]), (twists[0], twists[2])):
        assert i is not None and j is not None
        relations.append(_equality(linkage, i, j))
    return loop, relations


def _equality(linkage: SpatialParts, i: int, j: int) -> DimensionRelation:
    """Write that dimension j equals dimension i."""
    first, second = linkage.dimensions[i], linkage.dimensions[j]
    words = f"{second.name} = {first.name}"
    if first.kind == "angle":
        words = f"c_{second.name} = c_{first.name}, s_{second.name} = s_{first.name}"
    return DimensionRelation(words, {j: Fraction(1), i: Fraction(-1)})


class SpatialDimensions:
    """Dimensions of a spatial linkage under relations: some are free, the others follow.

    Attributes:
        linkage: the parts.
        free: indices of the free dimensions.
        terms: each dimension as a combination of free ones.
        proportional: the relation of a Bennett linkage, if it is one.
        variables: of the formulas; an angle has two, its cosine and its sine.
        angles: for each free dimension, whether it is an angle, drawn as tangent of its half.
    """

    def __init__(
        self,
        linkage: SpatialParts,
        relations: Sequence[DimensionRelation],
        proportional: BennettLoop | None = None,
    ) -> None:
        """Solve the relations.

        Raises:
            ExactError: they leave a dimension zero.
        """
        self.linkage, self.proportional = linkage, proportional
        count = len(linkage.dimensions)
        backwards = range(count - 1, -1, -1)
        rows = [[r.terms.get(i, Fraction(0)) for i in backwards] for r in relations]
        solved, pivots = echelon(rows) if rows else ([], [])
        self.terms: dict[int, dict[int, Fraction]] = {}
        for row, pivot in zip(solved, pivots, strict=True):
            self.terms[count - 1 - pivot] = {
                count - 1 - c: -row[c] for c in range(count) if c != pivot and row[c]
            }
        for i, terms in self.terms.items():
            if not terms:
                name = linkage.dimensions[i].name
                raise ExactError(f"relations leave no value but zero for {name}")
        follows = set(self.terms) | ({proportional.second_length} if proportional else set())
        self.free = [i for i in range(count) if i not in follows]
        self.angles = [linkage.dimensions[i].kind == "angle" for i in self.free]
        self.variables: list[Variable] = []
        for i, angle in zip(self.free, self.angles, strict=True):
            name = linkage.dimensions[i].name
            names = (f"c_{name}", f"s_{name}") if angle else (name,)
            self.variables += [Variable(each, "real") for each in names]

    @property
    def special(self) -> bool:
        """Whether there are relations."""
        return len(self.free) < len(self.linkage.dimensions)

    def further_words(self) -> list[str]:
        """State the relation of a Bennett linkage."""
        if self.proportional is None:
            return []
        i = self.proportional.second_length
        return [f"{self.linkage.dimensions[i].name} = {self.equals(i)}"]

    def argument_names(self) -> list[str]:
        """List the names of the variables."""
        return [variable.name for variable in self.variables]

    def equals(self, i: int) -> str:
        """Write a dimension that is not free in the free ones; empty for a free one."""
        dimensions = self.linkage.dimensions
        if self.proportional is not None and i == self.proportional.second_length:
            first, twist, _, other = (dimensions[k].name for k in self.proportional)
            return f"{first} s_{other}/s_{twist}"
        if i not in self.terms:
            return ""
        return write_sum(self.terms[i], dimensions)

    def pairs(self, point: Sequence[int], p: int) -> list[Value]:
        """Compute all dimensions from values of the free ones, modulo p."""
        free: dict[int, Value] = {}
        for i, x, angle in zip(self.free, point, self.angles, strict=True):
            free[i] = cosine_sine(x, p) if angle else x
        if self.proportional is not None:
            first, twist, second, other = self.proportional
            a, (_, s), (_, t) = free[first], free[twist], free[other]  # type: ignore[misc]
            assert isinstance(a, int)
            free[second] = a * t * pow(s, -1, p) % p
        out: list[Value] = []
        for i in range(len(self.linkage.dimensions)):
            if i in free:
                out.append(free[i])
            elif self.linkage.dimensions[i].kind == "angle":
                (same,) = self.terms[i]
                out.append(free[same])
            else:
                total = 0
                for j, c in self.terms[i].items():
                    value = free[j]
                    assert isinstance(value, int)
                    total += c.numerator * pow(c.denominator, -1, p) * value
                out.append(total % p)
        return out

    def values_in_file(self) -> list[complex]:
        """Return the values of the variables in the linkage."""
        out: list[complex] = []
        for i, angle in zip(self.free, self.angles, strict=True):
            value = self.linkage.dimensions[i].value.real
            out += (
                [complex(np.cos(value)), complex(np.sin(value))] if angle else [complex(value)]
            )
        return out

    def draw(self, p: int, rng: random.Random) -> list[int]:
        """Draw values of the free dimensions modulo a prime."""
        return [rng.randrange(1, p) for _ in self.free]

    def spread(self, point: Sequence[int], p: int) -> list[int]:
        """Compute the values of the variables at values of the free dimensions."""
        return spread_point(point, self.angles, p)


def spatial_relations(linkage: SpatialParts) -> list[DimensionRelation]:
    """Find equal lengths, equal offsets and equal angles in a linkage."""
    relations: list[DimensionRelation] = []
    followed: set[int] = set()
    for (i, a), (j, b) in combinations(enumerate(linkage.dimensions), 2):
        if a.kind != b.kind or j in followed:
            continue
        x, y = a.value.real, b.value.real
        if abs(x - y) <= FORMULA_RELATION * abs(x):
            followed.add(j)
            relations.append(_equality(linkage, i, j))
    return relations


def parse_spatial_relations(
    linkage: SpatialParts, texts: Sequence[str]
) -> list[DimensionRelation]:
    """Parse relations of lengths by names, or by letters of joints: ``l_upper=2*l_lower``.

    Raises:
        UsageError: a text is no relation.
        ExactError: it names no length, or does not hold in the linkage.
    """
    known: dict[str, int] = {}
    for i, dimension in enumerate(linkage.dimensions):
        if dimension.kind == "length":
            known |= {dimension.joints: i, dimension.joints[::-1]: i}
        if dimension.kind == "angle":
            known |= {f"c_{dimension.name}": i, f"s_{dimension.name}": i}
        else:
            known[dimension.name] = i
    parsed = []
    for text, (i, factor), (j, other) in neighbours(texts, known, "dimension"):
        kinds = [linkage.dimensions[k].kind == "angle" for k in (i, j)]
        if kinds[0] != kinds[1] or (kinds[0] and factor != other):
            raise ExactError(f"--where '{text}': an angle can only equal another angle")
        x, y = (linkage.dimensions[k].value.real for k in (i, j))
        if abs(factor * x - other * y) > FORMULA_RELATION * abs(factor * x):
            raise ExactError(
                f"{linkage.source}: --where '{text}' does not hold in the file: give a file "
                "with such dimensions"
            )
        if i != j:
            parsed.append(DimensionRelation(text, {i: factor, j: -other}))
    return parsed
