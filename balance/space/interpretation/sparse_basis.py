"""Sparse basis of the parallel space, by minimising ``Σ |x|`` over terms.

Among all combinations ``z = D x`` that lie in the space, the one with the least ``Σ |x|`` has
few terms (S. S. Chen, D. L. Donoho and M. A. Saunders, 1998). A linear programme finds its
terms, and a singular vector of their columns finds their values, to round-off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.support.tolerances import SOLUTION_OUTSIDE, SOLUTIONS_EQUAL, TERM_ABSENT
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest, rank_least_first

# Part by which the cost of the last term is raised, so that the optimum is unique: well above
# the accuracy of the linear programme, well below differences that matter.
COST_RISE = 1e-3
GOLDEN_RATIO = 0.5 * (1.0 + 5.0**0.5)
# Most entries of all linear programmes that search for more solutions than needed.
MAX_PROGRAMME_ENTRIES = 300_000


class SparseSearch(NamedTuple):
    """Search for sparse x with ``conditions @ x = 0`` and a new part ``shadow @ x``.

    Attributes:
        columns: parameters of the terms, of unit size in the units of the chain.
        conditions: distance of each column from the design space, as a vector.
        shadow: the coordinates of each in the parallel space (p, columns).
        parallel: basis of the parallel space, orthonormal in the units of the chain.
        cost: of each column.
    """

    columns: Array
    conditions: Array
    shadow: Array
    parallel: Array
    cost: Array

    @classmethod
    def of(cls, basis: Array, serial: int, columns: Array, cost: Array) -> SparseSearch:
        """Prepare the search in a design space.

        Args:
            basis: of the space (parameters, nullity).
            serial: number of its columns, the first ones, that are not new.
            columns: parameters of the terms (parameters, columns), in the same units.
            cost: of each column.
        """
        Q = np.linalg.qr(basis, "complete")[0]
        parallel, outside = Q[:, serial : basis.shape[1]], Q[:, basis.shape[1] :]
        return cls(columns, outside.T @ columns, parallel.T @ columns, parallel, cost)

    def independent(self) -> list[Array]:
        """Find one solution for each new dimension; those of few terms come first."""
        pool = self._spanning()
        entries = 2 * self.conditions.size
        for w in self._directions(MAX_PROGRAMME_ENTRIES // entries) if len(pool) > 1 else []:
            other = self.sparse(w)
            pool += [other] if other is not None else []
        ranks = rank_least_first([float(self.cost @ np.abs(x)) for x in pool])
        pool = sorted((pool[k] for k in ranks), key=np.count_nonzero)
        chosen: list[Array] = []
        for x in pool:
            if self._new(chosen, x):
                chosen.append(x)
        return chosen

    def _spanning(self) -> list[Array]:
        """Find columns that are solutions, and then other solutions until they span."""
        vectors: list[Array] = []
        count = len(self.shadow)
        alone = np.linalg.norm(self.conditions, axis=0) <= SOLUTION_OUTSIDE
        alone &= np.linalg.norm(self.shadow, axis=0) > SOLUTIONS_EQUAL
        for k in sorted(np.flatnonzero(alone).tolist(), key=lambda k: self.cost[k]):
            x = np.zeros(alone.size)
            x[k] = 1.0
            if self.balances(x) and self._new(vectors, x):
                vectors.append(x)
        while len(vectors) < count:
            span = _span(self.shadow @ np.array(vectors).T) if vectors else np.empty((count, 0))
            rest = np.linalg.qr(span, "complete")[0][:, span.shape[1] :]
            residual = rest.T @ self.shadow
            w = rest @ residual[:, first_largest(np.linalg.norm(residual, axis=0) / self.cost)]
            w /= np.linalg.norm(w)
            few = self.sparse(w)
            if few is None or not self._new(vectors, few):
                few = self.dense(w)
            vectors.append(few)
        return vectors

    def _new(self, solutions: list[Array], x: Array) -> bool:
        """Whether a solution has a part that others do not have."""
        return _span(self.shadow @ np.array([*solutions, x]).T).shape[1] > len(solutions)

    def _directions(self, most: int) -> list[Array]:
        """List at most ``most`` directions in which columns are new, cheapest columns first."""
        directions = np.empty((0, len(self.shadow)))
        for k in np.argsort(self.cost, kind="stable"):
            w, size = self.shadow[:, k], np.linalg.norm(self.shadow[:, k])
            if len(directions) < most and size > SOLUTIONS_EQUAL:
                if np.abs(directions @ w).max(initial=0.0) < (1.0 - SOLUTIONS_EQUAL) * size:
                    directions = np.vstack([directions, w / size])
        return list(directions)

    def sparse(self, w: Array) -> Array | None:
        """Find the cheapest x in the space with ``w @ shadow @ x = 1``; None if none is found.

        A linear programme finds its terms, the singular vector of their columns its values.
        Of equally cheap solutions it takes one with early terms.
        """
        from scipy.optimize import linprog

        A = np.vstack([self.conditions, w @ self.shadow])
        b = np.append(np.zeros(len(self.conditions)), 1.0)
        cost = np.tile(self.cost * _distinct_cost_factors(self.cost.size), 2)
        solved = linprog(cost, A_eq=np.hstack([A, -A]), b_eq=b, method="highs-ds")
        if solved.x is None:
            return None
        x = np.subtract(*solved.x.reshape(2, -1))
        support = np.flatnonzero(np.abs(x) > TERM_ABSENT * np.abs(x).max())
        x = np.zeros_like(x)
        x[support] = np.linalg.svd(self.conditions[:, support])[2][-1]
        return x if abs(w @ self.shadow @ x) > SOLUTIONS_EQUAL and self.balances(x) else None

    def dense(self, w: Array) -> Array:
        """Find some x for the direction w of the parallel space, with any number of terms."""
        x: Array = np.linalg.lstsq(self.columns, self.parallel @ w)[0].astype(np.float64)
        return x

    def balances(self, x: Array) -> bool:
        """Decide whether a combination lies in the design space, to round-off."""
        outside = np.linalg.norm(self.conditions @ x)
        return bool(outside <= SOLUTION_OUTSIDE * np.linalg.norm(self.shadow @ x))


def _distinct_cost_factors(count: int) -> Array:
    """Compute factors of costs (count,) that rise a little, so that no two sums are equal.

    The multiples of the golden ratio, modulo 1, make sums of steps differ as well.
    """
    k = np.arange(count, dtype=np.float64)
    return np.asarray(1.0 + COST_RISE * (k + np.mod(k * GOLDEN_RATIO, 1.0)) / (count + 1.0))


def _span(vectors: Array) -> Array:
    """Compute an orthonormal basis of the span of columns (n, m), of any sizes but zero."""
    U, values, _ = np.linalg.svd(vectors / np.linalg.norm(vectors, axis=0))
    return U[:, : np.count_nonzero(values > SOLUTIONS_EQUAL)]
