"""Read and check the files of a linkage, without loading numeric libraries for URDF.

An invalid file is therefore rejected at once.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from kinematics.error_text import clean
from kinematics.files.formats.convert import convert_to_urdf
from kinematics.files.formats.loop_dialects.translate import (
    Translated,
    drop_repeated_loops,
    translate_loops,
)
from kinematics.files.urdf.choose_ground import choose_ground
from kinematics.files.urdf.exporter_noise import remove_exporter_noise
from kinematics.files.urdf.floating_joints import settle_floating_joints
from kinematics.files.urdf.harmless_oddities import mend_oddities
from kinematics.files.urdf.input_streams import source_name
from kinematics.files.urdf.loop_file import merge_loop_file
from kinematics.files.urdf.read_options import Path, ReadOptions, RobotFile
from kinematics.files.urdf.rounded_angles import (
    DEGREES,
    describe_degrees,
    find_rounded_angles,
    note_rounded_angles,
    replace_rounded_angles,
)
from kinematics.files.urdf.validate import validate_robot, validate_tree
from kinematics.files.urdf.xml_tree import build_tree, name_file, read_bytes
from kinematics.model.document.element import Document, Element

if TYPE_CHECKING:
    from kinematics.model.linkage import UnassembledLinkage


def read_unassembled(
    model: Path | Document, loops: Path | None = None, options: ReadOptions | None = None
) -> UnassembledLinkage:
    """Read a linkage from its files, its loops not yet closed.

    Args:
        model: the file, or a document from a stream.
        loops: a YAML file with its loops; see `kinematics.files.urdf.loop_file`.
        options: changes to the file.

    Returns:
        The linkage as its file describes it.

    Raises:
        FileError: a file cannot be read as a linkage; the message gives place and reason.
    """
    options = options or ReadOptions()
    file = read_files(model, loops, options)
    # Libraries are loaded only for a file that was accepted.
    from kinematics.files.urdf.read import read_linkage

    return read_linkage(source_name(model), file, options)


def read_robot(
    model: Path | Document, nominal: bool = True, ground: str | None = None
) -> RobotFile:
    """Read and check a robot file, without the YAML file beside it.

    Args:
        model: the file, or a document from a stream.
        nominal: whether rounded angles will be replaced; see
            `kinematics.files.urdf.rounded_angles`.
        ground: name of the link that is the ground; see `kinematics.files.urdf.choose_ground`.

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
        robot, remarks = convert_to_urdf(root, data, path, ground)
        robot, told = choose_ground(robot, source, ground)
    if robot is not root:
        from kinematics.model.document.write_numbers import element_text

        document = Document(source, element_text(robot).encode())
    robot, odd = mend_oddities(robot, source)
    translation = _translate(validate_robot(robot, source), source, nominal)
    remarks = (*remarks, *told, *odd, *translation.remarks)
    return RobotFile(translation.tree, None, remarks, document, translation.dialects)


def _translate(tree: Element, source: str, nominal: bool) -> Translated:
    """Translate loops in the words of other tools, and check the tree again if there are."""
    with name_file(source):
        translation = translate_loops(tree, nominal)
        if translation.tree is not tree:
            validate_tree(translation.tree)
    return translation


def read_files(model: Path | Document, loops: Path | None, options: ReadOptions) -> RobotFile:
    """Read a robot file and the YAML file beside it, and replace rounded angles if wanted.

    Args:
        model: the file, or a document from a stream, which has no file beside it.
        loops: a YAML file with its loops; see `kinematics.files.urdf.loop_file`.
        options: changes to the file.

    Returns:
        The checked tree with its loops, the named inputs and the remarks.

    Raises:
        FileError: a file cannot be read as a linkage; the message gives place and reason.
    """
    source, nominal = source_name(model), options.angles == "nominal"
    robot = read_robot(model, nominal, options.ground)
    search = not isinstance(model, Document)
    merged = merge_loop_file(robot.tree, source, loops, search, robot.dialects)
    tree, repeated = drop_repeated_loops(merged.tree, robot.dialects)
    rounded = find_rounded_angles(tree)
    more: tuple[tuple[str, ...], ...] = ()
    if rounded:
        more = (note_rounded_angles(clean(source, 1000), rounded, options.angles),)
    if degrees := describe_degrees(tree):
        more = (*more, (DEGREES, f"{clean(source, 1000)}: {degrees}"))
    if nominal:
        tree, noise = remove_exporter_noise(replace_rounded_angles(tree), source)
        more = (*more, *noise)
    file = RobotFile(
        tree,
        merged.inputs,
        (*robot.remarks, *merged.remarks, *repeated, *more),
        robot.document,
        robot.dialects,
    )
    return settle_floating_joints(file, source, options.fix_base)
