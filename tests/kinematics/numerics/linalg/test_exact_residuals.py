"""Rows that double precision tells apart, beside rows whose span is known."""

from fractions import Fraction

import numpy as np
import pytest

from kinematics.numerics.linalg import exact_residuals
from kinematics.numerics.linalg.complete_pivoting import eliminate_by_largest
from kinematics.numerics.linalg.cyclotomic import root_of_integer
from kinematics.numerics.linalg.exact_residuals import separate_rows


def hidden_rows(seed, count=12, columns=20):
    """Exact rows that differ by 1e-9 … 1e-40 only, and rows of whole numbers of their span."""
    rng = np.random.default_rng(seed)
    whole = rng.integers(-9, 10, (count, columns))
    plain = [[Fraction(int(x)) for x in row] for row in whole]
    rows = []
    for k, row in enumerate(plain):
        size = Fraction(1, 10 ** int(rng.choice([0, 0, 9, 18, 27, 40])))
        shares = [Fraction(int(rng.integers(-99, 100)), 97) for _ in range(k)]
        rows.append(
            [
                size * x + sum(share * y[c] for share, y in zip(shares, plain, strict=False))
                for c, x in enumerate(row)
            ]
        )
    return rows, whole


def orthonormal(A):
    return np.linalg.svd(np.asarray(A, dtype=np.float64), full_matrices=False)[2]


@pytest.mark.parametrize("seed", range(6))
def test_they_span_what_the_exact_rows_span(seed):
    """Each exact row is a combination of the first ones, with weights that do not vanish."""
    rows, whole = hidden_rows(seed)
    floats = np.array(rows, dtype=np.float64)
    assert np.linalg.matrix_rank(floats, tol=1e-14 * np.linalg.norm(floats)) < len(rows)
    apart = separate_rows(rows)
    values = np.linalg.svd(apart, compute_uv=False)
    known = orthonormal(whole)
    assert apart.shape == floats.shape and values[-1] > 1e-3
    np.testing.assert_allclose(np.linalg.norm(apart, axis=1), 1.0, rtol=1e-14)
    assert np.abs(apart - apart @ known.T @ known).max() < 1e-12


def test_rows_that_are_apart_are_only_scaled():
    rows = [
        [Fraction(3, 7), Fraction(0), Fraction(4, 7)],
        [Fraction(0), Fraction(-(10**400)), 0],
    ]
    np.testing.assert_allclose(separate_rows(rows), [[0.6, 0, 0.8], [0, -1, 0]], rtol=1e-15)
    assert separate_rows([]).shape == (0, 0)


def test_a_combination_of_others_is_refused():
    row = [Fraction(1, 4), Fraction(1, 2)]
    with pytest.raises(ValueError, match="combination of others"):
        separate_rows([row, [2 * x for x in row]])


def test_numbers_grow_by_the_bits_of_a_double_a_pass(monkeypatch):
    """Elimination in fractions multiplies the length of numbers by the number of rows."""
    rng = np.random.default_rng(2)
    rows = [
        [Fraction(int(x), 2**62) for x in row]
        for row in rng.integers(-(2**62), 2**62, (20, 25))
    ]
    small = Fraction(1, 2**100)
    rows.append(
        [
            sum(column) + small * x
            for column, x in zip(zip(*rows, strict=True), rows[0][::-1], strict=True)
        ]
    )
    lengths, measured = [], exact_residuals._measured

    def note(entries, columns):
        lengths.append(max(abs(x).bit_length() for x in entries.values()))
        return measured(entries, columns)

    monkeypatch.setattr(exact_residuals, "_measured", note)
    separate_rows(rows)
    numerators = [x.numerator for row in eliminate_by_largest(rows)[0] for x in row]
    assert len(lengths) > len(rows) and max(lengths) < 62 + 100 + 4 * 53
    assert max(abs(x).bit_length() for x in numerators) > 1000


def test_numbers_of_a_field():
    """1 and √3 are in the span of both pairs, which differ by 1e-30."""
    r, small = root_of_integer(3, 12), Fraction(1, 10**30)
    rows = [[Fraction(1), r, Fraction(0)], [Fraction(1), r, small]]
    apart = separate_rows(rows)
    known = orthonormal([[1.0, 3**0.5, 0.0], [0.0, 0.0, 1.0]])
    assert np.abs(apart - apart @ known.T @ known).max() < 1e-14
    assert np.linalg.svd(apart, compute_uv=False)[-1] > 0.1
