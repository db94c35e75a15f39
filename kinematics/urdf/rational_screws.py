"""The joint screws of a file as rational numbers, from its decimals.

Directions keep the length that they have in the file, for a unit vector is rarely rational.
What is not rational itself is replaced, and a notice says so: angles in ``rpy`` and in the
offsets of mimic joints, pitches of screws. What is within 1e-12 rad of a multiple of π/12 is
taken for it; multiples of π/2 have rational rotations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from random import Random
from typing import NamedTuple

import numpy as np

from kinematics.error_text import clean
from kinematics.errors import ExactError
from kinematics.linalg.rational import (
    BITS,
    Vector,
    cross,
    decimal,
    dot,
    nearby_fraction,
    pi,
    quarters,
    root,
    rounds_root,
    tangent,
)
from kinematics.model.full_turns import position_text
from kinematics.model.linkage import Linkage, Notice
from kinematics.urdf.loop_joints import FREEDOMS
from kinematics.urdf.rational_poses import (
    AXES,
    Matrix,
    RationalPose,
    add_vectors,
    move_screws,
    rotation,
    scale_vector,
)
from kinematics.urdf.rounded_angles import exact_angle
from kinematics.urdf_elements.element import Element
from kinematics.urdf_elements.joint_types import coordinate_names

__all__ = ["Geometry", "change_replaced_numbers", "exact_geometry"]

# Screws that differ by more, relative to the largest, are those of another pose.
SAME = 1e-12
# A direction whose squared length differs from 1 by less was rounded from a unit vector.
ROUNDED = Fraction(1, 10**4)
# By how much numbers are changed to see what rests on them: radians, and parts of a size.
CHANGE = Fraction(1, 64)


class Geometry(NamedTuple):
    """Joints of a linkage in rational numbers, at its reference pose.

    Attributes:
        screws: ``[n; r × n + λ n]``, or ``[0; n]`` if prismatic, of each joint, with n of
            any length; (6,) each, inertial frame, SI units.
        squares: squared length of each n. A rate of the screw is that of the joint over
            the length.
        ratios: of each mimic, in the units of its joint over those of its source.
        notices: what was replaced, or is a rounded root (``not_exact``); and axes whose
            length is nearly 1 (``as_written``).
    """

    screws: tuple[Vector, ...]
    squares: tuple[Fraction, ...]
    ratios: tuple[Fraction, ...]
    notices: tuple[Notice, ...]


def exact_geometry(linkage: Linkage) -> Geometry:
    """The joint screws of a linkage, from the decimals of its file.

    Where the reference pose is not that of the file, whose loops are open, joints are at
    rational positions next to those found. Loops are closed there at their predecessors, so
    the links differ from those of the file by round-off.

    Args:
        linkage: read from a file.

    Raises:
        ExactError: the linkage was not read from a file, or its axes are not those of the
            file.
    """
    source = clean(linkage.source, 1000)
    if linkage.tree is None:
        raise ExactError(
            f"{source}: exact arithmetic works from the decimals of a URDF file; load one"
        )
    found = _Reading(linkage.tree, linkage.displaced is None)
    joints = [found.joints.get(joint.name) for joint in linkage.joints]
    screws = tuple(joint[1] for joint in joints if joint)
    if linkage.displaced is not None and len(screws) == len(joints):
        screws = move_screws(linkage.joints, screws, linkage.displaced.tolist())
        found.notices += _positions(linkage)
    if len(screws) < len(joints) or not _agree(linkage, screws):
        raise ExactError(
            f"{source}: exact arithmetic needs the axes that are in the file: these were moved "
            "to close its loops; write axes that let them close"
        )
    ratios = tuple(
        found.mimics[linkage.joints[mimic.joint].name][1] for mimic in linkage.mimics
    )
    squares = tuple(dot(n, n) for n in (_direction(screw) for screw in screws))
    return Geometry(screws, squares, ratios, tuple(found.notices))


def change_replaced_numbers(linkage: Linkage) -> tuple[Vector, ...]:
    """The joint screws with other numbers for those that `exact_geometry` replaces.

    Equal numbers stay equal, and opposite ones opposite; no other relation is kept.

    Args:
        linkage: one that `exact_geometry` takes.

    Returns:
        Screws of any length (6,) each.
    """
    assert linkage.tree is not None
    length, positions = Fraction(linkage.chain.frame.length), linkage.displaced
    found = _Reading(linkage.tree, positions is None, CHANGE, length)
    screws = tuple(found.joints[joint.name][1] for joint in linkage.joints)
    if positions is None:
        return screws
    sizes = [length if joint.kind == "prismatic" else Fraction(1) for joint in linkage.joints]
    moved = [
        float(found.changed(Fraction(q), size)) if q else 0.0
        for q, size in zip(positions.tolist(), sizes, strict=True)
    ]
    return move_screws(linkage.joints, screws, moved)


def _positions(linkage: Linkage) -> Iterator[Notice]:
    """Notices of the joints whose positions at the reference pose are rounded to fractions."""
    assert linkage.displaced is not None
    how = "closed" if linkage.at is None else "placed"
    carriers = {joint.parent for joint in linkage.joints}
    for j, (joint, q) in enumerate(zip(linkage.joints, linkage.displaced, strict=True)):
        if q and j in carriers:
            text = (
                f"joint '{joint.name}': {how} by Newton's method at "
                f"{position_text(joint, q, 6)} "
                f"from the pose of the file: taken within 2^-{BITS} of it; so are link lengths"
            )
            yield Notice("not_exact", text)


def _agree(linkage: Linkage, screws: tuple[Vector, ...]) -> bool:
    """Whether the screws are those of the reference pose of the linkage."""
    known = np.array([joint.screw for joint in linkage.joints])
    found = np.array([[float(x) for x in screw] for screw in screws])
    lengths = [float(dot(n, n)) ** 0.5 for n in map(_direction, screws)]
    difference = np.abs(found / np.reshape(lengths, (-1, 1)) - known)
    return bool(difference.max() <= SAME * max(1.0, np.abs(known).max()))


def _direction(screw: Vector) -> Vector:
    """The part n of a screw."""
    return screw[:3] if any(screw[:3]) else screw[3:]


def _numbers(item: Element | None, attribute: str, default: str) -> Vector:
    text = item.attributes.get(attribute, default) if item is not None else default
    return tuple(decimal(word) for word in text.split())


def _perpendicular(n: Vector, direction: Vector | None = None) -> Vector:
    """The part of ``direction`` perpendicular to n; by default that of the next axis."""
    if direction is None or not any(cross(n, direction)):
        nearest = max(range(3), key=lambda i: abs(n[i]))
        direction = AXES[(nearest + 1) % 3]
    return add_vectors(direction, scale_vector(-dot(direction, n) / dot(n, n), n))


class _Reading:
    """Places of links and screws of joints, gathered from the tree of a file."""

    def __init__(
        self, tree: Element, closed: bool = True, change: Fraction = Fraction(0),
        length: Fraction = Fraction(1),
    ) -> None:  # fmt: skip
        """Read it; what is replaced changes by up to ``change``, in lengths by that part."""
        self.notices: list[Notice] = []
        self.closed, self.change, self.length = closed, change, length
        self.joints: dict[str, tuple[str, Vector]] = {}
        self.mimics = dict(self._mimics(tree))
        self.places = self._placed(tree)
        for loop in tree.every("loop"):
            self._loop(loop)

    def _note(self, label: str, text: str) -> None:
        self.notices.append(Notice("not_exact", f"{label}: {text}"))

    def changed(self, x: Fraction, size: Fraction | None = None) -> Fraction:
        """A number that is replaced, plus or minus up to ``change`` of a size, its own or 1."""
        if not self.change:
            return x
        part = Fraction(Random(str(abs(x))).randint(512, 1024), 1024)
        return x + self.change * part * (x if size is None else size if x > 0 else -size)

    def _mimics(self, tree: Element) -> Iterator[tuple[str, tuple[str, Fraction, Fraction]]]:
        """Source, ratio and offset of each joint that follows another."""
        for joint in tree.every("joint"):
            mimic = joint.first("mimic")
            if mimic is not None and joint.attributes["type"] != "fixed":
                ratio = decimal(mimic.attributes.get("multiplier", "1").strip())
                turning = joint.attributes["type"] != "prismatic"
                read = exact_angle if turning else decimal
                offset = read(mimic.attributes.get("offset", "0").strip())
                yield joint.name, (mimic.attributes["joint"], ratio, offset)

    def _position(self, name: str) -> Fraction:
        """Position of a joint at the pose of the file."""
        factor, total = Fraction(1), Fraction(0)
        while name in self.mimics:
            name, ratio, offset = self.mimics[name]
            total += factor * offset
            factor *= ratio
        return total

    def _placed(self, tree: Element) -> dict[str, RationalPose]:
        """Poses of all links, and the screws of the joints of the tree."""
        hanging: dict[str, list[Element]] = {}
        for joint in tree.every("joint"):
            hanging.setdefault(_side(joint, "parent"), []).append(joint)
        carried = {_side(joint, "child") for joint in tree.every("joint")}
        ready = [link.name for link in tree.every("link") if link.name not in carried]
        places = dict.fromkeys(ready, RationalPose())
        while ready:
            link = ready.pop()
            for joint in hanging.get(link, ()):
                child = _side(joint, "child")
                places[child] = self._joint(joint, places[link])
                ready.append(child)
        return places

    def _joint(self, joint: Element, pose: RationalPose) -> RationalPose:
        """Add the screws of a joint of the tree; the pose of the link after it."""
        frame = pose @ self._origin(joint.label, joint.first("origin"))
        kind = joint.attributes["type"]
        if kind == "fixed":
            return frame
        axis = self._axis(joint, joint.first("axis"))
        second = joint.first("axis2")
        across = _perpendicular(axis, _numbers(second, "xyz", "") if second else None)
        n, u = frame.turn(axis), frame.turn(across)
        pitch = self._pitch(joint)
        self._add(joint, n, u, frame.d, pitch)
        offset = self._position(joint.name)
        return self._moved(joint, frame, n, pitch, offset) if offset else frame

    def _axis(self, item: Element, axis: Element | None) -> Vector:
        n = _numbers(axis, "xyz", "1 0 0")
        off = abs(dot(n, n) - 1)
        if axis is not None and 0 < off < ROUNDED:
            code = "not_exact" if any(map(rounds_root, n)) else "as_written"
            text = "its axis is a unit vector only to its digits: as written"
            self.notices.append(Notice(code, f"{item.label}: {text}"))
            return tuple(self.changed(x) if rounds_root(x) else x for x in n)
        return n

    def _pitch(self, joint: Element) -> Fraction:
        """Metres per radian."""
        thread = joint.first("screw_thread_pitch")
        pitch = _numbers(thread, "value", "0")[0]
        if pitch:
            text = f"its pitch is not rational in metres per radian: within 2^-{BITS} of it"
            self._note(joint.label, text)
        return nearby_fraction(self.changed(pitch) / (2 * pi()))

    def _add(
        self, item: Element, n: Vector, u: Vector, point: Vector, pitch: Fraction = Fraction(0)
    ) -> None:
        """The screws of a joint or loop about n, u and ``n × u`` through a point."""
        directions: Mapping[str, Vector] = {"n": n, "u": u, "w": cross(n, u)}
        kind = item.attributes["type"]
        for name, step in zip(coordinate_names(item.name, kind), FREEDOMS[kind], strict=True):
            motion, along = step.split()
            a = directions[along]
            if motion == "turn":
                screw = a + add_vectors(cross(point, a), scale_vector(pitch, a))
            else:
                screw = (Fraction(0),) * 3 + a
            self.joints[name] = motion, screw

    def _origin(self, label: str, origin: Element | None) -> RationalPose:
        """Pose of an ``<origin>``: ``R = Rz(yaw) Ry(pitch) Rx(roll)``."""
        pose = RationalPose(AXES, _numbers(origin, "xyz", "0 0 0"))
        if origin is not None:
            words = origin.attributes.get("rpy", "0 0 0").split()
            for axis, word in zip(reversed(AXES), reversed(words), strict=True):
                pose = pose @ RationalPose(self._turn(label, axis, exact_angle(word), word))
        return pose

    def _turn(self, label: str, n: Vector, angle: Fraction, word: str = "") -> Matrix:
        """Rotation about n, whose length is rational, by an angle."""
        quarter, rest = quarters(angle)
        text = f"the angle {clean(word or str(float(angle)))}"
        if not rest:
            if angle or (word and decimal(word)):
                self._note(label, f"{text} is taken as {quarter} π/2")
            return rotation(n, Fraction(0), quarter)
        if word and angle != decimal(word):
            text += f", taken as {round(angle / (pi() / 12))} π/12,"
        self._note(label, f"{text} has no rational rotation: within 2^-{BITS} rad of it")
        half = tangent(self.changed(rest, Fraction(1)))
        return rotation(n, half / (root(dot(n, n)) or 1), quarter)

    def _moved(
        self, joint: Element, frame: RationalPose, n: Vector, pitch: Fraction, offset: Fraction
    ) -> RationalPose:
        """The frame of a joint, moved along it to its position in the file."""
        length = root(dot(n, n))
        if length is None:
            raise ExactError(
                f"{joint.label}: at {float(offset):.6g} along an axis of irrational length; "
                "write the axis as a coordinate axis, or do without the offset"
            )
        if joint.attributes["type"] == "prismatic":
            return RationalPose(frame.R, add_vectors(frame.d, scale_vector(offset / length, n)))
        turned = RationalPose(self._turn(joint.label, n, offset)) @ RationalPose(frame.R)
        return RationalPose(
            turned.R, add_vectors(frame.d, scale_vector(pitch * offset / length, n))
        )

    def _loop(self, loop: Element) -> None:
        """Add the screws of a loop."""
        before, after = (self._end(loop, role) for role in ("predecessor", "successor"))
        axis = self._axis(loop, loop.first("axis"))
        n, u = before.turn(axis), before.turn(_perpendicular(axis))
        centre, kind = before.d, loop.attributes["type"]
        gap = add_vectors(after.d, scale_vector(Fraction(-1), before.d))
        if self.closed and any(gap) and kind not in ("prismatic", "cylindrical", "planar"):
            size = float(dot(gap, gap)) ** 0.5
            self._note(loop.label, f"open by {size:.1e} m in its decimals: closed there")
            away = self.changed(Fraction(size), self.length) - Fraction(size)
            centre = add_vectors(centre, scale_vector(away / Fraction(size), gap))
        if kind == "universal":
            second = loop.first("axis2")
            given = self._axis(loop, second) if second else _perpendicular(axis)
            u = _perpendicular(n, after.turn(given))
        elif kind == "planar":
            centre = add_vectors(after.d, scale_vector(-dot(n, gap) / dot(n, n), n))
        self._add(loop, n, u, centre)

    def _end(self, loop: Element, role: str) -> RationalPose:
        side = loop.first(role) or loop
        pose = self._origin(loop.label, side.first("origin"))
        return self.places[side.attributes["link"]] @ pose


def _side(joint: Element, role: str) -> str:
    """Name of the parent or child link."""
    side = joint.first(role) or joint
    return side.attributes["link"]
