"""Conditions of balance modulo a prime, for any dimensions of a planar linkage.

Force balance is complex: ``Σ_b (m_b O_b + s_b E_b)`` is constant, s being the first moment of
a body in the frame of its part. Dynamic balance is real: the columns of a body are x, i y, J
and m with ``s = x + i y`` and J the second moment about the origin of the frame, and

    2 i L = Σ_b m (Ō Ȯ - O Ō˙) + s (Ō Ė - E Ō˙) + s̄ (Ē Ȯ - O Ē˙) + 2 J Ė / E

vanishes too. Parameters are ordered by kind, moments first.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from balance.space.formulas.assembly_order import Step
from balance.space.formulas.modular_motion import FunctionSeries, ModularMotion
from balance.space.formulas.modular_pose import ModularAssembly, Pair, UnclosedError
from balance.space.formulas.planar_functions import (
    Coefficients,
    function_values,
    index_functions,
    linear_pose,
)
from balance.space.formulas.planar_parts import PlanarParts

Series = list[Pair]
ModularRow = list[int]

MAX_DRAWS = 4000
"""Most poses that are drawn for a geometry: each dyad closes in half of them."""


class ConditionSource:
    """Conditions of a linkage at any dimensions, modulo any prime.

    Attributes:
        index: the functions of its pose.
        alike: which directions turn alike, as `ModularMotion.turns_alike` says, in the motions
            that count; None for all motions.
    """

    def __init__(
        self, linkage: PlanarParts, first: int, steps: Sequence[Step], force: bool
    ) -> None:
        """Keep the linkage and an order of its assembly."""
        self.linkage, self.first, self.steps, self.force = linkage, first, steps, force
        self.index = index_functions(linkage)
        self.alike: list[int] | None = None

    @property
    def width(self) -> int:
        """Number of parameters: columns of the conditions."""
        return len(self.linkage.body_parts) * (2 if self.force else 4)

    def real_rank(self, rows: Sequence[ModularRow]) -> int:
        """Count the real conditions that rows in reduced echelon form are.

        A complex condition is two of them, but for one on masses alone, whose coefficients are
        real: that of a linkage which slides as a whole.
        """
        moments = len(self.linkage.body_parts)
        return sum(2 if self.force and any(row[:moments]) else 1 for row in rows)

    def motion_at(
        self, values: Sequence[Pair], p: int, rng: random.Random
    ) -> tuple[ModularMotion, list[Coefficients]]:
        """Draw a pose of given dimensions, and prepare its motion.

        Raises:
            UnclosedError: none of the poses drawn closes.
        """
        linear = linear_pose(self.linkage, self.index, values, p)
        assembly = ModularAssembly(self.linkage, values, p, rng)
        for _ in range(MAX_DRAWS):
            try:
                pose = assembly.pose(self.first, self.steps)
                start = function_values(self.index, pose, p)
                motion = ModularMotion(self.index, linear.loops, start, p, self._related(p))
            except (UnclosedError, ValueError, KeyError):
                continue
            if self.alike is not None and motion.turns_alike() != self.alike:
                continue
            if len(motion.columns) == self.linkage.freedoms:
                return motion, list(linear.origins)
        raise UnclosedError

    def _related(self, p: int) -> list[dict[int, int]]:
        """Write the relations of joints on the rates of directions and of slides."""
        rows = []
        for relation in self.linkage.relations:
            row: dict[int, int] = {}
            for k, c in relation.items():
                value = c.numerator * pow(c.denominator, -1, p)
                if k in self.index.of_joint:
                    terms = [(self.index.of_joint[k][0], value)]
                else:
                    base, part = (self.index.of_part[i] for i in self.linkage.joints[k].parts)
                    terms = [(part, value), (base, -value)]
                for i, x in terms:
                    if i:
                        row[i - 1] = (row.get(i - 1, 0) + x) % p
            rows.append(row)
        return rows

    def rows_from(
        self,
        motion: ModularMotion,
        origins: list[Coefficients],
        p: int,
        rng: random.Random,
        order: int,
        rays: int,
    ) -> list[ModularRow]:
        """Compute rows of conditions from series at a pose; order 0 is velocities alone.

        Args:
            motion: away from the pose.
            origins: of the parts, as `motion_at` returns them.
            p: the prime.
            rng: draws the rays.
            order: highest order of the series.
            rays: number of rays; one suffices for one degree of freedom.
        """
        rows: list[ModularRow] = []
        for _ in range(rays if len(motion.columns) > 1 else 1):
            ray = [rng.randrange(1, p) for _ in motion.columns]
            rows += self._rows_along(motion.along(ray, order), origins, p)
        return rows

    def _rows_along(
        self, ray: FunctionSeries, origins: list[Coefficients], p: int
    ) -> list[ModularRow]:
        rows: list[ModularRow] = []
        for rates in ray.rates:
            columns = [
                _body_columns(
                    ray.functions,
                    rates,
                    origins[part],
                    self.index.of_part[part],
                    self.index.sign[part],
                    self.force,
                    p,
                )
                for part in self.linkage.body_parts
            ]
            kinds = len(columns[0])
            ordered = [columns[b][kind] for kind in range(kinds) for b in range(len(columns))]
            rows += [list(row) for row in zip(*ordered, strict=True)]
        return [row for row in rows if any(row)]


def _combined(series: Sequence[Series], coefficients: Coefficients, p: int) -> Series:
    """Compute ``Σ_i o_i F_i`` and its conjugate, order by order."""
    out = []
    for k in range(len(series[0])):
        x = sum(a * series[i][k][0] for i, (a, _) in coefficients.items())
        y = sum(b * series[i][k][1] for i, (_, b) in coefficients.items())
        out.append((x % p, y % p))
    return out


def _wedge(A: Series, B: Series, rate_A: Series, rate_B: Series, p: int) -> list[int]:
    """Compute ``Ā Ḃ - B Ā˙``, order by order."""
    return [
        sum(A[a][1] * rate_B[k - a][0] - B[a][0] * rate_A[k - a][1] for a in range(k + 1)) % p
        for k in range(len(A))
    ]


def _body_columns(
    F: Sequence[Series],
    rates: Sequence[Series],
    origin: Coefficients,
    turning: int,
    sign: int,
    force: bool,
    p: int,
) -> list[list[int]]:
    """Compute the columns of one body: s, m for forces; x, i y, J, m otherwise."""
    place, V = _combined(F, origin, p), _combined(rates, origin, p)
    E, R = ([(sign * x % p, sign * y % p) for x, y in each[turning]] for each in (F, rates))
    if force:
        return [[x for x, _ in R], [x for x, _ in V]]
    linear = [[*(x for x, _ in A), *(y for _, y in A)] for A in (R, V)]
    first = _wedge(place, E, V, R, p)
    conjugate = _wedge(E, place, R, V, p)
    mass = _wedge(place, place, V, V, p)
    second = _wedge(E, E, R, R, p)
    count = len(E)
    zeros = [0] * (2 * count)
    real = [*linear[0], *((a + b) % p for a, b in zip(first, conjugate, strict=True))]
    imaginary = [
        *linear[0][:count],
        *(-y % p for y in linear[0][count:]),
        *((a - b) % p for a, b in zip(first, conjugate, strict=True)),
    ]
    return [real, imaginary, [*zeros, *second], [*linear[1], *mass]]
