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
from balance.studies.sketches.bars import (
    BarSection,
    UniformSolid,
    in_space,
    joined_inertial,
    make_bar,
)
from kinematics.model.document.element import Element

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
    section = BarSection(width, width)
    solids = [make_bar(a, b, section, STEEL * section.area) for a, b in pairwise(points)]
    if tool is not None:
        radius = (0.75 * TOOL_MASS / (np.pi * STEEL)) ** (1.0 / 3.0)
        ball = 0.4 * TOOL_MASS * radius**2 * np.eye(3)
        solids.append(UniformSolid(TOOL_MASS, in_space(tool), ball))
    return joined_inertial(solids)


def bar_width(lengths: Sequence[float]) -> float:
    """Choose the width of the bars of a mechanism, metres."""
    return SLENDER * max(lengths)
