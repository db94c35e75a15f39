"""What is printed does not depend on rounding; rounding is perturbed as it is meant to be."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from tests.support.covering import spread
from tests.support.gallery_commands import SAMPLE, all_commands
from tests.support.gallery_run import changed_commands, changed_lines, run_commands
from tests.support.perturbed_functions import PERTURBED, perturb_last_bits, perturbed, rounding
from tests.support.rounded_operations import OPERATIONS, operation
from tests.support.rounding import COMPILED

UNIT = 2.0**-52
SHORT = np.array([0.0, 1.0, -3.0, 0.375, 2.0**-40, 12345.0])


@pytest.fixture(params=(1, 2, 3))
def seed(request, monkeypatch):
    """Perturbed rounding, in this test."""
    monkeypatch.setattr(rounding, "seed", request.param)
    return request.param


def function(name):
    """The perturbed function of a name, and the plain one."""
    plain = eval(name, {"np": np, "operator": __import__("operator")})  # noqa: S307
    return perturbed(name, plain), plain


def numbers(*shape):
    """Doubles of both signs with all their bits."""
    return np.random.default_rng(shape).uniform(-1.0, 1.0, shape) / 3.0


def exact_product(a, b):
    """The product of two matrices, as rational numbers."""
    rows = [[Fraction(x) for x in row] for row in a]
    columns = [[Fraction(x) for x in column] for column in b.T]
    return [[sum(x * y for x, y in zip(r, c, strict=True)) for c in columns] for r in rows]


@pytest.mark.parametrize("name", ["operator.matmul", "np.dot", "np.einsum"])
def test_sums_of_products_keep_the_bound_of_their_error(name, seed):
    """``|error| ≤ n u Σ |a| |b|``, as on every processor; some entries do change."""
    a, b = numbers(5, 9), numbers(9, 4)
    words = ("ij,jk->ik",) if name == "np.einsum" else ()
    change, plain = function(name)
    result = change(*words, a, b)
    errors = [
        [abs(float(Fraction(x) - y)) for x, y in zip(*rows, strict=True)]
        for rows in zip(result, exact_product(a, b), strict=True)
    ]
    assert np.all(errors <= 9 * UNIT / 2 * (np.abs(a) @ np.abs(b)))
    assert np.any(result != plain(*words, a, b))
    assert np.array_equal(result, change(*words, a.copy(), b.copy()))


def test_a_sum_that_cancels_leaves_a_round_off(seed):
    """A product is rounded once where it is fused with the sum, and twice where it is not."""
    x, y = numbers(2)
    change, _ = function("operator.matmul")
    assert 0.0 < abs(change(np.array([x, -y]), np.array([y, x]))) <= UNIT * abs(x * y)


@pytest.mark.parametrize("name", sorted(PERTURBED))
def test_what_every_processor_computes_exactly_stays(name, seed):
    if not name.startswith(("np.", "operator.")) or name == "np.roots":
        return
    change, plain = function(name)
    if name == "np.tensordot":
        assert np.array_equal(change(SHORT, SHORT, 1), plain(SHORT, SHORT, 1))
    elif name == "np.linalg.norm":
        assert change(np.array([3.0, 4.0])) == 5.0
        assert change(np.array([0.0, -0.1, 0.0])) == 0.1
    elif name in ("operator.matmul", "np.matmul", "np.dot"):
        integers = np.rint(1e9 * numbers(4, 4))
        for a, b in ((SHORT, SHORT), (integers, np.eye(4)), (np.eye(4), numbers(4, 4))):
            assert np.array_equal(change(a, b), plain(a, b))
    elif name in ("np.linalg.solve", "np.linalg.lstsq"):
        arguments = 2.0 * np.eye(3), numbers(3, 1)
        first = change(*arguments)[0], plain(*arguments)[0]
        assert np.array_equal(*first)
    elif name.startswith("np.linalg."):
        result = change(2.0 * np.eye(3))
        first = result[0] if isinstance(result, tuple) else result
        plain_first = plain(2.0 * np.eye(3))
        plain_first = plain_first[0] if isinstance(plain_first, tuple) else plain_first
        assert np.array_equal(first, plain_first)
    elif name in ("np.sin", "np.tan", "np.arctan", "np.sinh", "np.tanh", "np.log1p"):
        assert change(0.0) == 0.0
    elif name in ("np.cos", "np.cosh", "np.exp"):
        assert change(0.0) == 1.0


def test_the_result_of_one_matrix_is_that_of_one_nearby(seed):
    """Singular values move by round-off of the matrix."""
    A = numbers(6, 4)
    change, plain = function("np.linalg.svd")
    moved = np.abs(change(A)[1] - plain(A)[1]).max()
    assert 0.0 < moved < 20 * UNIT


def test_last_bits_change_and_no_others(seed):
    values = numbers(1000)
    units = (perturb_last_bits(values) - values) / np.spacing(values)
    assert set(units) == {-1.0, 0.0, 1.0}
    assert np.array_equal(perturb_last_bits(SHORT), SHORT)
    assert np.array_equal(perturb_last_bits(-values), -perturb_last_bits(values))
    odd = np.array([np.inf, -np.inf, np.nan])
    assert np.array_equal(perturb_last_bits(odd), odd, equal_nan=True)
    assert perturb_last_bits(0.1) == perturb_last_bits(np.array([0.1]))[0]
    assert perturb_last_bits((1, "a", None)) == (1, "a", None)


def test_seeds_differ_and_no_seed_changes_nothing(monkeypatch):
    values, change = numbers(50), function("np.sin")[0]
    results = []
    for seed in (None, 1, 2):
        monkeypatch.setattr(rounding, "seed", seed)
        results.append(change(values))
    assert np.array_equal(results[0], np.sin(values))
    assert not any(np.array_equal(results[i], results[j]) for i, j in ((0, 1), (1, 2), (2, 0)))


@pytest.mark.parametrize("name", sorted(OPERATIONS))
def test_operations_are_exact_or_off_by_a_unit(name, seed):
    change, (plain, _) = operation(name), OPERATIONS[name]
    moved = 0
    for a, b in numbers(200, 2):
        result = change(float(a), float(b))
        assert abs(result - plain(a, b)) <= np.spacing(abs(plain(a, b)))
        moved += result != plain(a, b)
        assert change(3.0, 0.5) == plain(3.0, 0.5) and change(6, 2) == plain(6, 2)
    assert 20 < moved < 150
    array = numbers(20)
    assert operation(f"in place {name}")(array, numbers(20, 1)[:, 0]) is array


def test_numbers_of_the_product_change_and_what_is_printed_does_not(compiled_kernels):
    """A sample of the commands of the gallery."""
    inner = ["verify four_bar_kite --trajectories 1 --json"]
    usual, other = (run_commands([*SAMPLE, *inner], seed) for seed in (None, len(COMPILED)))
    assert set(changed_commands(usual, other)) == set(inner)


@pytest.mark.slow
@pytest.mark.parametrize("variant", spread(tuple(COMPILED), len(COMPILED)))
def test_what_is_printed_does_not_depend_on_rounding(variant):
    """Every command of the gallery, byte for byte: digits, words, notices and exit codes.

    Kernels are compiled in every way with ``ALL_CASES=1``.
    """
    commands = all_commands()
    changed = changed_commands(run_commands(commands), run_commands(commands, 1, variant))
    assert not changed, changed_lines(changed)
