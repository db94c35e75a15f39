"""Kernels that have a function of whole arrays for while they are not compiled: both agree."""

from __future__ import annotations

import numpy as np
import pytest

from balance.motion.verification import inertia_wrench_kernels, motion_kernels
from balance.motion.verification.shaking_wrench import inertia_loads, inertia_wrenches
from balance.motion.verification.shaking_wrench import mass_parameters as masses_of
from balance.space.momentum import regressor_kernels
from kinematics.closure import series
from kinematics.closure.joint_positions import input_chain
from kinematics.loading.model_gallery import load
from kinematics.model.spatial import displacements
from kinematics.numerics.compiled.background import compile_mode
from kinematics.numerics.linalg import null_space, pivoted_qr
from kinematics.numerics.linalg.pivoted_qr import Factor, factor_workspace

RNG = np.random.default_rng(3)
RANK, MORE, P = 18, 4, 21
MODULES = {
    inertia_wrench_kernels: ("fill_inertia_wrenches",),
    null_space: ("orthonormal", "put_solutions"),
    pivoted_qr: ("append_rows", "contains_rows", "put_factor", "take_factor", "update_factor"),
    regressor_kernels: ("spatial_regressor",),
    series: ("add_known_twists", "fill_right_side", "sum_columns"),
    displacements: ("place_links",),
}
# Functions of numbers and loops, as they are compiled, and those of whole arrays.
LOOPS = {name: getattr(m, name).py_func for m, names in MODULES.items() for name in names}
WHOLE = {
    name: getattr(m, f"_{name}_by_arrays") for m, names in MODULES.items() for name in names
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


def both(name, make, *numbers):
    """Results of the two functions on equal arguments, and the arrays that they wrote."""
    outcomes = []
    for function in (LOOPS[name], WHOLE[name]):
        made = make()
        answer = function(*made, *numbers)
        outcomes.append((answer, made))
    return outcomes


@pytest.mark.parametrize(("rank", "rows"), [(0, 9), (0, 30), (RANK, 0), (RANK, 2), (RANK, 9)])
def test_factors_and_their_updates(rank, rows):
    """Both have the Gram matrix of the rows, and the same pivots in the same order."""
    rng = np.random.default_rng(8)
    unknowns = np.arange(P)
    R = np.zeros((rank, P))
    order = rng.permutation(P)
    R[:, order] = workspace().F[:rank, :P]
    new = rng.standard_normal((rows, P)) @ np.diag(rng.uniform(0.1, 1.0, P))
    new[:, order[-2]] = new[:, order[-1]] = 0.0  # two unknowns without conditions of their own
    R[:, order[-2:]] = 0.0
    results, before = [], np.abs(R).max(initial=0.0)
    for functions in (LOOPS, WHOLE):
        F, permutation = factor_workspace(P, rank + rows), order.copy()
        functions["take_factor"](R, permutation, F)
        factor = Factor(F, permutation, unknowns, 1e-12)
        functions["append_rows"](factor, rank, new, 1.0)
        reached, scale, remainder = functions["update_factor"](factor, rank, rows, before)
        out = np.zeros((reached, P))
        functions["put_factor"](F, permutation, reached, out)
        results.append((permutation[:reached], out.T @ out, scale))
        assert np.allclose(out.T @ out, R.T @ R + new.T @ new, atol=1e-12)
        assert remainder < 1e-12 and reached == min(rank + rows, P - 2)
        assert np.array_equal(permutation[:rank], order[:rank])
        assert np.allclose(np.tril(out[:, permutation[:reached]], -1), 0.0, atol=1e-13)
    (loops, _, most), (whole, _, largest) = results
    assert np.array_equal(loops, whole) and np.isclose(most, largest, rtol=1e-12)


def test_appended_rows_and_rows_that_follow():
    rows = RNG.standard_normal((MORE, 2 * P))
    (_, (loops,)), (_, (whole,)) = both("append_rows", lambda: (workspace(),), RANK, rows, 0.3)
    assert np.array_equal(loops.F[: RANK + MORE], whole.F[: RANK + MORE])
    follow = np.zeros((2, 2 * P))
    factor = workspace()
    mix = RNG.standard_normal((2, RANK))
    follow[:, factor.columns[factor.permutation]] = mix @ factor.F[:RANK, :P]
    for given, expected in ((rows, False), (follow, True)):
        for function in (LOOPS["contains_rows"], WHOLE["contains_rows"]):
            assert bool(function(workspace(), RANK, given, 1.0, 1.0)) is expected


def test_null_spaces():
    rng = np.random.default_rng(7)
    x = rng.standard_normal((6, 9))
    x[3] = x[:3].sum(axis=0) + 1e-9 * x[3]  # loses its size to the rows before it
    made = [x.copy(), x.copy()]
    LOOPS["orthonormal"](made[0], 6, 8)
    WHOLE["orthonormal"](made[1], 6, 8)
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
        (LOOPS["put_solutions"], WHOLE["put_solutions"]), out, strict=True
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
            (LOOPS["fill_right_side"], WHOLE["fill_right_side"]), sides, strict=True
        ):
            function(6, k, 1, ends, mimics, columns, envelope, t, b)
        assert np.allclose(*sides, atol=1e-13) and np.abs(sides[0]).max() > 0.1


