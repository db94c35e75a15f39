"""What a quiet motion minimises: a norm over time of the shaking force, the moment, or both."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from balance.motion.verification.shaking_wrench import move_wrenches
from kinematics.numerics.array_types import Array

Part = Literal["force", "moment", "both"]
Measure = Literal["rms", "peak"]


class QuietObjective(NamedTuple):
    """The size of the shaking along a motion: one number.

    The size at an instant is ``|F|``, N, ``|M|``, N m, or ``√(|F|² + |M|²/ℓ²)``, N; over time
    it is the root mean square or the peak.

    Attributes:
        part: ``"force"``, ``"moment"`` or ``"both"``.
        measure: ``"rms"`` or ``"peak"``.
        point: of the moment, metres, inertial frame (3,).
        length: ℓ, metres.
    """

    part: Part
    measure: Measure
    point: Array
    length: float

    @property
    def unit(self) -> str:
        """Unit of the size."""
        return "N m" if self.part == "moment" else "N"

    @property
    def rows(self) -> Array:
        """Matrix (m, 6) that takes a wrench about the inertial origin to what counts."""
        moved = move_wrenches(np.eye(6), self.point).T
        if self.part == "force":
            return moved[3:]
        if self.part == "moment":
            return moved[:3]
        return np.concatenate([moved[3:], moved[:3] / self.length])

    def value(self, time: Array, wrenches: Array) -> float:
        """Compute the size over time of wrenches (N, 6) about the inertial origin."""
        sizes = np.linalg.norm(wrenches @ self.rows.T, axis=1)
        return overall(self.measure, time, sizes)


def overall(measure: Measure, time: Array, sizes: Array) -> float:
    """Compute the root mean square over time, or the peak, of sizes (N,) at times (N,)."""
    if measure == "peak":
        return float(sizes.max())
    return float(np.sqrt(np.trapezoid(sizes**2, time) / (time[-1] - time[0])))


def time_weights(time: Array) -> Array:
    """Compute the weights (N,) of samples in a mean over time, by the trapezoidal rule."""
    step = np.diff(time)
    return 0.5 * (np.append(step, 0.0) + np.append(0.0, step)) / step.sum()
