"""Springs of which both ends are free: products of unknowns, by a relaxation and a search.

With a at ``c + Σ s_i e_i`` and b at ``d + Σ t_j f_j`` the energy of a spring is linear in k,
k s, k t and k s tᵀ: the entries of a matrix of rank one. Without the rank, and with the limits
of `balance.masses.springs.spring_cone`, springs that balance are a polyhedron; if it is empty,
there are none. Otherwise one end is fixed, the other found by the convex program, and so in
turn, from several starts. What balances so does balance; what is not found is not excluded.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from balance.masses.springs.attached_springs import AttachedSpring
from balance.masses.springs.spring_cone import balanced_unknowns, least_unknowns, make_cone
from balance.masses.springs.spring_text import SpringRange
from balance.support.tolerances import SPRING_ABSENT
from kinematics.numerics.array_types import Array

# Starts of the search, turns of each, and progress below which a search ends.
STARTS, TURNS, SLOW = 8, 60, 1e-4


def balance_springs(
    rows: Array, springs: Sequence[AttachedSpring], ranges: Sequence[SpringRange], unit: float
) -> tuple[Array | None, bool]:
    """Find unknowns of springs that balance.

    Args:
        rows: conditions on all their unknowns, and gravity last.
        springs: the springs.
        ranges: least and greatest stiffness of each, N/m.
        unit: stiffness that counts as 1, N/m.

    Returns:
        The unknowns, None if none are found; and whether that excludes them.
    """
    x = balanced_unknowns(rows, make_cone(springs, unit, ranges))
    if x is None or not any(spring.paired for spring in springs):
        return x, True
    for first in _starts(springs, x):
        for fixed in _alternate(rows, springs, ranges, unit, first):
            few, T = fixed
            y = balanced_unknowns(_reduce(rows, T), make_cone(few, unit, ranges))
            if y is not None:
                return T @ y, True
    return None, False


def least_springs(
    rows: Array, springs: Sequence[AttachedSpring], ranges: Sequence[SpringRange], unit: float
) -> Array:
    """Find unknowns of springs that leave little of ``rows [x; 1]``.

    It is the least if no spring has both ends free; otherwise the least of several searches.
    """
    x = least_unknowns(rows, make_cone(springs, unit, ranges))
    if not any(spring.paired for spring in springs):
        return x
    best, least = None, np.inf
    for start in _starts(springs, x):
        for few, T in _alternate(rows, springs, ranges, unit, start):
            reduced = _reduce(rows, T)
            y = least_unknowns(reduced, make_cone(few, unit, ranges))
            size = float(np.linalg.norm(reduced @ np.append(y, 1.0)))
            if size < least * (1.0 - SLOW):
                best, least = T @ y, size
    assert best is not None
    return best


def _starts(springs: Sequence[AttachedSpring], x: Array) -> Iterator[list[Array]]:
    """List coordinates of the second ends: those of the relaxation, then random ones."""
    at, relaxed = 0, []
    for spring in springs:
        first, second = (len(end.axes) for end in spring.ends)
        k = x[at] if abs(x[at]) > SPRING_ABSENT else 1.0
        relaxed.append(np.clip(x[at + 1 + first : at + 1 + first + second] / k, -1.0, 1.0))
        at += spring.columns
    yield relaxed
    rng = np.random.default_rng(113)
    for _ in range(STARTS):
        yield [rng.uniform(-1.0, 1.0, len(spring.ends[1].axes)) for spring in springs]


def _alternate(
    rows: Array,
    springs: Sequence[AttachedSpring],
    ranges: Sequence[SpringRange],
    unit: float,
    shares: Sequence[Array],
) -> Iterator[tuple[list[AttachedSpring], Array]]:
    """Fix second and first ends in turn, each where the last program left it.

    Yields:
        The springs with one end fixed, and the matrix from their unknowns to all.
    """
    end, before = 1, np.inf
    for turn in range(TURNS):
        few, T = _fix(springs, end, shares)
        yield few, T
        reduced = _reduce(rows, T)
        y = least_unknowns(reduced, make_cone(few, unit, ranges))
        size = float(np.linalg.norm(reduced @ np.append(y, 1.0)))
        if turn % 2 and size > before * (1.0 - SLOW):
            return
        before = size if turn % 2 else before
        shares = _shares(springs, few, end, shares, y)
        end = 1 - end


def _fix(
    springs: Sequence[AttachedSpring], end: int, shares: Sequence[Array]
) -> tuple[list[AttachedSpring], Array]:
    """Fix one end of each spring of which both are free."""
    few, blocks = [], []
    for spring, share in zip(springs, shares, strict=True):
        few.append(spring.fixed(end, share) if spring.paired else spring)
        blocks.append(spring.spread(end, share) if spring.paired else np.eye(spring.columns))
    height, width = (sum(block.shape[k] for block in blocks) for k in range(2))
    T, row, column = np.zeros((height, width)), 0, 0
    for block in blocks:
        T[row : row + len(block), column : column + block.shape[1]] = block
        row, column = row + len(block), column + block.shape[1]
    return few, T


def _shares(
    springs: Sequence[AttachedSpring],
    few: Sequence[AttachedSpring],
    end: int,
    shares: Sequence[Array],
    y: Array,
) -> list[Array]:
    """Read the coordinates of the ends that were free.

    Those of an absent spring stay in the middle of their boxes.
    """
    largest, at, read = float(np.abs(y).max(initial=0.0)), 0, []
    for spring, reduced, share in zip(springs, few, shares, strict=True):
        k, products = y[at], y[at + 1 : at + reduced.columns]
        at += reduced.columns
        if not spring.paired:
            read.append(share)
        elif k > SPRING_ABSENT * largest:
            read.append(np.clip(products / k, -1.0, 1.0))
        else:
            read.append(np.zeros(len(spring.ends[1 - end].axes)))
    return read


def _reduce(rows: Array, T: Array) -> Array:
    """Write conditions in the unknowns that are left; gravity stays last."""
    return np.column_stack([rows[:, :-1] @ T, rows[:, -1]])
