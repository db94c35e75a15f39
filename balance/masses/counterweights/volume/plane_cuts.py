"""Moments of the part of a region on one side of a plane, in closed form.

- box and hull: tetrahedra from the centre to the facets are cut into tetrahedra; that with
  corners ``v_i = [x_i; 1]`` and volume V has the moments ``V/20 (Σ v_i v_iᵀ + s sᵀ)`` with
  ``s = Σ v_i``.
- ball and ellipsoid: a cap, by powers of its depth.
- cylinder: slices across the plane have a width ``2 cos θ``, and between the places where the
  plane leaves an end their moments are trigonometric polynomials of θ, for which the formula of
  Gauss is exact to round-off.
"""

from __future__ import annotations

import numpy as np

from balance.masses.counterweights.added_matter import homogeneous
from balance.masses.counterweights.regions import Region
from kinematics.numerics.array_types import Array

# Slices of a cylinder between two places: the degree in θ is at most 5.
SLICES = 24


def cut_moments(region: Region, normal: Array, constant: float) -> Array:
    """Integrate ``[u; 1][u; 1]ᵀ`` over the part of a region where ``normal·u + constant > 0``.

    Args:
        region: the region.
        normal: any vector (3,) in unit coordinates.
        constant: constant part.

    Returns:
        The moments (4, 4) in unit coordinates.
    """
    if region.offsets.size:
        return _polytope_part(region, normal, constant)
    if region.kind == "cylinder":
        return _cylinder_part(normal, constant)
    return _cap(normal, constant)


def _polytope_part(region: Region, normal: Array, constant: float) -> Array:
    """Cut the tetrahedra of a box or hull."""
    corners = homogeneous(region.vertices)[region.triangles]
    tetrahedra = np.concatenate([np.tile(np.eye(4)[3], (len(corners), 1, 1)), corners], axis=1)
    heights = tetrahedra @ np.append(normal, constant)
    order = np.argsort(-heights, axis=1, kind="stable")
    v, f = np.take_along_axis(tetrahedra, order[..., None], 1), np.sort(-heights, axis=1)
    above = (f < 0.0).sum(axis=1)
    pieces, signs = [v[above >= 3]], [np.ones(int((above >= 3).sum()))]
    for k, tip, sign in ((1, 0, 1.0), (3, 3, -1.0)):
        piece, g = v[above == k].copy(), f[above == k]
        others = [j for j in range(4) if j != tip]
        for j in others:
            piece[:, j] = _crossing(v[above == k], g, tip, j)
        pieces.append(piece)
        signs.append(np.full(len(piece), sign))
    w, g = v[above == 2], f[above == 2]
    a, b, c = w[:, 0], _crossing(w, g, 0, 2), _crossing(w, g, 0, 3)
    d, e, h = w[:, 1], _crossing(w, g, 1, 2), _crossing(w, g, 1, 3)
    for piece_corners in ((a, b, c, d), (b, c, d, e), (c, d, e, h)):
        pieces.append(np.stack(piece_corners, axis=1))
        signs.append(np.ones(len(w)))
    every = np.concatenate(pieces)
    volumes = np.concatenate(signs) * np.abs(np.linalg.det(every)) / 6.0
    sums = every.sum(axis=1)
    squares = every.mT @ every + sums[:, :, None] * sums[:, None, :]
    return np.asarray(np.einsum("n,nij->ij", volumes, squares) / 20.0)


def _crossing(v: Array, f: Array, i: int, j: int) -> Array:
    """Compute where edges from corner i to corner j cross the plane (n, 4)."""
    t = f[:, i] / (f[:, i] - f[:, j])
    return np.asarray(v[:, i] + t[:, None] * (v[:, j] - v[:, i]))


def _cap(normal: Array, constant: float) -> Array:
    """Compute the moments of a cap of the unit ball."""
    size = float(np.linalg.norm(normal))
    if size == 0.0 or abs(constant) >= size:
        whole = constant > 0.0
        return np.diag([0.2, 0.2, 0.2, 1.0]) * (4.0 / 3.0 * np.pi * whole)
    n, h = normal / size, -constant / size
    linear, cubic, quintic = 1.0 - h, (1.0 - h**3) / 3.0, (1.0 - h**5) / 5.0
    along = np.pi * (cubic - quintic)
    across = 0.25 * np.pi * (linear - 2.0 * cubic + quintic)
    moments = np.zeros((4, 4))
    moments[:3, :3] = across * np.eye(3) + (along - across) * np.outer(n, n)
    moments[:3, 3] = moments[3, :3] = 0.25 * np.pi * (1.0 - h * h) ** 2 * n
    moments[3, 3] = np.pi * (linear - cubic)
    return moments


def _cylinder_part(normal: Array, constant: float) -> Array:
    """Compute the moments of the unit cylinder on one side of a plane."""
    alpha, beta = float(np.hypot(normal[0], normal[1])), float(normal[2])
    e = np.append(normal[:2] / alpha, 0.0) if alpha > 0.0 else np.eye(3)[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        places = np.array([(-beta - constant), (beta - constant)]) / alpha
    kinks = np.arcsin(np.clip(places[np.isfinite(places)], -1.0, 1.0))
    ends = np.sort(np.concatenate([[-0.5 * np.pi, 0.5 * np.pi], kinks]))
    nodes, weights = np.polynomial.legendre.leggauss(SLICES)
    middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    theta = (middle[:, None] + half[:, None] * nodes).reshape(-1)
    w = (half[:, None] * weights).reshape(-1)
    x, width = np.sin(theta), np.cos(theta)
    low, high = _heights(alpha * x + constant, beta)
    w = 2.0 * w * width**2
    height, z = high - low, 0.5 * (high**2 - low**2)
    axes = np.column_stack([e, np.cross(np.eye(3)[2], e), np.eye(3)[2], np.zeros(3)])
    frame = np.vstack([axes, np.eye(4)[3]])
    xx, xz, x1 = w @ (x * x * height), w @ (x * z), w @ (x * height)
    yy, zz = w @ (width**2 * height) / 3.0, w @ (high**3 - low**3) / 3.0
    local = np.array(
        [
            [xx, 0.0, xz, x1],
            [0.0, yy, 0.0, 0.0],
            [xz, 0.0, zz, w @ z],
            [x1, 0.0, w @ z, w @ height],
        ]
    )
    return np.asarray(frame @ local @ frame.T)


def _heights(values: Array, beta: float) -> tuple[Array, Array]:
    """Compute the interval of z in -1 to 1 where ``values + beta z > 0``; may be empty."""
    low, high = np.full(values.shape, -1.0), np.ones(values.shape)
    if beta == 0.0:
        return low, np.where(values > 0.0, high, low)
    crossing = np.clip(-values / beta, -1.0, 1.0)
    return (crossing, high) if beta > 0.0 else (low, crossing)
