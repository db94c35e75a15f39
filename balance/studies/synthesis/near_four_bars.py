"""Four-bars near more points than any passes: least squares over their sizes.

In units of the crank, with the base from 0 to g, the crank at ``φ + β_j`` and coupler and
rocker b and c, the tips A_j and B_j and the directions ``U_j = (B_j - A_j)/b`` follow from four
numbers: φ, b, c, g. The rest has least squares of its own (variable projection; G. H. Golub,
V. Pereyra, 1973):

- a point of the coupler is at ``s A_j + t + q U_j`` at given turns β_j of the crank, with three
  complex numbers in which it is linear;
- a rocker that turns by γ_j is at the angles ``ψ + γ_j``, with a first angle ψ.

Starts are the points of a grid of the four numbers of which least is left, and steps lead from
each to the next minimum. None of these need be the least of all: another four-bar may be
nearer. Transmission angles below their bound have a price, so that the linkage does not fold.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.studies.synthesis.function_four_bars import (
    FunctionPoint,
    place_function,
    turns_as_asked,
    turns_of,
)
from balance.studies.synthesis.general_four_bars import (
    FARTHEST,
    LEAST,
    SHORTEST,
    GeneralFourBar,
    Lengths,
    largest_cosine,
    merit,
)
from balance.studies.synthesis.positions import Position, size_of
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

ComplexArray = NDArray[np.complex128]

# Starts: first angles of the crank, and lengths of coupler, rocker and base over the crank.
ANGLES, LENGTHS = 16, (0.6, 1.2, 2.4, 4.8)
# The best of them, which are refined; evaluations of each; bounds of the lengths.
STARTS, EVALUATIONS, LONGEST = 40, 60, 40.0
# Cosine of the transmission angle that is paid for, and the price, over the size.
HIGHEST, PRICE = math.cos(1.05 * LEAST), 1.0
# What is left, over the size, from which a four-bar is refined further, and how.
NEARLY_MET = 1e-3
FINE = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
# Distance of tips, in cranks, up to which two four-bars are one; and the part of the error, or
# of the least size that counts, up to which two are equally near.
SAME, EQUAL = 1e-5, (1e-3, 1e-6)
# Error of a rocker, radians, from which it has turned by a whole turn more or less.
TURN = 1.0
REMARK = (
    f"least squares from the best {STARTS} of {2 * ANGLES * len(LENGTHS) ** 3} starts: another "
    "four-bar may be nearer"
)
"""What a result says of the search."""


class _Loops(NamedTuple):
    """Four-bars in units of their cranks.

    Attributes:
        tips: of the cranks (points, count).
        ends: tips of the rockers.
        lengths: of the links (count,).
        cosine: largest cosine of the transmission angle on the way (count,).
    """

    tips: ComplexArray
    ends: ComplexArray
    lengths: Lengths
    cosine: Array

    @property
    def coupler_directions(self) -> ComplexArray:
        """U (points, count)."""
        return (self.ends - self.tips) / self.lengths.coupler


Leftover = Callable[[_Loops], Array]
"""What the best fit leaves of loops, over the size (rows, count)."""


def _place_loops(x: Array, side: float, beta: Array) -> _Loops:
    """Place four-bars of a first angle and logarithms of three lengths (4, count)."""
    lengths = Lengths(np.ones(x.shape[1]), *np.exp(x[1:]))
    _, b, c, g = lengths
    tips = np.exp(1j * (x[0] + beta[:, None]))
    gap = np.abs(g - tips)
    along = (b**2 - c**2 + gap**2) / (2.0 * gap)
    beside = side * np.sqrt(np.maximum(b**2 - along**2, 0.0))
    ends = tips + (along + 1j * beside) * (g - tips) / gap
    sign = math.copysign(1.0, beta[-1])
    span = np.full(x.shape[1], abs(beta[-1]))
    return _Loops(tips, ends, lengths, largest_cosine(lengths, sign * x[0], span))


def near_timed_four_bars(positions: Sequence[Position]) -> tuple[GeneralFourBar, ...]:
    """Find four-bars whose point is near places when the crank is at angles.

    ``Σ |x_j - point_j|²`` is least next to each start.

    Args:
        positions: six and more places of the point; see `timed_four_bars`.

    Returns:
        Those without defects, the nearest first.
    """
    points = np.array([each.point for each in positions])
    size, centre = size_of(positions), points.mean()
    goal = ((points - centre) / size)[:, None]
    beta = np.array([each.angle - positions[0].angle for each in positions])

    def leftover(loops: _Loops) -> Array:
        rest = _fit_point(loops, goal)[1]
        return np.concatenate([rest.real, rest.imag])

    four_bars, spreads = [], []
    for loop in _search(leftover, beta):
        s, t, q = (complex(part[0]) for part in _fit_point(loop, goal)[0])
        # Points that coincide are met by a linkage without size.
        if abs(s) * min(float(each[0]) for each in loop.lengths) <= SHORTEST:
            continue
        four_bar = _make_timed(loop, (size * s, centre + size * t, size * q), positions, beta)
        if four_bar.spread < FARTHEST * size:
            four_bars.append(four_bar)
            spreads.append(four_bar.spread / size)
    return _nearest_first(four_bars, spreads, size)


def _fit_point(loops: _Loops, goal: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Fit s, t and q (3, count), and return what they leave (points, count)."""
    ones = np.ones_like(loops.tips)
    rows = np.stack([loops.tips, ones, loops.coupler_directions], axis=-1).swapaxes(0, 1)
    parts = np.linalg.pinv(rows) @ goal
    return parts[..., 0].T, (rows @ parts)[..., 0].T - goal


