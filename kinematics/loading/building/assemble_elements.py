"""Assemble a linkage from elements that a program made, as from those of a file.

The elements pass the checks of the reader and its later steps. Their text becomes the document
of the linkage, so that functions which need a file work on it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import FileError
from kinematics.files.urdf.floating_joints import settle_floating_joints
from kinematics.files.urdf.loop_file import merge_loop_file
from kinematics.files.urdf.read import read_linkage
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.files.urdf.validate import validate_robot
from kinematics.files.urdf.xml_tree import name_file
from kinematics.model.document.element import Document, Element
from kinematics.model.document.write_numbers import element_text
from kinematics.model.linkage import Linkage

Remarks = Sequence[tuple[str, ...]]


def assemble_elements(
    robot: Element,
    source: str,
    inputs: Sequence[str] | None = None,
    options: ReadOptions | None = None,
    remarks: Remarks = (),
) -> Linkage:
    """Check the elements of a linkage, close its loops and choose its coordinates.

    Args:
        robot: the ``<robot>`` element; its angles are read as they are.
        source: name of the linkage in messages.
        inputs: names of joints to use as independent coordinates.
        options: changes to the elements.
        remarks: those of `kinematics.files.urdf.read_options.RobotFile`.

    Returns:
        The linkage at its reference pose, SI units.

    Raises:
        LinkageError: the linkage cannot be used; the subclass gives the reason.
    """
    options = options or ReadOptions()
    with faults_of(source):
        tree = validate_robot(robot, source)
        file = merge_loop_file(tree, source, search=False)
        document = Document(source, element_text(tree).encode())
        file = file._replace(remarks=(*remarks, *file.remarks), document=document)
        file = settle_floating_joints(file, source, options.fix_base)
        draft = read_linkage(source, file, options)
    return assemble(draft, inputs)


@contextmanager
def faults_of(source: str) -> Iterator[None]:
    """Convert a `Refusal` inside the block to a `FileError`, with remedies for Python."""
    try:
        with name_file(source):
            yield
    except FileError as error:
        remedy = error.remedy.replace("a <loop> element", "an item of loops")
        remedy = remedy.replace("use --bodies all", "give no bodies at all")
        if remedy == error.remedy:
            raise
        raise FileError(error.file, error.element, error.problem, remedy) from None
