"""Find and replace rounded angles of a URDF file, such as 1.5708 for π/2.

Read as written, a rounded right angle tilts axes by 3.7e-6 rad: a planar loop no longer
closes, and a planar chain has the conditions of a spatial one. A number that stands for a
multiple of π/12 by the rules of `kinematics.files.urdf.nominal_angles` is therefore replaced by
it, unless the user chooses ``as_written``; a remark names it in either case.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from kinematics.error_text import clean
from kinematics.files.urdf.nominal_angles import nearest_twelfth
from kinematics.model.document.element import Element
from kinematics.numerics.linalg.rational import count_digits, pi
from kinematics.numerics.tolerances import ANGLE_ROUND_OFF

ANGLE_READINGS = ("nominal", "as_written")
"""The interpretations of an angle that looks rounded."""
ROUNDED_ANGLES = "rounded_angles"
"""The code of the remark on such angles."""

# Digits to which the angles of a file may be rounded, fewest and most: those of a double are
# more, and those of a person fewer.
ROUNDED_DIGITS = 6, 12
# Fewest angles that show it.
GENERAL_ANGLES = 3
# Code of the notice on angles that make sense in degrees alone.
DEGREES = "angles_in_degrees"
# Radians above which an angle is more than a turn.
MORE_THAN_A_TURN = 6.4
# Number of angles that a remark names.
MAX_NAMED = 3

_TWELFTH = math.pi / 12
_TURNING = ("revolute", "continuous")


class Rounded(NamedTuple):
    """An angle that looks rounded.

    Attributes:
        label: its element, such as ``joint 'j1' (line 12)``.
        attribute: ``"rpy"``, or ``"offset"`` of a mimic joint.
        word: the number as written.
    """

    label: str
    attribute: str
    word: str


def find_rounded_angles(tree: Element) -> list[Rounded]:
    """Find the angles of a file that are rounded by more than round-off.

    Args:
        tree: checked tree of the file.
    """
    digits = _digits_of_angles(tree)
    return [
        Rounded(owner.label, attribute, word)
        for owner, item, attribute in _angle_attributes(tree)
        for word in item.attributes[attribute].split()
        if (k := nearest_twelfth(word, digits))
        and abs(float(word) - k * _TWELFTH) > ANGLE_ROUND_OFF
    ]


def replace_rounded_angles(tree: Element) -> Element:
    """Replace angles that look like rounded multiples of π/12 by all digits of the multiple."""
    new, digits = dict[int, Element](), _digits_of_angles(tree)
    for _, item, attribute in _angle_attributes(tree):
        words = item.attributes[attribute].split()
        full = [
            _all_digits(k) if (k := nearest_twelfth(word, digits)) else word for word in words
        ]
        if full != words:
            new[id(item)] = replace(
                item, attributes={**item.attributes, attribute: " ".join(full)}
            )
    return _replace_elements(tree, new) if new else tree


def note_rounded_angles(
    source: str, rounded: Sequence[Rounded], reading: str
) -> tuple[str, str, str]:
    """Compose the remark on the angles that look rounded.

    Args:
        source: the file.
        rounded: angles that look rounded.
        reading: one of `ANGLE_READINGS`.

    Returns:
        Code, message and names of a `kinematics.model.linkage.Notice`. The message tells
        number, interpretation and names of the angles, and the alternative.
    """
    named = ", ".join(
        f"{clean(r.word)} in {r.attribute} of {r.label}" for r in rounded[:MAX_NAMED]
    )
    if len(rounded) > MAX_NAMED:
        named += f" and {len(rounded) - MAX_NAMED} more"
    look = "angle looks" if len(rounded) == 1 else "angles look"
    how = "read as multiples of π/12, the default"
    choice = "--as-written (angles='as_written')"
    if reading != "nominal":
        how, choice = "taken as written", "--nominal (angles='nominal')"
    text = (
        f"{source}: {len(rounded)} {look} rounded, {how}: {named}; write all 16 digits, or "
        f"choose {choice}"
    )
    return ROUNDED_ANGLES, text, named


def describe_degrees(tree: Element) -> str:
    """Compose the remark on angles of more than a turn, which are degrees by mistake.

    Args:
        tree: checked tree of the file.

    Returns:
        The angles and the remedy; empty if there are none.
    """
    named = [
        f"{clean(item.attributes['rpy'])} in rpy of {owner.label}"
        for owner, item, attribute in _angle_attributes(tree)
        if attribute == "rpy"
        and any(abs(float(word)) > MORE_THAN_A_TURN for word in item.attributes["rpy"].split())
    ]
    if not named:
        return ""
    more = f" and {len(named) - MAX_NAMED} more" if len(named) > MAX_NAMED else ""
    return (
        f"angles of more than a turn, read in radians: {', '.join(named[:MAX_NAMED])}{more}; "
        "if they are degrees, multiply them by π/180 (90 is 1.5707963267948966)"
    )


def _digits_of_angles(tree: Element) -> int:
    """Find the significant digits to which all angles of a file are rounded; 0 if to none.

    Most of the angles must have them all, and be no multiples of π/12.
    """
    texts = (item.attributes[name] for _, item, name in _angle_attributes(tree))
    words = [word for text in texts for word in text.split() if float(word)]
    counts = [count_digits(word)[1] for word in words]
    digits = max(counts, default=0)
    if not ROUNDED_DIGITS[0] <= digits <= ROUNDED_DIGITS[1]:
        return 0
    general = sum(
        count >= digits - 1 and not nearest_twelfth(word)
        for word, count in zip(words, counts, strict=True)
    )
    return digits if general >= GENERAL_ANGLES and 2 * general > len(words) else 0


def _all_digits(k: int) -> str:
    """Write the double nearest to ``k π/12``, to all its digits."""
    return repr(float(k * pi() / 12))


def _angle_attributes(tree: Element) -> Iterator[tuple[Element, Element, str]]:
    """Attributes with angles: the joint, link or loop, the element and the attribute."""
    for owner in tree.children:
        inside = [owner]
        if owner.tag == "link":
            inside = owner.every("inertial")
        elif owner.tag == "loop":
            inside = owner.every("predecessor") + owner.every("successor")
        elif owner.tag != "joint":
            continue
        for item in (origin for part in inside for origin in part.every("origin")):
            if "rpy" in item.attributes:
                yield owner, item, "rpy"
        mimic = owner.first("mimic")
        if mimic and owner.attributes.get("type") in _TURNING and "offset" in mimic.attributes:
            yield owner, mimic, "offset"


def _replace_elements(element: Element, new: Mapping[int, Element], depth: int = 3) -> Element:
    """Replace elements inside an element by others, by their identity."""
    if id(element) in new or not depth:
        return new.get(id(element), element)
    children = tuple(_replace_elements(child, new, depth - 1) for child in element.children)
    return replace(element, children=children)
