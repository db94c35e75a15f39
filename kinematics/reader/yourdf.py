"""The border to yourdfpy: from a checked tree to its robot, and from its model to a tree.

yourdfpy is given only what it can read without failing, and a model that it has read
already passes the same checks as a file.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from kinematics.errors import FileError
from kinematics.reader.fields import LARGEST
from kinematics.reader.markup import Element, shown

if TYPE_CHECKING:
    from yourdfpy import URDF
    from yourdfpy import urdf as yourdf

__all__ = ["robot_of", "tree_of"]

# Entries of RᵀR - 1 of a pose, above which it is no rotation; files have six digits or more.
ORTHOGONAL = 1e-5

# What yourdfpy is given to read: shapes cannot fail, and prefixes cannot hide elements.
_KEPT = {
    "robot": ("link", "joint"),
    "link": ("inertial",),
    "inertial": ("origin", "mass", "inertia"),
    "joint": ("parent", "child", "origin", "axis", "mimic"),
}


def robot_of(tree: Element, source: str) -> yourdf.Robot:
    """The tree as yourdfpy reads it.

    Args:
        tree: accepted by :func:`kinematics.reader.guard.check`.
        source: path of the file, for messages.

    Raises:
        FileError: yourdfpy cannot read it.
    """
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
    copy.extend(
        _skeleton(child)
        for child in element.children
        if child.tag in kept and (child.tag != "inertial" or child.children)
    )
    return copy


def tree_of(model: URDF) -> Element:
    """The links and joints of a loaded model, as a tree that the guard can check.

    Rotations are left out of it: roll, pitch and yaw would lose digits where pitch is near
    a right angle.

    Raises:
        FileError: a pose in the model is not a rigid displacement.
    """
    robot = model.robot
    for item in [*robot.joints, *(link.inertial for link in robot.links if link.inertial)]:
        _check_pose(robot.name, getattr(item, "name", "<inertial>"), item.origin)
    parts = [_link(link) for link in robot.links] + [_joint(joint) for joint in robot.joints]
    return Element("robot", {"name": robot.name or ""}, tuple(parts))


def _check_pose(source: str, name: str, pose: np.ndarray | None) -> None:
    if pose is None:
        return
    R = pose[:3, :3]
    if not (
        np.all(np.abs(pose) <= LARGEST)
        and np.all(np.abs(R.T @ R - np.eye(3)) <= ORTHOGONAL)
        and np.linalg.det(R) > 0.0
    ):
        label, remedy = f"origin of '{shown(name)}'", "give it a rotation and a finite position"
        raise FileError(shown(source or "URDF"), label, "no rigid displacement", remedy)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _link(link: yourdf.Link) -> Element:
    parts = []
    if link.inertial is not None:
        mass, inertia = link.inertial.mass, link.inertial.inertia
        if mass is not None:
            parts.append(Element("mass", {"value": _numbers([mass])}))
        if inertia is not None:
            entries = zip("xyz", inertia, strict=True)
            upper = {
                f"i{a}{b}": _numbers([value])
                for a, row in entries
                for b, value in zip("xyz", row, strict=True)
                if a <= b
            }
            parts.append(Element("inertia", upper))
    inertial = [Element("inertial", {}, tuple(parts))] if parts else []
    return Element("link", {"name": link.name or ""}, tuple(inertial))


def _joint(joint: yourdf.Joint) -> Element:
    ends = {"parent": joint.parent, "child": joint.child}
    parts = [Element(role, {"link": name or ""}) for role, name in ends.items()]
    if joint.axis is not None:
        parts.append(Element("axis", {"xyz": _numbers(joint.axis)}))
    if joint.mimic is not None:
        follows = {
            "joint": joint.mimic.joint,
            "multiplier": _numbers([joint.mimic.multiplier]),
            "offset": _numbers([joint.mimic.offset]),
        }
        parts.append(Element("mimic", follows))
    return Element("joint", {"name": joint.name or "", "type": joint.type or ""}, tuple(parts))
