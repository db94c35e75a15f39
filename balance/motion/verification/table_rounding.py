"""Motions that a rounded table determines: a smooth spline within the rounding, and its error.

A number written with d decimals is off by up to ``δ = 10⁻ᵈ/2``. Differences of such numbers
give accelerations that are off by about ``δ/Δt²``, which may exceed the motion. So a spline of
degree five with few knots, or a polynomial of less, is fitted by least squares. It gets more
knots until it passes all samples within the rounding.

Its coefficients are linear in the samples, so each derivative is a sum ``Σ_k S_k u_k``, and
rounding moves it by at most ``Σ_k |S_k| δ_k``. What the spline cannot follow is about the
change of the derivative from this spline to the next one, with more knots.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array

DEGREE = 5
# Factor of the number of knots from one spline to the next.
KNOTS_FACTOR = 1.5
# Fewest samples per coefficient of a spline by least squares; with more coefficients the
# spline passes through all samples.
SAMPLES_PER_COEFFICIENT = 1.5
# Residuals of a spline within the rounding, over half a unit of the last digit: the largest,
# which is 1 for the true motion and some more after the fit, and the mean square over 1/3.
LARGEST_RESIDUAL = 2.0
MEAN_RESIDUAL = 1.2
# Factor of the difference between two splines: both may be off to the same side.
CHANGE_FACTOR = 2.0
# Most samples at which the effect of the rounding is computed; in between, the largest near by
# counts.
MOST_ROWS = 600
# Sums over rows at once.
BLOCK = 50


@dataclass(frozen=True, eq=False)
class InputErrors:
    """How far a motion from a table can be off, since its numbers are rounded; SI units.

    Attributes:
        decimals: fewest decimals of the inputs that move.
        u: bounds on the errors of the displacements (N, mobility).
        ud: of their velocities.
        udd: of their accelerations.
    """

    decimals: int
    u: Array
    ud: Array
    udd: Array


class SmoothSpline(NamedTuple):
    """A spline within the rounding of a table.

    Attributes:
        spline: ``scipy.interpolate.BSpline``.
        errors: bounds on its displacements, velocities and accelerations at the samples
            (3, N, columns).
    """

    spline: Any
    errors: Array


def even_times(time: Array, rounding: Array) -> tuple[Array, float] | None:
    """Return the even times that rounded ones stand for.

    Args:
        time: times as written (N,), seconds.
        rounding: half a unit of their last digits (N,).

    Returns:
        Even times, and how far their step can be off, relative to it: not at all, if the times
        are even as they are written. None if no even times round to those.
    """
    even = np.linspace(time[0], time[-1], time.size)
    distance, unit = np.abs(even - time).max(), float(rounding.max())
    if distance > 2.0 * unit:
        return None
    exact = distance <= max(0.01 * unit, 4.0 * np.finfo(np.float64).eps * np.abs(time).max())
    return even, 0.0 if exact else 2.0 * unit / float(time[-1] - time[0])


def smooth_spline(time: Array, u: Array, rounding: Array) -> SmoothSpline:
    """Fit the spline with the fewest knots that passes samples within their rounding.

    Args:
        time: times (N,), rising, seconds.
        u: samples (N, columns).
        rounding: bounds on their errors (N, columns).

    Returns:
        The spline, with bounds on the errors of its derivatives.
    """
    levels = list(_levels(time.size))
    for k, level in enumerate(levels):
        fit = _fit_level(time, u, *level)
        if _within(fit.spline(time) - u, rounding):
            # Of an even or odd polynomial the next degree adds nothing.
            above = k + (2 if level[1] == 1 else 1)
            more = _fit_level(time, u, *levels[above]) if above < len(levels) else None
            other = more or _interpolate(time, u)
            return SmoothSpline(fit.spline, _errors(time, fit, other, rounding))
    # No spline of few knots is right: the error is that between samples.
    fit = _interpolate(time, u)
    half = np.union1d(np.arange(0, time.size, 2), time.size - 1)
    return SmoothSpline(
        fit.spline, _errors(time, fit, _interpolate(time[half], u[half]), rounding)
    )


class _Fit(NamedTuple):
    """A spline, linear in its samples, and the transpose of the map to its coefficients."""

    spline: Any
    transposed: Callable[[Array], Array]


def _levels(samples: int) -> Iterator[tuple[int, int]]:
    """Yield degrees and numbers of intervals between knots, ascending in both."""
    for degree in range(1, DEGREE):
        if (degree + 1) * SAMPLES_PER_COEFFICIENT <= samples:
            yield degree, 1
    intervals = 1
    while (intervals + DEGREE) * SAMPLES_PER_COEFFICIENT <= samples:
        yield DEGREE, intervals
        intervals = max(intervals + 1, int(KNOTS_FACTOR * intervals))


def _fit_level(time: Array, u: Array, degree: int, intervals: int) -> _Fit:
    """Fit a spline by least squares; each interval between knots has as many samples."""
    from scipy.interpolate import BSpline
    from scipy.sparse.linalg import splu

    places = np.linspace(0.0, time.size - 1.0, intervals + 1)
    inner = np.interp(places, np.arange(time.size), time)
    knots = np.concatenate([[inner[0]] * degree, inner, [inner[-1]] * degree])
    B = BSpline.design_matrix(time, knots, degree)
    normal = splu((B.T @ B).tocsc())
    coefficients = normal.solve(B.T @ u)
    # The normal equations lose digits, which one step of refinement restores.
    coefficients += normal.solve(B.T @ (u - B @ coefficients))
    return _Fit(BSpline(knots, coefficients, degree), lambda rows: B @ normal.solve(rows))


def _interpolate(time: Array, u: Array) -> _Fit:
    """Make the spline through samples, of a lower degree if there are fewer than six."""
    from scipy.interpolate import BSpline, make_interp_spline
    from scipy.sparse.linalg import splu

    degree = min(DEGREE, time.size - 1 if time.size % 2 == 0 else time.size - 2)
    spline = make_interp_spline(time, u, k=degree)
    B = splu(BSpline.design_matrix(time, spline.t, degree).tocsc())
    return _Fit(spline, lambda rows: B.solve(rows, "T"))


def _within(residual: Array, rounding: Array) -> bool:
    """Whether residuals (N, columns) are what the rounding explains."""
    unit = rounding.max(axis=0)
    largest = np.abs(residual).max(axis=0) <= LARGEST_RESIDUAL * unit
    mean = (residual**2).mean(axis=0) <= (MEAN_RESIDUAL * unit) ** 2 / 3.0
    return bool(np.all((largest & mean) | (unit == 0.0)))


def _errors(time: Array, fit: _Fit, other: _Fit, rounding: Array) -> Array:
    """Bound the errors of a spline and its first two derivatives (3, N, columns).

    Args:
        time: times of the samples (N,).
        other: one with other knots; where both differ, neither follows the motion.
        rounding: bounds on the errors of the samples (N, columns).
    """
    from scipy.ndimage import maximum_filter1d

    intervals = max(1, min(np.unique(x.spline.t).size for x in (fit, other)) - 1)
    width = 2 * -(-time.size // intervals) + 1
    errors = np.empty((3, *rounding.shape))
    for order in range(3):
        change = CHANGE_FACTOR * np.abs(fit.spline(time, order) - other.spline(time, order))
        errors[order] = maximum_filter1d(change, width, axis=0, mode="nearest")
        errors[order] += _effect_of_rounding(time, fit, order, rounding)
    return errors


def _effect_of_rounding(time: Array, fit: _Fit, order: int, rounding: Array) -> Array:
    """Compute ``Σ_k |S_k| δ_k`` for a derivative at each sample (N, columns)."""
    from scipy.interpolate import BSpline
    from scipy.ndimage import maximum_filter1d

    knots, degree, steps = fit.spline.t, fit.spline.k, []
    if order > degree:
        return np.zeros_like(rounding)
    for _ in range(order):
        steps.append(_differences(knots, degree))
        knots, degree = knots[1:-1], degree - 1
    at = np.unique(np.linspace(0, time.size - 1, MOST_ROWS).astype(np.int64))
    rows = BSpline.design_matrix(time[at], knots, degree)
    for step in reversed(steps):
        rows = rows @ step
    sums = [
        np.abs(fit.transposed(rows[k : k + BLOCK].toarray().T)).T @ rounding
        for k in range(0, at.size, BLOCK)
    ]
    effects = np.concatenate(sums)
    if at.size == time.size:
        return effects
    effects = maximum_filter1d(effects, 3, axis=0, mode="nearest")
    return np.asarray(effects[np.searchsorted(at, np.arange(time.size))])


def _differences(knots: Array, degree: int) -> Any:
    """Build the matrix from coefficients of a spline to those of its derivative, sparse."""
    from scipy.sparse import diags_array

    count = knots.size - degree - 1
    weight = degree / (knots[degree + 1 : count + degree] - knots[1:count])
    return diags_array([-weight, weight], offsets=[0, 1], shape=(count - 1, count)).tocsr()
