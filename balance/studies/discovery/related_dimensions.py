"""Dimensions of a planar linkage modulo a prime, drawn under the relations of a family.

A relation is a polynomial in squares of distances, or in the products ``(b - a) (c - a)*`` of
which the arguments are angles. Each is solved for a variable of its own, in which it is of the
first or second degree, or has even powers up to the fourth; variables of relations that are
solved before stay as they are.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from math import prod

from balance.space.formulas.modular_pose import Pair, UnclosedError
from balance.space.formulas.planar_parts import PlanarParts
from balance.space.formulas.relations import FreeDimensions
from balance.studies.discovery.quantities import InvariantQuantity
from balance.studies.discovery.relations import GeometryRelation
from kinematics.errors import ExactError
from kinematics.numerics.linalg.prime_field import (
    PRIMES_OF_61_BITS,
    interpolate_modulo,
    root_modulo,
)

PolynomialCondition = Callable[[Sequence[Pair], int], int]

# Highest degree of a relation in one variable, and draws until all roots exist.
DEGREE, DRAWS = 8, 200
# Draws of which one is on the branch of the family, if there is any.
BRANCHES = 12


def condition_of(
    relation: GeometryRelation,
    quantities: Sequence[InvariantQuantity],
    linkage: PlanarParts,
) -> PolynomialCondition:
    """Write a relation as a polynomial in dimensions that vanishes.

    Args:
        relation: of a family.
        quantities: of its topology.
        linkage: a member, whose joints have the letters of the topology as names.

    Raises:
        ExactError: it is none.
    """
    sides = [
        [quantities[k].joints for k in side]
        for side in (relation.left_side, relation.right_side)
    ]
    number = {joint.name: k for k, joint in enumerate(linkage.joints)}

    def places(joints: Sequence[int], values: Sequence[Pair]) -> list[Pair]:
        """Place joints in the frame of the part that carries all of them."""
        indices = [number[chr(65 + j)] for j in joints]
        part = next(each for each in linkage.parts if all(k in each.points for k in indices))
        positions = [part.points[k] for k in indices]
        return [(0, 0) if k is None else values[k] for k in positions]

    def square(joints: Sequence[int], values: Sequence[Pair]) -> int:
        (a, b), (c, d) = places(joints, values)
        return (c - a) * (d - b)

    def corner(joints: Sequence[int], values: Sequence[Pair]) -> Pair:
        """A product whose argument is an angle, and its conjugate."""
        (x, y), (a, b), (c, d) = places(joints, values)
        return (c - x) * (b - y), (d - y) * (a - x)

    def loop(joints: Sequence[int], values: Sequence[Pair]) -> list[int]:
        following = [*joints[1:], joints[0]]
        return [square(pair, values) for pair in zip(joints, following, strict=True)]

    def value(values: Sequence[Pair], p: int) -> int:
        left, right = sides
        match relation.kind:
            case "right":
                return sum(corner(left[0], values)) % p
            case "same angle" | "opposite angle":
                (u, ū), (v, v̄) = corner(left[0], values), corner(right[0], values)
                if relation.kind == "same angle":
                    v, v̄ = v̄, v
                return (u * v - ū * v̄) % p
            case "product":
                first, second = (prod(square(x, values) for x in side) for side in sides)
                return (first - second) % p
            case "equal" | "squares":
                first, second = (sum(square(x, values) for x in side) for side in sides)
                return (first - second) % p
        (ab, bc, cd, da), (ef, fg, gh, he) = loop(left[0], values), loop(right[0], values)
        if quantities[relation.left_side[0]].kind == "slope":
            return (ab * da * fg * gh - ef * he * bc * cd) % p
        first_excess, second_excess = bc + cd - ab - da, fg + gh - ef - he
        return (first_excess**2 * fg * gh - second_excess**2 * bc * cd) % p

    if relation.kind in ("sum", "supplement"):
        raise ExactError(f"relations of the kind '{relation.kind}' are no polynomials")
    return value


class RelatedDimensions(FreeDimensions):
    """Dimensions that fulfil conditions."""

    def __init__(self, linkage: PlanarParts, conditions: Sequence[PolynomialCondition]) -> None:
        """Choose a variable for each condition.

        Raises:
            ExactError: there is no such choice.
        """
        super().__init__(linkage, [], cartesian=True)
        p, rng = PRIMES_OF_61_BITS[0], random.Random(7)
        at = super().draw(p, rng)
        # What holds by the zeros of the file alone is no condition.
        self._conditions = [f for f in conditions if f(self.pairs(at, p), p)]
        degrees = [
            [self._polynomial(f, at, v, p) for v in range(len(at))] for f in self._conditions
        ]
        self._order = _choose(degrees, [], set())
        if self._order is None:
            raise ExactError("its relations cannot be solved one after the other")

    @property
    def special(self) -> bool:
        """Whether there are conditions."""
        return bool(self._conditions)

    def draw(self, p: int, rng: random.Random) -> list[int]:
        """Draw values of the variables modulo a prime that fulfil the conditions.

        Raises:
            UnclosedError: roots do not exist.
        """
        for _ in range(DRAWS):
            values = super().draw(p, rng)
            for number, variable in self._order or []:
                f = self._conditions[number]
                root = _root(self._polynomial(f, values, variable, p), p, rng)
                if root is None:
                    break
                values[variable] = root
            else:
                return values
        raise UnclosedError

    def _polynomial(
        self, f: PolynomialCondition, values: Sequence[int], v: int, p: int
    ) -> list[int]:
        """Compute the coefficients of a condition in one variable, without leading zeros."""
        changed, points, table = list(values), range(DEGREE + 1), []
        for changed[v] in points:
            table.append(f(self.pairs(changed, p), p))
        coefficients = interpolate_modulo(points, table, p)
        while coefficients and not coefficients[-1]:
            coefficients.pop()
        return coefficients


def _solvable(coefficients: Sequence[int]) -> bool:
    """Whether roots are those of square roots."""
    degree = len(coefficients) - 1
    return degree in (1, 2) or (degree == 4 and not any(coefficients[1::2]))


def _root(coefficients: list[int], p: int, rng: random.Random) -> int | None:
    """Draw a root that is not 0; None if there is none."""
    if not _solvable(coefficients):
        return None
    if len(coefficients) == 2:
        return -coefficients[0] * pow(coefficients[1], -1, p) % p or None
    if len(coefficients) == 5:
        square = _root(coefficients[::2], p, rng)
        root = None if square is None else root_modulo(square, p)
        return None if root is None else rng.choice((root, -root)) % p
    c, b, a = coefficients
    root = root_modulo((b * b - 4 * a * c) % p, p)
    if root is None:
        return None
    return (rng.choice((root, -root)) - b) * pow(2 * a, -1, p) % p or None


def _choose(
    polynomials: Sequence[Sequence[list[int]]], order: list[tuple[int, int]], fixed: set[int]
) -> list[tuple[int, int]] | None:
    """Choose an order of conditions, and a variable for each that is in none before.

    Args:
        polynomials: of each condition in each variable.
        order: conditions and variables so far.
        fixed: variables of these conditions.
    """
    done = {number for number, _ in order}
    if len(done) == len(polynomials):
        return order
    for number, listed in enumerate(polynomials):
        if number in done:
            continue
        # A condition with a power of a variable as a factor does not bind that variable.
        used = {v for v, each in enumerate(listed) if sum(x != 0 for x in each) > 1}
        for v in sorted(used - fixed, key=lambda v: len(listed[v])):
            if _solvable(listed[v]):
                chosen = _choose(polynomials, [*order, (number, v)], fixed | used)
                if chosen is not None:
                    return chosen
    return None
