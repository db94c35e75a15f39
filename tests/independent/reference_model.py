"""Linkages for the independent route: read from a URDF file with nothing but ElementTree.

Only what the gallery uses is read: loops assembled in the file, and no rotated frames.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
MODELS = Path(__file__).resolve().parents[2] / "urdf_models"
GROUND = -1


class Cut(NamedTuple):
    """A loop joint: two links share a point and, if ``axis`` is not None, an axis."""

    first: int
    second: int
    point: Array
    axis: Array | None


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A linkage at its reference pose.

    Attributes:
        name: name of the robot.
        joints: names of the joints of the tree, parents first.
        parents: link that carries each joint.
        twists: unit twist of each joint; shape (n, 4, 4).
        points: a point of each joint; shape (n, 3), metres.
        bodies: links with inertial parameters, by name.
        links: the same links, by number.
        inertias: their inertial parameters; shape (nb, 10).
        cuts: the joints that close the loops.
        inputs: numbers of the joints that are the independent coordinates.
        relations: of mimic joints, ``relations @ q = 0``; shape (mimics, n).
    """

    name: str
    joints: tuple[str, ...]
    parents: tuple[int, ...]
    twists: Array
    points: Array
    bodies: tuple[str, ...]
    links: tuple[int, ...]
    inertias: Array
    cuts: tuple[Cut, ...]
    inputs: tuple[int, ...]
    relations: Array

    def scaled(self) -> Mechanism:
        """The same linkage with the origin amid its joints and unit length their spread.

        If all joints are in one point, the centres of mass count as well. Inertias are
        left as they are: ranks do not need them.
        """
        points = np.array([*self.points, *(cut.point for cut in self.cuts)])
        if not np.ptp(points, axis=0).any():
            points = np.vstack([points, self.inertias[:, 1:4] / self.inertias[:, :1]])
        centre = points.mean(axis=0)
        length = np.linalg.norm(points - centre, axis=1).max()
        change = np.eye(4)
        change[:3, :3] /= length
        change[:3, 3] = -centre / length
        twists = change @ self.twists @ np.linalg.inv(change)
        cuts = tuple(cut._replace(point=(cut.point - centre) / length) for cut in self.cuts)
        return replace(self, twists=twists, points=(self.points - centre) / length, cuts=cuts)


