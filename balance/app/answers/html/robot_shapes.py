"""The shapes that a robot file gives its links: boxes, cylinders, spheres and meshes.

Meshes are simplified by clustering: vertices in one cell of a grid become their mean, and
triangles that lose a corner are left out. Points are stored as 16-bit numbers between the
corners of a box, which keeps a page small.
"""

from __future__ import annotations

import base64
import logging
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.joint_positions import si_chain
from kinematics.files.urdf.robot_tree import pose_matrix
from kinematics.model.chain import rigid_parts
from kinematics.model.document.element import Element
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import first_names

logger = logging.getLogger(__name__)

IntArray = NDArray[np.int64]

# Most triangles of all shapes on a page, about 1.3 MB.
MAX_FACES = 100_000
# Larger files are left out, bytes.
MAX_FILE = 100_000_000
# Suffixes of files of meshes that are read.
SUFFIXES = (".stl", ".obj", ".dae", ".ply", ".glb", ".gltf", ".off")
# Cells along the longest side of a shape that is simplified, at first.
CELLS = 128.0
# Colour without a material.
GREY = "#9aa4ae"
# Points around a cylinder or sphere, and from pole to pole.
AROUND, DOWN = 32, 12


class Shape(NamedTuple):
    """Triangles in the frame of their link.

    Attributes:
        points: corners (n, 3), metres.
        faces: indices of the corners (m, 3).
        colour: ``"#rrggbb"``.
    """

    points: Array
    faces: IntArray
    colour: str


def robot_shapes(linkage: Linkage) -> list[dict[str, object]]:
    """Collect the shapes of the ``<visual>`` elements of the file of a linkage.

    A mesh that is missing, too large or of an unknown format is left out, and the log says so.

    Returns:
        One entry per shape and colour: ``part``, ``name`` of the link, ``color``, the corners
        ``low`` and ``high`` of its box at the reference pose, and base64 texts ``points``
        and ``faces``; empty without such elements.
    """
    if linkage.tree is None:
        return []
    chain = si_chain(linkage, spatial=True)
    part = rigid_parts(chain.parent.size, chain.ends)
    placed_shapes: list[tuple[int, str, Shape]] = []
    left_out: list[str] = []
    for link in linkage.tree.every("link"):
        if link.name not in linkage.places:
            continue
        place = linkage.places[link.name]
        for shape in _readable_shapes(link, linkage.tree, Path(linkage.source), left_out):
            points = shape.points @ place.pose[:3, :3].T + place.pose[:3, 3]
            placed_shapes.append(
                (int(part[place.link]), link.name, shape._replace(points=points))
            )
    if left_out:
        logger.warning("shapes_left_out: %s", first_names(list(dict.fromkeys(left_out))))
    limit = _faces_each([len(shape.faces) for *_, shape in placed_shapes])
    return [_packed(p, name, simplified(shape, limit)) for p, name, shape in placed_shapes]


def _readable_shapes(
    link: Element, robot: Element, file: Path, left_out: list[str]
) -> list[Shape]:
    """Read the shapes of one link; note those whose numbers or meshes cannot be read."""
    try:
        shapes = list(_link_shapes(link, robot, file, left_out))
    except (ValueError, IndexError):
        left_out.append(f"link {link.name} (a number of <visual> cannot be read)")
        return []
    return [shape for shape in shapes if np.isfinite(shape.points).all()]


def _link_shapes(
    link: Element, robot: Element, file: Path, left_out: list[str]
) -> Iterator[Shape]:
    """Read the shapes of one link."""
    for visual in link.every("visual"):
        geometry = visual.first("geometry")
        kind = next(iter(geometry.children), None) if geometry is not None else None
        if kind is None:
            continue
        colour, pose = _material(visual, robot), pose_matrix(visual.first("origin"))
        for shape in _geometry(kind, file, left_out):
            placed = shape.points @ pose[:3, :3].T + pose[:3, 3]
            yield Shape(placed, shape.faces, colour or shape.colour)


def _material(visual: Element, robot: Element) -> str:
    """Find the colour of a visual: its own, or that of its name in the robot; else empty."""
    material = visual.first("material")
    if material is None:
        return ""
    named = [element for element in robot.every("material") if element.name == material.name]
    for element in (material, *named):
        colour = element.first("color")
        if colour is not None:
            return _hex(colour.vector("rgba", "0.6 0.6 0.6 1")[:3])
    return ""


def _hex(rgb: Any) -> str:
    """Write a colour (3,), 0 to 1."""
    return "#" + "".join(f"{round(255 * min(max(float(c), 0.0), 1.0)):02x}" for c in rgb)


def _geometry(kind: Element, file: Path, left_out: list[str]) -> Iterator[Shape]:
    """Make the triangles of a primitive or a mesh."""
    if kind.tag == "box":
        size = np.array(kind.vector("size", "0 0 0"))
        yield _hull_of_grid(
            np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
            np.array([[1.0, -1.0], [1.0, 1.0]]),
            0.5 * size,
        )
    elif kind.tag in ("cylinder", "sphere"):
        radius = kind.vector("radius", "0")[0]
        turn = 2.0 * np.pi * np.arange(AROUND) / AROUND
        circle = np.column_stack([np.cos(turn), np.sin(turn)])
        if kind.tag == "cylinder":
            half, profile = 0.5 * kind.vector("length", "0")[0], [[1.0, -1.0], [1.0, 1.0]]
        else:
            half, down = radius, np.pi * np.arange(1, DOWN) / DOWN
            profile = np.column_stack([np.sin(down), -np.cos(down)]).tolist()
        yield _hull_of_grid(circle, np.array(profile), np.array([radius, radius, half]))
    elif kind.tag == "mesh":
        name = kind.attributes.get("filename", "")
        path = _mesh_path(name, file)
        if path is None:
            left_out.append(f"{name} (no such mesh, above 100 MB, or of a format not read)")
        else:
            yield from _mesh_shapes(path, np.array(kind.vector("scale", "1 1 1")), left_out)


