"""Topologies whose numbers are varied, and files into which the numbers are written.

Each number of a topology is ``nominal + size v`` with v uniform in [-1, 1]; in one row of
fifty, where s = 1, it is an expression that makes the geometry special.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

import balance
import kinematics
from kinematics.model.document.element import Document

AXES = "xyz"
ANGLES = ("roll", "pitch", "yaw")


class Topology(NamedTuple):
    """A model, and what varies in it.

    Attributes:
        text: its URDF file.
        numbers: of each path, the nominal value, the size of its variation, and the expression
            in special geometries (the nominal value if empty).
        special_rank: rank of the special geometries; None if it is not known beforehand.
    """

    text: str
    numbers: Mapping[str, tuple[float, float, str]]
    special_rank: int | None = None

    def sweep(self, rows: int, seed: int, **options) -> balance.SweepTable:
        """Compute about that many geometries, one of fifty of them special."""
        parameters: dict[str, object] = {"s": [0] * 49 + [1]}
        relations = {}
        for k, (path, (value, size, special)) in enumerate(self.numbers.items()):
            parameters[f"v{k}"] = {"uniform": [-1.0, 1.0]}
            relations[path] = f"(1-s)*({value!r} + {size!r}*v{k}) + s*({special or value})"
        linkage = kinematics.load(Document("model", self.text.encode()))
        return balance.sweep(
            linkage,
            parameters,
            relations=relations,
            samples=max(1, rows // 50),
            seed=seed,
            **options,
        )

    def linkage(self, table: balance.SweepTable, row: int) -> kinematics.Linkage:
        """Read the file into which the numbers of a row are written."""
        values = {path: float(table[path][row]) for path in self.numbers}
        return kinematics.load(Document("written", write_numbers(self.text, values).encode()))


def write_numbers(text: str, values: Mapping[str, float]) -> str:
    """Write numbers into a URDF file, by paths: lengths last."""
    robot = ElementTree.fromstring(text)
    for path in sorted(values, key=lambda path: path.endswith(".length")):
        name, *fields = path.split(".")
        if fields == ["length"]:
            _lengthen(robot, name, values[path])
            continue
        owner = next(x for x in robot if x.get("name") == name and x.tag in ("joint", "loop"))
        part = owner.find(fields[0]) if len(fields) == 3 else owner
        assert part is not None
        origin, kind = part.find("origin"), "xyz" if fields[-1] in AXES else "rpy"
        assert origin is not None
        words = origin.get(kind, "0 0 0").split()
        place = AXES.index(fields[-1]) if kind == "xyz" else ANGLES.index(fields[-1])
        words[place] = repr(values[path])
        origin.set(kind, " ".join(words))
    return ElementTree.tostring(robot, encoding="unicode")


def _lengthen(robot: ElementTree.Element, link: str, length: float) -> None:
    """Put the only further joint of a link at a distance from its frame."""
    joints = [
        x
        for x in robot.iter("joint")
        if (parent := x.find("parent")) is not None and parent.get("link") == link
    ]
    sides = [
        x
        for loop in robot.iter("loop")
        for x in loop
        if x.tag in ("predecessor", "successor") and x.get("link") == link
    ]
    first, *others = [part.find("origin") for part in (*joints, *sides)]
    far = first if not others else others[0]
    start = np.zeros(3) if not others else _vector(first)
    span = _vector(far) - start
    moved = start + span * (length / np.linalg.norm(span))
    far.set("xyz", " ".join(map(repr, moved.tolist())))


def _vector(origin: ElementTree.Element) -> np.ndarray:
    return np.array([float(word) for word in origin.get("xyz", "0 0 0").split()])


def gallery_text(name: str) -> str:
    """Read the file of a model of the gallery, without its comments."""
    text = kinematics.gallery()[name].read_text(encoding="utf-8")
    return re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)


def _four_bars() -> dict[str, Topology]:
    anti = gallery_text("four_bar_antiparallelogram")
    kite = gallery_text("four_bar_kite")
    return {
        "four-bar": Topology(
            gallery_text("four_bar_general"),
            {
                "q2.origin.x": (0.1, 0.05, "0.1 + 0.05*v0"),
                "q2.origin.y": (0.3, 0.05, "0.3 + 0.05*v1"),
                "q4.origin.x": (1.1, 0.1, "1.1 + 0.1*v2"),
                "q3.predecessor.origin.x": (0.8, 0.1, "1.1 + 0.1*v2"),
                "q3.predecessor.origin.y": (0.4, 0.1, "0"),
                "q3.successor.origin.x": (-0.2, 0.1, "0.1 + 0.05*v0"),
                "q3.successor.origin.y": (0.7, 0.1, "0.3 + 0.05*v1"),
            },
            5,
        ),
        "kite": Topology(
            kite,
            {
                "crank.length": (0.67, 0.05, "0.67 + 0.05*v0"),
                "coupler.length": (0.69, 0.05, "0.67 + 0.05*v0"),
                "q4.origin.x": (1.0, 0.05, "1 + 0.05*v2"),
                "rocker.length": (1.02, 0.05, "1 + 0.05*v2"),
            },
            7,
        ),
        "antiparallelogram": Topology(
            anti,
            {
                "crank.length": (0.5, 0.05, "0.5 + 0.05*v0"),
                "rocker.length": (0.52, 0.05, "0.5 + 0.05*v0"),
                "q4.origin.x": (1.0, 0.05, "1 + 0.05*v2"),
                "coupler.length": (1.02, 0.05, "1 + 0.05*v2"),
            },
            7,
        ),
    }


def _planar() -> dict[str, Topology]:
    five = {"left_lower": 0.63, "left_upper": 0.86, "right_lower": 0.5, "right_upper": 0.92}
    legs = {
        "b1.origin.x": (0.1, 0.1, "0.1 + 0.1*v0"),
        "b1.origin.y": (0.5, 0.1, "0.5 + 0.1*v1"),
        "c1.origin.x": (1.2, 0.1, "1.2 + 0.1*v2"),
        "c1.origin.y": (-0.1, 0.1, "-0.1 + 0.1*v3"),
        "a2.origin.x": (0.8, 0.1, ""),
        "b3.origin.y": (0.4, 0.1, ""),
        "a4.origin.x": (-0.7, 0.1, ""),
        "b4.origin.x": (1.0, 0.1, ""),
        "c3.successor.origin.x": (-0.8, 0.1, ""),
    }
    watt = {
        "a.origin.x": (0.2, 0.05, "0.2 + 0.05*v0"),
        "a.origin.y": (0.5, 0.05, "0.5 + 0.05*v1"),
        "o4.origin.x": (1.1, 0.05, "1.1 + 0.05*v2"),
        "o4.origin.y": (-0.1, 0.05, "0"),
        "b.predecessor.origin.x": (0.7, 0.05, "1.1 + 0.05*v2"),
        "b.predecessor.origin.y": (0.3, 0.05, "0"),
        "b.successor.origin.x": (-0.2, 0.05, "0.2 + 0.05*v0"),
        "b.successor.origin.y": (0.9, 0.05, "0.5 + 0.05*v1"),
        "c.origin.y": (0.8, 0.05, ""),
    }
    stephenson = dict(watt) | {
        "c.origin.y": (0.9, 0.05, ""),
        "b.predecessor.origin.x": (0.8, 0.05, "1.1 + 0.05*v2"),
        "b.predecessor.origin.y": (0.4, 0.05, "0"),
        "b.successor.origin.x": (-0.1, 0.05, "0.2 + 0.05*v0"),
        "b.successor.origin.y": (1.0, 0.05, "0.5 + 0.05*v1"),
    }
    return {
        "slider-crank": Topology(
            gallery_text("slider_crank"),
            {
                "crank.length": (0.5, 0.1, "0.5 + 0.1*v0"),
                "coupler.length": (0.55, 0.1, "0.5 + 0.1*v0"),
                "q4.origin.y": (0.02, 0.02, "0"),
            },
            6,
        ),
        "5R": Topology(
            gallery_text("five_bar"),
            {f"{link}.length": (size, 0.05, "0.75 + 0.05*v0") for link, size in five.items()}
            | {"u2.origin.y": (0.1, 0.1, "0")},
        ),
        "4-RRR": Topology(gallery_text("four_rrr"), legs),
        "Watt": Topology(gallery_text("six_bar_watt"), watt),
        "Stephenson": Topology(gallery_text("six_bar_stephenson"), stephenson),
    }


def bennett_text(angle: float) -> str:
    """Write the file of a Bennett linkage in Denavit-Hartenberg frames.

    Lengths 0.5 and 0.8, twists α and β with sin α / 0.5 = sin β / 0.8; a given crank angle.
    """
    a, b, alpha = 0.5, 0.8, 0.4
    beta = float(np.arcsin(b * np.sin(alpha) / a))
    mass = (
        '<inertial><origin xyz="0.1 0.05 0.03"/><mass value="1"/>'
        '<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    links = "".join(f'<link name="{x}">{mass}</link>' for x in ("crank", "coupler", "rocker"))
    # With θ2 from tan(θ1/2) tan(θ2/2) = sin((α+β)/2) / sin((β-α)/2); θ3 = -θ1, θ4 = -θ2.
    ratio = np.sin(0.5 * (alpha + beta)) / np.sin(0.5 * (beta - alpha))
    other = 2.0 * float(np.arctan(ratio / np.tan(0.5 * angle)))
    return f"""<robot name="bennett"><link name="base"/>{links}
    <link name="turned"/><link name="crank_end"/>
    <joint name="u1" type="continuous"><origin xyz="0 0 0" rpy="0 0 {angle!r}"/>
      <parent link="base"/><child link="crank"/><axis xyz="0 0 1"/></joint>
    <joint name="far" type="fixed"><origin xyz="{a} 0 0" rpy="{alpha!r} 0 0"/>
      <parent link="crank"/><child link="crank_end"/></joint>
    <joint name="q2" type="continuous"><origin xyz="0 0 0" rpy="0 0 {other!r}"/>
      <parent link="crank_end"/><child link="coupler"/><axis xyz="0 0 1"/></joint>
    <joint name="back" type="fixed"><origin xyz="{-b} 0 0" rpy="{-beta!r} 0 0"/>
      <parent link="base"/><child link="turned"/></joint>
    <joint name="q4" type="continuous"><origin xyz="0 0 0" rpy="0 0 {other!r}"/>
      <parent link="turned"/><child link="rocker"/><axis xyz="0 0 1"/></joint>
    <loop name="q3" type="revolute">
      <predecessor link="coupler"><origin xyz="{b} 0 0" rpy="{beta!r} 0 0"/></predecessor>
      <successor link="rocker"><origin xyz="{-a} 0 0" rpy="{-alpha!r} 0 0"/></successor>
      <axis xyz="0 0 1"/></loop></robot>"""


def topologies() -> dict[str, Topology]:
    """Give eight topologies and more, by name."""
    rsr = {
        "u1.origin.x": (3.0, 0.05, ""),
        "u2.origin.y": (2.59807621135331595, 0.05, ""),
        "elbow1_y.origin.x": (0.6, 0.05, ""),
        "platform1.origin.z": (0.8, 0.05, ""),
        "platform2.origin.x": (-4.5, 0.05, ""),
        "elbow2.predecessor.origin.z": (0.8, 0.05, ""),
        "elbow3.successor.origin.z": (-0.8, 0.05, ""),
    }
    gears = {
        "u2.origin.x": (0.6, 0.1, ""),
        "gear1.origin.x": (-0.3, 0.1, ""),
        "gear2.origin.y": (0.07, 0.05, ""),
    }
    a, b, alpha = "(0.5 + 0.05*v0)", "(0.8 + 0.05*v1)", "(0.4 + 0.05*v2)"
    beta = f"asin({b}*sin({alpha})/{a})"
    bennett = {
        "far.origin.x": (0.5, 0.05, a),
        "back.origin.x": (-0.8, 0.05, f"-{b}"),
        "far.origin.roll": (0.4, 0.05, alpha),
        "back.origin.roll": (-0.67, 0.05, f"-{beta}"),
        "q3.predecessor.origin.x": (0.8, 0.05, b),
        "q3.successor.origin.x": (-0.5, 0.05, f"-{a}"),
        "q3.predecessor.origin.roll": (0.67, 0.05, beta),
        "q3.successor.origin.roll": (-0.4, 0.05, f"-{alpha}"),
    }
    pendulum = gallery_text("double_pendulum_counter_rotary")
    return (
        _four_bars()
        | _planar()
        | {
            "Bennett": Topology(bennett_text(1.1), bennett, 13),
            "3-RSR": Topology(gallery_text("three_rsr"), rsr, 43),
            "gears": Topology(pendulum, gears),
        }
    )
