"""Integrals over the part of a unit ball where a quadratic constant along an axis is positive.

Across the axis the part has a section in the unit disc, and its thickness over a point p of it
is 2 h with ``h² = 1 - |p|²``. On a ray ``p = o + τ d`` from a point o of the disc to its rim,

    h² = (1 - τ) (α + β τ),    α = 1 - |o|²,  β = |d|²,

and ``1 - τ = (α + β)/β sin² ψ`` makes of powers of τ and h trigonometric polynomials of ψ, for
which the formula of Gauss is exact to round-off. Only the sum over the rays is left, which have
equal angles: it is of one dimension, and far more accurate than one over rays in space.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from balance.masses.counterweights.volume.rays import Rays, positive_intervals, unit_gauss
from balance.support.tolerances import PART_ROUND_OFF
from kinematics.numerics.array_types import Array

# Rays of a section for one in space; nodes along a ray, along the thickness, and round a disc.
FEWER, NODES, ACROSS, AROUND = 20, 14, 3, 5


def section_moments(
    form: Array, axis: Array, count: int, origin: tuple[float, float, float]
) -> Array:
    """Integrate ``[u; 1][u; 1]ᵀ`` over the part of the unit ball where a quadratic is positive.

    Args:
        form: symmetric matrix (4, 4) of the quadratic.
        axis: unit vector (3,) along which it is constant.
        count: about how many rays in space would be as many.
        origin: point of the ball over which rays start.

    Returns:
        The moments (4, 4).
    """
    rays = _choose_rays(axis, count, origin)
    intervals = positive_intervals(rays, form)
    (first, ends), (second, later) = intervals.roots
    between = intervals.at_end + later
    alpha, beta = 1.0 - float(rays.origin @ rays.origin), (rays.sides**2).sum(axis=0)
    parts, zero = np.zeros((4, len(beta))), np.zeros_like(beta)
    # One part at a time: in the difference of two long ones little would be left of a thin one.
    for low, high, positive in (
        (zero, first, between + ends),
        (first, second, between),
        (second, zero + 1.0, intervals.at_end),
    ):
        counts = (positive > 0.0) & (low < high)
        parts[:, counts] += _integrate_along(low[counts], high[counts], alpha, beta[counts])
    mass, linear, square, thick = rays.weights * parts
    local = np.empty((4, 4))
    local[:3, :3] = (square * rays.sides) @ rays.sides.T + thick.sum() * np.outer(axis, axis)
    local[:3, 3] = local[3, :3] = rays.sides @ linear
    local[3, 3] = mass.sum()
    shift = np.eye(4)
    shift[:3, 3] = rays.origin
    return np.asarray(shift @ local @ shift.T)


def section_products(
    form: Array, axis: Array, count: int, origin: tuple[float, float, float], basis: Array
) -> Array:
    """Integrate products of polynomials over the surface where a quadratic vanishes.

    Args:
        form: symmetric matrix (4, 4) of the quadratic q.
        axis: unit vector (3,) along which it is constant.
        count: about how many rays in space would be as many.
        origin: point of the ball over which rays start.
        basis: symmetric matrices (n, 4, 4) of the polynomials f.

    Returns:
        ``∫_{q = 0} f_i f_j / |∇q| dS`` (n, n).
    """
    rays = _choose_rays(axis, count, origin)
    intervals = positive_intervals(rays, form)
    flat, total = basis.reshape(len(basis), 16).T, np.zeros((len(basis), len(basis)))
    nodes, shares = unit_gauss(ACROSS)
    for tau, _ in intervals.roots:
        inside = (tau > 0.0) & (tau < 1.0) & (intervals.slopes > 0.0)
        points = rays.origin + tau[inside, None] * rays.sides[:, inside].T
        half = np.sqrt(np.maximum(1.0 - (points**2).sum(axis=1), 0.0))
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
    ways = _choose_directions(axis.tobytes(), AROUND)
    area = np.pi * (1.0 - height) * (1.0 + height)
    radii = np.sqrt((1.0 - height) * (1.0 + height) * squares)
    points = height * axis + (radii[:, None, None] * ways.T).reshape(-1, 3)
    weights = area / size * np.repeat(shares / AROUND, AROUND)
    v = np.column_stack([points, np.ones(len(points))])
    values = (v[:, :, None] * v[:, None, :]).reshape(-1, 16) @ basis.reshape(len(basis), 16).T
    return np.asarray((weights * values.T) @ values)


def _choose_rays(axis: Array, count: int, origin: tuple[float, float, float]) -> Rays:
    """Choose rays from a point of the disc across an axis to its rim."""
    o = np.array(origin)
    o = o - float(axis @ o) * axis
    ways = _choose_directions(axis.tobytes(), max(3, count // FEWER))
    along = o @ ways
    lengths = np.sqrt(along**2 + (1.0 - float(o @ o))) - along
    lengths = np.maximum(lengths, PART_ROUND_OFF)
    return Rays(o, lengths * ways, lengths**2 * (2.0 * np.pi / ways.shape[1]))


@lru_cache(maxsize=32)
def _choose_directions(axis: bytes, n: int) -> Array:
    """Choose n unit vectors (3, n) across an axis."""
    z = np.frombuffer(axis)
    e1 = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    e1 /= np.linalg.norm(e1)
    turn = (np.arange(n) + 0.5) * (2.0 * np.pi / n)
    return np.outer(e1, np.cos(turn)) + np.outer(np.cross(z, e1), np.sin(turn))


def _integrate_along(low: Array, high: Array, alpha: float, beta: Array) -> Array:
    """Integrate 2 τ h, 2 τ² h, 2 τ³ h and 2/3 τ h³ from τ = low (n,) to high (n,): (4, n)."""
    stretch = (alpha + beta) / beta
    nodes, shares = unit_gauss(NODES)
    start, end = (
        np.arcsin(np.sqrt(np.minimum((1.0 - tau) / stretch, 1.0))) for tau in (high, low)
    )
    psi = start + nodes[:, None] * (end - start)
    sine = np.sin(psi)
    cosine = np.sqrt(1.0 - sine * sine)
    x = 1.0 - stretch * sine**2
    h = (alpha + beta) / np.sqrt(beta) * sine * cosine
    weights = shares[:, None] * (end - start) * (4.0 * stretch * sine * cosine) * h * x
    return np.stack(
        [
            each.sum(axis=0)
            for each in (weights, weights * x, weights * x * x, weights * h * h / 3.0)
        ]
    )
