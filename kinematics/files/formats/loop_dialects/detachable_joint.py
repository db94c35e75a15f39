"""The plugin ``DetachableJoint`` of Gazebo, which welds two links at the pose of the file."""

from __future__ import annotations

from kinematics.files.formats.loop_dialects.draft import (
    Draft,
    check_spelling,
    end_name,
    write_instead,
)
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

_ENDS = ("parent_link", "child_model", "child_link")


def translate_detachable_joints(draft: Draft, gazebo: Element) -> None:
    """Translate the plugins of a ``<gazebo>`` that weld two links.

    Args:
        draft: the tree of the file, which gets the loops.

    Raises:
        Refusal: a link is not in the file.
    """
    for plugin in gazebo.walk():
        if is_detachable_joint(plugin):
            _translate(draft, plugin)


def is_detachable_joint(item: Element) -> bool:
    """Return whether an element is this plugin, by its name or that of its file."""
    words = item.name + item.attributes.get("filename", "")
    plain = words.replace("-", "").replace("_", "").lower()
    return item.tag == "plugin" and "detachablejoint" in plain


def _translate(draft: Draft, plugin: Element) -> None:
    """Add the loop of a plugin."""
    check_spelling(plugin, plugin, *_ENDS)
    parent, model, child = (end_name(plugin, role) for role in _ENDS)
    named = [name if name in draft.links else "" for name in (parent, child)]
    if model not in ("", "__model__", draft.tree.name) or not all(named):
        problem = "it welds links that are not both in this file"
        raise Refusal(plugin.label, problem, write_instead("fixed", *named))
    if draft.body(parent) != draft.body(child):
        origin = draft.poses.origin_on(child, draft.poses.frame(parent, None), plugin.line)
        sides = [(parent, None), (child, origin)]
        draft.add_loop(_nameless(plugin), "DetachableJoint", "fixed", sides, {})


def _nameless(plugin: Element) -> Element:
    """The name of a plugin is that of a class, which several plugins have."""
    return Element("weld", {}, (), plugin.line, "", plugin.span)
