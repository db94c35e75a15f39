"""Files of parts: meshes, outlines of plates, and a table."""

from __future__ import annotations

import re
from collections.abc import Sequence
from io import BytesIO, StringIO
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.parts.mesh_moments import mesh_moments, moments_apart
from balance.masses.counterweights.parts.outlines import Plate
from balance.masses.counterweights.parts.solids import (
    PartMesh,
    mesh_counterweight,
    volume_moments,
)
from balance.space.inertial_parameters.conversions import mass_properties
from balance.support.csv_text import csv_writer
from balance.support.tolerances import PART_MOMENTS, PART_ROUND_OFF
from kinematics.model.linkage import Notice
from kinematics.model.spatial.inertia import from_pseudo_inertia

Array = NDArray[np.float64]

TABLE = "parts.csv"
COLUMNS = (
    "link", "mesh", "outline", "density_kg_m3", "mass_kg", "volume_m3", "thickness_m",
    "x_m", "y_m", "z_m", "ixx_kg_m2", "iyy_kg_m2", "izz_kg_m2", "ixy_kg_m2", "ixz_kg_m2",
    "iyz_kg_m2",
)  # fmt: skip
# Rows and columns of Ixx, Iyy, Izz, Ixy, Ixz, Iyz.
ENTRIES = ((0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))

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
    def row(self) -> tuple[str, ...]:
        """Its row of the table: the mass properties of the mesh; link frame."""
        weight, plate = self.weight, self.solid.plate
        assert weight.density is not None
        mass, com, inertia = mass_properties(from_pseudo_inertia(weight.density * self.moments))
        size = weight.region.size
        numbers = (
            weight.density, mass, mass / weight.density, plate.thickness if plate else None,
            *_without_round_off(com + weight.com, size),
            *_without_round_off(inertia[ENTRIES], mass * size * size),
        )  # fmt: skip
        words = ("" if number is None else f"{number:.{DIGITS}g}" for number in numbers)
        return (weight.link, self.mesh, f"{self.stem}.dxf" if plate else "", *words)


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


def part_files(parts: Sequence[CounterweightPart]) -> dict[str, bytes]:
    """Make the files of parts: STL in mm, DXF in mm for plates, and ``parts.csv``.

    A mesh has its origin at the centre of mass of its counterweight, and the axes of the
    link; an outline has the coordinates of the link. The table has SI units, the centre in
    the link frame, and tensors of inertia about it, all of the meshes.

    Args:
        parts: from `parts_of`.

    Returns:
        The contents by name.

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
            files[f"{part.stem}.dxf"] = _dxf(part.solid.plate)
    text = StringIO(newline="")
    csv_writer(text).writerows([COLUMNS, *(part.row for part in parts)])
    files[TABLE] = text.getvalue().encode()
    return files


def rough_parts(parts: Sequence[CounterweightPart]) -> tuple[Notice, ...]:
    """Return a notice for each part whose mesh has other moments than were computed."""
    notices = []
    for part in parts:
        apart = moments_apart(part.moments, volume_moments(part.weight))
        if apart > PART_MOMENTS:
            text = (
                f"the mesh of '{part.weight.link}' differs by {apart:.1e} from the "
                "counterweight: parts.csv has the mesh, the URDF file the counterweight"
            )
            notices.append(Notice("rough_part", text))
    return tuple(notices)


def _without_round_off(values: Array, size: float) -> list[float]:
    """Replace values that are round-off of a size by 0."""
    return [0.0 if abs(value) <= PART_ROUND_OFF * size else value for value in values.tolist()]


def _stl(solid: PartMesh) -> bytes:
    """Write a mesh as binary STL in mm."""
    import trimesh

    mesh = trimesh.Trimesh(1e3 * solid.points, solid.triangles, process=False)
    text = BytesIO()
    mesh.export(text, file_type="stl")
    return text.getvalue()


def _dxf(plate: Plate) -> bytes:
    """Write the outline of a plate as DXF in mm, with arcs; it has no time in it."""
    from ezdxf.addons.r12writer import r12writer

    text = StringIO(newline="")
    with r12writer(text) as drawing:
        for loop in plate.loops():
            drawing.add_polyline_2d(loop.tolist(), format="xyb", closed=True)
    return text.getvalue().encode()
