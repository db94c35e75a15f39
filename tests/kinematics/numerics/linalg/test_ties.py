"""Choices among equal numbers do not depend on their last bits."""

import numpy as np
import pytest

from kinematics.numerics.linalg.ties import (
    first_direction,
    first_largest,
    first_least,
    rank_least_first,
    round_decimals,
)

SEEDS = range(20)


def perturbed(values, rng):
    """Numbers with other last bits, up to four units in the last place."""
    values = np.asarray(values, dtype=np.float64)
    return values * (1.0 + rng.integers(-4, 5, values.shape) * np.finfo(np.float64).eps)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_first_of_equal_numbers_is_chosen(seed):
    rng = np.random.default_rng(seed)
    values = perturbed([1.0, 3.0, 3.0, 3.0, 2.0], rng)
    assert first_largest(values) == 1
    assert first_least(-values) == 1
    assert rank_least_first(values.tolist()) == [0, 4, 1, 2, 3]


@pytest.mark.parametrize("seed", SEEDS)
def test_numbers_that_are_all_round_off_are_equal(seed):
    noise = 1e-15 * np.random.default_rng(seed).standard_normal(6)
    assert first_largest(noise, 1.0) == 0 == first_least(noise, 1.0)
    assert rank_least_first(noise.tolist(), 1.0) == list(range(6))


def test_numbers_that_differ_are_told_apart():
    assert first_largest([1.0, 1.0 + 1e-8]) == 1
    assert first_least([1.0, 1.0 - 1e-8]) == 1
    assert first_largest([1.0, 1.01], relative=0.1) == 0
    assert rank_least_first([2.0, 1.0 + 1e-8, 1.0]) == [2, 1, 0]
    assert first_largest([-3.0, -2.0, -2.0]) == 1
    assert first_least([2.0, 1.0, 1e15]) == 1
    assert first_largest([-2.0, -1.0, -1e15]) == 1


def test_numbers_that_are_not_finite():
    assert first_largest([np.nan, 1.0, 2.0]) == 2
    assert first_largest([1.0, np.inf, np.inf]) == 1
    assert first_least([np.inf, np.inf, 5.0]) == 2
    assert first_largest([np.nan, np.nan]) == 0
    assert rank_least_first([np.inf, 1.0, np.inf, 0.0]) == [3, 1, 0, 2]
    assert rank_least_first([]) == []


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_direction_depends_on_the_span_alone(seed, dimension):
    rng = np.random.default_rng(seed)
    rows = np.linalg.qr(np.random.default_rng(7).standard_normal((4, dimension)))[0].T
    turn = np.linalg.qr(rng.standard_normal((dimension, dimension)))[0]
    chosen, other = first_direction(rows), first_direction(turn @ rows)
    assert np.abs(chosen - other).max() < 1e-12
    assert abs(np.linalg.norm(chosen) - 1.0) < 1e-14
    assert np.abs(chosen - rows.T @ (rows @ chosen)).max() < 1e-13


def test_a_direction_is_a_coordinate_axis_if_one_is_in_the_span():
    rows = np.eye(3)[1:] @ np.diag([1.0, -1.0, -1.0])
    assert first_direction(rows).tolist() == [0.0, 1.0, 0.0]


@pytest.mark.parametrize("seed", SEEDS)
def test_halves_are_rounded_alike(seed):
    halves = np.array([0.25, 0.35, 1.45, -2.5])
    rounded = round_decimals(perturbed(halves, np.random.default_rng(seed)), 1)
    assert rounded.tolist() == round_decimals(halves, 1).tolist()
    assert np.abs(rounded - halves).max() <= 0.05 + 1e-12
    assert round_decimals([1234.0], -2).tolist() == [1200.0]
