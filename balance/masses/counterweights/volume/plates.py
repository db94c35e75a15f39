"""Plates: matter of planar linkages, of a thickness, in equal halves about their plane.

A plate has the outline of the section of a region with the plane through the middle of the
mechanism. It is a region itself: a cylinder on an ellipse, or a prism.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from balance.masses.counterweights.regions import Region, hull_region
from balance.masses.counterweights.volume.stock import Stock
from balance.masses.designs.density import DensityLimit
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import PLATE_UPRIGHT
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze

Array = NDArray[np.float64]


def stocks_of(
    space: DesignSpace, regions: Mapping[int, Region], limit: DensityLimit
) -> dict[int, Stock]:
    """Find the matter of limited density that regions hold.

    Args:
        space: a design space of the linkage.
        regions: region by position of the body.
        limit: the density; with a thickness, matter is in plates.

    Raises:
        UsageError: a thickness for a linkage in space, or a region that has no section with the
            plane of the linkage of a known form.
    """
    if limit.thickness is None:
        return {b: Stock(region, limit.density) for b, region in regions.items()}
    if not space.linkage.planar:
        raise UsageError("the linkage is not planar: plates of a thickness are for planar ones")
    frame = space.linkage.chain.frame
    across = frame.R[2]
    stocks = {}
    for b, region in regions.items():
        R, origin = space.frames[b, :3, :3], space.frames[b, :3, 3]
        normal = R.T @ across
        height = float(across @ (frame.origin - origin))
        try:
            plate = _plate(region, normal, height, limit.thickness)
        except UsageError as error:
            raise UsageError(f"link '{space.bodies[b]}': {error}") from None
        stocks[b] = Stock(plate, limit.density, _mirror(plate, normal, height))
    return stocks


def _plate(region: Region, normal: Array, height: float, thickness: float) -> Region:
    """Make the plate on the section of a region with the plane ``normal·x = height``."""
    text = f"{region.text}, {thickness:g} m thick"
    half, A = 0.5 * thickness * normal, region.place[:3, :3]
    if region.offsets.size:
        corners = region.to_link(region.vertices)
        return _prism(_section(corners, normal, height), half, text)
    across = A.T @ normal
    size = float(np.linalg.norm(across))
    nu, delta = across / size, (height - float(normal @ region.centre)) / size
    if not abs(delta) < 1.0:
        raise UsageError(MISSED.format(region.text))
    e1 = np.cross(nu, np.eye(3)[int(np.argmin(np.abs(nu)))])
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(nu, e1)
    radius = float(np.sqrt(1.0 - delta * delta))
    if region.kind == "cylinder":
        if abs(nu[2]) <= PLATE_UPRIGHT:
            z, side = np.eye(3)[2], radius * np.cross(nu, np.eye(3)[2])
            corners = np.array(
                [delta * nu + i * side + j * z for i in (-1, 1) for j in (-1, 1)]
            )
            return _prism(region.to_link(corners), half, text)
        if np.hypot(nu[0], nu[1]) > PLATE_UPRIGHT:
            raise UsageError(
                f"region {region.text} is oblique to the plane of the linkage: plates need a "
                "cylinder along the plane or across it"
            )
        radius = 1.0
    place = np.eye(4)
    place[:3, :3] = np.column_stack([radius * A @ e1, radius * A @ e2, half])
    place[:3, 3] = region.to_link(delta * nu)
    return replace(region, kind="cylinder", place=freeze(place), text=text)


MISSED = (
    "region {} does not meet the plane of the linkage, where plates are: move it, or leave out "
    "the thickness"
)


def _section(corners: Array, normal: Array, height: float) -> Array:
    """Compute points (n, 3) whose hull is the section of the hull of corners with a plane."""
    h = corners @ normal - height
    i, j = np.nonzero((h[:, None] > 0.0) & (h[None] < 0.0))
    share = (h[i] / (h[i] - h[j]))[:, None]
    points = np.concatenate([corners[i] + share * (corners[j] - corners[i]), corners[h == 0.0]])
    return np.asarray(points)


def _prism(section: Array, half: Array, text: str) -> Region:
    """Make the prism on a section."""
    if len(section) < 3:
        raise UsageError(MISSED.format(text))
    return hull_region(np.concatenate([section - half, section + half]), text)


def _mirror(region: Region, normal: Array, height: float) -> Array:
    """Compute the reflection (4, 4) about a plane of the link frame, in unit coordinates."""
    reflection = np.eye(4)
    reflection[:3, :3] -= 2.0 * np.outer(normal, normal)
    reflection[:3, 3] = 2.0 * height * normal
    return np.asarray(np.linalg.solve(region.place, reflection @ region.place))
