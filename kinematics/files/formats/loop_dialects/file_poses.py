"""Poses of links at the pose of the file, in rational numbers, for frames given on one link.

Decimals and right angles are exact, so that a loop with such a frame closes in the exact
arithmetic just as one with both frames written by hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from kinematics.errors import ExactError
from kinematics.files.formats.loop_dialects.decimal_words import decimal_word, word_value
from kinematics.files.urdf.loop_joints import perpendicular_to, unit_vector
from kinematics.files.urdf.rational_joints import RationalJoints
from kinematics.files.urdf.rational_poses import AXES, RationalPose
from kinematics.files.urdf.read import read_linkage
from kinematics.files.urdf.read_options import ReadOptions, RobotFile
from kinematics.files.urdf.robot_tree import pose_matrix
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words, roll_pitch_yaw
from kinematics.model.spatial.screws import exp, revolute
from kinematics.numerics.linalg.rational import Vector, dot, scale_vector


class FilePoses:
    """Poses of all links at the pose of the file."""

    def __init__(self, tree: Element) -> None:
        """Compute the poses of a checked tree without loops, in which a joint moves."""
        self._exact: RationalJoints | None = None
        try:
            self._exact = RationalJoints(tree)
            self._poses = self._exact.poses
        except ExactError:
            file = RobotFile(tree)
            places = read_linkage("", file, ReadOptions(bodies="all")).places
            self._poses = {name: _rational(place.pose) for name, place in places.items()}

    def frame(self, link: str, origin: Element | None) -> RationalPose:
        """Compute the pose of a frame on a link, in the inertial frame.

        Args:
            link: name of the link.
            origin: checked ``<origin>`` of the frame; the frame of the link without one.
        """
        return self._poses[link] @ self.pose(origin)

    def pose(self, origin: Element | None) -> RationalPose:
        """Compute the pose of a checked ``<origin>`` in the frame of its link."""
        if self._exact is not None:
            try:
                return self._exact.origin_pose("", origin)
            except ExactError:
                pass
        return _rational(pose_matrix(origin))

    def origin_on(self, link: str, frame: RationalPose, line: int) -> Element:
        """Make the ``<origin>`` on a link of a frame that is given in the inertial frame.

        Args:
            link: name of the link.
            frame: pose of the frame, in the inertial frame.
            line: of the element that gives it.
        """
        return self.origin_of(_inverse(self._poses[link]) @ frame, line)

    @staticmethod
    def origin_of(pose: RationalPose, line: int) -> Element:
        """Make the ``<origin>`` of a pose in the frame of its link.

        Args:
            line: of the element that gives it.
        """
        attributes = {"xyz": _vector_text(pose.d)}
        if pose.R != AXES:
            R = np.array([[float(x) for x in row] for row in pose.R])
            attributes["rpy"] = number_words(roll_pitch_yaw(R))
        return Element("origin", attributes, (), line)

    def direction(self, text: str, given: RationalPose, wanted: RationalPose) -> str:
        """Convert a direction from one frame to another.

        Args:
            text: three numbers in the first frame.
            wanted: pose of the second frame.
        """
        a: Vector = tuple(word_value(word) for word in text.split())
        return _vector_text(_inverse(wanted).turn(given.turn(a)))


def _vector_text(values: Sequence[Fraction]) -> str:
    """Write numbers as decimals: exactly if they have a few digits, else to 17 digits."""
    return " ".join(decimal_word(x) for x in values)


def quaternion_pose(words: Sequence[str]) -> RationalPose | None:
    """Compute a pose from position and quaternion ``x y z qw qx qy qz``; None if that is zero.

    Args:
        words: seven finite numbers.
    """
    *position, w, x, y, z = (word_value(word) for word in words)
    q = (w, x, y, z)
    square = dot(q, q)
    if not square:
        return None
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return RationalPose(tuple(scale_vector(1 / square, row) for row in rows), tuple(position))


def turn_between(first: str, second: str) -> str:
    """Compute ``rpy`` of the least rotation that turns one direction to another; radians.

    Args:
        first: three numbers, not all zero.
        second: three numbers, not all zero.
    """
    a, b = (unit_vector([float(word) for word in text.split()]) for text in (first, second))
    across, along = np.cross(a, b), float(a @ b)
    size = float(np.linalg.norm(across))
    axis = across / size if size > 1e-12 else perpendicular_to(a)
    R = exp(revolute(axis, np.zeros(3)), float(np.arctan2(size, along)))[:3, :3]
    return number_words(roll_pitch_yaw(R))


def _inverse(pose: RationalPose) -> RationalPose:
    back = RationalPose(tuple(zip(*pose.R, strict=True)))
    return RationalPose(back.R, scale_vector(-1, back.turn(pose.d)))


def _rational(pose: np.ndarray) -> RationalPose:
    rows = [[Fraction(x) for x in row] for row in pose[:3].tolist()]
    return RationalPose(tuple(tuple(row[:3]) for row in rows), tuple(row[3] for row in rows))
