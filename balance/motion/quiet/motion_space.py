"""Motions of the inputs that a plan chooses from: linear spaces of functions of time.

    u(t) = Σ_k f_k(t) c_k        c = fixed + free y

The functions f are B-splines of degree five, whose accelerations are smooth. The coefficients c
fulfil the conditions of the ends for every y. Those of a cycle are harmonics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from balance.motion.verification.input_paths import InputPath
from kinematics.numerics.array_types import Array

Functions = Callable[[Array, int], Array]

DEGREE = 5
# Shares of the duration at which a trapezoidal law stops to accelerate, and begins to brake.
TRAPEZOID = (1.0 / 3.0, 2.0 / 3.0)
# Samples per interval of the knots that a law is fitted to.
FITTED = 8


@dataclass(frozen=True, eq=False)
class PlannedPath:
    """A motion of the inputs as a function of time; an `InputPath`.

    Attributes:
        functions: values (N, count) of all functions at times (N,), or of a derivative.
        coefficients: c (count, inputs).
        corners: times at which the motion is not smooth.
    """

    functions: Functions
    coefficients: Array
    corners: tuple[float, ...] = ()

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations (N, inputs) at times (N,)."""
        u, ud, udd = (self.functions(time, order) @ self.coefficients for order in range(3))
        return u, ud, udd

    def jerk(self, time: Array) -> Array:
        """Compute the third derivatives (N, inputs) at times (N,)."""
        return self.functions(time, 3) @ self.coefficients


@dataclass(frozen=True, eq=False)
class MotionSpace:
    """A linear space of motions; see the head of this file.

    Attributes:
        duration: seconds.
        intervals: number of intervals between the knots of the functions.
        functions: values of all functions, or of a derivative, at times.
        fixed: coefficients for y = 0 (count, inputs).
        free: takes y (free, inputs) to coefficients (count, free).
    """

    duration: float
    intervals: int
    functions: Functions
    fixed: Array
    free: Array

    def path(self, y: Array) -> PlannedPath:
        """Return the motion with the given free coefficients (free, inputs)."""
        return PlannedPath(self.functions, self.fixed + self.free @ y)

    def times(self, per_interval: int) -> Array:
        """Compute evenly spaced times, so many for each interval of the functions."""
        return np.linspace(0.0, self.duration, per_interval * self.intervals + 1)

    def basis(self, time: Array, order: int) -> Array:
        """Compute the derivative of the motion by y (N, free)."""
        return self.functions(time, order) @ self.free

    def fit(self, path: InputPath) -> Array:
        """Compute the y of the motion of the space that is nearest to another one."""
        time = self.times(FITTED)
        difference = path.at(time)[0] - self.functions(time, 0) @ self.fixed
        return np.asarray(np.linalg.lstsq(self.basis(time, 0), difference, rcond=None)[0])


def rest_space(
    start: Array,
    end: Array,
    duration: float,
    intervals: int,
    smooth: bool = False,
    open_end: bool = False,
) -> MotionSpace:
    """Build the space of motions from rest to rest between two poses.

    Args:
        start: displacements of the inputs (inputs,), SI units.
        end: those at the end.
        duration: seconds.
        intervals: number of intervals between knots.
        smooth: whether accelerations vanish at both ends, too.
        open_end: whether the end is free: the last row of y is its displacement.
    """
    knots = np.linspace(0.0, duration, intervals + 1)
    functions = spline_functions(
        np.concatenate([knots[:1].repeat(DEGREE), knots, knots[-1:].repeat(DEGREE)])
    )
    count, held = intervals + DEGREE, 3 if smooth else 2
    fixed = np.zeros((count, start.size))
    fixed[:held], fixed[count - held :] = start, end
    # From a straight line: y = 0 is a motion too.
    share = np.linspace(0.0, 1.0, count - 2 * held + 2)[1:-1, None]
    fixed[held : count - held] = start + share * (end - start)
    free = np.eye(count)[:, held:-held]
    if open_end:
        moved = np.concatenate([np.zeros((held, 1)), share, np.ones((held, 1))])
        free = np.concatenate([free, moved], axis=1)
    return MotionSpace(duration, intervals, functions, fixed, free)


