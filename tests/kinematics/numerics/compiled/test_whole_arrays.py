"""Kernels that have a function of whole arrays for while they are not compiled: both agree."""

from __future__ import annotations

import numpy as np
import pytest

from kinematics.closure import series
from kinematics.numerics.compiled.background import compile_mode
from kinematics.numerics.linalg import null_space, pivoted_qr
from kinematics.numerics.linalg.pivoted_qr import Factor, factor_workspace

RNG = np.random.default_rng(3)
RANK, MORE, P = 18, 4, 21
# Functions of numbers and loops, as they are compiled.
LOOPS = {
    name: getattr(module, name).py_func
    for module, names in (
        (null_space, ("orthonormal", "put_solutions")),
        (
            pivoted_qr,
            (
                "apply_reflector",
                "apply_reflector_sparse",
                "append_rows",
                "contains_rows",
                "update_factor",
            ),
        ),
        (series, ("fill_right_side",)),
    )
    for name in names
}


def workspace():
    """A factor of P unknowns with rows below it, its columns permuted; the same each time."""
    rng = np.random.default_rng(5)
    F = factor_workspace(P, RANK + MORE)
    F[:] = rng.standard_normal(F.shape)
    F[:, P:] = 0.0
    F[:RANK] = np.triu(F[:RANK]) + 5.0 * np.eye(RANK, F.shape[1])
    F[RANK + 1, 2] = 0.0  # a multiplier that is skipped
    return Factor(F, rng.permutation(P), 2 * np.arange(P), 1e-12)


def arrays(name):
    """The function of whole arrays of a kernel."""
    module = {"orthonormal": null_space, "put_solutions": null_space, "fill_right_side": series}
    names = {
        "apply_reflector": "_reflect_and_measure_by_arrays",
        "apply_reflector_sparse": "_reflect_by_arrays",
    }
    return getattr(module.get(name, pivoted_qr), names.get(name, f"_{name}_by_arrays"))


def both(name, make, *numbers):
    """Results of the two functions on equal arguments, and the arrays that they wrote."""
    outcomes = []
    for function in (LOOPS[name], arrays(name)):
        made = make()
        answer = function(*made, *numbers)
        outcomes.append((answer, made))
    return outcomes


@pytest.mark.parametrize("k", [0, 3, 17])
def test_reflectors(k):
    begin, end = RANK, RANK + MORE
    for name, first in (("apply_reflector_sparse", begin), ("apply_reflector", k + 1)):
        results = []
        for function in (LOOPS[name], arrays(name)):
            F = workspace().F
            norms, column = np.zeros(F.shape[1]), F[[k, *range(first, end)], k]
            sparse = name.endswith("sparse")
            rows, more = ((begin, end), ()) if sparse else ((end,), (norms,))
            size = -np.copysign(np.linalg.norm(column), column[0])
            function(F.reshape(F.size), F.shape[1], k, *rows, size, *more)
            results.append((F[:-1], np.delete(norms, k)))
        for loops, whole in zip(*results, strict=True):
            assert np.allclose(loops, whole, rtol=1e-12, atol=1e-12)


def test_appended_rows_and_rows_that_follow():
    rows = RNG.standard_normal((MORE, 2 * P))
    (_, (loops,)), (_, (whole,)) = both("append_rows", lambda: (workspace(),), RANK, rows, 0.3)
    assert np.array_equal(loops.F[: RANK + MORE], whole.F[: RANK + MORE])
    follow = np.zeros((2, 2 * P))
    factor = workspace()
    mix = RNG.standard_normal((2, RANK))
    follow[:, factor.columns[factor.permutation]] = mix @ factor.F[:RANK, :P]
    for given, expected in ((rows, False), (follow, True)):
        for function in (LOOPS["contains_rows"], arrays("contains_rows")):
            assert bool(function(workspace(), RANK, given, 1.0, 1.0)) is expected


def test_null_spaces():
    rng = np.random.default_rng(7)
    x = rng.standard_normal((6, 9))
    x[3] = x[:3].sum(axis=0) + 1e-9 * x[3]  # loses its size to the rows before it
    made = [x.copy(), x.copy()]
    LOOPS["orthonormal"](made[0], 6, 8)
    arrays("orthonormal")(made[1], 6, 8)
    for rows in made:
        assert np.allclose(rows[:, :8] @ rows[:, :8].T, np.eye(6), atol=1e-12)
    assert np.allclose(made[0], made[1], atol=1e-6)
    factor = workspace()
    R = np.zeros((RANK, P))
    R[:, factor.permutation] = factor.F[:RANK, :P]
    known = np.zeros((2, 2 * P + 1))
    known[0, 1] = known[1, 3] = 1.0
    out = [np.empty((2 + P - RANK, 2 * P + 1)) for _ in range(2)]
    for function, solutions in zip(
        (LOOPS["put_solutions"], arrays("put_solutions")), out, strict=True
    ):
        function(known, R, factor.permutation, factor.columns, solutions)
        assert np.abs(solutions[:, factor.columns] @ R.T).max() < 1e-9
        assert np.allclose(solutions @ solutions.T, np.eye(len(solutions)), atol=1e-12)
    assert np.allclose(*out, atol=1e-6)


def test_right_sides_of_welds_and_relations():
    rng = np.random.default_rng(9)
    ends, mimics = np.array([[0, 3], [-1, 2], [1, -1]]), rng.standard_normal((2, 5))
    columns, t = rng.standard_normal((5, 2)), rng.standard_normal((2, 5, 2, 6))
    envelope = np.zeros((series.ROW + 1, 5), np.int64)
    envelope[series.ROW] = [0, 6, 12, 18, 19]
    for k in (0, 1):
        sides = [np.full(20, np.nan) for _ in range(2)]
        for function, b in zip(
            (LOOPS["fill_right_side"], arrays("fill_right_side")), sides, strict=True
        ):
            function(6, k, 1, ends, mimics, columns, envelope, t, b)
        assert np.allclose(*sides, atol=1e-13) and np.abs(sides[0]).max() > 0.1


def test_what_is_not_compiled_calls_the_function_of_whole_arrays():
    if compile_mode() == "never":
        assert null_space.orthonormal._uncompiled is arrays("orthonormal")
        assert pivoted_qr.update_factor._uncompiled is LOOPS["update_factor"]
