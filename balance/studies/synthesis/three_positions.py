"""Nonlinear pantographs through three positions: where two zero contours cross.

The moving pivot W_1 is free. The fixed pivot is the centre of the circle through W_1, W_2 and
W_3. The residuals of the second and of the third position are two functions of W_1, whose zero
contours cross at the designs; Newton's method refines the crossings.

Source: the outlook of G. Becht, MSc thesis, TU Delft, 2020, chapter 5, not carried out there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.motion.motion_tolerances import SYNTHESIS_ANGLE_MET
from balance.studies.synthesis.angle_error import angle_residual, chain_angles
from balance.studies.synthesis.pantograph import PantographMasses
from balance.studies.synthesis.positions import Displacement, Position, displacements, size_of
from balance.studies.synthesis.zero_contour import ZeroContour, zero_contour
from kinematics.numerics.array_types import Array

Complex = NDArray[np.complex128]

# Half of the side of the window of moving pivots, in sizes of the positions.
WINDOW = 2.0
# Rows and columns of the map.
CELLS = 120
# Steps of Newton's method, and of its differences relative to the window.
STEPS = 30
DIFFERENCE = 1e-7
# Crossings nearer than that, relative to the window, are one.
APART = 1e-6


@dataclass(frozen=True, eq=False)
class CrossingMap:
    """Residuals of both positions over moving pivots, and where both vanish.

    Attributes:
        x: of the moving pivot at the first position (columns,), metres.
        y: of the moving pivot (rows,), metres.
        residuals: of the second and third position (2, rows, columns), radians.
        contours: where each of them vanishes; points are x and y.
        moving: moving pivots of the designs (count,), complex.
        fixed: their fixed pivots (count,).
    """

    x: Array
    y: Array
    residuals: Array
    contours: tuple[ZeroContour, ZeroContour]
    moving: Complex
    fixed: Complex


def default_window(positions: Sequence[Position]) -> tuple[float, float, float, float]:
    """Choose the window of moving pivots: x and y from and to, metres."""
    middle = sum(each.point for each in positions) / len(positions)
    half = WINDOW * size_of(positions)
    return middle.real - half, middle.real + half, middle.imag - half, middle.imag + half


def circle_centres(moving: ArrayLike, steps: tuple[Displacement, ...]) -> Complex:
    """Compute the centres of circles through W_1, W_2 and W_3.

    Args:
        moving: W_1, complex, any shape.
        steps: displacements to the second and the third position.
    """
    W = np.asarray(moving)
    a, b = (step.move(W) - W for step in steps)
    with np.errstate(divide="ignore", invalid="ignore"):
        area = a * b.conjugate() - a.conjugate() * b
        centre = (abs(a) ** 2 * b - abs(b) ** 2 * a) / area
    return np.asarray(W - centre)


def crossing_map(
    positions: Sequence[Position],
    masses: PantographMasses,
    window: tuple[float, float, float, float],
    progress: Callable[[int, int], None] | None = None,
) -> CrossingMap:
    """Map the residuals of three positions over moving pivots, and find where both vanish.

    Args:
        positions: three positions of the tool.
        window: of the moving pivots: x from and to, y from and to, metres.
        progress: called with the number of rows done and of all rows.

    Returns:
        The map, and the designs with residuals of at most 1e-10.
    """
    steps = displacements(positions)
    x, y = np.linspace(*window[:2], CELLS), np.linspace(*window[2:], CELLS)
    residuals = np.empty((2, CELLS, CELLS))
    for row, height in enumerate(y):
        residuals[:, row] = _residuals(positions[0], steps, masses, x + 1j * height)
        if progress is not None:
            progress(row + 1, CELLS)

    def residual(W: Complex) -> Array:
        return _residuals(positions[0], steps, masses, W)

    size = x[-1] - x[0]
    roots = _newton(residual, _candidates(x, y, residuals), size)
    inside = (abs(roots.real - 0.5 * (x[0] + x[-1])) <= 0.6 * size) & (
        abs(roots.imag - 0.5 * (y[0] + y[-1])) <= 0.6 * (y[-1] - y[0])
    )
    moving = _distinct(roots[inside], APART * size)
    second, third = (
        zero_contour(
            x,
            y,
            residuals[k],
            lambda x, y, k=k: residual(x + 1j * y)[k],  # type: ignore[misc]
            SYNTHESIS_ANGLE_MET,
        )
        for k in (0, 1)
    )
    return CrossingMap(x, y, residuals, (second, third), moving, circle_centres(moving, steps))


def _residuals(
    first: Position, steps: tuple[Displacement, ...], masses: PantographMasses, W: Complex
) -> Array:
    """Compute the residuals of both positions (2, …) for moving pivots."""
    with np.errstate(all="ignore"):
        angles = chain_angles(first, steps, circle_centres(W, steps), W, masses)
        return angle_residual(angles, steps)


def _candidates(x: Array, y: Array, residuals: Array) -> Complex:
    """Find the middles of cells in which both residuals change their sign."""
    corners = [
        residuals[:, j : j + len(y) - 1, i : i + len(x) - 1] for j in (0, 1) for i in (0, 1)
    ]
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    j, i = np.nonzero(((low <= 0.0) & (high >= 0.0)).all(axis=0))
    return np.asarray(0.5 * (x[i] + x[i + 1]) + 0.5j * (y[j] + y[j + 1]))


def _newton(function: Callable[[Complex], Array], start: Complex, size: float) -> Complex:
    """Find zeros of two functions of the plane from many starts; those that converge."""
    W, h = start, DIFFERENCE * size
    best, least = W, np.full(W.shape, np.inf)
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            value = function(W)
            worst = np.abs(value).max(axis=0)
            better = worst < least
            best, least = np.where(better, W, best), np.where(better, worst, least)
            dx, dy = ((function(W + s) - function(W - s)) / (2.0 * h) for s in (h, 1j * h))
            below = dx[0] * dy[1] - dx[1] * dy[0]
            step = (value[0] * dy[1] - value[1] * dy[0]) / below
            step = step + 1j * (dx[0] * value[1] - dx[1] * value[0]) / below
            long = np.abs(step) / (0.05 * size)
            W = W - np.where(np.isfinite(step), step, 0.0) / np.maximum(long, 1.0)
    return best[least <= SYNTHESIS_ANGLE_MET]


def _distinct(points: Complex, apart: float) -> Complex:
    """Drop points that are near others."""
    pivots: list[complex] = []
    for point in points.tolist():
        if all(abs(point - other) > apart for other in pivots):
            pivots.append(point)
    return np.array(pivots, dtype=np.complex128)
