"""Limits of joints as the file of a linkage states them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinematics.model.document.element import Element
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array


def joint_limits(linkage: Linkage) -> Array:
    """Read the least and largest positions of all joints, counted from the reference pose.

    Joints of type ``continuous``, those without limits, and those of several degrees of freedom
    have none; equal limits, as of files that name them only because a parser asks for them, are
    none either.

    Returns:
        Shape (2, n): rad and m; infinite where there is no limit.
    """
    limits = np.full((2, len(linkage.joints)), [[-np.inf], [np.inf]])
    moved = np.zeros(len(linkage.joints)) if linkage.displaced is None else linkage.displaced
    for j, element, limit in _limit_elements(linkage):
        if element.attributes.get("type") not in ("revolute", "prismatic"):
            continue
        (low,), (high,) = limit.vector("lower", "0"), limit.vector("upper", "0")
        if low < high:
            limits[:, j] = low - moved[j], high - moved[j]
    return limits


def drive_limits(linkage: Linkage) -> tuple[Array, Array]:
    """Read the largest speeds, and the largest forces or torques, of all joints.

    Numbers that are missing, and those that are not above 0, are no limits.

    Returns:
        Speeds (n,), rad/s and m/s, and torques or forces (n,), N m and N; infinite where there
        is no limit.
    """
    limits = np.full((2, len(linkage.joints)), np.inf)
    for j, _, limit in _limit_elements(linkage):
        for k, attribute in enumerate(("velocity", "effort")):
            limits[k, j] = _size(limit.attributes.get(attribute, "0"))
    return limits[0], limits[1]


def _limit_elements(linkage: Linkage) -> Iterator[tuple[int, Element, Element]]:
    """Yield the joints with limits in the file: number, element, and that of its limits."""
    joints = () if linkage.tree is None else linkage.tree.every("joint")
    elements = {item.name: item for item in joints}
    for j, joint in enumerate(linkage.joints):
        element = elements.get(joint.name)
        limit = None if element is None else element.first("limit")
        if element is not None and limit is not None:
            yield j, element, limit


def _size(text: str) -> float:
    """Convert the text of a limit to a number; infinite if it is none."""
    try:
        value = float(text)
    except ValueError:
        return np.inf
    return value if value > 0.0 else np.inf
