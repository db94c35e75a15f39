"""Outlines of plates: sections of prisms and cylinders, cut along a line or a circle.

Curves are polygons whose area is that of the curve, and are given back as arcs for files.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.regions import Region
from balance.support.tolerances import PART_ROUND_OFF
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg.ties import first_least

if TYPE_CHECKING:
    from manifold3d import CrossSection


# Corners of a circle, and most times as many for one that is larger than the section.
CORNERS, LARGER = 2048, 64
# Distance from a circle, over its radius, up to which corners are on it, and the fewest such
# corners that make an arc.
ON_CIRCLE, FEWEST = 1e-5, 8


class Circle(NamedTuple):
    """A circle in a plane, m."""

    centre: Array
    radius: float


class Plate(NamedTuple):
    """A plate in the link frame.

    Attributes:
        axes: orthonormal rows (3, 3): two along the plate, and its normal.
        middle: distance of its middle plane from the origin along the normal, m.
        thickness: m.
        section: its outline, in mm along the first two axes.
        circles: circles of which parts of the outline are arcs.
    """

    axes: Array
    middle: float
    thickness: float
    section: CrossSection
    circles: tuple[Circle, ...]

    def loops(self) -> list[Array]:
        """Corners (n, 3) of each closed curve: x, y in mm, and the bulge to the next corner.

        The bulge is the tangent of a quarter of the angle of an arc, as in DXF; 0 for a line.
        """
        return [_with_arcs(loop, self.circles) for loop in self.section.to_polygons()]


def plate_of(weight: Counterweight) -> Plate | None:
    """Find the plate that a counterweight is; None if it is none of uniform thickness.

    Args:
        weight: a counterweight that fills a part of its region.
    """
    for normal, low, high in _faces(weight.region):
        cut = _conic_across(weight, normal)
        if cut is None:
            continue
        e1 = np.eye(3)[int(np.argmin(np.abs(normal) > PART_ROUND_OFF))]
        e1 = e1 - (e1 @ normal) * normal
        e1 /= np.linalg.norm(e1)
        axes = np.vstack([e1, np.cross(normal, e1), normal])
        plate = _cut_plate(weight.region, axes, low, high, cut)
        return _with_web(plate, weight.web) if plate and weight.web else plate
    return None


def _faces(region: Region) -> list[tuple[Array, float, float]]:
    """List normals across which regions have uniform thickness, and ends; thinnest first."""
    A = region.place[:3, :3]
    if region.kind in ("cylinder", "sector"):
        length = float(np.linalg.norm(A[:, 2]))
        normal = A[:, 2] / length
        if np.abs(A[:, :2].T @ normal).max() > PART_ROUND_OFF * region.size:
            return []
        middle = float(normal @ region.centre)
        return [(normal, middle - length, middle + length)]
    if not region.offsets.size:
        return []
    corners = region.to_link(region.vertices)
    normals = region.normals @ np.linalg.inv(A)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    faces: list[tuple[Array, float, float]] = []
    for normal in normals:
        heights = corners @ normal
        low, high = float(heights.min()), float(heights.max())
        between = np.minimum(heights - low, high - heights)
        first = next(x for x in normal if abs(x) > PART_ROUND_OFF)
        if first > 0.0 and between.max() <= PART_ROUND_OFF * region.size:
            faces.append((normal, low, high))
    return sorted(faces, key=lambda face: round((face[2] - face[1]) / region.size, 6))


def _conic_across(weight: Counterweight, normal: Array) -> Array | None:
    """Return the form of a counterweight if it is constant along a normal."""
    assert weight.form is not None
    Q, size = weight.form, weight.region.size
    unit = np.diag([size, size, size, 1.0])
    unit[:3, 3] = weight.region.centre
    scaled = unit.T @ Q @ unit
    along = np.abs(scaled[:, :3] @ normal).max()
    return Q if along <= PART_ROUND_OFF * np.abs(scaled).max() else None


def _cut_plate(region: Region, axes: Array, low: float, high: float, Q: Array) -> Plate | None:
    """Cut the section of a region along the line or circle where a form vanishes."""
    from manifold3d import CrossSection

    plane, circles = axes[:2], list[Circle]()
    if region.kind in ("cylinder", "sector"):
        sides = plane @ region.place[:3, :2]
        corners = _circle(CORNERS)
        if region.kind == "sector":
            corners = _wedge(region.half_angle)
        corners = corners @ sides.T + plane @ region.centre
        lengths = np.linalg.norm(sides, axis=0)
        if (
            np.abs(sides.T @ sides - lengths[0] ** 2 * np.eye(2)).max()
            <= 1e-12 * lengths[0] ** 2
        ):
            circles.append(Circle(plane @ region.centre, float(lengths[0])))
        section = CrossSection([1e3 * (corners if np.linalg.det(sides) > 0 else corners[::-1])])
    else:
        corners = region.to_link(region.vertices) @ plane.T
        section = CrossSection.hull_points(1e3 * corners)
    centre, size = corners.mean(axis=0), float(np.ptp(corners, axis=0).max())
    M, g = plane @ Q[:3, :3] @ plane.T, plane @ Q[:3, 3]
    # About the centre, so that a far line has no large constant.
    g, constant = g + M @ centre, float(Q[3, 3] + 2.0 * g @ centre + centre @ M @ centre)
    curvature = 0.5 * float(np.trace(M))
    if np.abs(M - curvature * np.eye(2)).max() > PART_ROUND_OFF * np.abs(M).max():
        return None
    if not g.any() and curvature == 0.0:
        cut = section
    elif abs(curvature) * size <= PART_ROUND_OFF * float(np.linalg.norm(g)):
        cut = section ^ CrossSection([1e3 * (centre + _half_plane(g, constant, size))])
    else:
        middle = -g / curvature
        square = float(middle @ middle) - constant / curvature
        radius = float(np.sqrt(max(square, 0.0)))
        times = int(np.clip(np.ceil(radius / size), 1, LARGER))
        disc = CrossSection([1e3 * (centre + middle + radius * _circle(times * CORNERS))])
        circles.append(Circle(centre + middle, radius))
        cut = section - disc if curvature > 0.0 else section ^ disc
    return Plate(axes, 0.5 * (low + high), high - low, cut, tuple(circles))


def _with_web(plate: Plate, web: Region) -> Plate:
    """Join the outline of a web, a box as thick as the plate, to that of a shape."""
    from manifold3d import CrossSection

    corners = web.to_link(web.vertices) @ plate.axes[:2].T
    return plate._replace(section=plate.section + CrossSection.hull_points(1e3 * corners))


def _circle(corners: int) -> Array:
    """Compute corners (n, 2) of a polygon with the area of the unit circle."""
    step = 2.0 * np.pi / corners
    turn = step * np.arange(corners)
    return np.sqrt(step / np.sin(step)) * np.column_stack([np.cos(turn), np.sin(turn)])


def _wedge(half_angle: float) -> Array:
    """Compute corners (n, 2) of a polygon with the area of a sector of the unit circle."""
    count = int(np.ceil(half_angle / np.pi * CORNERS)) + FEWEST
    step = 2.0 * half_angle / count
    turn = half_angle * np.linspace(-1.0, 1.0, count + 1)
    rim = np.sqrt(step / np.sin(step)) * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.vstack([np.zeros(2), rim])


def _half_plane(g: Array, constant: float, size: float) -> Array:
    """Compute corners (4, 2) of a square that is the side ``2 g·x + constant > 0`` nearby."""
    length = float(np.linalg.norm(g))
    n, far = g / length, 4.0 * size
    t = np.array([-n[1], n[0]])
    start = np.clip(-0.5 * constant / length, -far, far) * n
    return np.array(
        [
            start - far * t,
            start - far * t + 2 * far * n,
            start + far * t + 2 * far * n,
            start + far * t,
        ]
    )


def _with_arcs(loop: Array, circles: tuple[Circle, ...]) -> Array:
    """Replace runs of corners on a circle by one corner with a bulge."""
    count = len(loop)
    edges = np.full(count, -1)
    middles = 0.5 * (loop + np.roll(loop, -1, axis=0))
    for k, circle in enumerate(circles):
        on = _on_circle(loop, circle)
        edges[on & np.roll(on, -1) & _on_circle(middles, circle) & (edges < 0)] = k
    if (edges == edges[0]).all() and edges[0] >= 0:
        c, r = circles[edges[0]]
        turn = 1.0 if signed_area(loop) > 0.0 else -1.0
        return np.array([[*(1e3 * (c - [r, 0.0])), turn], [*(1e3 * (c + [r, 0.0])), turn]])
    start = next((k for k in range(count) if edges[k - 1] != edges[k]), 0)
    runs, k = list[tuple[int, int, int]](), 0
    while k < count:
        at, run = (start + k) % count, 1
        while edges[at] >= 0 and k + run < count and edges[(at + run) % count] == edges[at]:
            run += 1
        many = edges[at] >= 0 and run >= FEWEST
        runs += [(at, run, int(edges[at]))] if many else [(at + i, 1, -1) for i in range(run)]
        k += run
    exact = loop.copy()
    for (at, _, circle_here), (_, _, circle_before) in zip(
        runs, [runs[-1], *runs[:-1]], strict=True
    ):
        # Polygons have corners off their circle, by so little as keeps its area.
        if (circle_here >= 0) != (circle_before >= 0):
            line = (at - 1 if circle_here >= 0 else at + 1) % count
            circle = circles[max(circle_here, circle_before)]
            exact[at % count] = _onto(loop[at % count], loop[line], circle)
    corners = []
    for at, run, number in runs:
        piece = exact[(at + np.arange(run + 1)) % count]
        bulge = _bulge(piece, circles[number]) if number >= 0 else 0.0
        corners.append([*piece[0], bulge])
    return np.array(corners)


def _onto(corner: Array, other: Array, circle: Circle) -> Array:
    """Move a corner along a line through another to the near point of a circle; mm."""
    p, d = other - 1e3 * circle.centre, corner - other
    a, b, c = float(d @ d), float(p @ d), float(p @ p) - (1e3 * circle.radius) ** 2
    root = b * b - a * c
    if root < 0.0:
        return corner
    away = -b / a + np.sqrt(root) / a * np.array([-1.0, 1.0]) - 1.0
    return np.asarray(corner + away[first_least(np.abs(away))] * d)


def _on_circle(points: Array, circle: Circle) -> Flags:
    """Return which points (n, 2), in mm, are on a circle."""
    away = np.linalg.norm(1e-3 * points - circle.centre, axis=1) / circle.radius - 1.0
    return np.asarray(np.abs(away) <= ON_CIRCLE)


def _bulge(piece: Array, circle: Circle) -> float:
    """Compute the bulge of the arc of a circle along a run of corners."""
    away = (piece - 1e3 * circle.centre) @ np.array([1.0, 1.0j])
    return float(np.tan(0.25 * np.angle(away[1:] / away[:-1]).sum()))


def signed_area(loop: Array) -> float:
    """Compute the signed area of a closed curve (n, 2), or of one with bulges (n, 3)."""
    p, q, bulge = loop[:, :2], np.roll(loop[:, :2], -1, axis=0), loop[:, 2:].sum(axis=1)
    angle = 4.0 * np.arctan(bulge)
    chord, straight = np.linalg.norm(q - p, axis=1), bulge == 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = 0.5 * chord / np.sin(0.5 * angle)
        caps = np.where(straight, 0.0, 0.5 * radius**2 * (angle - np.sin(angle)))
    return float(0.5 * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum() + caps.sum())
