"""Pivots that leave one number free: the perpendicular bisector of a chord.

With the moving pivot W_1 chosen, the fixed pivot is on the bisector of W_1 and W_2; with the
fixed pivot chosen, W_1 is on the bisector of G and of the point that the displacement brings
to G. A pivot is ``middle + τ direction`` with the offset τ in metres.

Source: G. Becht, MSc thesis, TU Delft, 2020, chapter 3, Eqs. 20 to 23 (there by G_x).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.motion.motion_tolerances import SYNTHESIS_SINGULAR
from balance.studies.synthesis.positions import Displacement, Position, displacements, size_of
from kinematics.errors import SynthesisError
from kinematics.numerics.array_types import Array

Complex = NDArray[np.complex128]


class PivotLine(NamedTuple):
    """A pivot on a line, and the other one, which is chosen; inertial frame, metres.

    Attributes:
        middle: middle of the chord.
        direction: of its bisector, of length 1.
        chosen: the other pivot, at the first position.
        free: ``"fixed"`` or ``"moving"``: which pivot is on the line.
        step: displacement of the tool from the first position to the second.
    """

    middle: complex
    direction: complex
    chosen: complex
    free: str
    step: Displacement

    def pivots(self, offsets: ArrayLike) -> tuple[Complex, Complex]:
        """Compute the fixed and the moving pivot for offsets τ (any shape)."""
        on_line = self.middle + np.asarray(offsets) * self.direction
        other = np.full(on_line.shape, self.chosen)
        return (on_line, other) if self.free == "fixed" else (other, on_line)

    def offsets_of_x(self, x: ArrayLike) -> Array:
        """Compute the offsets τ of points with given x, metres.

        Raises:
            SynthesisError: the chord is horizontal, so that all points have one x.
        """
        if abs(self.direction.real) < SYNTHESIS_SINGULAR:
            raise SynthesisError(
                "the chord of the pivot is horizontal: all points of its bisector have the "
                f"same x = {self.middle.real:g}",
                "leave out the range of x: distances from the chord are searched then",
            )
        return (np.asarray(x, dtype=np.float64) - self.middle.real) / self.direction.real


def fixed_pivot_line(positions: Sequence[Position], moving: complex) -> PivotLine:
    """Find the line of the fixed pivots for a moving pivot.

    Args:
        positions: of the tool; the first two count.
        moving: the moving pivot at the first position, metres, inertial frame.

    Raises:
        SynthesisError: it is the pole of the displacement.
    """
    step = displacements(positions[:2])[0]
    return _bisector(moving, step.move(moving), moving, "fixed", step, size_of(positions))


def moving_pivot_line(positions: Sequence[Position], fixed: complex) -> PivotLine:
    """Find the line of the moving pivots, at the first position, for a fixed pivot.

    Args:
        positions: of the tool; the first two count.
        fixed: the fixed pivot, metres, inertial frame.

    Raises:
        SynthesisError: it is the pole of the displacement.
    """
    step = displacements(positions[:2])[0]
    origin = (fixed - step.shift) / step.rotation
    return _bisector(fixed, origin, fixed, "moving", step, size_of(positions))


def _bisector(
    start: complex, end: complex, chosen: complex, free: str, step: Displacement, size: float
) -> PivotLine:
    """Build the line between two points."""
    chord = end - start
    if abs(chord) < SYNTHESIS_SINGULAR * size:
        raise SynthesisError(
            "the chosen pivot is the pole of the displacement, where it stays",
            "choose a pivot away from the pole",
        )
    return PivotLine(0.5 * (start + end), 1j * chord / abs(chord), chosen, free, step)
