"""Where shapes are that lie across the plane of a linkage: axes of links, and heights."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.shaped.weight_shape import WeightShape
from balance.masses.designs.mass_regions import joint_points, joints_on
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import PART_ROUND_OFF, SHAPE_INSIDE
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least

# How near to the rim of its region a shape is at the rim, over the size of the region.
NEAR_RIM = 1e-3


def is_at_rim(space: DesignSpace, weight: Counterweight, region: Region) -> bool:
    """Whether a shape would leave its region if it were a little further from its joint.

    Args:
        space: a design space of the linkage.
        weight: the shape, which fills its own region.
        region: where it may be.
    """
    axes, (carrying, *_) = _joints_in_plane(space, space.bodies.index(weight.link))
    lever = axes[:2] @ weight.com - carrying
    distance, step = float(np.linalg.norm(lever)), NEAR_RIM * region.size
    if distance <= step:
        return False
    moved = weight.region.rim + step / distance * lever @ axes[:2]
    return not region.contains(moved, SHAPE_INSIDE).all()


def nearest_joint(space: DesignSpace, body: int, shape: Region) -> tuple[float, Array]:
    """Find the joint of a link that is nearest to a shape, in the plane.

    Args:
        space: a design space of the linkage, which is planar.
        body: position of the body.
        shape: a disc or cylinder across the plane, or a block.

    Returns:
        The distance from the shape, m, 0 where it holds the joint; and the joint (2,), from the
        middle of the shape along the axes of `axes_and_height`, m.
    """
    axes, joints = _joints_in_plane(space, body)
    away = joints - axes[:2] @ shape.centre
    if shape.offsets.size:
        sides = axes[:2] @ shape.place[:3, :2]
        sizes = np.linalg.norm(sides, axis=0)
        beyond = np.linalg.norm(np.maximum(np.abs(away @ (sides / sizes)) - sizes, 0.0), axis=1)
    else:
        beyond = np.linalg.norm(away, axis=1) - np.linalg.norm(shape.place[:3, 0])
    return max(0.0, float(beyond.min())), away[first_least(beyond, shape.size)]


class ShapePlace(NamedTuple):
    """Where the centre of mass of a shape is on its link, in the plane of the linkage.

    Attributes:
        joint: name of the joint that carries the link.
        distance: from that joint, m.
        direction: from that joint, degrees from the first of `axes_and_height`.
        away: angle at that joint between it and another joint of the link, degrees from 0 to
            180, by name.
    """

    joint: str
    distance: float
    direction: float
    away: dict[str, float]


def shape_place(space: DesignSpace, weight: Counterweight) -> ShapePlace:
    """Find where a shape is, as one lays it out on its link."""
    body = space.bodies.index(weight.link)
    axes, places = _joints_in_plane(space, body)
    names = [joint.name for joint in joints_on(space.linkage, space.linkage.bodies[body])]
    here, along = complex(*(axes[:2] @ weight.com - places[0])), {}
    for name, place in zip(names[1:], places[1:], strict=True):
        there = complex(*(place - places[0]))
        if name not in along and abs(there) > PART_ROUND_OFF * space.length:
            along[name] = abs(np.degrees(np.angle(here * there.conjugate())))
    return ShapePlace(names[0], abs(here), float(np.degrees(np.angle(here))), along)


def _joints_in_plane(space: DesignSpace, body: int) -> tuple[Array, Array]:
    """Find the axes of a link, and its joints (n, 2) along two of them, the carrying first."""
    axes, _ = axes_and_height(space, body)
    R, origin = space.frames[body, :3, :3], space.frames[body, :3, 3]
    joints = (np.array(joint_points(space, space.linkage.bodies[body])) - origin) @ R
    return axes, joints @ axes[:2].T


def axes_and_height(space: DesignSpace, body: int) -> tuple[Array, float]:
    """Find axes along and across the plane of a linkage in a link frame, and its height."""
    frame = space.linkage.chain.frame
    R, origin = space.frames[body, :3, :3], space.frames[body, :3, 3]
    normal = R.T @ frame.R[2]
    e1 = np.eye(3)[first_least(np.abs(normal), 1.0)]
    e1 = e1 - (e1 @ normal) * normal
    e1 /= np.linalg.norm(e1)
    height = float(frame.R[2] @ (frame.origin - origin))
    return np.vstack([e1, np.cross(normal, e1), normal]), height


def height_within(region: Region, shape: WeightShape, normal: Array, height: float) -> float:
    """Choose the height of a shape in a region: that of the plane, or the nearest to it.

    Args:
        normal: unit normal (3,) of the plane of the linkage, in the link frame.
        height: that of the plane along it, m.

    Raises:
        UsageError: the region is too thin for the shape, or of a form that holds none.
    """
    low, high = _extent(region, normal)
    half = 0.5 * shape.size if shape.flat else 0.0
    if not high - low > 2.0 * half * (1.0 - PART_ROUND_OFF):
        raise UsageError(
            f"region {region.text} is {high - low:g} m thick across the plane of the "
            f"linkage: too thin for {shape.plural}"
        )
    middle = 0.5 * (low + high)
    if not shape.flat and not low < height < high:
        return middle
    room = max(0.0, 0.5 * (high - low) - half)
    return middle + float(np.clip(height - middle, -room, room))


def _extent(region: Region, normal: Array) -> tuple[float, float]:
    """Compute the ends of a region along a normal, m.

    Raises:
        UsageError: it is no ball, box, hull, or cylinder along the normal.
    """
    if region.offsets.size:
        heights = region.to_link(region.vertices) @ normal
        return float(heights.min()), float(heights.max())
    middle, size = float(normal @ region.centre), np.abs(region.place[:3, :3].T @ normal)
    if region.kind == "ball":
        return middle - region.size, middle + region.size
    upright = region.kind == "cylinder" and size[:2].max() <= PART_ROUND_OFF * region.size
    if not upright:
        raise UsageError(
            f"region {region.text} is no ball, box, hull or cylinder across the plane of the "
            "linkage: shapes are sought in those"
        )
    return middle - float(size[2]), middle + float(size[2])
