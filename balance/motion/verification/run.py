"""Loads along one motion of a verification."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from balance.motion.verification.trajectory import Trajectory
from kinematics.numerics.array_types import Array, Flags
from kinematics.wording import repr_lines, unit_text

# Components of a wrench.
PARTS = {"force": slice(3, 6), "moment": slice(0, 3)}


@dataclass(frozen=True, eq=False)
class Run:
    """Loads along one motion; wrenches are ``[moment; force]`` in inertial axes, SI units.

    Attributes:
        trajectory: the motion.
        shaking: base reaction from Pinocchio, about the inertial origin (N, 6).
        series_shaking: the same from our Taylor series (N, 6).
        momentum: total momentum ``[ξ; p]`` from Pinocchio (N, 6).
        middle: ``shaking`` with moments about the middle of the mechanism (N, 6).
        about: ``shaking`` with moments about the point of the verification (N, 6).
        rate_difference: ``shaking - series_shaking``, with moments about the middle (N, 6).
        momentum_difference: momentum from Pinocchio minus ours, moments about the middle
            (N, 6).
        inertia: sum over the bodies of the sizes of their own inertia wrenches, moments
            about the middle divided by the characteristic length (N,), newtons.
        impulse: the same sum for their momenta (N,), newton seconds.
        bearing: forces in the joints (N, n), newtons.
        least_bearing: the least that preload leaves of them (N, n), newtons.
        preloaded: whether preload changes the force of a joint, without limit (n,).
        drive: torques, N m, or forces, N, of the inputs without gravity (N, inputs).
        open: number of components of the loop wrenches that rigid bodies do not determine.
        errors: bounds on the errors of the shaking moment about that point, N m, and of the
            shaking force, N, for a motion from a rounded table (2, N); None for exact motions.
    """

    trajectory: Trajectory
    shaking: Array
    series_shaking: Array
    momentum: Array
    middle: Array
    about: Array
    rate_difference: Array
    momentum_difference: Array
    inertia: Array
    impulse: Array
    bearing: Array
    least_bearing: Array
    preloaded: Flags
    drive: Array
    open: int
    errors: Array | None = None

    def sizes(self, part: str) -> Array:
        """Compute the size of the shaking ``"force"``, or ``"moment"`` about the point (N,).

        Newtons or newton metres.
        """
        sizes: Array = np.linalg.norm(self.about[:, PARTS[part]], axis=1)
        return sizes

    def peak(self, part: str) -> float:
        """Compute the peak of the shaking ``"force"`` or ``"moment"``, N or N m."""
        return float(self.sizes(part).max(initial=0.0))

    def rms(self, part: str) -> float:
        """Compute the root mean square over time of the shaking ``"force"`` or ``"moment"``."""
        time = self.trajectory.time
        mean = np.trapezoid(self.sizes(part) ** 2, time) / (time[-1] - time[0])
        return float(np.sqrt(mean))

    def peak_range(self, part: str) -> tuple[float, float]:
        """Compute the range that holds the peak of the ``"force"`` or ``"moment"``, N or N m.

        A rounded table determines it up to the rounding; for exact motions both ends are equal.
        """
        if self.errors is None:
            return (peak := self.peak(part)), peak
        sizes, off = self.sizes(part), self.errors[1 if part == "force" else 0]
        return max(0.0, float((sizes - off).max())), float((sizes + off).max())

    def __repr__(self) -> str:
        """Two lines: the motion and its peaks."""
        force, moment = self.peak("force"), self.peak("moment")
        scale = float(self.inertia.max(initial=0.0))
        return repr_lines(
            f"Run: {self.trajectory!r}",
            f"shaking force {unit_text(force, 'N', '.3g', scale)}, shaking moment "
            f"{unit_text(moment, 'N m', '.3g', scale)}",
        )
