"""Parts of prisms and cylinders where a quadratic is positive, constant along their axis.

They are a section of one thickness: of the integrals over rays in space, only those over rays
in the plane of the section are left, whose errors are far smaller for as many rays.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.rays import Rays, integrate_positive_part, unit_gauss
from balance.support.tolerances import CURVATURE_ZERO, PART_ROUND_OFF
from kinematics.numerics.array_types import Array

# Powers of τ in mass, first and second moments, with the factor τ of the area.
AREA_POWERS = (2, 3, 4)
# Rays to each piece of an edge.
GAUSS = 4


class Prism(NamedTuple):
    """A region of one thickness, in its unit coordinates.

    Attributes:
        axis: unit vector (3,) along its thickness.
        middle: height of its middle along it.
        half: half its thickness.
        corners: corners (n, 3) of its section at the middle, in order; none of a round one.
    """

    axis: Array
    middle: float
    half: float
    corners: Array


def prism_part(
    region: Region, form: Array, count: int, origin: tuple[float, float, float]
) -> Array | None:
    """Integrate ``[u; 1][u; 1]ᵀ`` over the part of a prism where a quadratic is positive.

    Args:
        region: the region.
        form: symmetric matrix (4, 4) of the quadratic, in unit coordinates.
        count: about how many rays sum up the section.
        origin: point of the region over which they start.

    Returns:
        The moments (4, 4) in unit coordinates; None if it is no prism along whose axis the
        quadratic is constant.
    """
    for prism in _prisms(region):
        along = np.abs(form[:, :3] @ prism.axis).max()
        if along <= CURVATURE_ZERO * np.abs(form).max():
            o = np.array(origin)
            o = o + (prism.middle - float(prism.axis @ o)) * prism.axis
            moments = (
                2.0
                * prism.half
                * integrate_positive_part(_section_rays(prism, count, o), form, AREA_POWERS)
            )
            across = np.outer(prism.axis, prism.axis)
            moments[:3, :3] += moments[3, 3] * prism.half**2 / 3.0 * across
            return np.asarray(moments)
    return None


@lru_cache(maxsize=32)
def _prisms(region: Region) -> list[Prism]:
    """List the axes along which a region has one thickness."""
    if region.kind == "cylinder":
        return [Prism(np.eye(3)[2], 0.0, 1.0, np.empty((0, 3)))]
    prisms: list[Prism] = []
    for axis in region.normals:
        heights = region.vertices @ axis
        low, high = float(heights.min()), float(heights.max())
        top = heights >= high - PART_ROUND_OFF
        first = next(x for x in axis if abs(x) > PART_ROUND_OFF)
        twice = any(abs(axis @ prism.axis) >= 1.0 - PART_ROUND_OFF for prism in prisms)
        if first < 0.0 or twice or not (top | (heights <= low + PART_ROUND_OFF)).all():
            continue
        corners = region.vertices[top] - 0.5 * (high - low) * axis
        if _turned_round(corners, axis, region.vertices[~top]):
            prisms.append(
                Prism(axis, 0.5 * (low + high), 0.5 * (high - low), _ordered(corners, axis))
            )
    return prisms


def _turned_round(corners: Array, axis: Array, bottom: Array) -> bool:
    """Whether the corners of the bottom are below those of the middle section."""
    if len(bottom) != len(corners):
        return False
    across = (bottom[:, None] - corners) - ((bottom[:, None] - corners) @ axis)[
        ..., None
    ] * axis
    return bool(np.linalg.norm(across, axis=2).min(axis=1).max() <= PART_ROUND_OFF)


def _ordered(corners: Array, axis: Array) -> Array:
    """Order the corners of a convex polygon, counter-clockwise about an axis."""
    away = corners - corners.mean(axis=0)
    e1 = away[0] / np.linalg.norm(away[0])
    turn = np.arctan2(away @ np.cross(axis, e1), away @ e1)
    return np.asarray(corners[np.argsort(turn)])


def _section_rays(prism: Prism, count: int, origin: Array) -> Rays:
    """Choose rays from a point of the section of a prism to its edge."""
    if not len(prism.corners):
        turn = (np.arange(count) + 0.5) * (2.0 * np.pi / count)
        rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
        weights = (1.0 - rim @ origin) * (2.0 * np.pi / count)
        return Rays(origin, (rim - origin).T, weights)
    pieces = max(1, count // (GAUSS * len(prism.corners)))
    nodes, share = unit_gauss(GAUSS)
    x = ((np.arange(pieces)[:, None] + nodes) / pieces).reshape(-1)
    w = np.tile(share / pieces, pieces)
    sides = np.roll(prism.corners, -1, axis=0) - prism.corners
    ends = (prism.corners[:, None] + x[:, None] * sides[:, None]).reshape(-1, 3)
    outward = np.cross(sides, prism.axis)
    heights = ((prism.corners - origin) * outward).sum(axis=1)
    return Rays(origin, (ends - origin).T, np.outer(heights, w).reshape(-1))
