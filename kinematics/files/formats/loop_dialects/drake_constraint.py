"""Constraints of Drake: a ball that closes a loop, and elements that are springs."""

from __future__ import annotations

from kinematics.error_text import clean
from kinematics.files.formats.loop_dialects.draft import (
    ZERO,
    Draft,
    check_spelling,
    end_name,
    read_numbers,
)
from kinematics.files.urdf.validate_fields import check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

# Ends of the tags of a body and of a point on it.
_BALL = (("_body_A", "_p_AP"), ("_body_B", "_p_BQ"))


def translate_drake(draft: Draft, item: Element) -> None:
    """Translate an element of Drake that joins two links.

    Args:
        draft: the tree of the file, which gets the loop.
        item: an element of the tree's root.

    Raises:
        Refusal: it does not say enough, or stands for a spring or a tendon.
    """
    prefix, _, word = item.tag.rpartition(":")
    if word == "ball_constraint":
        _translate_ball(draft, item, f"{prefix}:{word}" if prefix else word)
    elif word == "linear_bushing_rpy":
        _refuse_bushing(draft, item, f"{prefix}:bushing_frame" if prefix else "bushing_frame")
    elif word == "linear_spring_damper":
        draft.tell("springs_ignored", item, "a spring closes no loop: not read")
    elif word == "tendon_constraint":
        problem = "a tendon couples joints by lengths, which are not read"
        raise Refusal(item.label, problem, "write a <mimic> in a joint that follows another")


def _translate_ball(draft: Draft, item: Element, tag: str) -> None:
    """Add the loop of a ball."""
    check_spelling(item, item, *(tag + part for ends in _BALL for part in ends))
    sides = []
    for body, point in _BALL:
        link = draft.link(item, end_name(item, tag + body), "spherical", grounded=True)
        given = check_only(item, tag + point)
        words = ZERO.split()
        if given is not None:
            text = given.attributes.get("value", "") or given.text
            words = read_numbers(item, given, text, 3)
        sides.append((link, draft.origin(item, " ".join(words))))
    draft.add_loop(item, "Drake", "spherical", sides, {})


def _refuse_bushing(draft: Draft, item: Element, tag: str) -> None:
    """Refuse a bushing, with the loop for which it may stand.

    A bushing is a spring between two frames. Tools without loops use a stiff one for a joint:
    only its author knows of which type.
    """
    frames = {frame.name: frame for frame in draft.tree.every("frame")}
    ends = []
    for letter in "AC":
        name = end_name(item, tag + letter)
        frame = frames.get(name)
        link = frame.attributes.get("link", "") if frame is not None else name
        place = frame.attributes.get("xyz", "…") if frame is not None else "…"
        ends.append((link or "…", place))
    (first, start), (second, end) = ((clean(link), clean(at)) for link, at in ends)
    remedy = (
        'if it stands for a joint, write <loop name="…" type="revolute"><predecessor '
        f'link="{first}"><origin xyz="{start}"/></predecessor><successor link="{second}">'
        f'<origin xyz="{end}"/></successor><axis xyz="…"/></loop> in its place, with the type '
        "of that joint; if not, remove it"
    )
    raise Refusal(item.label, "a bushing is a spring, which closes no loop exactly", remedy)
