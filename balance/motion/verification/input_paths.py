"""Motions of the inputs as functions of time, with two derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from kinematics.numerics.array_types import Array

# Number of harmonics of random motions.
HARMONICS = 3


class InputPath(Protocol):
    """Displacements of the inputs from the reference pose as functions of time, SI units."""

    @property
    def corners(self) -> tuple[float, ...]:
        """Times at which the functions are not smooth, in order."""
        ...

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations (N, inputs) at times (N,)."""
        ...


def sample_input_path(path: InputPath, duration: float, count: int) -> tuple[Array, ...]:
    """Compute time (N,), displacements, velocities and accelerations (N, inputs) of a path.

    Args:
        duration: seconds.
        count: N, the number of samples at even times.
    """
    time = np.linspace(0.0, duration, count)
    return time, *path.at(time)


def input_path_data(
    time: Array, position: Array, velocity: Array, acceleration: Array
) -> dict[str, object]:
    """Return samples of a path as plain data for JSON."""
    return {
        "time": time.tolist(),
        "position": position.tolist(),
        "velocity": velocity.tolist(),
        "acceleration": acceleration.tolist(),
    }


@dataclass(frozen=True, eq=False)
class SinePath:
    """Sums of sines of one period, ``Σ_k a_k (sin(k ω t + φ_k) - sin φ_k)``.

    Attributes:
        size: amplitudes a (harmonics, inputs).
        phase: phases φ (harmonics, inputs).
        period: seconds.
        basis: takes the sums to the inputs (mobility, inputs).
        scale: factor of each sum (inputs,), or of all.
        amplitude: factor of all sums.
    """

    size: Array
    phase: Array
    period: float
    basis: Array
    scale: Array | float = 1.0
    amplitude: float = 1.0

    @property
    def corners(self) -> tuple[float, ...]:
        """There are none."""
        return ()

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations; see `InputPath`."""
        omega = 2.0 * np.pi * np.arange(1, len(self.size) + 1)[:, None] / self.period
        angle = omega * time[:, None, None] + self.phase
        wave = np.sin(angle)
        size = self.size
        path = np.einsum("kw,tkw->tw", size, wave - np.sin(self.phase))
        speed = np.einsum("kw,tkw->tw", size * omega, np.cos(angle))
        change = -np.einsum("kw,tkw->tw", size * omega**2, wave)
        path, speed, change = (self.amplitude * (self.scale * x) for x in (path, speed, change))
        return path @ self.basis.T, speed @ self.basis.T, change @ self.basis.T


def random_sines(rng: np.random.Generator, time: Array, width: int) -> SinePath:
    """Draw random sums of sines that are at most 1 at the given times, which end the period.

    Args:
        rng: source of the random numbers.
        time: times (N,), from 0.
    """
    k = np.arange(1, HARMONICS + 1)[:, None]
    size = rng.uniform(0.3, 1.0, (HARMONICS, width)) * rng.choice([-1.0, 1.0], width) / k
    phase = rng.uniform(-0.8, 0.8, (HARMONICS, width))
    path = SinePath(size, phase, float(time[-1] - time[0]), np.eye(width))
    scale = 1.0 / np.abs(path.at(time)[0]).max(axis=0, initial=0.0)
    return SinePath(size, phase, path.period, path.basis, scale)


@dataclass(frozen=True, eq=False)
class SteadyPath:
    """Constant speeds, ``u = start + rate t``.

    Attributes:
        start: displacements at time 0 (inputs,).
        rate: speeds (inputs,).
    """

    start: Array
    rate: Array

    @property
    def corners(self) -> tuple[float, ...]:
        """There are none."""
        return ()

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations; see `InputPath`."""
        u = self.start + np.outer(time, self.rate)
        return u, np.broadcast_to(self.rate, u.shape), np.zeros(u.shape)


@dataclass(frozen=True, eq=False)
class SplinePath:
    """A spline of degree five through samples.

    Attributes:
        spline: ``scipy.interpolate.BSpline``.
        corners: its times.
    """

    spline: Any
    corners: tuple[float, ...]

    @classmethod
    def through(cls, time: Array, u: Array) -> SplinePath:
        """Make the spline through samples.

        Args:
            time: times (N,), seconds.
            u: displacements of the inputs there (N, inputs), SI units.
        """
        from scipy.interpolate import make_interp_spline

        return cls(make_interp_spline(time, u, k=5), tuple(time.tolist()))

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations; see `InputPath`."""
        return self.spline(time), self.spline(time, 1), self.spline(time, 2)


@dataclass(frozen=True, eq=False)
class RestToRest:
    """A path of one period, run through again and again with rest at both ends.

    ``τ = t/2 - T/2π sin(π t/T)`` is its time, so that the inputs are never faster than on the
    path.

    Attributes:
        path: a periodic path.
        period: its period T, seconds.
    """

    path: InputPath
    period: float

    @property
    def corners(self) -> tuple[float, ...]:
        """There are none: all derivatives are periodic."""
        return ()

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations; see `InputPath`."""
        omega = np.pi / self.period
        now = 0.5 * (time - np.sin(omega * time) / omega)
        rate = 0.5 * (1.0 - np.cos(omega * time))[:, None]
        change = 0.5 * (omega * np.sin(omega * time))[:, None]
        u, ud, udd = self.path.at(now)
        return u, rate * ud, rate**2 * udd + change * ud
