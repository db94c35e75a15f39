"""What is read of a robot: changes that the user makes, and the checked elements."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

from kinematics.model.document.element import Document, Element

Path = str | os.PathLike[str]


class ReadOptions(NamedTuple):
    """Changes that the user makes to a file.

    Attributes:
        fix_base: change the floating joint of a base into a fixed one; see
            `kinematics.files.urdf.floating_joints`.
        bodies: ``"given"``: moving links with mass or inertia in the file carry parameters;
            ``"all"``: every moving link does.
        massless: names of links that carry no parameters, even with mass in the file.
        angles: ``"nominal"`` or ``"as_written"``; see `kinematics.files.urdf.rounded_angles`.
        ground: name of the link that is the ground; None for the only root.
    """

    fix_base: bool = False
    bodies: str = "given"
    massless: tuple[str, ...] = ()
    angles: str = "nominal"
    ground: str | None = None


class RobotFile(NamedTuple):
    """The checked elements of a robot with all its loops, and remarks on its files.

    Attributes:
        tree: the ``<robot>`` element.
        inputs: coordinates named as inputs; None if the marks in the tree name them.
        remarks: code and message of each remark for the user, and the names in it, if short
            forms leave them out.
        document: the URDF text, if the file itself is not one that can be read again.
        dialects: dialects of loops in the words of other tools, by the names of the loops.
    """

    tree: Element
    inputs: tuple[str, ...] | None = None
    remarks: tuple[tuple[str, ...], ...] = ()
    document: Document | None = None
    dialects: Mapping[str, str] = {}
