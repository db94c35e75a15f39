"""Reject loops in the formats of other tools.

A file with a loop that is not read would be analysed as an open tree. Gazebo writes a joint of
SDF into ``<gazebo>``, MuJoCo equalities into ``<mujoco>``, Drake constraints into elements of
its namespace; urdfdom has a proposal for ``<constraint>``.
"""

from __future__ import annotations

from collections.abc import Iterator

from kinematics.error_text import clean
from kinematics.urdf.xml_tree import Refusal
from kinematics.urdf_elements.element import Element

__all__ = ["check_foreign_loops"]

_EQUALITIES = {"connect": "spherical", "weld": "fixed"}
# A bushing stands for a joint of any type.
_DRAKE = {"ball_constraint": "spherical", "linear_bushing_rpy": "…"}
_SDF = {"ball": "spherical"}
_ENDS = (
    ("body1", "body2"), ("drake:ball_constraint_body_A", "drake:ball_constraint_body_B"),
    ("parent", "child"), ("parent_link", "child_link"),
)  # fmt: skip


def check_foreign_loops(robot: Element) -> None:
    """Reject an element of another tool that closes a loop.

    Raises:
        Refusal: there is one; the remedy is the ``<loop>`` to write in its place.
    """
    for item, kind in _closures(robot):
        first, second = _ends(item)
        remedy = (
            f'write <loop name="…" type="{kind}"><predecessor link="{first}"><origin xyz="…"/>'
            f'</predecessor><successor link="{second}"><origin xyz="…"/></successor>'
            '<axis xyz="…"/></loop> in its place'
        )
        raise Refusal(item.label, "it closes a loop in words that are not read", remedy)


def _closures(robot: Element) -> Iterator[tuple[Element, str]]:
    """Elements that close a loop, and the type of the equivalent ``<loop>``."""
    for item in robot.children:
        prefix, _, word = item.tag.rpartition(":")
        if prefix == "drake" and word in _DRAKE:
            yield item, _DRAKE[word]
        elif item.tag == "constraint" and item.first("parent") and item.first("child"):
            yield item, item.attributes.get("type", "revolute").removesuffix("_joint")
        elif item.tag == "gazebo":
            for inner in item.walk():
                if inner.tag == "joint" and inner.first("parent") and inner.first("child"):
                    kind = inner.attributes.get("type", "revolute")
                    yield inner, _SDF.get(kind, kind)
                elif inner.tag == "plugin" and "DetachableJoint" in inner.name:
                    yield inner, "fixed"
        elif item.tag == "mujoco":
            for equality in item.every("equality"):
                for inner in equality.children:
                    if inner.tag in _EQUALITIES:
                        yield inner, _EQUALITIES[inner.tag]


def _ends(item: Element) -> tuple[str, str]:
    """Find the links that a closure joins, as far as they have names there."""
    for pair in _ENDS:
        named = tuple(_link_of(item, role) for role in pair)
        if all(named):
            return clean(named[0]), clean(named[1])
    return "…", "…"


def _link_of(item: Element, role: str) -> str:
    """Find the link in an attribute, or in an element, of a closure."""
    inner = item.first(role)
    if inner is None:
        return item.attributes.get(role, "")
    return inner.attributes.get("link", "") or inner.name or inner.text
