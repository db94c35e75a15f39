"""Rank decision: linear conditions as a triangular factor, cut off at round-off.

Conditions come in blocks of rows. The triangular factor ``R = QᵀX`` with pivoting holds all of
them up to an orthogonal transformation, in the spirit of T. F. Chan (1987); it ends where the
largest remaining column is round-off. Blocks are scaled as a whole. A single row never is,
because that would turn round-off into a condition.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.null_space import extend, known_and_null_space
from kinematics.numerics.linalg.pivoted_qr import (
    rows_follow,
    smallest_pivot,
    updated_factor,
)
from kinematics.numerics.tolerances import RANK_MARGIN, RANK_RELATIVE


class Pivots(NamedTuple):
    """Sizes of the pivots of conditions.

    Attributes:
        least: the smallest one; infinite if there is none.
        largest: the largest one.
        tolerance: pivots up to this part of the largest are round-off.
    """

    least: float
    largest: float
    tolerance: float

    def are_near_round_off(self, margin: float) -> bool:
        """Whether the smallest pivot is within a factor of round-off."""
        return self.least < margin * self.tolerance * self.largest


class Conditions(NamedTuple):
    """Linear conditions on unknowns, compressed to a triangular factor.

    Known solutions are projected out: one unknown is left out for each of them, and the
    conditions are on the others alone.

    Attributes:
        factor: one row for each independent condition, triangular if its columns are taken in
            the order of ``permutation``.
        permutation: see ``factor``.
        columns: the unknowns that the columns of ``factor`` stand for.
        known: known solutions, as the rows of a triangular factor (s, unknowns).
        omitted: the s unknowns that are left out.
        tolerance: pivots up to this part of the largest are round-off.
        scale: largest pivot seen.
        dropped: largest remainder that was cut off as round-off.
    """

    factor: Array
    permutation: IntArray
    columns: IntArray
    known: Array
    omitted: IntArray
    tolerance: float = RANK_RELATIVE
    scale: float = 0.0
    dropped: float = 0.0

    @classmethod
    def none(cls, unknowns: int) -> Conditions:
        """Start without conditions."""
        return cls.given(np.empty((0, unknowns)))

    @classmethod
    def given(cls, solutions: Array, tolerance: float = RANK_RELATIVE) -> Conditions:
        """Start without conditions, on unknowns with known solutions.

        Args:
            solutions: known solutions as rows (solutions, unknowns).
            tolerance: relative size of round-off.
        """
        count = solutions.shape[1]
        factor, permutation, _, _ = updated_factor(
            np.empty((0, count)), _plain(solutions), np.arange(count), tolerance, 1.0
        )
        s = len(factor)
        columns = permutation[s:].copy()
        columns.sort()
        empty = np.empty((0, columns.size))
        return cls(empty, np.arange(columns.size), columns, factor, permutation[:s], tolerance)

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return len(self.factor)

    @property
    def complete(self) -> bool:
        """Whether no other condition can be independent."""
        return len(self.factor) == self.columns.size

    @property
    def ill_conditioned(self) -> bool:
        """Whether the smallest pivot is near round-off."""
        return self.pivots.are_near_round_off(RANK_MARGIN)

    @property
    def pivots(self) -> Pivots:
        """Sizes of the pivots."""
        least = float(smallest_pivot(self.factor, self.permutation))
        return Pivots(least, self.scale, self.tolerance)

    @property
    def rows(self) -> Array:
        """The conditions on all unknowns (rank, unknowns); known solutions satisfy them."""
        return extend(self.known, self.omitted, self.factor, self.columns)

    def append(self, rows: Array) -> Conditions:
        """Append conditions, given as rows (any leading shape, unknowns last)."""
        block = _plain(rows.reshape(-1, self.known.shape[1]))
        factor, permutation, scale, remainder = updated_factor(
            self.factor, block, self.columns, self.tolerance, self.scale
        )
        return self._replace(
            factor=factor,
            permutation=permutation,
            scale=scale,
            dropped=max(self.dropped, remainder),
        )

    def first(self, rank: int | None) -> Conditions:
        """Keep the conditions of the first ``rank`` pivots; all of them without it."""
        return self._replace(factor=self.factor[:rank])

    def contains(self, rows: Array) -> bool:
        """Decide whether rows that were not used follow from these conditions."""
        block = _plain(rows.reshape(-1, self.known.shape[1]))
        return self.complete or bool(
            rows_follow(
                self.factor, self.permutation, block, self.columns, self.tolerance, self.scale
            )
        )

    def decide(self) -> Decision:
        """Compute the null space of the conditions."""
        basis = known_and_null_space(self.known, self.factor, self.permutation, self.columns).T
        return Decision(NullSpace(self, freeze(basis)))


def _plain(rows: Array) -> Array:
    """Copy rows as the one layout for which kernels are compiled."""
    return np.array(rows, dtype=np.float64, order="C")


class Solved(Protocol):
    """Conditions with their null space, which may be made when they are asked for."""

    @property
    def conditions(self) -> Conditions:
        """All conditions."""

    @property
    def basis(self) -> Array:
        """Orthonormal null space, the known solutions first (unknowns, nullity)."""

    @property
    def pivots(self) -> Pivots:
        """Sizes of the pivots of the conditions."""


class NullSpace(NamedTuple):
    """Conditions and their null space; see `Solved`."""

    conditions: Conditions
    basis: Array

    @property
    def pivots(self) -> Pivots:
        """Sizes of the pivots of the conditions."""
        return self.conditions.pivots


class Decision:
    """A null space, and the numbers behind its rank, which are computed at first use."""

    def __init__(self, solved: Solved) -> None:
        """Keep conditions and null space, or what makes them at first use."""
        self._solved = solved

    @property
    def conditions(self) -> Conditions:
        """All conditions."""
        return self._solved.conditions

    @property
    def basis(self) -> Array:
        """Orthonormal null space, the known solutions first (unknowns, nullity)."""
        return self._solved.basis

    def with_basis(self, basis: Array) -> Decision:
        """Replace the null space by another one, whose columns are orthonormal."""
        return Decision(NullSpace(self.conditions, freeze(basis)))

    @property
    def rank(self) -> int:
        """Number of unknowns less the dimension of the basis."""
        return len(self.basis) - self.basis.shape[1]

    @property
    def singular_values(self) -> Array:
        """Singular values of all conditions, relative to the largest, descending (rank,).

        Those of conditions that only exact arithmetic finds are 0.
        """
        unseen = np.zeros(self.rank - self._values.size)
        return freeze(np.concatenate([self._values / self._values[:1], unseen]))

    @property
    def kept(self) -> float:
        """The smallest singular value, relative to the largest; 1 if there are none."""
        return float(self.singular_values[-1]) if self.rank else 1.0

    @property
    def dropped(self) -> float:
        """Upper bound of the first one that counts as round-off, relative."""
        return self.conditions.dropped / float(self._values[0]) if self.conditions.rank else 0.0

    @property
    def ill_conditioned(self) -> bool:
        """Whether the smallest singular value that counts is near round-off."""
        # Pivots exceed the singular values they stand for by less than 20 in practice, though
        # W. Kahan's matrices (1966) show no such bound: a factor of RANK_MARGIN is ample.
        pivots = self._solved.pivots
        near = pivots.are_near_round_off(RANK_MARGIN * RANK_MARGIN)
        return near and self.kept < RANK_MARGIN * pivots.tolerance

    @cached_property
    def _values(self) -> Array:
        """Singular values, descending (rank,)."""
        return _singular_values(self.conditions.rows)


def _singular_values(A: Array) -> Array:
    """Singular values, descending."""
    try:
        values: Array = np.linalg.svd(A, compute_uv=False).astype(np.float64, copy=False)
        return values
    except np.linalg.LinAlgError:
        return singular_value_decomposition(A)[1]


def singular_value_decomposition(A: Array) -> tuple[Array, Array, Array]:
    """Compute the thin singular value decomposition ``A = U diag(s) Vt``.

    Returns:
        U, s descending, and Vt.
    """
    try:
        U, values, Vt = np.linalg.svd(A, full_matrices=False)
    except np.linalg.LinAlgError:
        # Divide and conquer fails on rare matrices, for which the QR iteration does not.
        from scipy.linalg import svd

        U, values, Vt = svd(A, full_matrices=False, lapack_driver="gesvd")
    return U, values, Vt
