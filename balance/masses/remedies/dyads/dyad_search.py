"""Search for geometries of a dyad at which the angles of the links are related.

Geometries with a relation Σ J_b ω_b = 0 between the angular rates of the bodies, at every
pose, are special: none is hit by sampling. They are the zeros of the smallest singular value σ
of the matrix Ω(g) whose rows are the angular rates of all bodies along rays, order by order,
each order times the power ρ^k of the radius of convergence ρ. With its right singular vector J,

    σ² = min_J |Ω(g) J|²,  |J| = 1,        ∂(σ²)/∂g = 2 (Ω J)ᵀ (∂Ω/∂g) J,

for J need not be differentiated (envelope theorem). A walk goes down this gradient; g and J are
found together by least squares (Levenberg and Marquardt), which doubles the correct digits at
each step near a zero. Unlike the margin of the cone program, which is 0 wherever nothing is
buildable, σ has a gradient everywhere. Whether masses can be built is then decided exactly.

Ω J is the angular momentum of bodies whose only parameters are moments of inertia J, which have
no linear momentum: its rows and their gradient come from the regressor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from balance.masses.remedies.dyads.dyad_geometry import Dyad, dyad_screws, segments_of
from balance.space.momentum.regressor import RegressorSeries
from balance.space.spaces.condition_gradients import ConditionGradients
from balance.space.spaces.distance_to_rank_drop import spanning_rays
from kinematics.closure.series import Series, expand
from kinematics.model.arrays import Chain, read_only
from kinematics.numerics.array_types import Array, IntArray

# Order of the series of the angular rates.
ORDER = 10
# Bounds of the links of a dyad, in characteristic lengths, and the weight of those beyond.
SHORTEST, LONGEST, LENGTH_WEIGHT = 0.1, 5.0, 3.0
# Step of central differences, in characteristic lengths and radians.
STEP = 1e-6
# Most evaluations of a walk, and the sum of squares below which angles are related.
EVALUATIONS, RELATED = 100, 1e-22


@dataclass(frozen=True, eq=False)
class AngleRelations:
    """The angular rates of a linkage with a dyad, as they depend on its geometry.

    Attributes:
        chain: the planar linkage with the dyad, in a geometry to begin with.
        dyad: the dyad.
        joints: the joints of the dyad in the chain (3,).
        bodies: the bodies whose angles count: a link that slides along another one turns with
            it, which is no relation to be searched for.
        scale: radius of convergence, by whose powers orders are multiplied.
    """

    chain: Chain
    dyad: Dyad
    joints: IntArray
    bodies: IntArray
    scale: float = 1.0

    @cached_property
    def rays(self) -> Array:
        """Directions of the motion (rays, w)."""
        enough = 1 if self.chain.width == 1 else self.chain.links.size
        return spanning_rays(self.chain.width, ORDER, enough)

    @cached_property
    def weights(self) -> Array:
        """Weights of the orders."""
        return np.asarray(self.scale ** np.arange(ORDER + 1.0))

    def matrix(self, numbers: Array) -> Array:
        """Compute Ω (rows, bodies) at a geometry of the dyad.

        Args:
            numbers: the numbers of the dyad; see `balance.masses.remedies.dyads.dyad_geometry`.
        """
        chain, series = self._expand(numbers)
        X = RegressorSeries(chain, series, False).rows(ORDER)[:, :, :, 0, 3::4]
        X = X[..., self.bodies]
        return np.asarray((X * self.weights[:, None, None, None]).reshape(-1, X.shape[-1]))

    def at_scale(self, numbers: Array) -> AngleRelations:
        """Return the same with the radius of convergence at a geometry.

        It is taken from the growth of the rates, ``ρ = (|Ω_0| / |Ω_K|)^(1/K)``, so that the
        last order weighs as much as the first.

        Args:
            numbers: the numbers of the dyad.
        """
        orders = replace(self, scale=1.0).matrix(numbers).reshape(ORDER + 1, -1)
        sizes = np.sqrt(np.sum(orders**2, axis=1))
        scale = float((sizes[0] / sizes[-1]) ** (1.0 / ORDER)) if sizes[-1] > 0.0 else 1.0
        return replace(self, scale=scale)

    def smallest(self, numbers: Array) -> tuple[float, Array]:
        """Compute σ at a geometry of the dyad, and its right singular vector J (bodies,).

        Args:
            numbers: the numbers of the dyad.
        """
        _, values, Vt = np.linalg.svd(self.matrix(numbers), full_matrices=False)
        return float(values[-1]), Vt[-1]

    def gradient(self, numbers: Array, J: Array) -> Array:
        """Compute the derivatives of |Ω J|² for a fixed J, by the chain rule.

        Args:
            numbers: the numbers of the dyad.
            J: a moment of inertia for each body (bodies,), chain units.

        Returns:
            One for each number; with the vector of `smallest`, the gradient of σ².
        """
        chain, series = self._expand(numbers)
        z = np.zeros((chain.links.size, 4))
        z[self.bodies, 3] = J
        X = RegressorSeries(chain, series, False).rows(ORDER)
        bars = np.einsum("krwiq,q,k->krwi", X, z.ravel(), 2.0 * self.weights**2)
        slopes = ConditionGradients(chain, self.rays, series, False)
        of_screws = slopes.of_momentum(bars, z)[self.joints]
        rates = [
            (dyad_screws(self.dyad, numbers + h) - dyad_screws(self.dyad, numbers - h))
            for h in STEP * np.eye(numbers.size)
        ]
        return np.einsum("gnd,nd->g", np.array(rates) / (2.0 * STEP), of_screws)

    def _expand(self, numbers: Array) -> tuple[Chain, Series]:
        """Expand the motion at a geometry of the dyad."""
        screws = self.chain.screws.copy()
        screws[self.joints] = dyad_screws(self.dyad, numbers)
        chain = replace(self.chain, screws=read_only(screws))
        return chain, expand(chain, self.rays, ORDER)


@dataclass(frozen=True, eq=False)
class DyadWalk:
    """Where a walk ended.

    Attributes:
        numbers: the numbers of the dyad.
        J: the relation between the angular rates (bodies,).
        residual: |Ω J|² / |J|², and the square of how far lengths are out of bounds.
    """

    numbers: Array
    J: Array
    residual: float

    @property
    def related(self) -> bool:
        """Whether the angles are related, to round-off."""
        return self.residual <= RELATED


def walk(relations: AngleRelations, numbers: Array) -> DyadWalk:
    """Walk from a geometry of a dyad to one at which the angles are related, if one is near.

    Args:
        numbers: the numbers of the dyad to begin with.

    Returns:
        Where the walk ended.
    """
    from scipy.optimize import least_squares

    here, size = relations.at_scale(numbers), numbers.size
    x = least_squares(
        lambda x: _residuals(here, x[:size], x[size:]),
        np.concatenate([numbers, here.smallest(numbers)[1]]),
        lambda x: _jacobian(here, x[:size], x[size:]),
        method="lm",
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
        max_nfev=EVALUATIONS,
    ).x
    numbers, J = x[:size], x[size:] / np.sqrt(x[size:] @ x[size:])
    residuals = _residuals(here, numbers, J)
    return DyadWalk(numbers, J, float(residuals @ residuals))


def _residuals(relations: AngleRelations, numbers: Array, J: Array) -> Array:
    """Compute Ω J, how far each link of the dyad is out of bounds, and |J|² - 1."""
    lengths = segments_of(relations.dyad, numbers)
    over = np.maximum(lengths - LONGEST, 0.0) + np.maximum(SHORTEST - lengths, 0.0)
    out = np.concatenate([relations.matrix(numbers) @ J, LENGTH_WEIGHT * over, [J @ J - 1.0]])
    # Where the loops are singular, rates are without bound.
    return np.nan_to_num(out, nan=1e6, posinf=1e6, neginf=-1e6)


def _jacobian(relations: AngleRelations, numbers: Array, J: Array) -> Array:
    """Differentiate the residuals: by central differences in the numbers of the dyad."""
    slopes = [
        (_residuals(relations, numbers + h, J) - _residuals(relations, numbers - h, J))
        / (2.0 * STEP)
        for h in STEP * np.eye(numbers.size)
    ]
    matrix = relations.matrix(numbers)
    none = np.zeros((len(slopes[0]) - len(matrix) - 1, J.size))
    out = np.column_stack([np.array(slopes).T, np.vstack([matrix, none, 2.0 * J])])
    return np.nan_to_num(out, nan=0.0, posinf=0.0, neginf=0.0)
