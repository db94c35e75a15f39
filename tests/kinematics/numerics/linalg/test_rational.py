"""Elimination in rational numbers."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from kinematics.numerics.linalg.rational import (
    dot,
    echelon,
    rational_null_space,
)


def random_rows(seed):
    """Rows of fractions of a rank that is known, some of them zero; (rows, rank)."""
    rng = np.random.default_rng(seed)
    rank, count, columns = int(rng.integers(0, 4)), int(rng.integers(3, 7)), 6
    left = rng.integers(-3, 4, (count, rank))
    right = np.concatenate([np.eye(rank, dtype=int), rng.integers(-5, 6, (rank, 3))], axis=1)
    right = np.pad(right, ((0, 0), (0, columns - right.shape[1])))[:, rng.permutation(columns)]
    rows = [[Fraction(int(x), 7) for x in row] for row in left @ right]
    return rows, int(np.linalg.matrix_rank(left)) if rank else 0


@pytest.mark.parametrize("seed", range(12))
def test_reduced_rows_are_units_at_their_pivots_and_span_the_same(seed):
    rows, rank = random_rows(seed)
    reduced, pivots = echelon(rows)
    assert len(reduced) == len(set(pivots)) == rank
    for i, row in enumerate(reduced):
        assert [row[c] for c in pivots] == [int(i == k) for k in range(rank)]
    for row in rows:
        known = [
            sum((row[c] * r[k] for c, r in zip(pivots, reduced, strict=True)), Fraction(0))
            for k in range(6)
        ]
        assert known == row


@pytest.mark.parametrize("seed", range(12))
def test_by_default_the_first_entry_of_each_row_is_its_pivot(seed):
    reduced, pivots = echelon(random_rows(seed)[0])
    assert pivots == sorted(pivots)
    assert pivots == [next(c for c, x in enumerate(row) if x) for row in reduced]


@pytest.mark.parametrize("seed", range(12))
def test_the_null_space_has_product_zero_and_the_dimension_that_is_left(seed):
    rows, rank = random_rows(seed)
    found = rational_null_space(rows, 6)
    assert len(found) == 6 - rank == len(echelon(found)[0])
    assert all(dot(row, vector) == 0 for row in rows for vector in found)


def test_no_rows_leave_everything():
    assert rational_null_space([], 3) == [[int(i == j) for j in range(3)] for i in range(3)]
    assert echelon([]) == ([], [])
