"""Make the elements of a URDF file from numbers.

Poses are those of a frame in that of the link that carries it; SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words, roll_pitch_yaw
from kinematics.numerics.array_types import Array

# Limits that other parsers require of a prismatic joint without limits.
_UNLIMITED = {"lower": "-1e9", "upper": "1e9", "effort": "0", "velocity": "0"}
_ENTRIES = {
    "ixx": (0, 0),
    "iyy": (1, 1),
    "izz": (2, 2),
    "ixy": (0, 1),
    "ixz": (0, 2),
    "iyz": (1, 2),
}


def robot(name: str, parts: Iterable[Element]) -> Element:
    """Make the ``<robot>`` with its links, joints and loops.

    Args:
        parts: its children, in order.
    """
    return Element("robot", {"name": name}, tuple(parts))


def origin(pose: Array) -> Element:
    """Make the ``<origin>`` of a pose (4, 4), in metres and radians."""
    angles = roll_pitch_yaw(pose[:3, :3])
    attributes = {"xyz": number_words(pose[:3, 3])}
    if any(angles):
        attributes["rpy"] = number_words(angles)
    return Element("origin", attributes)


def link(name: str, inertial: Element | None = None) -> Element:
    """Make a ``<link>``, with an ``<inertial>`` or without.

    Args:
        inertial: its ``<inertial>``, if it has mass.
    """
    return Element("link", {"name": name}, (inertial,) if inertial else ())


def inertial(mass: float, inertia: Array, at: Element) -> Element:
    """Make an ``<inertial>``.

    Args:
        mass: kg.
        inertia: tensor about the centre of mass (3, 3), kg m², along the axes of ``at``.
        at: ``<origin>`` of the centre of mass in the frame of the link.
    """
    entries = {name: number_words([inertia[at]]) for name, at in _ENTRIES.items()}
    parts = (at, Element("mass", {"value": number_words([mass])}), Element("inertia", entries))
    return Element("inertial", {}, parts)


def joint(
    name: str,
    kind: str,
    parent: str,
    child: str,
    at: Element,
    axes: tuple[str, str] = ("", ""),
    pitch: float = 0.0,
    mimic: tuple[str, float, float] | None = None,
    *,
    independent: bool = False,
) -> Element:
    """Make a ``<joint>``.

    Args:
        kind: its type in the file.
        parent: name of the link that carries it.
        child: name of the link that it carries.
        at: ``<origin>`` of the frame of ``child`` in that of ``parent``.
        axes: text of its axis in that frame, and of the second axis of a universal joint;
            empty if it has none.
        pitch: of a screw joint, metres per radian; the file has metres per revolution.
        mimic: name, multiplier and offset of the joint that it follows.
        independent: whether it is marked as an input.
    """
    sides = [Element("parent", {"link": parent}), Element("child", {"link": child})]
    parts = [at, *sides, *_axis_elements(axes)]
    if pitch:
        parts.append(
            Element("screw_thread_pitch", {"value": number_words([2 * np.pi * pitch])})
        )
    if mimic is not None:
        source, *numbers = mimic
        values = zip(("multiplier", "offset"), map(number_words, zip(numbers)), strict=True)
        parts.append(Element("mimic", {"joint": source, **dict(values)}))
    if kind == "prismatic":
        parts.append(Element("limit", _UNLIMITED))
    attributes = {"name": name, "type": kind, **_independent_mark(independent)}
    return Element("joint", attributes, tuple(parts))


def hinge(
    name: str,
    parent: str,
    child: str,
    at: Element,
    axis: str = "0 0 1",
    *,
    mimic: tuple[str, float, float] | None = None,
    independent: bool = False,
) -> Element:
    """Make a revolute joint without limits; see `joint`."""
    axes = axis, ""
    return joint(
        name, "continuous", parent, child, at, axes, mimic=mimic, independent=independent
    )


def loop(
    name: str,
    kind: str,
    sides: Sequence[tuple[str, Element | None]],
    axes: tuple[str, str] = ("", ""),
    *,
    independent: bool = False,
) -> Element:
    """Make a ``<loop>``.

    Args:
        kind: type of the joint that closes it.
        sides: predecessor and successor: name of a link, and ``<origin>`` of the frame of the
            loop in its frame.
        axes: text of its axis in the frame on the predecessor, and of its second axis in
            the frame on the successor; empty if it has none.
        independent: whether its coordinates are marked as inputs.
    """
    ends = [
        Element(role, {"link": end}, (at,) if at else ())
        for role, (end, at) in zip(("predecessor", "successor"), sides, strict=True)
    ]
    attributes = {"name": name, "type": kind, **_independent_mark(independent)}
    return Element("loop", attributes, (*ends, *_axis_elements(axes)))


def _axis_elements(axes: tuple[str, str]) -> list[Element]:
    pairs = zip(("axis", "axis2"), axes, strict=True)
    return [Element(tag, {"xyz": text}) for tag, text in pairs if text]


def _independent_mark(independent: bool) -> dict[str, str]:
    return {"independent": "true"} if independent else {}
