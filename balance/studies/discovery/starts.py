"""Starts: joints anywhere, or near those of a linkage, so that every start is assembled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.studies.discovery.structure import LaneGeometry, TopologyArrays

Array = NDArray[np.float64]

# Least and largest size of the random changes of a linkage, over its size.
NEAREST, FARTHEST = 0.01, 1.0


def random_starts(structure: TopologyArrays, seed: int, numbers: range) -> LaneGeometry:
    """Draw starts: normally distributed points, and directions that are equally likely.

    Args:
        seed: seed of all starts.
        numbers: numbers of the starts; a start depends on its number alone.
    """
    drawn = [_draw(structure, np.random.default_rng([seed, number])) for number in numbers]
    points, axes = (np.stack(arrays) for arrays in zip(*drawn, strict=True))
    return structure.normalise(LaneGeometry(points, axes))


def starts_near(
    structure: TopologyArrays, origin: LaneGeometry, seed: int, numbers: range
) -> LaneGeometry:
    """Change a linkage by random amounts, from a hundredth of its size to all of it.

    Args:
        origin: the linkage, in one lane.
        seed: seed of all starts.
        numbers: numbers of the starts; 0 is the linkage itself.
    """
    count = len(structure.shifts)
    steps = []
    for number in numbers:
        rng = np.random.default_rng([seed, number])
        size = NEAREST * (FARTHEST / NEAREST) ** rng.random()
        steps.append((number > 0) * size * rng.standard_normal(count))
    many = LaneGeometry(*(np.repeat(array, len(steps), axis=0) for array in origin))
    return structure.change(many, np.stack(steps))


def _draw(structure: TopologyArrays, rng: np.random.Generator) -> tuple[Array, Array]:
    """Draw points and axes (joints, 3) of one start."""
    n = len(structure.parent)
    points = rng.standard_normal((structure.origin.max() + 1, 3))[structure.origin]
    axes = rng.standard_normal((n, 3))
    if structure.planar:
        points[:, 2] = axes[:, 2] = 0.0
        axes = np.where(structure.sliding[:, None], axes, np.eye(3)[2])
    axes[structure.free_axes] = np.tile(np.eye(3), (int(structure.free_axes.sum()) // 3, 1))
    return points, axes
