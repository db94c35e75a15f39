"""Counterweights as closed solids.

A plate is its outline, extruded. Other parts are the region as a polyhedron, cut by the plane
or the quadric where the form of the counterweight vanishes. Corners of curved surfaces then
move by so little as gives the solid the moments of the counterweight.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.parts.mesh_moments import fit_moments
from balance.masses.counterweights.parts.outlines import Plate, plate_of
from balance.masses.counterweights.regions import Region

if TYPE_CHECKING:
    from manifold3d import Manifold

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Corners of a cylinder and of a great circle of a ball.
AROUND_CYLINDER, AROUND_BALL = 512, 256
# Edges of the grid on which a quadric is followed, over the size of the region, to see where
# it is, and then over that of the part; and how exactly corners are on it.
EDGE_FIRST, EDGE, ON_QUADRIC = 0.08, 0.025, 1e-6


class PartMesh(NamedTuple):
    """A closed solid in the link frame.

    Attributes:
        points: corners (n, 3) from the centre of mass of the counterweight, m.
        triangles: triples of corners (t, 3), counter-clockwise from outside.
        plate: its outline if it is a plate.
    """

    points: Array
    triangles: IntArray
    plate: Plate | None


def mesh_counterweight(weight: Counterweight) -> PartMesh:
    """Make the solid of a counterweight that fills a part of its region.

    Its points are rounded to those that a file in single precision, in mm, holds.

    Args:
        weight: the counterweight, with a form and a density.
    """
    plate = plate_of(weight)
    body = _cut_region(weight) if plate is None else _extrude(plate)
    mesh = body.to_mesh64()
    points = np.asarray(mesh.vert_properties[:, :3]) * 1e-3
    if plate is not None:
        points = points @ plate.axes
    triangles = np.asarray(mesh.tri_verts, dtype=np.int64)
    along = None if plate is None else plate.axes[:2]
    fitted = fit_moments(points - weight.com, triangles, volume_moments(weight), along)
    rounded = np.asarray((1e3 * fitted).astype(np.float32), dtype=np.float64)
    return PartMesh(1e-3 * rounded, triangles, plate)


def volume_moments(weight: Counterweight) -> Array:
    """Compute ``∫ [x; 1][x; 1]ᵀ dV`` (4, 4) about the centre of mass of a counterweight."""
    assert weight.density is not None
    inertia = weight.inertia
    moments = np.zeros((4, 4))
    moments[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    moments[3, 3] = weight.mass
    return moments / weight.density


def _extrude(plate: Plate) -> Manifold:
    """Extrude the outline of a plate; mm along its axes."""
    low = 1e3 * (plate.middle - 0.5 * plate.thickness)
    return plate.section.extrude(1e3 * plate.thickness).translate((0.0, 0.0, low))


def _cut_region(weight: Counterweight) -> Manifold:
    """Cut the part of a region where a form is positive; mm in the link frame."""
    assert weight.form is not None
    region, Q = weight.region, weight.form
    place = np.diag([1e3, 1e3, 1e3, 1.0]) @ region.place
    body = _unit_polyhedron(region)
    unit = region.place.T @ Q @ region.place
    if not unit[:3, :3].any():
        if unit[:3, 3].any():
            body = body.trim_by_plane(tuple(unit[:3, 3]), _offset(unit))
    else:
        body = body ^ _quadric_side(unit)
    return body.transform(place[:3])


def _offset(unit: Array) -> float:
    """Compute the distance of a plane from the origin along its normal."""
    return -0.5 * float(unit[3, 3]) / float(np.linalg.norm(unit[:3, 3]))


def _unit_polyhedron(region: Region) -> Manifold:
    """Make the polyhedron of a region in unit coordinates."""
    from manifold3d import Manifold

    if region.offsets.size:
        return Manifold.hull_points(region.vertices)
    if region.kind == "cylinder":
        return Manifold.cylinder(2.0, 1.0, 1.0, AROUND_CYLINDER, True)
    return Manifold.sphere(1.0, AROUND_BALL)


def _quadric_side(unit: Array) -> Manifold:
    """Make the part of a box about the unit region where a form is positive."""
    from manifold3d import Manifold

    (a, _, _, _), (_, b, _, _), (_, _, c, _), _ = unit.tolist()
    d, e, f = 2.0 * unit[0, 1], 2.0 * unit[0, 2], 2.0 * unit[1, 2]
    g, h, i = (2.0 * unit[:3, 3]).tolist()
    j = float(unit[3, 3])

    def value(x: float, y: float, z: float) -> float:
        return x * (a * x + d * y + e * z + g) + y * (b * y + f * z + h) + z * (c * z + i) + j

    bounds = np.array([[-1.05] * 3, [1.05] * 3])
    first = Manifold.level_set(value, bounds.reshape(-1).tolist(), EDGE_FIRST, 0.0)
    if not first.is_empty():
        box = np.array(first.bounding_box()).reshape(2, 3)
        bounds = np.clip(box + [[-EDGE_FIRST] * 3, [EDGE_FIRST] * 3], -1.05, 1.05)
    edge = EDGE * float(np.ptp(bounds, axis=0).max())
    return Manifold.level_set(value, bounds.reshape(-1).tolist(), edge, 0.0, ON_QUADRIC)
