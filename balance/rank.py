"""Every decision about a rank is taken here.

Conditions arrive in blocks of rows. They are kept as a triangular factor, which is all of
them up to an orthogonal transformation: ``R = QᵀX`` with pivoting, in the spirit of T. F.
Chan (1987), cut off where the largest remaining column is round-off. Blocks are scaled as a
whole; a single row never is, because that would turn round-off into a condition.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinematics.kernels import kernel
from kinematics.linkage import frozen

__all__ = ["Conditions", "Decision"]

Array = NDArray[np.float64]

# Round-off of a regressor, relative to its largest singular value: measured values lie
# below 1e-14 for well-conditioned loops; the floor leaves two decades to those that are not.
FLOOR = 2.0**-40


@kernel
def _absorb(R, rows, floor, scale):
    """Pivoted triangular factor of ``[R; rows]`` and what was cut off.

    Returns:
        The factor (rank, columns) with columns in their own order, the order in which they
        were eliminated, the largest pivot, and the norm of the remainder.
    """
    old, p = R.shape
    m = old + rows.shape[0]
    W = np.empty((p, m))
    norms = np.zeros(p)
    permutation = np.arange(p)
    for j in range(p):
        for i in range(old):
            W[j, i] = R[i, j]
        for i in range(m - old):
            W[j, old + i] = rows[i, j]
        for i in range(m):
            norms[j] += W[j, i] * W[j, i]
    rank = 0
    remainder = 0.0
    for k in range(min(m, p) + 1):
        remainder = 0.0
        pivot = k
        for j in range(k, p):
            remainder += norms[j]
            if norms[j] > norms[pivot]:
                pivot = j
        if k == min(m, p):
            break
        size = np.sqrt(norms[pivot])
        scale = max(scale, size)
        if size <= floor * scale:
            break
        if pivot != k:
            permutation[k], permutation[pivot] = permutation[pivot], permutation[k]
            norms[pivot] = norms[k]
            for i in range(m):
                W[k, i], W[pivot, i] = W[pivot, i], W[k, i]
        rank = k + 1
        v = W[k, k:]
        diagonal = -size if v[0] > 0.0 else size
        v[0] -= diagonal
        factor = 1.0 / (diagonal * v[0])
        for j in range(k + 1, p):
            u = W[j, k:]
            dot = 0.0
            for i in range(v.size):
                dot += v[i] * u[i]
            dot *= factor
            u[0] += dot * v[0]
            total = 0.0
            for i in range(1, v.size):
                u[i] += dot * v[i]
                total += u[i] * u[i]
            norms[j] = total
        v[0] = diagonal
    out = np.zeros((rank, p))
    for j in range(p):
        for i in range(min(j + 1, rank)):
            out[i, permutation[j]] = W[j, i]
    return out, permutation, scale, np.sqrt(remainder)


@kernel
def _eliminate(R, permutation, row):
    """Remainder of a row after elimination by the factor, and the largest multiplier."""
    rank, p = R.shape
    x = row.copy()
    largest = 1.0
    for i in range(rank):
        multiplier = x[permutation[i]] / R[i, permutation[i]]
        largest = max(largest, abs(multiplier))
        for j in range(p):
            x[j] -= multiplier * R[i, j]
    remainder = 0.0
    for i in range(rank, p):
        remainder += x[permutation[i]] ** 2
    return np.sqrt(remainder), largest


@dataclass(frozen=True, eq=False)
class Decision:
    """A decided rank, with the numbers behind it.

    Attributes:
        rank: number of independent conditions.
        singular_values: of all conditions, relative to the largest, descending (rank,).
        kept: the smallest of them; 1 if there are none.
        dropped: upper bound of the first one that counts as round-off, relative.
        basis: orthonormal null space (parameters, nullity).
    """

    rank: int
    singular_values: Array
    kept: float
    dropped: float
    basis: Array


@dataclass(frozen=True, eq=False)
class Conditions:
    """Linear conditions on ``columns`` unknowns, compressed to a triangular factor.

    Attributes:
        factor: as many rows as there are independent conditions, triangular once its
            columns are taken in the order of ``permutation``.
        permutation: see ``factor``.
        scale: largest pivot seen.
        dropped: largest remainder that was cut off as round-off.
    """

    factor: Array
    permutation: NDArray[np.int64]
    scale: float = 0.0
    dropped: float = 0.0

    @classmethod
    def none(cls, columns: int) -> Conditions:
        """No conditions yet."""
        return cls(np.empty((0, columns)), np.arange(columns))

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return len(self.factor)

    def and_also(self, rows: Array) -> Conditions:
        """These conditions and those in ``rows`` (any leading shape, columns last)."""
        block = rows.reshape(-1, self.factor.shape[1])
        factor, permutation, scale, remainder = _absorb(self.factor, block, FLOOR, self.scale)
        return Conditions(factor, permutation, scale, max(self.dropped, remainder))

    def imply(self, rows: Array) -> bool:
        """Whether rows that were not used follow from these conditions.

        One random combination of the rows is tested: if any of them adds a condition, so
        does almost every combination.
        """
        block = rows.reshape(-1, self.factor.shape[1])
        row = np.cos(np.arange(1.0, len(block) + 1.0) ** 2) @ block
        remainder, growth = _eliminate(self.factor, self.permutation, row)
        return bool(remainder <= FLOOR * growth * max(self.scale, float(np.sqrt(row @ row))))

    def decide(self) -> Decision:
        """Singular values and null space of the conditions gathered so far."""
        if self.rank == 0:
            basis = np.eye(self.factor.shape[1])
            return Decision(0, frozen([]), 1.0, 0.0, frozen(basis))
        _, values, Vt = np.linalg.svd(self.factor)
        relative = values / values[0]
        return Decision(
            self.rank, frozen(relative), float(relative[-1]), self.dropped / float(values[0]),
            frozen(Vt[self.rank :].T),
        )  # fmt: skip
