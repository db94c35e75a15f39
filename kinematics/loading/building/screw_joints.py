"""Build linkages from joint screws: axes and points in the inertial frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kinematics.error_text import clean, closest_names
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.loading.building.assemble_elements import assemble_elements, faults_of
from kinematics.loading.building.check_arguments import (
    BodyLike,
    bodies_by_link,
    checked_array,
    checked_direction,
    checked_name,
    exact_differences,
    find_by_name,
    links_and_joints,
)
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.screws import twist_axis
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import AXES_PERPENDICULAR_COSINE, ROTATION_PITCH

# Types of the file, and screw joints.
KINDS = (*DEGREES_OF_FREEDOM, "helical")


class ScrewJoint(NamedTuple):
    """A joint between two links, in the inertial frame at the reference pose.

    Attributes:
        name: name of the joint, unique among joints and loops.
        parent: name of the link that carries it; of a loop, its predecessor.
        child: name of the link that it carries; of a loop, its successor.
        axis: direction of the axis (3,), of any length; z if neither it nor ``screw`` is
            given. The normal of a planar joint, the first axis of a universal one.
        point: a point of the axis (3,), metres; the centre of a spherical or universal joint.
        kind: ``revolute``, ``prismatic``, ``helical``, ``universal``, ``cylindrical``,
            ``planar``, ``spherical``, ``floating`` (six freedoms, no loop) or ``fixed``.
        pitch: pitch of a helical joint, metres per radian.
        axis2: second axis (3,) of a universal joint, perpendicular to the first.
        screw: in place of axis, point, kind and pitch: ``[ω; v]`` (6,) of any length, with v
            the velocity of the body point at the origin. Revolute or helical with pitch
            ``ω·v / |ω|²``, or prismatic if ω is zero.
        mimic: name of another joint and a ratio: ``q = ratio · q_other``, both displacements
            from the reference pose.
    """

    name: str
    parent: str
    child: str
    axis: ArrayLike | None = None
    point: ArrayLike = (0.0, 0.0, 0.0)
    kind: str = "revolute"
    pitch: float = 0.0
    axis2: ArrayLike | None = None
    screw: ArrayLike | None = None
    mimic: tuple[str, float] | None = None

    def __repr__(self) -> str:
        """One line with the kind and the two links."""
        kind = self.kind if self.screw is None else "screw"
        return f"ScrewJoint {self.name}: {kind} from {self.parent} to {self.child}"


class _CheckedJoint(NamedTuple):
    """A joint with checked numbers: type in the file, axes (or None), point, pitch."""

    joint: ScrewJoint
    kind: str
    axis: Array
    axis2: Array | None
    point: Array
    pitch: float

    @property
    def axes(self) -> tuple[str, str]:
        """Both axes as text."""
        if self.kind == "fixed":
            return "", ""
        return number_words(self.axis), "" if self.axis2 is None else number_words(self.axis2)


def from_screws(
    joints: Sequence[ScrewJoint],
    loops: Sequence[ScrewJoint] = (),
    bodies: Mapping[str, BodyLike] | None = None,
    inputs: Sequence[str] | None = None,
    *,
    name: str = "linkage",
) -> Linkage:
    """Build a linkage from the screws of its joints.

    A joint with axis n through r and pitch λ has the screw ``[n; r × n + λ n]``, a prismatic
    one ``[0; n]``, in the inertial frame at the reference pose. The frame of a link has its
    origin at the point of the joint that carries it, and axes parallel to the inertial frame.
    The base is the one link that no joint carries; its frame is the inertial frame.

    Args:
        joints: joints of the tree, in any order.
        loops: joints that close loops, from predecessor to successor; kind ``fixed`` welds.
        bodies: mass (kg), centre of mass (3,) in the inertial frame (m), and inertia tensor
            about that centre (3, 3), along inertial axes (kg m²), by the name of the link.
            Links without an entry carry no inertial parameters. By default every link that
            moves carries parameters, of mass 0.
        inputs: names of joints to use as independent coordinates; by default a
            well-conditioned set is chosen, of joints on the base first.
        name: name of the linkage, in messages and in its file.

    Returns:
        The linkage, as `kinematics.load` returns it for a file. Where the decimals of the
        numbers close its loops, the loops are closed in exact arithmetic too.

    Raises:
        FileError: the joints do not form a linkage; the message names the joint, the problem
            and the remedy.
        LinkageError: as for `kinematics.load`.

    Source:
        R. W. Brockett, "Robotic manipulators and the product of exponentials formula", 1984.

    Example:
        >>> from kinematics import ScrewJoint, from_screws
        >>> crank = ScrewJoint("u1", "base", "crank")
        >>> coupler = ScrewJoint("q2", "crank", "coupler", point=(0.1, 0.3, 0))
        >>> rocker = ScrewJoint("q4", "base", "rocker", point=(1.1, 0, 0))
        >>> closed = ScrewJoint("q3", "coupler", "rocker", point=(0.9, 0.7, 0))
        >>> linkage = from_screws([crank, coupler, rocker], [closed], inputs=["u1"])
        >>> linkage.mobility, linkage.planar
        (1, True)
    """
    source = f"{clean(str(name))} (built from screws)"
    with faults_of(source):
        robot = _robot(name, joints, loops, bodies)
    return assemble_elements(robot, source, inputs, links_and_joints(bodies))


def _robot(
    name: str,
    joints: Sequence[ScrewJoint],
    loops: Sequence[ScrewJoint],
    bodies: Mapping[str, BodyLike] | None,
) -> Element:
    """Make the elements of the linkage."""
    checked_name("<robot>", "name", name)
    checked = [_check_joint("joint", joint) for joint in joints]
    if not checked:
        raise Refusal("", "no joints", "give at least one joint")
    points = _points(checked)
    masses = bodies_by_link(bodies, points)
    parts = []
    for link, point in points.items():
        body = masses.get(link)
        inertial = None
        if body is not None:
            at = Element("origin", {"xyz": exact_differences(body[1], point)})
            inertial = make_elements.inertial(body[0], body[2], at)
        parts.append(make_elements.link(link, inertial))
    parts += [_joint_element(each, points) for each in checked]
    parts += [_loop_element(_check_joint("loop", loop), points) for loop in loops]
    return make_elements.robot(name, parts)


def _points(joints: Sequence[_CheckedJoint]) -> dict[str, Array]:
    """Origins (3,) of all links by their names, the base first.

    Raises:
        Refusal: a parent is neither the base nor the child of a joint.
    """
    carried = {each.joint.child: each.point for each in joints}
    bases = [x.joint for x in joints if x.joint.parent not in carried]
    base = bases[0].parent if bases else joints[0].joint.parent
    origins = {base: np.zeros(3), **carried}
    for joint in bases:
        if joint.parent != base:
            problem = f"no joint carries its parent link '{clean(joint.parent)}', and the "
            problem += f"base is '{clean(base)}'"
            remedy = f"correct the name; the links are {closest_names(joint.parent, origins)}"
            raise Refusal(find_by_name("joint", joint.name), problem, remedy)
    return origins


def _check_joint(word: str, joint: object) -> _CheckedJoint:
    """Check the numbers of a joint or of a loop."""
    if not isinstance(joint, ScrewJoint):
        problem = f"{clean(repr(joint), 60)} is not a ScrewJoint"
        raise Refusal(f"{word}s", problem, "write ScrewJoint(name, parent, child, …)")
    label = find_by_name(word, joint.name)
    for what in ("name", "parent", "child"):
        checked_name(label, what, getattr(joint, what))
    if joint.kind not in KINDS:
        problem = f"unknown kind '{clean(str(joint.kind))}'"
        raise Refusal(label, problem, f"choose from {', '.join(KINDS)}")
    if joint.screw is not None:
        return _check_screw(label, joint, joint.screw)
    axis = checked_direction(
        label, "axis", (0.0, 0.0, 1.0) if joint.axis is None else joint.axis
    )
    axis2 = _second_axis(label, joint, axis)
    pitch = float(checked_array(label, "pitch", joint.pitch, ()))
    if pitch and (joint.kind != "helical" or word == "loop"):
        problem = f"a pitch on a {joint.kind} {word}"
        raise Refusal(label, problem, 'use kind="helical" on a joint of the tree')
    return _CheckedJoint(
        joint, _file_type(joint.kind), axis, axis2, _point(label, joint), pitch
    )


def _second_axis(label: str, joint: ScrewJoint, axis: Array) -> Array | None:
    """Compute the second axis of a universal joint, if one is given."""
    if joint.axis2 is None:
        return None
    if joint.kind != "universal":
        raise Refusal(label, f"axis2 of a {joint.kind} joint", "give it to universal ones only")
    axis2 = checked_direction(label, "axis2", joint.axis2)
    size = float(np.linalg.norm(axis) * np.linalg.norm(axis2))
    if abs(float(axis @ axis2)) > AXES_PERPENDICULAR_COSINE * size:
        problem = "axis2 is not perpendicular to the axis"
        raise Refusal(label, problem, "correct it, or use two revolute joints")
    return axis2


def _file_type(kind: str) -> str:
    """Find the type in the file; rotations have no limits."""
    return "continuous" if kind in ("revolute", "helical") else kind


def _point(label: str, joint: ScrewJoint) -> Array:
    """Find the point of a joint (3,), metres."""
    return checked_array(label, "point", joint.point, (3,))


def _check_screw(label: str, joint: ScrewJoint, given: ArrayLike) -> _CheckedJoint:
    """Check a joint given by its screw; its point is the one nearest to the origin."""
    others = (joint.axis, joint.axis2, joint.pitch or None)
    if any(other is not None for other in others) or joint.kind != "revolute":
        problem = "a screw, and beside it an axis, a pitch or a kind"
        raise Refusal(label, problem, "give the screw alone, or the others without it")
    screw = checked_array(label, "screw", given, (6,))
    turning = bool(np.any(screw[:3]))
    axis = checked_direction(label, "screw", screw[:3] if turning else screw[3:])
    if not turning:
        return _CheckedJoint(joint, "prismatic", axis, None, _point(label, joint), 0.0)
    line = twist_axis(screw, ROTATION_PITCH)
    return _CheckedJoint(joint, "continuous", axis, None, line.point, line.pitch)


def _joint_element(each: _CheckedJoint, points: Mapping[str, Array]) -> Element:
    """Make the ``<joint>`` element."""
    joint = each.joint
    at = Element(
        "origin", {"xyz": exact_differences(points[joint.child], points[joint.parent])}
    )
    return make_elements.joint(
        joint.name,
        each.kind,
        joint.parent,
        joint.child,
        at,
        each.axes,
        each.pitch,
        _mimic(joint),
    )


def _mimic(joint: ScrewJoint) -> tuple[str, float, float] | None:
    """Source, ratio and offset of a mimic joint."""
    if joint.mimic is None:
        return None
    label = find_by_name("joint", joint.name)
    try:
        source, ratio = joint.mimic
    except (TypeError, ValueError):
        problem = f"mimic = {clean(repr(joint.mimic), 60)} is not a name and a ratio"
        raise Refusal(label, problem, 'write it as in mimic=("u1", -1.0)') from None
    return (
        checked_name(label, "mimic", source),
        float(checked_array(label, "ratio", ratio, ())),
        0.0,
    )


def _loop_element(each: _CheckedJoint, points: Mapping[str, Array]) -> Element:
    """Make the ``<loop>`` element; both sides have axes parallel to the inertial frame."""
    loop = each.joint
    if loop.mimic is not None or each.pitch:
        problem = "a loop cannot mimic another joint, or have a pitch"
        raise Refusal(find_by_name("loop", loop.name), problem, "let a joint of the tree do so")
    return make_elements.loop(
        loop.name,
        each.kind,
        [_side(each, end, points) for end in (loop.parent, loop.child)],
        each.axes,
    )


def _side(
    each: _CheckedJoint, link: str, points: Mapping[str, Array]
) -> tuple[str, Element | None]:
    """Find a link, known or not, and the ``<origin>`` of the loop in its frame."""
    at = Element(
        "origin", {"xyz": exact_differences(each.point, points.get(link, np.zeros(3)))}
    )
    return link, at
