"""Regions from meshes: convex free space as a closed STL, OBJ or other file of `trimesh`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from balance.masses.counterweights.regions import Region, hull_region
from balance.support.tolerances import MESH_CONVEX
from kinematics.errors import FileError
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Formats that hold one mesh in a single file, most bytes of it, and most corners of its hull.
FORMATS = (".stl", ".obj", ".ply", ".off")
MOST_BYTES = 50_000_000
MOST_CORNERS = 2_000


def mesh_region(file: str, scale: float, text: str) -> Region:
    """Read a convex region from a closed mesh in the frame of the link.

    Args:
        file: path of the mesh.
        scale: metres per unit of the file.
        text: the region in words.

    Raises:
        FileError: it cannot be read, is open, or is not convex.
    """
    mesh = _read_mesh(file)
    if not (mesh.is_watertight and mesh.is_winding_consistent):
        raise FileError(
            file, "", "the mesh is not closed", "close it, or give a ball, box or cylinder"
        )
    volume, points = abs(float(mesh.volume)), scale * np.asarray(mesh.vertices, np.float64)
    region = hull_region(points, text)
    more = region.volume / (scale**3 * volume or 1.0) - 1.0
    if more > MESH_CONVEX:
        problem = f"the mesh is not convex: its hull holds {number_text(100.0 * more, '.2g')} %"
        remedy = "matter could lie outside: give a convex piece of it, or a box inside it"
        raise FileError(file, "", f"{problem} more", remedy)
    if len(region.vertices) > MOST_CORNERS:
        problem = f"its hull has {len(region.vertices)} corners, more than {MOST_CORNERS}"
        raise FileError(file, "", problem, "simplify the mesh")
    return region


def _read_mesh(file: str) -> Any:
    """Read one mesh with `trimesh`.

    Raises:
        FileError: there is no such file, it is of another format or too large, or holds no
            mesh.
    """
    path = Path(file)
    if path.suffix.lower() not in FORMATS:
        formats = ", ".join(FORMATS)
        raise FileError(file, "", "no format of one mesh", f"give one of {formats}")
    try:
        size = path.stat().st_size
    except OSError as error:
        problem = f"cannot be read ({error.strerror or error})"
        raise FileError(file, "", problem, "give the path of a mesh") from None
    if size > MOST_BYTES:
        raise FileError(file, "", f"has {size} bytes", "simplify the mesh")
    import trimesh

    try:
        mesh = trimesh.load_mesh(path)
    except Exception as error:  # libraries of formats raise errors of all kinds
        problem = f"trimesh cannot read it ({type(error).__name__})"
        raise FileError(file, "", problem, "write the mesh anew") from None
    if not isinstance(mesh, trimesh.Trimesh) or not _is_finite(mesh):
        raise FileError(file, "", "has no mesh of finite corners", "write the mesh anew")
    return mesh


def _is_finite(mesh: Any) -> bool:
    """Whether a mesh has triangles, and no corner that is not a number."""
    corners: Array = np.asarray(mesh.vertices, dtype=np.float64)
    return len(mesh.faces) > 0 and bool(np.isfinite(corners).all())
