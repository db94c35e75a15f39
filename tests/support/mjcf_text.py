"""Gallery files as MJCF text, in several styles, by a route that the product does not use.

A massless link with one joint above and one below is no body in MuJoCo: its joints are those
of the next body. A revolute loop becomes two points on its axis, a spherical one a point, and
a fixed one a weld. Screw joints and loops of other types cannot be written.
"""

from __future__ import annotations

import random
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from kinematics.model.document.element import Document

STYLES = ("degrees", "quats", "classes", "frames", "geoms")
TYPES = {"continuous": "hinge", "revolute": "hinge", "prismatic": "slide"}

GEOM = '<geom size=".1"/>'
INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
# A parallelogram.
FOUR_BAR = """<mujoco model="four_bar">{head}<worldbody>
<body name="crank"><joint name="j1" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 0 1 0" size=".05"/>
 <body name="coupler" pos="0 1 0"><joint name="j2" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 2 0 0" size=".05"/><site name="s" pos="2 0 0"/>
 </body></body>
<body name="rocker" pos="2 0 0"><joint name="j3" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 0 1 0" size=".05"/><site name="t" pos="0 1 0"/></body>
</worldbody>{tail}</mujoco>"""
CONNECT = (
    '<equality><connect name="k" body1="coupler" body2="rocker" anchor="2 0 0"/></equality>'
)


def four_bar(head="", tail=CONNECT):
    """The four-bar linkage with sections before and after its bodies."""
    return FOUR_BAR.format(head=head, tail=tail)


def of(text):
    """A text as a document from a stream."""
    return Document("model", text.encode())


def world(inside, more=""):
    """A file with bodies, and sections before them."""
    return f"<mujoco>{more}<worldbody>{inside}</worldbody></mujoco>"


class Unwritable(Exception):
    """MJCF has no such joint, loop or body."""


class Moved(NamedTuple):
    """A joint above a body: its name, type, point and axis in the frame of the body."""

    name: str
    kind: str
    point: np.ndarray
    axis: np.ndarray


def words(values) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))


def floats(item, attribute, default="0 0 0"):
    text = default if item is None else item.get(attribute, default)
    return np.array([float(word) for word in text.split()])


def pose(item):
    """Rotation and position of the ``<origin>`` of an element."""
    origin = None if item is None else item.find("origin")
    return Rotation.from_euler("xyz", floats(origin, "rpy")), floats(origin, "xyz")


def mjcf_text(urdf: str, style: str) -> str:
    """Write a URDF file as MJCF.

    Args:
        urdf: its text.
        style: one of `STYLES`.
    """
    return _Writer(ElementTree.fromstring(urdf), style).text()


