"""Arithmetic on remainders modulo a prime: products, power series, elimination.

Nothing is rounded, and a rank is the number of pivots of an elimination. Remainders are
``0 … p - 1`` in 64-bit integers. Their products of matrices run in floating point, and are
exact there: one factor is cut into halves of 15 bits, and products of 30 and 15 bits have
room for 2^8 sums in the 53 bits of a double.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinematics.numerics.array_types import Array, IntArray

PRIMES = (1073741789, 1073741783, 1073741741, 1073741723)
"""The largest primes below 2^30."""

# Bits of half a remainder.
HALF_BITS = 15
# Number of products of 30 and 15 bits whose sum a double holds exactly.
MAX_EXACT_SUMS = 2**8


def inverse(a: int, p: int) -> int:
    """Compute the inverse of a modulo p, ``a⁻¹ a ≡ 1``.

    Args:
        a: a whole number that p does not divide.
    """
    return pow(int(a), -1, p)


def _halves(B: IntArray) -> Array:
    """Cut remainders into upper halves and, to their right, lower halves; (…, 2 columns)."""
    columns = B.shape[-1]
    out = np.empty((*B.shape[:-1], 2 * columns))
    out[..., :columns] = B >> HALF_BITS
    out[..., columns:] = B & (2**HALF_BITS - 1)
    return out


def _product_with_halves(A: Array, halves: Array, p: int) -> IntArray:
    """Compute the matrix product of remainders and halves of remainders, modulo p."""
    inner, columns = A.shape[-1], halves.shape[-1] // 2
    if inner > MAX_EXACT_SUMS:
        head = _product_with_halves(A[..., :MAX_EXACT_SUMS], halves[..., :MAX_EXACT_SUMS, :], p)
        return (
            head
            + _product_with_halves(A[..., MAX_EXACT_SUMS:], halves[..., MAX_EXACT_SUMS:, :], p)
        ) % p
    both = (A @ halves).astype(np.int64)
    return ((both[..., :columns] % p << HALF_BITS) + both[..., columns:]) % p


def product(A: IntArray, B: IntArray, p: int) -> IntArray:
    """Compute the matrix product A B modulo p.

    Args:
        A: remainders (…, m, inner).
        B: remainders (…, inner, n).

    Returns:
        Remainders (…, m, n).
    """
    return _product_with_halves(A.astype(np.float64), _halves(B), p)


class Convolution:
    """Sums ``Σ_a A_a B_{k-a}`` of two series of matrices modulo p, order by order.

    The A of all orders stand side by side, the B below each other in reverse order, so that a
    sum is one product of matrices.
    """

    def __init__(self, batch: int, rows: int, inner: int, columns: int, p: int) -> None:
        """Room for a few orders of A (batch, rows, inner) and B (batch, inner, columns)."""
        self._p, self._inner, self._A_filled, self._B_filled = p, inner, 0, 0
        self._A = np.zeros((batch, rows, 4 * inner))
        self._B = np.zeros((batch, 4 * inner, 2 * columns))

    def append_left(self, A: IntArray) -> None:
        """Append the next order of A."""
        if self._A_filled == self._A.shape[2]:
            self._A = np.concatenate([self._A, np.zeros_like(self._A)], axis=2)
        self._A[:, :, self._A_filled : self._A_filled + self._inner] = A
        self._A_filled += self._inner

    def append_right(self, B: IntArray) -> None:
        """Append the next order of B."""
        if self._B_filled == self._B.shape[1]:
            self._B = np.concatenate([np.zeros_like(self._B), self._B], axis=1)
        end = self._B.shape[1] - self._B_filled
        self._B[:, end - self._inner : end] = _halves(B)
        self._B_filled += self._inner

    def sum(self, count: int, chosen: Sequence[int] | None = None) -> IntArray:
        """Multiply the first ``count`` orders of A by the last of B, in reverse order.

        Args:
            count: number of orders.
            chosen: some of the rows of A; all by default.
        """
        size, start = count * self._inner, self._B.shape[1] - self._B_filled
        A = self._A[:, :, :size] if chosen is None else self._A[:, chosen, :size]
        return _product_with_halves(A, self._B[:, start : start + size], self._p)


def eliminate(A: IntArray, columns: int, p: int) -> IntArray:
    """Reduce remainders by Gauss-Jordan elimination in place, row by row.

    The pivot of a row is its first entry that does not vanish after the rows before it are
    eliminated. Rows are not exchanged.

    Args:
        A: in, out: remainders (rows, ≥ columns).
        columns: number of columns, the first ones, in which pivots lie.

    Returns:
        The column of the pivot of each row, -1 if the row vanishes there; (rows,).
    """
    pivots = np.full(len(A), -1)
    for i in np.flatnonzero(A[:, :columns].any(axis=1)).tolist():
        entries = np.flatnonzero(A[i, :columns])
        if not entries.size:
            continue
        pivots[i] = c = entries[0]
        A[i] = A[i] * inverse(A[i, c], p) % p
        factors = A[:, c].copy()
        factors[i] = 0
        others = np.flatnonzero(factors)
        A[others] = (A[others] + (p - factors[others, None]) * A[i]) % p
    return pivots


class Echelon:
    """Independent rows modulo p: each is 1 at its pivot, where all the others vanish."""

    def __init__(self, columns: int, p: int) -> None:
        """Start without rows."""
        self._p = p
        self._rows = np.empty((0, columns), np.int64)
        self._pivots = np.empty(0, np.int64)

    @property
    def rank(self) -> int:
        """Number of rows."""
        return len(self._rows)

    def implies(self, rows: IntArray) -> bool:
        """Decide whether all of some rows are combinations of those there are."""
        return not self._left_of(rows).any()

    def _left_of(self, rows: IntArray) -> IntArray:
        return (rows - product(rows[:, self._pivots], self._rows, self._p)) % self._p

    def absorb(self, rows: IntArray) -> list[tuple[int, int]]:
        """Add those rows that the ones before do not imply.

        Returns:
            The index of each row that is added, and the column of its pivot.
        """
        p, columns = self._p, rows.shape[1]
        rows = self._left_of(rows)
        pivots = eliminate(rows, columns, p)
        added = np.flatnonzero(pivots >= 0)
        if added.size:
            rows, pivots = rows[added], pivots[added]
            above = (self._rows - product(self._rows[:, pivots], rows, p)) % p
            self._rows = np.concatenate([above, rows])
            self._pivots = np.concatenate([self._pivots, pivots])
        return list(zip(added.tolist(), pivots[: added.size].tolist(), strict=True))
