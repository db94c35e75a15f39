"""Read and check the URDF and YAML files of a linkage, without loading numeric libraries.

An invalid file is therefore rejected at once.
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
    """Changes that the user makes to a file.

    Attributes:
        fix_base: change a floating joint between the ground and the base into a fixed one.
        bodies: ``"given"``: moving links with mass or inertia in the file carry parameters;
            ``"all"``: every moving link does.
        massless: names of links that carry no parameters, even with mass in the file.
        angles: ``"nominal"`` or ``"as_written"``; see `kinematics.urdf.rounded_angles`.
    """

    fix_base: bool = False
    bodies: str = "given"
    massless: tuple[str, ...] = ()
    angles: str = "nominal"


def read_files(model: Path | Document, loops: Path | None, options: ReadOptions) -> Sidecar:
    """Read a URDF file and the YAML file beside it, and replace rounded angles if wanted.

    Args:
        model: the URDF file, or a document from a stream, which has no file beside it.
        loops: a YAML file with its loops; see `kinematics.urdf.loop_file`.
        options: changes to the file.

    Returns:
        The checked tree with its loops, the named inputs and the remarks.

    Raises:
        FileError: a file cannot be read as a linkage; the message gives place and reason.
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
    more = ((ROUNDED_ANGLES, text),) if found else ()
    return side._replace(tree=tree, remarks=(*side.remarks, *more))
