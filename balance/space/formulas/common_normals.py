"""Axes of joints, and the common normals of two of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from balance.support.tolerances import FORMULA_ZERO
from kinematics.numerics.array_types import Array


@dataclass(eq=False)
class PlacedAxis:
    """The line of a joint, or its point, and where it is used."""

    name: str
    kind: str
    point: Array
    direction: Array
    ends: tuple[int, int]
    joints: tuple[int, ...]


def normal_between(
    a: PlacedAxis, b: PlacedAxis, size: float
) -> tuple[Array | None, Array, float, float]:
    """Find the common normal of two lines or points.

    Args:
        a: the first one.
        b: the second one.
        size: of the linkage; what is below round-off of it vanishes.

    Returns:
        Its foot on the first one, None if any point of it is one; its direction, 0 if it is not
        determined; its length; and the sine of the angle of two lines, 0 for points.
    """
    gap = b.point - a.point
    if a.kind == "spherical" or b.kind == "spherical":
        side = gap
        foot: Array | None = a.point
        if a.kind != "spherical":
            foot = a.point + a.direction * (a.direction @ gap)
            side = b.point - foot
        elif b.kind != "spherical":
            side = gap - b.direction * (b.direction @ gap)
        length = float(np.linalg.norm(side))
        if length <= FORMULA_ZERO * size:
            return foot, np.zeros(3), 0.0, 0.0
        return foot, side / length, length, 0.0
    across = np.cross(a.direction, b.direction)
    sine = float(np.linalg.norm(across))
    if sine <= FORMULA_ZERO:
        side = gap - a.direction * (a.direction @ gap)
        length = float(np.linalg.norm(side))
        if length <= FORMULA_ZERO * size:
            return None, np.zeros(3), 0.0, 0.0
        return None, side / length, length, 0.0
    normal = across / sine
    length = float(normal @ gap)
    foot = a.point + a.direction * float(np.cross(gap, b.direction) @ across) / sine**2
    if abs(length) <= FORMULA_ZERO * size:
        return foot, normal, 0.0, sine
    return foot, normal * np.sign(length), abs(length), sine


def unit_vector_across(direction: Array) -> Array:
    """Return a unit vector across another one."""
    axis = np.eye(3)[int(np.argmin(np.abs(direction)))]
    across = np.cross(direction, axis)
    return np.asarray(across / np.linalg.norm(across))
