"""Surface of matter that fills a part of its region, for drawings.

The matter is where two functions are positive: the depth below the surface of the region, and
the form of the weight. Their minimum is sampled on a grid along the principal axes of the
matter. Each cell that the surface crosses has one vertex, the mean of its crossings with the
edges of the cell, and each edge that it crosses has one face, between the cells around it
(surface nets: S. F. F. Gibson, Constrained elastic surface nets, MICCAI 1998).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from kinematics.numerics.array_types import Array, IntArray

# Grids that close in on the matter, the one after which they lie along its axes, their points
# along each axis, and cells of the surface.
SEARCHES, TURNED, SEARCHED, CELLS = 4, 1, 25, 16
# Least thickness of a grid, of its length.
THINNEST = 1e-4


class Surface(NamedTuple):
    """A closed surface.

    Attributes:
        points: vertices (n, 3) in the link frame, metres.
        faces: triangles (f, 3), counterclockwise from outside.
    """

    points: Array
    faces: IntArray


class _Box(NamedTuple):
    """A box in unit coordinates: its axes as rows (3, 3), and its ends along them (3,)."""

    axes: Array
    low: Array
    high: Array

    def grid(self, count: int) -> Array:
        """Return points (count, count, count, 3) in unit coordinates."""
        steps = np.linspace(self.low, self.high, count).T
        return np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1) @ self.axes


def filled_surface(weight: Counterweight) -> Surface | None:
    """Compute the surface of a weight that fills a part of its region.

    Args:
        weight: the weight; point masses have no surface, nor has matter too thin to be seen. A
            web is a solid of its own.
    """
    if weight.form is None:
        return None
    region = weight.region
    form = region.place.T @ weight.form @ region.place
    form /= np.abs(form).max()

    def depth(units: Array) -> Array:
        p = np.concatenate([units, np.ones((*units.shape[:-1], 1))], axis=-1)
        return np.minimum(-region.excess(units), ((p @ form) * p).sum(axis=-1))

    box = _box_of_matter(depth, np.abs([*region.vertices, np.ones(3)]).max(axis=0))
    values = depth(box.grid(CELLS + 1))
    inner = (slice(1, -1),) * 3
    values = np.pad(values[inner], 1, constant_values=float(values.min()))
    if not (values > 0.0).any():
        return None
    places, faces = _surface_net(values)
    points = (box.low + places / CELLS * (box.high - box.low)) @ box.axes
    if np.linalg.det(box.axes) * np.linalg.det(region.place[:3, :3]) < 0.0:
        faces = faces[:, ::-1]
    points = region.to_link(points)
    if weight.web is not None:
        corners, sides = weight.web.to_link(weight.web.vertices), weight.web.triangles
        faces = np.concatenate([faces, _outward(corners, sides) + len(points)])
        points = np.concatenate([points, corners])
    return Surface(points, faces)


def _outward(corners: Array, triangles: IntArray) -> IntArray:
    """Order the corners of triangles (f, 3) of a convex solid from outside."""
    sides = corners[triangles] - corners.mean(axis=0)
    inward = np.linalg.det(sides) < 0.0
    return np.where(inward[:, None], triangles[:, ::-1], triangles)


def _box_of_matter(depth: Callable[[Array], Array], reach: Array) -> _Box:
    """Close in on positive depths in the box up to ``reach`` to all sides.

    A point stays if the slope of the depth there may lead above 0 within a step of the grid.
    """
    box = _Box(np.eye(3), -reach, reach)
    for search in range(SEARCHES):
        grid = box.grid(SEARCHED)
        values = depth(grid)
        slope = np.abs(np.gradient(values)).sum(axis=0)
        near = grid[values + slope > 0.0]
        room = (box.high - box.low) / (SEARCHED - 1)
        axes = box.axes
        if search == TURNED and len(near) > 3:
            axes = np.linalg.svd(near - near.mean(axis=0), full_matrices=False)[2]
            room = np.full(3, np.linalg.norm(room))
        along = near @ axes.T
        room = np.maximum(room, THINNEST * room.max())
        box = _Box(axes, along.min(axis=0) - room, along.max(axis=0) + room)
    return box


def _surface_net(values: Array) -> tuple[Array, IntArray]:
    """Compute vertices (n, 3), in cells, and triangles (f, 3) around positive values.

    Args:
        values: of all corners of cells, positive at no side of the grid.
    """
    cells = (CELLS,) * 3
    sums, counts = np.zeros((*cells, 3)), np.zeros(cells)
    crossed: list[IntArray] = []
    for axis in range(3):
        v = np.moveaxis(values, axis, 0)
        start, end = v[:-1], v[1:]
        crossing = (start > 0.0) != (end > 0.0)
        part = np.where(crossing, start / np.where(crossing, start - end, 1.0), 0.0)
        for near in product((0, 1), repeat=2):
            cut = (slice(None), *(slice(side, side + CELLS) for side in near))
            offset = np.zeros((*cells, 3))
            offset[..., axis] = np.moveaxis(part[cut], 0, axis)
            offset[..., [other for other in range(3) if other != axis]] = near
            here = np.moveaxis(crossing[cut], 0, axis)
            sums += np.where(here[..., None], offset, 0.0)
            counts += here
        crossed.append(np.argwhere(np.moveaxis(crossing, 0, axis)))
    used = counts > 0
    number = np.full(cells, -1)
    number[used] = np.arange(used.sum())
    points = np.argwhere(used) + sums[used] / counts[used][:, None]
    faces = [_faces(number, values, edges, axis) for axis, edges in enumerate(crossed)]
    return points, np.concatenate(faces)


def _faces(number: IntArray, values: Array, edges: IntArray, axis: int) -> IntArray:
    """Return the triangles (2 n, 3) between the cells around edges (n, 3) along an axis."""
    a, b = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
    around = [number[tuple((edges - shift).T)] for shift in (a + b, b, 0 * a, a)]
    quads = np.column_stack(around)
    ends = values[tuple(edges.T)] <= 0.0
    quads[ends] = quads[ends][:, ::-1]
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
