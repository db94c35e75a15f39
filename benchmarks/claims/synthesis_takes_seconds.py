"""Claim: a synthesis with masses of steel takes at most 1 s for three positions, 5 s for five.

Mechanisms, their masses, file and confirmation, with compiled kernels, of the processor
(``--processor-time``). The error is the number of mechanisms that are not confirmed, or do not
meet their positions.
"""

from __future__ import annotations

import math

import numpy as np

from balance import Synthesis, synthesize
from balance.studies.synthesis.four_bars import place_four_bar

THREE = (
    (0.3, 0.1, math.radians(11.0)),
    (0.1, 0.4, math.radians(-40.0)),
    (-0.1, 0.5, math.radians(-70.0)),
)
CRANK_ANGLES = np.array([0.4, 0.7, 1.1, 1.3, 1.9])


def positions_of(tips: np.ndarray, ends: np.ndarray, tool: complex) -> list[tuple]:
    """Positions of a tool on a coupler from ``tips`` to ``ends``."""
    way = (ends - tips) / np.abs(ends - tips)
    points = tips + tool * way
    return list(zip(points.real, points.imag, np.unwrap(np.angle(way)), strict=True))


def general_positions() -> list[tuple]:
    """Five positions of the coupler of a four-bar with links of 0.4, 0.9, 0.8 and 1 m."""
    A = 0.4 * np.exp(1j * CRANK_ANGLES)
    gap = np.abs(1.0 - A)
    along = (0.9**2 - 0.8**2 + gap**2) / (2.0 * gap)
    B = A + (along + 1j * np.sqrt(0.9**2 - along**2)) * (1.0 - A) / gap
    return positions_of(A, B, 0.3 + 0.5j)


def kite_positions() -> list[tuple]:
    """Five positions of the coupler of a kite."""
    A, B = place_four_bar("kite", 2.3, np.array([0.4, 0.8, 1.3, 1.9, 2.6]))
    return positions_of(A, B, 0.2 - 0.7j)


def random_positions(count: int, seed: int) -> list[tuple]:
    """Points in a square of 1 m, and angles within ±1 rad."""
    rng = np.random.default_rng([count, seed])
    points, angles = rng.uniform(-0.5, 0.5, (count, 2)), rng.uniform(-1.0, 1.0, count)
    return [(*point, angle) for point, angle in zip(points, angles, strict=True)]


class ThroughThree:
    """Three positions, each kind of mechanism."""

    params = (("pantograph", 3), ("four-bar", 3), ("geared-four-bar", 3))
    claims = (("time_synthesis", 1.0), ("track_unconfirmed", 0.0))
    repetitions = 3

    def setup(self, kind: str, count: int) -> None:
        """Take the positions, and compile."""
        self.positions = self.positions_for(kind, count)
        self.answer = self.synthesis(kind, count)

    def positions_for(self, kind: str, count: int) -> list[tuple]:
        """The positions of a kind."""
        return list(THREE)

    def synthesis(self, kind: str, count: int) -> Synthesis:
        """Synthesise with the default matter, steel."""
        return synthesize(self.positions, kind=kind)

    def time_synthesis(self, kind: str, count: int) -> None:
        """From positions to confirmed files."""
        self.answer = self.synthesis(kind, count)

    def track_unconfirmed(self, kind: str, count: int) -> int:
        """Mechanisms that are not confirmed or miss; one if there is none."""
        mechanisms = self.answer.mechanisms
        return sum(not each.good for each in mechanisms) if mechanisms else 1


class ThroughThreeAtRandom(ThroughThree):
    """Random tasks: of thirty, those whose least matter takes the most steps."""

    params = tuple(("geared-four-bar", seed) for seed in (204, 212, 215, 219, 221, 227))

    def positions_for(self, kind: str, seed: int) -> list[tuple]:
        """Points in a square of 1 m, and angles within ±1 rad."""
        return random_positions(3, seed)


class ThroughThreeInTime(ThroughThree):
    """Three points at given angles of the crank: those of the manual, and random ones.

    Of those the last is a slow one: no matter fits its first set of rotors.
    """

    params = tuple(("timed", seed) for seed in (-1, 0, 2, 4, 7))
    claims = (("time_synthesis", 3.0), ("track_unconfirmed", 0.0))

    def positions_for(self, kind: str, seed: int) -> list[tuple]:
        """Points in a square of 1 m; steps of the crank from 0.3 to 1.2 rad."""
        if seed < 0:
            angles = np.radians([10.0, 40.0, 75.0])
            return [(0.3, 0.1, angles[0]), (0.2, 0.3, angles[1]), (0.0, 0.4, angles[2])]
        rng = np.random.default_rng([3, seed])
        points, steps = rng.uniform(-0.5, 0.5, (3, 2)), rng.uniform(0.3, 1.2, 2)
        angles = np.cumsum([0.0, *steps])
        return [(*point, angle) for point, angle in zip(points, angles, strict=True)]

    def synthesis(self, kind: str, count: int) -> Synthesis:
        """The tool turns as it may."""
        return synthesize(self.positions, kind="geared-four-bar", timed=True)


class ThroughFive(ThroughThree):
    """Five positions of the coupler of a known four-bar."""

    params = (("four-bar", 5), ("geared-four-bar", 5))
    claims = (("time_synthesis", 5.0), ("track_unconfirmed", 0.0))

    def positions_for(self, kind: str, count: int) -> list[tuple]:
        """Those of a kite, or of another four-bar."""
        return kite_positions() if kind == "four-bar" else general_positions()


class StackThroughMany(ThroughThree):
    """A stack of three four-bars, decoupled, through random positions."""

    params = tuple(("stack", count) for count in (3, 5, 10))
    claims = (("time_synthesis", 5.0), ("track_unconfirmed", 0.0))

    def positions_for(self, kind: str, count: int) -> list[tuple]:
        """As of the random tasks above."""
        return random_positions(count, 0)


class ThroughFiveInTime(ThroughFive):
    """Five points of the coupler of a known four-bar, at given angles of its crank."""

    params = (("timed", 5),)

    def positions_for(self, kind: str, count: int) -> list[tuple]:
        """The points of the other four-bar; the angles are those of its crank."""
        points = [place[:2] for place in general_positions()]
        return [(x, y, a) for (x, y), a in zip(points, CRANK_ANGLES, strict=True)]

    def synthesis(self, kind: str, count: int) -> Synthesis:
        """The tool turns as it may."""
        return synthesize(self.positions, kind="geared-four-bar", timed=True)
