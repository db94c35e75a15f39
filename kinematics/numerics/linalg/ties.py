"""Choose and sort by computed numbers: among equal ones, the first in the given order wins.

Numbers count as equal to the one that is sought if they differ from it by a small part of it.
Which of two equal numbers has the larger last bit depends on the processor; what is chosen
here does not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import TIE_RELATIVE

# Decimals below those of a rounded number that may hold round-off.
GUARD_DECIMALS = 6


def first_largest(values: ArrayLike, size: float = 0.0, relative: float = TIE_RELATIVE) -> int:
    """Return the index of the first number that equals the largest one.

    Args:
        values: numbers (n,), at least one; undefined ones are never chosen before others.
        size: what the numbers are to be compared with, if they may all be round-off.
        relative: difference over the absolute value of the largest number, or over the size if
            that is larger, up to which numbers are equal.
    """
    numbers = np.asarray(values, dtype=np.float64).ravel()
    finite = numbers[np.isfinite(numbers)]
    if not finite.size or np.isposinf(numbers).any():
        return int(np.argmax(np.where(np.isnan(numbers), -np.inf, numbers)))
    largest = float(finite.max())
    return int(np.argmax(numbers >= largest - relative * max(size, abs(largest))))


def first_least(values: ArrayLike, size: float = 0.0) -> int:
    """Return the index of the first number that equals the least one; see `first_largest`.

    Args:
        values: numbers (n,), at least one.
        size: what the numbers are to be compared with, if they may all be round-off.
    """
    return first_largest(-np.asarray(values, dtype=np.float64), size)


def rank_least_first(
    values: Sequence[float], size: float = 0.0, relative: float = TIE_RELATIVE
) -> list[int]:
    """Return the indices of numbers in ascending order; equal ones keep their order.

    Numbers are equal to the least one of their group: a group ends at the first number that
    exceeds its least one by more than the tolerance.

    Args:
        values: numbers (n,).
        size: what the numbers are to be compared with, if they may all be round-off.
        relative: difference over the absolute value of the smaller of two numbers, or over the
            size if that is larger, up to which they are equal.
    """
    groups: list[list[int]] = []
    least = np.inf
    for k in np.argsort(np.asarray(values, dtype=np.float64), kind="stable").tolist():
        if not groups or values[k] - least > relative * max(size, abs(least)):
            groups.append([])
            least = values[k]
        groups[-1].append(k)
    return [k for group in groups for k in sorted(group)]


def first_direction(rows: Array) -> Array:
    """Choose a unit vector (n,) of the span of orthonormal rows (k, n).

    It is the one nearest to a coordinate axis, the first such axis if several are as near,
    and points along it. It depends on the span alone, not on the basis or its signs.
    """
    shares = np.linalg.norm(rows, axis=0)
    vector = rows[:, first_largest(shares)] @ rows
    return np.asarray(vector / np.linalg.norm(vector), np.float64)


def first_basis(rows: Array) -> Array:
    """Compute orthonormal rows (k, n) that span those of orthonormal rows (k, n).

    Each is the `first_direction` of what the rows before it leave. They depend on the span
    alone, while those of a decomposition turn with the last bits if values are equal.
    """
    uncovered, basis = rows, np.empty((0, rows.shape[1]))
    while len(basis) < len(rows):
        direction = first_direction(uncovered)
        basis = np.vstack([basis, direction])
        uncovered = uncovered - np.outer(uncovered @ direction, direction)
        uncovered = np.linalg.svd(uncovered, full_matrices=False)[2][: len(rows) - len(basis)]
    return basis


def round_decimals(values: ArrayLike, decimals: int) -> Array:
    """Round numbers to decimals; halves, up to round-off, are rounded alike.

    Args:
        values: numbers, of any shape.
        decimals: digits after the point; negative ones are those before it.
    """
    cleared = np.round(np.asarray(values, dtype=np.float64), decimals + GUARD_DECIMALS)
    return np.asarray(np.round(cleared, decimals), np.float64)
