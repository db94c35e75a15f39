"""Limits of the inputs of a plan: positions, velocities, accelerations, jerks, torques."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from balance.motion.verification.joint_limits import drive_limits, joint_limits
from kinematics.error_text import did_you_mean
from kinematics.errors import UsageError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

Limit = float | Mapping[str, float] | None
"""A limit of all inputs, of inputs by name, or none."""

# Kinds of the excitation of the base at a frequency, and of a pose that is missed, which have
# no limits of their own.
EXCITATION, POSE = "excitation", "pose"
# Names of derivatives of positions, in order, and of torques.
KINDS = ("position", "velocity", "acceleration", "jerk", "torque")
TORQUE = 4


class InputLimits(NamedTuple):
    """Least and largest values of the inputs, SI units; infinite where there is no limit.

    Attributes:
        lower: of each kind of `KINDS` (5, inputs).
        upper: likewise.
    """

    lower: Array
    upper: Array

    @property
    def spans(self) -> Array:
        """Sizes that violations are compared with (5, inputs)."""
        with np.errstate(invalid="ignore", over="ignore"):
            width = self.upper - self.lower
        middle = np.where(np.isfinite(width), width, 1.0)
        spans = np.where(np.isfinite(self.upper), np.abs(self.upper), 1.0)
        spans[0] = np.maximum(middle[0], 1e-9)
        return spans

    @property
    def has_jerk(self) -> bool:
        """Whether a jerk is limited."""
        return bool(np.isfinite(self.upper[3]).any())

    def excess(self, kind: int, values: Array) -> Array:
        """Compute how far values (N, inputs) are beyond the limits, over the limits (inputs,).

        Args:
            kind: index in `KINDS`.
        """
        above = np.maximum(values - self.upper[kind], self.lower[kind] - values)
        with np.errstate(over="ignore"):  # beyond a limit next to zero by any factor
            return np.asarray(above.max(axis=0) / self.spans[kind])

    def tightened(self, excess: Array) -> InputLimits:
        """Return limits that are closer by parts (5, inputs) of their spans."""
        change = excess * self.spans
        return InputLimits(self.lower + change, self.upper - change)


def input_limits(
    linkage: Linkage,
    velocity: Limit = None,
    acceleration: Limit = None,
    jerk: Limit = None,
    torque: Limit = None,
    file: bool = True,
) -> InputLimits:
    """Collect the limits of the inputs, those of the file unless others are given.

    Args:
        linkage: the linkage.
        velocity: largest speed of every input, or by name, rad/s and m/s.
        acceleration: largest acceleration, rad/s² and m/s².
        jerk: largest jerk, rad/s³ and m/s³.
        torque: largest torque or force, N m and N.
        file: whether limits of the file count.

    Raises:
        UsageError: a name is that of no input, or a limit is not above 0.
    """
    inputs = linkage.positions_of(linkage.inputs)
    count = len(linkage.inputs)
    lower, upper = np.full((5, count), -np.inf), np.full((5, count), np.inf)
    if file:
        lower[0], upper[0] = joint_limits(linkage)[:, inputs]
        upper[1], upper[TORQUE] = (limit[inputs] for limit in drive_limits(linkage))
    for kind, given in enumerate((velocity, acceleration, jerk, torque), 1):
        if given is None:
            continue
        values = given if isinstance(given, Mapping) else dict.fromkeys(linkage.inputs, given)
        for name, value in values.items():
            if name not in linkage.inputs:
                raise UsageError(
                    f"limit of {KINDS[kind]}: '{name}' is no input"
                    f"{did_you_mean(name, linkage.inputs)}; "
                    f"the inputs are {', '.join(linkage.inputs)}"
                )
            if not value > 0.0:
                raise UsageError(f"limit of {KINDS[kind]} of {name}: must be above 0")
            upper[kind, linkage.inputs.index(name)] = value
    lower[1:] = -upper[1:]
    return InputLimits(lower, upper)


class LimitExceeded(NamedTuple):
    """A limit that no motion was found to keep.

    Attributes:
        kind: one of `KINDS`, `EXCITATION` or `POSE`.
        joint: name of the input; of an excitation, the frequency in words; of a pose, its
            number.
        limit: its limit, SI units; of positions, the upper one.
        excess: by which part of the limit the best motion exceeds it.
    """

    kind: str
    joint: str
    limit: float
    excess: float

    @property
    def words(self) -> str:
        """The limit, in words."""
        if self.kind == EXCITATION:
            share = number_text(self.excess, ".2g")
            return f"the base is excited at {self.joint}, by {share} of the shaking at best"
        if self.kind == POSE:
            share = number_text(self.excess, ".2g")
            return f"{self.joint} is missed, by {share} of the size of the motion at best"
        return (
            f"the {self.kind} of {self.joint} exceeds its limit {number_text(self.limit)} by "
            f"{number_text(self.excess, '.2g')} of it at best"
        )


def worst_limit(linkage: Linkage, limits: InputLimits, excess: Array) -> LimitExceeded:
    """Name the limit that is exceeded most.

    Args:
        excess: by kind and input, over the limits (5, inputs).
    """
    kind, k = divmod(int(np.argmax(excess)), excess.shape[1])
    return LimitExceeded(
        KINDS[kind], linkage.inputs[k], float(limits.upper[kind, k]), float(excess[kind, k])
    )
