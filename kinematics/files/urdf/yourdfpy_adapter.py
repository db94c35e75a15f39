"""Convert a model that yourdfpy has loaded to a tree and its poses.

The model passes the same checks as a file. No file is read by yourdfpy here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kinematics.error_text import clean
from kinematics.errors import FileError
from kinematics.files.urdf.robot_tree import Robot
from kinematics.files.urdf.validate_fields import MAX_NUMBER
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.numerics.tolerances import ROTATION_ORTHOGONALITY

if TYPE_CHECKING:
    from yourdfpy import URDF
    from yourdfpy import urdf as yourdf


def set_poses(robot: Robot, model: URDF) -> Robot:
    """Set the poses of a robot to those of a loaded model, which holds matrices, not angles.

    Args:
        robot: description of the tree that `tree_of` makes of the model.

    Returns:
        The robot with the origins (4, 4) of its joints and inertias, metres.
    """
    inertials = {link.name: link.inertial for link in model.robot.links}
    links = {
        name: inertial and inertial._replace(origin=_pose(inertials[name]))
        for name, inertial in robot.links.items()
    }
    pairs = zip(robot.joints, model.robot.joints, strict=True)
    joints = [joint._replace(origin=_pose(given)) for joint, given in pairs]
    return Robot(robot.name, links, tuple(joints))


def _pose(item: yourdf.Joint | yourdf.Inertial) -> np.ndarray:
    return np.eye(4) if item.origin is None else item.origin


def tree_of(model: URDF) -> Element:
    """Convert the links and joints of a loaded model to a tree for the checks.

    The tree has no rotations: roll, pitch and yaw would lose digits where pitch is near a
    right angle.

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
        np.all(np.abs(pose) <= MAX_NUMBER)
        and np.all(np.abs(R.T @ R - np.eye(3)) <= ROTATION_ORTHOGONALITY)
        and np.linalg.det(R) > 0.0
    ):
        label, remedy = f"origin of '{clean(name)}'", "give it a rotation and a finite position"
        raise FileError(clean(source or "URDF"), label, "no rigid displacement", remedy)


def _link(link: yourdf.Link) -> Element:
    parts = []
    if link.inertial is not None:
        mass, inertia = link.inertial.mass, link.inertial.inertia
        if mass is not None:
            parts.append(Element("mass", {"value": number_words([mass])}))
        if inertia is not None:
            entries = zip("xyz", inertia, strict=True)
            upper = {
                f"i{a}{b}": number_words([value])
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
        parts.append(Element("axis", {"xyz": number_words(joint.axis)}))
    if joint.mimic is not None:
        follows = {
            "joint": joint.mimic.joint,
            "multiplier": number_words([joint.mimic.multiplier]),
            "offset": number_words([joint.mimic.offset]),
        }
        parts.append(Element("mimic", follows))
    return Element("joint", {"name": joint.name or "", "type": joint.type or ""}, tuple(parts))