def harmonic_space(inputs: int, duration: float, harmonics: int) -> MotionSpace:
    """Build the space of cycles: a constant, and harmonics of one over the duration.

    Args:
        inputs: number of inputs.
        duration: of one cycle, seconds.
        harmonics: number of multiples of the rate of the cycle.
    """
    rate = 2.0 * np.pi * np.arange(harmonics + 1) / duration

    def functions(time: Array, order: int) -> Array:
        turn = np.outer(time, rate) + 0.5 * np.pi * order
        waves = [np.cos(turn), np.sin(turn[:, 1:])]
        return np.concatenate(waves, axis=1) * np.concatenate([rate, rate[1:]]) ** order

    count = 2 * harmonics + 1
    # Loads have higher harmonics than the inputs.
    intervals = 3 * harmonics + 5
    return MotionSpace(duration, intervals, functions, np.zeros((count, inputs)), np.eye(count))


@dataclass(frozen=True, eq=False)
class PathWithStops:
    """Motions one after the other, each from rest to rest; an `InputPath`.

    Attributes:
        legs: the motions, each from time 0 on.
        starts: their times (legs + 1,), with the end of the last one.
    """

    legs: tuple[PlannedPath, ...]
    starts: Array

    @property
    def corners(self) -> tuple[float, ...]:
        """Corner times of the legs, and the times at which one ends and the next begins."""
        pairs = zip(self.legs, self.starts, strict=False)
        inner = [start + corner for leg, start in pairs for corner in leg.corners]
        return tuple(sorted([*inner, *self.starts[1:-1].tolist()]))

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations; see `InputPath`."""
        number = np.searchsorted(self.starts[1:-1], time, side="right")
        parts = np.empty((3, len(time), self.legs[0].coefficients.shape[1]))
        for k, leg in enumerate(self.legs):
            here = number == k
            if here.any():
                within = np.clip(time[here] - self.starts[k], 0.0, None)
                parts[:, here] = leg.at(np.minimum(within, self.starts[k + 1] - self.starts[k]))
        u, ud, udd = parts
        return u, ud, udd


def leg_times(stops: Sequence[Array], units: Array, duration: float) -> Array:
    """Compute the times of stops at which all legs accelerate alike (stops,).

    The duration of a leg is as the root of its distance.
    """
    distances = np.linalg.norm(np.diff(np.array(stops), axis=0) / units, axis=1)
    shares = np.sqrt(distances)
    return duration * np.append(0.0, np.cumsum(shares)) / shares.sum()


def path_through(
    law: Callable[[Array, Array, float], PlannedPath], stops: Sequence[Array], times: Array
) -> PlannedPath | PathWithStops:
    """Make the motion that rests at all stops, with a law on each straight line.

    Args:
        law: `quintic_path` or `trapezoidal_path`.
        stops: displacements of the inputs, two or more.
        times: of the stops.
    """
    legs = tuple(
        law(a, b, float(span))
        for a, b, span in zip(stops[:-1], stops[1:], np.diff(times), strict=True)
    )
    return legs[0] if len(legs) == 1 else PathWithStops(legs, times)


def spline_functions(knots: Array) -> Functions:
    """Build the B-splines of degree five on knots, all of them given with multiplicity."""
    from scipy.interpolate import BSpline

    splines = BSpline(knots, np.eye(knots.size - DEGREE - 1), DEGREE)

    def evaluate(time: Array, order: int) -> Array:
        return np.asarray(splines(time, order))

    return evaluate


def quintic_path(start: Array, end: Array, duration: float) -> PlannedPath:
    """Build the quintic law on a straight line: ``10 τ³ - 15 τ⁴ + 6 τ⁵``."""
    share = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])[:, None]
    functions = spline_functions(np.repeat([0.0, duration], DEGREE + 1))
    return PlannedPath(functions, start + share * (end - start))


def trapezoidal_path(start: Array, end: Array, duration: float) -> PlannedPath:
    """Build the law of trapezoidal speed on a straight line: thirds of equal duration."""
    corners = np.multiply(TRAPEZOID, duration)
    knots = np.concatenate(
        [np.zeros(DEGREE + 1), corners.repeat(DEGREE - 1), np.full(DEGREE + 1, duration)]
    )
    functions = spline_functions(knots)
    time = np.linspace(0.0, duration, 12 * FITTED + 1)
    x, first = time / duration, TRAPEZOID[0]
    late = 1.0 - np.where(x > TRAPEZOID[1], 1.0 - x, 0.0) ** 2 / (2.0 * first * (1.0 - first))
    middle = (x - 0.5 * first) / (1.0 - first)
    share = np.where(x < first, x**2 / (2.0 * first * (1.0 - first)), middle)
    share = np.where(x > TRAPEZOID[1], late, share)
    coefficients = np.linalg.lstsq(functions(time, 0), share, rcond=None)[0][:, None]
    return PlannedPath(functions, start + coefficients * (end - start), tuple(corners.tolist()))
