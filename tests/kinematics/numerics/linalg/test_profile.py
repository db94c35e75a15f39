"""Loop matrices factorised within their profile solve what full ones solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import qr

from kinematics.closure.series import expand, loop_matrix, series_workspace
from kinematics.model.arrays import Chain, Frame, freeze
from kinematics.numerics.linalg import skyline_qr
from kinematics.numerics.linalg.skyline_qr import (
    COUNT,
    HEIGHT,
    JOINT,
    ROW,
    ROWS,
    envelope_table,
)


def row(loops, seed, mimics=0):
    """A planar row of coupled five-bars, whose loops come in random order.

    The last link of each on the ground is the first of the next.
    """
    rng = np.random.default_rng(seed)
    parent, ends, first = [-1], [], 0
    for _ in range(loops):
        n = len(parent)
        parent += [first, n, n + 1, -1]
        ends.append((n + 2, n + 3))
        first = n + 3
    order = rng.permutation(loops)
    n = len(parent)
    follow = np.zeros((mimics, n))
    for row, j in zip(follow, rng.choice(n - 1, mimics, replace=False), strict=True):
        row[j + 1], row[j] = 1.0, -0.5
    screws = np.column_stack([np.ones(n), rng.standard_normal((n, 2))])
    whole = np.int64
    chain = Chain(
        frame=Frame(),
        joints=freeze(range(n), whole),
        units=freeze(np.ones(n)),
        parent=freeze(parent, whole),
        screws=freeze(screws),
        ends=freeze(np.array(ends)[order], whole),
        mimics=freeze(follow),
        dependent=freeze([], whole),
        columns=freeze(np.zeros((n, 0))),
        moves=freeze(np.ones((n, n - 3 * loops - mimics)), np.bool_),
        links=freeze(range(n), whole),
    )
    pivots = qr(loop_matrix(chain), mode="r", pivoting=True)[1]
    dependent, inputs = np.split(pivots, [3 * loops + mimics])
    columns = np.zeros((n, inputs.size))
    columns[inputs, np.arange(inputs.size)] = 1.0
    return replace(chain, dependent=freeze(dependent, whole), columns=freeze(columns))


@pytest.mark.table(2)
@pytest.mark.parametrize(("loops", "mimics"), [(3, 0), (9, 0), (9, 3), (40, 0), (40, 7)])
def test_rates_close_the_loops(loops, mimics):
    chain = row(loops, seed=loops, mimics=mimics)
    rates = expand(chain, np.ones((1, chain.width)), 0).C[0, 0]
    A = loop_matrix(chain)
    expected = chain.columns.copy()
    expected[chain.dependent] = -np.linalg.solve(A[:, chain.dependent], A @ chain.columns)
    assert np.linalg.cond(A[:, chain.dependent]) < 1e4
    assert np.abs(rates - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize(("loops", "mimics"), [(1, 0), (3, 1), (9, 3), (40, 7)])
def test_whole_arrays_and_loops_factor_alike(loops, mimics):
    """The functions for compiled and for uncompiled runs; also where a column is zero."""
    chain = row(loops, seed=loops, mimics=mimics)
    lines = chain.walked[6]
    filled, results = series_workspace(chain, 1, 1)[0], []
    skyline_qr.fill_envelope.py_func(chain.screws, chain.mimics, lines, filled)
    filled[-1] = 0.0
    for kind in ("py_func", "by_arrays"):
        factor, solve = (
            getattr(getattr(skyline_qr, name), kind, None)
            or getattr(skyline_qr, f"_{name}_{kind}")
            for name in ("factor_envelope", "solve_least_norm")
        )
        F, diagonal = filled.copy(), np.full(len(filled), np.nan)
        b = np.linspace(1.0, 2.0, lines[COUNT, ROWS])
        factor(F, lines, diagonal)
        results.append((F, diagonal, solve(F, lines, diagonal, b), b))
    for by_loops, by_arrays in zip(*results, strict=True):
        assert np.allclose(by_loops, by_arrays, rtol=1e-8, atol=1e-11)


def test_the_profile_is_as_wide_for_many_loops_as_for_few():
    widths = []
    for loops in (20, 160):
        chain = row(loops, seed=1)
        dependent = np.setdiff1d(np.arange(chain.parent.size), np.arange(0, 4 * loops + 1, 4))
        lines = envelope_table(chain.parent, chain.ends, chain.mimics, dependent, 3)
        first, joints = lines[ROW, :loops], lines[JOINT, : dependent.size]
        assert lines[COUNT, ROWS] == 3 * loops
        assert sorted(first.tolist()) == list(range(0, 3 * loops, 3))
        assert sorted(joints.tolist()) == dependent.tolist()
        widths.append(lines[COUNT, HEIGHT])
    assert widths[1] <= widths[0] < 40
