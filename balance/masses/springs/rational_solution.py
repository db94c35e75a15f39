"""Linear systems in rational numbers, whose pivots a prime chooses."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from balance.space.exact.modular import PRIMES
from kinematics.numerics.array_types import IntArray

# Digits of numbers that are taken as rational, size below which they are zero, and largest
# number of pivots.
DIGITS, TINY, MAX_PIVOTS = 14, 1e-14, 120
# Part of a column beyond others that round-off may leave.
DEPENDENT = 1e-7


def rational(value: float) -> Fraction:
    """Read a number by its first 14 digits; what is below 1e-14 is zero."""
    return Fraction(0) if abs(value) < TINY else Fraction(f"{float(value):.{DIGITS}g}")


def solve_rational(
    rows: Sequence[Sequence[Fraction]],
    right_side: Sequence[Fraction],
    start: Sequence[Fraction],
    wanted: int,
) -> list[Fraction] | None:
    """Solve ``rows x = right_side`` exactly, with unknowns that are no pivots as in ``start``.

    Pivots are the first ``wanted`` columns, without those that depend on others but for
    round-off; then the further ones; then, if need be, the rest.

    Returns:
        The solution, which was checked in every row; None if there is none, or the system is
        too large.
    """
    order = _independent(rows, wanted)
    order += [*range(wanted, len(start)), *(c for c in range(wanted) if c not in set(order))]
    pivots = _pivots([[row[c] for c in order] for row in rows])
    if pivots is None or len(pivots) > MAX_PIVOTS:
        return None
    pivots = [(r, order[c]) for r, c in pivots]
    columns = [c for _, c in pivots]
    x = [Fraction(0) if c in set(columns) else value for c, value in enumerate(start)]
    residual = [value - _times(row, x) for row, value in zip(rows, right_side, strict=True)]
    few = [[rows[r][c] for c in columns] for r, _ in pivots]
    values = _solve_square(few, [residual[r] for r, _ in pivots])
    if values is None:
        return None
    for c, value in zip(columns, values, strict=True):
        x[c] = value
    holds = all(_times(row, x) == value for row, value in zip(rows, right_side, strict=True))
    return x if holds else None


def inconsistency(rows: Sequence[Sequence[Fraction]], right_side: Sequence[Fraction]) -> bool:
    """Whether a combination of rows is found that is zero on the left and not on the right.

    That proves that ``rows x = right_side`` has no solution (Fredholm's alternative).
    """
    pivots = _pivots(rows)
    if pivots is None or len(pivots) > MAX_PIVOTS:
        return False
    columns, used = [c for _, c in pivots], [r for r, _ in pivots]
    turned = [[rows[r][c] for r in used] for c in columns]
    width = len(rows[0]) if rows else 0
    for i in range(len(rows)):
        if i in used:
            continue
        w = _solve_square(turned, [-rows[i][c] for c in columns])
        if w is None:
            return False
        if (
            right_side[i]
            + sum((a * right_side[r] for a, r in zip(w, used, strict=True)), Fraction(0))
            == 0
        ):
            continue
        combination = (
            rows[i][c]
            + sum((a * rows[r][c] for a, r in zip(w, used, strict=True)), Fraction(0))
            for c in range(width)
        )
        if not any(combination):
            return True
    return False


def _independent(rows: Sequence[Sequence[Fraction]], wanted: int) -> list[int]:
    """List columns that depend on none before them, by floating point."""
    A = np.array([[float(x) for x in row[:wanted]] for row in rows]).reshape(len(rows), wanted)
    Q, kept = np.empty((len(rows), 0)), []
    for c in range(wanted):
        size = float(np.linalg.norm(A[:, c]))
        v = A[:, c] - Q @ (Q.T @ A[:, c])
        v = v - Q @ (Q.T @ v)
        if float(np.linalg.norm(v)) > DEPENDENT * size:
            Q = np.column_stack([Q, v / np.linalg.norm(v)])
            kept.append(c)
    return kept


def _times(row: Sequence[Fraction], x: Sequence[Fraction]) -> Fraction:
    """Compute a scalar product, without what is zero."""
    return sum((a * b for a, b in zip(row, x, strict=True) if a and b), Fraction(0))


def _pivots(rows: Sequence[Sequence[Fraction]]) -> list[tuple[int, int]] | None:
    """Eliminate modulo a prime: row and column of each pivot, by column.

    None if no prime divides no denominator.
    """
    reduced = next(filter(lambda A: A is not None, (_modulo(rows, p) for p in PRIMES)), None)
    if reduced is None:
        return None
    A, p = reduced
    pivots: list[tuple[int, int]] = []
    free = np.ones(len(A), dtype=bool)
    for c in range(A.shape[1] if A.size else 0):
        candidates = np.flatnonzero(free & (A[:, c] != 0))
        if not candidates.size:
            continue
        r = int(candidates[0])
        A[r] = A[r] * pow(int(A[r, c]), -1, p) % p
        others = candidates[1:]
        A[others] = (A[others] - A[others, c : c + 1] * A[r]) % p
        free[r] = False
        pivots.append((r, c))
    return pivots


def _modulo(rows: Sequence[Sequence[Fraction]], p: int) -> tuple[IntArray, int] | None:
    """Reduce rational numbers modulo a prime, if it divides no denominator."""
    try:
        table = [[x.numerator % p * pow(x.denominator, -1, p) % p for x in row] for row in rows]
    except ValueError:
        return None
    return np.array(table, dtype=np.int64).reshape(len(rows), -1), p


def _solve_square(
    A: Sequence[Sequence[Fraction]], b: Sequence[Fraction]
) -> list[Fraction] | None:
    """Solve a square system by elimination; None if it is singular."""
    n = len(A)
    M = [[*row, value] for row, value in zip(A, b, strict=True)]
    for k in range(n):
        r = min(
            (i for i in range(k, n) if M[i][k]),
            key=lambda i: M[i][k].numerator.bit_length() + M[i][k].denominator.bit_length(),
            default=None,
        )
        if r is None:
            return None
        M[k], M[r] = M[r], M[k]
        for i in range(k + 1, n):
            if M[i][k]:
                f = M[i][k] / M[k][k]
                M[i] = [
                    x - f * y if y and j > k else x
                    for j, (x, y) in enumerate(zip(M[i], M[k], strict=True))
                ]
    x = [Fraction(0)] * n
    for k in range(n - 1, -1, -1):
        later_terms = sum((M[k][j] * x[j] for j in range(k + 1, n) if M[k][j]), Fraction(0))
        x[k] = (M[k][n] - later_terms) / M[k][k]
    return x
