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

from balance.motion.motion_tolerances import LOCAL_CURVE_RESIDUAL, LOCAL_CURVE_STEP
from balance.motion.paths.branches import null_basis
from balance.motion.paths.rest_equations import RestEquations, RowsAtPose
from kinematics.errors import PoseError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.gauss_newton import Iterate, LeastNorm, gauss_newton, step_grows

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


class LocalArc:
    """A local curve in terms of the arc length in all joints."""

    def __init__(self, equations: RestEquations, curve: LocalCurve) -> None:
        """Integrate the speed of the joints as a Chebyshev series in the advance."""
        self.equations, self.curve = equations, curve
        sigma = _nodes() * curve.advance
        poses, slopes = _poses(equations, curve, sigma), curve.coordinates(sigma)[1]
        speeds = [
            float(np.linalg.norm(here.rates @ slope))
            for here, slope in zip(poses, slopes, strict=True)
        ]
        self._speed = chebyshev.chebfit(sigma / curve.advance, speeds, POINTS - 1)
        self._length = chebyshev.chebint(self._speed, lbnd=0.0, scl=curve.advance)

    @property
    def extent(self) -> tuple[float, float]:
        """Arc lengths of its two ends, below and above 0."""
        first, last = chebyshev.chebval(np.array([-1.0, 1.0]), self._length)
        return float(first), float(last)

    def length_at(self, sigma: float) -> float:
        """Compute the arc length at an advance along the tangent, with its sign."""
        return float(chebyshev.chebval(sigma / self.curve.advance, self._length))

    def ends(self) -> tuple[list[tuple[Array, Array, float]], int]:
        """Compute positions, tangent away from the middle, and arc length, at both ends.

        Returns:
            Those of the end ahead and of the end behind; and the least dimension of the null
            space there.
        """
        ends, dimension = [], len(self.curve.v)
        for sign, length in zip((1.0, -1.0), reversed(self.extent), strict=True):
            sigma = np.array([sign * self.curve.advance])
            here = _poses(self.equations, self.curve, sigma)[0]
            slope = sign * self.curve.coordinates(sigma)[1][0]
            ends.append((here.q, slope / np.linalg.norm(slope), abs(length)))
            dimension = min(dimension, null_basis(here)[0].shape[1])
        return ends, max(1, dimension)

    def positions(self, s: Array) -> Array:
        """Compute closed joint positions (N, n) at arc lengths that rise."""
        first, last = self.extent
        x = 2.0 * (s - first) / (last - first) - 1.0
        for _ in range(8):  # Newton's method on s(σ)
            error = chebyshev.chebval(x, self._length) - s
            x = x - error / (self.curve.advance * chebyshev.chebval(x, self._speed))
        sigma = x * self.curve.advance
        order = np.concatenate([np.flatnonzero(sigma >= 0), np.flatnonzero(sigma < 0)[::-1]])
        positions = np.empty((s.size, self.curve.start.q.size))
        positions[order] = [here.q for here in _poses(self.equations, self.curve, sigma[order])]
        return positions


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
            curve = _solve(equations, start, v, advance)
        except PoseError:
            continue
        if curve is not None:
            return curve
    return None


def _solve(
    equations: RestEquations, start: RowsAtPose, v: Array, advance: float
) -> LocalCurve | None:
    """Solve for the coefficients at one length of the branch."""
    aside = np.linalg.svd(v[None])[2][1:].T  # directions perpendicular to v (w, w - 1)
    sigma = _nodes() * advance
    basis, slopes = _monomials(sigma, advance)

    def curve(x: Array) -> LocalCurve:
        return LocalCurve(start, v, x.reshape(TERMS, -1) @ aside.T, advance)

    def system(x: Array) -> tuple[Array, Array]:
        branch = curve(x)
        _, rate = branch.coordinates(sigma)
        rows, slope = [], []
        for k, here in enumerate(_poses(equations, branch, sigma)):
            weight = 1.0 / (sigma[k] * here.scale)
            rows.append(weight * (here.rows @ rate[k]))
            turn = np.einsum("ria,a->ri", equations.derivative(here.q), rate[k]) @ aside
            change = here.rows @ aside
            both = turn[:, None] * basis[k][:, None] + change[:, None] * slopes[k][:, None]
            slope.append(weight * both.reshape(len(rows[-1]), -1))
        return np.concatenate(rows), np.concatenate(slope)

    def solved(path: Sequence[Iterate]) -> bool:
        return bool(
            path[-1].error <= LOCAL_CURVE_RESIDUAL and path[-1].size <= LOCAL_CURVE_STEP
        )

    solution = gauss_newton(
        system,
        np.zeros(TERMS * aside.shape[1]),
        LeastNorm(1e-12, 1.0 / advance),
        solved,
        step_grows(1e3, LOCAL_CURVE_STEP),
        EVALUATIONS,
    )
    return curve(solution.last.x) if solution.last.error <= LOCAL_CURVE_RESIDUAL else None


def _nodes() -> Array:
    """List the zeros of a Chebyshev polynomial, outwards on one side and then the other."""
    x = np.cos((2 * np.arange(POINTS) + 1) * np.pi / (2 * POINTS))
    return np.concatenate([np.sort(x[x > 0.0]), np.sort(x[x < 0.0])[::-1]])


def _monomials(sigma: Array, advance: float) -> tuple[Array, Array]:
    """Compute ``σ² T_k`` and its slope at all points (points, terms)."""
    x, s = sigma / advance, sigma[:, None]
    T = chebyshev.chebvander(x, TERMS - 1)
    der = np.array([chebyshev.chebval(x, chebyshev.chebder(e)) for e in np.eye(TERMS)]).T
    return s**2 * T, 2.0 * s * T + s**2 * der / advance


def _poses(equations: RestEquations, curve: LocalCurve, sigma: Array) -> list[RowsAtPose]:
    """Compute the equations at points of the curve, from the pose outwards on both sides."""
    y = curve.coordinates(sigma)[0]
    here, before, poses = curve.start, np.zeros_like(curve.v), []
    for k in range(len(sigma)):
        if k and sigma[k] * sigma[k - 1] < 0.0:
            here, before = curve.start, np.zeros_like(curve.v)
        here = equations.at(equations.move(here, y[k] - before))
        before = y[k]
        poses.append(here)
    return poses
