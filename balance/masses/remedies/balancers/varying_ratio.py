"""The varying ratio of a wheel to a crank, and the pitch curves or the cam that drive it.

A wheel of inertia J on the base turns by φ(u) while the crank turns by u. With the angular
momentum h(u) of the linkage about the wheel's axis, for a unit rate of the crank, the sum
vanishes at the ratio

    i(u) = dφ/du = -h(u) / J            φ(u) = ∫ i du

Two gears with centres c apart roll on each other at the radii

    r1 = c |i| / (1 + |i|)     r2 = c / (1 + |i|)     r1 + r2 = c,   r1 du = r2 |dφ|

External gears turn oppositely, as a negative ratio asks for; a positive ratio needs a pair of
equal wheels behind them. Where the ratio changes its sign no gears roll: a cam with a track
moves the wheel by φ(u).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from balance.motion.motion_tolerances import RELATION_RESIDUAL
from balance.support.csv_text import csv_table
from kinematics.numerics.array_types import Array

TURN = 2.0 * np.pi
# Least size of a ratio over its greatest at which gears still roll: their radii go with it.
LEAST_RATIO = 0.01


@dataclass(frozen=True, eq=False)
class PitchCurves:
    """Pitch curves of two gears, in the frames of the gears.

    At ``u = 0`` both frames have their axes along the line from the centre of the first gear
    to that of the second. The gears touch on this line, so the point that touches is at the
    angle -u in the first frame, and at ``π - ψ`` in the second, turned by ``ψ = -∫ |i| du``.

    Attributes:
        distance: of the centres, c, metres.
        u: angle of the first gear (N,), radians.
        turned: angle ψ of the second gear (N,), radians.
        first: radius of the first gear at the point that touches, r1 (N,), metres.
        second: radius of the second gear there, r2 (N,), metres.
        reversed: whether the ratio is positive, so that equal wheels must reverse the second.
        closed: whether the curve of the second gear closes after whole turns of the first.
    """

    distance: float
    u: Array
    turned: Array
    first: Array
    second: Array
    reversed: bool
    closed: bool

    @property
    def points(self) -> Array:
        """Points of both curves in the frames of their gears (2, N, 2), metres."""
        angles = np.stack([-self.u, np.pi - self.turned])
        radii = np.stack([self.first, self.second])
        return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=-1)

    @property
    def rolled(self) -> tuple[float, float]:
        """Lengths ``∫ r1 du`` and ``∫ r2 |dψ|`` that roll on each other, metres."""
        return (
            float(np.trapezoid(self.first, self.u)),
            float(np.trapezoid(self.second, -self.turned)),
        )

    def columns(self) -> dict[str, Array]:
        """List the columns of a table: angles, radii and points of both curves."""
        first, second = self.points
        return {
            "u": self.u,
            "r1": self.first,
            "x1": first[:, 0],
            "y1": first[:, 1],
            "turned": self.turned,
            "r2": self.second,
            "x2": second[:, 0],
            "y2": second[:, 1],
        }


@dataclass(frozen=True, eq=False)
class VaryingRatio:
    """The ratio of a wheel to a crank over the motion of the crank.

    Attributes:
        crank: name of the crank.
        turns: whether the table is one full turn, after which all repeats.
        inertia: of the wheel about its axis, J, kg m².
        u: displacement of the crank from the reference pose (N,), radians or metres.
        ratio: i(u) (N,).
        slope: di/du (N,).
        angle: φ(u) of the wheel, from 0 at the first sample (N,), radians.
    """

    crank: str
    turns: bool
    inertia: float
    u: Array
    ratio: Array
    slope: Array
    angle: Array

    @property
    def signed(self) -> bool:
        """Whether the ratio keeps its sign, and is nowhere too small for gears."""
        low, high = float(self.ratio.min()), float(self.ratio.max())
        return low * high > 0.0 and min(abs(low), abs(high)) >= LEAST_RATIO * max(
            abs(low), abs(high)
        )

    @property
    def cycle(self) -> float:
        """Angle of the wheel over the whole table, radians."""
        return float(self.angle[-1])

    def pitch_curves(self, distance: float) -> PitchCurves | None:
        """Compute the pitch curves of gears; None if the ratio changes its sign.

        Args:
            distance: of the centres, metres.
        """
        if not self.signed:
            return None
        size, turned = np.abs(self.ratio), -np.abs(self.angle)
        share = TURN / abs(self.cycle)
        closed = self.turns and abs(share - round(share)) <= RELATION_RESIDUAL * share
        return PitchCurves(
            distance,
            self.u,
            turned,
            distance * size / (1.0 + size),
            distance / (1.0 + size),
            bool(self.ratio[0] > 0.0),
            closed,
        )

    def columns(self) -> dict[str, Array]:
        """List the columns of a table: crank, ratio, its slope, angle of the wheel."""
        return {"u": self.u, "ratio": self.ratio, "slope": self.slope, "angle": self.angle}


def integrate(x: Array, slope: Array, change: Array) -> Array:
    """Integrate a function from its values and derivatives at samples; 0 at the first.

    ``Δ/2 (f₀ + f₁) + Δ²/12 (f₀' - f₁')`` on each interval, exact for cubic functions.

    Args:
        x: samples (N,).
        slope: the function f (N,).
        change: its derivative f' (N,).
    """
    step = np.diff(x)
    part = 0.5 * step * (slope[1:] + slope[:-1]) + step**2 / 12.0 * (change[:-1] - change[1:])
    return np.concatenate([[0.0], np.cumsum(part)])


class CsvFiles(Mapping[str, bytes]):
    """Files of comma-separated values by name, each written when it is asked for."""

    def __init__(self, tables: Mapping[str, Mapping[str, Array]]) -> None:
        """Keep the columns.

        Args:
            tables: columns of numbers (N,) by their name, by the name of the file.
        """
        self._tables = tables

    def __getitem__(self, name: str) -> bytes:
        """Write a file, with a line of names."""
        columns = self._tables[name]
        return csv_table([*columns], [*columns.values()])

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the files."""
        return iter(self._tables)

    def __len__(self) -> int:
        """Count the files."""
        return len(self._tables)
