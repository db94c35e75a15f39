"""Every decision about a rank is taken here.

Conditions arrive in blocks of rows. They are kept as a triangular factor, which is all of
them up to an orthogonal transformation: ``R = QᵀX`` with pivoting, in the spirit of T. F.
Chan (1987), cut off where the largest remaining column is round-off. Blocks are scaled as a
whole; a single row never is, because that would turn round-off into a condition.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.kernels import kernel
from kinematics.linkage import frozen

__all__ = ["Conditions", "Decision"]

Array = NDArray[np.float64]

# Round-off of a regressor, relative to its largest singular value: measured values lie
# below 1e-14 for well-conditioned loops; the floor leaves two decades to those that are not.
FLOOR = 2.0**-40
# Round-off of a factor's rows, which their multipliers amplify when others are eliminated.
ROUNDING = 2.0**-46


@kernel
def _absorb(R, rows, begin, end, weight, floor, scale):
    """Pivoted triangular factor of R and ``weight * rows[begin:end]``, and what was cut off.

    Returns:
        The factor (rank, columns) with columns in their own order, the order in which they
        were eliminated, the largest pivot, and the norm of the remainder.
    """
    old, p = R.shape
    m = old + end - begin
    W = np.empty((p, m))
    norms = np.zeros(p)
    permutation = np.arange(p)
    for j in range(p):
        for i in range(old):
            W[j, i] = R[i, j]
        for i in range(end - begin):
            W[j, old + i] = weight * rows[begin + i, j]
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
def _implied(R, permutation, rows, begin, end, weight, floor, scale):
    """Whether ``weight * rows[begin:end]`` follow from the factor R.

    One generic combination of the rows is eliminated by the factor: if any of them adds a
    condition, so does almost every combination.
    """
    rank, p = R.shape
    x = np.zeros(p)
    for i in range(begin, end):
        c = weight * np.cos((i - begin + 1.0) ** 2)
        for j in range(p):
            x[j] += c * rows[i, j]
    size = 0.0
    for j in range(p):
        size += x[j] * x[j]
    size = np.sqrt(size)
    growth = 1.0
    for i in range(rank):
        multiplier = x[permutation[i]] / R[i, permutation[i]]
        growth = max(growth, abs(multiplier))
        for j in range(p):
            x[j] -= multiplier * R[i, j]
    remainder = 0.0
    for i in range(rank, p):
        remainder += x[permutation[i]] ** 2
    return np.sqrt(remainder) <= floor * max(scale, size) + ROUNDING * growth * scale


@kernel
def _gather(
    R, permutation, scale, dropped, rows, per_ray, width, first, radius, fresh, stop, floor
):
    """Absorb the rows of consecutive orders; see `Conditions.with_orders`."""
    orders, count, p = rows.shape
    ranks = np.zeros(orders, np.int64)
    settled = True
    done = 0
    for k in range(orders):
        order = first + k
        weight = radius**order
        every = 1
        for i in range(order):
            every = every * (width + i) // (i + 1)
        used = 0
        while used < every:
            wanted = 2 * used if used > 0 else -(-(p - R.shape[0]) // per_ray)
            wanted = min(every, max(wanted, 1))
            if (wanted if wanted == every else wanted + 1) * per_ray > count:
                return R, permutation, scale, dropped, ranks[:done], False, False
            begin, end = used * per_ray, wanted * per_ray
            R, permutation, scale, remainder = _absorb(
                R, rows[k], begin, end, weight, floor, scale
            )
            dropped = max(dropped, remainder)
            used = wanted
            if used < every and _implied(
                R, permutation, rows[k], end, end + per_ray, weight, floor, scale
            ):
                break
        ranks[k] = R.shape[0]
        done += 1
        settled = _implied(R, permutation, fresh, 0, fresh.shape[0], 1.0, floor, scale)
        if settled and stop:
            break
    return R, permutation, scale, dropped, ranks[:done], settled, True


class Decision(NamedTuple):
    """The numbers behind a rank, and the null space.

    Attributes:
        singular_values: of all conditions, relative to the largest, descending (rank,).
        kept: the smallest of them; 1 if there are none.
        dropped: upper bound of the first one that counts as round-off, relative.
        basis: orthonormal null space (parameters, nullity).
    """

    singular_values: Array
    kept: float
    dropped: float
    basis: Array


class Conditions(NamedTuple):
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
        factor, permutation, scale, remainder = _absorb(
            self.factor, block, 0, len(block), 1.0, FLOOR, self.scale
        )
        return Conditions(factor, permutation, scale, max(self.dropped, remainder))

    def imply(self, rows: Array) -> bool:
        """Whether rows that were not used follow from these conditions."""
        block = rows.reshape(-1, self.factor.shape[1])
        return bool(
            _implied(
                self.factor, self.permutation, block, 0, len(block), 1.0, FLOOR, self.scale
            )
        )

    def with_orders(
        self, rows: Array, first: int, radius: float, fresh: Array, stop: bool
    ) -> tuple[Conditions, Array, bool, bool]:
        """Add the derivatives of consecutive orders, along as many rays as it takes.

        ``C(w + k - 1, k)`` generic rays span all derivatives of order k in w coordinates;
        fewer will do once the rows of one more follow from those gathered. Rows of order k
        are weighted by ``radius**k``.

        Args:
            rows: shape (orders, rays, w, rows per column, columns).
            first: the first of the orders.
            radius: radius of convergence of the series.
            fresh: rows of a finite pose, which decide whether another order is needed.
            stop: whether to stop at the order that needs no other.

        Returns:
            The conditions, the rank after each order, whether the fresh rows follow from
            them, and whether there were enough rays.
        """
        orders, rays, width, rows_per_column, columns = rows.shape
        factor, permutation, scale, dropped, ranks, settled, enough = _gather(
            self.factor, self.permutation, self.scale, self.dropped,
            rows.reshape(orders, -1, columns), width * rows_per_column, width, first, radius,
            fresh, stop, FLOOR,
        )  # fmt: skip
        return Conditions(factor, permutation, scale, dropped), ranks, settled, enough

    def decide(self) -> Decision:
        """Singular values and null space of the conditions gathered so far."""
        if self.rank == 0:
            return Decision(frozen([]), 1.0, 0.0, np.eye(self.factor.shape[1]))
        _, values, Vt = np.linalg.svd(self.factor)
        relative = values / values[0]
        dropped = self.dropped / float(values[0])
        return Decision(frozen(relative), float(relative[-1]), dropped, Vt[self.rank :].T)
