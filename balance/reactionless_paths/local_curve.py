"""A path through a pose in which several meet: a polynomial that solves ``A(y) ẏ = 0``.

There the null space is too large to integrate. A branch with the tangent v is smooth, so it is

    y(σ) = σ v + σ² Σ_k c_k T_k(σ / δ),    c_k ⟂ v,    -δ ≤ σ ≤ δ

with Chebyshev polynomials T_k. The coefficients follow from ``A(y(σ)) y'(σ) / σ = 0`` at the
zeros of a Chebyshev polynomial of higher degree (collocation), by the Gauss-Newton method; σ is
the advance along v.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from balance.reactionless_paths.rest_equations import RestEquations, RowsAtPose
from balance.tolerances import LOCAL_CURVE_RESIDUAL, LOCAL_CURVE_STEP
from kinematics.errors import PoseError
from kinematics.linalg.gauss_newton import Iterate, LeastNorm, gauss_newton, step_grows

__all__ = ["LocalCurve", "solve_local_curve"]

Array = NDArray[np.float64]

# Advance to either side, radians and characteristic lengths; halved until the polynomial fits.
ADVANCES = (0.1, 0.05, 0.025, 0.0125)
# Coefficients of the polynomial, and points of collocation.
TERMS = 12
POINTS = 20
# Most evaluations of the Gauss-Newton method.
EVALUATIONS = 12


class LocalCurve(NamedTuple):
    """A branch near a pose.

    Attributes:
        start: the equations in the pose.
        v: unit tangent (w,).
        coefficients: Chebyshev coefficients c (terms, w).
        advance: δ, to either side.
    """

    start: RowsAtPose
    v: Array
    coefficients: Array
    advance: float

    def coordinates(self, sigma: Array) -> tuple[Array, Array]:
        """Compute displacements of the coordinates from the pose, and their slopes.

        Args:
            sigma: advances along v (N,).

        Returns:
            y (N, w) and y' (N, w).
        """
        x = sigma / self.advance
        c = chebyshev.chebval(x, self.coefficients).T
        slope = chebyshev.chebval(x, chebyshev.chebder(self.coefficients)).T / self.advance
        s = sigma[:, None]
        return s * self.v + s**2 * c, self.v + 2.0 * s * c + s**2 * slope

    def positions(self, equations: RestEquations, sigma: Array) -> Array:
        """Compute closed poses at advances that rise or fall from 0 (N, n)."""
        here, found = self.start, []
        before = np.zeros_like(self.v)
        for y in self.coordinates(sigma)[0]:
            here = equations.at(equations.move(here, y - before))
            before = y
            found.append(here.q)
        return np.array(found)


def solve_local_curve(
    equations: RestEquations, start: RowsAtPose, v: Array
) -> LocalCurve | None:
    """Find the branch with a given tangent.

    Args:
        equations: the equations of the linkage.
        start: the pose in which several paths meet.
        v: unit tangent (w,), a line of the tangent cone.

    Returns:
        The branch; None if no polynomial fits: no smooth path leaves along v.
    """
    for advance in ADVANCES:
        try:
            found = _solve(equations, start, v, advance)
        except PoseError:
            continue
        if found is not None:
            return found
    return None


def _solve(
    equations: RestEquations, start: RowsAtPose, v: Array, advance: float
) -> LocalCurve | None:
    """Solve for the coefficients at one length of the branch."""
    aside = np.linalg.svd(v[None])[2][1:].T  # directions perpendicular to v (w, w - 1)
    half = np.cos((2 * np.arange(POINTS) + 1) * np.pi / (2 * POINTS)) * advance
    sigma = np.concatenate([np.sort(half[half > 0]), -np.sort(-half[half < 0])])
    basis, slopes = _monomials(sigma, advance)

    def curve(x: Array) -> LocalCurve:
        return LocalCurve(start, v, x.reshape(TERMS, -1) @ aside.T, advance)

    def system(x: Array) -> tuple[Array, Array]:
        found = curve(x)
        _, rate = found.coordinates(sigma)
        rows, slope = [], []
        for k, here in enumerate(_poses(equations, found, sigma)):
            weight = 1.0 / (sigma[k] * here.scale)
            rows.append(weight * (here.rows @ rate[k]))
            turn = np.einsum("ria,a->ri", equations.derivative(here.q), rate[k]) @ aside
            change = here.rows @ aside
            both = turn[:, None] * basis[k][:, None] + change[:, None] * slopes[k][:, None]
            slope.append(weight * both.reshape(len(rows[-1]), -1))
        return np.concatenate(rows), np.concatenate(slope)

    def solved(path: Sequence[Iterate]) -> bool:
        return bool(path[-1].error <= LOCAL_CURVE_RESIDUAL and path[-1].size <= LOCAL_CURVE_STEP)

    found = gauss_newton(
        system, np.zeros(TERMS * aside.shape[1]), LeastNorm(1e-12, 1.0 / advance), solved,
        step_grows(1e3, LOCAL_CURVE_STEP), EVALUATIONS,
    )  # fmt: skip
    return curve(found.last.x) if found.last.error <= LOCAL_CURVE_RESIDUAL else None


def _monomials(sigma: Array, advance: float) -> tuple[Array, Array]:
    """Compute ``σ² T_k`` and its slope at all points (points, terms)."""
    x, s = sigma / advance, sigma[:, None]
    T = chebyshev.chebvander(x, TERMS - 1)
    der = np.array([chebyshev.chebval(x, chebyshev.chebder(e)) for e in np.eye(TERMS)]).T
    return s**2 * T, 2.0 * s * T + s**2 * der / advance


def _poses(equations: RestEquations, curve: LocalCurve, sigma: Array) -> list[RowsAtPose]:
    """Compute the equations at points of the curve, from the pose outwards on both sides."""
    y = curve.coordinates(sigma)[0]
    here, before, found = curve.start, np.zeros_like(curve.v), []
    for k in range(len(sigma)):
        if k and sigma[k] * sigma[k - 1] < 0.0:
            here, before = curve.start, np.zeros_like(curve.v)
        here = equations.at(equations.move(here, y[k] - before))
        before = y[k]
        found.append(here)
    return found
