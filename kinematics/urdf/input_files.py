"""The files of a linkage, read and accepted, before any library is loaded for them.

A file that is refused here, whether URDF or YAML, is refused at once.
"""

from __future__ import annotations

import os
from typing import NamedTuple

from kinematics.error_text import clean
from kinematics.urdf.input_streams import source_name
from kinematics.urdf.loop_file import Sidecar, merge_loop_file
from kinematics.urdf.rounded_angles import (
    ROUNDED_ANGLES,
    describe_rounded_angles,
    find_rounded_angles,
    replace_rounded_angles,
)
from kinematics.urdf.validate import parse_file, validate_file
from kinematics.urdf_elements.element import Document

__all__ = ["ReadOptions", "Path", "read_files"]

Path = str | os.PathLike[str]


class ReadOptions(NamedTuple):
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


def read_files(model: Path | Document, loops: Path | None, options: ReadOptions) -> Sidecar:
    """What a URDF file and the file beside it say, with angles read as the user wants.

    Args:
        model: the URDF file; beside one that was read from a stream there is none.
        loops: a YAML file with its loops; see :mod:`kinematics.urdf.loop_file`.
        options: what to change about it.

    Raises:
        FileError: a file cannot be read as a linkage; the message says where and why.
    """
    source = source_name(model)
    if isinstance(model, Document):
        tree = parse_file(model.data, source, options.fix_base)
    else:
        tree = validate_file(model, options.fix_base)
    side = merge_loop_file(tree, source, loops, search=not isinstance(model, Document))
    found = find_rounded_angles(side.tree)
    tree = replace_rounded_angles(side.tree) if options.angles == "nominal" else side.tree
    text = f"{clean(source, 1000)}: {describe_rounded_angles(found, options.angles)}"
    told = ((ROUNDED_ANGLES, text),) if found else ()
    return side._replace(tree=tree, remarks=(*side.remarks, *told))
