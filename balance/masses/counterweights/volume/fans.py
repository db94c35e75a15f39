"""Fans: directions of a disc that are full from its axis to its rim, or empty.

In unit coordinates, with ``e(θ) = [cos θ; sin θ]``, a linear form ``g·u + c`` has over the
direction θ, of all radii and the whole thickness, the integral ``2/3 g·e(θ) + c``. Where that
is positive is an arc about the direction of g, and its sector gives most. Of half angle α about
the direction e a sector has the moments

    m = 2 α,    h = 4/3 sin α e,    Σ = ½ (α + ½ sin 2α) e eᵀ + ½ (α - ½ sin 2α) n nᵀ

in its plane, with n across e, and ``m / 3`` along the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest

FULL_TURN = 2.0 * np.pi


class AngleRange(NamedTuple):
    """Directions from one on, counter-clockwise.

    Attributes:
        start: angle of the first direction, radians.
        width: radians, above 0 and up to 2 π.
    """

    start: float
    width: float

    @property
    def middle(self) -> float:
        """Angle of the direction in the middle, radians."""
        return self.start + 0.5 * self.width


class Fan(NamedTuple):
    """Directions of the unit disc that may be full.

    Attributes:
        allowed: the directions.
    """

    allowed: AngleRange

    def arcs(self, form: Array) -> list[AngleRange]:
        """List the allowed directions in which the integral of a form (4, 4) is positive."""
        (gx, gy), c = (2.0 * form[:2, 3]).tolist(), float(form[3, 3])
        size = float(np.hypot(gx, gy))
        if 1.5 * abs(c) >= size:
            return [self.allowed] if c > 0.0 else []
        half = float(np.arccos(-1.5 * c / size))
        return _common(self.allowed, AngleRange(float(np.arctan2(gy, gx)) - half, 2.0 * half))

    @staticmethod
    def moments(arcs: Sequence[AngleRange]) -> Array:
        """Compute ``∫ [u; 1][u; 1]ᵀ`` (4, 4) over the sectors of arcs."""
        total = np.zeros((4, 4))
        for arc in arcs:
            alpha = 0.5 * arc.width
            c, s = np.cos(arc.middle), np.sin(arc.middle)
            turned = np.array([[c, -s], [s, c]])
            wide = 0.5 * np.sin(2.0 * alpha)
            total[:2, :2] += turned * (0.5 * np.array([alpha + wide, alpha - wide])) @ turned.T
            total[:2, 3] += 4.0 / 3.0 * np.sin(alpha) * turned[:, 0]
            total[2, 2] += 2.0 * alpha / 3.0
            total[3, 3] += 2.0 * alpha
        total[3, :2] = total[:2, 3]
        return total


def widest_free_arc(excluded: Sequence[AngleRange]) -> AngleRange | None:
    """Return the widest arc outside all of some arcs; None if they leave none."""
    if not excluded:
        return AngleRange(0.0, FULL_TURN)
    free = []
    for arc in excluded:
        end = arc.start + arc.width
        others = [other for other in excluded if other is not arc]
        if not any(0.0 <= _turn(other.start, end) < other.width for other in others):
            free.append(AngleRange(end, min(_turn(end, other.start) for other in excluded)))
    free = [arc for arc in free if arc.width > 0.0]
    return free[first_largest([arc.width for arc in free])] if free else None


def _turn(start: float, end: float) -> float:
    """Compute the angle from a direction to another, counter-clockwise, 0 to 2 π."""
    return float((end - start) % FULL_TURN)


def _common(first: AngleRange, second: AngleRange) -> list[AngleRange]:
    """List the arcs that two arcs have in common: two if both reach round."""
    if first.width >= FULL_TURN:
        return [second]
    ahead = _turn(first.start, second.start)
    pieces = [
        (max(0.0, start), min(first.width, start + second.width))
        for start in (ahead - FULL_TURN, ahead)
    ]
    return [AngleRange(first.start + a, b - a) for a, b in pieces if b > a]
