"""Weighted linear least squares for combinations of parameters that motions excite.

Loads of channel c are ``y_c = Y_c x + F_c a_c + noise`` with parameters x, and parameters a_c
of the sensor alone, such as its offset, which are projected out. Rows of several recordings
stand one below the other. Of x, only its part in the row space of Y is determined: ``x = V v``,
V orthonormal. The noise of channel c in recording k is white with a standard deviation of its
own, which is estimated together with v: with weights ``1/σ_ck``,

    σ_ck² = |r_ck|² / (N_k - tr H_ck)

with the residual r_ck and the diagonal block H_ck of the hat matrix of v and all a. The
covariance of v is ``(Σ_c V' Y_c' W_c P_c W_c Y_c V)⁻¹``, with the weights W_c and the projector
P_c on the complement of ``W_c F_c``. (G. A. F. Seber, A. J. Lee, Linear Regression Analysis,
2003, chapter 3; for robots: J. Swevers et al., IEEE Transactions on Robotics and Automation
13(5), 1997, section II.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.space.conditions.rank import Conditions, singular_value_decomposition
from balance.support.tolerances import (
    EXCITED_OUTSIDE,
    EXCITED_RELATIVE,
    NOISE_FOUND,
    NOISE_LEAST,
)
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.vectors import complement

# Most changes of the weights; a handful is enough.
MAX_WEIGHTS = 50
# Standard deviation of the rounding of numbers, over half a unit of their last digit.
ROUNDING_DEVIATION = 3.0**-0.5
# Fewest degrees of freedom of the residuals of a channel in a recording.
LEAST_FREEDOM = 3.0


class ChannelRows(NamedTuple):
    """Loads of one channel in all recordings that have it, one below the other.

    Attributes:
        rows: Y (N, parameters).
        loads: y (N,).
        sensor: F (N, f), f may be 0.
        recording: index of the recording of each row (N,), ascending.
        rounding: bounds on the rounding of the loads (N,).
    """

    rows: Array
    loads: Array
    sensor: Array
    recording: IntArray
    rounding: Array


class LeastSquares(NamedTuple):
    """Combinations of parameters that loads determine, and how well.

    Attributes:
        directions: V, orthonormal columns (parameters, excited).
        estimate: v (excited,).
        factor: triangular R of ``R' R = cov(v)⁻¹`` (excited, excited).
        noise: standard deviation of each row of each channel (N,), the same in a recording.
        residuals: of the loads of each channel (N,).
    """

    directions: Array
    estimate: Array
    factor: Array
    noise: tuple[Array, ...]
    residuals: tuple[Array, ...]

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


def solve(channels: Sequence[ChannelRows]) -> LeastSquares | None:
    """Estimate the parameters that loads determine.

    Returns:
        The estimate; None if a recording has too few samples for so many unknowns.
    """
    outside = [_project_out(channel.sensor, channel.rows) for channel in channels]
    sizes = [float(np.linalg.norm(rows)) or 1.0 for rows in outside]
    scaled = [rows / size for rows, size in zip(outside, sizes, strict=True)]
    V = excited_directions(np.concatenate(scaled))
    A = [channel.rows @ V for channel in channels]
    highest = max(float(np.abs(channel.loads).max()) for channel in channels)
    least = [
        np.maximum(ROUNDING_DEVIATION * channel.rounding, NOISE_LEAST * highest)
        for channel in channels
    ]
    least = [np.maximum(size, np.finfo(np.float64).tiny) for size in least]
    residuals = [_project_out(c.sensor, c.loads) for c in channels]
    none = [np.zeros(len(channel.loads)) for channel in channels]
    noise = _estimate_noise(channels, residuals, none, least)
    for _ in range(MAX_WEIGHTS):
        v, R, residuals, leverages = _solve_weighted(channels, A, noise)
        freedoms = [
            _sum_by_recording(c, 1.0 - h) for c, h in zip(channels, leverages, strict=True)
        ]
        if min(float(freedom.min()) for freedom in freedoms) < LEAST_FREEDOM:
            return None
        before = noise
        noise = _estimate_noise(channels, residuals, leverages, least)
        if all(
            np.all(np.abs(now - old) <= NOISE_FOUND * old)
            for now, old in zip(noise, before, strict=True)
        ):
            break
    return LeastSquares(V, v, R, tuple(noise), tuple(residuals))


def _project_out(columns: Array, rows: Array) -> Array:
    """Subtract from rows (N, …) their projection on the span of columns (N, f)."""
    Q = np.linalg.qr(columns)[0]
    return np.asarray(rows - Q @ (Q.T @ rows))


def _solve_weighted(
    channels: Sequence[ChannelRows], A: Sequence[Array], noise: Sequence[Array]
) -> tuple[Array, Array, list[Array], list[Array]]:
    """Solve the weighted equations ``A v + F a = y`` of all channels.

    Returns:
        v; R of ``R' R = cov(v)⁻¹``; residuals and leverages of the rows of each channel.
    """
    bases = [
        np.linalg.qr(channel.sensor / sigma[:, None])[0]
        for channel, sigma in zip(channels, noise, strict=True)
    ]
    rows, loads = [], []
    for channel, part, sigma, Q in zip(channels, A, noise, bases, strict=True):
        weighted = np.column_stack([part, channel.loads]) / sigma[:, None]
        weighted -= Q @ (Q.T @ weighted)
        rows.append(weighted[:, :-1])
        loads.append(weighted[:, -1])
    Q, R = np.linalg.qr(np.concatenate(rows))
    v = np.linalg.solve(R, Q.T @ np.concatenate(loads))
    ends = np.cumsum([len(part) for part in loads])[:-1]
    leverages = [
        hat + np.square(basis).sum(axis=1)
        for hat, basis in zip(np.split(np.square(Q).sum(axis=1), ends), bases, strict=True)
    ]
    residuals = [
        sigma * (y - part @ v) for sigma, y, part in zip(noise, loads, rows, strict=True)
    ]
    return v, R, residuals, leverages


def _sum_by_recording(channel: ChannelRows, values: Array) -> Array:
    """Sum values of rows (N,) over each recording that has the channel."""
    starts = np.flatnonzero(np.diff(channel.recording, prepend=-1))
    return np.asarray(np.add.reduceat(values, starts))


def _estimate_noise(
    channels: Sequence[ChannelRows],
    residuals: Sequence[Array],
    leverages: Sequence[Array],
    least: Sequence[Array],
) -> list[Array]:
    """Estimate the standard deviation of each row of each channel, one for a recording."""
    noise = []
    for channel, r, h, floor in zip(channels, residuals, leverages, least, strict=True):
        power = _sum_by_recording(channel, np.square(r)) / _sum_by_recording(channel, 1.0 - h)
        which = np.unique(channel.recording, return_inverse=True)[1]
        noise.append(np.maximum(np.sqrt(power)[which], floor))
    return noise


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


def sensor_errors(channel: ChannelRows, fit: LeastSquares, noise: Array) -> list[float | None]:
    """Compute standard errors of the parameters of a sensor, ``a = (W F)⁺ W (y - Y V v)``.

    Args:
        channel: the loads of the sensor.
        fit: what all loads determine.
        noise: standard deviation of each row of the channel (N,).

    Returns:
        One for each column; None for a parameter that cannot be told from the others, since
        masses explain the same loads.
    """
    highest = float(noise.max())
    weights = (highest / noise)[:, None]
    columns, rows = weights * channel.sensor, weights * channel.rows
    inverse = np.linalg.pinv(columns)
    size = np.linalg.norm(columns, axis=0)
    open_part = inverse @ (rows @ complement(fit.directions))
    open_size = np.linalg.norm(open_part, axis=1) * size
    slope = inverse @ (rows @ fit.directions)
    spread = np.hypot(highest * np.linalg.norm(inverse, axis=1), fit.spread(slope))
    known = open_size <= EXCITED_OUTSIDE * np.linalg.norm(rows)
    return [float(s) if yes else None for s, yes in zip(spread, known, strict=True)]
