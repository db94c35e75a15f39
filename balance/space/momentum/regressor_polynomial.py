"""Mixed partial derivatives of the momentum regressor, to any order.

    h(u, u̇) = Σ_w u̇_w X_w(u) z          X_w(u) = Σ_α X_{w,α} u^α

Along a ray ``u = t δ`` the coefficient of order k is a homogeneous polynomial of degree k in
δ: its values along enough rays, from the kernels of the momentum, determine ``X_{w,α}``. The
multi-indices α and their order are those of `kinematics.closure.taylor.monomials`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import ArrayLike

from balance.space.momentum.regressor import RegressorSeries
from kinematics.closure.joint_positions import si_chain
from kinematics.closure.series import expand
from kinematics.closure.taylor.monomials import monomial_powers, monomial_table
from kinematics.closure.taylor.taylor_motion import scaled_chain
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.motion import Motion, motion_of
from kinematics.numerics.array_types import Array, IntArray
from kinematics.wording import count_noun, first_names

# Number of rays for each monomial of the highest degree.
RAYS_PER_MONOMIAL = 2
SEED = 11


@dataclass(frozen=True, eq=False)
class MomentumTaylor:
    """The momentum regressor as a Taylor polynomial about the reference pose.

    Points u are as in `kinematics.closure.taylor.TaylorMotion`. Rows are ``[ξ; p]`` about the
    inertial origin in inertial axes, or ``[ξz, px, py]`` in the axes of the plane; SI units.

    Attributes:
        motion: the motion that was expanded.
        exponents: multi-indices α (M, w), by degree.
        coefficients: ``X_{w,α}`` (M, w, rows, parameters).
    """

    motion: Motion
    exponents: IntArray
    coefficients: Array

    def __repr__(self) -> str:
        """One line: degree, inputs, size."""
        rows, parameters = self.coefficients.shape[2:]
        order = int(self.exponents.sum(axis=1).max(initial=0))
        return (
            f"MomentumTaylor: order {order} in {first_names(self.motion.inputs)}, "
            f"{rows} rows of {count_noun(parameters, 'parameter')}"
        )

    @property
    def derivatives(self) -> Array:
        """Mixed partial derivatives ``α! X_{w,α}`` at the reference pose, as `coefficients`."""
        products = [np.prod([factorial(a) for a in row]) for row in self.exponents.tolist()]
        return np.array(products)[:, None, None, None] * self.coefficients

    def evaluate(self, u: ArrayLike) -> Array:
        """Evaluate the regressor at points u (..., w); shape (..., w, rows, parameters)."""
        points = monomial_powers(self.exponents, np.asarray(u, dtype=np.float64))
        return np.tensordot(points, self.coefficients, axes=1)

    def momentum(self, z: ArrayLike) -> Array:
        """Compute the momentum of bodies z (parameters,) for unit rates of inputs, by monomial.

        Returns:
            Coefficients (M, w, rows).
        """
        momentum: Array = self.coefficients @ np.asarray(z, dtype=np.float64)
        return momentum


def momentum_taylor(
    linkage: LinkageLike,
    order: int,
    motion: str | Sequence[str] | Motion | None = None,
    *,
    spatial: bool | None = None,
) -> MomentumTaylor:
    """Expand the momentum regressor of a linkage as a Taylor polynomial in its inputs.

    ``X_w(u) = Σ_α X_{w,α} u^α`` about the reference pose.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        order: highest degree in the inputs, at least 0.
        motion: restriction of the inputs, as relations or as a `Motion`.
        spatial: six rows and ten parameters per body; by default only if the linkage is
            not planar.

    Returns:
        Coefficients by multi-index, SI units; see `MomentumTaylor` for rows and axes.

    Raises:
        MotionError: the motion is not one of this linkage's inputs.
        LinkageError: there are too many coefficients.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, chapter 5.

    Example:
        >>> import balance
        >>> taylor = balance.momentum.momentum_taylor("robot.urdf", 2)
        >>> taylor.coefficients.shape
        (3, 1, 3, 12)
    """
    linkage = as_linkage(linkage)
    motion = motion_of(linkage, motion) or Motion.free(linkage.inputs)
    chain = si_chain(linkage, not linkage.planar if spatial is None else spatial)
    chain, scales = scaled_chain(chain, linkage, motion)
    table = monomial_table(chain.width, order)
    count = np.diff(table.starts)
    rays = np.random.default_rng(SEED).standard_normal(
        (RAYS_PER_MONOMIAL * int(count[-1]), chain.width)
    )
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    X = RegressorSeries(chain, expand(chain, rays, order)).rows(order)
    parts = [
        _fit_polynomial(table.exponents[a:b], rays, values)
        for a, b, values in zip(table.starts[:-1], table.starts[1:], X, strict=True)
    ]
    units = monomial_powers(table.exponents, 1.0 / scales)
    coefficients = np.concatenate(parts) * units[:, None, None, None] / scales[:, None, None]
    return MomentumTaylor(motion, table.exponents, freeze(coefficients))


def _fit_polynomial(exponents: IntArray, rays: Array, values: Array) -> Array:
    """Fit the homogeneous polynomial that has given values along rays.

    Monomials are weighted by the roots of their multinomial coefficients, with which no
    rotation of the variables changes their sum of squares.

    Args:
        exponents: its multi-indices (N, w).
        rays: unit vectors (rays, w).
        values: shape (rays, …).

    Returns:
        Coefficients, shape (N, …).
    """
    degree = int(exponents[0].sum())
    products = [np.prod([factorial(a) for a in row]) for row in exponents.tolist()]
    weights = np.sqrt(factorial(degree) / np.array(products))
    flat = values.reshape(len(rays), -1)
    fit = np.linalg.lstsq(monomial_powers(exponents, rays) * weights, flat, rcond=None)[0]
    coefficients: Array = (weights[:, None] * fit).reshape(len(exponents), *values.shape[1:])
    return coefficients
