"""Find elements and expressions of xacro in the tree of a file."""

from __future__ import annotations

from kinematics.model.document.element import Element


def uses_xacro(root: Element) -> bool:
    """Return whether an element of xacro, or an expression of it, is in a tree.

    Texts of a URDF file are those of other tools.

    Args:
        root: root element of the file.
    """
    prefixes = {"xacro"}
    for item in root.walk():
        for attribute, value in item.attributes.items():
            if attribute.startswith("xmlns:") and "xacro" in value:
                prefixes.add(attribute.removeprefix("xmlns:"))
        prefix, colon, _ = item.tag.partition(":")
        if colon and prefix in prefixes:
            return True
        texts = () if root.tag == "robot" else (item.text,)
        if any("${" in value for value in (*texts, *item.attributes.values())):
            return True
    return False
