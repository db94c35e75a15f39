"""Replace the equality of a fixed tendon over two joints by that of the joints.

A fixed tendon has the length ``L = a q₁ + b q₂``. Its equality holds it at ``c`` beyond the
length at the reference pose, so that one joint follows the other:
``q₁ - q₁⁰ = c/a - (b/a)(q₂ - q₂⁰)``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from kinematics.files.urdf.validate_fields import are_numbers
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words

# Attributes that the equality of a tendon and that of joints share.
_SHARED = ("name", "class", "active")


def replace_tendons(root: Element) -> tuple[Element, frozenset[str]]:
    """Replace every equality of one fixed tendon over two joints.

    Args:
        root: the ``<mujoco>`` element, without includes.

    Returns:
        The element, and the names of the tendons that are read like this.
    """
    tendons = {
        item.name: item for section in root.every("tendon") for item in section.every("fixed")
    }
    used: set[str] = set()
    children = []
    for section in root.children:
        if section.tag == "equality":
            parts = tuple(_replaced(item, tendons, used) for item in section.children)
            section = replace(section, children=parts)
        children.append(section)
    return replace(root, children=tuple(children)), frozenset(used)


def _replaced(item: Element, tendons: Mapping[str, Element], used: set[str]) -> Element:
    """Return the equality of two joints, or the same element."""
    tendon = tendons.get(item.attributes.get("tendon1", ""))
    if item.tag != "tendon" or tendon is None or "tendon2" in item.attributes:
        return item
    joints = tendon.every("joint")
    words = [joint.attributes.get("coef", "") for joint in joints]
    given = item.attributes.get("polycoef", "0").split() or ["0"]
    if len(joints) != 2 or not all(are_numbers(word, 1) for word in (*words, given[0])):
        return item
    (a, b), c = map(float, words), float(given[0])
    names = [joint.attributes.get("joint", "") for joint in joints]
    if not a or not b or not all(math.isfinite(x) for x in (c / a, b / a)) or not all(names):
        return item
    used.add(tendon.name)
    attributes = {key: item.attributes[key] for key in _SHARED if key in item.attributes}
    attributes |= {"joint1": names[0], "joint2": names[1]}
    attributes["polycoef"] = number_words([c / a, -b / a, 0.0, 0.0, 0.0])
    return replace(item, tag="joint", attributes=attributes, children=())
