"""Points and weights on which a free beam shakes its mount in no low mode.

A beam is carried at points ξ_i, and the mount follows the weighted sum Σ W_i v(ξ_i) of its
deflections. It equals the mean deflection in a mode ψ if Σ W_i ψ(ξ_i) = 0, because free modes
have no mean. Weights add up to 1; points and weights are symmetric, so that antisymmetric modes
need no condition. With n points, the first n - 1 symmetric modes can be met: a Gauss quadrature
for the functions 1, ψ1, ψ3, …
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from balance.motion.flexible.free_beam_modes import (
    FLEX_SCHEMA,
    mode_numbers,
    mode_shape,
    mode_slope,
)
from balance.support.result_files import WithPicture
from kinematics.errors import LinkageError, UsageError
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, first_names, repr_lines, size_text

MOST_POINTS = 40
MOST_STEPS = 60
SUPPORT_RESIDUAL = 1e-13
"""Largest weighted sum of a mode at supports that count as converged."""

STATIC_POINT = (3.0 - 6.0**0.5) / 2.0
"""Two supports at ± this ξ: a uniform load moves the centre of mass least."""


class Bar(NamedTuple):
    """A bar of a whippletree: two points carried at its ends, a pivot between them.

    Attributes:
        ends: ξ of the points at its ends, the nearer to the middle first.
        pivot: ξ of its pivot.
        arms: distances of the ends from the pivot, over the length of the beam.
        weight: sum of the weights of the points that it carries.
    """

    ends: tuple[float, float]
    pivot: float
    arms: tuple[float, float]
    weight: float


@dataclass(frozen=True, eq=False)
class SupportPoints(WithPicture):
    """Supports of a free beam.

    Attributes:
        points: ξ from -½ to ½, ascending; shape (n,).
        weights: W, of sum 1; shape (n,).
        modes: numbers of the symmetric modes whose weighted sum vanishes.
        residual: largest weighted sum of these modes.
        bars: the whippletree of the half ξ > 0: each bar joins the next point to the pivot of
            the bar before it.
        hinge: ξ of the pivot of the last bar (of the outer point, if there is no bar): where
            the half is joined to other links.
    """

    picture_maker = "flexible_pictures:supports_picture"

    points: Array
    weights: Array
    modes: tuple[int, ...]
    residual: float
    bars: tuple[Bar, ...]
    hinge: float

    def __repr__(self) -> str:
        """Number of points, modes, and where the halves are joined to other links."""
        modes = first_names([str(mode) for mode in self.modes]) or "none"
        return repr_lines(
            f"SupportPoints: {count_noun(len(self.points), 'point')}, hinges at "
            f"±{self.hinge:.9f} of the length",
            f"silent symmetric modes: {modes} (residual {size_text(self.residual)})",
        )

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/flex.schema.json``."""
        return {
            "schema": FLEX_SCHEMA,
            "result": "supports",
            "points": self.points.tolist(),
            "weights": self.weights.tolist(),
            "modes": list(self.modes),
            "residual": self.residual,
            "bars": [
                bar._asdict() | {"ends": list(bar.ends), "arms": list(bar.arms)}
                for bar in self.bars
            ],
            "hinge": self.hinge,
            "static_point": STATIC_POINT,
        }


def support_points(count: int) -> SupportPoints:
    """Compute supports that keep the first ``count - 1`` symmetric modes off the mount.

    Newton's method follows the solution of R(x) = (1 - τ) R(x0) from τ = 0 at evenly spread
    points to τ = 1.

    Args:
        count: number of points, from 1 to 40.

    Raises:
        UsageError: the count is out of range.
        LinkageError: the continuation does not converge.

    Example:
        >>> from balance.motion.flexible.support_points import support_points
        >>> [round(float(xi), 6) for xi in support_points(2).points]
        [-0.275842, 0.275842]
    """
    if not 1 <= count <= MOST_POINTS:
        raise UsageError(f"{count} supports: give a number from 1 to {MOST_POINTS}")
    half, odd = count // 2, count % 2
    start = (np.arange(half) + (1.0 if odd else 0.5)) / (count + 0.2 * odd)
    waves = mode_numbers(2 * count - 1)[0 : 2 * count - 2 : 2]
    unknown = np.concatenate([start, np.full(half, 1.0 / count)])
    unknown = unknown if odd else unknown[:-1]
    unknown = _continue(unknown, half, waves) if count > 1 else unknown
    xi, weights, centre = _unpack(unknown, half, odd)
    residual = np.abs(_residual(unknown, half, waves)[0]).max(initial=0.0)
    middle = [0.0] if odd else []
    bars = _whippletree(xi, weights)
    return SupportPoints(
        np.array([*-xi[::-1], *middle, *xi]),
        np.array([*weights[::-1], *([centre] if odd else []), *weights]),
        tuple(range(1, 2 * count - 2, 2)),
        float(residual),
        bars,
        bars[-1].pivot if bars else float(xi.max(initial=0.0)),
    )


