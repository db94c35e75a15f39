"""Read and check the files of a linkage, without loading numeric libraries for URDF.

An invalid file is therefore rejected at once.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from kinematics.error_text import clean
from kinematics.formats.convert import convert_to_urdf
from kinematics.urdf.harmless_oddities import mend_oddities
from kinematics.urdf.input_streams import source_name
from kinematics.urdf.loop_file import merge_loop_file
from kinematics.urdf.read_options import Path, ReadOptions, RobotFile
from kinematics.urdf.rounded_angles import (
    ROUNDED_ANGLES,
    describe_rounded_angles,
    find_rounded_angles,
    replace_rounded_angles,
)
from kinematics.urdf.validate import validate_robot
from kinematics.urdf.xml_tree import build_tree, name_file, read_bytes
from kinematics.urdf_elements.element import Document

if TYPE_CHECKING:
    from kinematics.model.linkage import UnassembledLinkage

__all__ = ["read_files", "read_robot", "read_unassembled"]


def read_unassembled(
    model: Path | Document, loops: Path | None = None, options: ReadOptions | None = None
) -> UnassembledLinkage:
    """Read a linkage from its files, its loops not yet closed.

    Args:
        model: the file, or a document from a stream.
        loops: a YAML file with its loops; see `kinematics.urdf.loop_file`.
        options: changes to the file.

    Returns:
        The linkage as its file describes it.

    Raises:
        FileError: a file cannot be read as a linkage; the message gives place and reason.
    """
    options = options or ReadOptions()
    file = read_files(model, loops, options)
    # Libraries are loaded only for a file that was accepted.
    from kinematics.urdf.read import read_linkage

    return read_linkage(source_name(model), file, options)


def read_robot(model: Path | Document, fix_base: bool = False) -> RobotFile:
    """Read and check a robot file, without the YAML file beside it.

    Args:
        model: the file, or a document from a stream.
        fix_base: change floating joints on the ground into fixed joints.

    Returns:
        The checked tree and the remarks.

    Raises:
        FileError: the file is missing, too large, not well-formed, or not a linkage.
    """
    source = source_name(model)
    document = model if isinstance(model, Document) else None
    path = os.fsdecode(model) if not isinstance(model, Document) else None
    with name_file(source):
        data = document.data if document else read_bytes(source)
        root = build_tree(data)
        robot, remarks = convert_to_urdf(root, data, path)
    if robot is not root:
        from kinematics.urdf_elements.write_numbers import element_text

        document = Document(source, element_text(robot).encode())
    robot, odd = mend_oddities(robot, source)
    tree = validate_robot(robot, source, fix_base)
    return RobotFile(tree, None, (*remarks, *odd), document)


def read_files(model: Path | Document, loops: Path | None, options: ReadOptions) -> RobotFile:
    """Read a robot file and the YAML file beside it, and replace rounded angles if wanted.

    Args:
        model: the file, or a document from a stream, which has no file beside it.
        loops: a YAML file with its loops; see `kinematics.urdf.loop_file`.
        options: changes to the file.

    Returns:
        The checked tree with its loops, the named inputs and the remarks.

    Raises:
        FileError: a file cannot be read as a linkage; the message gives place and reason.
    """
    source, robot = source_name(model), read_robot(model, options.fix_base)
    merged = merge_loop_file(robot.tree, source, loops, not isinstance(model, Document))
    tree, found = merged.tree, find_rounded_angles(merged.tree)
    text = f"{clean(source, 1000)}: {describe_rounded_angles(found, options.angles)}"
    more = ((ROUNDED_ANGLES, text),) if found else ()
    return RobotFile(
        replace_rounded_angles(tree) if options.angles == "nominal" else tree,
        merged.inputs, (*robot.remarks, *merged.remarks, *more), robot.document,
    )  # fmt: skip
