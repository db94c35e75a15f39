"""Translate the loops of a checked file that are in the words of other tools.

A file without such words costs one pass over the elements in ``<robot>``, links and joints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from kinematics.error_text import quoted
from kinematics.files.formats.loop_dialects.closing_frames import (
    CLOSING_PREFIX,
    translate_closing_frames,
)
from kinematics.files.formats.loop_dialects.coupling import translate_coupling
from kinematics.files.formats.loop_dialects.detachable_joint import (
    is_detachable_joint,
    translate_detachable_joints,
)
from kinematics.files.formats.loop_dialects.draft import Draft, end_name
from kinematics.files.formats.loop_dialects.drake_constraint import translate_drake
from kinematics.files.formats.loop_dialects.gazebo_joint import translate_gazebo
from kinematics.files.formats.loop_dialects.loop_joint import translate_loop_joint
from kinematics.files.formats.loop_dialects.mujoco_equality import translate_mujoco
from kinematics.files.formats.loop_dialects.urdfdom_constraint import translate_constraint
from kinematics.model.document.element import Element

_OWN = {"link", "joint", "loop", "material", "transmission"}
# What links and joints consist of.
_PARTS = frozenset({
    "axis", "axis2", "box", "calibration", "child", "collision", "color", "cylinder",
    "dynamics", "geometry", "inertia", "inertial", "joint", "limit", "link", "mass",
    "material", "mesh", "mimic", "origin", "parent", "safety_controller",
    "screw_thread_pitch", "sphere", "texture", "visual",
})  # fmt: skip
_DIALECTS: Mapping[str, Callable[[Draft, Element], None]] = {
    "constraint": translate_constraint,
    "coupling": translate_coupling,
    "loop_joint": translate_loop_joint,
}
_DRAKE = ("ball_constraint", "linear_bushing_rpy", "linear_spring_damper", "tendon_constraint")
# Most remarks on one element of ``<robot>``.
MAX_TOLD = 5
# Elements that name links and join none, and what is inside them.
_HARMLESS = {
    "actuator", "camera", "chain", "contact", "end_effector", "exclude", "frame", "group",
    "group_state", "inertial", "joint_properties", "loop", "material", "pair",
    "passive_joint", "ros2_control", "self_collide", "sensor", "transmission",
    "virtual_joint", "visual",
}  # fmt: skip
# Elements that hold others, which have nothing to do with each other.
_HOLDERS = {"gazebo", "mujoco", "model", "world", "robot", "extension", "custom", "default"}
# Attributes, and tags of texts, that name frames of messages.
_LABELS = ("reference", "frame", "topic", "namespace")


class Translated(NamedTuple):
    """A tree with the loops of all dialects.

    Attributes:
        tree: the ``<robot>``; the one that was given if nothing was translated.
        remarks: code and message of each remark for the user.
        dialects: dialect of each translated loop, by its name; the others have none.
    """

    tree: Element
    remarks: tuple[tuple[str, str], ...] = ()
    dialects: Mapping[str, str] = {}


def translate_loops(tree: Element, nominal: bool = True) -> Translated:
    """Translate loops in the words of other tools to ``<loop>`` and ``<mimic>`` elements.

    Args:
        tree: a tree that `kinematics.files.urdf.validate.validate_robot` accepted.
        nominal: whether rounded angles will be replaced; see
            `kinematics.files.urdf.rounded_angles`.

    Returns:
        The tree, to be checked again if it is another one.

    Raises:
        Refusal: an element closes a loop and does not say enough, or is wrong.
    """
    foreign = [item for item in tree.children if item.tag not in _OWN]
    framed = any(link.name.startswith(CLOSING_PREFIX) for link in tree.every("link"))
    inside = [part for item in tree.children if item.tag in _PARTS for part in _unusual(item)]
    if not foreign and not framed and not inside:
        return Translated(tree)
    draft = Draft(tree, nominal)
    for item in foreign:
        _translate(draft, item)
    for item in inside:
        _tell_unread_closures(draft, item, frozenset())
    if framed:
        translate_closing_frames(draft)
    joints = {joint.name: joint for joint in tree.every("joint")}
    if not draft.loops and draft.joints == joints:
        return Translated(tree, tuple(draft.remarks))
    changed = (draft.joints[x.name] if x.tag == "joint" else x for x in tree.children)
    whole = replace(tree, children=(*changed, *(loop for loop, _ in draft.loops)))
    pairs = [*((loop, "") for loop in tree.every("loop")), *draft.loops]
    whole, said = _drop_repeated(whole, pairs)
    kept = {id(loop) for loop in whole.every("loop")}
    dialects = {loop.name: dialect for loop, dialect in draft.loops if id(loop) in kept}
    return Translated(whole, (*draft.remarks, *said), dialects)


def _unusual(item: Element) -> list[Element]:
    """List the topmost elements of other tools inside a link or a joint."""
    elements: list[Element] = []
    pending = [item]
    while pending:
        for part in pending.pop().children:
            (pending if part.tag in _PARTS else elements).append(part)
    return elements


def _translate(draft: Draft, item: Element) -> None:
    """Translate an element of another tool, and tell of what it says of links besides."""
    word = item.tag.rpartition(":")[2]
    if item.tag == "gazebo":
        translate_gazebo(draft, item)
        translate_detachable_joints(draft, item)
    elif word in _DRAKE:
        translate_drake(draft, item)
        return
    elif item.tag == "mujoco":
        translate_mujoco(draft, item)
    elif item.tag in _DIALECTS and _has_ends(item):
        _DIALECTS[item.tag](draft, item)
        return
    partly_read = item.tag in ("gazebo", "mujoco")
    _tell_unread_closures(draft, item, frozenset(_read_parts(item) if partly_read else ()))


def _has_ends(item: Element) -> bool:
    """Whether an element is a closure: other tools have constraints of other kinds."""
    roles = ("parent", "child")
    return item.tag != "constraint" or any(
        item.first(role) or role in item.attributes for role in roles
    )


def _read_parts(item: Element) -> list[int]:
    """Identities of the elements inside ``<gazebo>`` and ``<mujoco>`` that were read."""
    return [
        id(part)
        for part in item.walk()
        if part.tag == "equality"
        or (part.tag == "joint" and part.first("parent") and part.first("child"))
        or is_detachable_joint(part)
    ]


def drop_repeated_loops(
    tree: Element, dialects: Mapping[str, str]
) -> tuple[Element, tuple[tuple[str, str], ...]]:
    """Drop loops that a loop of another dialect implies.

    Args:
        dialects: dialect of each translated loop, by its name; the others have none.

    Returns:
        The tree, and code and message of a remark on each dropped loop.
    """
    pairs = [(loop, dialects.get(loop.name, "")) for loop in tree.every("loop")]
    return _drop_repeated(tree, sorted(pairs, key=lambda pair: pair[0].name in dialects))


def _drop_repeated(
    tree: Element, pairs: Sequence[tuple[Element, str]]
) -> tuple[Element, tuple[tuple[str, str], ...]]:
    """Drop repeated loops; those to prefer come first."""
    if len({dialect for _, dialect in pairs}) < 2:
        return tree, ()
    draft = Draft(tree, False)
    roles = ("predecessor", "successor")
    bodies = [{draft.body(end_name(loop, role)) for role in roles} for loop, _ in pairs]
    if len({frozenset(pair) for pair in bodies}) == len(bodies):
        return tree, ()
    from kinematics.files.formats.loop_dialects.repeated_loops import find_repeated

    repeated = find_repeated(pairs, draft.place)
    gone = {id(loop) for loop, _ in repeated}
    said = tuple(
        ("loops_repeated", f"{loop.label}: implied by {other.label}: counted once")
        for loop, other in repeated
    )
    return replace(tree, children=tuple(x for x in tree.children if id(x) not in gone)), said


def _tell_unread_closures(draft: Draft, item: Element, done: frozenset[int]) -> None:
    """Add a remark on each innermost element that names two links.

    Args:
        draft: the tree of the file, which gets the remarks.
        item: an element of another tool, in ``<robot>``.
        done: identities of the elements inside that were read.
    """
    for element, names in _find_closures(draft.links, item, done)[1][:MAX_TOLD]:
        text = f"it names the links {quoted(sorted(names))}, and is not read; if it closes a "
        draft.tell("unread_closure", element, f"{text}loop, write a <loop>")


def _find_closures(
    links: set[str], item: Element, done: frozenset[int]
) -> tuple[set[str], list[tuple[Element, set[str]]]]:
    """Find the links that an element names, and the innermost elements that name two."""
    word = item.tag.rpartition(":")[2]
    if id(item) in done or word in _HARMLESS or "collision" in word:
        return set(), []
    names, closures = set(_named(links, item)), []
    for child in item.children:
        inner, below = _find_closures(links, child, done)
        closures += below
        if word not in _HOLDERS:
            names |= inner
    if len(names) > 1 and not closures:
        closures = [(item, names)]
    return names, closures


def _named(links: set[str], item: Element) -> Iterator[str]:
    """Names of links among the attributes and the text of an element."""
    values = [(item.tag, item.text), *item.attributes.items()]
    for label, value in values:
        if any(part in label.lower() for part in _LABELS):
            continue
        words = value.replace(",", " ").split()
        several = len(words) > 1 and all(word in links for word in words)
        for name in words if several else [value.strip().rpartition("::")[2]]:
            if name in links and not _is_plain_value(name):
                yield name


def _is_plain_value(name: str) -> bool:
    """Whether a name may be a number or a truth value as well."""
    return name in ("true", "false", "True", "False") or not name.strip("0123456789.+-eE")
