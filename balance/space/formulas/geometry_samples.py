"""Conditions at geometries that relations allow, in one reduced echelon form."""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from time import monotonic

from balance.space.formulas.modular_conditions import ConditionSource, ModularRow
from balance.space.formulas.modular_motion import ModularMotion
from balance.space.formulas.modular_pose import UnclosedError
from balance.space.formulas.planar_functions import Coefficients
from balance.space.formulas.relations import FreeDimensions
from balance.space.formulas.spatial_dimensions import SpatialDimensions
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS, echelon_modulo

# Orders of the series, and numbers of rays, that are tried.
EXTENTS = ((1, 1), (2, 1), (2, 2), (3, 2), (4, 3), (6, 4), (9, 6), (14, 9))
# Poses of a geometry with one loop that are drawn until one belongs to the motion of its rank;
# each further loop doubles them.
POSES_OF_ONE_LOOP = 12
# Numbers of orders after which the rank has stayed the same and counts as final.
SURE_EXTENTS = 3
# Finite poses that are added after the rank is reached.
SPARE_POSES = 3


class OutOfTimeError(Exception):
    """The time that was given is over."""


class ConditionSamples(ABC):
    """Echelon forms of conditions at dimensions drawn at random.

    Attributes:
        solved: columns with pivots, in the order of the rows.
        entries: row and column of the entries that do not vanish.
        free: the dimensions that can be chosen.
        deadline: when time is over; None for never.
        rng: draws dimensions and poses.
    """

    free: FreeDimensions | SpatialDimensions

    def __init__(self, deadline: float | None) -> None:
        """Start without dimensions."""
        self.deadline, self.rng = deadline, random.Random(5)
        self.solved: list[int] = []
        self.entries: list[tuple[int, int]] = []
        self._base_rows: list[ModularRow] = []
        self._kept: dict[tuple[int, ...], list[ModularRow]] = {}

    def start(self, rows: list[ModularRow]) -> None:
        """Keep rows in which columns are chosen."""
        self._base_rows = rows

    @abstractmethod
    def rows(self, point: Sequence[int], p: int) -> list[ModularRow]:
        """Compute independent conditions at values of the variables.

        Raises:
            UnclosedError: no pose has the rank of the linkage.
            OutOfTimeError: the time is over.
        """

    @abstractmethod
    def agree(
        self, conditions: Callable[[int], list[ModularRow]], point: Sequence[int], p: int
    ) -> bool:
        """Check conditions at finite poses modulo a prime, without series.

        Args:
            conditions: computes rows modulo a number, each with 1 where it is solved.
            point: values of the variables.
            p: a prime.
        """

    def check_time(self) -> None:
        """Stop when the time is over.

        Raises:
            OutOfTimeError: it is.
        """
        if self.deadline is not None and monotonic() > self.deadline:
            raise OutOfTimeError

    def pivots_for(self, columns: Sequence[int]) -> list[int]:
        """Find the columns with pivots for an order of the columns."""
        return echelon_modulo(self._base_rows, columns, PRIMES_OF_61_BITS[0])[1]

    def count_terms(self, solved: Sequence[int]) -> int | None:
        """Count entries that do not vanish; None if these columns cannot be solved for."""
        rows, pivots = echelon_modulo(self._base_rows, solved, PRIMES_OF_61_BITS[0])
        if len(pivots) < len(self._base_rows):
            return None
        return sum(sum(1 for x in row if x) for row in rows)

    def solve_for(self, solved: Sequence[int]) -> None:
        """Choose the columns with pivots."""
        self.solved = list(solved)
        rows, _ = echelon_modulo(self._base_rows, self.solved, PRIMES_OF_61_BITS[0])
        self.entries = [
            (r, c)
            for r, row in enumerate(rows)
            for c, x in enumerate(row)
            if x and c not in self.solved
        ]

    def values(self, point: Sequence[int]) -> list[int]:
        """Compute the entries at values of the variables, modulo the first prime.

        Rows are kept: those of one point serve every choice of solved parameters.
        """
        key = tuple(point)
        if key not in self._kept:
            self._kept[key] = self.rows(point, PRIMES_OF_61_BITS[0])
        return self._entries_of(self._kept[key])

    def fresh_values(self, point: Sequence[int]) -> list[int]:
        """Compute the entries at another pose of the same dimensions."""
        return self._entries_of(self.rows(point, PRIMES_OF_61_BITS[0]))

    def _entries_of(self, rows: list[ModularRow]) -> list[int]:
        solved, pivots = echelon_modulo(rows, self.solved, PRIMES_OF_61_BITS[0])
        if len(pivots) < len(self.solved):
            raise UnclosedError
        return [solved[r][c] for r, c in self.entries]


