"""Rational screws of a linkage whose loops are planar or spherical, inside its intervals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from kinematics.loading.meant.bennett_loops import bennett_axes
from kinematics.loading.meant.four_joint_loops import (
    LinkRelation,
    Pin,
    Slide,
    apply_relations,
    find_relations,
)
from kinematics.loading.meant.link_shapes import LinkShapes
from kinematics.loading.meant.link_widths import LinkWidths, Width
from kinematics.model.chain import extent, loop_joints
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import (
    Vector,
    cross,
    nearby_fraction,
    nearby_vector,
    part_across,
)
from kinematics.numerics.linalg.rational_directions import nearby_unit_vector

# Error of the axes of a Bennett linkage in half widths of the intervals: those of the last two
# depend on all others.
MAX_BENNETT_ERROR = 4.0
# Gap up to which loops count as closed in a file whose pose is the reference pose, in parts of
# the size.
CLOSED_GAP = 1e-12
# Least second singular value of the directions of slides that are not all parallel.
MIN_SPREAD_OF_SLIDES = 1e-3
# Round-off of the direction of a slide, radians.
SLIDE_ROUND_OFF = 1e-15


class Figure(NamedTuple):
    """The joints of loops that move in a plane, or on a sphere.

    Attributes:
        joints: numbers of the joints.
        normal: of the plane, of any length; None on a sphere.
        centre: of the sphere; None in a plane.
        pins: axes of rotation.
        places: points of the pins, in the plane through the origin; or unit vectors along them.
        slides: joints that slide.
        relations: those that hold, or nearly.
        size: length to which errors of the relations are relative.
        axes: rational screws of the joints, if the relations decide all of them.
    """

    joints: tuple[int, ...]
    normal: Vector | None
    centre: Vector | None
    pins: tuple[Pin, ...]
    places: tuple[Vector, ...]
    slides: tuple[Slide, ...]
    relations: tuple[LinkRelation, ...]
    size: float
    axes: tuple[Vector, ...] = ()


def find_figures(linkage: Linkage, widths: LinkWidths, limit: float) -> list[Figure]:
    """Find the loops of a linkage that move in a plane or on a sphere.

    Args:
        widths: half widths of its joints.
        limit: largest nearness of a relation.

    Returns:
        The figures. Those in parallel planes share their normal.
    """
    figures: list[Figure] = []
    for joints in _loop_groups(linkage):
        normals = [figure.normal for figure in figures if figure.normal is not None]
        figure = _planar_figure(linkage, widths, joints, normals, limit)
        if figure is None:
            figure = _spherical_figure(linkage, widths, joints, limit)
        if figure is None:
            figure = _bennett_figure(linkage, widths, joints)
        if figure is not None:
            figures.append(figure)
    taken = {j for figure in figures for j in figure.joints}
    others = tuple(j for j in range(len(linkage.joints)) if j not in taken)
    if others and not linkage.loops:
        whole = _planar_figure(linkage, widths, others, [], limit)
        figures += _parallel_figures(linkage, widths, others) if whole is None else [whole]
    return figures


def _parallel_figures(
    linkage: Linkage, widths: LinkWidths, joints: Sequence[int]
) -> list[Figure]:
    """Make a figure without joints for each direction of parallel axes of an open chain."""
    turning = [j for j in joints if linkage.joints[j].kind == "revolute"]
    axes = [linkage.joints[j].direction for j in turning]
    signs = [np.sign(a[np.argmax(np.abs(a))]) for a in axes]
    groups = _alike([s * a for s, a in zip(signs, axes, strict=True)], widths.angle)
    return [
        Figure((), nearby_vector(axes[group[0]]), None, (), (), (), (), 1.0)
        for group in groups
        if len(group) > 1
    ]


def exact_screws(
    linkage: Linkage, widths: LinkWidths, figures: Sequence[Figure], nearness: float
) -> tuple[tuple[Vector, ...], list[LinkRelation]]:
    """Compute rational screws of all joints.

    Args:
        widths: half widths of its joints.
        nearness: relations up to this nearness hold exactly.

    Returns:
        Screws (n, 6) of any length, and the relations that hold: pins and slides are numbers
        of joints, errors are relative to the size.
    """
    screws: dict[int, Vector] = {}
    holding: list[LinkRelation] = []
    for figure in figures:
        wanted = [x for x in figure.relations if x.nearness <= nearness]
        if wanted and figure.axes:
            screws.update(zip(figure.joints, figure.axes, strict=True))
            holding += wanted
            continue
        places, true = apply_relations(figure.places, wanted, figure.slides, figure.normal)
        holding += [
            relation._replace(
                pins=tuple(figure.pins[p].joints[0] for p in relation.pins),
                slide=figure.slides[relation.slide].joint if relation.slide >= 0 else -1,
                error=relation.error / figure.size,
            )
            for relation in true
        ]
        for slide in figure.slides:
            screws[slide.joint] = (Fraction(0),) * 3 + slide.d
        for pin, place in zip(figure.pins, places, strict=True):
            for j in pin.joints:
                axis = linkage.joints[j].direction
                n, point = figure.normal, place
                if n is None:
                    assert figure.centre is not None
                    n, point = place, figure.centre
                if axis @ _floats(n) < 0:
                    n = tuple(-x for x in n)
                screws[j] = n + cross(point, n)
    normals = [figure.normal for figure in figures if figure.normal is not None]
    for j in range(len(linkage.joints)):
        if j not in screws:
            screws[j] = _free_screw(linkage, widths, j, normals)
    return tuple(screws[j] for j in range(len(linkage.joints))), holding


def _loop_groups(linkage: Linkage) -> list[tuple[int, ...]]:
    """Group the joints of loops that share joints."""
    parent = [joint.parent for joint in linkage.joints]
    groups: list[set[int]] = []
    for loop in linkage.loops:
        group = loop_joints(parent, loop.end, loop.successor)
        for other in [x for x in groups if x & group]:
            groups.remove(other)
            group |= other
        groups.append(group)
    return [tuple(sorted(group)) for group in groups]


def _planar_figure(
    linkage: Linkage,
    widths: LinkWidths,
    joints: tuple[int, ...],
    normals: Sequence[Vector],
    limit: float,
) -> Figure | None:
    """Make the figure of joints that move in a plane; None if they do not."""
    kinds = {j: linkage.joints[j].kind for j in joints}
    turning = [j for j in joints if kinds[j] == "revolute"]
    if "helical" in kinds.values():
        return None
    axes = {j: linkage.joints[j].direction for j in joints}
    mean = _mean_normal([axes[j] for j in turning], [axes[j] for j in joints])
    if mean is None:
        return None
    off = [float(np.linalg.norm(np.cross(axes[j], mean))) for j in turning]
    off += [abs(float(axes[j] @ mean)) for j in joints if kinds[j] == "prismatic"]
    if max(off) > widths.angle:
        return None
    normal = _shared_normal(mean, normals, widths.angle)
    size, lever = extent(linkage).length, _lever(linkage, joints, mean)
    # The line of a slide passes a pin at a pose to which tilted axes have been closed.
    closing = widths.round_off + (widths.whole.angle * lever if widths.exact else 0.0)
    slides = []
    for j in joints:
        if kinds[j] == "prismatic":
            d = nearby_vector(axes[j])
            d = part_across(d, normal)
            round_off = Width((), closing / 2, SLIDE_ROUND_OFF)
            near, far = (widths.of(link, j) + round_off for link in widths.links[j])
            slides.append(Slide(j, widths.links[j], d, (near, far)))
    flat = {j: part_across(nearby_vector(linkage.joints[j].point), normal) for j in turning}
    groups = _alike([_floats(flat[j]) for j in turning], widths.place)
    pins, places = [], []
    for group in groups:
        members = tuple(turning[k] for k in group)
        pins.append(Pin(members, _pin_widths(widths, members, lever)))
        places.append(flat[members[0]])
    where = np.array([_floats(place) for place in places]).reshape(-1, 3)
    relations = find_relations(
        where, pins, slides, True, size, limit, widths.links, LinkShapes(linkage, widths)
    )
    return Figure(
        joints, normal, None, tuple(pins), tuple(places), tuple(slides), tuple(relations), size
    )


def _mean_normal(turning: Sequence[Array], directions: Sequence[Array]) -> Array | None:
    """Compute the mean of axes, or the normal of slides; None if neither decides the plane."""
    if turning:
        mean: Array = np.sum([np.sign(axis @ turning[0]) * axis for axis in turning], axis=0)
        return mean / np.linalg.norm(mean)
    _, sizes, rows = np.linalg.svd(np.array(directions), full_matrices=False)
    return rows[2] if len(rows) == 3 and sizes[1] > MIN_SPREAD_OF_SLIDES else None


def _lever(linkage: Linkage, joints: Sequence[int], normal: Array) -> float:
    """Length along the normal by which tilted axes shift places: of joints and link frames."""
    points = [linkage.joints[j].point for j in joints]
    points += [place.pose[:3, 3] for place in linkage.places.values() if place.link in joints]
    return float(np.ptp(np.array(points) @ normal))


def _spherical_figure(
    linkage: Linkage, widths: LinkWidths, joints: tuple[int, ...], limit: float
) -> Figure | None:
    """Make the figure of joints whose axes meet in a point; None if they do not."""
    if any(linkage.joints[j].kind != "revolute" for j in joints) or len(joints) < 4:
        return None
    axes = np.array([linkage.joints[j].direction for j in joints])
    points = np.array([linkage.joints[j].point for j in joints])
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    total = across.sum(axis=0)
    if np.linalg.cond(total) > 1e6:
        return None
    centre = np.linalg.solve(total, np.einsum("jab,jb->a", across, points))
    away = np.einsum("jab,jb->ja", across, points - centre)
    if float(np.linalg.norm(away, axis=1).max()) > widths.place:
        return None
    signs = np.array([np.sign(a[np.argmax(np.abs(a))]) for a in axes])
    groups = _alike(list(signs[:, None] * axes), widths.angle)
    # Axes that miss one another by their digits were tilted until they met.
    tilted = min(linkage.mended, widths.whole.place / extent(linkage).length)
    pins, places = [], []
    for group in groups:
        members = tuple(joints[k] for k in group)
        pins.append(Pin(members, _pin_angles(widths, members, tilted)))
        places.append(nearby_unit_vector(nearby_vector(axes[group[0]])))
    where = np.array([_floats(place) for place in places])
    relations = find_relations(
        where, pins, (), False, 1.0, limit, widths.links, LinkShapes(linkage, widths)
    )
    o = nearby_vector(centre)
    return Figure(joints, None, o, tuple(pins), tuple(places), (), tuple(relations), 1.0)


def _bennett_figure(
    linkage: Linkage, widths: LinkWidths, joints: tuple[int, ...]
) -> Figure | None:
    """Make the figure of four axes of a Bennett linkage; None if they are not."""
    around = _order_around(widths, joints)
    if any(linkage.joints[j].kind != "revolute" for j in joints) or not around:
        return None
    centre = np.mean([linkage.joints[j].point for j in joints], axis=0)
    size = extent(linkage).length
    screws = []
    for j in around:
        screw = np.array(linkage.joints[j].screw)
        screw[3:] = (screw[3:] - np.cross(centre, screw[:3])) / size
        screws.append(screw)
    axes = bennett_axes(screws)
    if axes is None:
        return None
    unit = [_floats(axis) / np.linalg.norm(_floats(axis[:3])) for axis in axes]
    error = float(np.abs(np.array(unit) - screws).max())
    width = widths.angle + widths.place / size
    if error > MAX_BENNETT_ERROR * width:
        return None
    length, o = nearby_fraction(Fraction(size)), nearby_vector(centre)
    moved = {
        j: axis[:3]
        + tuple(length * x + y for x, y in zip(axis[3:], cross(o, axis[:3]), strict=True))
        for j, axis in zip(around, axes, strict=True)
    }
    relation = LinkRelation(
        "Bennett linkage", around, (1,) * 4, -1, error, error / (MAX_BENNETT_ERROR * width)
    )
    return Figure(
        joints, None, None, (), (), (), (relation,), size, tuple(moved[j] for j in joints)
    )


def _order_around(widths: LinkWidths, joints: tuple[int, ...]) -> tuple[int, ...]:
    """Order four joints around their loop; empty if they are not those of one loop of four."""
    if len(joints) != 4 or len({link for j in joints for link in widths.links[j]}) != 4:
        return ()
    around = [joints[0]]
    link = widths.links[joints[0]][1]
    while len(around) < 4:
        following = [j for j in joints if j not in around and link in widths.links[j]]
        if len(following) != 1:
            return ()
        around.append(following[0])
        before, after = widths.links[following[0]]
        link = after if before == link else before
    return tuple(around)


def _pin_widths(widths: LinkWidths, joints: Sequence[int], lever: float) -> dict[int, Width]:
    """Half widths of the place of a pin on its links; ``lever`` of a tilted axis, metres."""
    more = 0.0 if widths.exact else widths.round_off
    return _least(
        (link, Width(width.box, width.rest + width.angle * lever + more, width.angle))
        for link, width in _members(widths, joints)
    )


def _pin_angles(widths: LinkWidths, joints: Sequence[int], tilted: float) -> dict[int, Width]:
    """Half widths of the direction of a pin on its links, as its place on the unit sphere."""
    closing = tilted + (0.0 if widths.closed else min(widths.whole.angle, CLOSED_GAP))
    return _least(
        (link, Width((), width.angle + closing + 1e-15))
        for link, width in _members(widths, joints)
    )


def _members(widths: LinkWidths, joints: Sequence[int]) -> list[tuple[int, Width]]:
    """Half widths of the joints of a pin on each link."""
    return [(link, widths.of(link, j)) for j in joints for link in widths.links[j]]


def _least(pairs: Iterable[tuple[int, Width]]) -> dict[int, Width]:
    """Keep the least width of each link."""
    widths: dict[int, Width] = {}
    for key, value in pairs:
        widths[key] = min(value, widths.get(key, value), key=lambda width: width.place)
    return widths


def _alike(vectors: Sequence[Array], width: float) -> list[list[int]]:
    """Group vectors that are equal up to a width."""
    groups: list[list[int]] = []
    for k, vector in enumerate(vectors):
        for group in groups:
            if np.linalg.norm(vectors[group[0]] - vector) <= width:
                group.append(k)
                break
        else:
            groups.append([k])
    return groups


def _free_screw(
    linkage: Linkage, widths: LinkWidths, j: int, normals: Sequence[Vector]
) -> Vector:
    """Make the rational screw of a joint that is in no figure."""
    joint = linkage.joints[j]
    n = _free_direction(joint.direction, widths.angle, normals)
    if joint.kind == "prismatic":
        return (Fraction(0),) * 3 + n
    screw = n + cross(nearby_vector(joint.point), n)
    if joint.kind == "helical":
        pitch = nearby_fraction(Fraction(float(joint.screw[:3] @ joint.screw[3:])))
        screw = screw[:3] + tuple(x + pitch * y for x, y in zip(screw[3:], n, strict=True))
    return screw


def _free_direction(direction: Array, width: float, normals: Sequence[Vector]) -> Vector:
    """Make a rational direction, parallel or at right angles to a normal if it nearly is."""
    axes = [_floats(normal) / np.linalg.norm(_floats(normal)) for normal in normals]
    for normal, axis in zip(normals, axes, strict=True):
        if np.linalg.norm(np.cross(axis, direction)) <= width:
            return normal if direction @ axis > 0 else tuple(-x for x in normal)
    for normal, axis in zip(normals, axes, strict=True):
        if abs(direction @ axis) <= width:
            return part_across(nearby_vector(direction), normal)
    return nearby_vector(direction)


def _shared_normal(mean: Array, normals: Sequence[Vector], width: float) -> Vector:
    """Take the known normal along a direction, or make one of it."""
    for normal in normals:
        n = _floats(normal)
        if np.linalg.norm(np.cross(n / np.linalg.norm(n), mean)) <= width:
            return normal
    return nearby_vector(mean)


def _floats(x: Vector) -> Array:
    """Convert fractions to floating point."""
    return np.array([float(y) for y in x])
