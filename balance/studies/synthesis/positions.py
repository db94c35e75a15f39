"""Positions of a tool in the plane, and the displacements between them.

Points are complex numbers x + i y, in metres, in the inertial frame. A displacement maps
``z`` to ``e^(iφ) z + t``; its pole is the point that it leaves where it is.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from balance.motion.motion_tolerances import SYNTHESIS_SINGULAR
from kinematics.errors import SynthesisError, UsageError

# Least and largest number of positions: two leave a pivot free, three leave none, four are met
# by single four-bars, and more are approached.
FEWEST, MOST = 2, 20
FARTHEST = 1e6
"""Largest coordinate, metres."""

Points = TypeVar("Points", complex, NDArray[np.complex128])


class Position(NamedTuple):
    """A position of the tool in the plane.

    Attributes:
        x: of its point, metres, inertial frame.
        y: of its point, metres, inertial frame.
        angle: of its frame, counter-clockwise from the x-axis, radians. The tool turns from
            one position to the next by the difference of the angles as they are given.
    """

    x: float
    y: float
    angle: float

    @property
    def point(self) -> complex:
        """The point as a complex number."""
        return complex(self.x, self.y)


class Displacement(NamedTuple):
    """Displacement of the tool from the first position to another, ``z → e^(iφ) z + t``.

    Attributes:
        turn: φ, radians, inertial frame.
        shift: t, metres.
    """

    turn: float
    shift: complex

    @property
    def rotation(self) -> complex:
        """``e^(iφ)``."""
        return cmath.exp(1j * self.turn)

    @property
    def pole(self) -> complex | None:
        """The point that stays, ``t / (1 - e^(iφ))``; None for a translation."""
        divisor = 1.0 - self.rotation
        return None if abs(divisor) < SYNTHESIS_SINGULAR else self.shift / divisor

    def move(self, point: Points) -> Points:
        """Move points of the tool from the first position to the other."""
        return self.rotation * point + self.shift


def check_positions(positions: Iterable[Sequence[float]]) -> tuple[Position, ...]:
    """Check positions of a tool.

    Args:
        positions: two to twenty, each x and y in metres and the angle in radians.

    Returns:
        The positions.

    Raises:
        UsageError: there are fewer or more, or a number is not finite or too large.
        SynthesisError: two of them coincide.
    """
    poses = tuple(Position(*map(float, each)) for each in positions)
    if not FEWEST <= len(poses) <= MOST:
        raise UsageError(f"{len(poses)} positions: give {FEWEST} to {MOST}")
    for k, each in enumerate(poses, 1):
        if not all(abs(value) <= FARTHEST for value in each):
            raise UsageError(f"position {k} is not of finite numbers up to {FARTHEST:g}")
    size = size_of(poses)
    for k, pose in enumerate(poses):
        for j, other in enumerate(poses[:k]):
            apart = abs(pose.point - other.point) > SYNTHESIS_SINGULAR * size
            turned = abs(cmath.exp(1j * (pose.angle - other.angle)) - 1.0) > SYNTHESIS_SINGULAR
            if not (apart or turned):
                raise SynthesisError(
                    f"positions {j + 1} and {k + 1} coincide", "give positions that differ"
                )
    return poses


def displacements(positions: Sequence[Position]) -> tuple[Displacement, ...]:
    """Compute the displacements from the first position to each other one.

    ``φ_i = angle_i - angle_1`` and ``t_i = d_i - e^(iφ_i) d_1``.
    """
    first, *others = positions
    steps = []
    for each in others:
        turn = each.angle - first.angle
        shift = each.point - cmath.exp(1j * turn) * first.point
        steps.append(Displacement(turn, shift))
    return tuple(steps)


def size_of(positions: Sequence[Position]) -> float:
    """Compute the largest distance between points of positions, metres; 1 if all coincide."""
    first = positions[0].point
    size = max(math.hypot(*_parts(each.point - first)) for each in positions)
    return size or 1.0


def _parts(z: complex) -> tuple[float, float]:
    """Real and imaginary part."""
    return z.real, z.imag
