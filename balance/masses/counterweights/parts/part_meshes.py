"""Closed meshes of counterweights, with their mass, centre and inertia.

A plate is its outline, extruded. Other parts are the region as a polyhedron, cut by the plane
or the quadric where the form of the counterweight vanishes. Corners of curved surfaces then
move by so little as gives the solid the moments of the counterweight.

With corners ``v_i = [x_i; 1]`` of a triangle and the origin as the fourth corner, a tetrahedron
of volume V has the moments ``V/20 (Σ v_i v_iᵀ + s sᵀ)``, ``s = Σ v_i``; a closed mesh is the
signed sum of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import homogeneous
from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.parts.outlines import Plate, plate_of
from balance.masses.counterweights.regions import Region
from balance.support.clarabel_adapter import triangles as upper_triangle
from kinematics.numerics.array_types import Array, IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold


# Corners of a cylinder and of a great circle of a ball.
AROUND_CYLINDER, AROUND_BALL = 512, 256
# Edges of the grid on which a quadric is followed, over the size of the region, to see where
# it is, and then over that of the part; and how exactly corners are on it.
EDGE_FIRST, EDGE, ON_QUADRIC = 0.08, 0.025, 1e-6
# Steps of Newton's method, the change of a coordinate for differences, and the share of the
# largest singular value below which a direction is left alone.
STEPS, DIFFERENCE, DEGENERATE = 6, 1e-6, 1e-5


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
    fitted = _fit_moments(points - weight.com, triangles, volume_moments(weight), along)
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


def mesh_moments(points: Array, triangles: IntArray) -> Array:
    """Compute ``∫ [x; 1][x; 1]ᵀ dV`` (4, 4) of a closed mesh.

    Args:
        points: corners (n, 3), m.
        triangles: triples of corners (t, 3), counter-clockwise from outside.
    """
    v = homogeneous(points)[triangles]
    volumes = np.linalg.det(v[:, :, :3]) / 6.0
    sums = v.sum(axis=1) + [0.0, 0.0, 0.0, 1.0]
    squares = v.mT @ v + sums[:, :, None] * sums[:, None, :]
    squares[:, 3, 3] += 1.0
    return np.asarray(np.einsum("n,nij->ij", volumes, squares) / 20.0)


def moments_apart(moments: Array, wanted: Array) -> float:
    """Compute the largest difference of moments (4, 4) about the wanted centre.

    It is relative: of the volume to it, of first moments to volume and radius of gyration, and
    of second moments to their trace.
    """
    return float(np.abs(_differences(moments, wanted)).max())


def _fit_moments(
    points: Array, triangles: IntArray, wanted: Array, plane: Array | None = None
) -> Array:
    """Move the corners of a mesh by as little as gives it the wanted moments.

    Corners move by an affine map and ``x |x|²``, of which the moments need ten.

    Args:
        points: corners (n, 3) about the wanted centre, m.
        triangles: triples of corners (t, 3).
        wanted: moments (4, 4) about their centre.
        plane: unit vectors (2, 3) along which corners may move; None for all directions.

    Returns:
        The corners (n, 3).
    """
    along = np.eye(3) if plane is None else plane
    size = float(np.sqrt(np.trace(wanted[:3, :3]) / wanted[3, 3]))
    x = points @ along.T / size
    powers = np.column_stack([np.ones(len(x)), x])
    fields = [np.outer(power, unit) for power in powers.T for unit in along]
    fields.append((x * np.square(x).sum(axis=1)[:, None]) @ along)
    moves = size * np.array(fields)
    start = points
    for _ in range(STEPS):
        away = _differences(mesh_moments(points, triangles), wanted)
        slopes = [
            _differences(mesh_moments(points + DIFFERENCE * move, triangles), wanted) - away
            for move in moves
        ]
        J = np.array(slopes).T / DIFFERENCE
        step = np.linalg.lstsq(J, -away, rcond=DEGENERATE)[0]
        points = points + np.einsum("k,kni->ni", step, moves)
    better = moments_apart(mesh_moments(points, triangles), wanted) < moments_apart(
        mesh_moments(start, triangles), wanted
    )
    return np.asarray(points if better else start)


def _differences(moments: Array, wanted: Array) -> Array:
    """Compute relative differences (10,)."""
    size = float(np.sqrt(np.trace(wanted[:3, :3]) / wanted[3, 3]))
    scale = np.diag([1.0 / size] * 3 + [1.0])
    return np.asarray(upper_triangle(scale @ (moments - wanted) @ scale) / wanted[3, 3])
