"""Volume, first and second moments of closed meshes, and meshes with wanted ones.

With corners ``v_i = [x_i; 1]`` of a triangle and the origin as the fourth corner, a tetrahedron
of volume V has the moments ``V/20 (Σ v_i v_iᵀ + s sᵀ)``, ``s = Σ v_i``; a closed mesh is the
signed sum of them.
"""

from __future__ import annotations

import numpy as np

from balance.masses.counterweights.added_matter import homogeneous
from balance.support.clarabel_adapter import triangles as upper_triangle
from kinematics.numerics.array_types import Array, IntArray

# Steps of Newton's method, the change of a coordinate for differences, and the share of the
# largest singular value below which a direction is left alone.
STEPS, DIFFERENCE, DEGENERATE = 6, 1e-6, 1e-5


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


def fit_moments(
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
