"""Files of parts: meshes, outlines of plates, and a table.

A plate is its outline, extruded. Other parts are the region as a polyhedron, cut by the plane
or the quadric where the form of the counterweight vanishes. Corners of curved surfaces then
move by so little as gives the solid the moments of the counterweight.

With corners ``v_i = [x_i; 1]`` of a triangle and the origin as the fourth corner, a tetrahedron
of volume V has the moments ``V/20 (Σ v_i v_iᵀ + s sᵀ)``, ``s = Σ v_i``; a closed mesh is the
signed sum of them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from io import BytesIO, StringIO
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import homogeneous
from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.parts.outlines import Plate, plate_of
from balance.masses.counterweights.parts.step_solids import has_step, step_file
from balance.masses.counterweights.regions import Region
from balance.space.inertial_parameters.conversions import mass_properties
from balance.support.clarabel_adapter import triangles as upper_triangle
from balance.support.csv_text import csv_writer
from balance.support.dxf import polylines_dxf
from balance.support.tolerances import PART_MOMENTS
from kinematics.error_text import quoted
from kinematics.model.linkage import Notice
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array, IntArray
from kinematics.wording import without_round_off

TABLE = "parts.csv"
COLUMNS = (
    "link",
    "mesh",
    "outline",
    "solid",
    "density_kg_m3",
    "mass_kg",
    "volume_m3",
    "thickness_m",
    "x_m",
    "y_m",
    "z_m",
    "ixx_kg_m2",
    "iyy_kg_m2",
    "izz_kg_m2",
    "ixy_kg_m2",
    "ixz_kg_m2",
    "iyz_kg_m2",
    "mass_g",
    "x_mm",
    "y_mm",
    "z_mm",
    "along_x_mm",
    "along_y_mm",
    "along_z_mm",
)
# Rows and columns of Ixx, Iyy, Izz, Ixy, Ixz, Iyz.
ENTRIES = ((0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))

# Significant digits of the table: a mesh in single precision has no more.
DIGITS = 8
# Steps of Newton's method, the change of a coordinate for differences, and the share of the
# largest singular value below which a direction is left alone.
STEPS, DIFFERENCE, DEGENERATE = 6, 1e-6, 1e-5


class CounterweightPart(NamedTuple):
    """A counterweight as a solid, and the names of its files.

    Attributes:
        weight: the counterweight.
        solid: its solid.
        stem: names of its files without their ending.
    """

    weight: Counterweight
    solid: PartMesh
    stem: str

    @property
    def mesh(self) -> str:
        """Name of the file of its mesh."""
        return f"{self.stem}.stl"

    @property
    def moments(self) -> Array:
        """Moments ``∫ [x; 1][x; 1]ᵀ dV`` (4, 4) of its mesh about the designed centre."""
        return _mesh_moments(self.solid.points, self.solid.triangles)

    @property
    def outline(self) -> str | None:
        """Name of the file of its outline; None if it is no plate."""
        return f"{self.stem}.dxf" if self.solid.plate else None

    @property
    def step(self) -> str | None:
        """Name of the file of its exact solid; None if a curved surface cuts it."""
        return f"{self.stem}.step" if has_step(self.weight, self.solid.plate) else None

    def row(self, solids: bool = False) -> tuple[str, ...]:
        """Return its row of the table: the mass properties of the mesh; link frame.

        Args:
            solids: whether its exact solid is written too.
        """
        weight, plate = self.weight, self.solid.plate
        assert weight.density is not None
        mass, com, inertia = mass_properties(from_pseudo_inertia(weight.density * self.moments))
        size = weight.region.size
        centre = without_round_off(com + weight.com, size)
        numbers = (
            weight.density,
            mass,
            mass / weight.density,
            plate.thickness if plate else None,
            *centre,
            *without_round_off(inertia[ENTRIES], mass * size * size),
            1e3 * mass,
            *(1e3 * x for x in centre),
            *(1e3 * np.ptp(self.solid.points, axis=0)),
        )
        words = ("" if number is None else f"{number:.{DIGITS}g}" for number in numbers)
        files = (self.mesh, self.outline or "", (self.step or "") if solids else "")
        return (weight.link, *files, *words)


def parts_of(weights: Sequence[Counterweight]) -> tuple[CounterweightPart, ...]:
    """Make the solids of counterweights of limited density.

    Args:
        weights: the counterweights; those of point masses have no solid, and are left out.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf", balance="force")
        >>> answer = balance.counterweights(
        ...     space, ["crank", "rocker"], density=7850, shape="disc=0.02"
        ... )
        >>> parts = balance.masses.parts_of(answer.weights)
        >>> [part.mesh for part in parts]
        ['crank.stl', 'rocker.stl']
    """
    parts: list[CounterweightPart] = []
    for weight in weights:
        if weight.form is not None:
            stem = re.sub(r"[^\w.-]", "_", weight.link).lstrip(".") or "part"
            while stem.lower() in [part.stem.lower() for part in parts] + ["parts"]:
                stem += "_"
            parts.append(CounterweightPart(weight, _mesh_counterweight(weight), stem))
    return tuple(parts)


def part_files(parts: Sequence[CounterweightPart], solids: bool = False) -> dict[str, bytes]:
    """Make the files of parts: STL in mm, DXF in mm for plates, and ``parts.csv``.

    A mesh has its origin at the centre of mass of its counterweight, and the axes of the
    link; an outline has the coordinates of the link. The table has SI units, the centre in
    the link frame, and tensors of inertia about it, all of the meshes; then the mass in
    grams, and the centre and the sizes along the axes of the link in mm.

    Args:
        parts: from `parts_of`.
        solids: whether there are STEP files too, in mm, with the origin and axes of the meshes:
            exact solids of plates, and of regions that are whole or that planes cut.

    Returns:
        The contents by name.

    Raises:
        PackageError: build123d is needed for STEP, and is not installed.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf", balance="force")
        >>> answer = balance.counterweights(
        ...     space, ["crank", "rocker"], density=7850, shape="disc=0.02"
        ... )
        >>> files = balance.masses.part_files(balance.masses.parts_of(answer.weights))
        >>> list(files)
        ['crank.stl', 'crank.dxf', 'rocker.stl', 'rocker.dxf', 'parts.csv']
    """
    files: dict[str, bytes] = {}
    for part in parts:
        files[part.mesh] = _stl(part.solid)
        if part.solid.plate is not None:
            files[f"{part.stem}.dxf"] = polylines_dxf(part.solid.plate.loops(), closed=True)
        if solids and part.step is not None:
            files[part.step] = step_file(part.weight, part.solid.plate)
    text = StringIO(newline="")
    csv_writer(text).writerows([COLUMNS, *(part.row(solids) for part in parts)])
    files[TABLE] = text.getvalue().encode()
    return files


def part_notices(
    parts: Sequence[CounterweightPart], solids: bool = False
) -> tuple[Notice, ...]:
    """Tell which parts are too narrow, or lack an outline, an exact solid or their very mesh.

    Args:
        parts: from `parts_of`.
        solids: whether STEP files are wanted.
    """
    notices = []
    narrow = [part.weight.link for part in parts if part.weight.too_narrow]
    if narrow:
        notices.append(
            Notice("narrow_part", f"too narrow to cut: the part of {quoted(narrow)}")
        )
    flat = [part.weight.link for part in parts if part.outline is None]
    if flat:
        text = (
            f"no DXF of {quoted(flat)}: it is not of one thickness; plates are, by "
            "--thickness on a planar linkage"
        )
        notices.append(Notice("part_without_outline", text))
    curved = [part.weight.link for part in parts if part.step is None]
    if solids and curved:
        text = f"no STEP of {quoted(curved)}: a curved surface cuts it, and STL has it"
        notices.append(Notice("part_without_step", text))
    for part in parts:
        apart = _moments_apart(part.moments, _volume_moments(part.weight))
        if apart > PART_MOMENTS:
            text = (
                f"the mesh of '{part.weight.link}' differs by {apart:.1e} from the "
                "counterweight: parts.csv has the mesh, the URDF file the counterweight"
            )
            notices.append(Notice("rough_part", text))
    return tuple(notices)


def _stl(solid: PartMesh) -> bytes:
    """Write a mesh as binary STL in mm."""
    import trimesh

    mesh = trimesh.Trimesh(1e3 * solid.points, solid.triangles, process=False)
    text = BytesIO()
    mesh.export(text, file_type="stl")
    return text.getvalue()


if TYPE_CHECKING:
    from manifold3d import Manifold


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


def _mesh_counterweight(weight: Counterweight) -> PartMesh:
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
    fitted = _fit_moments(points - weight.com, triangles, _volume_moments(weight), along)
    rounded = np.asarray((1e3 * fitted).astype(np.float32), dtype=np.float64)
    return PartMesh(1e-3 * rounded, triangles, plate)


def _volume_moments(weight: Counterweight) -> Array:
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


def _mesh_moments(points: Array, triangles: IntArray) -> Array:
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


def _moments_apart(moments: Array, wanted: Array) -> float:
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
        away = _differences(_mesh_moments(points, triangles), wanted)
        slopes = [
            _differences(_mesh_moments(points + DIFFERENCE * move, triangles), wanted) - away
            for move in moves
        ]
        J = np.array(slopes).T / DIFFERENCE
        step = np.linalg.lstsq(J, -away, rcond=DEGENERATE)[0]
        points = points + np.einsum("k,kni->ni", step, moves)
    better = _moments_apart(_mesh_moments(points, triangles), wanted) < _moments_apart(
        _mesh_moments(start, triangles), wanted
    )
    return np.asarray(points if better else start)


def _differences(moments: Array, wanted: Array) -> Array:
    """Compute relative differences (10,)."""
    size = float(np.sqrt(np.trace(wanted[:3, :3]) / wanted[3, 3]))
    scale = np.diag([1.0 / size] * 3 + [1.0])
    return np.asarray(upper_triangle(scale @ (moments - wanted) @ scale) / wanted[3, 3])
