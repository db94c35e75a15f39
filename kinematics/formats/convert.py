"""Convert the elements of a robot file to those of a URDF file, by its root element."""

from __future__ import annotations

from typing import NamedTuple

from kinematics.urdf_elements.element import Element

__all__ = ["Converted", "convert_to_urdf"]


class Converted(NamedTuple):
    """The elements of a URDF file, and what was not read of the file they came from.

    Attributes:
        robot: the ``<robot>`` element, not yet checked.
        remarks: code and message of each remark for the user.
    """

    robot: Element
    remarks: tuple[tuple[str, str], ...] = ()


def convert_to_urdf(root: Element, data: bytes, path: str | None) -> Converted:
    """Convert the elements of a file to those of a URDF file.

    Args:
        root: the root element of the file.
        data: its bytes.
        path: the file, from which others may be included; None for a stream.

    Returns:
        The ``<robot>`` element: ``root`` itself if the file is URDF.

    Raises:
        Refusal: the file has something that cannot be converted.
    """
    if root.tag == "mujoco":
        from kinematics.formats.mjcf.convert_file import convert_mjcf

        return Converted(*convert_mjcf(root, path))
    return Converted(root)
