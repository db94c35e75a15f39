"""From a URDF file to a draft of a linkage.

The guard refuses what cannot be a linkage, yourdfpy reads the frames, axes and inertias,
and the bare XML tree supplies what yourdfpy drops: loops, screw pitches, input marks.

The inertial frame is the frame of the root link. The pose of the file, where every joint
coordinate is zero (that of a mimic joint: its offset), becomes the reference pose.
"""

from __future__ import annotations

import heapq
import io
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from kinematics.errors import FileError
from kinematics.fields import LARGEST, coordinates
from kinematics.guard import check
from kinematics.inertial import parameters
from kinematics.linkage import GROUND, Body, Draft, Joint, Loop, Mimic, Notice, frozen
from kinematics.loops import Place, attach, freedoms, perpendicular, unit
from kinematics.markup import Element, shown
from kinematics.screws import exp, revolute

if TYPE_CHECKING:
    from yourdfpy import urdf as yourdf

__all__ = ["draft", "read"]

Array = NDArray[np.float64]

# What yourdfpy is given to read: shapes cannot fail, and prefixes cannot hide elements.
_KEPT = {
    "robot": ("link", "joint"),
    "link": ("inertial",),
    "inertial": ("origin", "mass", "inertia"),
    "joint": ("parent", "child", "origin", "axis", "mimic"),
}


def read(path: str | os.PathLike[str]) -> Draft:
    """Read a URDF file.

    Args:
        path: the file.

    Returns:
        The linkage as the file describes it, with its loops not yet closed.

    Raises:
        FileError: the file cannot be read as a linkage; the message says where and why.
    """
    tree = check(path)
    source = os.fsdecode(path)
    return draft(_parsed(tree, source), tree, source)


def draft(robot: yourdf.Robot, tree: Element, source: str) -> Draft:
    """Build a draft from a robot that yourdfpy has read.

    Args:
        robot: links and joints.
        tree: the same robot as :func:`kinematics.guard.check` returns it; supplies loops,
            screw pitches, second axes and input marks.
        source: path of the file, for messages.

    Raises:
        FileError: no moving link has inertia, or a mimic joint is out of range.
    """
    file = shown(source, 1000)
    offsets = _offsets(robot.joints)
    for name, position in offsets.items():
        if not abs(position) <= LARGEST:
            remedy = "correct the offsets and multipliers of the mimic joints"
            raise FileError(file, f"joint '{shown(name)}'", "position out of range", remedy)
    joints, places = _tree_joints(robot, tree, offsets)
    bodies = _bodies(robot, places)
    if not bodies:
        remedy = "give the links that move a mass and an inertia"
        raise FileError(file, "", "no moving link has an <inertial>", remedy)
    loops = _loops(tree, places, joints)
    return Draft(
        name=robot.name,
        source=source,
        joints=tuple(joints),
        bodies=tuple(bodies),
        loops=tuple(loops),
        mimics=tuple(_mimics(robot, joints)),
        named_inputs=_inputs(tree),
        notices=_notices(places, bodies),
    )


def _parsed(tree: Element, source: str) -> yourdf.Robot:
    """The tree as yourdfpy reads it."""
    from yourdfpy import URDF

    data = io.BytesIO(ElementTree.tostring(_skeleton(tree)))
    try:
        model = URDF.load(
            data,
            build_scene_graph=False,
            build_collision_scene_graph=False,
            load_meshes=False,
            load_collision_meshes=False,
        )
    except Exception as error:
        problem = f"yourdfpy cannot read it ({' '.join(repr(error).split())})"
        raise FileError(shown(source, 1000), "", problem, "simplify the file") from error
    return model.robot


def _skeleton(element: Element) -> ElementTree.Element:
    """The element and what yourdfpy needs of its contents."""
    plain = {k: v for k, v in element.attributes.items() if ":" not in k and k != "xmlns"}
    copy = ElementTree.Element(element.tag, plain)
    kept = _KEPT.get(element.tag, ())
    copy.extend(_skeleton(child) for child in element.children if child.tag in kept)
    return copy


def _ordered(joints: Sequence[yourdf.Joint], root: str) -> list[yourdf.Joint]:
    """Parents first, and otherwise in the order of the file."""
    hanging: dict[str, list[int]] = {}
    for i, joint in enumerate(joints):
        hanging.setdefault(joint.parent, []).append(i)
    ready = hanging.get(root, [])[:]
    order = []
    while ready:
        joint = joints[heapq.heappop(ready)]
        order.append(joint)
        for i in hanging.get(joint.child, ()):
            heapq.heappush(ready, i)
    return order


def _offsets(joints: Sequence[yourdf.Joint]) -> dict[str, float]:
    """Positions of the mimic joints at the pose of the file: ratio × source + offset."""
    mimics = {j.name: j.mimic for j in joints if j.mimic is not None}
    known: dict[str, float] = {}
    for start in mimics:
        path = [start]
        while path[-1] in mimics and path[-1] not in known:
            path.append(mimics[path[-1]].joint)
        position = known.get(path.pop(), 0.0)
        for name in reversed(path):
            position = mimics[name].multiplier * position + mimics[name].offset
            known[name] = position
    return known


