"""Cranks that guide a tool through positions: circle points and their centres.

A crank from G on the base to w on the tool, in the frame of the tool, keeps its length R if

    |d_i|² + 2 Re(d̄_i e^(iθ_i) w) - 2 Re(d̄_i G) - 2 Re(e^(iθ_i) Ḡ w) + |w|² + |G|² - R² = 0

at every position d_i, θ_i. This is linear in the eight numbers ``λ (1, w, G, Ḡ w, κ)``. The
product of w and Ḡ is the fourth of them: two quadrics.

- Five positions leave a plane of them, in which two conics meet in up to four points.
- Four leave a curve, the circle-point curve: each line of the tool through its point, in
  directions of a grid, holds up to three of its points.
- For three positions w is chosen on a grid, and G is the centre of the circle through its
  places. For two, G is on the perpendicular bisector, on a grid too.

Source: L. Burmester, 1888; J. M. McCarthy, G. S. Soh, Geometric Design of Linkages, 2nd ed.,
2011, chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.motion.motion_tolerances import SYNTHESIS_SINGULAR
from balance.studies.synthesis.positions import Position, displacements, size_of
from kinematics.numerics.array_types import Array

ComplexArray = NDArray[np.complex128]

MOST_POSITIONS = 5
"""Most positions that a crank can meet."""
# Directions of lines of the tool through its point, for four positions.
DIRECTIONS = 180
# Places on the tool, in sizes of the positions, and directions: for three positions; half as
# many directions for two.
RADII, PLACES = (0.1, 0.25, 0.5, 0.9, 1.4, 2.2), 24
# Angles of cranks from the perpendicular bisector's foot, for two positions.
SIDES = np.linspace(-1.3, 1.3, 9)
# Steps of Newton's method, and what they may leave of a radius, over the size.
STEPS, LEFT = 6, 1e-11


class Cranks(NamedTuple):
    """Cranks that guide the tool, all at the first position.

    Attributes:
        fixed: G (n,), metres, inertial frame.
        moving: W (n,), metres, inertial frame.
    """

    fixed: ComplexArray
    moving: ComplexArray


def cranks_through(
    positions: Sequence[Position],
    *,
    fixed: complex | None = None,
    moving: complex | None = None,
) -> Cranks:
    """Find cranks that guide a tool through two to five positions.

    Args:
        positions: of the tool.
        fixed: pivot on the base, for two positions; metres, inertial frame.
        moving: or pivot on the tool, at the first position.

    Returns:
        All of them for five positions, those of a grid for fewer.
    """
    points = np.array([each.point for each in positions])
    centre, size = points.mean(), size_of(positions)
    if len(positions) < 4:
        cranks = _on_grid(positions, fixed, moving)
    else:
        flat = (points - centre) / size
        turns = np.exp(1j * np.array([each.angle for each in positions]))
        G, w = (_of_four if len(positions) == 4 else _of_five)(flat, turns)
        cranks = Cranks(centre + size * G, points[0] + turns[0] * size * w)
    return _settle(positions, cranks)


def _rows(points: ComplexArray, turns: ComplexArray) -> Array:
    """Build the linear equations (n, 8), in λ, λ w, λ G, λ Ḡ w, λ κ."""
    u, ones = points.conj() * turns, np.ones(len(points))
    return np.column_stack(
        [
            np.abs(points) ** 2,
            *(2.0 * u.real, -2.0 * u.imag),
            *(-2.0 * points.real, -2.0 * points.imag),
            *(-2.0 * turns.real, 2.0 * turns.imag),
            ones,
        ]
    )


def _null_space(rows: Array) -> Array:
    """Return an orthonormal basis (8, 8 - n) of what rows leave."""
    return np.asarray(np.linalg.svd(rows)[2][len(rows) :].T)


def _of_five(points: ComplexArray, turns: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Find the cranks of five positions: G and w, in units of the size."""
    return _meet_quadrics(_null_space(_rows(points, turns)))


