"""Combinations of few columns are found where they are known to be."""

from __future__ import annotations

import numpy as np
import pytest

from balance.space.interpretation.freedoms import SparseSearch
from tests.support.laws import outside

SEEDS = range(10)


def planted(seed, serial=3, terms=(1, 2, 3)):
    """A space of random vectors, and of combinations of few columns of a vocabulary."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((30, 60))
    columns /= np.linalg.norm(columns, axis=0)
    few = np.zeros((60, len(terms)))
    places = rng.permutation(60)
    for k, count in enumerate(terms):
        few[places[3 * k : 3 * k + count], k] = rng.choice([-1.0, 1.0], count)
    basis = np.linalg.qr(np.hstack([rng.standard_normal((30, serial)), columns @ few]))[0]
    return SparseSearch.of(basis, serial, columns, np.ones(60)), basis, columns, few


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_planted_combinations_are_found(seed):
    search, basis, columns, few = planted(seed)
    found = np.array(search.independent()).T
    assert [np.count_nonzero(x) for x in found.T] == [1, 2, 3]
    assert outside(columns @ found, basis) < 1e-12
    assert (np.flatnonzero(found[:, 0]) == np.flatnonzero(few[:, 0])).all()
    both = np.hstack([basis[:, :3], columns @ found])
    assert outside(basis, both) < 1e-12


@pytest.mark.table(3)
@pytest.mark.parametrize("seed", SEEDS)
def test_each_solution_is_new_and_balances(seed):
    """Whatever the terms: here no combination of few columns lies in the space."""
    rng = np.random.default_rng(seed)
    basis = np.linalg.qr(rng.standard_normal((12, 6)))[0]
    columns = rng.standard_normal((12, 20))
    columns /= np.linalg.norm(columns, axis=0)
    search = SparseSearch.of(basis, 2, columns, np.ones(20))
    found = np.array(search.independent()).T
    assert found.shape == (20, 4)
    assert outside(columns @ found, basis) < 1e-10
    both = np.hstack([basis[:, :2], columns @ found])
    assert np.linalg.matrix_rank(both, 1e-9) == 6


def test_a_direction_without_a_sparse_solution_has_a_dense_one():
    search, basis, columns, _ = planted(0)
    w = np.array([0.6, 0.0, -0.8])
    x = search.dense(w)
    assert outside((columns @ x)[:, None], basis) < 1e-12
    assert np.abs(search.shadow @ x - w).max() < 1e-12


def test_the_cheaper_of_equal_columns_is_taken():
    rng = np.random.default_rng(0)
    basis = np.linalg.qr(rng.standard_normal((6, 2)))[0]
    columns = np.column_stack([basis[:, 1], basis[:, 1], rng.standard_normal((6, 4))])
    for cheap in (0, 1):
        cost = np.ones(6)
        cost[1 - cheap] = 1.5
        (x,) = SparseSearch.of(basis, 1, columns, cost).independent()
        assert np.flatnonzero(x).tolist() == [cheap]