def _make_timed(
    loop: _Loops,
    fit: tuple[complex, complex, complex],
    positions: Sequence[Position],
    beta: Array,
) -> GeneralFourBar:
    """Make the four-bar of a loop and of the place of the point on its coupler."""
    s, t, q = fit
    A, B = complex(loop.tips[0, 0]), complex(loop.ends[0, 0])
    point = s * A + t + q * complex(loop.coupler_directions[0, 0])
    start = float(np.angle(s * A))
    four_bar = GeneralFourBar(
        tuple(positions),
        t,
        t + s * float(loop.lengths.base[0]),
        t + s * A,
        t + s * B,
        tuple((start + beta).tolist()),
        math.acos(min(1.0, float(loop.cosine[0]))),
        start=Position(point.real, point.imag, 0.0),
    )
    angles = zip(positions, four_bar.tool_angles().tolist(), strict=True)
    poses = tuple(Position(each.x, each.y, angle) for each, angle in angles)
    return replace(four_bar, positions=poses)


def near_function_four_bars(
    points: Sequence[FunctionPoint], *, base: float = 1.0
) -> tuple[GeneralFourBar, ...]:
    """Find four-bars whose rocker is near given angles when the crank is at others.

    ``Σ (ψ_j - ψ - γ_j)²`` is least next to each start.

    Args:
        points: six and more; see `function_four_bars`.
        base: its length, metres.

    Returns:
        Those without defects, the nearest first.
    """
    beta, gamma = turns_of(points)
    backwards = np.exp(-1j * gamma)[:, None]

    def leftover(loops: _Loops) -> Array:
        turned = (loops.ends - loops.lengths.base) / loops.lengths.rocker * backwards
        return np.angle(turned * np.conj(turned.sum(axis=0)))

    four_bars, spreads = [], []
    for loop in _search(leftover, beta):
        g = float(loop.lengths.base[0])
        links = [float(each[0]) / g for each in loop.lengths]
        W, Z = complex(loop.tips[0, 0]) / g, complex(loop.ends[0, 0]) / g
        wanted = 1.0 + (Z - 1.0) * np.exp(-1j * float(leftover(loop)[0, 0]))
        angle = math.acos(min(1.0, float(loop.cosine[0])))
        four_bar = place_function(W, wanted, beta, gamma, base, angle)
        start = Position(base * Z.real, base * Z.imag, float(np.angle(Z - 1.0)))
        four_bar = replace(four_bar, rocker_tip=base * Z, start=start)
        fits = SHORTEST < min(links) and max(links) < FARTHEST
        if fits and turns_as_asked(four_bar, TURN):
            four_bars.append(four_bar)
            spreads.append(max(links))
    return _nearest_first(four_bars, spreads, 1.0)


def _search(leftover: Leftover, beta: Array) -> list[_Loops]:
    """Find loops without defects of which least is left next to starts."""
    minima = []
    for side in (1.0, -1.0):
        x = _list_starts()
        cost = np.linalg.norm(_residual(leftover, _place_loops(x, side, beta)), axis=0)
        ranks = rank_least_first(cost.tolist())[: STARTS // 2]
        minima += [(_refine(leftover, x[:, k], side, beta), side) for k in ranks]
    kept: list[_Loops] = []
    for x, side in minima:
        loop = _place_loops(x[:, None], side, beta)
        if loop.cosine[0] < math.cos(LEAST) and all(
            _measure_distance(loop, each) > SAME for each in kept
        ):
            kept.append(loop)
    return kept


def _measure_distance(loop: _Loops, other: _Loops) -> float:
    """Compute how far the tips of two loops and their bases are apart, in cranks."""
    base = float(np.abs(loop.lengths.base - other.lengths.base)[0])
    tips = np.abs(loop.tips[0] - other.tips[0]) + np.abs(loop.ends[0] - other.ends[0])
    return base + float(tips[0])


def _nearest_first(
    four_bars: Sequence[GeneralFourBar], spread: Sequence[float], size: float
) -> tuple[GeneralFourBar, ...]:
    """Sort by the root mean square of the errors; equally near ones as exact four-bars.

    Args:
        spread: of each, for `merit`.
        size: metres, or a radian.
    """
    transmission = np.array([each.transmission for each in four_bars])
    ranks = rank_least_first(merit(transmission, np.array(spread)).tolist())
    ranked = [four_bars[k] for k in ranks]
    errors = [each.root_mean_square / size for each in ranked]
    return tuple(ranked[k] for k in rank_least_first(errors, *EQUAL))


def _list_starts() -> Array:
    """List the grid of first angles and logarithms of lengths (4, count)."""
    angles = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    grid = np.meshgrid(angles, *[np.log(LENGTHS)] * 3, indexing="ij")
    return np.array([each.ravel() for each in grid])


def _residual(leftover: Leftover, loops: _Loops) -> Array:
    """Add the price of small transmission angles to what is left (rows + 1, count)."""
    price = PRICE * np.maximum(loops.cosine - HIGHEST, 0.0)
    return np.vstack([leftover(loops), price])


def _refine(leftover: Leftover, start: Array, side: float, beta: Array) -> Array:
    """Go from a start to the next minimum (4,)."""
    from scipy.optimize import least_squares

    def residual(x: Array) -> Array:
        return _residual(leftover, _place_loops(x[:, None], side, beta))[:, 0]

    high = np.array([np.inf, *[math.log(LONGEST)] * 3])
    x = least_squares(residual, start, bounds=(-high, high), max_nfev=EVALUATIONS, ftol=1e-10)
    if np.abs(x.fun).max() > NEARLY_MET:
        return np.asarray(x.x)
    # Steps without bounds settle faster; they start so near that they keep to them.
    return np.asarray(least_squares(residual, x.x, method="lm", max_nfev=200, **FINE).x)
