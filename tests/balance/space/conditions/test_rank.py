"""Ranks of matrices whose rank is known exactly, however they are cut into blocks."""

from __future__ import annotations

import numpy as np
import pytest

from balance.space.conditions import rank
from balance.space.conditions.rank import Conditions
from kinematics.numerics.tolerances import RANK_MARGIN, RANK_RELATIVE
from tests.support.laws import exact_rank, outside

SHAPES = [(1, 1, 1), (5, 3, 2), (3, 5, 3), (8, 8, 5), (30, 12, 7), (12, 30, 9), (60, 70, 43)]


def whole_numbers(shape, seed):
    """A matrix of whole numbers (rows, columns), product of two thin ones."""
    rows, columns, rank = shape
    rng = np.random.default_rng(seed)
    left, right = rng.integers(-4, 5, (rows, rank)), rng.integers(-4, 5, (rank, columns))
    return (left @ right).astype(float)


def gathered(matrix, blocks=1):
    conditions = Conditions.none(matrix.shape[1])
    for block in np.array_split(matrix, blocks):
        conditions = conditions.append(block)
    return conditions


def check(conditions, matrix, rank):
    """Rank, null space and singular values are those of the matrix."""
    decision = conditions.decide()
    p = matrix.shape[1]
    assert conditions.rank == rank == decision.singular_values.size
    basis = decision.basis
    assert basis.shape == (p, p - rank)
    assert basis.T @ basis == pytest.approx(np.eye(p - rank), abs=1e-13)
    size = np.linalg.norm(matrix, 2) if rank else 1.0
    assert np.abs(matrix @ basis).max(initial=0.0) < 1e-12 * size
    assert outside(conditions.factor.T / max(size, 1.0), matrix.T) < 1e-12 if rank else True
    values = decision.singular_values
    if rank:
        expected = np.linalg.svd(matrix, compute_uv=False)[:rank]
        assert values == pytest.approx(expected / expected[0], abs=1e-13)
        assert decision.kept == values[-1] > RANK_RELATIVE
        assert decision.dropped < RANK_RELATIVE


@pytest.mark.table(2)
@pytest.mark.parametrize("blocks", [1, 2, 5])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_rank_is_exact(shape, blocks):
    matrix = whole_numbers(shape, 70)
    check(gathered(matrix, blocks), matrix, exact_rank(matrix))


@pytest.mark.table
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_order_of_rows_and_columns_does_not_matter(shape):
    matrix = whole_numbers(shape, 71)
    rng = np.random.default_rng(72)
    rank = exact_rank(matrix)
    for _ in range(3):
        mixed = matrix[rng.permutation(shape[0])][:, rng.permutation(shape[1])]
        check(gathered(mixed, 2), mixed, rank)


@pytest.mark.parametrize("factor", [1e-30, 1e-3, 1e30])
def test_the_unit_of_the_conditions_does_not_matter(factor):
    matrix = whole_numbers((30, 12, 7), 73)
    conditions = gathered(factor * matrix, 3)
    assert conditions.rank == 7
    assert conditions.contains(-3.0 * factor * matrix[::-1])
    relative = conditions.decide().singular_values
    assert relative == pytest.approx(gathered(matrix, 3).decide().singular_values, abs=1e-13)


def test_conditions_of_unlike_size_all_count():
    """Whole blocks differ by 1e8 without loss, in either order: the floor is near 1e-12."""
    strong, weak = whole_numbers((6, 12, 4), 74), 1e-8 * whole_numbers((6, 12, 3), 75)
    for blocks in ((strong, weak), (weak, strong)):
        assert gathered(np.vstack(blocks), 2).rank == 7


def test_round_off_is_not_a_condition():
    """Neither in the same block nor later, nor in rows made of nothing but round-off."""
    matrix = whole_numbers((30, 12, 7), 76)
    noise = 1e-15 * np.random.default_rng(77).standard_normal(matrix.shape)
    size = np.abs(matrix).max()
    conditions = gathered(matrix + size * noise, 3)
    assert conditions.rank == 7
    later = conditions.append(size * noise)
    assert later.rank == 7 and later.dropped >= conditions.dropped
    assert conditions.contains(size * noise)


@pytest.mark.table(3)
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_rows_of_the_span_are_implied_and_others_are_not(shape):
    matrix = whole_numbers(shape, 78)
    rng = np.random.default_rng(79)
    conditions = gathered(matrix)
    combined = rng.standard_normal((4, shape[0])) @ matrix
    assert conditions.contains(combined)
    assert conditions.contains(matrix)
    assert conditions.append(combined).rank == conditions.rank
    if exact_rank(matrix) == shape[1]:
        return
    combined[rng.integers(4)] += 1e-6 * np.abs(matrix).max() * rng.standard_normal(shape[1])
    assert not conditions.contains(combined)
    assert not conditions.contains(rng.standard_normal((1, 2, 3, shape[1])))
    assert conditions.append(combined).rank == conditions.rank + 1


def test_zero_rows_are_no_conditions():
    matrix = whole_numbers((9, 7, 4), 80)
    padded = np.vstack([np.zeros((3, 7)), matrix[:5], np.zeros((2, 7)), matrix[5:]])
    check(gathered(padded, 6), padded, exact_rank(matrix))
    nothing = Conditions.none(7).append(np.zeros((5, 7)))
    assert nothing.rank == 0 and nothing.contains(np.zeros((2, 7)))
    assert not nothing.contains(matrix)
    assert nothing.append(matrix).rank == exact_rank(matrix)


