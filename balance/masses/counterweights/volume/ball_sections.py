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
    zero, one = np.zeros_like(first), np.ones_like(first)
    # One part at a time: in the difference of two long ones little would be left of a thin one.
    low, high = np.concatenate([zero, first, second]), np.concatenate([first, second, one])
    positive = np.concatenate([between + ends, between, intervals.at_end])
    counts = np.flatnonzero((positive > 0.0) & (low < high))
    ray = counts % first.size
    alpha, sides = 1.0 - float(rays.origin @ rays.origin), rays.sides[:, ray]
    parts = _integrate_along(low[counts], high[counts], alpha, (sides**2).sum(axis=0))
    mass, linear, square, thick = rays.weights[ray] * parts
    local = np.empty((4, 4))
    local[:3, :3] = (square * sides) @ sides.T + thick.sum() * np.outer(axis, axis)
    local[:3, 3] = local[3, :3] = sides @ linear
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
    tau = np.concatenate([root for root, _ in intervals.roots])
    slopes = np.tile(intervals.slopes, 2)
    inside = np.flatnonzero((tau > 0.0) & (tau < 1.0) & (slopes > 0.0))
    ray, tau = inside % intervals.slopes.size, tau[inside]
    points = rays.origin[:, None] + tau * rays.sides[:, ray]
    half = np.sqrt(np.maximum(1.0 - (points**2).sum(axis=0), 0.0))
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
    total = alpha + beta
    stretch = total / beta
    nodes, shares = unit_gauss(NODES)
    start, end = (
        np.arcsin(np.sqrt(np.minimum((1.0 - tau) / stretch, 1.0))) for tau in (high, low)
    )
    width = end - start
    square = np.sin(start + nodes[:, None] * width) ** 2
    # h² is ``total * stretch * flat``: what is one number on a ray multiplies its sums.
    flat = square * (1.0 - square)
    x = 1.0 - stretch * square
    part = flat * x
    sums = np.empty((4, beta.size))
    sums[3] = shares @ (part * flat) * (total * stretch / 3.0)
    for power in range(3):
        sums[power] = shares @ part
        part *= x
    return np.asarray(sums * (4.0 * stretch * total / np.sqrt(beta) * width))