class _Writer:
    def __init__(self, robot, style):
        self.robot, self.style = robot, style
        self.links = {link.get("name"): link for link in robot.findall("link")}
        self.below = {}
        for joint in robot.findall("joint"):
            self.below.setdefault(joint.find("parent").get("link"), []).append(joint)
        carried = {joint.find("child").get("link") for joint in robot.findall("joint")}
        (self.base,) = set(self.links) - carried
        # Body and place in it of each link, since some links are no bodies.
        self.place = {self.base: ("world", Rotation.identity(), np.zeros(3))}

    def text(self):
        root = ElementTree.Element("mujoco", model=self.robot.get("name"))
        angle = "degree" if self.style == "degrees" else "radian"
        ElementTree.SubElement(root, "compiler", angle=angle, eulerseq="XYZ")
        if self.style == "classes":
            outer = ElementTree.SubElement(root, "default")
            ElementTree.SubElement(outer, "joint", type="slide", axis="1 0 0")
            inner = ElementTree.SubElement(outer, "default", {"class": "turning"})
            ElementTree.SubElement(inner, "joint", type="hinge", axis="0 0 1")
        world = ElementTree.SubElement(root, "worldbody")
        self.children(self.base, world)
        equality = ElementTree.SubElement(root, "equality")
        for loop in self.robot.findall("loop"):
            self.loop(loop, equality)
        return ElementTree.tostring(root, encoding="unicode")

    def children(self, link, holder):
        for joint in self.below.get(link, []):
            self.carry(joint, holder)

    def carry(self, joint, holder):
        """Write the body above which a joint is, with the joints of massless links."""
        turn, at = pose(joint)
        moved, passed = [], []
        while True:
            name = joint.find("child").get("link")
            if joint.find("screw_thread_pitch") is not None or joint.find("mimic") is not None:
                raise Unwritable(joint.get("name"))
            kind = TYPES.get(joint.get("type"))
            if kind is None:
                raise Unwritable(joint.get("type"))
            axis = floats(joint.find("axis"), "xyz", "1 0 0")
            moved.append(Moved(joint.get("name"), kind, np.zeros(3), axis))
            passed.append((name, Rotation.identity(), np.zeros(3)))
            if self.links[name].find("inertial") is not None:
                break
            if len(self.below.get(name, [])) != 1:
                raise Unwritable(f"massless link {name}")
            (joint,) = self.below[name]
            R, d = pose(joint)
            back = R.inv()
            moved = [
                m._replace(point=back.apply(m.point - d), axis=back.apply(m.axis))
                if R.magnitude() or d.any()
                else m
                for m in moved
            ]
            passed = [(link, back * Q, back.apply(p - d)) for link, Q, p in passed]
            at, turn = at + turn.apply(d) if d.any() else at, turn * R
        for link, Q, p in passed:
            self.place[link] = (name, Q, p)
        self.body(name, moved, turn, at, holder)

    def body(self, name, moved, turn, at, holder):
        if self.style == "frames":
            holder = ElementTree.SubElement(holder, "frame", pos=words(at))
            at = np.zeros(3)
        body = ElementTree.SubElement(holder, "body", name=name)
        if at.any():
            body.set("pos", words(at))
        self.orient(body, turn)
        for m in moved:
            item = ElementTree.SubElement(body, "joint", name=m.name)
            if m.point.any():
                item.set("pos", words(m.point))
            if self.style == "classes" and m.kind == "hinge":
                item.set("class", "turning")
                if np.array_equal(m.axis, [0.0, 0.0, 1.0]):
                    continue
            item.set("type", m.kind)
            item.set("axis", words(m.axis))
        self.inertia(body, self.links[name].find("inertial"))
        self.children(name, body)

    def orient(self, item, turn):
        """Write a rotation in the manner of the style."""
        if not turn.magnitude():
            return
        if self.style == "degrees":
            item.set("euler", words(turn.as_euler("xyz", degrees=True)))
        elif self.style == "classes":
            vector = turn.as_rotvec()
            angle = np.linalg.norm(vector)
            item.set("axisangle", words([*(vector / angle), angle]))
        elif self.style == "frames":
            R = turn.as_matrix()
            item.set("xyaxes", words([R[:, 0], R[:, 1]]))
        else:
            item.set("quat", words(np.roll(turn.as_quat(), 1)))

    def inertia(self, body, inertial):
        turn, centre = pose(inertial)
        (mass,) = floats(inertial.find("mass"), "value")
        at = inertial.find("inertia")
        xx, yy, zz, xy, xz, yz = (
            float(at.get(key, "0")) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        )
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        tensor = turn.as_matrix() @ tensor @ turn.as_matrix().T
        if self.style in ("degrees", "classes", "frames"):
            full = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            ElementTree.SubElement(
                body, "inertial", pos=words(centre), mass=words(mass), fullinertia=words(full)
            )
            return
        moments, axes = np.linalg.eigh(tensor)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        quat = words(np.roll(Rotation.from_matrix(axes).as_quat(), 1))
        place = {"pos": words(centre), "quat": quat, "mass": words(mass)}
        if self.style == "quats":
            ElementTree.SubElement(body, "inertial", place, diaginertia=words(moments))
            return
        squares = 2.5 / mass * (moments.sum() - 2 * moments)
        if squares.min() <= 1e-9 * squares.max():
            raise Unwritable("a flat ellipsoid")
        ElementTree.SubElement(
            body, "geom", place, type="ellipsoid", size=words(np.sqrt(squares))
        )

    def loop(self, loop, equality):
        sides = []
        for role in ("predecessor", "successor"):
            side = loop.find(role)
            body, Q, p = self.place[side.get("link")]
            R, d = pose(side)
            sides.append((body, Q * R, p + Q.apply(d) if Q.magnitude() else p + d))
        (one, R, point), (other, *_) = sides
        points = {"spherical": [point], "revolute": [point]}.get(loop.get("type"))
        if points is None:
            raise Unwritable(f"{loop.get('type')} loop")
        if loop.get("type") == "revolute":
            axis = floats(loop.find("axis"), "xyz", "1 0 0")
            points.append(point + R.apply(axis / np.abs(axis).max()))
        for k, anchor in enumerate(points):
            name = loop.get("name") + "_b" * k
            ElementTree.SubElement(
                equality, "connect", name=name, body1=one, body2=other, anchor=words(anchor)
            )


def random_tree(seed: int, balls: bool = True) -> str:
    """A tree of 5 bodies with hinges, slides and balls, several on some bodies."""
    rng = random.Random(seed)

    def numbers(count, least=-1.0):
        return " ".join(f"{rng.uniform(least, 1.0):.3f}" for _ in range(count))

    root = ElementTree.Element("mujoco", model="tree")
    ElementTree.SubElement(root, "compiler", angle="radian")
    holders = [ElementTree.SubElement(root, "worldbody")]
    for k in range(5):
        body = ElementTree.SubElement(
            rng.choice(holders), "body", pos=numbers(3), quat=numbers(4)
        )
        holders.append(body)
        kinds = rng.choice(
            (
                ["hinge"],
                ["slide"],
                ["hinge", "slide"],
                ["slide", "hinge"],
                ["ball"],
                ["hinge", "hinge"],
                ["slide", "ball"],
            )
        )
        for kind in kinds:
            if kind == "ball" and not balls:
                kind = "hinge"
            joint = ElementTree.SubElement(body, "joint", type=kind)
            if rng.random() < 0.7:
                joint.set("pos", numbers(3))
            if kind != "ball":
                joint.set("axis", numbers(3))
                joint.set("ref", numbers(1))
            if rng.random() < 0.7:
                joint.set("name", f"j{k}{kind}{len(body)}")
        if rng.random() < 0.5:
            size = numbers(3, 0.1)
            ElementTree.SubElement(body, "geom", type="box", size=size, pos=numbers(3))
        else:
            ElementTree.SubElement(
                body,
                "inertial",
                pos=numbers(3),
                quat=numbers(4),
                mass=numbers(1, 0.1),
                diaginertia="0.3 0.4 0.5",
            )
    return ElementTree.tostring(root, encoding="unicode")