def _of_four(points: ComplexArray, turns: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Find cranks of four positions, on lines of the tool through its point."""
    rows = _rows(points, turns)
    pairs = []
    for angle in np.pi * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS:
        line = np.zeros((1, 8))
        line[0, 1:3] = -np.sin(angle), np.cos(angle)
        pairs.append(_meet_quadrics(_null_space(np.vstack([rows, line]))))
    return np.concatenate([G for G, _ in pairs]), np.concatenate([w for _, w in pairs])


def _meet_quadrics(basis: Array) -> tuple[ComplexArray, ComplexArray]:
    """Find G and w in a space of dimension three (8, 3) where the products hold.

    With coordinates (x, y, 1) both quadrics are ``a y² + b(x) y + c(x)``; their resultant is of
    degree four in x.
    """
    conics = _quadrics(basis)
    x = np.cos(np.pi * (np.arange(9) + 0.5) / 9.0)
    (a, b, c), (p, q, r) = (_in_y(Q, x) for Q in conics)
    resultant = (a * r - c * p) ** 2 - (a * q - b * p) * (b * r - c * q)
    roots = np.polynomial.Polynomial.fit(x, resultant, 4, domain=[-1.0, 1.0]).roots()
    x = roots[np.abs(roots.imag) < 1e-5 * (1.0 + np.abs(roots))].real
    (a, b, c), (p, q, r) = (_in_y(Q, x) for Q in conics)
    with np.errstate(all="ignore"):
        y = -(a * r - c * p) / (a * q - b * p)
    v = basis @ np.stack([x, y, np.ones_like(x)])
    scale, w, G = v[0], v[1] + 1j * v[2], v[3] + 1j * v[4]
    proper = np.isfinite(y) & (np.abs(scale) > 1e-9 * np.linalg.norm(v, axis=0))
    return (G[proper] / scale[proper]), (w[proper] / scale[proper])


def _quadrics(basis: Array) -> tuple[Array, Array]:
    """Build both quadrics ``λ (λ Ḡ w) = (λ Ḡ) (λ w)`` in coordinates of a basis (3, 3)."""
    scale, wx, wy, gx, gy, px, py, _ = basis
    real = np.outer(scale, px) - np.outer(gx, wx) - np.outer(gy, wy)
    imaginary = np.outer(scale, py) - np.outer(gx, wy) + np.outer(gy, wx)
    return real + real.T, imaginary + imaginary.T


def _in_y(Q: Array, x: Array) -> tuple[Array, Array, Array]:
    """Coefficients of y², y and 1 of a conic at values of x."""
    return (
        np.full(x.shape, Q[1, 1]),
        2.0 * (Q[0, 1] * x + Q[1, 2]),
        Q[0, 0] * x**2 + 2.0 * Q[0, 2] * x + Q[2, 2],
    )


def _on_grid(
    positions: Sequence[Position], fixed: complex | None, moving: complex | None
) -> Cranks:
    """Choose cranks of two or three positions on a grid, or on a pivot that is given."""
    steps, size = displacements(positions), size_of(positions)
    if fixed is not None:
        # The inverse motion carries the base; both places of G are equally far from W.
        G = np.full(SIDES.shape, complex(fixed))
        back = (fixed - steps[0].shift) / steps[0].rotation
        return Cranks(G, _equally_far(G, np.full(SIDES.shape, back), SIDES, size))
    places = PLACES // 2 if len(steps) == 1 else PLACES
    ways = np.exp(2j * np.pi * np.arange(places) / places)
    W = positions[0].point + size * np.multiply.outer(RADII, ways).ravel()
    if moving is not None:
        W = np.array([complex(moving)])
    if len(steps) == 1:
        W, sides = (np.ravel(part) for part in np.broadcast_arrays(W[:, None], SIDES))
        return Cranks(_equally_far(W, steps[0].move(W), sides, size), W)
    ends = [step.move(W) for step in steps]
    return Cranks(_centre(W, *ends), W)


def _equally_far(
    first: ComplexArray, second: ComplexArray, sides: Array, size: float
) -> ComplexArray:
    """Place points on the perpendicular bisectors of pairs of points."""
    chord = second - first
    along = np.where(np.abs(chord) > SYNTHESIS_SINGULAR * size, chord / np.abs(chord), np.nan)
    return (
        0.5 * (first + second) + 1j * np.tan(sides) * (0.5 * np.abs(chord) + 0.2 * size) * along
    )


def _centre(a: ComplexArray, b: ComplexArray, c: ComplexArray) -> ComplexArray:
    """Compute the centres of circles through three points each; NaN or far if in line."""
    u, v = b - a, c - a
    area = (u.conj() * v).imag
    with np.errstate(all="ignore"):
        return np.asarray(a + 0.5j * (v * np.abs(u) ** 2 - u * np.abs(v) ** 2) / -area)


def _settle(positions: Sequence[Position], cranks: Cranks) -> Cranks:
    """Refine cranks by Newton's method, and keep those whose length is one at all positions."""
    steps, size = displacements(positions), size_of(positions)
    G, W = (part.copy() for part in cranks)
    turns = np.array([1.0, *(step.rotation for step in steps)])
    shifts = np.array([0.0, *(step.shift for step in steps)])
    kept = np.isfinite(G) & np.isfinite(W)
    for k in np.flatnonzero(kept):
        G[k], W[k], error = _newton(turns, shifts, complex(G[k]), complex(W[k]))
        kept[k] = error <= LEFT * (size + abs(W[k] - G[k]))
    return Cranks(G[kept], W[kept])


def _newton(
    turns: ComplexArray, shifts: ComplexArray, G: complex, W: complex
) -> tuple[complex, complex, float]:
    """Refine a crank by steps of least length; return it and what is left of its radius."""
    for _ in range(STEPS):
        arms = turns * W + shifts - G
        radii = np.abs(arms)
        if not radii.min() > 0.0:
            break
        units = arms.conj() / radii
        to_w = units * turns
        J = np.column_stack([-units.real, units.imag, to_w.real, -to_w.imag])
        step = np.linalg.lstsq(J[1:] - J[0], radii[0] - radii[1:], rcond=1e-12)[0]
        G, W = G + complex(*step[:2]), W + complex(*step[2:])
    radii = np.abs(turns * W + shifts - G)
    return G, W, float(np.abs(radii - radii[0]).max())
