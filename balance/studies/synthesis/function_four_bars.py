"""Four-bars whose rocker turns by given angles when the crank does (function generation).

With the base of length 1 from the crank to the rocker, crank and rocker a and c at angles φ and
ψ from it, and the coupler b, the loop closes if (Freudenstein's equation)

    K_1 cos ψ - K_2 cos φ + K_3 = cos(φ - ψ),

    K_1 = 1/a,    K_2 = 1/c,    K_3 = (a² - b² + c² + 1) / (2 a c).

It is linear in K. Only turns are given, from the first point to each other one, so both angles
at the first point are unknown as well: five unknowns.

- Three points leave both angles free: they are chosen on a grid, or given. A negative length
  is a link at the opposite angle.
- Four and five: seen from the rocker, the crank passes through positions, and the coupler is a
  link between two points that keep their distance (`circle_points`): from the tip of the
  rocker, which is the centre, to that of the crank, the circle point. The base is such a link
  too, and no solution.

Source: F. Freudenstein, Trans. ASME 77, 1955, pp. 853-861; inversion: J. M. McCarthy, G. S.
Soh, Geometric Design of Linkages, 2nd ed., 2011, chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.studies.synthesis.circle_points import cranks_through
from balance.studies.synthesis.general_four_bars import (
    FARTHEST,
    LEAST,
    MOST,
    SHORTEST,
    GeneralFourBar,
    Lengths,
    largest_transmission,
    merit,
)
from balance.studies.synthesis.positions import Position
from balance.support.csv_columns import read_columns
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

ComplexArray = NDArray[np.complex128]

# Angles of crank and of rocker at the first of three points, over half a turn: those of the
# other half have negative lengths.
STARTS = 48
# Largest change of the length of the coupler from point to point, over the longest link, and of
# the turn of the rocker, radians.
EXACT, TURNED = 1e-11, 1e-6


class FunctionPoint(NamedTuple):
    """Angles of crank and rocker, of which only differences count.

    Attributes:
        crank: radians, counter-clockwise.
        rocker: radians.
    """

    crank: float
    rocker: float


def function_four_bars(
    points: Sequence[FunctionPoint],
    *,
    start: tuple[float, float] | None = None,
    base: float = 1.0,
) -> tuple[GeneralFourBar, ...]:
    """Find four-bars whose rocker is at given angles when the crank is.

    Args:
        points: three to five; the angle of the crank rises or falls, by less than a turn.
        start: angles of crank and rocker from the base at the first of three points, radians.
        base: its length, metres; it lies on the x-axis, from the crank at the origin.

    Returns:
        At most 500 without defects, in the order of `general_four_bars`. Their tool is the tip
        of the rocker, and turns with it.

    Example:
        >>> from balance.studies.synthesis.function_four_bars import FunctionPoint
        >>> from balance.studies.synthesis.function_four_bars import function_four_bars
        >>> points = [FunctionPoint(0.0, 0.0), FunctionPoint(0.5, 0.2), FunctionPoint(1.1, 0.6)]
        >>> best = function_four_bars(points)[0]
        >>> [round(float(angle), 9) for angle in best.tool_angles()]
        [0.0, 0.2, 0.6]
    """
    beta, gamma = turns_of(points)
    if len(points) == 3:
        phi, psi = _list_starts() if start is None else np.array(start)[:, None]
        W, Z = solve_freudenstein(phi + beta[:, None], psi + gamma[:, None])
    else:
        W, Z = _tips_by_inversion(beta, gamma)
    return _without_defects(W, Z, beta, gamma, base)


def read_function(path: str | PathLike[str]) -> tuple[FunctionPoint, ...]:
    """Read a function from a table with the columns ``crank`` and ``rocker``.

    Args:
        path: a file of comma-separated values; radians, or as the heads say: ``crank [deg]``.

    Raises:
        FileError: it is no such table.
    """
    rows = read_columns(path, FunctionPoint._fields, fewest=1)
    return tuple(FunctionPoint(*map(float, row)) for row in rows)


def turns_of(points: Sequence[FunctionPoint]) -> tuple[Array, Array]:
    """Compute the turns β of the crank and γ of the rocker from the first point (n,)."""
    crank, rocker = (np.array(angles, dtype=np.float64) for angles in zip(*points, strict=True))
    return crank - crank[0], rocker - rocker[0]


def _list_starts() -> tuple[Array, Array]:
    """List the pairs of a grid of first angles (count,)."""
    angles = np.pi * (np.arange(STARTS) + 0.5) / STARTS
    phi, psi = np.meshgrid(angles, angles)
    return phi.ravel(), psi.ravel()


def solve_freudenstein(phi: Array, psi: Array) -> tuple[ComplexArray, ComplexArray]:
    """Solve Freudenstein's equation for K, of least squares for more than three points.

    Args:
        phi: angles of the crank from the base (points, count).
        psi: of the rocker.

    Returns:
        Tips of crank and rocker at the first point (count,), if the base goes from 0 to 1; not
        finite where there is no solution.
    """
    rows = np.stack([np.cos(psi), -np.cos(phi), np.ones_like(phi)], axis=-1)
    K = np.linalg.pinv(rows.swapaxes(0, 1)) @ np.cos(phi - psi).T[..., None]
    with np.errstate(all="ignore"):
        crank, rocker = 1.0 / K[:, 0, 0], 1.0 / K[:, 1, 0]
    return crank * np.exp(1j * phi[0]), 1.0 + rocker * np.exp(1j * psi[0])


def _tips_by_inversion(beta: Array, gamma: Array) -> tuple[ComplexArray, ComplexArray]:
    """Find both tips at the first point from the positions of the crank seen by the rocker."""
    bases = 1.0 - np.exp(-1j * gamma)
    relative = [
        Position(z.real, z.imag, turn)
        for z, turn in zip(bases.tolist(), (beta - gamma).tolist(), strict=True)
    ]
    couplers = cranks_through(relative)
    return couplers.moving, couplers.fixed


def _without_defects(
    W: ComplexArray, Z: ComplexArray, beta: Array, gamma: Array, base: float
) -> tuple[GeneralFourBar, ...]:
    """Make the four-bars without defects of tips of crank and rocker at the first point."""
    fits = np.isfinite(W) & np.isfinite(Z)
    W, Z = W[fits], Z[fits]
    tips = W * np.exp(1j * beta[:, None])
    ends = 1.0 + (Z - 1.0) * np.exp(1j * gamma[:, None])
    couplers = np.abs(ends - tips)
    lengths = Lengths(np.abs(W), couplers[0], np.abs(Z - 1.0), np.ones(len(W)))
    longest, shortest = np.max(lengths, axis=0), np.min(lengths, axis=0)
    signs = np.sign(((ends - tips) * (ends - 1.0).conj()).imag)
    transmission, _ = largest_transmission(lengths, np.angle(tips))
    fits = (signs == signs[0]).all(axis=0) & (np.ptp(couplers, axis=0) < EXACT * longest)
    fits &= (shortest > SHORTEST) & (longest < FARTHEST) & (transmission > LEAST)
    kept = np.flatnonzero(fits)
    ranks = rank_least_first(merit(transmission[kept], longest[kept]).tolist())
    four_bars = (
        place_function(complex(W[k]), complex(Z[k]), beta, gamma, base, float(transmission[k]))
        for k in kept[ranks][:MOST]
    )
    return tuple(each for each in four_bars if turns_as_asked(each, TURNED))


def place_function(
    W: complex, Z: complex, beta: Array, gamma: Array, base: float, transmission: float
) -> GeneralFourBar:
    """Make a four-bar of a length of the base whose tool is the tip of the rocker."""
    wanted = 1.0 + (Z - 1.0) * np.exp(1j * gamma)
    angles = np.angle(Z - 1.0) + gamma
    poses = zip((base * wanted).tolist(), angles.tolist(), strict=True)
    return GeneralFourBar(
        tuple(Position(z.real, z.imag, angle) for z, angle in poses),
        0j,
        complex(base),
        base * W,
        base * Z,
        tuple((np.angle(W) + beta).tolist()),
        transmission,
        tool_link="rocker",
    )


def turns_as_asked(four_bar: GeneralFourBar, within: float) -> bool:
    """Whether the rocker turns as asked within an angle, whole turns on the way counted."""
    wanted = np.array([each.angle for each in four_bar.positions])
    return bool(np.abs(four_bar.tool_angles() - (wanted - wanted[0])).max() < within)
