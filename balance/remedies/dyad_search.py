"""Search for the geometry of a dyad with which a planar linkage is balanced by buildable masses.

Geometries with such masses are special: none is hit by sampling. They are the zeros of

    φ(g) = min_z |X(g) z|²    over masses with P_b(z) ⪰ 1 for every body b,

the residual of the best buildable masses, where the rows of X are the terms of the momentum
along rays, each order times the power ρ^k of the radius of convergence ρ. Unlike the margin of
the cone program, which is 0 wherever nothing is buildable, φ has a gradient there. With the best
masses z it is ``2 (X z)ᵀ (∂X/∂g) z``, for the masses need not be differentiated (envelope
theorem). In a plane, ``P_b ⪰ 1`` holds exactly for

    m = 1 + a²,   mc = a f,   E = 1 + |f|² + b²

with numbers a and b and a vector f, so that g and z are found together, by least squares with
the residuals X(g) z and no constraint (Levenberg and Marquardt). Two more residuals keep the
lengths of the dyad within bounds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from balance.momentum.regressor import RegressorSeries
from balance.remedies.dyad_geometry import Dyad, dyad_screws, segments_of
from balance.spaces.condition_gradients import ConditionGradients
from balance.spaces.distance_to_rank_drop import spanning_rays
from kinematics.closure.newton import radius_of_convergence
from kinematics.closure.series import expand
from kinematics.model.arrays import Chain

__all__ = ["DyadConditions", "DyadWalk", "buildable_masses", "walk"]

Array = NDArray[np.float64]

# Order of the momentum series.
ORDER = 10
# Bounds of the links of a dyad, in characteristic lengths.
SHORTEST, LONGEST = 0.1, 5.0
# Weight of a length out of bounds.
LENGTH_WEIGHT = 3.0
# Step of central differences, in characteristic lengths and radians.
STEP = 1e-6
# Most evaluations of one walk, and residual |X z|² / |z|² at which masses balance a geometry.
EVALUATIONS, BALANCED = 150, 1e-22


@dataclass(frozen=True, eq=False)
class DyadConditions:
    """The conditions on the masses of a linkage with a dyad, as they depend on its geometry.

    Attributes:
        chain: the linkage with the dyad; its geometry is one to begin with.
        dyad: the dyad.
        joints: the joints of the dyad in the chain (3,).
        scale: radius of convergence, by whose powers orders are multiplied.
    """

    chain: Chain
    dyad: Dyad
    joints: NDArray[np.int64]
    scale: float = 1.0

    @cached_property
    def rays(self) -> Array:
        """Directions of the motion (rays, w)."""
        width, unknowns = self.chain.width, 4 * self.chain.links.size
        return spanning_rays(width, ORDER, 2 - (-unknowns // (3 * width)) if width > 1 else 1)

    @cached_property
    def weights(self) -> Array:
        """Weights of the orders."""
        return np.asarray(self.scale ** np.arange(ORDER + 1.0))

    def place(self, numbers: Array) -> Chain:
        """Return the chain with another geometry of the dyad.

        Args:
            numbers: the numbers of the dyad.
        """
        screws = self.chain.screws.copy()
        screws[self.joints] = dyad_screws(self.dyad, numbers)
        return replace(self.chain, screws=screws)

    def matrix(self, numbers: Array) -> Array:
        """Compute the conditions X (rows, 4 bodies) at a geometry of the dyad.

        Args:
            numbers: the numbers of the dyad.
        """
        chain = self.place(numbers)
        series = expand(chain, self.rays, ORDER)
        X = RegressorSeries(chain, series, False).rows(ORDER)
        X *= self.weights.reshape(-1, 1, 1, 1, 1)
        return np.asarray(X.reshape(-1, 4 * chain.links.size))

    def with_scale(self, numbers: Array) -> DyadConditions:
        """Return the conditions with the radius of convergence at a geometry.

        Args:
            numbers: the numbers of the dyad.
        """
        series = expand(self.place(numbers), self.rays, ORDER)
        return replace(self, scale=radius_of_convergence(series.C[0] @ self.rays[0]))

    def gradient(self, numbers: Array, z: Array) -> Array:
        """Differentiate the residual |X z|² of fixed masses, by the chain rule.

        At the masses that are best for a geometry, this is the gradient of the residual of the
        best masses (envelope theorem).

        Args:
            numbers: the numbers of the dyad.
            z: parameters of the bodies (4 bodies,).

        Returns:
            Derivatives with respect to the numbers.
        """
        chain = self.place(numbers)
        series = expand(chain, self.rays, ORDER)
        X = RegressorSeries(chain, series, False).rows(ORDER)
        weights = np.einsum("krwiq,q,k->krwi", X, z, 2.0 * self.weights**2)
        slopes = ConditionGradients(chain, self.rays, series, False)
        bar = slopes.of_momentum(weights, z.reshape(-1, 4))[self.joints]
        turned = np.array([
            (dyad_screws(self.dyad, numbers + step) - dyad_screws(self.dyad, numbers - step))
            for step in STEP * np.eye(numbers.size)
        ]) / (2.0 * STEP)  # fmt: skip
        return np.einsum("gnd,nd->g", turned, bar)


@dataclass(frozen=True, eq=False)
class DyadWalk:
    """Where a walk ended.

    Attributes:
        numbers: the numbers of the dyad.
        z: the best buildable masses, parameters of the bodies (4 bodies,), chain units.
        residual: |X z|² / |z|².
    """

    numbers: Array
    z: Array
    residual: float

    @property
    def balanced(self) -> bool:
        """Whether the masses balance the linkage with the dyad, to round-off."""
        return self.residual <= BALANCED


def buildable_masses(u: Array) -> tuple[Array, Array]:
    """Compute masses with ``P_b ⪰ 1`` for every body from free numbers.

    Args:
        u: a, f_x, f_y, b of each body (4 bodies,).

    Returns:
        ``[m, mc_x, mc_y, E]`` of each body (4 bodies,), and its Jacobian.
    """
    a, fx, fy, b = u.reshape(-1, 4).T
    z = np.stack([1.0 + a * a, a * fx, a * fy, 1.0 + fx * fx + fy * fy + b * b], axis=1)
    none = np.zeros_like(a)
    rows = (
        [2.0 * a, none, none, none], [fx, a, none, none], [fy, none, a, none],
        [none, 2.0 * fx, 2.0 * fy, 2.0 * b],
    )  # fmt: skip
    blocks = np.array(rows).transpose(2, 0, 1)
    count = len(blocks)
    J = np.zeros((count, 4, count, 4))
    J[np.arange(count), :, np.arange(count)] = blocks
    return z.ravel(), J.reshape(4 * count, 4 * count)


def walk(conditions: DyadConditions, numbers: Array, u: Array) -> DyadWalk:
    """Walk to a geometry and masses that are balanced, or as nearly so as lies on the way.

    Args:
        conditions: the conditions.
        numbers: the numbers of the dyad to begin with.
        u: free numbers of the masses to begin with, see `buildable_masses`.

    Returns:
        Where the walk ended.

    Raises:
        numpy.linalg.LinAlgError: the geometry to begin with is singular.
    """
    from scipy.optimize import least_squares

    here = conditions.with_scale(numbers)
    size = numbers.size
    found = least_squares(
        lambda x: _residuals(here, x[:size], x[size:]), np.concatenate([numbers, u]),
        lambda x: _jacobian(here, x[:size], x[size:]), method="lm", xtol=1e-15, ftol=1e-15,
        gtol=1e-15, max_nfev=EVALUATIONS,
    )  # fmt: skip
    numbers, z = found.x[:size], buildable_masses(found.x[size:])[0]
    away = here.matrix(numbers) @ z
    bounds = _lengths_out_of_bounds(here.dyad, numbers)
    residual = float((away @ away + bounds @ bounds) / (z @ z))
    return DyadWalk(numbers, z, residual)


def _residuals(conditions: DyadConditions, numbers: Array, u: Array) -> Array:
    """Compute X z and how far lengths are out of bounds."""
    z, _ = buildable_masses(u)
    rows = conditions.matrix(numbers) @ z
    out = np.concatenate([rows, _lengths_out_of_bounds(conditions.dyad, numbers)])
    # Geometries at which the loops cannot be solved are far from any solution.
    return np.nan_to_num(out, nan=1e6, posinf=1e6, neginf=-1e6)


def _jacobian(conditions: DyadConditions, numbers: Array, u: Array) -> Array:
    """Differentiate the residuals: by central differences in the numbers of the dyad."""
    z, J = buildable_masses(u)
    slopes = [
        (_at(conditions, numbers + step, z) - _at(conditions, numbers - step, z)) / (2.0 * STEP)
        for step in STEP * np.eye(numbers.size)
    ]
    masses = conditions.matrix(numbers) @ J
    lengths = np.zeros((len(slopes[0]) - len(masses), u.size))
    out = np.column_stack([np.array(slopes).T, np.vstack([masses, lengths])])
    return np.nan_to_num(out, nan=0.0, posinf=0.0, neginf=0.0)


def _at(conditions: DyadConditions, numbers: Array, z: Array) -> Array:
    """Compute the residuals for given masses."""
    bounds = _lengths_out_of_bounds(conditions.dyad, numbers)
    return np.concatenate([conditions.matrix(numbers) @ z, bounds])


def _lengths_out_of_bounds(dyad: Dyad, numbers: Array) -> Array:
    """Compute how far each link of a dyad is too short or too long."""
    lengths = segments_of(dyad, numbers)
    over = np.maximum(lengths - LONGEST, 0.0) + np.maximum(SHORTEST - lengths, 0.0)
    return np.asarray(LENGTH_WEIGHT * over)
