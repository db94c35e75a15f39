"""Pantographs whose links turn in a varying ratio, through two or three positions.

The masses are given, and the pivots are searched for which the motion without momentum passes
through the positions: along a line for two positions (`pivot_line`), in the plane for three.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from balance.studies.synthesis.angle_error import chain_angles
from balance.studies.synthesis.balanced_pantograph import BalancedPantograph
from balance.studies.synthesis.error_map import offsets_without_error
from balance.studies.synthesis.pantograph import PantographMasses
from balance.studies.synthesis.pivot_line import PivotLine
from balance.studies.synthesis.positions import Position, displacements
from balance.studies.synthesis.rr_chain import RRChain
from balance.studies.synthesis.three_positions import CrossingMap, crossing_map


def through_two_positions(
    positions: Sequence[Position], line: PivotLine, masses: PantographMasses,
    low: float, high: float,
) -> tuple[BalancedPantograph, ...]:  # fmt: skip
    """Find the pantographs through two positions with a pivot on a line.

    Args:
        positions: two positions of the tool.
        line: of the pivot that is not chosen.
        low: least offset of the pivot, metres.
    """
    offsets = offsets_without_error(positions, line, masses, low, high)
    return _pantographs(positions, *line.pivots(offsets), masses)


def through_three_positions(
    positions: Sequence[Position], masses: PantographMasses,
    window: tuple[float, float, float, float],
    progress: Callable[[int, int], None] | None = None,
) -> tuple[tuple[BalancedPantograph, ...], CrossingMap]:  # fmt: skip
    """Find the pantographs through three positions.

    Args:
        positions: three positions of the tool.
        window: of the moving pivots, see `crossing_map`.
        progress: as of `crossing_map`.

    Returns:
        The pantographs, and the map with which they were found.
    """
    crossings = crossing_map(positions, masses, window, progress=progress)
    return _pantographs(positions, crossings.fixed, crossings.moving, masses), crossings


def _pantographs(
    positions: Sequence[Position], fixed: ArrayLike, moving: ArrayLike, masses: PantographMasses
) -> tuple[BalancedPantograph, ...]:
    """Build the pantographs on pivots."""
    steps, G, W = displacements(positions), np.asarray(fixed), np.asarray(moving)
    angles = chain_angles(positions[0], steps, G, W, masses)
    turns = np.cumsum(angles.link_turns, axis=0)
    pantographs = []
    for k in range(len(G)):
        beta = (0.0, *turns[:, k].tolist())
        chain = RRChain(tuple(positions), complex(G[k]), complex(W[k]), beta)
        pantographs.append(BalancedPantograph(chain, masses))
    return tuple(pantographs)
