"""Check single elements of a URDF file: types, numbers, origins, axes and inertias.

Other readers accept ``nan``, ``2,5``, an axis of zero length or an inertia without entries, or
replace them by defaults of their own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from operator import mul

from kinematics.error_text import clean
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM
from kinematics.numerics.tolerances import AXES_PERPENDICULAR_COSINE

# Largest number: products of numbers up to it stay in the range of floating point.
MAX_NUMBER = 1e30
# Least length of an axis: its square stays in the range of floating point.
SMALLEST_AXIS = 1e-100
# Largest angle, rad: beyond it the digits that determine the direction are lost.
MAX_ANGLE = 1e4

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_TURNING = ("revolute", "continuous")


def rotates(joint: Element) -> bool:
    """Whether the position of a joint of one degree of freedom is an angle."""
    return joint.attributes["type"] in _TURNING


def check_only(owner: Element, tag: str, inside: Element | None = None) -> Element | None:
    """Return the only child with a tag, if there is one.

    Args:
        tag: tag of the child.
        inside: element with the child; ``owner`` by default.

    Raises:
        Refusal: there are two.
    """
    children = (inside or owner).every(tag)
    if len(children) > 1:
        problem = f"more than one <{tag}> (line {children[1].line})"
        raise Refusal(owner.label, problem, "keep one of them")
    return children[0] if children else None


def check_needed(owner: Element, tag: str, attribute: str) -> str:
    """Return an attribute of the only child with a tag.

    Args:
        owner: element with the child.
        tag: tag of the child.
        attribute: name of the attribute.

    Raises:
        Refusal: there is no such child or attribute, or there are two such children.
    """
    item = check_only(owner, tag)
    value = item.attributes.get(attribute) if item else None
    if value is None:
        example = f'<{tag} {attribute}="…"/>'
        raise Refusal(owner.label, f"no {example}", f"add {example}")
    return value


def are_numbers(text: str, count: int) -> bool:
    """Return whether a text is a number of finite decimals.

    Args:
        count: how many numbers it must hold.
    """
    words = text.split()
    good = all(_NUMBER.fullmatch(w) and abs(float(w)) <= MAX_NUMBER for w in words)
    return len(words) == count and good


def check_numbers(owner: Element, item: Element, attribute: str, count: int) -> None:
    """Check that an attribute, if present, holds finite decimal numbers.

    Args:
        item: element with the attribute.
        attribute: name of the attribute.
        count: how many numbers it must hold.

    Raises:
        Refusal: it holds another count, or other text.
    """
    text = item.attributes.get(attribute)
    if text is None:
        return
    if not are_numbers(text, count):
        what = f"{count} finite numbers" if count > 1 else "a finite number"
        where = f'<{item.tag} {attribute}="{clean(text)}"> (line {item.line})'
        example = f'{attribute}="{" ".join(["0.5", "0", "-1e-3"][:count])}"'
        raise Refusal(owner.label, f"{where} is not {what}", f"write it as in {example}")


def check_origin(owner: Element, inside: Element) -> None:
    """Check that the ``<origin>`` inside an element, if any, holds three and three numbers.

    Args:
        inside: element with the ``<origin>``.

    Raises:
        Refusal: there are two, or a number is missing or out of range, or there is a
            quaternion.
    """
    origin = check_only(owner, "origin", inside)
    if origin is None:
        return
    for attribute in origin.attributes:
        if attribute.startswith("quat"):
            problem = f"<origin {attribute}> (line {origin.line}) is not supported"
            raise Refusal(owner.label, problem, "write the rotation as rpy")
    check_numbers(owner, origin, "xyz", 3)
    check_numbers(owner, origin, "rpy", 3)
    if max(map(abs, origin.vector("rpy", "0 0 0"))) > MAX_ANGLE:
        where = f'<origin rpy="{clean(origin.attributes["rpy"])}"> (line {origin.line})'
        problem = f"{where} has an angle beyond {MAX_ANGLE:g} rad"
        raise Refusal(owner.label, problem, "write angles in radians, between -π and π")


def _check_axis(owner: Element, tag: str) -> None:
    """Check that an axis, if any, is a direction."""
    axis = check_only(owner, tag)
    if axis is None:
        return
    check_needed(owner, tag, "xyz")
    check_numbers(owner, axis, "xyz", 3)
    fixed = owner.attributes.get("type") == "fixed"
    if not fixed and math.hypot(*axis.vector("xyz", "")) < SMALLEST_AXIS:
        remedy = 'give it a direction, such as xyz="0 0 1"'
        raise Refusal(owner.label, f"<{tag}> (line {axis.line}) is zero", remedy)


def check_link(link: Element) -> None:
    """Check that the ``<inertial>`` of a link, if any and not empty, has all its numbers."""
    inertial = check_only(link, "inertial")
    if inertial is None or not inertial.children:
        return
    check_origin(link, inertial)
    _check_inertial(link, inertial, "mass", ["value"])
    _check_inertial(link, inertial, "inertia", ["ixx", "iyy", "izz"], ["ixy", "ixz", "iyz"])


def _check_inertial(
    link: Element,
    inertial: Element,
    tag: str,
    needed: Sequence[str],
    optional: Sequence[str] = (),
) -> None:
    """Check that a part of an ``<inertial>`` has its numbers; other readers use defaults."""
    item = check_only(link, tag, inertial)
    missing = [name for name in needed if item is None or name not in item.attributes]
    if item is None or missing:
        problem = f'<inertial> (line {inertial.line}) has no <{tag} {missing[0]}="…">'
        raise Refusal(link.label, problem, "add it, or remove the <inertial>")
    for attribute in (*needed, *optional):
        check_numbers(link, item, attribute, 1)


def check_type(item: Element) -> None:
    """Check type, origin, axes and pitch of a joint, or type and axes of a loop."""
    kind = item.attributes.get("type", "")
    if kind not in DEGREES_OF_FREEDOM:
        problem = f"unknown type '{clean(kind)}'" if kind else "no type"
        remedy = f"choose from {', '.join(DEGREES_OF_FREEDOM)}"
        if kind.strip().lower() in DEGREES_OF_FREEDOM:
            remedy = f'write type="{kind.strip().lower()}"'
        raise Refusal(item.label, problem, remedy)
    if item.tag == "loop" and kind == "floating":
        remedy = "remove it, or choose another type"
        raise Refusal(item.label, "a floating joint closes no loop", remedy)
    value = item.attributes.get("independent", "false")
    if value not in ("true", "false"):
        problem = f'independent="{clean(value)}" is neither true nor false'
        raise Refusal(item.label, problem, 'write independent="true" on an input')
    for tag in ("axis", "axis2"):
        _check_axis(item, tag)
    if kind != "universal" and item.first("axis2"):
        raise Refusal(item.label, f"<axis2> on a {kind} {item.tag}", "remove <axis2>")
    if item.tag == "joint":
        check_origin(item, item)
        _check_second_axis(item)
        _check_pitch(item, kind)


def _check_second_axis(joint: Element) -> None:
    """Check that the second axis of a universal joint is perpendicular to the first."""
    first, second = joint.first("axis"), joint.first("axis2")
    if second is not None:
        a = first.vector("xyz", "") if first else [1.0, 0.0, 0.0]
        b = second.vector("xyz", "")
        size = math.hypot(*a) * math.hypot(*b)
        if abs(sum(map(mul, a, b))) > AXES_PERPENDICULAR_COSINE * size:
            problem = f"<axis2> (line {second.line}) is not perpendicular to the axis"
            raise Refusal(joint.label, problem, "correct it, or use two revolute joints")


def _check_pitch(joint: Element, kind: str) -> None:
    """Check the pitch of a screw joint, if any."""
    pitch = check_only(joint, "screw_thread_pitch")
    if pitch is not None:
        if kind not in _TURNING:
            problem = f"<screw_thread_pitch> on a {kind} joint"
            raise Refusal(joint.label, problem, 'use type="revolute" for a screw joint')
        check_needed(joint, "screw_thread_pitch", "value")
        check_numbers(joint, pitch, "value", 1)
