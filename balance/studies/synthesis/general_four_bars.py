"""General four-bars whose coupler passes through two to five positions.

Two cranks of `circle_points` and the tool make a four-bar. With the angle α of the crank from
the base the diagonal from its tip to the base of the rocker is ``d² = a² + g² - 2 a g cos α``,
and the transmission angle μ between coupler and rocker follows from
``2 b c cos μ = b² + c² - d²``. On the way the crank goes through an interval of α, in which d
is extreme at the ends, and where crank and base are in line. A four-bar is kept if

- the crank meets the positions in their order within one turn (order);
- μ stays away from 0 and π on the way, so that the linkage never folds (branch, circuit); and
  its sign is that of the assembly at all positions;
- its links and pivots are neither too short nor too far.

Source: J. M. McCarthy, G. S. Soh, Geometric Design of Linkages, 2nd ed., 2011, chapters 2, 5.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.studies.synthesis.circle_points import Cranks, cranks_through
from balance.studies.synthesis.four_bars import CouplerMotion
from balance.studies.synthesis.positions import Position, displacements, size_of
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg.ties import rank_least_first

ComplexArray = NDArray[np.complex128]

# Least transmission angle on the way, and that from which size decides.
LEAST, AMPLE = math.radians(10.0), math.radians(35.0)
# Shortest link and farthest pivot, in sizes of the positions.
SHORTEST, FARTHEST = 0.05, 20.0
# Most designs that are returned.
MOST = 500
# Angles of the crank at which the turn of the tool is followed.
SAMPLES = 200


@dataclass(frozen=True)
class GeneralFourBar(CouplerMotion):
    """A four-bar whose coupler carries the tool through positions.

    Attributes:
        positions: of the tool.
        crank_base: pivot on the base, metres, inertial frame.
        rocker_base: of the rocker.
        crank_tip: pivot on the coupler at the first position.
        rocker_tip: of the rocker.
        crank_angles: of the crank at each position, radians, inertial frame; monotone.
        transmission: least angle between coupler and rocker, or its supplement, on the way.
        tool_link: ``"coupler"``, or ``"rocker"`` if its tip is the tool, and turns with it.
        start: pose of the tool at the first angle of the crank; None: the first position.
    """

    positions: tuple[Position, ...]
    crank_base: complex
    rocker_base: complex
    crank_tip: complex
    rocker_tip: complex
    crank_angles: tuple[float, ...]
    transmission: float
    tool_link: str = "coupler"
    start: Position | None = None

    kind = "geared four-bar"
    defects = ()

    @property
    def first(self) -> Position:
        """Pose of the tool at the first angle of the crank."""
        return self.start or self.positions[0]

    @property
    def numbers(self) -> dict[str, float]:
        """Lengths of crank and base, metres, and the transmission angle, radians.

        If the rocker is the tool, those of all links and the angles of crank and rocker from
        the base at the first position; if it is near its positions, the root mean square of
        its errors.
        """
        numbers = super().numbers | {"transmission_angle": self.transmission}
        if self.tool_link == "rocker":
            rocker = self.rocker_tip - self.rocker_base
            numbers |= {
                "coupler": abs(self.rocker_tip - self.crank_tip),
                "rocker": abs(rocker),
                "crank_start": self.crank_angles[0],
                "rocker_start": cmath.phase(rocker),
            }
        if self.start is None:
            return numbers
        name = "rms_distance" if self.tool_link == "coupler" else "rms_angle"
        return numbers | {name: self.root_mean_square}

    @property
    def root_mean_square(self) -> float:
        """Of the distances from positions, metres, or of the errors of a rocker, radians."""
        errors = self._distances if self.tool_link == "coupler" else self._angle_errors
        return float(np.sqrt(np.mean(errors**2)))

    def meets(self, within: float) -> bool:
        """Whether it misses no position by more than metres, or the rocker by radians."""
        return (
            super().meets(within)
            if self.tool_link == "coupler"
            else (self.angle_error <= within)
        )

    def pivots(self, index: int = 0) -> dict[str, complex]:
        """Compute the pivots at a position, metres, inertial frame."""
        A, B = self._tips(self.crank_angles[index])
        return {
            "crank_base": self.crank_base,
            "rocker_base": self.rocker_base,
            "crank_tip": complex(A),
            "rocker_tip": complex(B),
        }

    def tool_points(self, crank_angles: ArrayLike) -> ComplexArray:
        """Compute the point of the tool for angles of the crank."""
        A, B = self._tips(crank_angles)
        arm = (self.first.point - self.crank_tip) / (self.rocker_tip - self.crank_tip)
        return np.asarray(A + arm * (B - A))

    def _tips(self, crank_angles: ArrayLike) -> tuple[ComplexArray, ComplexArray]:
        """Compute both tips for angles of the crank, in the assembly of the first position."""
        G, H, W, Z = self.crank_base, self.rocker_base, self.crank_tip, self.rocker_tip
        A = G + abs(W - G) * np.exp(1j * np.asarray(crank_angles, dtype=np.float64))
        coupler, rocker, diagonal = abs(Z - W), abs(Z - H), np.abs(H - A)
        along = (coupler**2 - rocker**2 + diagonal**2) / (2.0 * diagonal)
        side = math.copysign(1.0, ((H - W).conjugate() * (Z - W)).imag)
        beside = side * np.sqrt(np.maximum(coupler**2 - along**2, 0.0))
        return A, np.asarray(A + (along + 1j * beside) * (H - A) / diagonal)

    def tool_turns(self, crank_angles: ArrayLike) -> ComplexArray:
        """Compute ``e^(iθ)`` of the angle of the tool for angles of the crank."""
        A, B = self._tips(crank_angles)
        from_tip = B - A, self.rocker_tip - self.crank_tip
        from_base = B - self.rocker_base, self.rocker_tip - self.rocker_base
        moved, first = from_tip if self.tool_link == "coupler" else from_base
        return np.asarray(moved / first * cmath.exp(1j * self.first.angle))

    def tool_angles(self) -> Array:
        """Compute the turn of the tool from the first angle of the crank to each, radians.

        Whole turns on the way count.
        """
        alpha = np.array(self.crank_angles)
        way = np.linspace(alpha[0], alpha[-1], SAMPLES)
        turned = np.unwrap(np.angle(self.tool_turns(way)))
        parts = (alpha - alpha[0]) / (alpha[-1] - alpha[0])
        near = np.interp(parts, np.linspace(0.0, 1.0, SAMPLES), turned - turned[0])
        turns = np.angle(self.tool_turns(alpha) * np.exp(-1j * turned[0]))
        return np.asarray(turns + 2.0 * np.pi * np.round((near - turns) / (2.0 * np.pi)))


def general_four_bars(
    positions: Sequence[Position],
    *,
    fixed: complex | None = None,
    moving: complex | None = None,
) -> tuple[GeneralFourBar, ...]:
    """Find four-bars without defects whose coupler passes through positions.

    Args:
        positions: two to five positions of the tool.
        fixed: pivot of the crank on the base, for two positions; metres, inertial frame.
        moving: or pivot of the crank on the coupler, at the first position.

    Returns:
        At most 500: those whose transmission angle keeps 35° first, the smallest first among
        them; then the others, those with the largest transmission angle first.
    """
    positions = tuple(positions)
    cranks = cranks_through(positions, fixed=fixed, moving=moving)
    rockers = cranks
    if fixed is not None or moving is not None:
        rockers = cranks_through(positions)
    return pair_cranks(positions, cranks, rockers)


def pair_cranks(
    positions: tuple[Position, ...], cranks: Cranks, rockers: Cranks
) -> tuple[GeneralFourBar, ...]:
    """Make the four-bars without defects of cranks and rockers, in the order above."""
    pairs = _judge_pairs(positions, cranks, rockers)
    return tuple(
        GeneralFourBar(
            positions,
            complex(cranks.fixed[i]),
            complex(rockers.fixed[j]),
            complex(cranks.moving[i]),
            complex(rockers.moving[j]),
            tuple(angles),
            transmission,
        )
        for i, j, angles, transmission in zip(*pairs, strict=True)
    )


def merit(transmission: Array, spread: Array) -> Array:
    """Rate four-bars, the best least: of ample transmission the small ones, then the others.

    Args:
        transmission: least transmission angle, radians (n,).
        spread: largest distance of a pivot from the tool, in sizes of the positions (n,), below
            `FARTHEST`; infinite for a four-bar that counts among the others.
    """
    ample = (transmission > AMPLE) & np.isfinite(spread)
    # No transmission angle is above π/2: the others rate `FARTHEST` and more.
    return np.where(ample, spread, FARTHEST * (1.0 + 0.5 * math.pi - transmission))


class _Pairs(NamedTuple):
    """Pairs of cranks that make four-bars without defects."""

    cranks: list[int]
    rockers: list[int]
    angles: list[list[float]]
    transmission: list[float]


def _judge_pairs(positions: tuple[Position, ...], cranks: Cranks, rockers: Cranks) -> _Pairs:
    """Judge all pairs of a crank and a rocker, the best first."""
    size, steps = size_of(positions), displacements(positions)
    G, W = (part[:, None] for part in cranks)
    H, Z = (part[None, :] for part in rockers)
    tips = np.stack([W, *(step.move(W) for step in steps)])
    ends = np.stack([Z, *(step.move(Z) for step in steps)])
    a, b, c, g = np.abs(W - G), np.abs(Z - W), np.abs(Z - H), np.abs(H - G)
    links = [np.broadcast_to(each, b.shape) for each in (a, b, c, g)]
    spread = np.max([np.abs(z - positions[0].point) + 0.0 * b for z in (G, W, H, Z)], axis=0)
    fits = (np.min(links, axis=0) > SHORTEST * size) & (spread < FARTHEST * size)
    signs = np.sign(((ends - tips) * (ends - H).conj()).imag)
    fits &= (signs == signs[0]).all(axis=0)
    i, j = np.nonzero(fits)
    if not i.size:
        return _Pairs([], [], [], [])
    lengths = Lengths(*(each[i, j] for each in links))
    alpha = np.angle((tips[:, i, 0] - G[i, 0]) / (H[0, j] - G[i, 0]))
    best, sign = largest_transmission(lengths, alpha)
    kept = np.flatnonzero(best > LEAST)
    key = merit(best[kept], spread[i, j][kept] / size)
    kept = kept[rank_least_first(key.tolist())][:MOST]
    turned = _from_first(alpha[:, kept], sign[kept])
    start = np.angle(tips[0, i[kept], 0] - G[i[kept], 0])
    return _Pairs(
        i[kept].tolist(), j[kept].tolist(), (start + turned).T.tolist(), best[kept].tolist()
    )


class Lengths(NamedTuple):
    """Lengths of crank, coupler, rocker and base (n,)."""

    crank: Array
    coupler: Array
    rocker: Array
    base: Array


def largest_transmission(lengths: Lengths, alpha: Array) -> tuple[Array, Array]:
    """Compute the least transmission angle on the way, in the better direction of the crank.

    Args:
        lengths: of the links (n,).
        alpha: angles of the crank from the base at the positions (p, n).

    Returns:
        Radians (n,), -1 where the crank cannot go through the positions so; and the direction,
        1 or -1.
    """
    ways = [_transmission(lengths, alpha, sign) for sign in (1.0, -1.0)]
    return np.maximum(*ways), np.where(ways[0] >= ways[1], 1.0, -1.0)


def _from_first(alpha: Array, sign: Array | float) -> Array:
    """Compute the turns of a crank from the first position in a direction (p, n), within 2π."""
    return np.asarray(sign * np.mod(sign * (alpha - alpha[0]), 2.0 * np.pi))


def _transmission(lengths: Lengths, alpha: Array, sign: float) -> Array:
    """Compute the least transmission angle if the crank turns in a direction.

    Returns:
        Radians (n,); -1 where the order of the positions is another, or the linkage folds.
    """
    turned = sign * _from_first(alpha, sign)
    ordered = (np.diff(turned, axis=0) > 0.0).all(axis=0)
    cosine = largest_cosine(lengths, sign * alpha[0], turned[-1])
    angle = np.arccos(np.minimum(cosine, 1.0))
    return np.where(ordered & (cosine < 1.0), angle, -1.0)


def largest_cosine(lengths: Lengths, start: Array, span: Array) -> Array:
    """Compute the largest ``|cos μ|`` on the way of a crank; 1 and more if the linkage folds.

    Args:
        lengths: of the links (n,).
        start: first angle of the crank from the base, radians (n,).
        span: what it turns from there, positive (n,).
    """
    a, b, c, g = lengths
    cosines = [np.cos(start), np.cos(start + span)]
    for at, cosine in ((0.0, 1.0), (np.pi, -1.0)):
        passed: Flags = np.mod(at - start, 2.0 * np.pi) <= span
        cosines.append(np.where(passed, cosine, cosines[0]))
    diagonal = a**2 + g**2 - 2.0 * a * g * np.stack(cosines)
    return np.asarray(np.abs((b**2 + c**2 - diagonal) / (2.0 * b * c)).max(axis=0))
