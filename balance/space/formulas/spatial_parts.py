"""Rigid parts of a spatial linkage with named dimensions: normals, twists, and offsets.

The frame of a part has its z-axis along its first joint, and its x-axis along the common normal
of its first joint and its second one, whose foot is the origin (J. Denavit, R. S. Hartenberg,
1955). Axes are directed so that sines of twists are positive. What vanishes in the linkage,
such as the distance of axes that meet, stays zero; so do right angles.

A spherical joint is a point: its normal to an axis is its distance from it, without a twist.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from balance.space.formulas.common_normals import (
    PlacedAxis,
    normal_between,
    unit_vector_across,
)
from balance.space.formulas.notations import plain_name
from balance.space.formulas.parameters import Parameter
from balance.space.formulas.planar_parts import Dimension, letters
from balance.space.formulas.rate_relations import RateRelation, rate_relations
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import FORMULA_ZERO
from kinematics.errors import ExactError
from kinematics.model.chain import rigid_parts
from kinematics.numerics.array_types import Array


class AxisPlace(NamedTuple):
    """Where the axis of a joint is in the frame of a part: ``Rz(turn) Tz Tx Rx(twist)``.

    Attributes:
        turn: dimension of the angle of the normal about z; None for 0.
        along: dimension of the foot of the normal along z; None for 0.
        normal: dimension of its length; None for 0.
        twist: dimension of the angle between the axes; None for a right angle or none.
        perpendicular: whether that angle is a right one.
    """

    turn: int | None = None
    along: int | None = None
    normal: int | None = None
    twist: int | None = None
    perpendicular: bool = False


class SpatialJoint(NamedTuple):
    """A joint, from the part nearer to the ground to the other one.

    Attributes:
        name: in the file.
        letter: in formulas.
        kind: ``"revolute"``, ``"prismatic"`` or ``"spherical"``.
        parts: the two parts; the last one of a loop leads back to the ground.
        place: a point of it in the inertial frame (3,), for drawing.
        constant: dimension between the frames of the two parts that does not change: offset
            of a revolute joint, angle of a prismatic one; None for 0.
    """

    name: str
    letter: str
    kind: str
    parts: tuple[int, int]
    place: Array
    constant: int | None = None


@dataclass
class SpatialPart:
    """A rigid part; its frame is given at the reference pose.

    Attributes:
        name: of its first body, or of its first joint.
        bodies: indices of the bodies of the design space on it.
        first: joint that carries it; -1 for the ground.
        further: its other joints, in order.
        origin: of its frame (3,).
        axes: of its frame, in rows (3, 3).
        places: of its further joints.
    """

    name: str
    bodies: list[int]
    first: int = -1
    further: list[int] = field(default_factory=list)
    origin: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))
    places: dict[int, AxisPlace] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class SpatialParts:
    """A spatial linkage as parts, joints and dimensions: an open chain, or one loop.

    Attributes:
        source: file, for messages.
        parts: the ground first, each after the part that carries it.
        joints: each carries a part; in a loop the last one leads back to the ground.
        dimensions: all of them; none is zero in the linkage. Those of the ground are left out.
        body_parts: part of each body of the design space.
        freedoms: degrees of freedom of the motion.
        closed: whether it is a loop.
        relations: of the rates of joints, by their numbers; the motion obeys them.
    """

    source: str
    parts: tuple[SpatialPart, ...]
    joints: tuple[SpatialJoint, ...]
    dimensions: tuple[Dimension, ...]
    body_parts: tuple[int, ...]
    freedoms: int
    closed: bool
    relations: tuple[RateRelation, ...] = ()

    def normal_ends(self, number: int, k: int) -> tuple[Array, Array]:
        """Compute the feet of a normal on the first axis of a part, and on a further one."""
        part = self.parts[number]
        place = part.places[k]
        angle, along, length = (
            0.0 if index is None else self.dimensions[index].value.real
            for index in (place.turn, place.along, place.normal)
        )
        x, y, z = part.axes
        foot = part.origin + along * z
        return foot, foot + length * (np.cos(angle) * x + np.sin(angle) * y)

    def in_file(self, parameter: Parameter) -> Array:
        """Express a parameter by ``m, mcx, mcy, mcz, Exx … Eyz`` about the inertial origin."""
        part = self.parts[self.body_parts[parameter.body]]
        o, kind = part.origin, parameter.kind
        row = np.zeros(10)
        if kind == "m":
            row[0] = 1.0
        elif kind[0] == "s":
            axis = part.axes["xyz".index(kind[1])]
            row[0], row[1:4] = -axis @ o, axis
        else:
            u, v = (part.axes["xyz".index(letter)] for letter in kind[1:])
            # E about the frame: E - (2 o·mc 1 - o mcᵀ - mc oᵀ) + m (o·o 1 - o oᵀ).
            row[0] = (o @ o) * (u @ v) - (o @ u) * (o @ v)
            row[1:4] = -2 * o * (u @ v) + (o @ u) * v + (o @ v) * u
            row[4:7] = u * v
            for k, (i, j) in enumerate(((0, 1), (0, 2), (1, 2)), 7):
                row[k] = u[i] * v[j] + u[j] * v[i]
        return row


def spatial_parts(space: DesignSpace) -> SpatialParts:
    """Name the dimensions of the linkage of a design space.

    Raises:
        ExactError: it has screw joints, joints that follow others, several loops, or a loop
            with branches or away from the ground.
    """
    chain, linkage = space.chain, space.linkage
    if len(chain.mimics):
        raise ExactError(f"{space.source}: formulas know no joint that follows another")
    part_of = rigid_parts(len(chain.parent), chain.ends).tolist()
    axes = []
    for k, index in enumerate(chain.joints.tolist()):
        joint = linkage.joints[index]
        if joint.kind == "helical":
            raise ExactError(f"{space.source}: joint '{joint.name}': formulas know no screws")
        ends = part_of[int(chain.parent[k])], part_of[k]
        axes.append(
            PlacedAxis(joint.whole, joint.kind, joint.point, joint.direction, ends, (k,))
        )
    bodies: dict[int, list[int]] = {}
    for body, link in enumerate(chain.links.tolist()):
        bodies.setdefault(part_of[link], []).append(body)
    axes = _join_spherical(axes, set(bodies))
    order, joints, closed = _order_parts(space.source, axes)
    builder = _Builder(space, [axes[k] for k in joints], order, bodies, closed)
    return SpatialParts(
        space.source,
        tuple(builder.parts),
        tuple(builder.joints),
        tuple(builder.dimensions),
        tuple(order.index(part_of[link]) for link in chain.links.tolist()),
        chain.columns.shape[1],
        closed,
        tuple(_relations(space, [axes[k] for k in joints], builder, order)),
    )


def _relations(
    space: DesignSpace, axes: Sequence[PlacedAxis], builder: _Builder, order: Sequence[int]
) -> Iterator[RateRelation]:
    """Write relations of inputs on joints as they are numbered and directed here."""
    for row in rate_relations(space):
        relation = {}
        for number, c in row.items():
            joint = space.linkage.joints[int(space.chain.joints[number])]
            k = next((k for k, axis in enumerate(axes) if number in axis.joints), None)
            if k is None or len(axes[k].joints) > 1:
                raise ExactError(
                    f"{space.source}: motion: '{joint.name}' is part of a spherical joint, "
                    "whose rates formulas do not relate"
                )
            forwards = order.index(axes[k].ends[1]) == builder.joints[k].parts[1]
            along = float(axes[k].direction @ joint.direction) > 0.0
            relation[k] = c if forwards == along else -c
        yield relation


def _join_spherical(axes: list[PlacedAxis], massive: set[int]) -> list[PlacedAxis]:
    """Replace three axes through one point, with nothing on the parts between, by a point."""
    axes = list(axes)
    for middle in list(axes):
        neighbours = [
            [axis for axis in axes if axis is not middle and part in axis.ends]
            for part in middle.ends
        ]
        if not all(
            part and part not in massive and len(near) == 1
            for part, near in zip(middle.ends, neighbours, strict=True)
        ):
            continue
        three = [neighbours[0][0], middle, neighbours[1][0]]
        if three[0] is three[2] or any(axis.kind != "revolute" for axis in three):
            continue
        directions = np.array([axis.direction for axis in three])
        if abs(np.linalg.det(directions)) <= FORMULA_ZERO:
            continue
        sides = [np.eye(3) - np.outer(n, n) for n in directions]
        pulls = [side @ axis.point for side, axis in zip(sides, three, strict=True)]
        centre: Array = np.linalg.solve(np.sum(sides, axis=0), np.sum(pulls, axis=0)) * 1.0
        size = max(1.0, float(np.abs(centre).max()))
        misses = [side @ (centre - a.point) for side, a in zip(sides, three, strict=True)]
        if np.abs(misses).max() > FORMULA_ZERO * size:
            continue
        outer = [sum(three[i].ends) - middle.ends[i // 2] for i in (0, 2)]
        numbers = tuple(number for axis in three for number in axis.joints)
        whole = PlacedAxis(
            middle.name, "spherical", centre, directions[0], (outer[0], outer[1]), numbers
        )
        place = min(axes.index(axis) for axis in three)
        axes = [axis for axis in axes if axis not in three]
        axes.insert(place, whole)
    return axes


def _order_parts(source: str, axes: Sequence[PlacedAxis]) -> tuple[list[int], list[int], bool]:
    """Order parts and joints from the ground on: a tree, or once around a loop."""
    parts = sorted({0, *(part for axis in axes for part in axis.ends)})
    loops = len(axes) - len(parts) + 1
    if loops > 1:
        raise ExactError(
            f"{source}: it has {loops} loops: formulas of spatial linkages are of open chains "
            "and single loops"
        )
    if loops and any(sum(part in axis.ends for axis in axes) != 2 for part in parts):
        raise ExactError(
            f"{source}: formulas of a spatial loop need two joints on each link, the ground too"
        )
    order, joints = [0], []
    waiting = [0]
    while waiting:
        part = waiting.pop(0)
        for k, axis in enumerate(axes):
            if part in axis.ends and k not in joints:
                joints.append(k)
                other = sum(axis.ends) - part
                if other not in order:
                    order.append(other)
                    waiting.append(other)
                if loops:
                    waiting = [other]
                    break
    return order, joints, bool(loops)


class _Builder:
    """Places the frames of parts, and names their dimensions."""

    def __init__(
        self,
        space: DesignSpace,
        axes: list[PlacedAxis],
        order: list[int],
        bodies: dict[int, list[int]],
        closed: bool,
    ) -> None:
        self.axes, self.size, self.dimensions = axes, space.length, list[Dimension]()
        self.parts = [SpatialPart("ground", [])]
        letter = letters()
        self.joints: list[SpatialJoint] = []
        for k, axis in enumerate(axes):
            ends = order.index(axis.ends[0]), order.index(axis.ends[1])
            back = closed and k == len(axes) - 1
            base, part = (max(ends), 0) if back else (min(ends), max(ends))
            self.joints.append(
                SpatialJoint(axis.name, next(letter), axis.kind, (base, part), axis.point)
            )
        used = {"ground"}
        for number, label in enumerate(order[1:], 1):
            first = next(k for k, joint in enumerate(self.joints) if joint.parts[1] == number)
            members = bodies.get(label, [])
            word = plain_name(
                space.bodies[members[0]] if members else f"link_{axes[first].name}"
            )
            name, count = word, 2
            while name in used:
                name, count = f"{word}_{count}", count + 1
            used.add(name)
            further = [k for k, j in enumerate(self.joints) if j.parts[0] == number]
            self.parts.append(SpatialPart(name, members, first, further))
        self._direct_axes()
        self._place_frames(space.source)
        for number in range(1, len(self.parts)):
            self._name_dimensions(number)
        for k in range(len(self.joints)):
            self._name_constant(k)

    def _direct_axes(self) -> None:
        """Direct axes, from the ground on, so that sines of twists are positive."""
        for part in self.parts[1:]:
            first = self.axes[part.first]
            for k in part.further:
                axis = self.axes[k]
                if first.kind == "spherical":
                    continue
                _, normal, length, sine = normal_between(first, axis, self.size)
                if sine == 0.0:
                    sign = float(first.direction @ axis.direction)
                elif length == 0.0:
                    continue
                else:
                    sign = float(np.cross(first.direction, axis.direction) @ normal)
                if axis.kind != "spherical" and sign < 0.0:
                    axis.direction = -axis.direction

    def _place_frames(self, source: str) -> None:
        feet: list[Array | None] = [None] * len(self.parts)
        normals: list[Array | None] = [None] * len(self.parts)
        z: list[Array] = [np.array([0.0, 0.0, 1.0])]
        for number, part in enumerate(self.parts[1:], 1):
            first = self.axes[part.first]
            second = self.axes[part.further[0]] if part.further else None
            direction = first.direction
            if first.kind == "spherical":
                feet[number] = first.point
                if len(part.further) > 1:
                    raise ExactError(
                        f"{source}: link '{part.name}' branches after the spherical joint "
                        f"'{first.name}': formulas do not cover this"
                    )
                if second is not None:
                    direction = second.direction
                    if second.kind == "spherical":
                        direction = unit_vector_across(second.point - first.point)
            if second is not None:
                foot, normal, _, _ = normal_between(first, second, self.size)
                feet[number] = foot if foot is not None else feet[number]
                normals[number] = normal if normal.any() else None
            z.append(direction)
        for number in range(len(self.parts) - 1, 0, -1):
            part = self.parts[number]
            if not part.further:
                continue
            child = self.joints[part.further[0]].parts[1]
            if not child:
                continue
            foot, line = feet[child], self.axes[part.first]
            if feet[number] is None and foot is not None:
                feet[number] = line.point + z[number] * (z[number] @ (foot - line.point))
            if normals[number] is None and normals[child] is not None:
                normals[number] = normals[child]
        for number, part in enumerate(self.parts[1:], 1):
            base = self.parts[self.joints[part.first].parts[0]]
            line = self.axes[part.first]
            foot = feet[number]
            if foot is None:
                near = self._foot(base, part.first) if base.first >= 0 else line.point
                foot = line.point + z[number] * (z[number] @ (near - line.point))
            candidates = [normals[number], base.axes[0], base.axes[1], np.eye(3)[0]]
            x = next(
                side
                for each in candidates
                if each is not None
                and np.linalg.norm(side := each - z[number] * (z[number] @ each)) > 0.5
                or each is normals[number]
                and each is not None
                and np.linalg.norm(side := each - z[number] * (z[number] @ each)) > FORMULA_ZERO
            )
            x = x / np.linalg.norm(x)
            part.origin, part.axes = foot, np.array([x, np.cross(z[number], x), z[number]])

    def _foot(self, part: SpatialPart, k: int) -> Array:
        """Find the foot of the normal of a part on a further joint."""
        first, axis = self.axes[part.first], self.axes[k]
        if axis.kind == "spherical":
            return axis.point
        foot, normal, length, _ = normal_between(first, axis, self.size)
        if foot is None or first.kind == "spherical":
            foot = part.origin
        return foot + normal * length

    def _add(self, name: str, kind: str, number: int, joints: str, value: float) -> int | None:
        """Name a dimension; None for 0."""
        small = FORMULA_ZERO * (1.0 if kind == "angle" else self.size)
        if abs(value) <= small:
            return None
        used, word, count = {each.name for each in self.dimensions}, name, 2
        while name in used:
            name, count = f"{word}_{count}", count + 1
        self.dimensions.append(Dimension(name, kind, number, joints, complex(value)))
        return len(self.dimensions) - 1

    def _name_dimensions(self, number: int) -> None:
        part = self.parts[number]
        first = self.axes[part.first]
        x, y, z = part.axes
        for k in part.further:
            axis, letter = self.axes[k], self.joints[k].letter
            ends = self.joints[part.first].letter + letter
            name = part.name if len(part.further) == 1 else f"{part.name}_{letter}"
            foot, normal, length, sine = normal_between(first, axis, self.size)
            if foot is None or (first.kind == "spherical" and axis.kind != "spherical"):
                foot = part.origin
            along = turn = None
            if k != part.further[0]:
                along = self._add(
                    f"h_{name}", "axial", number, ends, float(z @ (foot - part.origin))
                )
                if normal.any():
                    angle = float(np.arctan2(normal @ y, normal @ x))
                    turn = self._add(f"{name}_turn", "angle", number, ends, angle)
            reach = self._add(f"l_{name}", "length", number, ends, length)
            cosine = float(z @ axis.direction) if sine else 1.0
            twist, right = None, bool(sine) and abs(cosine) <= FORMULA_ZERO
            if sine and not right:
                twist = self._add(name, "angle", number, ends, float(np.arctan2(sine, cosine)))
            part.places[k] = AxisPlace(turn, along, reach, twist, right)

    def _name_constant(self, k: int) -> None:
        """Name what does not change between the frames of the parts of a joint."""
        joint = self.joints[k]
        base, part = self.parts[joint.parts[0]], self.parts[joint.parts[1]]
        if joint.kind == "spherical" or not all(joint.parts):
            return
        word = plain_name(joint.name)
        if joint.kind == "revolute":
            value = float(part.axes[2] @ (part.origin - self._foot(base, k)))
            index = self._add(f"h_{word}", "axial", joint.parts[0], joint.letter, value)
        else:
            x, y, _ = part.axes
            normal = self._axis_x(base, k)
            # The angle from the normal of the base to that of the part, about the axis.
            angle = float(np.arctan2(-(normal @ y), normal @ x))
            index = self._add(f"{word}", "angle", joint.parts[0], joint.letter, angle)
        self.joints[k] = joint._replace(constant=index)

    def _axis_x(self, part: SpatialPart, k: int) -> Array:
        """Return the normal of a part to a further joint; where there is none, its x-axis."""
        normal = normal_between(self.axes[part.first], self.axes[k], self.size)[1]
        return normal if normal.any() else part.axes[0]
