"""Files of parts: meshes, outlines of plates, exact solids, and a table with its key."""

from __future__ import annotations

import re
from collections.abc import Sequence
from io import BytesIO, StringIO
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.parts.dimensions import whole_dimensions
from balance.masses.counterweights.parts.outlines import Plate, signed_area
from balance.masses.counterweights.parts.part_meshes import (
    PartMesh,
    mesh_counterweight,
    mesh_moments,
    moments_apart,
    volume_moments,
)
from balance.masses.counterweights.parts.step_solids import has_step, step_file
from balance.masses.counterweights.regions import Region
from balance.space.inertial_parameters.conversions import mass_properties
from balance.support.csv_text import csv_writer
from balance.support.dxf import polylines_dxf
from balance.support.mass_table import ENTRIES
from balance.support.tolerances import PART_MOMENTS
from kinematics.error_text import quoted
from kinematics.model.linkage import Notice
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.wording import vector_text, without_round_off

TABLE = "parts.csv"
README = "README.txt"
# Meaning of columns whose name does not say it.
MEANINGS = {
    "shape": "disc, cylinder, sector, block or ball; plate if it has one thickness, else solid",
    "radius_mm": "radius of the rim of a round part",
    "angle_deg": "angle of a sector between its straight sides",
    "direction_deg": "direction of its middle, from x of the drawing towards y",
    "hole_radius_mm": "radius of the round hole in a plate",
    "axis_x_mm": "middle of the axis of a round part (x, y, z); of a sector, at the joint",
    "arm_mm": "distance of the part from the nearest joint of its link: what bridges it is not "
    "counted",
    "web_width_mm": "width of the web, a bar as thick as the part, which is counted with it",
    "web_length_mm": "length of the web, from the joint to the axis of the part",
    "web_x_mm": "end of the web at the joint (x, y, z): the middle of its side",
    "x_mm": "centre of mass (x, y, z)",
    "along_x_mm": "size of the part along the axes of the link (x, y, z)",
    "ixx_kg_m2": "moments of inertia about the centre of mass (xx, yy, zz, xy, xz, yz)",
}

# Significant digits of the table: a mesh in single precision has no more.
DIGITS = 8


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
        return mesh_moments(self.solid.points, self.solid.triangles)

    @property
    def outline(self) -> str | None:
        """Name of the file of its outline; None if it is no plate."""
        return f"{self.stem}.dxf" if self.solid.plate else None

    @property
    def step(self) -> str | None:
        """Name of the file of its exact solid; None if a curved surface cuts it."""
        return f"{self.stem}.step" if has_step(self.weight, self.solid.plate) else None

    def cells(self, solids: bool = False) -> dict[str, str]:
        """Return its row of the table: sizes, and mass properties of the mesh; link frame.

        Args:
            solids: whether its exact solid is written too.

        Returns:
            The text by column, in the order of the columns; empty where there is nothing.
        """
        weight, plate, whole = self.weight, self.solid.plate, whole_dimensions(self.weight)
        assert weight.density is not None
        mass, com, inertia = mass_properties(from_pseudo_inertia(weight.density * self.moments))
        size, region = weight.region.size, weight.region
        centre = without_round_off(com + weight.com, size).tolist()
        moments = without_round_off(inertia[ENTRIES], mass * size * size).tolist()
        radius: float | None = None
        axis: list[float | None] = [None] * 3
        if region.kind in ("cylinder", "sector") or (whole and whole.radius):
            radius = 1e3 * float(np.linalg.norm(region.place[:3, 0]))
            axis = (1e3 * without_round_off(region.centre, size)).tolist()
        along = (1e3 * np.ptp(self.solid.points, axis=0)).tolist()
        numbers = {
            "density_kg_m3": weight.density,
            "mass_kg": mass,
            "volume_m3": mass / weight.density,
            **_labelled("{}_m", "xyz", centre),
            **_labelled("i{}_kg_m2", ("xx", "yy", "zz", "xy", "xz", "yz"), moments),
            "mass_g": 1e3 * mass,
            "thickness_mm": 1e3 * plate.thickness if plate else None,
            "radius_mm": radius,
            "angle_deg": whole.angle if whole else None,
            "direction_deg": _direction(region, plate) if whole and whole.angle else None,
            "hole_radius_mm": _hole_radius(plate) if plate else None,
            **_labelled("axis_{}_mm", "xyz", axis),
            "arm_mm": None if weight.arm is None else 1e3 * weight.arm,
            **_web_sizes(weight),
            **_labelled("{}_mm", "xyz", [1e3 * x for x in centre]),
            **_labelled("along_{}_mm", "xyz", along),
        }
        shape = whole.shape if whole else "plate" if plate else "solid"
        words = {"link": weight.link, "shape": shape, "mesh": self.mesh}
        words |= {"outline": self.outline or "", "solid": (self.step or "") if solids else ""}
        return words | {
            name: "" if number is None else f"{number:.{DIGITS}g}"
            for name, number in numbers.items()
        }


