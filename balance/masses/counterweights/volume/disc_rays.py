"""Rays from the middle of a unit disc to its rim, for the part where a quadratic is positive.

On the ray of direction ``d(θ)`` the quadratic is ``a τ² + 2 b τ + c``. An integral along it is
analytic in θ but where the quadratic vanishes at the rim, ``a + 2 b + c = 0``, and
where the ray touches the curve on which it vanishes, ``b² - a c = 0``: there it is a series of
powers of the root of the distance. Both are trigonometric polynomials of θ. The real parts of
all their roots divide the turn, and between two of them

    θ = θ_1 + (θ_2 - θ_1) x² (3 - 2 x),    0 < x < 1,

makes the integrand analytic in x up to both ends, and the formula of Gauss converges as fast
for a thin crescent at the rim as for a half disc.
"""

from __future__ import annotations

import numpy as np

from balance.masses.counterweights.volume.rays import Rays, unit_gauss
from balance.support.tolerances import CURVATURE_ZERO
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import cross_products

# Rays between two singular directions for the cube root of the number of rays in space.
PER_INTERVAL = 0.8


def rays_to_rim(form: Array, axis: Array, count: int) -> Rays:
    """Choose rays from the middle of the unit disc across an axis to its rim.

    Args:
        form: symmetric matrix (4, 4) of the quadratic.
        axis: unit vector (3,) along which it is constant.
        count: about how many rays in space would be as many.
    """
    plane = plane_across(axis)
    square, linear = plane.T @ form[:3, :3] @ plane, form[:3, 3] @ plane
    constant = float(form[3, 3])
    touched = np.outer(linear, linear) - constant * square
    turns = np.concatenate(
        [_roots(square, linear, constant), _roots(touched, np.zeros(2), 0.0)]
    )
    starts = np.sort(turns % (2.0 * np.pi)) if turns.size else np.zeros(1)
    widths = np.diff(np.append(starts, starts[0] + 2.0 * np.pi))
    x, shares = unit_gauss(int(np.ceil(PER_INTERVAL * np.cbrt(count))))
    turn = (starts[:, None] + widths[:, None] * (x * x * (3.0 - 2.0 * x))).reshape(-1)
    weights = widths[:, None] * (shares * 6.0 * x * (1.0 - x))
    ways = plane @ np.array([np.cos(turn), np.sin(turn)])
    return Rays(np.zeros(3), ways, weights.reshape(-1))


def plane_across(axis: Array) -> Array:
    """Compute two unit vectors, columns (3, 2), across a unit vector (3,) and each other."""
    least = int(np.argmin(np.abs(axis)))
    first = -axis[least] * axis
    first[least] += 1.0
    first /= np.sqrt(first @ first)
    return np.column_stack([first, cross_products(axis, first)])


def _roots(square: Array, linear: Array, constant: float) -> Array:
    """Compute the real parts of the roots θ of ``d·square d + 2 linear·d + constant``."""
    fourth = complex(square[0, 0] - square[1, 1], -2.0 * square[0, 1]) / 4.0
    third, second = complex(linear[0], -linear[1]), constant + 0.5 * np.trace(square)
    # With z = exp(iθ) it is a polynomial of z over z².
    powers = np.array([fourth, third, second, third.conjugate(), fourth.conjugate()])
    powers[np.abs(powers) <= CURVATURE_ZERO * np.abs(powers).max()] = 0.0
    return np.asarray(np.angle(np.roots(powers)), dtype=np.float64)
