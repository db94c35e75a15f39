"""Regions of the links of a linkage: by default, from ``<collision>``, and from texts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from balance.masses.counterweights.region_text import COLLISION, read_radius, read_region
from balance.masses.counterweights.regions import (
    Region,
    ball_region,
    hull_region,
)
from balance.masses.designs.constraints import unknown_body
from balance.masses.designs.mass_regions import BALL_RADIUS, ball_of, joint_points
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import COORDINATE_ROUND_OFF, LINK_LENGTH_ZERO
from kinematics.errors import BodyError, UsageError
from kinematics.files.urdf.robot_tree import pose_matrix
from kinematics.model.document.element import Element
from kinematics.model.linkage import GROUND, Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Distance of a region from the joint of its link, in characteristic lengths of the linkage,
# above which a notice asks whether it is given in metres.
DISTANT = 20.0
# Radius of the ball of a link by default, in lengths of the link.
DEFAULT_RADIUS = 0.5
# What names all bodies, in a linkage without a link of this name.
ALL = "all"
# Points on a circle, and circles on a sphere, that stand for round collision elements. They
# lie on the surface, so that the hull is inside that of the elements.
CIRCLE_POINTS = 16
SPHERE_CIRCLES = 5


def regions_of(
    space: DesignSpace, links: Sequence[str], regions: Mapping[str, Region | str]
) -> dict[int, Region]:
    """Find the region of each body to which matter may be added.

    Args:
        links: names of the bodies, or ``("all",)`` for all; see `names_of_links`.
        regions: region of a body, or its text, by name, or ``all`` for each body without one;
            the others have `default_region`.

    Returns:
        The regions by position of the body, ascending.

    Raises:
        BodyError: a body is unknown, is part of the ground, or has no usable collision
            element.
        UsageError: no body is named, one is named twice, a region is for a body that is not
            named, or the text of a region is wrong.
    """
    if not links:
        raise UsageError("no link to add matter to: name at least one")
    links = names_of_links(space.linkage, links)
    for k, name in enumerate(links):
        _check_body(space, name)
        if name in links[:k]:
            raise UsageError(f"link '{name}' is named twice among those to add matter to")
    regions = regions_by_name(space.linkage, links, regions)
    for name in regions:
        _check_body(space, name)
        if name not in links:
            raise UsageError(
                f"link '{name}' has a region, but no matter may be added to it: add it, or "
                "leave out the region"
            )
    chosen = {space.bodies.index(name): regions.get(name) for name in links}
    return {b: _region_of(space, b, chosen[b]) for b in sorted(chosen)}


def names_of_links(linkage: Linkage, links: Sequence[str]) -> Sequence[str]:
    """Return the names of links to which matter may be added; ``("all",)`` means all bodies.

    One text has names parted by commas, as on the command line.
    """
    if isinstance(links, str):
        links = [name.strip() for name in links.split(",")]
    every = tuple(links) == (ALL,) and ALL not in linkage.places
    return linkage.body_names if every else links


def regions_by_name(
    linkage: Linkage, links: Sequence[str], regions: Mapping[str, Region | str]
) -> dict[str, Region | str]:
    """Return regions by the names of bodies: that of ``all`` is of each link without one."""
    given = dict(regions)
    every = given.pop(ALL, None) if ALL not in linkage.places else None
    names = [] if every is None else names_of_links(linkage, links)
    return {name: every for name in names if every is not None} | given


def radius_text(ball: Region, factor: float = 1.0) -> str:
    """Write the radius of a ball about the joint of a link, times a factor: ``80mm``."""
    return f"{number_text(1e3 * factor * ball.size, '.3g')}mm"


def is_about_joint(space: DesignSpace, body: int, region: Region) -> bool:
    """Whether a region is the ball of some radius about the joint that carries a link."""
    return region.text == default_region(space, body, region.size).text


def default_region(space: DesignSpace, body: int, radius: float | None = None) -> Region:
    """Return the ball about the joint that carries a link, by default of half its length.

    The length is the largest distance from that joint to another joint of the link, to a
    joint of a loop on it, or to its centre of mass in the file. A link shorter than a
    thousandth of the characteristic length of the linkage has that length.

    Args:
        body: position of the body.
        radius: that of the ball, metres.
    """
    link = space.linkage.bodies[body]
    points = joint_points(space, link)
    if link.inertia[0] > 0.0:
        points = [*points, link.inertia[1:4] / link.inertia[0]]
    away = np.array(points) - points[0]
    length = math.sqrt(float((away * away).sum(axis=1).max()))
    if length <= LINK_LENGTH_ZERO * space.chain.frame.length:
        length = space.chain.frame.length
    R, origin = space.frames[body, :3, :3], space.frames[body, :3, 3]
    centre = R.T @ (points[0] - origin)
    centre[np.abs(centre) <= COORDINATE_ROUND_OFF * (length + np.abs(origin).max())] = 0.0
    return ball_region(centre, DEFAULT_RADIUS * length if radius is None else radius)


def wide_region(space: DesignSpace, body: int) -> Region:
    """Return the ball about the middle of a link's joints, of 1.5 lengths of the link.

    It is the ball that contains the mass of the link in designs; see
    `balance.masses.designs.mass_regions.ball_of`.

    Args:
        space: the design space, spatial.
        body: position of the body.
    """
    frame = space.chain.frame
    ball = ball_of(space, space.linkage.bodies[body], BALL_RADIUS)
    across = frame.R.T[:, : ball.centre.size]
    centre = frame.origin + frame.length * across @ ball.centre
    R, origin = space.frames[body, :3, :3], space.frames[body, :3, 3]
    return ball_region(R.T @ (centre - origin), ball.radius * frame.length)


def distant_regions(
    space: DesignSpace, regions: Mapping[str, Region | str]
) -> tuple[Notice, ...]:
    """Return a notice for each given region that is far from its link, or far too large.

    Args:
        regions: region of a body, or its text, by name; unknown names are left out.
    """
    limit, notices = DISTANT * space.chain.frame.length, []
    for name, given in regions_by_name(space.linkage, (ALL,), regions).items():
        if name not in space.bodies or (isinstance(given, str) and given.strip() == COLLISION):
            continue
        region = _region_of(space, space.bodies.index(name), given)
        away = max(float(np.linalg.norm(region.centre)), region.size)
        if away > limit:
            text = (
                f"the region of '{name}' reaches {away:.3g} m from the origin of the link, and "
                f"the linkage is {space.chain.frame.length:.3g} m large: regions are in metres"
            )
            notices.append(Notice("region_far", text))
    return tuple(notices)


def _check_body(space: DesignSpace, name: str) -> None:
    """Raise BodyError for a name that is no body to which matter can be added."""
    if name in space.bodies:
        return
    place = space.linkage.places.get(name)
    if place is not None and place.link == GROUND:
        problem = "is part of the ground, which does not move: matter there balances nothing"
        raise BodyError(space.source, name, problem, space.bodies)
    for body in space.linkage.bodies:
        if place is not None and body.link == place.link:
            problem = f"is fixed to '{body.name}', and one body with it: name '{body.name}'"
            raise BodyError(space.source, name, problem)
    raise unknown_body(space, name)


def _region_of(space: DesignSpace, body: int, given: Region | str | None) -> Region:
    """Return the region of a body from what the caller gave."""
    name = space.bodies[body]
    if isinstance(given, Region):
        return given
    if given is None:
        return default_region(space, body)
    try:
        if given.strip() == COLLISION:
            return hull_region(_collision_points(space, name), COLLISION)
        radius = read_radius(given)
        return read_region(given) if radius is None else default_region(space, body, radius)
    except UsageError as error:
        raise UsageError(f"link '{name}': {error}") from None


def _collision_points(space: DesignSpace, name: str) -> Array:
    """List points (n, 3) of the link frame whose hull is that of the collision elements.

    Raises:
        BodyError: the link has no collision element, or one that is a mesh.
    """
    tree = space.linkage.tree
    links = [] if tree is None else [link for link in tree.every("link") if link.name == name]
    elements = [item for link in links for item in link.every("collision")]
    if not elements:
        problem = "has no <collision> element: give its region as a ball or a box"
        raise BodyError(space.source, name, problem)
    return np.concatenate([_element_points(space, name, element) for element in elements])


def _element_points(space: DesignSpace, name: str, element: Element) -> Array:
    """List points (n, 3) of the link frame whose hull is that of a collision element."""
    geometry = element.first("geometry")
    shape = geometry.children[0] if geometry is not None and geometry.children else None
    try:
        points, pose = _shape_points(shape), pose_matrix(element.first("origin"))
        placed = points @ pose[:3, :3].T + pose[:3, 3]
        if not np.isfinite(placed).all():
            raise ValueError
    except (ValueError, KeyError, IndexError):
        problem = (
            f"its {element.label} is no box, cylinder or sphere with finite sizes: give its "
            "region as a ball or a box"
        )
        raise BodyError(space.source, name, problem) from None
    return placed


def _shape_points(shape: Element | None) -> Array:
    """List points (n, 3) of a box, cylinder or sphere about the origin.

    Raises:
        KeyError, ValueError, IndexError: it is another shape, or its sizes are no numbers.
    """
    if shape is None:
        raise ValueError
    if shape.tag == "box":
        signs = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T
        return np.asarray(signs * np.array(shape.vector("size", ""))[[0, 1, 2]])
    turn = np.linspace(0.0, 2.0 * np.pi, CIRCLE_POINTS, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(CIRCLE_POINTS)])
    radius = float(shape.attributes["radius"])
    if shape.tag == "cylinder":
        half = 0.5 * float(shape.attributes["length"])
        ends = [radius * circle + [0.0, 0.0, z] for z in (-half, half)]
        return np.concatenate(ends)
    if shape.tag != "sphere":
        raise ValueError
    heights = np.sin(np.linspace(-0.5, 0.5, SPHERE_CIRCLES + 2)[1:-1] * np.pi)
    rings = [np.sqrt(1.0 - z * z) * circle + [0.0, 0.0, z] for z in heights]
    return np.asarray(radius * np.concatenate([*rings, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]]))
