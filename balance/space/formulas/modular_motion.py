"""Taylor series of the functions of a pose along rays, modulo a prime.

Rates are ``Ω = Ė / E`` of the directions and σ̇ of the prismatic joints. Loops and their
conjugates are linear in them: ``A(F) V = 0``; order by order, ``A_0 V_k = -Σ_a A_a V_{k-a}``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from balance.space.formulas.modular_pose import Pair
from balance.space.formulas.planar_functions import Coefficients, FunctionIndex
from kinematics.numerics.linalg.prime_field import invert_modulo

Rates = list[int]


class FunctionSeries(NamedTuple):
    """Series along one ray; index = order.

    Attributes:
        functions: the functions F, each a list of pairs.
        rates: of F for each column of the motion: Ḟ as if that column moved at rate 1.
    """

    functions: list[list[Pair]]
    rates: list[list[list[Pair]]]


class ModularMotion:
    """The motion of a linkage away from a pose."""

    def __init__(
        self,
        index: FunctionIndex,
        loops: Sequence[Coefficients],
        start: Sequence[Pair],
        p: int,
        relations: Sequence[Mapping[int, int]] = (),
    ) -> None:
        """Choose dependent rates, and independent rows.

        Args:
            index: the functions.
            loops: relations of the functions.
            start: the functions at the pose.
            p: the prime.
            relations: of the rates, which vanish at all times.
        """
        self.relations = relations
        self.index, self.loops, self.start, self.p = index, loops, start, p
        self.size = index.turning + len(index.of_joint)
        self.direction = list(range(index.turning + 1))
        self.direction += [direction for _, direction in index.of_joint.values()]
        A = self._rows([list(start)])[0] + self._related_rows()
        self.rows, self.dependent, self.inverse = invert_modulo(A, self.size, p)
        self.columns = [v for v in range(self.size) if v not in self.dependent]

    def turns_alike(self) -> list[int]:
        """Give each direction the first that turns as fast in all motions; 0 is the ground."""
        A = self._rows([list(self.start)])[0] + self._related_rows()
        rates = [self._next_rates([[A[r] for r in self.rows]], [], c) for c in self.columns]
        kinds = [[0] * len(rates)]
        kinds += [[V[v] for V in rates] for v in range(self.index.turning)]
        return [kinds.index(kind) for kind in kinds]

    def _derivative(self, i: int, F: Sequence[Sequence[Pair]]) -> list[tuple[int, list[Pair]]]:
        """List what multiplies which rate in Ḟ_i, as series; F are values by order."""
        p, index = self.p, self.index
        if i == 0:
            return []
        if i <= index.turning:
            return [(i - 1, [(f[i][0], -f[i][1] % p) for f in F])]
        d = self.direction[i]
        terms = [(i - 1, [f[d] for f in F])]
        if d:
            terms.append((d - 1, [(f[i][0], -f[i][1] % p) for f in F]))
        return terms

    def _rows(self, F: Sequence[Sequence[Pair]]) -> list[list[list[int]]]:
        """Compute the rows of A for values of the functions, order by order."""
        p, count = self.p, len(F)
        A = [[[0] * self.size for _ in range(2 * len(self.loops))] for _ in range(count)]
        for r, loop in enumerate(self.loops):
            for i, (a, b) in loop.items():
                for v, series in self._derivative(i, F):
                    for k, (x, y) in enumerate(series):
                        rows = A[k]
                        rows[2 * r][v] = (rows[2 * r][v] + a * x) % p
                        rows[2 * r + 1][v] = (rows[2 * r + 1][v] + b * y) % p
        return A

    def _related_rows(self, order: int = 0) -> list[list[int]]:
        """Write the relations of the rates, which are constant: zeros above order 0."""
        rows = []
        for relation in self.relations:
            rows.append([0] * self.size)
            if order == 0:
                for v, c in relation.items():
                    rows[-1][v] = c
        return rows

    def along(self, ray: Sequence[int], order: int) -> FunctionSeries:
        """Compute series along a ray of the columns, up to an order."""
        p, count, columns = self.p, self.index.size, self.columns
        F: list[list[Pair]] = [list(self.start)]
        A: list[list[list[int]]] = []
        V: list[list[Rates]] = [[] for _ in columns]
        whole: list[Rates] = []
        for k in range(order + 1):
            rows = self._rows(F[k:])[0] + self._related_rows(k)
            A.append([rows[r] for r in self.rows])
            for w, column in enumerate(columns):
                V[w].append(self._next_rates(A, V[w], column if k == 0 else -1))
            whole.append(
                [sum(d * V[w][k][v] for w, d in enumerate(ray)) % p for v in range(self.size)]
            )
            if k < order:
                scale = pow(k + 1, -1, p)
                rates = self._product(F, whole, k)
                F.append([(x * scale % p, y * scale % p) for x, y in rates])
        series = [[f[i] for f in F] for i in range(count)]
        by_column = []
        for w in range(len(columns)):
            orders = [self._product(F, V[w], k) for k in range(order + 1)]
            by_column.append([[f[i] for f in orders] for i in range(count)])
        return FunctionSeries(series, by_column)

    def _next_rates(self, A: list[list[list[int]]], V: list[Rates], free: int) -> Rates:
        """Solve for the rates of the next order; ``free`` is a column that moves at rate 1."""
        p, k = self.p, len(V)
        rates = [0] * self.size
        if free >= 0:
            rates[free] = 1
            sums = [row[free] for row in A[0]]
        else:
            sums = [0] * len(self.rows)
        for a in range(1, k + 1):
            before = V[k - a]
            for r, row in enumerate(A[a]):
                sums[r] += sum(x * y for x, y in zip(row, before, strict=True))
        for r, v in enumerate(self.dependent):
            rates[v] = -sum(x * y for x, y in zip(self.inverse[r], sums, strict=True)) % p
        return rates

    def _product(self, F: list[list[Pair]], V: Sequence[Rates], k: int) -> list[Pair]:
        """Compute Ḟ at order k for rates V."""
        p, out = self.p, [(0, 0)] * self.index.size
        for i in range(1, self.index.size):
            x = y = 0
            for v, series in self._derivative(i, F[: k + 1]):
                for a, (f, g) in enumerate(series):
                    x += f * V[k - a][v]
                    y += g * V[k - a][v]
            out[i] = x % p, y % p
        return out
