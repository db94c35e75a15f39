"""Joints of a URDF tree in rational numbers: poses of links, screws of joints and loops.

Irrational numbers are replaced, and a notice names each: angles in ``rpy`` and in the offsets
of mimic joints, pitches of screws. An angle within 1e-12 rad of a multiple of π/12 is replaced
by that multiple; multiples of π/2 have rational rotations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from random import Random

from kinematics.error_text import clean
from kinematics.errors import ExactError
from kinematics.files.urdf.loop_joints import FREEDOMS
from kinematics.files.urdf.nominal_angles import exact_angle
from kinematics.files.urdf.rational_poses import (
    AXES,
    Matrix,
    RationalPose,
    rotation,
)
from kinematics.files.urdf.read_roots import FileRoots
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import coordinate_names
from kinematics.model.linkage import Notice
from kinematics.numerics.linalg.rational import (
    BITS,
    Vector,
    add_vectors,
    cross,
    decimal,
    dot,
    nearby_fraction,
    part_across,
    pi,
    quarters,
    root,
    rounds_root,
    tangent,
)
from kinematics.numerics.tolerances import UNIT_AXIS_SQUARED_LENGTH
from kinematics.wording import size_text


def _perpendicular(n: Vector, direction: Vector | None = None) -> Vector:
    """Compute the part of a direction perpendicular to n; by default that of the next axis."""
    if direction is None or not any(cross(n, direction)):
        nearest = max(range(3), key=lambda i: abs(n[i]))
        direction = AXES[(nearest + 1) % 3]
    return part_across(direction, n)


class RationalJoints:
    """Screws of joints and loops, and mimic relations, of a URDF tree in rational numbers.

    Attributes:
        joints: motion (``"turn"`` or ``"slide"``) and screw (6,) of each coordinate, in the
            inertial frame at the pose of the file, SI units; the axis has any length.
        mimics: source, ratio and offset of each mimic joint.
        poses: pose of each link.
        notices: replaced numbers.
    """

    def __init__(
        self,
        tree: Element,
        closed: bool = True,
        change: Fraction = Fraction(0),
        length: Fraction = Fraction(1),
        roots: FileRoots | None = None,
    ) -> None:
        """Read a tree.

        Args:
            tree: the tree of a file that the checks accepted.
            closed: whether the loops of the file close at its own pose.
            change: largest change of replaced numbers: radians, and parts of a length.
            length: unit of changed lengths, metres.
            roots: numbers that are read as roots, sines and cosines.
        """
        self.notices: list[Notice] = [] if roots is None else list(roots.notices)
        self.roots = roots
        self.closed, self.change, self.length = closed, change, length
        self.joints: dict[str, tuple[str, Vector]] = {}
        self.mimics = dict(self._mimics(tree))
        self.poses = self._place_links(tree)
        for loop in tree.every("loop"):
            self._add_loop(loop)

    def _numbers(self, item: Element | None, attribute: str, default: str) -> Vector:
        """Read the decimals of an attribute, or the roots that they stand for."""
        text = item.attributes.get(attribute, default) if item is not None else default
        if self.roots is not None:
            return self.roots.vector(item, attribute, text.split())
        return tuple(decimal(word) for word in text.split())

    def _note(self, label: str, text: str, code: str = "not_exact") -> None:
        """Add a notice of a replaced number."""
        self.notices.append(Notice(code, f"{label}: {text}"))

    def change_number(self, x: Fraction, size: Fraction | None = None) -> Fraction:
        """Change a replaced number by up to ``change`` of a size, with the sign of the number.

        Args:
            size: unit of the change; the number itself by default.
        """
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

    def _place_links(self, tree: Element) -> dict[str, RationalPose]:
        """Compute the poses of all links, and add the screws of the joints of the tree."""
        hanging: dict[str, list[Element]] = {}
        for joint in tree.every("joint"):
            hanging.setdefault(joint.link_at("parent"), []).append(joint)
        carried = {joint.link_at("child") for joint in tree.every("joint")}
        ready = [link.name for link in tree.every("link") if link.name not in carried]
        poses = dict.fromkeys(ready, RationalPose())
        while ready:
            link = ready.pop()
            for joint in hanging.get(link, ()):
                child = joint.link_at("child")
                poses[child] = self._add_joint(joint, poses[link])
                ready.append(child)
        return poses

    def _add_joint(self, joint: Element, pose: RationalPose) -> RationalPose:
        """Add the screws of a joint of the tree, and return the pose of the link after it."""
        frame = pose @ self.origin_pose(joint.label, joint.first("origin"))
        kind = joint.attributes["type"]
        if kind == "fixed":
            return frame
        axis = self._axis(joint, joint.first("axis"))
        second = joint.first("axis2")
        across = _perpendicular(axis, self._numbers(second, "xyz", "") if second else None)
        n, u = frame.turn(axis), frame.turn(across)
        pitch = self._pitch(joint)
        self._add_screws(joint, n, u, frame.d, pitch)
        offset = self._position(joint.name)
        return self._move_frame(joint, frame, n, pitch, offset) if offset else frame

    def _axis(self, item: Element, axis: Element | None) -> Vector:
        """Read the direction of an axis, with the length that it has in the file."""
        n = self._numbers(axis, "xyz", "1 0 0")
        off = abs(dot(n, n) - 1)
        if self.roots is not None:
            return n
        if axis is not None and 0 < off < UNIT_AXIS_SQUARED_LENGTH:
            code = "not_exact" if any(map(rounds_root, n)) else "as_written"
            text = "its axis is a unit vector only to its digits: as written"
            self.notices.append(Notice(code, f"{item.label}: {text}"))
            return tuple(self.change_number(x) if rounds_root(x) else x for x in n)
        return n

    def _pitch(self, joint: Element) -> Fraction:
        """Read the pitch of a screw joint, metres per radian."""
        thread = joint.first("screw_thread_pitch")
        pitch = self._numbers(thread, "value", "0")[0]
        if pitch:
            text = f"its pitch is not rational in metres per radian: within 2^-{BITS} of it"
            self._note(joint.label, text)
        return nearby_fraction(self.change_number(pitch) / (2 * pi()))

    def _add_screws(
        self, item: Element, n: Vector, u: Vector, point: Vector, pitch: Fraction = Fraction(0)
    ) -> None:
        """Add the screws of a joint or loop about n, u and ``n × u`` through a point."""
        directions: Mapping[str, Vector] = {"n": n, "u": u, "w": cross(n, u)}
        kind = item.attributes["type"]
        for name, step in zip(coordinate_names(item.name, kind), FREEDOMS[kind], strict=True):
            motion, along = step.split()
            a = directions[along]
            if motion == "turn":
                screw = a + add_vectors(cross(point, a), a, pitch)
            else:
                screw = (Fraction(0),) * 3 + a
            self.joints[name] = motion, screw

    def origin_pose(self, label: str, origin: Element | None) -> RationalPose:
        """Compute the pose of an ``<origin>``: ``R = Rz(yaw) Ry(pitch) Rx(roll)``.

        Args:
            label: of its element, in notices.
            origin: the checked element; the identity without one.
        """
        pose = RationalPose(AXES, self._numbers(origin, "xyz", "0 0 0"))
        if origin is not None:
            words = origin.attributes.get("rpy", "0 0 0").split()
            for axis, word in zip(reversed(AXES), reversed(words), strict=True):
                if not word.strip("+-0."):  # a zero, as most files have it: no turn
                    continue
                pose = pose @ RationalPose(self._turn(label, axis, exact_angle(word), word))
        return pose

    def _turn(self, label: str, n: Vector, angle: Fraction, word: str = "") -> Matrix:
        """Rotation about n, whose length is rational, by an angle."""
        exact = None if self.roots is None else self.roots.half_angle(float(angle))
        if exact is not None and dot(n, n) == 1:
            return rotation(n, exact[1], exact[0])
        quarter, rest = quarters(angle)
        text = f"the angle {clean(word or str(float(angle)))}"
        if not rest:
            if angle or (word and decimal(word)):
                self._note(label, f"{text} is taken as {quarter} π/2")
            return rotation(n, Fraction(0), quarter)
        if word and angle != decimal(word):
            text += f", taken as {round(angle / (pi() / 12))} π/12,"
        self._note(label, f"{text} has no rational rotation: within 2^-{BITS} rad of it")
        half = tangent(self.change_number(rest, Fraction(1)))
        return rotation(n, half / (root(dot(n, n)) or 1), quarter)

    def _move_frame(
        self, joint: Element, frame: RationalPose, n: Vector, pitch: Fraction, offset: Fraction
    ) -> RationalPose:
        """Move the frame of a joint along it to its position in the file."""
        length = root(dot(n, n))
        if length is None:
            raise ExactError(
                f"{joint.label}: at {float(offset):.6g} along an axis of irrational length; "
                "write the axis as a coordinate axis, or do without the offset"
            )
        if joint.attributes["type"] == "prismatic":
            return RationalPose(frame.R, add_vectors(frame.d, n, offset / length))
        turned = RationalPose(self._turn(joint.label, n, offset)) @ RationalPose(frame.R)
        return RationalPose(turned.R, add_vectors(frame.d, n, pitch * offset / length))

    def _add_loop(self, loop: Element) -> None:
        """Add the screws of a loop."""
        before, after = (self._end(loop, role) for role in ("predecessor", "successor"))
        axis = self._axis(loop, loop.first("axis"))
        n, u = before.turn(axis), before.turn(_perpendicular(axis))
        centre, kind = before.d, loop.attributes["type"]
        gap = add_vectors(after.d, before.d, -1)
        if self.closed and any(gap) and kind not in ("prismatic", "cylindrical", "planar"):
            # No double holds the square of a gap below 1e-162 m.
            size = Fraction(float(dot(gap, gap)) ** 0.5) or max(map(abs, gap))
            text = f"open by {size_text(float(size))} m in its decimals: closed there"
            self._note(loop.label, text, "open_in_decimals")
            away = self.change_number(size, self.length) - size
            centre = add_vectors(centre, gap, away / size)
        if kind == "universal":
            second = loop.first("axis2")
            given = self._axis(loop, second) if second else _perpendicular(axis)
            u = _perpendicular(n, after.turn(given))
        elif kind == "planar":
            centre = add_vectors(after.d, n, -dot(n, gap) / dot(n, n))
        self._add_screws(loop, n, u, centre)

    def _end(self, loop: Element, role: str) -> RationalPose:
        """Compute the pose of the frame of a loop on one of its links."""
        side = loop.first(role) or loop
        pose = self.origin_pose(loop.label, side.first("origin"))
        return self.poses[side.attributes["link"]] @ pose
