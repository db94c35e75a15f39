"""Map of the angle error over the place of a pivot and the ratio of moments of inertia."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import SYNTHESIS_ANGLE_MET
from balance.studies.synthesis.angle_error import (
    ChainAngles,
    angle_error,
    angle_residual,
    chain_angles,
)
from balance.studies.synthesis.pantograph import PantographMasses
from balance.studies.synthesis.pivot_line import PivotLine
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.zero_contour import ZeroContour, refine_roots, zero_contour
from kinematics.numerics.array_types import Array

# Offsets at which roots along a pivot line are looked for.
SCAN = 4001


@dataclass(frozen=True, eq=False)
class AngleErrorMap:
    """Angle error over offsets of a pivot and ratios ``R = (I1 + I3) / (I2 + I4 + I5)``.

    Attributes:
        line: of the pivot.
        offsets: τ (columns,), metres.
        ratios: R (rows,).
        errors: ε (rows, columns), radians; NaN where the first link reverses on the way.
        contour: where ε = 0, refined; its points are τ and R.
    """

    line: PivotLine
    offsets: Array
    ratios: Array
    errors: Array
    contour: ZeroContour


def angle_error_map(
    positions: Sequence[Position],
    line: PivotLine,
    masses: PantographMasses,
    offsets: ArrayLike,
    ratios: ArrayLike,
    *,
    s2: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> AngleErrorMap:
    """Map the angle error of pantographs through two positions, and find where it vanishes.

    Args:
        positions: two positions of the tool.
        line: of the pivot that is not chosen.
        masses: of the pantographs; I1 + I3 is R times I2 + I4 + I5.
        offsets: of the pivot (columns,), metres.
        ratios: R (rows,), from 0 up.
        s2: centre of link 2 instead of that of force balance.
        progress: called with the number of rows done and of all rows.

    Returns:
        The map; on its contour ε is at most 1e-10.
    """
    tau, R = (np.asarray(each, dtype=np.float64) for each in (offsets, ratios))
    errors = np.empty((len(R), len(tau)))
    for row, ratio in enumerate(R):
        angles = _angles(positions, line, masses, tau, np.full(len(tau), ratio), s2)
        errors[row] = angle_error(angles, (line.step,))[0]
        if progress is not None:
            progress(row + 1, len(R))

    def residual(tau: Array, ratio: Array) -> Array:
        angles = _angles(positions, line, masses, tau, ratio, s2)
        return np.asarray(angle_residual(angles, (line.step,))[0])

    contour = zero_contour(tau, R, errors, residual, SYNTHESIS_ANGLE_MET)
    return AngleErrorMap(line, tau, R, errors, contour)


def offsets_without_error(
    positions: Sequence[Position],
    line: PivotLine,
    masses: PantographMasses,
    low: float,
    high: float,
    s2: float | None = None,
) -> Array:
    """Find the offsets of a pivot for which the angle error vanishes, for given masses.

    Args:
        positions: two positions of the tool.
        line: of the pivot that is not chosen.
        low: least offset, metres.
        s2: centre of link 2 instead of that of force balance.

    Returns:
        The offsets (count,), ascending, metres.
    """

    def angles(tau: Array) -> Array:
        chain = chain_angles(
            positions[0], (line.step,), *line.pivots(tau), masses, masses.inertia_1, s2
        )
        return np.asarray(angle_residual(chain, (line.step,))[0])

    tau = np.linspace(low, high, SCAN)
    values = angles(tau)
    (at,) = np.nonzero(
        np.isfinite(values[:-1] * values[1:]) & (values[:-1] * values[1:] <= 0.0)
    )
    step = tau[1] - tau[0]
    roots = tau[at] + step * refine_roots(lambda s: angles(tau[at] + step * s), len(at))
    good = np.abs(angles(roots)) <= SYNTHESIS_ANGLE_MET
    return np.unique(roots[good])


def _angles(
    positions: Sequence[Position],
    line: PivotLine,
    masses: PantographMasses,
    tau: Array,
    ratios: Array,
    s2: float | None,
) -> ChainAngles:
    """Compute the angles of the chains for offsets and ratios of one shape."""
    return chain_angles(
        positions[0], (line.step,), *line.pivots(tau), masses, ratios * masses.inertia_2, s2
    )
