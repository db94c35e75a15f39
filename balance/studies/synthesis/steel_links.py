"""Masses of links as they would be built: square bars of steel between the joints.

The crank and the rocker are bars from joint to joint; the coupler is a triangle of three bars,
to both joints and to the tool, a ball of steel. Bars are as wide as a fraction of the longest
link.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from balance.masses.designs.density import STEEL
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.numerics.array_types import Array

TOOL_MASS = 1.0
"""Mass of the tool, kg."""
# Width of a bar over the length of the longest link.
SLENDER = 1.0 / 40.0


def bars_inertial(
    points: Sequence[complex], width: float, tool: complex | None = None
) -> Element:
    """Make the ``<inertial>`` of bars from point to point, and of a tool.

    Args:
        points: in the frame of the link, metres.
        width: of the square section, metres.
        tool: where the ball of the tool is; None: there is none.
    """
    masses, centres, tensors = list[float](), list[Array](), list[Array]()
    for a, b in pairwise(points):
        length = abs(b - a)
        mass = STEEL * width**2 * length
        along = np.array([(b - a).real, (b - a).imag, 0.0]) / length
        across = mass * (length**2 + width**2) / 12.0
        axial = mass * width**2 / 6.0
        masses.append(mass)
        centres.append(_space(0.5 * (a + b)))
        tensors.append(across * np.eye(3) + (axial - across) * np.outer(along, along))
    if tool is not None:
        radius = (0.75 * TOOL_MASS / (np.pi * STEEL)) ** (1.0 / 3.0)
        masses.append(TOOL_MASS)
        centres.append(_space(tool))
        tensors.append(0.4 * TOOL_MASS * radius**2 * np.eye(3))
    mass = sum(masses)
    centre = np.average(centres, axis=0, weights=masses)
    tensor = np.zeros((3, 3))
    for m, r, central in zip(masses, centres, tensors, strict=True):
        apart = r - centre
        tensor += central + m * (apart @ apart * np.eye(3) - np.outer(apart, apart))
    at = Element("origin", {"xyz": number_words([float(x) for x in centre])})
    return make_elements.inertial(mass, tensor, at)


def bar_width(lengths: Sequence[float]) -> float:
    """Choose the width of the bars of a mechanism, metres."""
    return SLENDER * max(lengths)


def _space(z: complex) -> Array:
    """Write a point of the plane in space."""
    return np.array([z.real, z.imag, 0.0])
