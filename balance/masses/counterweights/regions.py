"""Regions of a link frame in which matter may be added: convex shapes of positive volume.

A region is an affine image ``x = H [u; 1]`` of a shape in unit coordinates u, whose centre is
0 and which has no point further away than 1 in its own norm:

==========  ======================================  ============================================
ball        ``|u| ≤ 1``                             ``ball(x,y,z,r)``
ellipsoid   ``|u| ≤ 1``                             ``ellipsoid(x,y,z,a,b,c[,roll,pitch,yaw])``
box         ``|u_i| ≤ 1``                           ``box(x0:x1,y0:y1,z0:z1[,roll,pitch,yaw])``
cylinder    ``u_1² + u_2² ≤ 1``, ``|u_3| ≤ 1``      ``cylinder(x,y,z,ax,ay,az,r,length)``
hull        ``normals u ≤ offsets``                 ``collision``, or ``mesh(FILE.stl,1mm)``
sector      of such a cylinder, about its 1st axis  none: weights of that shape fill it
==========  ======================================  ============================================

Lengths are metres in the link frame, angles radians; a cylinder has its middle at (x, y, z)
and its axis along (ax, ay, az), and a box with angles is turned about its middle.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from balance.support.tolerances import HULL_FLAT, INSIDE_REGION
from kinematics.errors import UsageError
from kinematics.files.urdf.robot_tree import rotation_of_angles
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.linalg.ties import first_least
from kinematics.wording import number_text

Kind = Literal["ball", "ellipsoid", "box", "cylinder", "hull", "sector"]

# Points of a rim.
RIM_POINTS = 129
# Corners, and facets, of regions without any.
NO_POINTS = freeze(np.empty((0, 3)))
NO_TRIANGLES = freeze(np.empty((0, 3)), np.int64)


@dataclass(frozen=True, eq=False)
class Region:
    """A convex region of a link frame.

    Attributes:
        kind: shape in unit coordinates.
        place: affine map H (4, 4) from unit coordinates to the link frame, metres.
        text: the region in words, as `read_region` reads them, or ``collision``.
        vertices: corners of a box or hull in unit coordinates (n, 3); empty otherwise.
        triangles: its facets as triples of corners (t, 3).
        normals: outward unit normals of its facets (t, 3).
        offsets: distances of its facets from the centre (t,).
        half_angle: how far a sector reaches to both sides of its first axis, radians.
    """

    kind: Kind
    place: Array
    text: str
    vertices: Array
    triangles: IntArray
    normals: Array
    offsets: Array
    half_angle: float = np.pi

    def __repr__(self) -> str:
        """One line: the text of the region."""
        return f"Region {self.text}"

    @property
    def centre(self) -> Array:
        """Centre (3,) in the link frame, metres."""
        return self.place[:3, 3]

    @property
    def size(self) -> float:
        """Largest half axis, metres."""
        return float(np.linalg.norm(self.place[:3, :3], axis=0).max())

    @property
    def volume(self) -> float:
        """Volume, m³."""
        if self.offsets.size:
            size = float(np.abs(np.linalg.det(self.vertices[self.triangles])).sum()) / 6.0
        else:
            size = 4.0 / 3.0 * np.pi if self.ellipsoidal else 2.0 * self.half_angle
        return size * abs(float(np.linalg.det(self.place[:3, :3])))

    @property
    def rim(self) -> Array:
        """Points (n, 3) of the link frame at its ends: corners, or two rims of a round part."""
        turn = self.half_angle * np.linspace(-1.0, 1.0, RIM_POINTS)
        ring = np.column_stack([np.cos(turn), np.sin(turn), np.ones(RIM_POINTS)])
        ends = np.vstack([ring, ring * [1, 1, -1]])
        return self.to_link(self.vertices if self.offsets.size else ends)

    @property
    def ellipsoidal(self) -> bool:
        """Whether the shape is a ball or an ellipsoid."""
        return self.kind in ("ball", "ellipsoid")

    def to_unit(self, points: ArrayLike) -> Array:
        """Convert points (..., 3) of the link frame, metres, to unit coordinates."""
        away = np.asarray(points, dtype=np.float64) - self.centre
        return np.asarray(away @ np.linalg.inv(self.place[:3, :3]).T)

    def to_link(self, points: ArrayLike) -> Array:
        """Convert points (..., 3) in unit coordinates to the link frame, metres."""
        return np.asarray(np.asarray(points) @ self.place[:3, :3].T + self.centre)

    def excess(self, units: ArrayLike) -> Array:
        """Compute how far points are outside, negative inside, in unit coordinates.

        Args:
            units: points (..., 3) in unit coordinates.
        """
        u = np.asarray(units, dtype=np.float64)
        if self.ellipsoidal:
            return np.asarray(np.linalg.norm(u, axis=-1) - 1.0)
        if self.kind in ("cylinder", "sector"):
            across = np.linalg.norm(u[..., :2], axis=-1)
            outside = np.maximum(across, np.abs(u[..., 2])) - 1.0
            if self.kind == "sector":
                turn = np.abs(np.arctan2(u[..., 1], u[..., 0])) - self.half_angle
                beside = across * np.sin(np.clip(turn, -0.5 * np.pi, 0.5 * np.pi))
                outside = np.maximum(outside, beside)
            return np.asarray(outside)
        return np.asarray((u @ self.normals.T - self.offsets).max(axis=-1))

    def gauge(self, units: ArrayLike) -> Array:
        """Compute the factor by which the region must grow to reach points, (...,).

        Args:
            units: points (..., 3) in unit coordinates.
        """
        u = np.asarray(units, dtype=np.float64)
        if self.offsets.size:
            return np.asarray((u @ (self.normals / self.offsets[:, None]).T).max(axis=-1))
        return self.excess(u) + 1.0

    def outward(self, unit: ArrayLike, near: float) -> Array:
        """Compute unit normals (k, 3) of the surfaces that a point is on; k is 0 inside.

        Args:
            unit: the point (3,) in unit coordinates.
            near: distance up to which it is on a surface.
        """
        u = np.asarray(unit, dtype=np.float64)
        if self.offsets.size:
            return np.asarray(self.normals[self.normals @ u >= self.offsets - near])
        if self.ellipsoidal:
            size = float(np.linalg.norm(u))
            return np.reshape(u / size if size >= 1.0 - near else [], (-1, 3))
        across, normals = float(np.hypot(u[0], u[1])), []
        if across >= 1.0 - near:
            normals.append([u[0] / across, u[1] / across, 0.0])
        if abs(u[2]) >= 1.0 - near:
            normals.append([0.0, 0.0, float(np.sign(u[2]))])
        return np.reshape(normals, (-1, 3)).astype(np.float64)

    def contains(self, points: ArrayLike, tolerance: float = INSIDE_REGION) -> Flags:
        """Return whether points (..., 3) of the link frame are inside.

        Args:
            points: metres, in the link frame.
            tolerance: distance outside that counts as inside, in unit coordinates.
        """
        return np.asarray(self.excess(self.to_unit(points)) <= tolerance)

    @property
    def words(self) -> str:
        """The text with numbers of more than six decimals to four digits."""
        return re.sub(r"\d+\.\d{7,}", lambda number: number_text(float(number[0])), self.text)

    def grown(self, factor: float) -> Region:
        """Return the region stretched about its centre by a factor."""
        place = self.place.copy()
        place[:3, :3] *= factor
        return replace(self, place=freeze(place), text=f"{self.text} × {factor:.6g}")


def ball_region(centre: ArrayLike, radius: float) -> Region:
    """Make a ball.

    Args:
        centre: centre (3,), metres, link frame.
        radius: metres.

    Raises:
        UsageError: a number is not finite, or the ball is empty.
    """
    c = _finite(centre, "ball")
    _positive([radius], "ball", "radius")
    text = f"ball({_listed([*c, radius])})"
    return _round("ball", _place(radius * np.eye(3), c), text)


def ellipsoid_region(
    centre: ArrayLike, axes: ArrayLike, rpy: ArrayLike = (0.0, 0.0, 0.0)
) -> Region:
    """Make an ellipsoid.

    Args:
        centre: centre (3,), metres, link frame.
        axes: half axes (3,), metres.
        rpy: roll, pitch and yaw of its axes (3,), radians, as in URDF.

    Raises:
        UsageError: a number is not finite, or the ellipsoid is empty.
    """
    c, a, angles = (_finite(part, "ellipsoid") for part in (centre, axes, rpy))
    _positive(a, "ellipsoid", "half axis")
    text = f"ellipsoid({_listed([*c, *a, *(angles if angles.any() else ())])})"
    return _round("ellipsoid", _place(rotation_of_angles(angles) * a, c), text)


def cylinder_region(centre: ArrayLike, axis: ArrayLike, radius: float, length: float) -> Region:
    """Make a cylinder.

    Args:
        centre: middle of its axis (3,), metres, link frame.
        axis: direction of its axis (3,), of any length but 0.
        radius: metres.
        length: metres.

    Raises:
        UsageError: a number is not finite, the axis is 0, or the cylinder is empty.
    """
    c, n = _finite(centre, "cylinder"), _finite(axis, "cylinder")
    _positive([radius, length], "cylinder", "radius or length")
    if not n.any():
        raise UsageError("region cylinder: its axis is 0 0 0: give a direction")
    text = f"cylinder({_listed([*c, *n, radius, length])})"
    n = n / np.abs(n).max()
    n = n / np.linalg.norm(n)
    side = np.cross(n, np.eye(3)[first_least(np.abs(n), 1.0)])
    side /= np.linalg.norm(side)
    axes = np.column_stack([radius * side, radius * np.cross(n, side), 0.5 * length * n])
    return _round("cylinder", _place(axes, c), text)


def box_region(low: ArrayLike, high: ArrayLike, rpy: ArrayLike = (0.0, 0.0, 0.0)) -> Region:
    """Make a box along the axes of the link frame, or turned about its middle.

    Args:
        low: least coordinates (3,), metres, before it is turned.
        high: largest coordinates (3,), metres, likewise.
        rpy: roll, pitch and yaw of its axes (3,), radians, as in URDF.

    Raises:
        UsageError: a number is not finite, or the box is empty or inside out.
    """
    lo, hi, angles = (_finite(part, "box") for part in (low, high, rpy))
    for name, a, b in zip("xyz", lo, hi, strict=True):
        if not a < b:
            what = "is inside out" if a > b else "has no volume"
            raise UsageError(f"region box {what}: {name} from {a:g} to {b:g}: give x0 < x1")
    ends = [f"{a:.12g}:{b:.12g}" for a, b in zip(lo, hi, strict=True)]
    text = f"box({','.join([*ends, *([_listed(angles.tolist())] if angles.any() else [])])})"
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    axes = rotation_of_angles(angles) * (0.5 * (hi - lo))
    return _polytope("box", _place(axes, 0.5 * (lo + hi)), text, corners)


def sector_region(
    centre: ArrayLike, axes: Array, radius: float, thickness: float, half_angle: float
) -> Region:
    """Make the sector of a disc, from its centre to its rim.

    Args:
        centre: middle of the axis of the disc (3,), metres, link frame.
        axes: orthonormal rows (3, 3): the middle direction of the sector, the one across it,
            and the axis of the disc.
        radius: that of the disc, metres.
        thickness: metres.
        half_angle: how far it reaches to both sides of its middle direction, up to π.
    """
    place = _place(axes.T * [radius, radius, 0.5 * thickness], np.asarray(centre))
    turn = np.degrees(2.0 * half_angle)
    text = (
        f"a sector of {turn:.4g}° and radius {number_text(radius)} m, "
        f"{number_text(thickness)} m thick"
    )
    return replace(_round("sector", place, text), half_angle=half_angle)


def hull_region(points: ArrayLike, text: str = "collision") -> Region:
    """Make the convex hull of points.

    Args:
        points: points (n, 3), metres, link frame.
        text: the region in words.

    Raises:
        UsageError: a number is not finite, or the hull has no volume.
    """
    given = _finite(points, "hull").reshape(-1, 3)
    spread = np.linalg.svd(given - given.mean(axis=0), compute_uv=False)
    if len(given) < 4 or not spread[-1] > HULL_FLAT * spread[0]:
        raise UsageError(f"region {text}: the hull of these points has no volume")
    from scipy.spatial import ConvexHull

    corners = given[ConvexHull(given).vertices]
    centre = corners.mean(axis=0)
    half = float(np.abs(corners - centre).max())
    return _polytope("hull", _place(half * np.eye(3), centre), text, (corners - centre) / half)


def _finite(numbers: ArrayLike, what: str) -> Array:
    """Convert to an array; raise UsageError for numbers that are not finite."""
    values = np.asarray(numbers, dtype=np.float64)
    if not np.isfinite(values).all():
        raise UsageError(f"region {what}: every number must be finite")
    return values


def _positive(numbers: ArrayLike, what: str, part: str) -> None:
    """Raise UsageError unless all numbers are finite and above 0."""
    for value in _finite(numbers, what).tolist():
        if not value > 0.0:
            raise UsageError(f"region {what} is empty: {part} {value:g}: give one above 0")


def _listed(numbers: list[float]) -> str:
    return ",".join([f"{float(value):.12g}" for value in numbers])


def _place(axes: Array, centre: Array) -> Array:
    """Build the affine map (4, 4) with these columns and this centre."""
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = axes, centre
    return freeze(H)


def _round(kind: Kind, place: Array, text: str) -> Region:
    """Make a region without corners."""
    return Region(kind, place, text, NO_POINTS, NO_TRIANGLES, NO_POINTS, NO_POINTS[:, 0])


def _polytope(kind: Kind, place: Array, text: str, points: Array) -> Region:
    """Make the convex hull of points in unit coordinates (n, 3)."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    number = np.full(len(points), -1)
    number[hull.vertices] = np.arange(hull.vertices.size)
    return Region(
        kind,
        place,
        text,
        freeze(points[hull.vertices]),
        number[hull.simplices].astype(np.int64),
        freeze(hull.equations[:, :3]),
        freeze(-hull.equations[:, 3]),
    )
