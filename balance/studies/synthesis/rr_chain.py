"""RR chains whose two links turn in a constant ratio, through two or three positions.

The first link turns about the fixed pivot G by β_i, the second one, the tool, by φ_i while the
moving pivot goes from W_1 to W_i. Both descriptions of W_i give one complex equation for each
position after the first, linear in G and W_1:

    (1 - e^(iβ_i)) G + (e^(iβ_i) - e^(iφ_i)) W_1 = t_i        β_i = k φ_i

with the displacement ``z → e^(iφ_i) z + t_i`` of the tool. Two positions leave a pivot free,
three leave none. Masses without coupling make ``J1 θ̇1 + J2 θ̇2`` vanish, so ``k = -J2/J1``.

Source: G. Becht, MSc thesis, TU Delft, 2020, chapter 3, Eqs. 12 to 16; J. M. McCarthy,
Geometric Design of Linkages, 2000 (the equation of the RR chain).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.motion.motion_tolerances import SYNTHESIS_SINGULAR
from balance.studies.synthesis.positions import (
    Displacement,
    Position,
    check_positions,
    displacements,
    size_of,
)
from kinematics.errors import SynthesisError, UsageError

Positions = Iterable[Sequence[float]]
# Largest size of the ratio of the turns, and inverse of the least.
LARGEST_RATIO = 1e6


@dataclass(frozen=True)
class RRChain:
    """Two links in series, revolute joints at both pivots, through positions of the tool.

    Attributes:
        positions: of the tool.
        fixed: the fixed pivot G, metres, inertial frame.
        moving: the moving pivot W_1 at the first position.
        link_turns: turn β_i of the first link from the first position to each, radians; 0
            first.
    """

    positions: tuple[Position, ...]
    fixed: complex
    moving: complex
    link_turns: tuple[float, ...]

    @property
    def tool_turns(self) -> tuple[float, ...]:
        """Turn φ_i of the tool from the first position to each, radians; 0 first."""
        return tuple(each.angle - self.positions[0].angle for each in self.positions)

    @property
    def length(self) -> float:
        """Distance of the pivots, metres."""
        return abs(self.moving - self.fixed)

    @property
    def reach(self) -> complex:
        """From the moving pivot to the point of the tool, at the first position."""
        return self.positions[0].point - self.moving

    @property
    def first_angle(self) -> float:
        """Angle θ1 of the first link at the first position, radians, inertial frame."""
        return cmath.phase(self.moving - self.fixed)

    def tool_points(
        self, link_turns: ArrayLike, tool_turns: ArrayLike
    ) -> NDArray[np.complex128]:
        """Compute the point of the tool for turns of both links from the first position.

        Args:
            link_turns: of the first link, radians.
            tool_turns: of the tool, radians.
        """
        first = np.exp(1j * np.asarray(link_turns)) * (self.moving - self.fixed)
        return np.asarray(self.fixed + first + np.exp(1j * np.asarray(tool_turns)) * self.reach)

    @property
    def error(self) -> float:
        """Largest distance of the tool from its positions, metres."""
        points = self.tool_points(self.link_turns, self.tool_turns)
        return float(np.abs(points - [each.point for each in self.positions]).max())


def check_ratio(ratio: float) -> float:
    """Check the ratio k of the turns of the first link and of the tool.

    Raises:
        UsageError: it is 0 or 1, not finite, or its size is above 1e6 or below 1e-6.
    """
    if not math.isfinite(ratio) or ratio in (0.0, 1.0):
        why = {0.0: "the first link stands still", 1.0: "both links are one body"}
        reason = why.get(ratio, "it is no finite number")
        raise UsageError(f"ratio k = {ratio:g}: {reason}; give another ratio of the turns")
    if not 1.0 / LARGEST_RATIO <= abs(ratio) <= LARGEST_RATIO:
        raise UsageError(
            f"ratio k = {ratio:g}: its size is not from {1.0 / LARGEST_RATIO:g} to "
            f"{LARGEST_RATIO:g}; give another ratio of the turns"
        )
    return ratio


def chain_from_fixed_pivot(positions: Positions, ratio: float, fixed: complex) -> RRChain:
    """Find the moving pivot of an RR chain through two positions.

    ``W_1 = (t - (1 - e^(ikφ)) G) / (e^(ikφ) - e^(iφ))``.

    Args:
        positions: two positions, see `check_positions`.
        ratio: k, turn of the first link over that of the tool.
        fixed: the fixed pivot G, metres, inertial frame.

    Returns:
        The chain.

    Raises:
        SynthesisError: no chain with such a pivot passes through the positions.
        UsageError: the ratio or a position is none.
    """
    poses, (step,), beta = _prepare(positions, ratio, 2)
    rotation = cmath.exp(1j * beta[1])
    divisor = rotation - step.rotation
    if abs(divisor) < SYNTHESIS_SINGULAR:
        raise SynthesisError(
            f"with k = {ratio:g} the tool does not turn against the first link",
            "give another ratio",
        )
    moving = (step.shift - (1.0 - rotation) * fixed) / divisor
    return _checked(RRChain(poses, fixed, moving, beta))


def chain_from_moving_pivot(positions: Positions, ratio: float, moving: complex) -> RRChain:
    """Find the fixed pivot of an RR chain through two positions.

    ``G = (t - (e^(ikφ) - e^(iφ)) W_1) / (1 - e^(ikφ))``.

    Args:
        positions: two positions, see `check_positions`.
        ratio: k, turn of the first link over that of the tool.
        moving: the moving pivot W_1 at the first position, metres, inertial frame.

    Returns:
        The chain.

    Raises:
        SynthesisError: no chain with such a pivot passes through the positions.
        UsageError: the ratio or a position is none.
    """
    poses, (step,), beta = _prepare(positions, ratio, 2)
    rotation = cmath.exp(1j * beta[1])
    if abs(1.0 - rotation) < SYNTHESIS_SINGULAR:
        raise SynthesisError(
            f"with k = {ratio:g} the first link makes whole turns only", "give another ratio"
        )
    fixed = (step.shift - (rotation - step.rotation) * moving) / (1.0 - rotation)
    return _checked(RRChain(poses, fixed, moving, beta))


def chain_from_three_positions(positions: Positions, ratio: float) -> RRChain:
    """Find the RR chain through three positions: two linear complex equations for G and W_1.

    Args:
        positions: three positions, see `check_positions`.
        ratio: k, turn of the first link over that of the tool.

    Returns:
        The chain; it is the only one.

    Raises:
        SynthesisError: no chain passes through the positions.
        UsageError: the ratio or a position is none.
    """
    poses, steps, beta = _prepare(positions, ratio, 3)
    rotations = np.exp(1j * np.array(beta[1:]))
    tool = np.array([step.rotation for step in steps])
    matrix = np.column_stack([1.0 - rotations, rotations - tool])
    sizes = np.linalg.svd(matrix, compute_uv=False)
    if sizes[-1] < SYNTHESIS_SINGULAR:
        raise SynthesisError(
            f"with k = {ratio:g} the equations of the three positions have no single solution",
            "give another ratio, or two positions",
        )
    fixed, moving = np.linalg.solve(matrix, [step.shift for step in steps])
    return _checked(RRChain(poses, complex(fixed), complex(moving), beta))


def _prepare(
    positions: Positions, ratio: float, count: int
) -> tuple[tuple[Position, ...], tuple[Displacement, ...], tuple[float, ...]]:
    """Check what is given; return positions, displacements and turns of the first link."""
    check_ratio(ratio)
    poses = check_positions(positions)
    if len(poses) != count:
        raise UsageError(f"{len(poses)} positions: give {count}")
    steps = displacements(poses)
    for k, step in enumerate(steps, 2):
        if step.turn == 0.0:
            raise SynthesisError(
                f"positions 1 and {k} have the same angle, so that no link would turn in a "
                "constant ratio",
                "give positions that differ in angle, or the nonlinear case",
            )
    return poses, steps, (0.0, *(ratio * step.turn for step in steps))


def _checked(chain: RRChain) -> RRChain:
    """Refuse a chain whose pivots coincide, as they do on a pole."""
    if chain.length < SYNTHESIS_SINGULAR * max(size_of(chain.positions), abs(chain.reach)):
        raise SynthesisError(
            "the pivots coincide: the chosen one is the pole of the displacement",
            "choose a pivot away from the pole",
        )
    return chain
