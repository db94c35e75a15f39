"""Convert the elements of a robot file to those of a URDF file, by its root element."""

from __future__ import annotations

from typing import NamedTuple

from kinematics.model.document.element import Element


class Converted(NamedTuple):
    """The elements of a URDF file, and what was not read of the file they came from.

    Attributes:
        robot: the ``<robot>`` element, not yet checked.
        remarks: code and message of each remark for the user.
    """

    robot: Element
    remarks: tuple[tuple[str, str], ...] = ()


def convert_to_urdf(
    root: Element, data: bytes, path: str | None, ground: str | None = None
) -> Converted:
    """Convert the elements of a file to those of a URDF file.

    Args:
        root: the root element of the file.
        path: the file, from which others may be included; None for a stream.
        ground: name of the link that is the ground of an SDF model; None for the default.

    Returns:
        The ``<robot>`` element: ``root`` itself if the file is URDF.

    Raises:
        Refusal: the file has something that cannot be converted.
    """
    remarks: tuple[tuple[str, str], ...] = ()
    if b"xacro" in data or b"${" in data:
        from kinematics.files.formats.find_xacro import uses_xacro

        if uses_xacro(root):
            from kinematics.files.formats.expand_xacro import EXPANDED, expand_xacro

            root, remarks = expand_xacro(data, path), (EXPANDED,)
    converted = _convert_expanded(root, path, ground)
    return converted._replace(remarks=(*remarks, *converted.remarks))


def _convert_expanded(root: Element, path: str | None, ground: str | None) -> Converted:
    """Convert the elements of a file without xacro, by the tag of its root."""
    if root.tag == "sdf":
        from kinematics.files.formats.sdf.convert_model import convert_sdf

        return Converted(*convert_sdf(root, ground, path))
    if root.tag == "mujoco":
        from kinematics.files.formats.mjcf.convert_file import convert_mjcf

        return Converted(*convert_mjcf(root, path))
    return Converted(root)
