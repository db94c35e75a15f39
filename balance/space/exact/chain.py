"""A linkage and its motion in rational numbers, the input of exact ranks.

Structure, and which joints are independent, come from the assembled linkage; numbers come
from the decimals of its file. Axes keep the lengths that they have there, so the relations
of a motion, and of joints that follow others, are rescaled by the lengths of their axes. Where
a ratio of lengths is irrational, the screw of one of the joints is multiplied by its square
root, so that the relations are rational.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from fractions import Fraction
from itertools import combinations
from math import gcd, prod
from typing import NamedTuple

import numpy as np

from balance.space.exact.radicals import square_classes
from kinematics.closure.assembly.assemble import moving_chain
from kinematics.errors import ExactError, InexactPlaneError
from kinematics.files.urdf.rational_screws import Geometry
from kinematics.model.chain import loop_joints
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.cyclotomic import FieldNumber
from kinematics.numerics.linalg.rational import (
    Vector,
    cross,
    dot,
    echelon,
    nearby_vector,
    rational_bracket,
    rational_null_space,
    root,
)
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import count_noun

Relation = dict[int, Fraction]


class ExactChain(NamedTuple):
    """A linkage and its motion in rational numbers; n joints, w columns.

    Attributes:
        parent: link before each joint, -1 for the ground (n,).
        screws: joint screws of any length at the reference pose; inertial frame, SI units.
        radicands: pairwise coprime numbers for each joint: relations and columns are those of
            its screw times the square root of their product. Mostly there are none.
        ends: the two links welded by each loop.
        mimics: rows of linear relations between the rates of the screws (g, n).
        dependent: joints whose rates follow from the loops.
        columns: rates of the screws of the other joints (n, w).
        links: link of each body.
        rows: components of the momentum ``[ξ; p]`` that count (3 or fewer in a plane, 6).
        parameters: parameters of a body that are counted, as combinations of the ten
            ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]``.
    """

    parent: tuple[int, ...]
    screws: tuple[Vector, ...]
    radicands: tuple[tuple[int, ...], ...]
    ends: tuple[tuple[int, int], ...]
    mimics: tuple[Vector, ...]
    dependent: tuple[int, ...]
    columns: tuple[Vector, ...]
    links: tuple[int, ...]
    rows: tuple[Vector, ...]
    parameters: tuple[Vector, ...]

    def __repr__(self) -> str:
        """One line: how many joints, loops and columns."""
        joints, loops = (
            count_noun(len(self.parent), "joint"),
            count_noun(len(self.ends), "loop"),
        )
        width = len(self.columns[0]) if self.columns else 0
        return (
            f"ExactChain: {joints}, {loops}, {count_noun(width, 'column')}, in rational numbers"
        )

    @property
    def width(self) -> int:
        """Number of columns: degrees of freedom of the motion."""
        return len(self.columns[0])

    @property
    def conductor(self) -> int:
        """Conductor of the field of its numbers, 1 if they are rational."""
        return _conductor(self.screws)


def exact_chain(
    linkage: Linkage,
    geometry: Geometry,
    motion: Motion | None = None,
    force: bool = False,
    spatial: bool = False,
) -> ExactChain:
    """Write a linkage under a motion in rational numbers; idle joints are kept.

    Args:
        linkage: the assembled linkage: structure and independent joints.
        geometry: its joint screws in rational numbers, from its file.
        motion: restriction of the inputs; free by default.
        force: whether only linear momentum counts.
        spatial: whether all ten parameters per body count, even if the linkage is planar.

    Raises:
        ExactError: the linkage is planar only up to rounding.
    """
    count = len(linkage.joints)
    moving = moving_chain(linkage, motion, spatial)
    independent = linkage.positions_of(linkage.inputs if motion is None else motion.inputs)
    # Before all else: a linkage that is planar only up to rounding has other parameters.
    if moving.planar:
        rows, parameters = _planar_rows_and_parameters(
            linkage, geometry, moving.joints, moving.frame.R[2]
        )
    else:
        rows, parameters = unit_vectors(6), unit_vectors(10)
    relations = _motion_relations(motion, independent)
    radicands = _radicands(linkage, geometry, relations)
    lengths = [
        square * prod(numbers)
        for square, numbers in zip(geometry.squares, radicands, strict=True)
    ]
    basis = _independent_columns(relations, lengths, independent)
    columns = [(Fraction(0),) * len(basis) for _ in range(count)]
    for row, joint in enumerate(independent):
        columns[joint] = tuple(vector[row] for vector in basis)
    if force:
        rows, parameters = rows[len(rows) // 3 if moving.planar else 3 :], parameters[:-1]
        parameters = parameters if moving.planar else parameters[:4]
    return ExactChain(
        parent=tuple(joint.parent for joint in linkage.joints),
        screws=geometry.screws,
        radicands=radicands,
        ends=tuple((loop.end, loop.successor) for loop in linkage.loops),
        mimics=_mimics(linkage, geometry, lengths),
        dependent=tuple(j for j in range(count) if j not in set(independent.tolist())),
        columns=tuple(columns),
        links=tuple(body.link for body in linkage.bodies),
        rows=rows,
        parameters=parameters,
    )


def unit_vectors(count: int) -> tuple[Vector, ...]:
    """Return the rows of the unit matrix."""
    return tuple(tuple(Fraction(int(i == j)) for j in range(count)) for i in range(count))


def _motion_relations(motion: Motion | None, independent: IntArray) -> list[Relation]:
    """Write the relations of a motion as coefficients of the displacements of joints."""
    rows = [] if motion is None else [row for _, row in motion.coefficients()]
    joints = independent.tolist()
    return [{j: c for j, c in zip(joints, row, strict=True) if c} for row in rows]


def _radicands(
    linkage: Linkage, geometry: Geometry, relations: Sequence[Relation]
) -> tuple[tuple[int, ...], ...]:
    """Find the square roots that make the relations between rates of screws rational.

    Ratios of lengths matter only between joints that relations join: the first joint of such a
    group needs no root.
    """
    joined = [
        [mimic.joint, mimic.source]
        for mimic, ratio in zip(linkage.mimics, geometry.ratios, strict=True)
        if ratio
    ]
    joined += [list(relation) for relation in relations]
    first = list(range(len(linkage.joints)))
    for joints in joined:
        lowest = min(first[j] for j in joints)
        groups = {first[j] for j in joints}
        first = [lowest if x in groups else x for x in first]
    ratios = [
        geometry.squares[j] * geometry.squares[k] if j != k else Fraction(1)
        for j, k in enumerate(first)
    ]
    irrational = [ratio for ratio in ratios if isinstance(ratio, FieldNumber)]
    radicands = [] if irrational else square_classes(ratios)
    field = _conductor(geometry.screws)
    if irrational or any(gcd(b, field) > 1 for numbers in radicands for b in numbers):
        raise ExactError(
            f"{linkage.source}: axes that relations join have lengths whose ratios are no "
            "roots of rational numbers; write axes of equal length"
        )
    return tuple(tuple(sorted(numbers)) for numbers in radicands)


def _conductor(screws: Sequence[Vector]) -> int:
    """Find the conductor of the field of the numbers in screws."""
    numbers = (x for screw in screws for x in screw if isinstance(x, FieldNumber))
    return next((x.conductor for x in numbers), 1)


def _ratio(lengths: Sequence[Fraction], joint: int, other: int) -> Fraction:
    """Compute the length of one screw over that of another, from the squares of both."""
    ratio = root(lengths[joint] / lengths[other])
    assert ratio is not None
    return ratio


def _independent_columns(
    relations: Sequence[Relation], lengths: Sequence[Fraction], independent: IntArray
) -> list[list[Fraction]]:
    """Compute the rates of the independent screws for each column of the motion.

    The rate of a joint is that of its screw times the length of the screw, and so are the
    coefficients of relations between rates, up to a factor.
    """
    rows = []
    for relation in relations:
        first = next(iter(relation))
        rows.append(
            [
                relation[j] * _ratio(lengths, j, first) if j in relation else Fraction(0)
                for j in independent.tolist()
            ]
        )
    return rational_null_space(rows, independent.size)


def _mimics(
    linkage: Linkage, geometry: Geometry, lengths: Sequence[Fraction]
) -> tuple[Vector, ...]:
    """Collect the relations between the rates of the screws of mimic joints."""
    rows = []
    for mimic, ratio in zip(linkage.mimics, geometry.ratios, strict=True):
        row = [Fraction(0)] * len(linkage.joints)
        row[mimic.joint] = Fraction(1)
        if ratio:
            row[mimic.source] = -ratio * _ratio(lengths, mimic.source, mimic.joint)
        rows.append(tuple(row))
    return tuple(rows)


def _planar_rows_and_parameters(
    linkage: Linkage, geometry: Geometry, joints: IntArray, normal: Array
) -> tuple[tuple[Vector, ...], tuple[Vector, ...]]:
    """Compute rows ``[ξ·n, p·a, p·b]`` and parameters ``[m, mc·a, mc·b, n·E n]`` of a plane.

    The axes a, b, n are at right angles, and of any length.
    """
    zero = (Fraction(0),) * 3
    moving = [geometry.screws[j] for j in joints]
    turning = [screw for screw in moving if any(screw[:3])]
    n = _plane_normal(turning, [s[3:] for s in moving if not any(s[:3])], normal)
    deviation = max(_out_of_plane(screw, n) for screw in moving)
    if deviation:
        raise InexactPlaneError(linkage.source, float(deviation) ** 0.5)
    nearest = max(range(3), key=lambda i: abs(n[i]))
    helper = unit_vectors(3)[(nearest + 1) % 3]
    a = tuple(x - dot(helper, n) / dot(n, n) * y for x, y in zip(helper, n, strict=True))
    b = cross(n, a)
    squares = tuple(n[i] * n[j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    unit, six = (Fraction(1), *zero), (Fraction(0),) * 6
    parameters = (
        unit + six,
        (unit[1], *a) + six,
        (unit[1], *b) + six,
        (*zero, unit[1]) + squares,
    )
    return (n + zero, zero + a, zero + b), parameters


def _out_of_plane(screw: Vector, n: Vector) -> Fraction:
    """Square of how far a screw is from a motion in the plane of normal n; relative."""
    w, v, square = screw[:3], screw[3:], dot(n, n)
    if not any(w):
        return dot(v, n) ** 2 / (dot(v, v) * square)
    off = cross(w, n)
    return dot(off, off) / (dot(w, w) * square) + dot(w, v) ** 2 / dot(w, w) ** 2


def _plane_normal(turning: Sequence[Vector], slides: Sequence[Vector], normal: Array) -> Vector:
    """Compute a normal of the plane in which screws move; ``normal`` is the rounded one."""
    if turning:
        n = turning[0][:3]
    else:
        free = rational_null_space(slides, 3)
        if not free:  # they leave the plane, by round-off at least
            return nearby_vector(normal)
        sizes = [abs(float(dot(v, v))) ** 0.5 for v in free]
        along = [abs(float(x @ normal)) for x in np.array(free, dtype=np.float64)]
        n = tuple(free[first_largest(np.array(along) / sizes)])
    largest = max(n, key=abs)
    return tuple(-x for x in n) if largest < 0 else n


def loops_are_regular(chain: ExactChain, locked: Collection[int] = ()) -> bool:
    """Decide whether loops close at all orders because their constraints are independent.

    The displacement around a loop stays in the group that its screws generate. Where the
    loop matrix has as many independent rows as all those groups have dimensions, the
    closed poses are a manifold. (Implicit function theorem; the loop matrix has as many
    independent rows as there are dependent joints.)

    If both the linkage and the same linkage with some of its joints locked are regular,
    these joints are at rest in every motion: the closed poses of the locked linkage are a
    manifold of the same dimension, within those of the whole.

    Args:
        chain: the linkage and its motion.
        locked: joints that are locked: the loop matrix of the others decides.
    """
    still = set(locked)
    constraints = sum(
        any(c and j not in still for j, c in enumerate(row)) for row in chain.mimics
    )
    for ends in chain.ends:
        around = sorted(loop_joints(chain.parent, *ends) - still)
        constraints += len(lie_algebra([chain.screws[j] for j in around]))
    return len(set(chain.dependent) - still) == constraints


def lie_algebra(screws: Sequence[Vector]) -> list[list[Fraction]]:
    """Compute a basis of the Lie algebra that screws generate, in echelon form.

    Args:
        screws: twists ``[ω; v]`` (count, 6).
    """
    basis = echelon(screws)[0]
    while len(basis) < 6:
        wider = echelon(
            basis + [list(rational_bracket(a, b)) for a, b in combinations(basis, 2)]
        )[0]
        if len(wider) == len(basis):
            break
        basis = wider
    return basis
