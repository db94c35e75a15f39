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
    parts, zero = np.zeros((4, len(rays.weights))), np.zeros_like(rays.weights)
    # One part at a time: in the difference of two long ones little would be left of a thin one.
    for low, high, positive in (
        (zero, first, between + ends),
        (first, second, between),
        (second, zero + 1.0, intervals.at_end),
    ):
        counts = (positive > 0.0) & (low < high)
        if counts.any():
            parts[:, counts] += _integrate_along(low[counts], high[counts])
    mass, linear, square, thick = rays.weights * parts
    moments = np.empty((4, 4))
    moments[:3, :3] = (square * rays.sides) @ rays.sides.T + thick.sum() * np.outer(axis, axis)
    moments[:3, 3] = moments[3, :3] = rays.sides @ linear
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
    flat, total = basis.reshape(len(basis), 16).T, np.zeros((len(basis), len(basis)))
    nodes, shares = unit_gauss(ACROSS)
    for tau, _ in intervals.roots:
        inside = (tau > 0.0) & (tau < 1.0) & (intervals.slopes > 0.0)
        points = tau[inside, None] * rays.sides[:, inside].T
        half = np.sqrt((1.0 - tau[inside]) * (1.0 + tau[inside]))
        weights = rays.weights[inside] * tau[inside] / intervals.slopes[inside]
        for node, share in zip(nodes, shares, strict=True):
            v = np.ones((len(points), 4))
            v[:, :3] = points + ((2.0 * node - 1.0) * half)[:, None] * axis
            values = (v[:, :, None] * v[:, None, :]).reshape(-1, 16) @ flat
            total += (2.0 * share * half * weights * values.T) @ values
    return total


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
    start, end = np.arccos(high), np.arccos(low)
    nodes, shares = unit_gauss(NODES)
    phi = start + nodes[:, None] * (end - start)
    x, h = np.cos(phi), np.sin(phi)
    weights = 2.0 * shares[:, None] * (end - start) * x * h * h
    return np.stack(
        [
            each.sum(axis=0)
            for each in (weights, weights * x, weights * x * x, weights * h * h / 3.0)
        ]
    )
