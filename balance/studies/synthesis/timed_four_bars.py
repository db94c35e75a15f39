"""Four-bars that lead a point of the coupler through places at given angles of the crank.

Path generation with prescribed timing. From the first place to place j the crank turns by β_j,
which is given, and the coupler by γ_j, which is not. The vectors W of the crank and Z from its
tip to the point of the tool, both at the first place, lead the point by

    δ_j = W (e^(iβ_j) - 1) + Z (e^(iγ_j) - 1).

With ``r_j = (e^(iβ_j) - 1) / (e^(iβ_2) - 1)``, ``ε_j = δ_j - r_j δ_2`` and ``ζ = 1/Z`` this is

    e^(iγ_j) = 1 + r_j (e^(iγ_2) - 1) + ε_j ζ:

for a turn γ_2 every further place puts ζ on a circle. Three places leave γ_2 and a point of one
circle free; four leave γ_2, and two circles meet in up to two points; for five the third circle
goes through such a point at single γ_2. The crank and all turns of the coupler are then known,
and the rocker is any crank of those positions (`circle_points`).

Source: G. N. Sandor, A. G. Erdman, Advanced Mechanism Design, vol. 2, 1984, chapter 3; J. M.
McCarthy, G. S. Soh, Geometric Design of Linkages, 2nd ed., 2011, chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.studies.synthesis.circle_points import Cranks, cranks_through
from balance.studies.synthesis.general_four_bars import (
    FARTHEST,
    MOST,
    SHORTEST,
    GeneralFourBar,
    merit,
    pair_cranks,
)
from balance.studies.synthesis.positions import Position, size_of
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.ties import rank_least_first

ComplexArray = NDArray[np.complex128]

# Turns γ_2 that are tried, by the number of places; those of the other circle for three.
TURNS = {3: 36, 4: 360, 5: 3600}
# Most cranks for which rockers are sought, by the number of places: each costs up to 0.2 s.
CRANKS = {3: 12, 4: 12, 5: 100}
# Largest distance of their pivots from the point, over the size of the places, for three and
# four places: cranks of all distances up to it are tried.
NEAR = 3.0
# Steps of Newton's method, many where two turns γ_2 nearly coincide; what is left when it ends,
# and at most; how far two dyads differ at least, all over the size.
STEPS, EXACT, LEFT, APART = 40, 1e-15, 1e-12, 1e-7
# Shortest link over the longest one, from which a four-bar of ample transmission comes first.
EVEN = 0.25


class _Dyads(NamedTuple):
    """Cranks with the point of the tool, in units of the size of the places.

    Attributes:
        crank: W (count,).
        arm: Z (count,).
        turns: γ_j of the coupler from the first place to each other one (places - 1, count).
    """

    crank: ComplexArray
    arm: ComplexArray
    turns: Array

    def take(self, chosen: IntArray) -> _Dyads:
        """Take some of them."""
        return _Dyads(self.crank[chosen], self.arm[chosen], self.turns[:, chosen])


def timed_four_bars(positions: Sequence[Position]) -> tuple[GeneralFourBar, ...]:
    """Find four-bars whose point of the tool is at places when the crank is at angles.

    Args:
        positions: three to five places of the point; their angles are those of the crank,
            which rise or fall by less than a turn. Only their differences count.

    Returns:
        At most 500 without defects, in the order of `general_four_bars`, but those with a link
        that is less than a quarter of another one after all others of ample transmission: their
        links turn fast, and take much matter. Their positions have the angles of the tool,
        which is in line with the x-axis at the first.

    Example:
        >>> from balance.studies.synthesis.positions import Position
        >>> from balance.studies.synthesis.timed_four_bars import timed_four_bars
        >>> places = [Position(0.3, 0.1, 0.0), Position(0.2, 0.3, 0.5), Position(0.0, 0.4, 1.1)]
        >>> best = timed_four_bars(places)[0]
        >>> abs(complex(best.tool_points(best.crank_angles[0] + 1.1)) - 0.4j) < 1e-9
        True
    """
    places = np.array([each.point for each in positions])
    size = size_of(positions)
    turned = np.array([each.angle - positions[0].angle for each in positions[1:]])
    dyads = _dyads((places[1:] - places[0]) / size, np.asarray(np.exp(1j * turned) - 1.0))
    four_bars: list[GeneralFourBar] = []
    for W, Z, turns in zip(dyads.crank, dyads.arm, dyads.turns.T, strict=True):
        tip = places[:1] - size * Z
        angles = (0.0, *turns.tolist())
        poses = tuple(
            Position(z.real, z.imag, angle)
            for z, angle in zip(places.tolist(), angles, strict=True)
        )
        four_bars += pair_cranks(poses, Cranks(tip - size * W, tip), cranks_through(poses))
    transmission = np.array([each.transmission for each in four_bars])
    spread = np.array([each.spread if _is_even(each) else np.inf for each in four_bars])
    ranks = rank_least_first(merit(transmission, spread / size).tolist())
    return tuple(_at_given_angles(four_bars[k], turned) for k in ranks[:MOST])


def _is_even(four_bar: GeneralFourBar) -> bool:
    """Whether no link is much shorter than another one."""
    G, H, W, Z = four_bar.pivots().values()
    links = abs(W - G), abs(Z - W), abs(Z - H), abs(H - G)
    return min(links) > EVEN * max(links)


def _at_given_angles(four_bar: GeneralFourBar, turned: Array) -> GeneralFourBar:
    """Put the crank at the given turns β_j, and count whole turns of the tool on the way."""
    start = four_bar.crank_angles[0]
    four_bar = replace(four_bar, crank_angles=(start, *(start + turned).tolist()))
    poses = zip(four_bar.positions, four_bar.tool_angles().tolist(), strict=True)
    return replace(
        four_bar, positions=tuple(Position(each.x, each.y, angle) for each, angle in poses)
    )


def _dyads(shifts: ComplexArray, rotated: ComplexArray) -> _Dyads:
    """Find cranks for shifts δ_j of the point and ``e^(iβ_j) - 1`` of the crank."""
    count = len(shifts) + 1
    with np.errstate(all="ignore"):
        c, zeta = _second_turns(shifts, rotated, count)
        ratios = rotated / rotated[0]
        bases = shifts - ratios * shifts[0]
        turns = np.angle(1.0 + np.multiply.outer(ratios, c) + np.multiply.outer(bases, zeta))
        arm = 1.0 / zeta
        dyads = _Dyads((shifts[0] - arm * c) / rotated[0], arm, turns)
        spread = np.maximum(np.abs(arm), np.abs(arm + dyads.crank))
        fits = (np.abs(dyads.crank) > SHORTEST) & (spread < FARTHEST)
    kept = np.flatnonzero(fits)
    ranks = rank_least_first(spread[kept].tolist())
    if count < 5:
        ranks = ranks[: int(np.sum(spread[kept] < NEAR))]
        ranks = ranks[:: len(ranks) // CRANKS[count] + 1]
    return _settle(shifts, rotated, dyads.take(kept[ranks]), CRANKS[count])


def _second_turns(
    shifts: ComplexArray, rotated: ComplexArray, count: int
) -> tuple[ComplexArray, ComplexArray]:
    """Choose turns of the coupler to the second place: ``e^(iγ_2) - 1`` and ζ."""
    steps = TURNS[count]
    around = np.exp(2j * np.pi * (np.arange(steps) + 0.5) / steps)
    c = around - 1.0
    ratios = (rotated / rotated[0])[1:, None]
    bases = (shifts[1:] - ratios[:, 0] * shifts[0])[:, None]
    centres, radii = -(1.0 + ratios * c) / bases, 1.0 / np.abs(bases)
    if count == 3:
        zeta = centres[0][:, None] + radii[0] * around
        return np.repeat(c, steps), zeta.ravel()
    apart = centres[1] - centres[0]
    along = (radii[0] ** 2 - radii[1] ** 2 + np.abs(apart) ** 2) / (2.0 * np.abs(apart))
    beside = np.sqrt(radii[0] ** 2 - along**2)
    zetas = [centres[0] + (along + 1j * s * beside) * apart / np.abs(apart) for s in (1, -1)]
    if count == 4:
        return np.concatenate([c, c]), np.concatenate(zetas)
    starts = [_near_third_circle(zeta, centres[2], float(radii[2, 0])) for zeta in zetas]
    at = np.concatenate(starts)
    return c[at], np.concatenate([zeta[k] for zeta, k in zip(zetas, starts, strict=True)])


def _near_third_circle(zeta: ComplexArray, centres: ComplexArray, radius: float) -> IntArray:
    """Find where ζ crosses a circle from one turn γ_2 to the next, or ends at one."""
    beyond = np.abs(zeta - centres) - radius
    after = np.roll(beyond, -1)
    crosses = (beyond * after <= 0.0) | (np.isfinite(beyond) & ~np.isfinite(after))
    crosses |= np.isfinite(beyond) & ~np.isfinite(np.roll(beyond, 1))
    return np.flatnonzero(crosses)


def _settle(shifts: ComplexArray, rotated: ComplexArray, dyads: _Dyads, most: int) -> _Dyads:
    """Refine cranks by Newton's method, and keep different ones that lead the point."""
    kept: list[tuple[complex, complex, Array]] = []
    for W, Z, turns in zip(dyads.crank, dyads.arm, dyads.turns.T, strict=True):
        W, Z, turns, error = _newton(shifts, rotated, complex(W), complex(Z), turns)
        new = all(abs(W - other[0]) + abs(Z - other[1]) > APART for other in kept)
        if error < LEFT * (1.0 + abs(W) + abs(Z)) and SHORTEST < abs(W) < FARTHEST and new:
            kept.append((W, Z, turns))
        if len(kept) == most:
            break
    cranks, arms = (np.array([each[k] for each in kept], dtype=np.complex128) for k in (0, 1))
    angles = np.array([each[2] for each in kept]).reshape(len(kept), len(shifts)).T
    return _Dyads(cranks, arms, angles)


def _newton(
    shifts: ComplexArray, rotated: ComplexArray, W: complex, Z: complex, turns: Array
) -> tuple[complex, complex, Array, float]:
    """Refine a crank by steps of least length; return it and what is left of the shifts."""
    for step in range(STEPS + 1):
        e = np.exp(1j * turns)
        left = W * rotated + Z * (e - 1.0) - shifts
        error = float(np.abs(left).max())
        if step == STEPS or not EXACT < error < FARTHEST:
            break
        J = np.column_stack(
            [rotated, 1j * rotated, e - 1.0, 1j * (e - 1.0), np.diag(1j * Z * e)]
        )
        real = np.linalg.lstsq(
            np.vstack([J.real, J.imag]), -np.concatenate([left.real, left.imag]), rcond=1e-13
        )[0]
        W, Z, turns = W + complex(*real[:2]), Z + complex(*real[2:4]), turns + real[4:]
    return W, Z, turns, error
