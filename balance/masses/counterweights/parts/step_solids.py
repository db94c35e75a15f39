"""STEP files of counterweights: exact solids with planes, cylinders and spheres for faces.

A plate is its outline, of lines and arcs, extruded. Other counterweights are the region, cut by
the plane where their form vanishes. Those that a curved surface cuts have none.
"""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.parts.outlines import Plate, signed_area
from balance.masses.counterweights.regions import Region
from balance.support.tolerances import PART_ROUND_OFF
from kinematics.errors import PackageError
from kinematics.numerics.array_types import Array

if TYPE_CHECKING:
    from build123d import Edge, Shape

LIBRARY = "build123d"
INSTALL = "python -m pip install 'screwbalance[cad]'"
# What stands for the time of writing in the file.
NO_TIME = "1970-01-01T00:00:00"


def has_step(weight: Counterweight, plate: Plate | None) -> bool:
    """Whether a counterweight has planes, cylinders and spheres alone for faces.

    Args:
        weight: a counterweight that fills a part of its region.
        plate: its outline if it is a plate.
    """
    return plate is not None or not (weight.form is None or weight.form[:3, :3].any())


def step_file(weight: Counterweight, plate: Plate | None) -> bytes:
    """Write a counterweight as STEP in mm, about its centre of mass, with the axes of its link.

    Args:
        weight: a counterweight for which `has_step` holds.
        plate: its outline if it is a plate.

    Raises:
        PackageError: build123d is not installed.
    """
    try:
        from build123d import Location, export_step
    except ImportError:
        raise PackageError("STEP", LIBRARY, INSTALL) from None
    solid = _extruded(plate) if plate is not None else _cut(weight)
    x, y, z = (-1e3 * weight.com).tolist()
    text = BytesIO()
    export_step(solid.moved(Location((x, y, z))), text, timestamp=NO_TIME)
    return text.getvalue()


def _extruded(plate: Plate) -> Shape:
    """Extrude the outline of a plate, mm in the link frame."""
    from build123d import Face, Solid, Vector, Wire

    low = 1e3 * (plate.middle - 0.5 * plate.thickness) * plate.axes[2]
    outer = list[tuple[Wire, Array]]()
    holes = list[tuple[Wire, Array]]()
    for loop in plate.loops():
        wire = Wire(_edges(loop, plate.axes, low))
        (outer if signed_area(loop) > 0.0 else holes).append((wire, loop))
    way = Vector(*(1e3 * plate.thickness * plate.axes[2]).tolist())
    solids = []
    for wire, loop in outer:
        inside = [hole for hole, corners in holes if _holds(loop, corners[0, :2])]
        solids.append(Solid.extrude(Face(wire, inside), way))
    return solids[0] if len(solids) == 1 else solids[0].fuse(*solids[1:])


def _edges(loop: Array, axes: Array, low: Array) -> list[Edge]:
    """Make the lines and arcs of a closed curve, whose corners have a bulge."""
    from build123d import Edge

    def placed(point: Array) -> tuple[float, ...]:
        return tuple((low + point @ axes[:2]).tolist())

    edges = []
    for corner, after in zip(loop, np.roll(loop, -1, axis=0), strict=True):
        start, end, bulge = corner[:2], after[:2], float(corner[2])
        if bulge == 0.0:
            edges.append(Edge.make_line(placed(start), placed(end)))
            continue
        # The middle of an arc is off its chord by the bulge times half of it, to the right.
        chord = end - start
        middle = 0.5 * (start + end) + 0.5 * bulge * np.array([chord[1], -chord[0]])
        edges.append(Edge.make_three_point_arc(placed(start), placed(middle), placed(end)))
    return edges


def _holds(loop: Array, point: Array) -> bool:
    """Whether a point is inside a closed curve, by the turns of its corners about it."""
    away = (loop[:, :2] - point) @ np.array([1.0, 1.0j])
    return bool(abs(np.angle(np.roll(away, -1) / away).sum()) > np.pi)


def _cut(weight: Counterweight) -> Shape:
    """Cut a region by the plane of a counterweight, mm in the link frame."""
    from build123d import Keep, Plane

    solid = _whole(weight.region)
    if weight.cut is None:
        return solid
    normal, distance = weight.cut
    origin = tuple((1e3 * distance * normal).tolist())
    return solid.split(Plane(origin=origin, z_dir=tuple(normal.tolist())), keep=Keep.TOP)


def _whole(region: Region) -> Shape:
    """Make the solid of a region, mm in the link frame."""
    from build123d import Face, Matrix, Plane, Shell, Solid, Vector, Wire

    if region.offsets.size:
        corners = 1e3 * region.to_link(region.vertices)
        faces = [
            Face(Wire.make_polygon([Vector(*corners[k].tolist()) for k in facet]))
            for facet in region.triangles
        ]
        return Solid(Shell(faces)).clean()
    axes, centre = region.place[:3, :3], tuple((1e3 * region.centre).tolist())
    sizes = np.linalg.norm(axes, axis=0)
    upright = np.abs(axes.T @ axes - np.diag(sizes**2)).max() <= PART_ROUND_OFF * sizes.max()
    ball = region.ellipsoidal
    alike = sizes if ball else sizes[:2]
    if upright and np.ptp(alike) <= PART_ROUND_OFF * sizes.max():
        normal = tuple((axes[:, 2] / sizes[2]).tolist())
        plane = Plane(origin=centre, z_dir=normal)
        if ball:
            return Solid.make_sphere(1e3 * float(sizes[0]), plane)
        plane = plane.offset(-1e3 * float(sizes[2]))
        return Solid.make_cylinder(1e3 * float(sizes[0]), 2e3 * float(sizes[2]), plane)
    unit = Solid.make_sphere(1.0) if ball else Solid.make_cylinder(1.0, 2.0, Plane((0, 0, -1)))
    rows = np.diag([1e3, 1e3, 1e3, 1.0]) @ region.place
    return unit.transform_geometry(Matrix(rows.tolist()))
