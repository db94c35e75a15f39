"""The momentum of a planar linkage in the functions of its pose that it is linear in.

Every origin of a part is ``O = Σ_i o_i F_i`` with F the constant 1, the direction E of each
class of parts that do not turn against each other, and ``σ E`` for each prismatic joint. The
coefficients o are complex and linear in the dimensions. Loops are relations
``Σ_i a_i F_i = 0``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from balance.space.formulas.modular_pose import ModularPose, Pair
from balance.space.formulas.planar_parts import PlanarParts

Coefficients = dict[int, Pair]


class FunctionIndex(NamedTuple):
    """Which function belongs to what.

    Attributes:
        of_part: index of the direction of each part; 0, the constant, for those that do not
            turn.
        sign: of each part: its direction is that function times the sign.
        of_joint: index of ``σ E`` of each prismatic joint, and of E.
        size: number of functions, the constant included.
    """

    of_part: tuple[int, ...]
    sign: tuple[int, ...]
    of_joint: Mapping[int, tuple[int, int]]
    size: int

    @property
    def turning(self) -> int:
        """Number of directions that change; they are the functions 1 … turning."""
        return self.size - 1 - len(self.of_joint)


def index_functions(linkage: PlanarParts) -> FunctionIndex:
    """Number the functions of a linkage."""
    count = len(linkage.parts)
    sign = [0] * count
    root = list(range(count))
    for start in range(count):
        if sign[start]:
            continue
        sign[start], waiting = 1, [start]
        while waiting:
            part = waiting.pop()
            for joint in linkage.joints:
                if not joint.slides or part not in joint.parts:
                    continue
                other = sum(joint.parts) - part
                if not sign[other]:
                    sign[other] = sign[part] * joint.signs[0] * joint.signs[1]
                    root[other] = start
                    waiting.append(other)
    roots = sorted(set(root))  # the ground is the first one
    of_part = tuple(roots.index(r) for r in root)
    of_joint, last = {}, len(roots)
    for k, joint in enumerate(linkage.joints):
        if joint.slides:
            of_joint[k] = last, of_part[joint.parts[0]]
            last += 1
    return FunctionIndex(of_part, tuple(sign), of_joint, last)


class LinearPose(NamedTuple):
    """Origins and loops as combinations of functions.

    Attributes:
        origins: coefficients of the origin of each part.
        loops: coefficients that vanish.
    """

    origins: tuple[Coefficients, ...]
    loops: tuple[Coefficients, ...]


def linear_pose(
    linkage: PlanarParts, index: FunctionIndex, values: Sequence[Pair], p: int
) -> LinearPose:
    """Write origins and loops for dimensions modulo a prime."""
    origins: list[Coefficients | None] = [None] * len(linkage.parts)
    origins[0] = {}
    loops: list[Coefficients] = []
    used: set[int] = set()
    waiting = [0]
    while waiting:
        part = waiting.pop(0)
        for k, joint in enumerate(linkage.joints):
            if part not in joint.parts or k in used:
                continue
            used.add(k)
            other = sum(joint.parts) - part
            start = origins[part]
            assert start is not None
            there = _across(linkage, index, values, k, part, start, p)
            origin = origins[other]
            if origin is None:
                origins[other] = there
                waiting.append(other)
            else:
                loops.append(_sum([(there, 1), (origin, -1)], p))
    return LinearPose(tuple(o for o in origins if o is not None), tuple(loops))


def _sum(terms: Sequence[tuple[Coefficients, int]], p: int) -> Coefficients:
    total: Coefficients = {}
    for coefficients, sign in terms:
        for i, (a, b) in coefficients.items():
            c, d = total.get(i, (0, 0))
            total[i] = (c + sign * a) % p, (d + sign * b) % p
    return {i: pair for i, pair in total.items() if pair != (0, 0)}


def _across(
    linkage: PlanarParts,
    index: FunctionIndex,
    values: Sequence[Pair],
    k: int,
    part: int,
    start: Coefficients,
    p: int,
) -> Coefficients:
    """Carry an origin across a joint to the other part."""
    joint = linkage.joints[k]
    other = sum(joint.parts) - part
    if joint.slides:
        first = joint.parts[0]
        function, _ = index.of_joint[k]
        along = index.sign[first] * joint.signs[0]
        step: Coefficients = {function: (along, along)}
        if joint.offset is not None:
            h, c = values[joint.offset]
            s = index.sign[first]
            step = _sum([(step, 1), ({index.of_part[first]: (h * s % p, c * s % p)}, 1)], p)
        return _sum([(start, 1), (step, 1 if part == first else -1)], p)
    terms = [(start, 1)]
    for end, sign in ((part, 1), (other, -1)):
        dimension = linkage.parts[end].points[k]
        if dimension is not None:
            terms.append(({index.of_part[end]: values[dimension]}, sign * index.sign[end]))
    return _sum(terms, p)


def function_values(index: FunctionIndex, pose: ModularPose, p: int) -> list[Pair]:
    """Compute the functions at a pose."""
    values: list[Pair] = [(1, 1)] * index.size
    for part, (i, sign) in enumerate(zip(index.of_part, index.sign, strict=True)):
        e, c = pose.directions[part]
        values[i] = e * sign % p, c * sign % p
    for k, (i, direction) in index.of_joint.items():
        e, c = values[direction]
        values[i] = pose.slides[k] * e % p, pose.slides[k] * c % p
    return values
