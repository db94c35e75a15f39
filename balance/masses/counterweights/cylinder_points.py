"""Points of cylinders for point masses: some to begin with, and those that are missing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from balance.masses.counterweights.quadratic_minimum import minimise_in_region
from balance.masses.counterweights.regions import Region
from balance.support.tolerances import PRICE_NEGATIVE
from kinematics.numerics.array_types import Array

# Points on each of the circles at the ends and in the middle.
AROUND = 24
# Most points of one cylinder; a program that needs more stays undecided.
MOST_POINTS = 300


def first_points() -> Array:
    """Return points (n, 3) in the unit coordinates of a cylinder, on its surface and axis."""
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    ring = np.concatenate([circle, np.zeros((1, 2))])
    return np.concatenate(
        [np.column_stack([ring, np.full(len(ring), z)]) for z in (-1.0, 0.0, 1.0)]
    )


def missing_points(
    regions: Mapping[int, Region], forms: Array, points: Mapping[int, Array]
) -> dict[int, Array]:
    """Find the points of cylinders at which the dual polynomials are negative.

    Args:
        regions: region by position of the body.
        forms: polynomials (links, 4, 4) in unit coordinates.
        points: points that each cylinder has (n, 3), by position of its link.

    Returns:
        New points (1, 3), by position of the link; empty if there are none, or enough.
    """
    new_points, kinds = {}, list(regions.values())
    for k, existing in points.items():
        least, at = minimise_in_region(kinds[k], forms[k])
        size = float(np.abs(forms[k]).max())
        if least < -PRICE_NEGATIVE * size and len(existing) < MOST_POINTS:
            new_points[k] = at[None]
    return new_points
