"""Tell of elements that name two links and are not read: they may close a loop."""

from __future__ import annotations

from collections.abc import Iterator

from kinematics.error_text import quoted
from kinematics.files.formats.loop_dialects.draft import Draft
from kinematics.model.document.element import Element

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


def tell_unread_closures(draft: Draft, item: Element, done: frozenset[int]) -> None:
    """Add a remark on each innermost element that names two links.

    Args:
        draft: the tree of the file, which gets the remarks.
        item: an element of another tool, in ``<robot>``.
        done: identities of the elements inside that were read.
    """
    for element, names in _search(draft.links, item, done)[1][:MAX_TOLD]:
        text = f"it names the links {quoted(sorted(names))}, and is not read; if it closes a "
        draft.tell("unread_closure", element, f"{text}loop, write a <loop>")


def _search(
    links: set[str], item: Element, done: frozenset[int]
) -> tuple[set[str], list[tuple[Element, set[str]]]]:
    """Find the links that an element names, and the innermost elements that name two."""
    word = item.tag.rpartition(":")[2]
    if id(item) in done or word in _HARMLESS or "collision" in word:
        return set(), []
    names, closures = set(_named(links, item)), []
    for child in item.children:
        inner, below = _search(links, child, done)
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