def _labelled(
    form: str, labels: Sequence[str], numbers: Sequence[float | None]
) -> dict[str, float | None]:
    """Name numbers by a form with a label in it."""
    return {form.format(label): x for label, x in zip(labels, numbers, strict=True)}


def _web_sizes(weight: Counterweight) -> dict[str, float | None]:
    """Return the sizes of a web, and its end at the joint, mm; None without one."""
    web, length, width, end = weight.web, None, None, [None] * 3
    if web is not None:
        length, width = (1e3 * size for size in weight.web_sizes)
        joint = web.to_link([-1.0, 0.0, 0.0])
        end = (1e3 * without_round_off(joint, web.size)).tolist()
    sizes = {"web_length_mm": length, "web_width_mm": width}
    return sizes | _labelled("web_{}_mm", "xyz", end)


def _direction(region: Region, plate: Plate | None) -> float | None:
    """Compute the angle of the middle of a sector from the first axis of its drawing; degrees.

    Args:
        region: the sector.
        plate: its outline.
    """
    if plate is None:
        return None
    x, y, _ = (plate.axes @ region.place[:3, 0]).tolist()
    return float(np.degrees(np.arctan2(y, x)))


def _hole_radius(plate: Plate) -> float | None:
    """Return the radius of the round hole of a plate, mm; None without one."""
    holes = [
        0.5 * float(np.linalg.norm(loop[1, :2] - loop[0, :2]))
        for loop in plate.loops()
        if len(loop) == 2 and signed_area(loop) < 0.0
    ]
    return holes[0] if len(holes) == 1 else None


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
            parts.append(CounterweightPart(weight, mesh_counterweight(weight), stem))
    return tuple(parts)


def part_files(parts: Sequence[CounterweightPart], solids: bool = False) -> dict[str, bytes]:
    """Make the files of parts: STL, DXF of plates, ``parts.csv``, and ``README.txt``.

    Lengths in STL, DXF and STEP are mm, from the centre of mass of the part along the axes of
    its link; ``README.txt`` names those of each drawing, and the columns of the table. The
    table has SI units and the tensor of inertia about the centre, of the meshes; then, in g, mm
    and degrees, the mass, the dimensions that the part has (thickness, radius, angle and
    direction of a sector, hole, axis), its arm and web (see `Counterweight`), the centre of
    mass in the link frame and the sizes along its axes. Columns without a value for any part
    are left out.

    Args:
        parts: from `parts_of`.
        solids: whether there are STEP files too: exact solids of plates, and of regions that
            are whole or that planes cut.

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
        ['crank.stl', 'crank.dxf', 'rocker.stl', 'rocker.dxf', 'parts.csv', 'README.txt']
    """
    files: dict[str, bytes] = {}
    for part in parts:
        files[part.mesh] = _stl(part.solid)
        if part.solid.plate is not None:
            files[f"{part.stem}.dxf"] = _outline_dxf(part.weight, part.solid.plate)
        if solids and part.step is not None:
            files[part.step] = step_file(part.weight, part.solid.plate)
    rows, text = [part.cells(solids) for part in parts], StringIO(newline="")
    columns = [name for name in (rows[0] if rows else ()) if any(row[name] for row in rows)]
    csv_writer(text).writerows([columns, *([row[name] for name in columns] for row in rows)])
    files[TABLE] = text.getvalue().encode()
    files[README] = _readme(parts, columns).encode()
    return files


def _outline_dxf(weight: Counterweight, plate: Plate) -> bytes:
    """Write the outline of a plate about its centre of mass."""
    centre = 1e3 * plate.axes[:2] @ weight.com
    return polylines_dxf([loop - [*centre, 0.0] for loop in plate.loops()], closed=True)


def _readme(parts: Sequence[CounterweightPart], columns: Sequence[str]) -> str:
    """Write what the files of parts are, in which units and frames."""
    drawings = []
    for part in parts:
        if part.solid.plate is not None:
            x, y = (vector_text(axis) for axis in part.solid.plate.axes[:2])
            drawings.append(f"{part.outline}: x is {x} and y is {y} of {part.weight.link}")
    lines = [
        "Files of counterweights. Lengths in STL, DXF and STEP files are millimetres.",
        "",
        "All files of a part have one frame: the origin is the centre of mass of the part, at",
        "x_mm, y_mm, z_mm of parts.csv in the frame of its link, and the axes are those of the",
        "link. A DXF drawing has two of them:",
        *(drawings or ["none here: no part has one thickness."]),
        "",
        "Shapes lie in the plane of their links where their regions let them. Which layer a",
        "part is in, and whether it collides with other links or the frame, is not checked.",
        "",
        "Parts have no holes for shafts and screws. The web of a part, which ends at the axis",
        "of a joint, is in its files and is counted. What bridges an arm_mm above 0 is not:",
        "add its mass to the link in the file of the robot, and compute again.",
        "",
        "Columns of parts.csv, of the frame of the link:",
        *(f"{name}: {text}" for name, text in MEANINGS.items() if name in columns),
    ]
    return "\n".join(lines) + "\n"


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
        apart = moments_apart(part.moments, volume_moments(part.weight))
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