class GeometrySamples(ConditionSamples):
    """Echelon forms at geometries of planar linkages whose conditions have a known rank.

    Attributes:
        source: computes conditions.
        free: the dimensions that can be chosen.
        target: the rank, of real conditions.
    """

    free: FreeDimensions

    def __init__(
        self,
        source: ConditionSource,
        free: FreeDimensions,
        target: int,
        deadline: float | None = None,
    ) -> None:
        """Find how many orders and rays the rank needs.

        Raises:
            UnclosedError: no geometry drawn has that rank.
        """
        self.source, self.free, self.target = source, free, target
        super().__init__(deadline)
        self.attempts = POSES_OF_ONE_LOOP << max(source.linkage.loops() - 1, 0)
        p = PRIMES_OF_61_BITS[0]
        # Of dimensions with several motions, one extent more tells them apart.
        self.extent = EXTENTS[min(self._least_extent(p) + free.special, len(EXTENTS) - 1)]
        self.start(self.rows(free.draw(p, self.rng), p))

    def _least_extent(self, p: int) -> int:
        """Find the fewest orders and rays, by index, that give the rank, and no more beyond."""
        values = self.free.pairs(self.free.draw(p, self.rng), p)
        for _ in range(self.attempts):
            motion, origins = self.source.motion_at(values, p, self.rng)
            counts: list[int] = []
            for self.extent in EXTENTS:
                counts.append(self.source.real_rank(self._reduced(motion, origins, p)))
                if (
                    counts[-1] > self.target
                    or counts[-SURE_EXTENTS:] == [self.target] * SURE_EXTENTS
                ):
                    break
            if counts[-1] == self.target:
                return counts.index(self.target)
        raise UnclosedError

    def rows(self, point: Sequence[int], p: int) -> list[ModularRow]:
        """Compute independent conditions at values of the variables.

        Where two motions have the same dimensions, a parallelogram and an antiparallelogram,
        poses are drawn until the conditions have the rank of the linkage.

        Raises:
            UnclosedError: no pose has that rank.
            OutOfTimeError: the time is over.
        """
        self.check_time()
        values = self.free.pairs(point, p)
        for _ in range(self.attempts):
            rows = self._reduced(*self.source.motion_at(values, p, self.rng), p)
            if self.source.real_rank(rows) == self.target:
                return rows
        raise UnclosedError

    def _reduced(
        self, motion: ModularMotion, origins: list[Coefficients], p: int
    ) -> list[ModularRow]:
        """Reduce the conditions of a motion."""
        rows = self.source.rows_from(motion, origins, p, self.rng, *self.extent)
        return echelon_modulo(rows, range(self.source.width), p)[0]

    def agree(
        self, conditions: Callable[[int], list[ModularRow]], point: Sequence[int], p: int
    ) -> bool:
        """Check that conditions span those of velocities at finite poses."""
        every = range(self.source.width)
        finite = echelon_modulo(self.finite_rows(point, p), every, p)
        return echelon_modulo(conditions(p), every, p) == finite

    def finite_rows(self, point: Sequence[int], p: int) -> list[ModularRow]:
        """Compute conditions from velocities at finite poses of one motion.

        Where the dimensions have several motions, poses whose series have another rank than
        the linkage are passed over.
        """
        values = self.free.pairs(point, p)
        rows: list[ModularRow] = []
        spare = SPARE_POSES
        for _ in range(self.attempts * (self.target + SPARE_POSES)):
            motion, origins = self.source.motion_at(values, p, self.rng)
            if self.free.special:
                reduced = self._reduced(motion, origins, p)
                if self.source.real_rank(reduced) != self.target:
                    continue
            rows += self.source.rows_from(motion, origins, p, self.rng, 0, 1)
            rows = echelon_modulo(rows, range(self.source.width), p)[0]
            spare -= self.source.real_rank(rows) >= self.target
            if not spare:
                break
        return rows
