"""Plates: matter of planar linkages, of a thickness, in equal halves about their plane.

A plate has the outline of the section of a region with the plane through the middle of the
mechanism. It is a region itself: a cylinder on an ellipse, or a prism.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from balance.masses.counterweights.regions import Region, hull_region
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.designs.density import DensityLimit
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import PLATE_UPRIGHT
from kinematics.errors import BodyError, UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array


def density_limits(
    space: DesignSpace,
    regions: Mapping[int, Region],
    density: float | Mapping[str, float] | None,
    thickness: float | None,
) -> dict[int, DensityLimit]:
    """Check the densities of added matter, and its thickness.

    Args:
        space: a design space of the linkage.
        regions: region by position of the body.
        density: kg/m³, of all links or by name of each; None for point masses.
        thickness: that of plates, m; None for other matter.

    Returns:
        The limits by position of the body; empty without a density.

    Raises:
        BodyError: a link has a density and no region.
        UsageError: a link has none, a number is not above 0, or there is a thickness without a
            density or for a linkage in space.
    """
    names = [space.bodies[b] for b in regions]
    given = density if isinstance(density, Mapping) else dict.fromkeys(names, density)
    for name in given:
        if name not in names:
            raise BodyError(space.source, name, "has a density, but gets no matter", names)
    for value in (*given.values(), thickness):
        if value is not None and not 0.0 < value < np.inf:
            raise UsageError(f"a density or thickness of {value:g}: give a number above 0")
    if density is None and thickness is not None:
        raise UsageError("plates have a volume, and point masses have none: give a density too")
    if thickness is not None and not space.linkage.planar:
        raise UsageError("a linkage in space has no plane for plates; leave out the thickness")
    limits = {}
    for b, name in zip(regions, names, strict=True):
        value = given.get(name)
        if value is None and density is not None:
            raise UsageError(f"link '{name}' has no density: give one for all links")
        if value is not None:
            limits[b] = DensityLimit(float(value), thickness)
    return limits


def with_further_links(
    limits: Mapping[int, DensityLimit], regions: Mapping[int, Region]
) -> dict[int, DensityLimit]:
    """Give further links the largest density of those that have one."""
    densest = max(limits.values(), key=lambda limit: limit.density)
    return {b: limits.get(b, densest) for b in regions}


def stocks_of(
    space: DesignSpace, regions: Mapping[int, Region], limits: Mapping[int, DensityLimit]
) -> dict[int, Stock]:
    """Find the matter of limited density that regions hold.

    Args:
        space: a design space of the linkage.
        regions: region by position of the body.
        limits: density of each; with a thickness, matter is in plates.

    Raises:
        UsageError: a region has no section of a known form with the plane of the linkage.
    """
    frame, stocks = space.linkage.chain.frame, {}
    for b, region in regions.items():
        density, thickness = limits[b]
        if thickness is None:
            stocks[b] = Stock(region, density)
            continue
        R, origin = space.frames[b, :3, :3], space.frames[b, :3, 3]
        normal, height = R.T @ frame.R[2], float(frame.R[2] @ (frame.origin - origin))
        try:
            plate = _plate(region, normal, height, thickness)
        except UsageError as error:
            raise UsageError(f"link '{space.bodies[b]}': {error}") from None
        stocks[b] = Stock(plate, density, _mirror(plate, normal, height))
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
    nu, offset = across / size, (height - float(normal @ region.centre)) / size
    if not abs(offset) < 1.0:
        raise UsageError(MISSED.format(region.text))
    e1 = np.cross(nu, np.eye(3)[int(np.argmin(np.abs(nu)))])
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(nu, e1)
    radius = float(np.sqrt(1.0 - offset * offset))
    if region.kind == "cylinder":
        if abs(nu[2]) <= PLATE_UPRIGHT:
            z, side = np.eye(3)[2], radius * np.cross(nu, np.eye(3)[2])
            corners = np.array(
                [offset * nu + i * side + j * z for i in (-1, 1) for j in (-1, 1)]
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
    place[:3, 3] = region.to_link(offset * nu)
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
