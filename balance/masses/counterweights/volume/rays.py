"""Integrals over the part of a region where a quadratic polynomial is positive, along rays.

Every region is star-shaped about each of its points o: with points p of its surface and
weights w,

    ∫_K f dV = Σ_i w_i ∫_0^1 τ² f(o + τ (p_i - o)) dτ,    w = ((p - o) · normal) × area,

and along a ray the polynomial ``a τ² + 2 b τ + c`` has at most two roots, between which
integrals are exact. What is approximate is the sum over the rays. It is best where o is far
from the surface on which the polynomial vanishes.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.regions import Region
from kinematics.numerics.array_types import Array, Flags

# Powers of τ in mass, first and second moments, with the factor τ² of the volume.
POWERS = (3, 4, 5)


class Rays(NamedTuple):
    """Rays from a point of a region to its surface, in unit coordinates.

    Attributes:
        origin: o (3,).
        sides: vectors p - o (3, n).
        weights: weights (n,).
    """

    origin: Array
    sides: Array
    weights: Array

    def products(self, tau: Array, chosen: Flags) -> Array:
        """Compute ``[u; 1][u; 1]ᵀ`` (k, 16) at τ (k,) on chosen rays (n,)."""
        v = np.ones((tau.size, 4))
        v[:, :3] = self.origin + tau[:, None] * self.sides[:, chosen].T
        return np.asarray((v[:, :, None] * v[:, None, :]).reshape(-1, 16))


@lru_cache(maxsize=16)
def rays_of(region: Region, count: int, origin: tuple[float, float, float]) -> Rays:
    """Choose rays to the surface of a region, in its unit coordinates.

    Args:
        region: the region.
        count: about how many.
        origin: the point o that they start from.
    """
    ends, areas, normals, heights = _surface(region, count)
    o = np.array(origin)
    return Rays(o, ends - o[:, None], areas * (heights - o @ normals))


@lru_cache(maxsize=32)
def _surface(region: Region, count: int) -> tuple[Array, Array, Array, Array]:
    """Choose points (3, n), their areas, normals (3, n), and heights ``p · normal``."""
    if region.offsets.size:
        ends, areas, normals = _polytope_surface(region, count)
    elif region.kind == "cylinder":
        ends, areas, normals = _cylinder_surface(count)
    else:
        ends, areas = _sphere(count)
        normals = ends
    columns = np.ascontiguousarray(ends.T), areas, np.ascontiguousarray(normals.T)
    return *columns, (ends * normals).sum(axis=1)


def integrate_positive_part(
    rays: Rays, form: Array, powers: tuple[int, int, int] = POWERS
) -> Array:
    """Integrate ``[u; 1][u; 1]ᵀ`` over the part of a region where a quadratic is positive.

    Args:
        rays: the rays of the region.
        form: symmetric matrix M (4, 4) of the polynomial ``[u; 1]ᵀ M [u; 1]``.
        powers: of τ in mass, first and second moments; by default those of a volume.

    Returns:
        The moments (4, 4) in unit coordinates.
    """
    o, sides, w = rays
    intervals = positive_intervals(rays, form)
    # What is positive up to a root counts there, and not beyond: plus or minus its power of τ.
    parts = [change * tau ** powers[0] for tau, change in intervals.roots]
    moments = []
    for power in powers:
        moments.append(w * (parts[0] + parts[1] + intervals.at_end) / power)
        parts = [part * tau for part, (tau, _) in zip(parts, intervals.roots, strict=True)]
    mass, first, second = moments
    local = np.empty((4, 4))
    local[:3, :3] = (second * sides) @ sides.T
    local[:3, 3] = local[3, :3] = sides @ first
    local[3, 3] = mass.sum()
    shift = np.eye(4)
    shift[:3, 3] = o
    return np.asarray(shift @ local @ shift.T)


def surface_products(rays: Rays, form: Array, basis: Array) -> Array:
    """Integrate products of polynomials over the surface where a quadratic vanishes.

    It is the second derivative ``∫_{q = 0} f_i f_j / |∇q| dS`` of ``∫ max(q, 0) dV``.

    Args:
        rays: the rays of the region.
        form: symmetric matrix (4, 4) of q.
        basis: symmetric matrices (n, 4, 4) of the polynomials f.

    Returns:
        The integrals (n, n).
    """
    intervals = positive_intervals(rays, form)
    slopes = intervals.slopes
    flat = basis.reshape(len(basis), 16).T
    total = np.zeros((len(basis), len(basis)))
    for tau, _ in intervals.roots:
        inside = (tau > 0.0) & (tau < 1.0) & (slopes > 0.0)
        t = tau[inside]
        values = rays.products(t, inside) @ flat
        weights = rays.weights[inside] * t * t / slopes[inside]
        total += (weights * values.T) @ values
    return total


class Intervals(NamedTuple):
    """Where a quadratic is positive along rays.

    Attributes:
        roots: two pairs, the lesser first, of a root within [0, 1] (n,), and the number of
            positive intervals that end there less that of those that begin there (n,). A ray
            without roots may have any.
        at_end: 1 where it is positive at τ = 1, else 0 (n,).
        slopes: size of the derivative at the roots (n,); 0 where there are none.
    """

    roots: tuple[tuple[Array, Array], tuple[Array, Array]]
    at_end: Array
    slopes: Array


def positive_intervals(rays: Rays, form: Array) -> Intervals:
    """Find where a quadratic is positive along rays."""
    p, o = rays.sides, np.append(rays.origin, 1.0)
    q = form[:3, :3] @ p
    a = q[0] * p[0] + q[1] * p[1] + q[2] * p[2]
    b, c = (form[:3] @ o) @ p, float(o @ form @ o)
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    far = -(b + np.copysign(root, b))
    with np.errstate(divide="ignore", invalid="ignore"):
        # Zero over zero is no root: fmax makes it 0, where no interval ends.
        x, y = (np.fmin(np.fmax(each, 0.0), 1.0) for each in (far / a, c / far))
    first, second = np.minimum(x, y), np.maximum(x, y)
    middle = 0.5 * (first + second)
    between = ((a * middle + 2.0 * b) * middle + c > 0.0).astype(np.float64)
    at_end = (a + 2.0 * b + c > 0.0).astype(np.float64)
    roots = (first, float(c > 0.0) - between), (second, between - at_end)
    return Intervals(roots, at_end, 2.0 * root)


def _polytope_surface(region: Region, count: int) -> tuple[Array, Array, Array]:
    """Choose points of facets, their areas and normals.

    Each triangle is a square that is collapsed at a corner.
    """
    corners = region.vertices[region.triangles]
    n = max(2, int(np.ceil(np.sqrt(count / len(corners)))))
    x, w = unit_gauss(n)
    s, t = np.repeat(x, n), np.tile(x, n)
    A, B, C = corners[:, 0], corners[:, 1], corners[:, 2]
    ends = A[:, None] + s[:, None] * (B - A)[:, None] + (s * t)[:, None] * (C - B)[:, None]
    sizes = np.linalg.norm(np.cross(B - A, C - A), axis=1)
    areas = sizes[:, None] * (np.repeat(w, n) * np.tile(w, n) * s)
    return ends.reshape(-1, 3), areas.reshape(-1), np.repeat(region.normals, n * n, axis=0)


def _sphere(count: int) -> tuple[Array, Array]:
    """Choose points of the unit sphere, and their areas."""
    circle, around, x, w = _circle_and_heights(count / 2)
    heights = 2.0 * x - 1.0
    across = np.sqrt(1.0 - heights**2)
    ends = across[:, None, None] * circle + heights[:, None, None] * np.eye(3)[2]
    return ends.reshape(-1, 3), np.outer(2.0 * w, around).reshape(-1)


def _cylinder_surface(count: int) -> tuple[Array, Array, Array]:
    """Choose points of the surface of the unit cylinder, their areas and normals."""
    circle, around, x, w = _circle_and_heights(count / 6)
    z = np.eye(3)[2]
    side = (circle + (2.0 * x - 1.0)[:, None, None] * z).reshape(-1, 3)
    disc = (x[:, None, None] * circle).reshape(-1, 3)
    wall, end = np.outer(2.0 * w, around).reshape(-1), np.outer(w * x, around).reshape(-1)
    normals = np.concatenate(
        [np.tile(circle, (len(x), 1)), np.tile(z, (end.size, 1)), np.tile(-z, (end.size, 1))]
    )
    return np.concatenate([side, disc + z, disc - z]), np.concatenate([wall, end, end]), normals


def _circle_and_heights(count: float) -> tuple[Array, Array, Array, Array]:
    """Choose 2 n points of a circle with weights, and n between 0 and 1; ``n² = count``."""
    n = max(2, int(np.ceil(np.sqrt(count))))
    x, w = unit_gauss(n)
    turn = (np.arange(2 * n) + 0.5) * np.pi / n
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(2 * n)])
    return circle, np.full(2 * n, np.pi / n), x, w


@lru_cache(maxsize=32)
def unit_gauss(n: int) -> tuple[Array, Array]:
    """Compute nodes and weights of Gauss and Legendre between 0 and 1."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (x + 1.0), 0.5 * w
