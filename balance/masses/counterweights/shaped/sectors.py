"""Sectors of a disc about the joint of a crank: the least mass that balances forces.

Sectors of one radius and thickness about one axis are arcs of directions that are full. Their
masses and first moments, ``|h| ≤ 2/3 ρ t R³ sin(m / (ρ t R²))``, and those of all sets of
directions in an arc, are convex, and the least mass is that of one arc where a linear form is
positive: the program of matter of limited density, with `Fan` for the regions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight, filled_counterweight
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.regions import Region, cylinder_region, sector_region
from balance.masses.counterweights.shaped.across_plane import axes_and_height, height_within
from balance.masses.counterweights.shaped.shape_holder import WHOLE
from balance.masses.counterweights.shaped.weight_shape import WeightShape
from balance.masses.counterweights.volume.cut_regions import Stock, fill
from balance.masses.counterweights.volume.decide_filled import decide_filled
from balance.masses.counterweights.volume.fans import (
    FULL_TURN,
    AngleRange,
    Fan,
    widest_free_arc,
)
from balance.masses.designs.mass_regions import joint_points
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import SHAPE_INSIDE
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array


def fan_of(space: DesignSpace, body: int, stock: Stock, shape: WeightShape) -> Stock:
    """Find the directions about the joint of a link in which its region holds sectors.

    Of several arcs of such directions the widest counts.

    Args:
        space: a design space of the linkage.
        body: position of the body.
        stock: its region and density.
        shape: thickness and radius; without a radius that of the largest circle in the region.

    Raises:
        UsageError: the joint slides, or the region holds no such sector.
    """
    joint = space.linkage.joints[space.linkage.bodies[body].link]
    if joint.kind != "revolute":
        raise UsageError(f"sectors are about a joint that turns, and '{joint.name}' slides")
    axes, height = axes_and_height(space, body)
    R, origin = space.frames[body, :3, :3], space.frames[body, :3, 3]
    at = axes[:2] @ (R.T @ (joint_points(space, space.linkage.bodies[body])[0] - origin))
    height = height_within(stock.region, shape, axes[2], height)
    normals, rooms = _sides(stock.region, shape, axes, np.append(at, height))
    if not rooms.size:
        raise UsageError(
            f"region {stock.region.text} does not hold the axis of joint '{joint.name}', from "
            "where sectors reach to their rim"
        )
    radius = float(rooms.min()) if shape.radius is None else shape.radius
    if not radius > 0.0:
        raise UsageError(
            f"region {stock.region.text} holds no circle about joint '{joint.name}': give the "
            f"radius too, such as sector={shape.size:g},0.1"
        )
    arcs = []
    for normal, room in zip(normals, rooms.tolist(), strict=True):
        if room < radius * (1.0 - SHAPE_INSIDE):
            half = float(np.arccos(max(-1.0, room / radius)))
            arcs.append(AngleRange(float(np.arctan2(normal[1], normal[0])) - half, 2.0 * half))
    allowed = widest_free_arc(arcs)
    if allowed is None:
        raise UsageError(
            f"region {stock.region.text} holds no sector of radius {radius:g} m about joint "
            f"'{joint.name}'"
        )
    disc = cylinder_region(np.append(at, height) @ axes, axes[2], radius, shape.size)
    place = np.array(disc.place)
    place[:3, :3] = axes.T * [radius, radius, 0.5 * shape.size]
    disc = replace(disc, place=freeze(place))
    return Stock(disc, stock.density, fan=Fan(allowed))


def decide_sectors(
    blank: Counterweights, fans: Mapping[int, Stock]
) -> tuple[Counterweights, float]:
    """Find the least mass of sectors of given sizes, and a bound, kg.

    Args:
        blank: the answer where there are none.
        fans: from `fan_of`, by position of the body.
    """
    answer = decide_filled(blank.space, fans, relax=False)
    if answer.verdict == "infeasible":
        return blank, np.inf
    if answer.gap is None or answer.residual is None:
        return blank, 0.0
    bound = answer.added_mass * (1.0 - answer.gap)
    names = {blank.space.bodies[b]: stock for b, stock in fans.items()}
    weights = [_sector(weight, names[weight.link]) for weight in answer.weights]
    made = tuple(weight for weight in weights if weight is not None)
    if len(made) < len(weights):
        return blank, bound
    shaped = replace(
        blank, verdict="feasible", z=answer.z, residual=answer.residual, weights=made
    )
    return shaped, bound


def _sector(weight: Counterweight, stock: Stock) -> Counterweight | None:
    """Make the sector that a counterweight in a fan is; None if it is in two pieces."""
    assert weight.form is not None and stock.fan is not None
    place = stock.region.place
    arcs = stock.fan.arcs(place.T @ weight.form @ place)
    return sector_of(weight.link, stock, arcs[0]) if len(arcs) == 1 else None


def sector_about(link: str, stock: Stock, moments: Array) -> Counterweight:
    """Make the sector of a mass about the direction of its first moments, or near it.

    Args:
        link: name of the link.
        stock: from `fan_of`.
        moments: mass and first moments (4, 4), kg, in unit coordinates.
    """
    assert stock.fan is not None
    allowed = stock.fan.allowed
    volume = abs(float(np.linalg.det(stock.region.place[:3, :3])))
    width = min(allowed.width, float(moments[3, 3]) / (stock.density * volume))
    start = float(np.arctan2(moments[1, 3], moments[0, 3])) - 0.5 * width
    if allowed.width < FULL_TURN:
        # The nearest start from which the whole sector is allowed.
        room = 0.5 * (allowed.width - width)
        off = float(np.remainder(start - allowed.start - room + np.pi, FULL_TURN)) - np.pi
        start = allowed.start + room + min(max(off, -room), room)
    return sector_of(link, stock, AngleRange(start, width))


def sector_of(link: str, stock: Stock, arc: AngleRange) -> Counterweight:
    """Make the sector of an arc of directions of a fan.

    Args:
        link: name of the link.
        stock: from `fan_of`.
        arc: its directions, in unit coordinates.
    """
    place = stock.region.place
    c, s = np.cos(arc.middle), np.sin(arc.middle)
    sizes = np.linalg.norm(place[:3, :3], axis=0)
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ (place[:3, :3] / sizes).T
    region = sector_region(place[:3, 3], axes, sizes[0], 2.0 * float(sizes[2]), 0.5 * arc.width)
    whole = Fan(AngleRange(-0.5 * arc.width, arc.width))
    matter = Stock(region, stock.density, fan=whole)
    return filled_counterweight(link, matter, WHOLE, fill(matter, WHOLE), arm=0.0)


def _sides(region: Region, shape: WeightShape, axes: Array, at: Array) -> tuple[Array, Array]:
    """List sides that a circle about an axis may not pass.

    Args:
        region: the region.
        shape: the shape.
        axes: orthonormal rows (3, 3) of the link frame, the last one along the axis.
        at: the middle of the axis (3,) along them, m.

    Returns:
        Unit normals (n, 2), and rooms (n,), m: a point of the rim in the direction e is inside
        where ``R normal·e ≤ room``. None if the axis is outside.
    """
    half, outside = 0.5 * shape.size, (np.empty((0, 2)), np.empty(0))
    if region.offsets.size:
        N = region.normals @ np.linalg.inv(region.place[:3, :3])
        rooms, N = region.offsets + N @ region.centre, N @ axes.T
        rooms = rooms - N @ at - half * np.abs(N[:, 2])
        reach = np.linalg.norm(N[:, :2], axis=1)
        aside = reach > SHAPE_INSIDE * np.linalg.norm(N, axis=1)
        rooms = rooms[aside] / reach[aside]
        return (N[aside, :2] / reach[aside, None], rooms) if rooms.min() >= 0.0 else outside
    away = at - axes @ region.centre
    radius, off = float(np.linalg.norm(region.place[:3, 0])), float(np.hypot(*away[:2]))
    if region.kind == "ball":
        radius = float(np.sqrt(max(0.0, radius**2 - (abs(away[2]) + half) ** 2)))
    if off > radius:
        return outside
    if off <= SHAPE_INSIDE * radius:
        fits = shape.radius is None or shape.radius <= radius * (1.0 + SHAPE_INSIDE)
        return np.array([[1.0, 0.0]]), np.array([radius if fits else -np.inf])
    normal = away[None, :2] / off
    if shape.radius is None:
        return normal, np.array([radius - off])
    # |away + R e|² ≤ radius²
    return normal, np.array([0.5 * (radius**2 - shape.radius**2 - off * off) / off])
