"""Zero contour of a function on a grid, by marching squares, and its refinement."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kinematics.numerics.array_types import Array, Flags, IntArray

# Steps of bisection, and of Newton's method with divided differences, that refine a root.
BISECTIONS = 30
NEWTON_STEPS = 6


class ZeroContour(NamedTuple):
    """Points in which a contour crosses the lines of a grid.

    Attributes:
        points: coordinates (N, 2).
        residuals: values there (N,).
        segments: pairs of indices of points that a cell joins (M, 2).
    """

    points: Array
    residuals: Array
    segments: IntArray


def zero_contour(
    x: ArrayLike,
    y: ArrayLike,
    values: ArrayLike,
    function: Callable[[Array, Array], Array],
    tolerance: float,
) -> ZeroContour:
    """Find the zero contour of a function whose values on a grid are known.

    Where neighbours on the grid differ in sign, the root between them is refined. Sign changes
    that are no roots, but jumps or poles, are dropped.

    Args:
        x: coordinates of the columns (columns,).
        y: coordinates of the rows (rows,).
        values: on the grid (rows, columns); NaN where the function is none.
        function: computes values for coordinates of one shape.
        tolerance: largest value at a root.
    """
    x, y, v = (np.asarray(each, dtype=np.float64) for each in (x, y, values))
    across, up = _changes(v, 1), _changes(v, 0)
    j, i = np.nonzero(across)
    m, k = np.nonzero(up)
    start = np.concatenate([np.column_stack([x[i], y[j]]), np.column_stack([x[k], y[m]])])
    end = np.concatenate([np.column_stack([x[i + 1], y[j]]), np.column_stack([x[k], y[m + 1]])])
    part = refine_roots(lambda s: function(*(start + s[:, None] * (end - start)).T), len(start))
    points = start + part[:, None] * (end - start)
    residuals = function(*points.T)
    good = np.abs(residuals) <= tolerance
    number = np.where(good, np.cumsum(good) - 1, -1)
    own_across, own_up = (np.full(mask.shape, -1) for mask in (across, up))
    own_across[across], own_up[up] = number[: len(i)], number[len(i) :]
    segments = _segments(own_across, own_up, v)
    return ZeroContour(points[good], residuals[good], segments)


def refine_roots(function: Callable[[Array], Array], count: int) -> Array:
    """Refine roots in the intervals [0, 1], by bisection and then Newton's method.

    Args:
        function: computes the values of all functions, one for each number in [0, 1] (count,);
            their signs differ at 0 and 1.

    Returns:
        The roots (count,).
    """
    low, high = np.zeros(count), np.ones(count)
    if not count:
        return low
    below = function(low)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        same = function(middle) * below > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    before, root = low, high
    f0, f1 = function(before), function(root)
    for _ in range(NEWTON_STEPS):
        slope = np.where(
            f1 == f0, np.inf, (f1 - f0) / np.where(root == before, 1.0, root - before)
        )
        step = np.clip(root - f1 / slope, 0.0, 1.0)
        f2 = function(step)
        better = np.abs(f2) < np.abs(f1)
        before, f0 = np.where(better, root, before), np.where(better, f1, f0)
        root, f1 = np.where(better, step, root), np.where(better, f2, f1)
    return root


def _changes(values: Array, axis: int) -> Flags:
    """Find the edges of the grid along an axis whose ends differ in sign."""
    n = values.shape[axis]
    start, end = (np.take(values, range(k, n - 1 + k), axis) for k in (0, 1))
    with np.errstate(invalid="ignore"):
        edges: Flags = np.isfinite(start * end) & ((start < 0.0) != (end < 0.0))
    return edges


def _segments(across: IntArray, up: IntArray, values: Array) -> IntArray:
    """Join the crossings on the four sides of each cell: bottom, right, top, left."""
    sides = np.stack([across[:-1], up[:, 1:], across[1:], up[:, :-1]], axis=-1).reshape(-1, 4)
    count = (sides >= 0).sum(axis=1)
    two = sides[count == 2]
    pairs = [two[two >= 0].reshape(-1, 2)]
    four = count == 4
    corners = [values[:-1, :-1], values[:-1, 1:], values[1:, 1:], values[1:, :-1]]
    middle = sum(corners).ravel()[four]  # type: ignore[union-attr]
    # A saddle: the sign in its middle says which corners are cut off.
    joined = (middle < 0.0) == (corners[0].ravel()[four] < 0.0)
    saddles = sides[four]
    for first, second in (((0, 1), (2, 3)), ((3, 0), (1, 2))):
        mask = joined if first == (0, 1) else ~joined
        pairs += [saddles[mask][:, first], saddles[mask][:, second]]
    return np.concatenate(pairs)
