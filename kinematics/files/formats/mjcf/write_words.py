"""Write poses of a compiled MJCF file as ``<origin>`` elements, without round-off.

MuJoCo keeps rotations as quaternions and composes frames in double precision. The words of
the file come back if they have at most 15 digits, and multiples of π/12 to all digits.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from kinematics.files.urdf.validate_fields import MAX_NUMBER
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words, roll_pitch_yaw
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import EXACT_ANGLE_ERROR

# Decimals that are kept of numbers of size 1: the next are round-off.
DIGITS = 15
_TWELFTH = math.pi / 12


def rotation_matrix(quaternion: ArrayLike) -> Array:
    """Compute the rotation matrix (3, 3) of a quaternion (w, x, y, z) of any length.

    Without a length the entries are nan, which the check of the file refuses.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def round_to(values: ArrayLike, size: float) -> Array:
    """Round numbers to the digits that are significant beside numbers of a size.

    Args:
        size: of the largest; numbers are left alone if it is zero or not finite.
    """
    x = np.asarray(values, dtype=np.float64)
    if not (np.isfinite(size) and 1e-100 < size < 1e100):
        return x
    return np.round(x, DIGITS - math.ceil(math.log10(size)))


def write_origin(position: ArrayLike, rotation: ArrayLike, size: float) -> Element:
    """Make the ``<origin>`` of a pose.

    Args:
        position: (3,), metres.
        rotation: quaternion (w, x, y, z), or matrix (3, 3).
        size: of the linkage, metres.
    """
    attributes = {"xyz": number_words(round_to(position, size))}
    R = np.asarray(rotation, dtype=np.float64)
    angles = [_round_angle(a) for a in roll_pitch_yaw(rotation_matrix(R) if R.ndim == 1 else R)]
    if any(angles):
        attributes["rpy"] = number_words(angles)
    return Element("origin", attributes)


def is_identity(at: Element) -> bool:
    """Return whether an ``<origin>`` displaces nothing."""
    return not any(at.vector("xyz", "0 0 0") + at.vector("rpy", "0 0 0"))


def direction_words(axis: ArrayLike, given: ArrayLike) -> str:
    """Write the axis of a joint.

    Args:
        axis: unit vector (3,) of the compiled joint.
        given: vector (3,) of the file, which is written if it has the same direction.
    """
    n, a = np.asarray(axis, dtype=np.float64), np.asarray(given, dtype=np.float64)
    length = np.linalg.norm(a) if np.abs(a).max() <= MAX_NUMBER else 0.0
    same = length > 0.0 and np.abs(a / length - n).max() <= EXACT_ANGLE_ERROR
    return number_words(a if same else round_to(n, 1.0))


def _round_angle(angle: float) -> float:
    """Round an angle to a multiple of π/12, to all its digits, or to 15 decimals; -π to π."""
    if not math.isfinite(angle):
        return angle
    k = round(angle / _TWELFTH)
    if abs(angle - k * _TWELFTH) <= EXACT_ANGLE_ERROR:
        return math.pi * (12 if k == -12 else k) / 12
    return round(angle, DIGITS)
