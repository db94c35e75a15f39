"""Weighted linear least squares for combinations of parameters that a motion excites.

Loads of channel c are ``y_c = Y_c x + F_c a_c + noise`` with parameters x, and parameters a_c
of the sensor alone, such as its offset, which are projected out. Of x, only its part in the row
space of Y is determined: ``x = V v``, V orthonormal. The noise of each channel is white with a
standard deviation of its own, which is estimated together with v: with weights ``1/σ_c``,

    σ_c² = |r_c|² / (N - f_c - tr H_c)

with the residual r_c and the diagonal block H_c of the hat matrix. The covariance of v is
``(Σ_c V' Y_c' Y_c V / σ_c²)⁻¹``. (G. A. F. Seber, A. J. Lee, Linear Regression Analysis, 2003,
chapter 3; for robots: J. Swevers et al., IEEE Transactions on Robotics and Automation 13(5),
1997, section II.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.space.conditions.rank import Conditions, singular_value_decomposition
from balance.support.tolerances import (
    EXCITED_OUTSIDE,
    EXCITED_RELATIVE,
    NOISE_FOUND,
    NOISE_LEAST,
)
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import complement

# Most changes of the weights; a handful is enough.
MAX_WEIGHTS = 50
# Standard deviation of the rounding of numbers, over half a unit of their last digit.
ROUNDING_DEVIATION = 3.0**-0.5
# Fewest degrees of freedom of the residuals of a channel.
LEAST_FREEDOM = 3.0


class LeastSquares(NamedTuple):
    """Combinations of parameters that loads determine, and how well.

    Attributes:
        directions: V, orthonormal columns (parameters, excited).
        estimate: v (excited,).
        factor: triangular R of ``R' R = cov(v)⁻¹`` (excited, excited).
        noise: standard deviation of each channel (channels,).
        residuals: of the loads (N, channels).
        freedom: degrees of freedom of the residuals (channels,).
    """

    directions: Array
    estimate: Array
    factor: Array
    noise: Array
    residuals: Array
    freedom: Array

    def spread(self, rows: Array) -> Array:
        """Compute standard errors (k,) of combinations of v, given as rows (k, excited)."""
        return np.asarray(np.linalg.norm(np.linalg.solve(self.factor.T, rows.T), axis=0))


def excited_directions(rows: Array) -> Array:
    """Compute an orthonormal basis (parameters, excited) of the row space of rows.

    Args:
        rows: regressor of loads (rows, parameters), each channel over its size.
    """
    count = rows.shape[1]
    triangle = np.asarray(np.linalg.qr(rows, mode="r")) if len(rows) > count else rows
    start = Conditions.given(np.empty((0, count)), EXCITED_RELATIVE)
    null = start.append(triangle).decide().basis
    return complement(null)


def solve(
    rows: Array, loads: Array, sensors: list[Array], rounding: Array
) -> LeastSquares | None:
    """Estimate the parameters that loads determine.

    Args:
        rows: Y (N, channels, parameters).
        loads: y (N, channels).
        sensors: F of each channel (N, f), f may be 0.
        rounding: bounds on the rounding of the loads (channels,).

    Returns:
        The estimate; None if there are too few samples for so many unknowns.
    """
    N, channels = loads.shape
    bases = [np.linalg.qr(F)[0] for F in sensors]
    Y, y = rows.copy(), loads.copy()
    for c, Q in enumerate(bases):
        Y[:, c] -= Q @ (Q.T @ Y[:, c])
        y[:, c] -= Q @ (Q.T @ y[:, c])
    size = np.sqrt(np.square(Y).sum(axis=(0, 2)))
    size = np.where(size > 0.0, size, 1.0)
    V = excited_directions((Y / size[:, None]).reshape(N * channels, -1))
    A = Y @ V
    least = np.maximum(ROUNDING_DEVIATION * rounding, NOISE_LEAST * np.abs(loads).max())
    least = np.maximum(least, np.finfo(np.float64).tiny)
    noise = np.maximum(np.sqrt(np.square(y).mean(axis=0)), least)
    fixed = N - np.array([Q.shape[1] for Q in bases])
    for _ in range(MAX_WEIGHTS):
        flat = (A / noise[:, None]).reshape(N * channels, -1)
        Q, R = np.linalg.qr(flat)
        v = np.linalg.solve(R, Q.T @ (y / noise).reshape(-1))
        residuals = y - A @ v
        hat = np.square(Q).sum(axis=1).reshape(N, channels).sum(axis=0)
        freedom = fixed - hat
        if freedom.min() < LEAST_FREEDOM:
            return None
        before = noise
        noise = np.maximum(np.sqrt(np.square(residuals).sum(axis=0) / freedom), least)
        if np.all(np.abs(noise - before) <= NOISE_FOUND * before):
            break
    return LeastSquares(V, v, R, noise, residuals, freedom)


def condition_number(factor: Array, rows: Array) -> float:
    """Compute the ratio of largest and smallest standard error of unit combinations.

    Args:
        factor: R of a `LeastSquares`.
        rows: orthonormal combinations of v (k, excited).
    """
    if not len(rows):
        return 1.0
    half = np.asarray(np.linalg.solve(factor.T, rows.T), np.float64)
    spread = singular_value_decomposition(half)[1]
    return float(spread[0] / spread[-1])


def sensor_errors(
    columns: Array, rows: Array, fit: LeastSquares, noise: float
) -> list[float | None]:
    """Compute standard errors of the parameters of a sensor, ``a = F⁺ (y - Y V v)``.

    Args:
        columns: F (N, f).
        rows: Y of its channel (N, parameters).
        fit: what all loads determine.
        noise: standard deviation of the channel.

    Returns:
        One for each column; None for a parameter that cannot be told from the others, since
        masses explain the same loads.
    """
    inverse = np.linalg.pinv(columns)
    size = np.linalg.norm(columns, axis=0)
    open_part = inverse @ (rows @ complement(fit.directions))
    open_size = np.linalg.norm(open_part, axis=1) * size
    slope = inverse @ (rows @ fit.directions)
    spread = np.hypot(noise * np.linalg.norm(inverse, axis=1), fit.spread(slope))
    known = open_size <= EXCITED_OUTSIDE * np.linalg.norm(rows)
    return [float(s) if yes else None for s, yes in zip(spread, known, strict=True)]
