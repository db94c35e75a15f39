"""Write the URDF file of a linkage at its reference pose: only origins of joints change.

A joint of the tree at position q from the pose of the file displaces its link by ``D(q)`` in
the frame of the joint, so its origin O becomes ``O D(q)``. Links keep their frames, and with
them inertias, meshes and the joints that they carry. The frames of loops do not change.
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal, localcontext
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np

from kinematics.error_text import clean
from kinematics.errors import FileError
from kinematics.files.urdf.edit_xml import Splice, Text, read_source
from kinematics.files.urdf.loop_joints import freedoms_of_joint, perpendicular_to, unit_vector
from kinematics.files.urdf.robot_tree import pose_matrix
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import coordinate_names
from kinematics.model.document.write_numbers import roll_pitch_yaw
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.screws import exp, revolute
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import COORDINATE_AXIS_DIFFERENCE

# Digits that stand for a double: with them, all of its digits are written.
DOUBLE_DIGITS = 16


class Posed(NamedTuple):
    """A file whose pose is the reference pose of a linkage.

    Attributes:
        data: its bytes.
        moved: positions of the joints that moved, from the pose of the file that was read, in
            radians and metres.
        beside: whether its loops are in a YAML file, which is needed beside it.
    """

    data: bytes
    moved: Mapping[str, float]
    beside: bool


def write_at_reference_pose(linkage: Linkage) -> Posed:
    """Write the URDF file of a linkage at the pose at which its loops were closed.

    Args:
        linkage: a linkage that was read from a file.

    Returns:
        The bytes of the file, and the joints that moved.

    Raises:
        FileError: the linkage was not read from a file, or the file cannot be read any more,
            or its joints are not those of the linkage, or a universal joint has turned about
            its second axis.
    """
    data, tree = read_source(linkage, "joint", "that could be written at another pose")
    assert linkage.tree is not None
    joints = {joint.name: joint for joint in tree.every("joint")}
    original_joints = {joint.name: joint for joint in linkage.tree.every("joint")}
    positions: dict[str, float] = {}
    if linkage.displaced is not None:
        pairs = zip(linkage.joints, linkage.displaced.tolist(), strict=True)
        positions = {joint.name: q for joint, q in pairs if q and not joint.in_loop}
    text, splices = Text(data), []
    for name, joint in original_joints.items():
        kind = joint.attributes["type"]
        q = [positions.get(each, 0.0) for each in coordinate_names(name, kind)]
        if any(q):
            if kind == "universal" and q[1]:
                problem = "a universal joint that has turned about its second axis"
                file, remedy = clean(linkage.source, 1000), "replace it by two joints"
                raise FileError(file, joint.label, problem, remedy)
            there = _with_digits(joint, moved_origin(joint, q), linkage)
            splices.append(_replace_origin(text, joints[name], there))
    loop_names = {loop.name for loop in tree.every("loop")}
    # Loops of the file in the words of other tools have a place there.
    added = (loop for loop in linkage.tree.every("loop") if loop.span == (0, 0))
    beside = any(loop.name not in loop_names for loop in added)
    return Posed(text.replace(splices), positions, beside)


def _replace_origin(text: Text, joint: Element, attributes: Mapping[str, str]) -> Splice:
    """Replace the origin of a joint, or add one as its first child."""
    words = " ".join(f"{name}={quoteattr(value)}" for name, value in attributes.items())
    old = joint.first("origin")
    if old is not None:
        return Splice(old.span[0], text.end(old), f"<{old.tag} {words}/>")
    at = joint.children[0].span[0]
    return Splice(at, at, f"<origin {words}/>{text.margin(at)}")


def moved_origin(joint: Element, q: list[float]) -> dict[str, str]:
    """Compute the attributes of the ``<origin>`` of a joint that has moved.

    Args:
        q: positions of its coordinates from the pose of the file, radians and metres.
    """
    old = joint.first("origin")
    attributes = {"xyz": "0 0 0", **(old.attributes if old is not None else {})}
    axis = joint.first("axis")
    n = unit_vector(axis.vector("xyz", "") if axis is not None else [1.0, 0.0, 0.0])
    kind = joint.attributes["type"]
    D = np.eye(4)
    for (_, screw), position in zip(_freedoms(joint, kind, n), q, strict=True):
        D = D @ exp(screw, position)
    there = pose_matrix(old) @ D
    if np.any(D[:3, 3]):
        attributes["xyz"] = " ".join(repr(x) for x in there[:3, 3].tolist())
    if kind != "prismatic" and any(q[3:] if kind == "floating" else q):
        words = attributes.get("rpy", "0 0 0").split()
        turning = q[-1] if kind == "planar" else q[0]
        several = kind in ("spherical", "floating")
        simple = None if several else _turn_words(words, n, turning)
        attributes["rpy"] = " ".join(simple or map(repr, roll_pitch_yaw(there[:3, :3])))
    return attributes


def _with_digits(joint: Element, there: dict[str, str], linkage: Linkage) -> dict[str, str]:
    """Write the numbers of an origin that have changed with as many digits as the file has.

    With more of them, a file that rounds the numbers of a special geometry would be read as
    one that misses it on purpose.
    """
    digits = 0 if linkage.meant is None else linkage.meant.digits
    if not 0 < digits < DOUBLE_DIGITS:
        return there
    old = joint.first("origin")
    attributes = {"rpy": "0 0 0", "xyz": "0 0 0", **(old.attributes if old is not None else {})}
    return {
        name: " ".join(
            word if word == before else f"{float(word):.{digits}g}"
            for word, before in zip(words.split(), attributes[name].split(), strict=True)
        )
        for name, words in there.items()
    }


def _freedoms(joint: Element, kind: str, n: Array) -> list[tuple[str, Array]]:
    """Kinds and screws of the freedoms of a joint, in its own frame."""
    thread = joint.first("screw_thread_pitch")
    if thread is not None:
        pitch = thread.vector("value", "")[0] / (2 * np.pi)
        return [("helical", revolute(n, np.zeros(3), pitch))]
    return freedoms_of_joint(kind, n, perpendicular_to(n), np.zeros(3))


def _turn_words(words: list[str], n: Array, angle: float) -> list[str] | None:
    """Words of ``rpy`` after a turn about n, if a single one of them changes; or None.

    ``R = Rz(yaw) Ry(pitch) Rx(roll)``: a turn about x adds to the roll, a turn about the y
    axis after the roll adds to the pitch, and so on.
    """
    roll, pitch, _ = (float(word) for word in words)
    rolled = exp(revolute(np.eye(3)[0], np.zeros(3)), roll)[:3, :3] @ n
    pitched = exp(revolute(np.eye(3)[1], np.zeros(3)), pitch)[:3, :3] @ rolled
    for k, direction in enumerate((n, rolled, pitched)):
        along = np.abs(direction) - np.eye(3)[k]
        if np.abs(along).max() <= COORDINATE_AXIS_DIFFERENCE:
            with localcontext() as context:
                context.prec = 60
                total = Decimal(words[k]) + Decimal(repr(float(angle * direction[k])))
            return [*words[:k], str(total), *words[k + 1 :]]
    return None
