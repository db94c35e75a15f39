"""Read texts, numbers, flags and poses of SDF elements, in which values are texts."""

from __future__ import annotations

import math
from fractions import Fraction

from kinematics.error_text import clean
from kinematics.files.formats.sdf.steps import Shift, Steps, Turn, simplify, to_decimal
from kinematics.files.urdf.validate_fields import MAX_ANGLE, check_numbers, check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element
from kinematics.numerics.linalg.rational import pi

_FLAGS = {"true": True, "1": True, "false": False, "0": False}
# Least length of a quaternion: that of a shorter one is not that of a rotation.
MIN_QUATERNION = 1e-6


def needed_text(owner: Element, tag: str) -> str:
    """Return the text of the only child with a tag.

    Args:
        owner: element with the child.
        tag: tag of the child.

    Raises:
        Refusal: there is no such child, it is empty, or there are two.
    """
    item = check_only(owner, tag)
    if item is None or not item.text:
        example = f"<{tag}>…</{tag}>"
        raise Refusal(owner.label, f"no {example}", f"add {example}")
    return item.text


def is_true(owner: Element, item: Element | None, attribute: str = "") -> bool:
    """Read a flag in the text of an element, or in an attribute; false if it is missing.

    Args:
        item: the element, if there is one.
        attribute: name of the attribute; the text by default.

    Raises:
        Refusal: it is another word.
    """
    if item is None:
        return False
    word = item.attributes.get(attribute, "false") if attribute else item.text
    if word.strip().lower() not in _FLAGS:
        what = f"{attribute}=" if attribute else ""
        problem = f"<{item.tag}> (line {item.line}): {what}'{clean(word)}' is no flag"
        raise Refusal(owner.label, problem, "write true or false")
    return _FLAGS[word.strip().lower()]


def number_texts(owner: Element, item: Element, count: int) -> list[str]:
    """Return the numbers in the text of an element, as they are written.

    Args:
        count: how many numbers it must hold.

    Raises:
        Refusal: it holds another count, or other text.
    """
    try:
        check_numbers(owner, Element(item.tag, {"text": item.text}), "text", count)
    except Refusal:
        what = f"{count} finite numbers" if count > 1 else "a finite number"
        where = f"<{item.tag}>{clean(item.text)}</{item.tag}> (line {item.line})"
        example = " ".join(["0.5", "0", "-1e-3", *["0"] * count][:count])
        remedy = f"write it as in <{item.tag}>{example}</{item.tag}>"
        raise Refusal(owner.label, f"{where} is not {what}", remedy) from None
    return item.text.split()


def pose_steps(owner: Element, pose: Element | None) -> Steps:
    """Read a ``<pose>``: three lengths, and angles or a quaternion; zero if it is empty.

    Args:
        pose: the element, if there is one.

    Raises:
        Refusal: it holds other text, or angles out of range.
    """
    if pose is None or not pose.text:
        return ()
    form = pose.attributes.get("rotation_format", "euler_rpy")
    if form not in ("euler_rpy", "quat_xyzw"):
        problem = f"<pose> (line {pose.line}): unknown rotation_format '{clean(form)}'"
        raise Refusal(owner.label, problem, "write euler_rpy or quat_xyzw")
    degrees = is_true(owner, pose, "degrees")
    words = number_texts(owner, pose, 6 if form == "euler_rpy" else 7)
    x, y, z = map(to_decimal, words[:3])
    if form == "quat_xyzw":
        angles = _quaternion_angles(owner, pose, list(map(float, words[3:])))
    else:
        angles = list(map(_radians, words[3:])) if degrees else words[3:]
    if max(abs(float(angle)) for angle in angles) > MAX_ANGLE:
        problem = f"<pose> (line {pose.line}) has an angle beyond {MAX_ANGLE:g} rad"
        raise Refusal(owner.label, problem, "write angles between -π and π")
    turns = [Turn(axis, to_decimal(angles[axis])) for axis in (2, 1, 0)]
    return simplify([Shift((x, y, z)), *turns])


def _radians(word: str) -> str:
    """Convert degrees to all digits of an angle in radians."""
    return repr(float(Fraction(to_decimal(word)) * pi() / 180))


def _quaternion_angles(owner: Element, pose: Element, q: list[float]) -> list[str]:
    """Convert a quaternion (x, y, z, w) of any length to roll, pitch and yaw."""
    size = math.hypot(*q)
    if size < MIN_QUATERNION:
        problem = f"<pose> (line {pose.line}) has a quaternion of length {size:.3g}"
        raise Refusal(owner.label, problem, "give one of length 1: x y z w")
    x, y, z, w = (value / size for value in q)
    from numpy import array

    from kinematics.model.document.write_numbers import roll_pitch_yaw

    R = array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return [repr(angle) for angle in roll_pitch_yaw(R)]
