"""Balanced four-bars whose coupler passes through four positions, or near more.

For a ratio r of base and crank and angles α_i of the crank, the crank tips A_i and directions
U_i of the coupler are known in units of the crank (`four_bars`). The tool is then at

    s A_i + t + a U_i        and turned by        arg U_i + c

with a similarity s, t and the place a, c of the tool on the coupler, in which the points are
linear: least squares give them (variable projection; G. H. Golub, V. Pereyra, 1973). What they
leave is a function of r and all α_i. It vanishes at single designs for four positions, and not
at all for more, of which the nearest design is sought. The search starts from angles α_i that
turn the coupler as the tool.

Source: four positions of a general four-bar, L. Burmester, 1888. A kite or an antiparallelogram
has one ratio instead of three, and the place of the tool is free.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import SYNTHESIS_MET
from balance.studies.synthesis.four_bars import (
    LARGEST,
    SMALLEST,
    Complex,
    FourBarDesign,
    crank_angles,
    place_four_bar,
)
from balance.studies.synthesis.mirrored_base import KIND, antiparallelograms_through
from balance.studies.synthesis.positions import Position, displacements, size_of
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

# Ratios of base and crank from which the search starts, and their bounds; masses exist from √2.
RATIOS = tuple(np.geomspace(1.45, 6.0, 16).tolist())
LOWEST, HIGHEST = 1.42, 12.0
# Starts that are refined; distance of the crank from a change point, radians.
STARTS, CLEAR = 24, 0.05
# What is left, over the size of the positions, from which a design is refined further.
NEARLY_MET = 1e-3
FINE = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
# Distance of pivots, over the size of the positions, up to which two designs are one.
SAME = 1e-3


def four_bars_near(positions: Sequence[Position], kind: str) -> tuple[FourBarDesign, ...]:
    """Find balanced four-bars whose coupler passes through or near four or more positions.

    ``Σ |x_i - point_i|² + L² (φ_i - angle_i)²`` is least, with the size L of the positions.

    Args:
        positions: four or more positions of the tool.
        kind: ``"kite"`` or ``"antiparallelogram"``.

    Returns:
        The designs: first those that meet all positions, without defects and with near pivots
        first; then the others, the nearest first.
    """
    fitting = _Fitting(kind, positions)
    size = fitting.size
    exact: list[FourBarDesign] = []
    near: list[FourBarDesign] = []
    if kind == KIND:
        exact = [
            each for each in antiparallelograms_through(positions) if _in_reach(each, size)
        ]
    for start in [] if exact else _starts(fitting):
        design = fitting.refine(start)
        if not _in_reach(design, size) or any(_same(design, x, size) for x in exact + near):
            continue
        (exact if design.miss <= SYNTHESIS_MET * size else near).append(design)
    ranks = rank_least_first([each.spread for each in exact])
    exact = sorted((exact[k] for k in ranks), key=lambda each: len(each.defects))
    ranks = rank_least_first([each.miss for each in near])
    return (*exact, *(near[k] for k in ranks))


def _starts(fitting: _Fitting) -> list[Array]:
    """Choose the ratios and crank angles of a grid that leave the least."""
    steps = displacements(fitting.positions)
    starts = [
        np.array([ratio, *angles])
        for ratio in RATIOS
        for angles in crank_angles(fitting.kind, ratio, steps)
    ]
    ranks = rank_least_first([float(np.linalg.norm(fitting.residual(x))) for x in starts])
    return [starts[k] for k in ranks[:STARTS]]


class _Fit(NamedTuple):
    """The best similarity and place of the tool for a ratio and crank angles.

    Attributes:
        scale: s; length of the crank, metres, and direction of the base.
        fixed: t, metres.
        points: of the tool (n,), metres.
        angles: of the tool (n,), radians.
        residual: what is left of the points and, in arcs of the size, of the angles (3 n,), m.
    """

    scale: complex
    fixed: complex
    points: Complex
    angles: Array
    residual: Array


class _Fitting:
    """Fits of a kind of four-bar to positions, as a function of its ratio and crank angles."""

    def __init__(self, kind: str, positions: Sequence[Position]) -> None:
        """Keep what all fits need."""
        self.kind, self.positions = kind, tuple(positions)
        self.size = size_of(positions)
        self._goal = np.array([each.point for each in positions])
        self._angles = np.array([each.angle for each in positions])
        self._backwards = np.exp(-1j * self._angles)

    def fit(self, x: Array) -> _Fit:
        """Fit the similarity and the place of the tool; x is the ratio and the crank angles."""
        A, B = place_four_bar(self.kind, x[0], x[1:])
        U = (B - A) / np.abs(B - A)
        M = np.column_stack([A, np.ones(len(A)), U])
        parts = np.linalg.lstsq(M, self._goal, rcond=1e-10)[0]
        apart = M @ parts - self._goal
        turned = U * self._backwards
        misturned = np.angle(turned * np.conj(turned.sum()))
        return _Fit(
            complex(parts[0]),
            complex(parts[1]),
            apart + self._goal,
            misturned + self._angles,
            np.concatenate([apart.real, apart.imag, self.size * misturned]),
        )

    def residual(self, x: Array) -> Array:
        """Compute what the best fit leaves (3 n,), metres."""
        return self.fit(x).residual

    def refine(self, start: Array) -> FourBarDesign:
        """Find the ratio and crank angles next to a start that leave the least."""
        from scipy.optimize import least_squares

        ends = np.sort(math.copysign(1.0, start[1]) * np.array([CLEAR, math.pi - CLEAR]))
        low, high = np.full(start.size, ends[0]), np.full(start.size, ends[1])
        low[0], high[0] = LOWEST, HIGHEST
        bounds = low, high
        solution = least_squares(
            self.residual, np.clip(start, low, high), bounds=bounds, max_nfev=30
        )
        if np.abs(solution.fun).max() <= NEARLY_MET * self.size:
            # Steps without bounds settle faster; they start so near that they keep to them.
            x = least_squares(self.residual, solution.x, method="lm", max_nfev=200, **FINE).x
        else:
            x = least_squares(self.residual, solution.x, bounds=bounds, max_nfev=60).x
        fit = self.fit(x)
        first = Position(fit.points[0].real, fit.points[0].imag, float(fit.angles[0]))
        angles = tuple(x[1:].tolist())
        return FourBarDesign(
            self.kind, self.positions, float(x[0]), angles, fit.scale, fit.fixed, first
        )


def _in_reach(design: FourBarDesign, size: float) -> bool:
    """Whether the crank has a length, and no pivot is far away."""
    return SMALLEST * size < abs(design.scale) and design.spread < LARGEST * size


def _same(design: FourBarDesign, other: FourBarDesign, size: float) -> bool:
    """Whether two designs have the same pivots."""
    pairs = zip(design.pivots().values(), other.pivots().values(), strict=True)
    return all(abs(a - b) <= SAME * size for a, b in pairs)