def hat(vector: Array) -> Array:
    """The matrix of the cross product by ``vector``; shape (3, 3)."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def point_mass(position: Array) -> Array:
    """Inertial parameters of a unit mass at ``position``, from ``-[r]²``; shape (10,)."""
    tensor = -hat(position) @ hat(position)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return np.array([1, *position, *(tensor[pair] for pair in pairs)])


def child(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    """The child of that tag, which must be there."""
    found = element.find(tag)
    if found is None:
        raise ValueError(f"{element.get('name', element.tag)}: has no <{tag}>")
    return found


def numbers(element: ElementTree.Element | None, key: str, default: str) -> Array:
    """The numbers of an attribute, or of ``default`` if the element is absent."""
    return np.array((default if element is None else element.get(key, default)).split(), float)


def origin(element: ElementTree.Element) -> Array:
    """The offset of a child ``<origin>``, which must not rotate; shape (3,), metres."""
    offset = element.find("origin")
    if numbers(offset, "rpy", "0 0 0").any():
        raise ValueError(f"{element.get('name')}: the reference route reads rpy='0 0 0' only")
    return numbers(offset, "xyz", "0 0 0")


def joint_twist(joint: ElementTree.Element, point: Array) -> Array:
    """The twist of a joint through ``point``, per radian or metre; shape (4, 4)."""
    axis = numbers(joint.find("axis"), "xyz", "1 0 0")
    axis /= np.linalg.norm(axis)
    twist = np.zeros((4, 4))
    if joint.get("type") == "prismatic":
        twist[:3, 3] = axis
        return twist
    if joint.get("type") not in ("revolute", "continuous"):
        raise ValueError(f"{joint.get('name')}: unknown type {joint.get('type')}")
    pitch = numbers(joint.find("screw_thread_pitch"), "value", "0")[0]
    twist[:3, :3] = hat(axis)
    twist[:3, 3] = np.cross(point, axis) + pitch / (2 * np.pi) * axis
    return twist


def inertial_parameters(inertial: ElementTree.Element, frame: Array) -> Array:
    """Parameters about the inertial origin of a link whose frame is at ``frame``."""
    mass = numbers(child(inertial, "mass"), "value", "")[0]
    inertia = child(inertial, "inertia")
    order = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    about_centre = [numbers(inertia, key, "")[0] for key in order]
    return np.array([0, 0, 0, 0, *about_centre]) + mass * point_mass(frame + origin(inertial))


def in_order(
    robot: ElementTree.Element,
) -> tuple[list[ElementTree.Element], dict[str | None, tuple[int, Array]]]:
    """The joints of the tree, parents first, and number and position of every link."""
    waiting = robot.findall("joint")
    carried = {child(joint, "child").get("link") for joint in waiting}
    known: dict[str | None, tuple[int, Array]] = {
        link.get("name"): (GROUND, np.zeros(3))
        for link in robot.findall("link")
        if link.get("name") not in carried
    }
    joints: list[ElementTree.Element] = []
    while waiting:
        joint = next(j for j in waiting if child(j, "parent").get("link") in known)
        waiting.remove(joint)
        frame = known[child(joint, "parent").get("link")][1]
        known[child(joint, "child").get("link")] = (len(joints), frame + origin(joint))
        joints.append(joint)
    return joints, known


def read_cut(loop: ElementTree.Element, known: dict[str | None, tuple[int, Array]]) -> Cut:
    """A ``<loop>`` element of type revolute or spherical, assembled in the file."""
    ends = child(loop, "predecessor"), child(loop, "successor")
    (first, at_first), (second, at_second) = (known[end.get("link")] for end in ends)
    point = at_first + origin(ends[0])
    gap = np.linalg.norm(point - at_second - origin(ends[1]))
    if gap > 1e-14:
        raise ValueError(f"{loop.get('name')}: open by {gap} m")
    if loop.get("type") not in ("revolute", "spherical"):
        raise ValueError(f"{loop.get('name')}: unknown type {loop.get('type')}")
    if loop.get("type") == "spherical":
        return Cut(first, second, point, None)
    axis = numbers(child(loop, "axis"), "xyz", "")
    return Cut(first, second, point, axis / np.linalg.norm(axis))


def read_relations(joints: Sequence[ElementTree.Element]) -> Array:
    """Rows ``q_j - ratio q_source = 0`` of the mimic joints; shape (mimics, n), no offsets."""
    names = [joint.get("name") for joint in joints]
    rows = []
    for row, joint in zip(np.eye(len(joints)), joints, strict=True):
        if (mimic := joint.find("mimic")) is not None:
            row[names.index(mimic.get("joint"))] -= numbers(mimic, "multiplier", "1")[0]
            rows.append(row)
    return np.array(rows).reshape(-1, len(joints))


def load(model: str | Path, inputs: Sequence[str] = ()) -> Mechanism:
    """Read a model of the gallery by its name, or any such file by its path.

    Args:
        model: name of a file of the gallery, without suffix, or a path.
        inputs: joints to use as inputs instead of those that the file marks.
    """
    path = MODELS / f"{model}.urdf" if isinstance(model, str) else model
    robot = ElementTree.parse(path).getroot()
    joints, known = in_order(robot)
    names = [joint.get("name", "") for joint in joints]
    points = [known[child(joint, "child").get("link")][1] for joint in joints]
    solid = [link for link in robot.findall("link") if link.find("inertial") is not None]
    marked = [joint.get("name", "") for joint in joints if joint.get("independent") == "true"]
    return Mechanism(
        name=robot.get("name", ""),
        joints=tuple(names),
        parents=tuple(known[child(joint, "parent").get("link")][0] for joint in joints),
        twists=np.array([joint_twist(*pair) for pair in zip(joints, points, strict=True)]),
        points=np.array(points),
        bodies=tuple(link.get("name", "") for link in solid),
        links=tuple(known[link.get("name")][0] for link in solid),
        inertias=np.array(
            [
                inertial_parameters(child(link, "inertial"), known[link.get("name")][1])
                for link in solid
            ]
        ),
        cuts=tuple(read_cut(loop, known) for loop in robot.findall("loop")),
        inputs=tuple(names.index(name) for name in inputs or marked),
        relations=read_relations(joints),
    )
