"""Read joints, frames and inertias of a robot from its checked tree, as numbers.

The description is the same for a file and for a model that yourdfpy has loaded.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kinematics.files.urdf.validate_inertias import tensor
from kinematics.model.document.element import Element
from kinematics.numerics.array_types import Array


class Inertial(NamedTuple):
    """The ``<inertial>`` of a link.

    Attributes:
        mass: kg.
        inertia: tensor about the centre of mass (3, 3), along the axes of ``origin``, kg m².
        origin: pose of the centre of mass in the frame of the link (4, 4), metres.
    """

    mass: float
    inertia: Array
    origin: Array


class Follows(NamedTuple):
    """A ``<mimic>``: the position is ``multiplier`` times that of a joint, plus ``offset``."""

    joint: str
    multiplier: float
    offset: float


class TreeJoint(NamedTuple):
    """A joint between two links of the tree.

    Attributes:
        element: the element, with its name, type, axes and pitch.
        parent: name of its parent link.
        child: name of its child link.
        origin: its pose in the frame of the parent link (4, 4), metres.
        mimic: its relation to another joint, if it is a moving mimic joint.
    """

    element: Element
    parent: str
    child: str
    origin: Array
    mimic: Follows | None

    @property
    def name(self) -> str:
        """Name in the file."""
        return self.element.name

    @property
    def kind(self) -> str:
        """Type in the file."""
        return self.element.attributes["type"]


class Robot(NamedTuple):
    """Links and joints of a tree.

    Attributes:
        name: name of the robot.
        links: mass and inertia of every link by its name, None if the file gives none.
        joints: joints in the order of the file.
    """

    name: str
    links: Mapping[str, Inertial | None]
    joints: tuple[TreeJoint, ...]


def describe_robot(tree: Element) -> Robot:
    """Read joints, frames and inertias of a tree.

    Args:
        tree: a tree that `kinematics.files.urdf.validate.validate_robot` accepted.
    """
    links = {link.name: _inertial(link.first("inertial")) for link in tree.every("link")}
    return Robot(tree.name, links, tuple(_joint(joint) for joint in tree.every("joint")))


def pose_matrix(origin: Element | None) -> Array:
    """Compute the pose (4, 4) of an ``<origin>``; the identity if there is none."""
    pose = np.eye(4)
    if origin is not None:
        pose[:3, :3] = rotation_of_angles(origin.vector("rpy", "0 0 0"))
        pose[:3, 3] = origin.vector("xyz", "0 0 0")
    return pose


def rotation_of_angles(angles: ArrayLike) -> Array:
    """Compute the rotation matrix (3, 3) ``Rz(yaw) Ry(pitch) Rx(roll)``.

    Args:
        angles: roll, pitch and yaw, radians.
    """
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
    return np.array(
        [
            [cp * cy, sp * (sr * cy) - cr * sy, sp * (cr * cy) + sr * sy],
            [cp * sy, sp * (sr * sy) + cr * cy, sp * (cr * sy) - sr * cy],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _inertial(item: Element | None) -> Inertial | None:
    """Read an ``<inertial>``; an empty one counts as none."""
    mass = item.first("mass") if item is not None else None
    inertia = item.first("inertia") if item is not None else None
    if item is None or mass is None or inertia is None:
        return None
    (kilograms,) = mass.vector("value", "0")
    return Inertial(kilograms, np.array(tensor(inertia)), pose_matrix(item.first("origin")))


def _joint(joint: Element) -> TreeJoint:
    """Read a ``<joint>``."""
    parent, child = (joint.link_at(role) for role in ("parent", "child"))
    mimic = joint.first("mimic")
    follows = None
    if mimic is not None and joint.attributes["type"] != "fixed":
        (multiplier,), (offset,) = mimic.vector("multiplier", "1"), mimic.vector("offset", "0")
        follows = Follows(mimic.attributes["joint"], multiplier, offset)
    return TreeJoint(joint, parent, child, pose_matrix(joint.first("origin")), follows)
