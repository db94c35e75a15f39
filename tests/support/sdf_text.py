"""SDF files with the linkages of URDF files, written in several styles.

Poses are composed numerically here, by scipy's rotations: the reader of SDF composes none.
"""

from __future__ import annotations

import math
import random
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from tests.support.urdf_text import pose_of, words

Tree = ElementTree.Element
TYPES = {"spherical": "ball"}
STYLES = (
    "model",
    "parent",
    "frames",
    "model_axes",
    "joint_poses",
    "degrees",
    "quaternions",
    "reversed",
    "old",
    "world",
)
# Joint types that SDF does not have.
FOREIGN = ("planar", "cylindrical")


class Placed(NamedTuple):
    """Poses (4, 4) of the links of a URDF file in the frame of its root."""

    root: str
    links: dict[str, np.ndarray]


def numbers(item, attribute, default="0 0 0"):
    text = default if item is None else item.get(attribute, default)
    return np.array([float(word) for word in text.split()])


def nominal(angles):
    """Angles within 1e-4 rad of multiples of π/12, made those multiples, as the reader does."""
    k = np.round(angles * 12 / math.pi)
    near = (np.abs(angles - k * math.pi / 12) < 1e-4) & (k != 0)
    return np.where(near, k * math.pi / 12, angles)


def origin_pose(item):
    origin = None if item is None else item.find("origin")
    return pose_of(numbers(origin, "xyz"), nominal(numbers(origin, "rpy")))


def placed(robot: Tree) -> Placed:
    """Where the links are."""
    joints = robot.findall("joint")
    carried = {joint.find("child").get("link") for joint in joints}
    root = next(x.get("name") for x in robot.findall("link") if x.get("name") not in carried)
    links = {root: np.eye(4)}
    while len(links) < len(robot.findall("link")):
        for joint in joints:
            parent, child = (joint.find(role).get("link") for role in ("parent", "child"))
            if parent in links:
                links[child] = links[parent] @ origin_pose(joint)
    return Placed(root, links)


def fits(robot: Tree) -> bool:
    """Whether SDF has all its joint types; pitches of screws and mimics, too."""
    return not any(item.get("type") in FOREIGN for item in robot.iter())