def test_twists_of_columns():
    """Links of a tree: only columns that move a link count, whatever rates the others have."""
    rng = np.random.default_rng(11)
    parent, dim, width, orders = np.array([-1, 0, 1, 0, -1]), 6, 3, 3
    columns = np.zeros((5, width))
    columns[[0, 2, 4], [0, 1, 2]] = 1.0
    moves = np.array([[1, 0, 0], [1, 0, 0], [1, 1, 0], [1, 0, 0], [0, 0, 1]], dtype=bool)
    s, rates = rng.standard_normal((orders, 5, dim)), rng.standard_normal((orders, 5, width))
    ray, results = rng.standard_normal(width), []
    for functions in (LOOPS, WHOLE):
        c, t, v = rates.copy(), np.zeros((orders, 5, width, dim)), np.empty((orders, 5, dim))
        for k in range(orders):
            functions["add_known_twists"](dim, k, parent, columns, moves, s, c, t)
            functions["sum_columns"](dim, k, moves, ray, t, v)
        results.append((c[0][moves], t, v))
        assert not t[:, ~moves].any()
    for loops, whole in zip(*results, strict=True):
        assert np.allclose(loops, whole, atol=1e-13) and np.abs(loops).max() > 0.1


@pytest.mark.lanes
@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("moved", [False, True])
def test_rows_of_the_regressor(force, moved):
    rng = np.random.default_rng(12)
    links, moves = np.array([2, -1, 4, 0]), rng.random((5, 3)) < 0.6
    V, T = rng.standard_normal((2, 4, 5, 6)), rng.standard_normal((2, 4, 5, 3, 6))
    T *= moves[:, :, None]
    start = rng.standard_normal((5, 4, 4)) if moved else np.empty((0, 4, 4))
    results = []
    for functions in (LOOPS, WHOLE):
        H, N = np.zeros((2, 4, 4, 4, 3)), np.zeros((2, 4, 3, 4, 5, 3))
        X = np.zeros((4, 2, 3, 3 if force else 6, 4, 4 if force else 10))
        for first, last in ((0, 1), (2, 3)):  # orders may come in parts
            rows = X[first : last + 1]
            functions["spatial_regressor"](
                first, last, 0, 2, start, links, moves, V, T, H, N, rows
            )
        results.append(X)
    assert np.allclose(*results, atol=1e-12) and np.abs(results[0]).max() > 1.0


