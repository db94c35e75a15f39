"""The global minimum of a quadratic polynomial ``[u; 1]ᵀ M [u; 1]`` over a region.

The polynomial need not be convex. The minimum is found exactly for each shape:

- ball and ellipsoid: the trust-region subproblem. The minimiser solves
  ``(A + λ 1) u = -b`` with ``A + λ 1 ⪰ 0`` and ``λ (|u| - 1) = 0`` for one λ ≥ 0
  (J. J. Moré, D. C. Sorensen, SIAM Journal on Scientific and Statistical Computing 4, 1983).
- box and hull: a minimiser lies inside the interior, a facet, an edge or at a corner, and is
  stationary there. On a face where the polynomial is not strictly convex it is also attained
  on the border of the face. So the stationary points of strictly convex faces and the corners
  contain a minimiser.
- cylinder: where the polynomial is not strictly convex along the axis, a minimiser lies at an
  end. Otherwise the axial coordinate is eliminated, which leaves a polynomial on the disc:
  its stationary points are that of the interior and, on the circle, the roots of a polynomial
  of degree four.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.counterweights.regions import Region
from balance.support.tolerances import CURVATURE_ZERO, STATIONARY_INSIDE
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least

# Most steps for the multiplier: enough for every bit of a double by bisection alone.
BISECTIONS = 120
# Part of the largest entry of an axis from which an entry sets its sign.
FIRST_OF_LARGEST = 0.9


def minimise_in_region(region: Region, form: ArrayLike) -> tuple[float, Array]:
    """Minimise a quadratic polynomial over a region.

    Args:
        form: symmetric matrix M (4, 4) in its unit coordinates.

    Returns:
        The minimum and a minimiser (3,) in unit coordinates.
    """
    M = np.asarray(form, dtype=np.float64)
    if region.ellipsoidal:
        return _minimise_in_ball(M)
    if region.kind == "cylinder":
        points = _cylinder_candidates(M)
    else:
        points = _face_candidates(region, M)
    points = points[region.excess(points) <= STATIONARY_INSIDE]
    p = np.column_stack([points, np.ones(len(points))])
    values = np.einsum("ni,ij,nj->n", p, M, p)
    return float(values.min()), points[first_least(values, float(np.abs(M).max()))]


def least_values(regions: Sequence[Region], forms: Array) -> Array:
    """Compute the minima (n,) of quadratic polynomials, each over its region.

    Args:
        forms: symmetric matrices (n, 4, 4) in their unit coordinates.
    """
    minima = np.zeros(len(regions))
    round_ones = [k for k, region in enumerate(regions) if region.ellipsoidal]
    if round_ones:
        minima[round_ones] = _minimise_in_balls(forms[round_ones])[0]
    for k, region in enumerate(regions):
        if not region.ellipsoidal:
            minima[k] = minimise_in_region(region, forms[k])[0]
    return minima


def _minimise_in_ball(form: ArrayLike) -> tuple[float, Array]:
    """Minimise ``[u; 1]ᵀ M [u; 1]`` over ``|u| ≤ 1``, in any dimension.

    Args:
        form: symmetric matrix M (d + 1, d + 1).

    Returns:
        The minimum and a minimiser (d,).
    """
    values, points = _minimise_in_balls(np.asarray(form, dtype=np.float64)[None])
    return float(values[0]), points[0]


def _minimise_in_balls(M: Array) -> tuple[Array, Array]:
    """Minimise forms (n, d + 1, d + 1) over the unit ball: minima (n,), minimisers (n, d)."""
    scales = np.abs(M).max(axis=(1, 2))
    # A power of two, which changes no digit: squares of a form of any size are numbers.
    powers = -np.frexp(scales)[1][:, None, None]
    forms = np.ldexp(M, powers)
    w, V = np.linalg.eigh(forms[:, :-1, :-1])
    # Of two equal minima one is chosen by the sign of an axis, which is that of its first entry
    # of about the largest size.
    sizes = np.abs(V)
    firsts = np.argmax(sizes >= FIRST_OF_LARGEST * sizes.max(axis=1, keepdims=True), axis=1)
    V = V * np.sign(np.take_along_axis(V, firsts[:, None], axis=1))
    beta = (forms[:, None, -1, :-1] @ V)[:, 0]
    zeros = CURVATURE_ZERO * np.where(scales > 0.0, np.ldexp(scales, powers[:, 0, 0]), 1.0)
    x = list(map(_secular_solution, w.tolist(), beta.tolist(), zeros.tolist()))
    points = (V @ np.array(x)[:, :, None])[:, :, 0]
    p = np.column_stack([points, np.ones(len(points))])
    return (p[:, None] @ M @ p[:, :, None])[:, 0, 0], points


def _secular_solution(w: list[float], beta: list[float], zero: float) -> list[float]:
    """Solve the trust-region subproblem in the axes of the form, with eigenvalues w."""
    if w[0] > zero:
        inside = [-b / value for value, b in zip(w, beta, strict=True)]
        if sum(x * x for x in inside) <= 1.0:
            return inside
    low = max(0.0, -w[0])
    pairs = [(value + low, b) for value, b in zip(w, beta, strict=True)]
    if math.hypot(*(b for value, b in pairs if value <= zero)) <= zero:
        # The hard case: the multiplier is -w_0, and an eigenvector fills up the norm.
        x = [0.0 if value <= zero else -b / value for value, b in pairs]
        if (size := sum(value * value for value in x)) <= 1.0:
            x[0] = math.sqrt(1.0 - size) if low > 0.0 else 0.0
            return x
    multiplier = _multiplier(w, [b * b for b in beta], low, zero)
    x = [-b / (value + multiplier) for value, b in zip(w, beta, strict=True)]
    size = math.hypot(*x)
    return [value / size for value in x]


def _multiplier(w: list[float], squares: list[float], low: float, zero: float) -> float:
    """Solve ``Σ squares_i / (w_i + λ)² = 1`` for λ above ``low``."""
    high = low + math.sqrt(sum(squares)) + zero
    multiplier, pairs = high, list(zip(w, squares, strict=True))
    for _ in range(BISECTIONS):
        # Newton's method for 1 / |x| = 1, within the bracket.
        square = slope = 0.0
        for value, part in pairs:
            shifted = value + multiplier
            term = part / (shifted * shifted)
            square, slope = square + term, slope + term / shifted
        low, high = (multiplier, high) if square > 1.0 else (low, multiplier)
        step = (square / slope) * (math.sqrt(square) - 1.0)
        if abs(step) <= CURVATURE_ZERO * (multiplier + abs(w[0])):
            break
        following = multiplier + step
        multiplier = following if low < following < high else 0.5 * (low + high)
    return multiplier


def _face_candidates(region: Region, M: Array) -> Array:
    """List stationary points of the faces of a polytope on which the form is convex."""
    v, facets = region.vertices, region.triangles
    edges = {tuple(sorted((int(f[i]), int(f[i - 1])))) for f in facets for i in range(3)}
    ends = v[np.array(sorted(edges))]
    candidates = [v, _stationary(M, ends[:, 0], (ends[:, 1] - ends[:, 0])[:, None])]
    sides = v[facets]
    candidates.append(_stationary(M, sides[:, 0], sides[:, 1:] - sides[:, :1]))
    candidates.append(_stationary(M, np.zeros((1, 3)), np.eye(3)[None]))
    return np.concatenate(candidates)


def _stationary(M: Array, origins: Array, directions: Array) -> Array:
    """Compute stationary points (n, 3) of strictly convex restrictions to flats.

    Args:
        M: the form (4, 4).
        origins: a point of each flat (n, 3).
        directions: directions that span it (n, k, 3).
    """
    A = directions @ M[:3, :3] @ directions.swapaxes(-1, -2)
    gradient = (origins @ M[:3, :3] + M[:3, 3])[:, None] @ directions.swapaxes(-1, -2)
    scale = np.abs(M).max() or 1.0
    convex = np.linalg.eigvalsh(A)[:, 0] > CURVATURE_ZERO * scale
    if not convex.any():
        return np.empty((0, 3))
    A, b, D = A[convex], gradient[convex].swapaxes(-1, -2), directions[convex]
    steps = np.linalg.solve(A, -b)[..., 0]
    return np.asarray(origins[convex] + np.einsum("nk,nkj->nj", steps, D))


def _cylinder_candidates(M: Array) -> Array:
    """List points of a cylinder that contain a minimiser."""
    candidates = []
    for end in (-1.0, 1.0):
        T = np.zeros((4, 3))
        T[[0, 1, 3], [0, 1, 2]], T[2, 2] = 1.0, end
        candidates.append([*_minimise_in_ball(T.T @ M @ T)[1], end])
    scale = float(np.abs(M).max()) or 1.0
    if M[2, 2] > CURVATURE_ZERO * scale:
        # u_3 = -(c·u + d) / M33 on stationary lines; the rest is a form on the disc.
        slope = -M[2, [0, 1, 3]] / M[2, 2]
        T = np.zeros((4, 3))
        T[[0, 1, 3], [0, 1, 2]], T[2] = 1.0, slope
        flat = T.T @ M @ T
        points = [*_stationary_on_circle(flat), _minimise_in_ball(flat)[1]]
        candidates += [[*u, slope[:2] @ u + slope[2]] for u in points]
    return np.array(candidates)


def _stationary_on_circle(N: Array) -> list[Array]:
    """Compute the stationary points (2,) of ``[u; 1]ᵀ N [u; 1]`` on the unit circle.

    With ``u = (cos t, sin t)`` and ``s = e^{it}``, the derivative times s² is a polynomial of
    degree four in s.
    """
    # f(t) = a cos 2t + b sin 2t + c cos t + d sin t + constant
    a, b = 0.5 * (N[0, 0] - N[1, 1]), N[0, 1]
    c, d = 2.0 * N[0, 2], 2.0 * N[1, 2]
    # f'(t) = -2a sin 2t + 2b cos 2t - c sin t + d cos t
    coefficients = np.array(
        [b + 1j * a, 0.5 * (d + 1j * c), 0.0, 0.5 * (d - 1j * c), b - 1j * a]
    )
    if not np.abs(coefficients).max() > 0.0:
        return [np.array([1.0, 0.0])]
    angles = np.angle(np.roots(coefficients))
    return [np.array([np.cos(t), np.sin(t)]) for t in angles]
