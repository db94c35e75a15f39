"""The files of a linkage, read and accepted, before any library is loaded for them.

A file that is refused here, whether URDF or YAML, is refused at once.
"""

from __future__ import annotations

import os
from typing import NamedTuple

from kinematics.urdf.input_streams import Document, source_of
from kinematics.urdf.loop_file import Sidecar, merge
from kinematics.urdf.rounded_angles import ROUNDED, nominal, remark, rounded
from kinematics.urdf.validate import check, parse
from kinematics.urdf.xml_tree import shown

__all__ = ["Options", "Path", "accepted"]

Path = str | os.PathLike[str]


class Options(NamedTuple):
    """What the user changes about a file.

    Attributes:
        fix_base: whether a floating joint between the ground and the base becomes fixed.
        bodies: ``"given"``: moving links with mass or inertia in the file carry parameters;
            ``"all"``: every moving link does.
        massless: links that carry no parameters whatever the file says.
        angles: ``"nominal"`` or ``"as_written"``; see :mod:`kinematics.urdf.rounded_angles`.
    """

    fix_base: bool = False
    bodies: str = "given"
    massless: tuple[str, ...] = ()
    angles: str = "nominal"


def accepted(model: Path | Document, loops: Path | None, options: Options) -> Sidecar:
    """What a URDF file and the file beside it say, with angles read as the user wants.

    Args:
        model: the URDF file; beside one that was read from a stream there is none.
        loops: a YAML file with its loops; see :mod:`kinematics.urdf.loop_file`.
        options: what to change about it.

    Raises:
        FileError: a file cannot be read as a linkage; the message says where and why.
    """
    source = source_of(model)
    if isinstance(model, Document):
        tree = parse(model.data, source, options.fix_base)
    else:
        tree = check(model, options.fix_base)
    side = merge(tree, source, loops, search=not isinstance(model, Document))
    found = rounded(side.tree)
    tree = nominal(side.tree) if options.angles == "nominal" else side.tree
    text = f"{shown(source, 1000)}: {remark(found, options.angles)}"
    told = ((ROUNDED, text),) if found else ()
    return side._replace(tree=tree, remarks=(*side.remarks, *told))