@pytest.mark.lanes
@pytest.mark.parametrize("dim", [3, 6])
def test_places_of_links(dim):
    """Of hinges and slides that are not unit screws in the last bits, on the ground or not."""
    rng = np.random.default_rng(13)
    parent, screws = np.array([-1, 0, 1, -1, 3, 0]), rng.standard_normal((6, dim))
    turns = screws[:, : 1 if dim == 3 else 3]
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    turns[[2, 3]] = 0.0
    size, results = 3 if dim == 3 else 4, []
    for functions in (LOOPS, WHOLE):
        H, s, E = np.empty((6, size, size)), np.empty((6, dim)), np.empty((size, size))
        functions["place_links"](parent, screws, np.linspace(-2.0, 3.0, 6), H, s, E)
        results.append((H, s))
    for loops, whole in zip(*results, strict=True):
        assert np.allclose(loops, whole, atol=1e-13)


@pytest.mark.lanes
@pytest.mark.parametrize("model", ["five_bar", "delta"])
def test_regressors_of_momentum_and_its_rate(model):
    chain, rng, results = input_chain(load(model)), np.random.default_rng(15), []
    speeds = rng.standard_normal((2, 1, chain.width))
    sample = (np.zeros(chain.parent.size), *speeds)
    kernel = motion_kernels._regressors_at
    for function in (kernel.py_func, motion_kernels._regressors_at_by_arrays):
        workspace, carried = (
            motion_kernels.load_workspace(chain),
            np.empty((len(chain.parent), 6)),
        )
        function(chain.walked, chain.links, sample, workspace, carried)
        results.append((workspace[2][2], carried))
    for loops, whole in zip(*results, strict=True):
        assert np.allclose(loops, whole, atol=1e-12) and np.abs(loops).max() > 0.1


@pytest.mark.lanes
@pytest.mark.parametrize("resting", [False, True])
def test_inertia_wrenches(resting):
    """Of a helix, a slide and hinges in space, one after another, and a body on the ground."""
    rng = np.random.default_rng(12)
    parent, links = np.array([-1, 0, 1, 0]), np.array([0, -1, 2, 3, 1])
    screws = rng.standard_normal((4, 6))
    screws[2, :3] = 0.0
    sizes = np.linalg.norm(screws[:, :3], axis=1)
    screws /= np.where(sizes > 0.0, sizes, np.linalg.norm(screws[:, 3:], axis=1))[:, None]
    z = rng.standard_normal((5, 10))
    motion = tuple(rng.standard_normal((3, 7, 4)))
    if resting:
        motion = motion[0], 0.0 * motion[1], 0.0 * motion[2]
    results = []
    for functions in (LOOPS, WHOLE):
        work = np.empty((5, 4, 4)), np.empty((4, 6)), np.zeros((2, 5, 6)), np.empty((8, 3))
        wrenches = np.full((7, 5, 6), np.nan)
        functions["fill_inertia_wrenches"](parent, screws, links, z, motion, work, wrenches)
        results.append(wrenches)
    assert np.allclose(*results, rtol=1e-12, atol=1e-12)
    assert not results[0][:, 1].any() and not results[1][:, 1].any()
    assert bool(results[0].any()) is not resting


@pytest.mark.parametrize("model", ["slider_crank", "rusr"])
def test_inertia_wrenches_by_velocities_of_all_joints_and_by_those_of_inputs(model):
    """Along the tree, without the loops, and by the series that close the loops."""
    linkage = load(model)
    chain, z = input_chain(linkage), masses_of(linkage)
    ud, udd = np.array([[1.3]]), np.array([[-0.7]])
    expanded = series.expand_from(chain, chain.screws, ud, 1)
    qd = expanded.C[0, 0] @ ud[0]
    qdd = expanded.C[0, 0] @ udd[0] + expanded.C[0, 1] @ ud[0]
    at = np.zeros((1, chain.parent.size))
    expected = inertia_loads(chain, z, at, ud, udd).rate
    actual = inertia_wrenches(chain, z, at, qd[None], qdd[None])
    assert np.abs(actual - expected).max() < 1e-12 * np.abs(expected).max()


def test_what_is_not_compiled_calls_the_function_of_whole_arrays():
    if compile_mode() == "never":
        assert null_space.orthonormal._uncompiled is WHOLE["orthonormal"]
        assert series.carry_screws._uncompiled is series.carry_screws.py_func