class Writer:
    """The writer of one file in one style."""

    def __init__(self, robot: Tree, style: str, seed: int = 0):
        self.robot, self.style, self.rng = robot, style, random.Random(seed)
        self.root, self.poses = placed(robot)
        version = "1.4" if style == "old" else "1.11"
        self.sdf = ElementTree.Element("sdf", {"version": version})
        holder = self.sdf
        if style == "world":
            holder = ElementTree.SubElement(self.sdf, "world", {"name": "w"})
            include = ElementTree.SubElement(holder, "include")
            ElementTree.SubElement(include, "uri").text = "model://sun"
        self.model = ElementTree.SubElement(holder, "model", {"name": robot.get("name", "m")})

    def text(self) -> str:
        for link in self.robot.findall("link"):
            self.link(link)
        for joint in self.robot.findall("joint"):
            self.joint(joint)
        for loop in self.robot.findall("loop"):
            self.loop(loop)
        if self.style in ("world", "reversed"):
            joint = self.item(self.model, "joint", name="to_world", type="fixed")
            self.item(joint, "parent", "world")
            self.item(joint, "child", self.root)
        ElementTree.indent(self.sdf)
        return ElementTree.tostring(self.sdf, encoding="unicode")

    def item(self, holder, tag, text=None, **attributes):
        found = ElementTree.SubElement(holder, tag, attributes)
        found.text = text
        return found

    def pose(self, holder, pose, base=""):
        """A ``<pose>`` in the style's form."""
        attributes = {"relative_to": base} if base else {}
        R = Rotation.from_matrix(pose[:3, :3])
        angles = R.as_euler("xyz")
        if self.style == "degrees":
            attributes["degrees"] = "true"
            angles = np.degrees(angles)
        if self.style == "quaternions":
            attributes["rotation_format"] = "quat_xyzw"
            angles = R.as_quat()
        line = f"{words(pose[:3, 3])} {words(angles)}"
        return self.item(holder, "pose", line, **attributes)

    def link(self, link):
        name = link.get("name")
        made = self.item(self.model, "link", name=name)
        pose = self.poses[name]
        if self.style == "parent":
            for joint in self.robot.findall("joint"):
                if joint.find("child").get("link") == name:
                    parent = joint.find("parent").get("link")
                    self.pose(made, origin_pose(joint), parent)
        elif self.style == "frames":
            near = pose.copy()
            near[:3, 3] += 0.25
            self.pose(self.item(self.model, "frame", name=f"{name}_near"), near)
            self.pose(made, np.linalg.inv(near) @ pose, f"{name}_near")
        else:
            self.pose(made, pose)
        inertial = link.find("inertial")
        if inertial is not None and len(inertial):
            self.inertial(made, inertial)

    def inertial(self, link, inertial):
        made = self.item(link, "inertial")
        self.pose(made, origin_pose(inertial))
        self.item(made, "mass", inertial.find("mass").get("value"))
        inertia = self.item(made, "inertia")
        for key, value in inertial.find("inertia").attrib.items():
            self.item(inertia, key, value)

    def joint(self, joint):
        parent, child = (joint.find(role).get("link") for role in ("parent", "child"))
        self.write(joint, parent, child, self.poses[child])

    def loop(self, loop):
        first, last = (loop.find(role) for role in ("predecessor", "successor"))
        frame = self.poses[first.get("link")] @ origin_pose(first)
        self.write(loop, first.get("link"), last.get("link"), frame)

    def write(self, joint, parent, child, frame):
        """A joint whose frame has a pose (4, 4) in the model."""
        kind = joint.get("type")
        screw = joint.find("screw_thread_pitch")
        # A joint of two freedoms that is turned round names them in the other order.
        flip = self.style == "reversed" and kind != "universal" and self.rng.random() < 0.6
        if flip:
            parent, child = child, parent
        made = self.item(
            self.model,
            "joint",
            name=joint.get("name"),
            type="screw" if screw is not None else TYPES.get(kind, kind),
        )
        self.item(made, "parent", parent)
        self.item(made, "child", child)
        if screw is not None:
            self.pitch(made, float(screw.get("value")))
        frame = self.moved(made, frame, child)
        for tag in ("axis", "axis2"):
            self.axis(made, joint, tag, -1.0 if flip else 1.0, frame)

    def pitch(self, made, pitch):
        if self.style == "old":
            self.item(made, "thread_pitch", repr(-2 * math.pi / pitch))
        else:
            self.item(made, "screw_thread_pitch", repr(pitch))

    def moved(self, made, frame, child):
        """Write the pose of a joint; the frame that its axes are in."""
        there = np.linalg.inv(self.poses[child]) @ frame
        if self.style == "joint_poses":
            there = there @ pose_of([0, 0, 0], [0.3, -0.2, 0.5])
            frame = frame @ pose_of([0, 0, 0], [0.3, -0.2, 0.5])
        if np.abs(there - np.eye(4)).max() > 1e-15:
            self.pose(made, there)
        return frame

    def axis(self, made, joint, tag, sign, frame):
        """Axes are in the URDF frame of the joint or loop: the rotation of ``urdf``."""
        kind = joint.get("type")
        if kind in ("fixed", "spherical") or (tag == "axis2" and kind != "universal"):
            return
        urdf = self.urdf_frame(joint)
        n = urdf @ self.direction(joint, tag)
        holder = self.item(made, tag)
        if self.style in ("model_axes", "old"):
            xyz = self.item(holder, "xyz", words(sign * n))
            if self.style == "model_axes":
                xyz.set("expressed_in", "__model__")
        else:
            self.item(holder, "xyz", words(sign * (frame[:3, :3].T @ n)))
        mimic = joint.find("mimic")
        if mimic is not None and tag == "axis":
            item = self.item(holder, "mimic", joint=mimic.get("joint"), axis="axis")
            self.item(item, "multiplier", mimic.get("multiplier", "1"))
            self.item(item, "offset", mimic.get("offset", "0"))

    def urdf_frame(self, joint):
        if joint.tag == "joint":
            return self.poses[joint.find("child").get("link")][:3, :3]
        side = joint.find("predecessor")
        return (self.poses[side.get("link")] @ origin_pose(side))[:3, :3]

    def direction(self, joint, tag):
        given = joint.find(tag)
        first = numbers(joint.find("axis"), "xyz", "1 0 0")
        if tag == "axis" or given is not None:
            return first if tag == "axis" else numbers(given, "xyz")
        n = first / np.linalg.norm(first)
        d = np.roll(np.eye(3), 1, axis=1)[np.argmax(np.abs(n))]
        return d - (d @ n) * n


def sdf_of(path, style, seed=0):
    """The text of an SDF file with the linkage of a URDF file."""
    return Writer(ElementTree.parse(path).getroot(), style, seed).text()