def test_zero_columns_are_free():
    matrix = whole_numbers((9, 7, 4), 81)
    wide = np.zeros((9, 10))
    wide[:, [0, 2, 3, 5, 6, 8, 9]] = matrix
    conditions = gathered(wide, 2)
    check(conditions, wide, exact_rank(matrix))
    basis = conditions.decide().basis
    assert np.linalg.norm(basis[[1, 4, 7]], axis=1) == pytest.approx(np.ones(3), abs=1e-13)


def test_no_conditions_leave_everything_free():
    conditions = Conditions.none(6)
    decision = conditions.decide()
    assert conditions.rank == 0 and decision.kept == 1.0 and decision.dropped == 0.0
    assert decision.singular_values.size == 0
    assert np.array_equal(decision.basis, np.eye(6))
    assert conditions.contains(np.zeros((3, 6))) and not conditions.contains(np.ones((1, 6)))
    none_added = conditions.append(np.empty((0, 6)))
    assert none_added.rank == 0 and none_added.contains(np.empty((0, 6)))
    assert Conditions.none(0).decide().basis.shape == (0, 0)


def test_blocks_may_have_any_leading_shape():
    matrix = whole_numbers((24, 9, 6), 82)
    one, other = gathered(matrix), Conditions.none(9).append(matrix.reshape(2, 3, 4, 9))
    assert np.array_equal(one.factor, other.factor)


def test_conditions_are_not_changed_by_those_that_follow():
    matrix = whole_numbers((20, 9, 6), 83)
    first = gathered(matrix[:2])
    kept = first.factor.copy()
    first.append(matrix[2:])
    first.contains(matrix)
    assert np.array_equal(first.factor, kept)
    assert np.array_equal(matrix, whole_numbers((20, 9, 6), 83))


def test_the_factor_is_triangular_and_holds_all_conditions():
    """``RᵀR = XᵀX`` up to the remainder; below its diagonal R is zero."""
    matrix = whole_numbers((30, 12, 7), 84)
    conditions = gathered(matrix, 4)
    factor = conditions.factor[:, conditions.permutation]
    assert np.array_equal(np.tril(factor, -1), np.zeros(factor.shape))
    gram = matrix.T @ matrix
    assert np.abs(conditions.factor.T @ conditions.factor - gram).max() < 1e-13 * gram.max()


def of_spectrum(rng, columns, least):
    """A random matrix whose singular values fall from 1 to about ``least``."""
    rows = columns + int(rng.integers(columns))
    left = np.linalg.qr(rng.standard_normal((rows, columns)))[0]
    right = np.linalg.qr(rng.standard_normal((columns, columns)))[0]
    values = [
        np.geomspace(1.0, least, columns),
        np.append(rng.uniform(0.01, 1.0, columns - 1), least),
        np.append(1.0, np.full(columns - 1, least)),
    ][rng.integers(3)]
    return (left * values) @ right * rng.uniform(rng.choice([0.1, 1.0]), 1.0, columns)


@pytest.mark.table(3)
@pytest.mark.parametrize("seed", range(8))
def test_a_pivot_never_hides_that_the_smallest_singular_value_is_near_round_off(seed):
    """Whether decided by pivots or not, with and without solutions that are known before."""
    rng, verdicts = np.random.default_rng((85, seed)), []
    for _ in range(60):
        columns, least = int(rng.integers(2, 90)), 10.0 ** rng.uniform(-11.0, -6.0)
        matrix, known = of_spectrum(rng, columns, least), np.empty((0, columns))
        if rng.integers(2):
            mixing = np.linalg.qr(rng.standard_normal((columns + 5, columns + 5)))[0]
            matrix, known = matrix @ mixing[:columns], mixing[columns:]
        conditions = Conditions.given(known)
        for block in np.array_split(matrix, 3):
            conditions = conditions.append(block)
        values = np.linalg.svd(matrix, compute_uv=False)[:columns]
        decision, margin = conditions.decide(), values[-1] / values[0]
        assert conditions.rank == columns
        assert decision.kept == pytest.approx(margin, rel=1e-3)
        assert decision.ill_conditioned == (margin < RANK_MARGIN * RANK_RELATIVE)
        pivots = np.abs(np.diag(conditions.factor[:, conditions.permutation]))
        assert pivots.min() < 0.1 * RANK_MARGIN * margin * conditions.scale
        verdicts.append(decision.ill_conditioned)
    assert 10 < sum(verdicts) < 50


def test_singular_values_are_computed_only_where_they_are_needed(monkeypatch):
    rng, asked = np.random.default_rng(86), []

    def svd(matrix, compute_uv):
        asked.append(matrix.shape)
        return np.ones(min(matrix.shape))

    firm, close = (gathered(of_spectrum(rng, 9, least)) for least in (1e-2, 1e-8))
    monkeypatch.setattr("numpy.linalg.svd", svd)
    decision = firm.decide()
    assert not decision.ill_conditioned and asked == []
    assert decision.kept == decision.singular_values[-1] == 1.0 and len(asked) == 1
    assert not close.decide().ill_conditioned and len(asked) == 2


def test_a_decomposition_does_not_fail_where_divide_and_conquer_does(monkeypatch):
    A = np.random.default_rng(7).standard_normal((9, 5))

    def fails(*_, **__):
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr(np.linalg, "svd", fails)
    U, values, Vt = rank.singular_value_decomposition(A)
    assert U.shape == (9, 5) and np.abs(U * values @ Vt - A).max() < 1e-13
    assert (np.diff(values) <= 0.0).all() and np.abs(Vt @ Vt.T - np.eye(5)).max() < 1e-13
