"""Joints of SDF in ``<gazebo>``, with which Gazebo closes loops.

The pose of such a joint is given in the frame of its child link, unless ``relative_to`` names
another frame; its axes are given in its own frame, unless ``expressed_in`` names another.
Gazebo adds only what is directly in a ``<gazebo>`` without ``reference`` to the model.
"""

from __future__ import annotations

from kinematics.error_text import clean, closest_names
from kinematics.files.formats.loop_dialects.draft import (
    ZERO,
    Draft,
    Side,
    check_spelling,
    end_name,
    read_numbers,
    write_instead,
)
from kinematics.files.urdf.validate_fields import check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

_TYPES = ("revolute", "continuous", "prismatic", "ball", "universal", "fixed")
_AXES = {"universal": ("axis", "axis2"), "ball": (), "fixed": ()}
_PARTS = (
    "parent",
    "child",
    "pose",
    "axis",
    "axis2",
    "origin",
    "physics",
    "sensor",
    "name",
    "type",
)
# Attributes of <pose>, and the values that they may have.
_PLAIN = {"degrees": "false", "rotation_format": "euler_rpy", "frame": ""}
_MODEL = "__model__"
_TRUE = ("1", "true", "True")


def translate_gazebo(draft: Draft, gazebo: Element) -> None:
    """Translate the joints of SDF inside a ``<gazebo>``.

    Args:
        draft: the tree of the file, which gets the loops.

    Raises:
        Refusal: a joint does not say enough, or has no equal among loops.
    """
    direct = {id(item) for item in gazebo.every("joint")}
    for joint in gazebo.walk():
        if joint.tag != "joint":
            continue
        kind = joint.attributes.get("type", "").strip()
        place = "reference" in gazebo.attributes
        if not (joint.first("parent") or joint.first("child")):
            if id(joint) in direct and kind and not place:
                draft.tell("unread_closure", joint, "it names no links: not read")
            continue
        ends = [end_name(joint, role) for role in ("parent", "child")]
        if place or id(joint) not in direct:
            where = "in <gazebo reference=…>" if place else "not directly in <gazebo>"
            problem = f"it closes a loop {where}, where Gazebo does not read it"
            raise Refusal(joint.label, problem, write_instead(kind, *ends))
        if kind not in _TYPES:
            problem = f"a joint of type '{clean(kind)}' closes a loop, and no loop is like it"
            raise Refusal(joint.label, problem, write_instead("…", *ends))
        _translate(draft, joint, kind)


def _translate(draft: Draft, joint: Element, kind: str) -> None:
    """Add the loop of a joint, unless it is a joint of the tree, or fixes the base."""
    check_spelling(joint, joint, *_PARTS)
    if joint.first("origin"):
        problem = "<origin> of URDF in a joint of SDF is not read"
        raise Refusal(joint.label, problem, "write <pose>, or a <loop> in its place")
    names = [_plain(draft, end_name(joint, role)) for role in ("parent", "child")]
    parent, child = (draft.link(joint, name, kind, grounded=True) for name in names)
    if _repeats(draft, joint, parent, child):
        return
    link, origin = _frame(draft, joint, child)
    tags = _AXES.get(kind, ("axis",))
    axes = {tag: _axis(draft, joint, tag, (link, origin)) for tag in tags}
    sides: list[Side] = [(parent, None), (child, None)]
    if draft.body(parent) != draft.body(child):
        sides = [
            (end, origin if end == link else _origin_on(draft, end, (link, origin), joint))
            for end in (parent, child)
        ]
    draft.add_loop(joint, "SDF", kind, sides, axes)


def _plain(draft: Draft, name: str) -> str:
    """Remove the name of the robot before the name of a link: ``robot::link``."""
    return name.removeprefix(f"{draft.tree.name}::")


def _repeats(draft: Draft, joint: Element, parent: str, child: str) -> bool:
    """Return whether a joint of the tree is the same joint; tell of it."""
    twin = draft.joints.get(joint.name)
    if twin is None or [parent, child] != [end_name(twin, r) for r in ("parent", "child")]:
        return False
    if twin.attributes["type"] != joint.attributes["type"].strip():
        problem = f"it has another type than {twin.label}"
        raise Refusal(joint.label, problem, "keep one of the two joints")
    draft.tell("loops_repeated", joint, f"the same as {twin.label}: counted once")
    return True


def _frame(draft: Draft, joint: Element, child: str) -> Side:
    """Find the frame of a joint: a link, and an origin on it."""
    pose = check_only(joint, "pose")
    if pose is None:
        return child, None
    check_spelling(joint, pose, *_PLAIN, "relative_to")
    for attribute, plain in _PLAIN.items():
        if pose.attributes.get(attribute, plain) not in (plain, "0", ""):
            problem = f"<pose {attribute}=…> (line {pose.line}) is not read"
            raise Refusal(joint.label, problem, "write six numbers, in metres and radians")
    words = read_numbers(joint, pose, pose.text or f"{ZERO} {ZERO}", 6)
    origin = draft.origin(joint, " ".join(words[:3]), " ".join(words[3:]))
    base = pose.attributes.get("relative_to", "").strip()
    return (_base(draft, joint, base) if base else child), origin


def _base(draft: Draft, joint: Element, name: str) -> str:
    """Find the link whose frame a name stands for: a link, a joint or the model."""
    plain = _plain(draft, name)
    if plain in draft.links:
        return plain
    if plain == _MODEL or plain == "world":
        return draft.root
    if plain in draft.joints:
        return end_name(draft.joints[plain], "child")
    names = sorted({*draft.links, *draft.joints, _MODEL})
    remedy = f"name a link or a joint of the file: {closest_names(name, names)}"
    raise Refusal(joint.label, f"the frame '{clean(name)}' does not exist", remedy)


def _axis(draft: Draft, joint: Element, tag: str, frame: Side) -> str:
    """Find the text of an axis, in the frame of the joint."""
    item = check_only(joint, tag)
    inner = check_only(item, "xyz") if item is not None else None
    if item is not None and inner is None and "xyz" in item.attributes:
        problem = f"<{tag} xyz=…> (line {item.line}) of URDF in a joint of SDF is not read"
        raise Refusal(joint.label, problem, f"write <{tag}><xyz>…</xyz></{tag}>")
    if item is None or inner is None:
        if tag == "axis2":
            problem = "a universal joint without <axis2>"
            raise Refusal(joint.label, problem, "add <axis2><xyz>…</xyz></axis2>")
        return "0 0 1"
    check_spelling(joint, inner, "expressed_in")
    text = " ".join(read_numbers(joint, inner, inner.text, 3))
    base = inner.attributes.get("expressed_in", "").strip()
    old = item.first("use_parent_model_frame")
    if old is not None and old.text in _TRUE:
        base = base or _MODEL
    if not base or (_base(draft, joint, base) == frame[0] and not _turned(frame[1])):
        return text
    given = draft.poses.frame(_base(draft, joint, base), None)
    link, origin = frame
    wanted = draft.poses.frame(link, draft.nominal_origin(origin))
    return draft.poses.direction(text, given, wanted)


def _turned(origin: Element | None) -> bool:
    return origin is not None and "rpy" in origin.attributes


def _origin_on(draft: Draft, link: str, frame: Side, joint: Element) -> Element:
    """Make the origin on a link of a frame that is given on another."""
    there = draft.poses.frame(frame[0], draft.nominal_origin(frame[1]))
    return draft.poses.origin_on(link, there, joint.line)
