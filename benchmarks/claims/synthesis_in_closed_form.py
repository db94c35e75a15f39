"""Claim: a map of 3600 pantographs costs less than integrating 240 of them numerically.

Their motion without momentum has a closed form. The error is that of the turn of the tool,
beside numerical integration. Through three positions, four-bars are beside those of the motion
generation of pylinkage, which samples circle-point curves and knows no masses: times side by
side, and by how much both miss the positions.
"""

from __future__ import annotations

import math

import numpy as np

from balance.studies.synthesis.error_map import angle_error_map
from balance.studies.synthesis.four_bars import four_bars_through
from balance.studies.synthesis.momentum_integral import delta_at_link_turn
from balance.studies.synthesis.pantograph import PantographMasses, reduced_inertias
from balance.studies.synthesis.pivot_line import fixed_pivot_line
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.rr_chain import chain_from_three_positions

MASSES = PantographMasses(
    l2=0.05,
    l3=0.05,
    m1=0.12,
    m2=0.3,
    m3=0.15,
    m4=0.024,
    m5=0.067,
    m6=0.78,
    s3=0.097,
    s4=0.024,
    s5=0.25,
    inertia_1=1.6e-3,
    inertia_2=5e-3,
)
TWO = (Position(0.25, 0.1, 0.0), Position(0.178, 0.013, -0.2556))
THREE = (Position(0.0, 0.0, 0.0), Position(0.2, 0.1, 0.3), Position(0.3, 0.3, 0.6))
COUNT = 60


def integrate(turn: float) -> float:
    """Turn of the tool by a Runge-Kutta method."""
    from scipy.integrate import solve_ivp

    J1, J2, C = map(float, reduced_inertias(MASSES, 0.1, 0.25))

    def rate(angle: float, tool: np.ndarray) -> np.ndarray:
        c = C * np.cos(0.5 * math.pi + angle - tool)
        return -(J1 + c) / (J2 + c)

    found = solve_ivp(rate, (0.0, turn), [0.0], "DOP853", rtol=1e-12, atol=1e-13)
    return float(found.y[0, -1])


class SynthesisMap:
    """A map of 60 by 60 pantographs, beside four integrations for each column."""

    params = ((COUNT,),)
    claims = (("time_map", "time_integrations", 1.0), ("track_turn_error", 1e-10))

    def setup(self, count: int) -> None:
        """Prepare the line of pivots."""
        self.line = fixed_pivot_line(TWO, 0.1j)
        self.offsets = self.line.offsets_of_x(np.linspace(-0.03, 0.06, count))
        self.ratios = np.linspace(0.0, 0.8, count)

    def time_map(self, count: int) -> None:
        """The map and its zero contour, refined."""
        angle_error_map(TWO, self.line, MASSES, self.offsets, self.ratios)

    def time_integrations(self, count: int) -> None:
        """Four integrations for each column."""
        for turn in np.linspace(0.3, 1.2, 4 * count):
            integrate(float(turn))

    def track_turn_error(self, count: int) -> float:
        """Difference of the turn of the tool, radians."""
        inertias = reduced_inertias(MASSES, 0.1, 0.25)
        turns = np.linspace(0.3, 1.2, 5)
        ends = delta_at_link_turn(np.full(5, 0.5 * math.pi), turns, inertias)
        closed = turns - (ends - 0.5 * math.pi)
        return float(max(abs(closed[k] - integrate(float(turns[k]))) for k in range(5)))


class ThreePositions:
    """Mechanisms through three positions, beside pylinkage."""

    params = ((3,),)
    claims = (("track_position_error", 1e-9),)

    def setup(self, count: int) -> None:
        """Prepare the poses of the peer.

        Raises:
            NotImplementedError: pylinkage is not installed.
        """
        try:
            from pylinkage.synthesis import Pose, motion_generation
        except ImportError:
            raise NotImplementedError("pip install pylinkage") from None
        self.generate = motion_generation
        self.poses = [Pose(*each) for each in THREE]

    def time_pantograph(self, count: int) -> None:
        """The balanced pantograph of a constant ratio."""
        chain_from_three_positions(THREE, -0.5)

    def time_balanced_four_bars(self, count: int) -> None:
        """All balanced kites and antiparallelograms of a grid."""
        for kind in ("kite", "antiparallelogram"):
            four_bars_through(THREE, kind)

    def time_pylinkage(self, count: int) -> None:
        """Four-bars of pylinkage, without masses."""
        self.generate(self.poses)

    def track_position_error(self, count: int) -> float:
        """Largest distance of our couplers from the positions, metres."""
        found = [
            d for kind in ("kite", "antiparallelogram") for d in four_bars_through(THREE, kind)
        ]
        return max(each.error for each in found)

    def track_share_of_peer_error(self, count: int) -> float:
        """Largest change of a link of the peer's four-bars between the positions, metres."""
        return max(
            (_miss(each) for each in self.generate(self.poses).raw_solutions), default=0.0
        )


def _miss(solution) -> float:
    """Change of the lengths of crank and rocker when the coupler goes to the positions."""
    first, worst = THREE[0], 0.0
    pairs = (
        (solution.ground_pivot_a, solution.crank_pivot_b),
        (solution.ground_pivot_d, solution.coupler_pivot_c),
    )
    for base, tip in pairs:
        G, W = complex(*base), complex(*tip)
        for each in THREE[1:]:
            turn = np.exp(1j * (each.angle - first.angle))
            moved = each.point + turn * (W - first.point)
            worst = max(worst, abs(abs(moved - G) - abs(W - G)))
    return float(worst)