def _tree_joints(
    robot: yourdf.Robot, tree: Element, offsets: Mapping[str, float]
) -> tuple[list[Joint], dict[str, Place]]:
    """The joints of the tree, and the place of every link of the file, root first."""
    carried = {joint.child for joint in robot.joints}
    root = next(link.name for link in robot.links if link.name not in carried)
    elements = {item.name: item for item in tree.every("joint")}
    places = {root: Place(GROUND, np.eye(4))}
    joints: list[Joint] = []
    for joint in _ordered(robot.joints, root):
        link, pose = places[joint.parent]
        frame = pose if joint.origin is None else pose @ joint.origin
        for name, (kind, screw) in zip(
            coordinates(joint.name, joint.type), _steps(joint, elements[joint.name], frame),
            strict=True,
        ):  # fmt: skip
            joints.append(Joint(name, kind, link, frozen(screw), frozen(frame[:3, 3])))
            link = len(joints) - 1
        if offsets.get(joint.name):
            frame = exp(joints[link].screw, offsets[joint.name]) @ frame
        places[joint.child] = Place(link, frame)
    return joints, places


def _steps(joint: yourdf.Joint, element: Element, frame: Array) -> list[tuple[str, Array]]:
    """Kinds and screws of a joint whose frame has the pose ``frame`` (4, 4)."""
    if joint.type == "fixed":
        return []
    axis = unit(joint.axis)
    second = element.first("axis2")
    across = perpendicular(axis, second.vector("xyz", "") if second else None)
    n, u, point = frame[:3, :3] @ axis, frame[:3, :3] @ across, frame[:3, 3]
    thread = element.first("screw_thread_pitch")
    pitch = thread.vector("value", "")[0] / (2 * np.pi) if thread else 0.0
    if pitch:
        return [("helical", revolute(n, point, pitch))]
    return freedoms(joint.type, n, u, point)


def _weighed(inertial: yourdf.Inertial, pose: Array) -> Array:
    """Inertial parameters (10,) about the inertial origin of a link at ``pose`` (4, 4).

    The file gives the tensor about the centre of mass, along the axes of the inertial's
    own frame; both are carried to the inertial frame.
    """
    frame = pose if inertial.origin is None else pose @ inertial.origin
    R = frame[:3, :3]
    return parameters(inertial.mass, frame[:3, 3], R @ inertial.inertia @ R.T)


def _bodies(robot: yourdf.Robot, places: Mapping[str, Place]) -> list[Body]:
    """Moving rigid bodies with inertia, each named after its topmost link."""
    top: dict[int, str] = {}
    for name, place in places.items():
        top.setdefault(place.link, name)
    sums: dict[int, Array] = {}
    for link in robot.links:
        place = places[link.name]
        if place.link != GROUND and link.inertial is not None:
            z = _weighed(link.inertial, place.pose)
            sums[place.link] = sums.get(place.link, 0.0) + z
    return [
        Body(top[link], link, frozen(sums[link]), frozen(places[top[link]].pose))
        for link in sorted(sums)
    ]


def _loops(tree: Element, places: Mapping[str, Place], joints: list[Joint]) -> list[Loop]:
    """The welds; the joints of the loops are appended to ``joints``."""
    extent = max(float(np.abs(place.pose[:3, 3]).max()) for place in places.values())
    welds = []
    for element in tree.every("loop"):
        chain, weld = attach(element, places, len(joints), extent)
        joints.extend(chain)
        welds.append(weld)
    return welds


def _mimics(robot: yourdf.Robot, joints: Sequence[Joint]) -> list[Mimic]:
    index = {joint.name: i for i, joint in enumerate(joints)}
    return [
        Mimic(index[joint.name], index[joint.mimic.joint], joint.mimic.multiplier)
        for joint in robot.joints
        if joint.mimic is not None
    ]


def _inputs(tree: Element) -> tuple[str, ...]:
    """Coordinates of the joints and loops that are marked as independent."""
    marked = [
        coordinates(item.name, item.attributes["type"])
        for item in tree.every("joint") + tree.every("loop")
        if item.attributes.get("independent") == "true"
    ]
    return tuple(name for names in marked for name in names)


def _notices(places: Mapping[str, Place], bodies: Sequence[Body]) -> tuple[Notice, ...]:
    """Moving bodies without ``<inertial>``, which carry no parameters."""
    settled = {GROUND, *(body.link for body in bodies)}
    bare = []
    for name, place in places.items():
        if place.link not in settled:
            settled.add(place.link)
            bare.append(name)
    if not bare:
        return ()
    return (Notice("massless", f"no <inertial>, so no parameters: {', '.join(bare)}"),)