def static_deflection(xi: float) -> float:
    """Compute the mean deflection of a beam on two supports under a uniform load, in q l⁴ / EI.

    1/320 - ξ²/8 + ξ³/3 - ξ⁴/12; its least value, 1.276e-4, is at `STATIC_POINT`.

    Args:
        xi: ξ, distance of each support from the middle, in lengths of the beam.

    Example:
        >>> from balance.motion.flexible.support_points import STATIC_POINT, static_deflection
        >>> round(1e4 * static_deflection(STATIC_POINT), 3)
        1.276
    """
    return 1.0 / 320.0 - xi**2 / 8.0 + xi**3 / 3.0 - xi**4 / 12.0


def _unpack(unknown: Array, half: int, odd: int) -> tuple[Array, Array, float]:
    """Split unknowns into points ξ > 0, their weights, and the weight of the middle."""
    xi = unknown[:half]
    if odd:
        weights = unknown[half:]
        return xi, weights, float(1.0 - 2.0 * weights.sum())
    weights = np.append(unknown[half:], 0.5 - unknown[half:].sum())
    return xi, weights[:half], 0.0


def _residual(unknown: Array, half: int, waves: Array) -> tuple[Array, Array]:
    """Compute the weighted sums of the symmetric modes (n - 1,), and their Jacobian."""
    odd = int(unknown.size == 2 * half)
    xi, weights, centre = _unpack(unknown, half, odd)
    shapes = np.array([mode_shape(1, xi, wave) for wave in waves]).reshape(len(waves), half)
    slopes = np.array([mode_slope(1, xi, wave) for wave in waves]).reshape(len(waves), half)
    middle = np.array([mode_shape(1, np.zeros(1), wave)[0] for wave in waves])
    last = middle if odd else shapes[:, -1] if half else middle
    free = shapes if odd else shapes[:, : half - 1]
    jacobian = np.hstack([2.0 * weights * slopes, 2.0 * (free - last[:, None])])
    return 2.0 * shapes @ weights + centre * middle, jacobian


def _continue(unknown: Array, half: int, waves: Array) -> Array:
    """Follow the solution from the start to the supports.

    Raises:
        LinkageError: the continuation does not converge.
    """
    start, _ = _residual(unknown, half, waves)
    reached, step = 0.0, 1.0
    for _ in range(MOST_STEPS):
        target = min(reached + step, 1.0)
        solution = _newton(unknown, half, waves, (1.0 - target) * start)
        if solution is None:
            step /= 2.0
            continue
        unknown, reached, step = solution, target, 2.0 * step
        if reached == 1.0:
            return unknown
    raise LinkageError(f"supports at {unknown.size + 1} points: the continuation stalls")


def _newton(unknown: Array, half: int, waves: Array, goal: Array) -> Array | None:
    """Solve for a residual; None if the points leave their order or it does not converge."""
    for _ in range(8):
        value, jacobian = _residual(unknown, half, waves)
        if np.abs(value - goal).max() < SUPPORT_RESIDUAL:
            return unknown
        try:
            unknown = unknown - np.linalg.solve(jacobian, value - goal)
        except np.linalg.LinAlgError:
            return None
        if np.any(np.diff(np.concatenate([[0.0], unknown[:half], [0.5]])) <= 0.0):
            return None
    value, _ = _residual(unknown, half, waves)
    return unknown if np.abs(value - goal).max() < 10.0 * SUPPORT_RESIDUAL else None


def _whippletree(xi: Array, weights: Array) -> tuple[Bar, ...]:
    """Join the points of one half by bars; arms are in the inverse ratio of the weights."""
    bars: list[Bar] = []
    pivot, carried = (float(xi[0]), float(weights[0])) if xi.size else (0.0, 0.0)
    for point, weight in zip(xi[1:].tolist(), weights[1:].tolist(), strict=True):
        joined = (carried * pivot + weight * point) / (carried + weight)
        arms = (joined - pivot, point - joined)
        bars.append(Bar((pivot, point), joined, arms, carried + weight))
        pivot, carried = joined, carried + weight
    return tuple(bars)
