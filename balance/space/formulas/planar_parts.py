"""Rigid parts of a planar linkage with named dimensions: lengths, and points in link frames.

The frame of a part has its origin at its first revolute joint and its x-axis through the
second one, one in a loop if there is one; along its first prismatic joint if it has one;
along the x-axis of the plane if it has one joint. A part that the motion keeps from turning
has the directions of the ground. Points are complex numbers ``x + i y``. A coordinate that
vanishes in the linkage, such as the offset of an in-line slider, stays zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.formulas.notations import plain_name
from balance.space.formulas.parameters import Parameter, in_part_frame
from balance.space.formulas.rate_relations import RateRelation, rate_relations
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import FORMULA_ZERO
from kinematics.errors import ExactError
from kinematics.model.chain import rigid_parts
from kinematics.model.linkage import Joint
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import echelon

GROUND_PART = 0


class Dimension(NamedTuple):
    """A dimension of a part.

    Attributes:
        name: in formulas, such as ``l_crank``.
        kind: ``"length"`` (real), ``"offset"`` (i times a real number), or ``"point"``, a
            complex number.
        part: index of the part.
        joints: letters of the joints between which it is.
        value: in the linkage, metres; complex for points, real otherwise.
    """

    name: str
    kind: str
    part: int
    joints: str
    value: complex


@dataclass
class Part:
    """A rigid part; its frame is given at the reference pose.

    Attributes:
        name: of its first body, or of its first joint.
        bodies: indices of the bodies of the design space on it.
        joints: indices of its joints, in order.
        origin: of its frame, in the plane.
        axis: unit complex number along its x-axis.
        points: for each revolute joint, the dimension of its place, or None at the origin.
    """

    name: str
    bodies: list[int]
    joints: list[int] = field(default_factory=list)
    origin: complex = 0j
    axis: complex = 1 + 0j
    points: dict[int, int | None] = field(default_factory=dict)


class PartJoint(NamedTuple):
    """A joint between two parts.

    Attributes:
        name: in the file.
        letter: of its centre in formulas.
        slides: whether it is prismatic.
        parts: the two parts.
        place: its centre, or a point on its line, in the plane.
        direction: unit complex number along which it slides; 0 if revolute.
        signs: for each part, 1 if it slides along the x-axis of the part, -1 if against it.
        offset: the dimension of a prismatic joint, or None if it is in line.
    """

    name: str
    letter: str
    slides: bool
    parts: tuple[int, int]
    place: complex
    direction: complex
    signs: tuple[int, int] = (1, 1)
    offset: int | None = None


@dataclass(frozen=True)
class PlanarParts:
    """A planar linkage as parts, joints and dimensions.

    Attributes:
        source: file, for messages.
        parts: the ground first.
        joints: all of them.
        dimensions: all of them; none is zero in the linkage.
        body_parts: part of each body of the design space.
        mobility: degrees of freedom, without relations of inputs.
        relations: of the rates of joints, which the motion obeys; they turn about the normal
            of the plane.
        unturned: the moving parts that these relations keep from turning.
    """

    source: str
    parts: tuple[Part, ...]
    joints: tuple[PartJoint, ...]
    dimensions: tuple[Dimension, ...]
    body_parts: tuple[int, ...]
    mobility: int
    relations: tuple[RateRelation, ...] = ()
    unturned: frozenset[int] = frozenset()

    @property
    def freedoms(self) -> int:
        """Count the degrees of freedom of the motion."""
        return self.mobility - len(self.relations)

    def in_file(self, parameter: Parameter) -> NDArray[np.complexfloating]:
        """Express a parameter by ``m, mcx, mcy, Ezz`` about the inertial origin."""
        part = self.parts[self.body_parts[parameter.body]]
        return in_part_frame(parameter.kind, part.origin, part.axis)

    def loops(self) -> int:
        """Count the independent loops."""
        return len(self.joints) - len(self.parts) + 1


def letters() -> Iterator[str]:
    """Generate names of joint centres: A to Z, then A1, B1 …."""
    round_of = 0
    while True:
        for code in range(ord("A"), ord("Z") + 1):
            yield chr(code) + (str(round_of) if round_of else "")
        round_of += 1


def planar_parts(space: DesignSpace) -> PlanarParts:
    """Name the dimensions of the linkage of a design space.

    Raises:
        ExactError: the linkage is spatial, has gears or screw joints, or a part that slides
            in two directions.
    """
    chain, linkage = space.chain, space.linkage
    if not chain.planar:
        raise ExactError(f"{space.source}: formulas are of planar linkages; this is spatial")
    if len(chain.mimics):
        raise ExactError(f"{space.source}: formulas know no joint that follows another")
    part_of = rigid_parts(len(chain.parent), chain.ends).tolist()
    names = ["ground"] + [""] * max(part_of)
    parts = [Part(name, []) for name in names]
    for body, link in enumerate(chain.links.tolist()):
        parts[part_of[link]].bodies.append(body)
    axes = space.axes
    letter = letters()
    joints = []
    for k, index in enumerate(chain.joints.tolist()):
        joint = linkage.joints[index]
        if joint.kind == "helical":
            raise ExactError(f"{space.source}: joint '{joint.name}': formulas know no screws")
        slides = joint.kind == "prismatic"
        x, y = (axes[:2] @ joint.point).tolist()
        u, v = (axes[:2] @ joint.screw[3:]).tolist() if slides else (0.0, 0.0)
        ends = part_of[int(chain.parent[k])], part_of[k]
        joints.append(
            PartJoint(joint.whole, next(letter), slides, ends, complex(x, y), complex(u, v))
        )
        for part in ends:
            parts[part].joints.append(k)
    branches = _branch_joints([joint.parts for joint in joints])
    for part in parts:
        # Sides of loops are equal now and then: frames are along them.
        part.joints[1:] = sorted(part.joints[1:], key=lambda k: (k in branches, k))
    _name_parts(parts, joints, space.bodies)
    relations = [
        {
            k: c * _sign_of_turn(linkage.joints[int(chain.joints[k])], axes)
            for k, c in row.items()
        }
        for row in rate_relations(space)
    ]
    unturned = _parts_without_turn(relations, joints)
    dimensions: list[Dimension] = []
    for number, part in enumerate(parts):
        _place_frame(space.source, part, joints)
        if number in unturned:
            part.axis = parts[GROUND_PART].axis
        has_axis = number not in unturned
        dimensions += _point_dimensions(number, part, joints, len(dimensions), has_axis)
    for k, joint in enumerate(joints):
        if joint.slides:
            joints[k] = _with_offset(joint, parts, dimensions)
    return PlanarParts(
        space.source,
        tuple(parts),
        tuple(joints),
        tuple(dimensions),
        tuple(part_of[link] for link in chain.links.tolist()),
        chain.columns.shape[1] + len(relations),
        tuple(relations),
        unturned,
    )


def _sign_of_turn(joint: Joint, axes: Array) -> int:
    """Return -1 if a joint turns against the normal of the plane."""
    return -1 if joint.kind == "revolute" and joint.direction @ axes[2] < 0.0 else 1


def _branch_joints(ends: Sequence[tuple[int, int]]) -> set[int]:
    """Find the joints that are in no loop: without one of them, two parts are not connected."""
    branches = set()
    for k in range(len(ends)):
        reached, waiting = {ends[k][0]}, [ends[k][0]]
        while waiting:
            part = waiting.pop()
            for j, pair in enumerate(ends):
                other = sum(pair) - part
                if j != k and part in pair and other not in reached:
                    reached.add(other)
                    waiting.append(other)
        if ends[k][1] not in reached:
            branches.add(k)
    return branches


def _name_parts(
    parts: Sequence[Part], joints: Sequence[PartJoint], bodies: Sequence[str]
) -> None:
    """Name the moving parts by their first bodies, or joints, without odd characters."""
    used = {parts[GROUND_PART].name}
    for part in parts[1:]:
        word = bodies[part.bodies[0]] if part.bodies else f"link_{joints[part.joints[0]].name}"
        name, number = plain_name(word), 2
        while name in used:
            name, number = f"{plain_name(word)}_{number}", number + 1
        used.add(name)
        part.name = name


def _place_frame(source: str, part: Part, joints: Sequence[PartJoint]) -> None:
    """Place the frame of a part."""
    turning = [joints[k].place for k in part.joints if not joints[k].slides]
    sliding = [joints[k] for k in part.joints if joints[k].slides]
    part.origin = turning[0] if turning else sliding[0].place
    if sliding:
        part.axis = sliding[0].direction
        for joint in sliding[1:]:
            if abs((joint.direction / part.axis).imag) > FORMULA_ZERO:
                raise ExactError(
                    f"{source}: link '{part.name}' slides in two directions: formulas know one"
                )
        return
    size = max((abs(z - part.origin) for z in turning), default=0.0)
    apart = [z - part.origin for z in turning if abs(z - part.origin) > FORMULA_ZERO * size]
    part.axis = apart[0] / abs(apart[0]) if apart else 1 + 0j


def _point_dimensions(
    number: int, part: Part, joints: Sequence[PartJoint], start: int, has_axis: bool
) -> list[Dimension]:
    """Name the places of the revolute joints of a part in its frame.

    Args:
        number: of the part.
        part: the part.
        joints: of the linkage.
        start: number of dimensions before.
        has_axis: whether the x-axis is that of the part itself, through one of its joints.
    """
    turning = [k for k in part.joints if not joints[k].slides]
    dimensions: list[Dimension] = []
    places: dict[int, complex] = {
        k: (joints[k].place - part.origin) / part.axis for k in turning
    }
    size = max((abs(z) for z in places.values()), default=0.0)
    further = [k for k in turning if abs(places[k]) > FORMULA_ZERO * size]
    has_axis = has_axis and not any(joints[k].slides for k in part.joints)
    first = next(iter(further), None) if has_axis else None
    origin = joints[turning[0]].letter if turning else ""
    several = sum(k != first for k in further) > 1
    for k in turning:
        if k not in further:
            part.points[k] = None
            continue
        z = places[k]
        twin = next(
            (
                j
                for j in further
                if j in part.points and abs(places[j] - z) <= FORMULA_ZERO * size
            ),
            None,
        )
        if twin is not None:
            part.points[k] = part.points[twin]
            continue
        end = f"{part.name}_{joints[k].letter}" if several and k != first else part.name
        if k == first:
            name, kind, value = f"l_{part.name}", "length", complex(z.real)
        elif abs(z.imag) <= FORMULA_ZERO * size:
            name, kind, value = f"x_{end}", "length", complex(z.real)
        elif abs(z.real) <= FORMULA_ZERO * size:
            name, kind, value = f"y_{end}", "offset", complex(z.imag)
        else:
            name, kind, value = f"z_{end}", "point", z
        part.points[k] = start + len(dimensions)
        dimensions.append(Dimension(name, kind, number, f"{origin}{joints[k].letter}", value))
    return dimensions


def _with_offset(
    joint: PartJoint, parts: Sequence[Part], dimensions: list[Dimension]
) -> PartJoint:
    """Find the offset of a prismatic joint: between the origins of its parts, across it."""
    first, second = (parts[part] for part in joint.parts)
    signs = tuple(
        1 if (joint.direction / part.axis).real > 0 else -1 for part in (first, second)
    )
    across = ((second.origin - first.origin) / first.axis).imag
    size = max([abs(each.value) for each in dimensions], default=1.0)
    offset = None
    if abs(across) > FORMULA_ZERO * size:
        offset = len(dimensions)
        dimensions.append(
            Dimension(
                f"h_{plain_name(joint.name)}",
                "offset",
                joint.parts[0],
                joint.letter,
                complex(across),
            )
        )
    return joint._replace(signs=(signs[0], signs[1]), offset=offset)


def _parts_without_turn(
    relations: Sequence[RateRelation], joints: Sequence[PartJoint]
) -> frozenset[int]:
    """Find the moving parts that relations keep from turning; those that slide do not count.

    Args:
        relations: of the rates of the joints, about the normal of the plane.
        joints: of the linkage; part 0 is the ground.
    """
    count = 1 + max((max(joint.parts) for joint in joints), default=0)
    rows = []
    for relation in relations:
        row = [Fraction(0)] * count
        for k, c in relation.items():
            if not joints[k].slides:
                base, part = joints[k].parts
                row[part] += c
                row[base] -= c
        rows.append(row[1:])
    sliding = {part for joint in joints if joint.slides for part in joint.parts}
    solved, _ = echelon(rows) if rows else ([], [])
    still = {
        next(k for k, c in enumerate(row, start=1) if c)
        for row in solved
        if sum(c != 0 for c in row) == 1
    }
    return frozenset(still - sliding)
