"""Find elements and expressions of xacro in the tree of a file."""

from __future__ import annotations

from kinematics.files.urdf.validate import walk_xacro
from kinematics.model.document.element import Element


def uses_xacro(root: Element) -> bool:
    """Return whether an element of xacro, or an expression of it, is in a tree.

    Texts of a URDF file are those of other tools.

    Args:
        root: root element of the file.
    """
    for item, of_xacro in walk_xacro(root):
        if of_xacro:
            return True
        texts = () if root.tag == "robot" else (item.text,)
        if any("${" in value for value in (*texts, *item.attributes.values())):
            return True
    return False
