"""Integrals over the part of a unit ball where a quadratic constant along an axis is positive.

Across the axis the part has a section in the unit disc, and its thickness over a point p of it
is 2 h with ``h² = 1 - |p|²``. Along a ray from the middle of the disc, ``|p| = cos φ`` makes of
powers of |p| and h trigonometric polynomials of φ, for which the formula of Gauss is exact
to round-off. Only the sum over the rays is left (`disc_rays`), which is of one dimension.
"""

from __future__ import annotations

import numpy as np

from balance.masses.counterweights.volume.disc_rays import plane_across, rays_to_rim
from balance.masses.counterweights.volume.rays import positive_intervals, unit_gauss
from kinematics.numerics.array_types import Array

# Nodes along a ray, along the thickness, and round a disc.
NODES, ACROSS, AROUND = 12, 3, 5


def section_moments(form: Array, axis: Array, count: int) -> Array:
    """Integrate ``[u; 1][u; 1]ᵀ`` over the part of the unit ball where a quadratic is positive.

    Args:
        form: symmetric matrix (4, 4) of the quadratic.
        axis: unit vector (3,) along which it is constant.
        count: about how many rays in space would be as many.

    Returns:
        The moments (4, 4).
    """
    rays = rays_to_rim(form, axis, count)
    intervals = positive_intervals(rays, form)
    (first, ends), (second, later) = intervals.roots
    between = intervals.at_end + later
    zero, one = np.zeros_like(first), np.ones_like(first)
    # One part at a time: in the difference of two long ones little would be left of a thin one.
    low, high = np.concatenate([zero, first, second]), np.concatenate([first, second, one])
    positive = np.concatenate([between + ends, between, intervals.at_end])
    counts = np.flatnonzero((positive > 0.0) & (low < high))
    ray = counts % first.size
    sides, parts = rays.sides[:, ray], _integrate_along(low[counts], high[counts])
    mass, linear, square, thick = rays.weights[ray] * parts
    moments = np.empty((4, 4))
    moments[:3, :3] = (square * sides) @ sides.T + thick.sum() * np.outer(axis, axis)
    moments[:3, 3] = moments[3, :3] = sides @ linear
    moments[3, 3] = mass.sum()
    return moments


def section_products(form: Array, axis: Array, count: int, basis: Array) -> Array:
    """Integrate products of polynomials over the surface where a quadratic vanishes.

    Args:
        form: symmetric matrix (4, 4) of the quadratic q.
        axis: unit vector (3,) along which it is constant.
        count: about how many rays in space would be as many.
        basis: symmetric matrices (n, 4, 4) of the polynomials f.

    Returns:
        ``∫_{q = 0} f_i f_j / |∇q| dS`` (n, n).
    """
    rays = rays_to_rim(form, axis, count)
    intervals = positive_intervals(rays, form)
    tau = np.concatenate([root for root, _ in intervals.roots])
    slopes = np.tile(intervals.slopes, 2)
    inside = np.flatnonzero((tau > 0.0) & (tau < 1.0) & (slopes > 0.0))
    ray, tau = inside % intervals.slopes.size, tau[inside]
    points = tau * rays.sides[:, ray]
    half = np.sqrt((1.0 - tau) * (1.0 + tau))
    weights = half * rays.weights[ray] * tau / slopes[inside]
    nodes, shares = unit_gauss(ACROSS)
    v = np.ones((4, ACROSS, tau.size))
    v[:3] = points[:, None] + axis[:, None, None] * ((2.0 * nodes - 1.0)[:, None] * half)
    first, second = np.triu_indices(4)
    monomials = (v[first] * v[second]).reshape(len(first), -1)
    squares = (np.outer(2.0 * shares, weights).reshape(-1) * monomials) @ monomials.T
    twice = np.where(first == second, 1.0, 2.0)
    values = basis[:, first, second] * twice
    return np.asarray(values @ squares @ values.T)


def disc_products(normal: Array, constant: float, basis: Array) -> Array:
    """Integrate products of polynomials over the disc of the unit ball where a plane cuts it.

    Args:
        normal: any vector (3,); the plane is ``normal·u + constant = 0``.
        constant: constant part.
        basis: symmetric matrices (n, 4, 4) of the polynomials f.

    Returns:
        ``∫ f_i f_j dS / |normal|`` (n, n); zero if the plane misses the ball.
    """
    size = float(np.linalg.norm(normal))
    if abs(constant) >= size:
        return np.zeros((len(basis), len(basis)))
    axis, height = normal / size, -constant / size
    # Of radius and angle polynomials of degree 4 are integrated exactly.
    squares, shares = unit_gauss(ACROSS)
    turn = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    ways = plane_across(axis) @ np.array([np.cos(turn), np.sin(turn)])
    area = np.pi * (1.0 - height) * (1.0 + height)
    radii = np.sqrt((1.0 - height) * (1.0 + height) * squares)
    points = height * axis + (radii[:, None, None] * ways.T).reshape(-1, 3)
    weights = area / size * np.repeat(shares / AROUND, AROUND)
    v = np.column_stack([points, np.ones(len(points))])
    values = (v[:, :, None] * v[:, None, :]).reshape(-1, 16) @ basis.reshape(len(basis), 16).T
    return np.asarray((weights * values.T) @ values)


def _integrate_along(low: Array, high: Array) -> Array:
    """Integrate 2 τ h, 2 τ² h, 2 τ³ h and 2/3 τ h³ from τ = low (n,) to high (n,): (4, n)."""
    nodes, shares = unit_gauss(NODES)
    start, end = np.arccos(high), np.arccos(low)
    phi = start + nodes[:, None] * (end - start)
    x, square = np.cos(phi), np.sin(phi) ** 2
    part = x * square
    sums = np.empty((4, low.size))
    sums[3] = shares @ (part * square) / 3.0
    for power in range(3):
        sums[power] = shares @ part
        part *= x
    return np.asarray(sums * (2.0 * (end - start)))
