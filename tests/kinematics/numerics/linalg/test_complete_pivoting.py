"""Elimination by the largest entries, beside a search through all rows for each of them."""

from fractions import Fraction

import numpy as np
import pytest

from kinematics.numerics.linalg.complete_pivoting import eliminate_by_largest
from kinematics.numerics.linalg.cyclotomic import root_of_integer
from tests.support.counted_work import instructions


def random_rows(seed):
    """Five independent rows of fractions, many of them zero, and one that follows from two."""
    rng = np.random.default_rng(seed)
    numbers = rng.integers(-4, 5, (6, 8)) * (rng.random((6, 8)) < 0.6)
    numbers[:5, :5] += 50 * np.eye(5, dtype=int)
    rows = [[Fraction(int(x), int(rng.integers(1, 9))) for x in row] for row in numbers]
    rows[3] = [x / 3 - y for x, y in zip(rows[0], rows[5], strict=True)]
    return rows


def pivots_by_search(rows):
    """Columns of the first of the largest entries that each step leaves."""
    A, pivots = [list(row) for row in rows], []
    while any(map(any, A)):
        size, _, i = max((abs(x), -k, k) for k, row in enumerate(A) for x in row)
        c = [abs(x) for x in A[i]].index(size)
        pivots.append(c)
        top = A.pop(i)
        A = [[x - row[c] / top[c] * y for x, y in zip(row, top, strict=True)] for row in A]
    return pivots


@pytest.mark.parametrize("seed", range(8))
def test_every_pivot_is_the_largest_entry_that_is_left(seed):
    rows = random_rows(seed)
    reduced, pivots = eliminate_by_largest(rows)
    assert pivots == pivots_by_search(rows) and len(pivots) == 5
    assert [[row[c] for c in pivots] for row in reduced] == np.eye(5).tolist()
    for row in rows:
        sums = [
            sum(row[c] * r[k] for c, r in zip(pivots, reduced, strict=True)) for k in range(8)
        ]
        assert sums == row


def test_equal_entries_come_in_their_order():
    rows = [[Fraction(1), Fraction(-2), Fraction(2)], [Fraction(2), Fraction(0), Fraction(0)]]
    reduced, pivots = eliminate_by_largest(rows)
    assert pivots == [1, 0] and reduced == [[0, 1, -1], [1, 0, 0]]
    assert eliminate_by_largest([[Fraction(0)] * 2]) == ([], [])
    assert eliminate_by_largest([]) == ([], [])


def test_numbers_of_a_field():
    """The second row is √3 times the first."""
    r = root_of_integer(3, 12)
    rows = [[Fraction(1), r, Fraction(0)], [r, Fraction(3), Fraction(0)], [r, r, Fraction(1)]]
    reduced, pivots = eliminate_by_largest(rows)
    assert pivots == [1, 2] and len(reduced) == 2
    for row in rows:
        known = [
            sum(row[c] * x[k] for c, x in zip(pivots, reduced, strict=True)) for k in range(3)
        ]
        assert known == row


def test_the_work_on_blocks_grows_as_the_square_of_their_number():
    """Rows of other blocks do not change, and none of their entries is read again."""

    def work(blocks):
        block = [
            [Fraction(1), Fraction(2), Fraction(3)],
            [Fraction(4), Fraction(5), Fraction(7)],
        ]
        rows = [
            [Fraction(0)] * (3 * k) + row + [Fraction(0)] * (3 * (blocks - k - 1))
            for k in range(blocks)
            for row in block
        ]
        return instructions(lambda: eliminate_by_largest(rows))

    assert work(20) < 5.0 * work(10)
