"""Convert an MJCF file to the elements of a URDF file with loops."""

from __future__ import annotations

import os
from collections.abc import Iterator

from kinematics.files.formats.mjcf.body_tree import BodyTree
from kinematics.files.formats.mjcf.compile_file import compile_file
from kinematics.files.formats.mjcf.equalities import EqualityReader
from kinematics.files.formats.mjcf.includes import expand_includes
from kinematics.files.formats.mjcf.reduce_file import reduce_file
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element

NOT_READ = "not_read"
"""The code of remarks on what a file has and a linkage does not."""

Remarks = tuple[tuple[str, str], ...]


def convert_mjcf(root: Element, path: str | None) -> tuple[Element, Remarks]:
    """Convert the elements of an MJCF file to those of a URDF file.

    The reference pose is ``qpos0``; joint positions count from there. A connect becomes a
    spherical loop, a weld a fixed loop, and a linear constraint between joints a ``<mimic>``.

    Args:
        root: the ``<mujoco>`` element.
        path: its file; None for a stream.

    Returns:
        The ``<robot>`` element, and code and message of each remark.

    Raises:
        PackageError: MuJoCo is not installed.
        Refusal: the file cannot be converted, or MuJoCo refuses it.
    """
    root = expand_includes(root, path)
    file = reduce_file(root)
    compiled = compile_file(file, None if path is None else os.path.dirname(path))
    tree = BodyTree(compiled)
    equalities = EqualityReader(tree, file.disabled)
    equalities.couple_joints()
    parts = list(tree.parts())
    parts += equalities.loops()
    parts += _transmissions(root, set(tree.joints))
    stem = os.path.splitext(os.path.basename(path or ""))[0]
    name = root.attributes.get("model", "").strip() or stem or "mjcf"
    texts = (*file.remarks, *equalities.remarks, *compiled.warnings)
    place = path or "MJCF"
    remarks = [(NOT_READ, f"{place}: {text}") for text in texts]
    return make_elements.robot(name, parts), tuple(remarks)


def _transmissions(root: Element, joints: set[str]) -> Iterator[Element]:
    """Make a ``<transmission>`` for every joint with an actuator: a preferred input."""
    seen: set[str] = set()
    for section in root.every("actuator"):
        for item in section.children:
            joint = item.attributes.get("joint") or item.attributes.get("jointinparent", "")
            if joint in joints and joint not in seen:
                seen.add(joint)
                inside = (Element("joint", {"name": joint}),)
                yield Element("transmission", {"name": item.name or f"{joint}_drive"}, inside)