def _hull_of_grid(outline: Array, profile: Array, size: Array) -> Shape:
    """Make a closed surface of an outline (n, 2) scaled by a profile (radius, z) along z."""
    n, m = len(outline), len(profile)
    rings = [np.column_stack([r * outline, np.full(n, z)]) for r, z in profile]
    ends = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]
    k, j = np.arange(n), (np.arange(n) + 1) % n
    faces = [np.column_stack([np.full(n, n * m), j, k])]
    for r in range(m - 1):
        a, b = r * n + k, r * n + j
        faces += [np.column_stack([a, b, b + n]), np.column_stack([a, b + n, a + n])]
    faces.append(np.column_stack([np.full(n, n * m + 1), (m - 1) * n + k, (m - 1) * n + j]))
    return Shape(np.concatenate([*rings, ends]) * size, np.concatenate(faces), GREY)


def _mesh_path(name: str, file: Path) -> Path | None:
    """Find the file of a mesh: beside the robot file, or in a package around it."""
    if not name.lower().endswith(SUFFIXES):
        return None
    scheme, _, rest = name.rpartition("://")
    folders = [file.parent, *file.resolve().parents]
    if scheme == "package":
        listed = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        folders = [*folders, *map(Path, filter(None, listed))]
        folders += [folder.parent for folder in folders if folder.name == rest.split("/")[0]]
    elif scheme not in ("", "file"):
        return None
    for path in (folder / rest for folder in folders):
        if path.is_file() and path.stat().st_size <= MAX_FILE:
            return path
    return None


def _mesh_shapes(path: Path, scale: Array, left_out: list[str]) -> Iterator[Shape]:
    """Read the meshes of a file; note a file that cannot be read."""
    import trimesh

    if path.suffix.lower() == ".dae" and b"<!DOCTYPE" in path.read_bytes():
        # Entities could read other files.
        left_out.append(f"{path.name} (a mesh with a document type is not read)")
        return
    try:
        parts = trimesh.load_scene(path, skip_materials=False).dump()
    except Exception as error:  # libraries of formats raise errors of all kinds
        left_out.append(f"{path.name} (trimesh cannot read it: {type(error).__name__})")
        return
    mesh: Any
    for mesh in parts:
        points: Array = np.asarray(mesh.vertices, dtype=np.float64)
        faces: IntArray = np.asarray(mesh.faces, dtype=np.int64)
        if len(faces) and np.isfinite(points).all():
            yield Shape(points * scale, faces, _mesh_colour(mesh))


def _mesh_colour(mesh: Any) -> str:
    """Read the main colour of a mesh; grey if it has none."""
    material = getattr(mesh.visual, "material", None)
    colour = getattr(material, "main_color", None)
    return GREY if colour is None else _hex(np.asarray(colour)[:3] / 255.0)


def _faces_each(counts: list[int]) -> int:
    """Find the largest limit of triangles per shape that keeps all within `MAX_FACES`."""
    limit = max(counts, default=0)
    while sum(min(count, limit) for count in counts) > MAX_FACES:
        limit = int(0.9 * limit)
    return limit


def simplified(shape: Shape, most: int) -> Shape:
    """Simplify a shape to at most a number of triangles by clustering its vertices.

    Args:
        shape: the shape.
    """
    mesh, cells = shape, CELLS
    while len(mesh.faces) > most and cells > 2.0:
        mesh = _clustered(shape, cells)
        # The number of triangles of a surface grows as the square of that of the cells.
        cells *= min(0.95 * float(np.sqrt(most / max(len(mesh.faces), 1))), 0.9)
    return mesh


def _clustered(shape: Shape, cells: float) -> Shape:
    """Replace the vertices in each cell of a grid by their mean."""
    low, span = shape.points.min(axis=0), float(np.ptp(shape.points, axis=0).max()) or 1.0
    i, j, k = np.floor((shape.points - low) / span * cells).astype(np.int64).T
    _, cluster = np.unique((i << 40) + (j << 20) + k, return_inverse=True)
    count = np.bincount(cluster)
    points = [np.bincount(cluster, shape.points[:, axis]) / count for axis in range(3)]
    faces = cluster[shape.faces]
    kept = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    a, b, c = np.sort(kept, axis=1).T
    _, first = np.unique((a << 42) + (b << 21) + c, return_index=True)
    return Shape(np.column_stack(points), kept[first], shape.colour)


def _packed(part: int, name: str, shape: Shape) -> dict[str, object]:
    """Write a shape as data of a page."""
    used, faces = np.unique(shape.faces, return_inverse=True)
    points = shape.points[used]
    low, high = points.min(axis=0), points.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    grid = np.round((points - low) / span * 65535.0).astype("<u2")
    wide = len(used) > 65535
    indices = faces.reshape(-1).astype("<u4" if wide else "<u2")
    return {
        "part": part,
        "name": name,
        "color": shape.colour,
        "wide": wide,
        "low": low.tolist(),
        "high": (low + span).tolist(),
        "points": base64.b64encode(grid.tobytes()).decode(),
        "faces": base64.b64encode(indices.tobytes()).decode(),
    }
