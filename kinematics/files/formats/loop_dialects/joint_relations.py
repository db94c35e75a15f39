"""Linear relations between joints, as ``<mimic>`` elements of the joints of a draft."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

from kinematics.error_text import clean, closest_names
from kinematics.files.formats.loop_dialects.decimal_words import decimal_word, word_value
from kinematics.files.formats.loop_dialects.draft import Draft
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM

_IDLE = ("mimic", "axis2", "screw_thread_pitch", "origin")


class _Relation(NamedTuple):
    """The position of a joint is ``ratio`` times that of a free joint, plus ``offset``."""

    free: str
    ratio: Fraction
    offset: Fraction


def follow_joint(
    draft: Draft, item: Element, names: tuple[str, str], ratio: str, offset: str
) -> None:
    """Let a joint follow another: ``q = ratio × q_source + offset``.

    Args:
        draft: the tree of the file, whose joints get a ``<mimic>``.
        item: the element that relates them.
        names: of the joint that follows, and of its source.
        ratio: a finite decimal number.
        offset: a finite decimal number, in the unit of the first joint.

    Raises:
        Refusal: a joint does not exist or has not one degree of freedom, or the file relates
            them in another way too.
    """
    for name in names:
        _check_joint(draft, item, name)
    here, there = (_relation(draft, name) for name in names)
    a, b = word_value(ratio), word_value(offset)
    if here.free == there.free:
        if here.ratio == a * there.ratio and here.offset == a * there.offset + b:
            if names[0] == names[1]:
                raise Refusal(item.label, "it relates a joint to itself", "remove it")
            draft.tell("loops_repeated", item, "the joints are so related already: once")
            return
        problem = "it contradicts how the file relates these joints already"
        raise Refusal(item.label, problem, "keep one of the relations")
    if here.free == names[0] and not (_is_input(draft, here.free) and a):
        _set_mimic(draft, here.free, names[1], ratio, offset)
        return
    if not here.ratio or not a or not there.ratio:
        problem = "it relates joints of which one does not move"
        raise Refusal(item.label, problem, "write the joint that does not move as fixed")
    # here.ratio x + here.offset = a (there.ratio y + there.offset) + b for the free joints.
    slope = a * there.ratio / here.ratio
    constant = (a * there.offset + b - here.offset) / here.ratio
    first, second = here.free, there.free
    if _is_input(draft, first) and not _is_input(draft, second):
        first, second, slope, constant = second, first, 1 / slope, -constant / slope
    _set_mimic(draft, first, second, decimal_word(slope), decimal_word(constant))


def fix_joint(draft: Draft, item: Element, name: str, position: str) -> None:
    """Fix a joint, and those that are related to it, at a position.

    Args:
        draft: the tree of the file, whose joint becomes a fixed one.
        item: the element that fixes it.
        position: a finite decimal number, radians or metres.

    Raises:
        Refusal: the joint does not exist or has not one degree of freedom, or stands
            elsewhere already.
    """
    _check_joint(draft, item, name)
    here = _relation(draft, name)
    if not here.ratio:
        if here.offset != word_value(position):
            raise Refusal(item.label, "its joint stands elsewhere already", "correct one")
        return
    place = (word_value(position) - here.offset) / here.ratio
    fixed: dict[str, Element] = {}
    related = [n for n, j in draft.joints.items() if _moves_once(j)]
    for other in [n for n in related if _relation(draft, n).free == here.free]:
        relation = _relation(draft, other)
        exact = relation.ratio * place + relation.offset
        word = position if other == name else decimal_word(exact)
        fixed[other] = _fixed(draft, draft.joints[other], float(word))
    draft.joints.update(fixed)


def _moves_once(joint: Element) -> bool:
    return DEGREES_OF_FREEDOM[joint.attributes["type"]] == 1


def _check_joint(draft: Draft, item: Element, name: str) -> None:
    """Check that a joint exists, and has one degree of freedom."""
    joint = draft.joints.get(name)
    if joint is None:
        remedy = f"correct the name; the joints are {closest_names(name, draft.joints)}"
        raise Refusal(item.label, f"joint '{clean(name)}' does not exist", remedy)
    if not _moves_once(joint):
        kind = joint.attributes["type"]
        problem = f"it relates joints of one degree of freedom; {joint.label} is {kind}"
        raise Refusal(item.label, problem, "name other joints, or remove it")


def _is_input(draft: Draft, name: str) -> bool:
    return draft.joints[name].attributes.get("independent") == "true"


def _relation(draft: Draft, name: str) -> _Relation:
    """Follow the mimic joints from a joint to the free one."""
    ratio, offset = Fraction(1), Fraction(0)
    while (mimic := draft.joints[name].first("mimic")) is not None:
        offset += ratio * word_value(mimic.attributes.get("offset", "0").strip())
        ratio *= word_value(mimic.attributes.get("multiplier", "1").strip())
        name = mimic.attributes["joint"]
    return _Relation(name, ratio, offset)


def _set_mimic(draft: Draft, name: str, source: str, ratio: str, offset: str) -> None:
    """Give a free joint a ``<mimic>``."""
    joint = draft.joints[name]
    attributes = {"joint": source, "multiplier": ratio, "offset": offset}
    mimic = Element("mimic", attributes, (), joint.line)
    draft.joints[name] = replace(joint, children=(*joint.children, mimic))


def _fixed(draft: Draft, joint: Element, position: float) -> Element:
    """Change a joint to a fixed one, with its link where the joint at a position has it."""
    origin = joint.first("origin")
    if position:
        from kinematics.files.urdf.write_closed_pose import moved_origin

        # The angles that it adds to must not be rounded ones: their sum would not look so.
        origin = draft.nominal_origin(origin)
        others = [child for child in joint.children if child.tag != "origin"]
        there = replace(joint, children=(*others, *([origin] if origin else [])))
        attributes = moved_origin(there, [position])
        origin = Element("origin", attributes, (), joint.line)
    children = [child for child in joint.children if child.tag not in _IDLE]
    marks = {k: v for k, v in joint.attributes.items() if k != "independent"}
    return replace(
        joint,
        attributes={**marks, "type": "fixed"},
        children=(*children, *([origin] if origin is not None else [])),
    )
