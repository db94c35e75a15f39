"""Borrowed workspaces: results are arrays of their own, whatever else is computed."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import kinematics
from balance.space.momentum.regressor import RegressorSeries, rows_at
from kinematics.closure.newton import expand_at, forward_kinematics
from kinematics.closure.series import expand
from kinematics.model.arrays import freeze

MODELS = ["four_bar_general", "five_bar", "bennett", "three_rsr", "delta"]
ORDER = 3


def rays_of(chain, seed=0):
    return np.random.default_rng(seed).standard_normal((2, chain.width))


def regressor(chain, series, force=False):
    return RegressorSeries(chain, series, force).rows(series.order)


def arrays_in(item):
    """All arrays in nested tuples and lists."""
    if isinstance(item, np.ndarray):
        return [item]
    parts = item if isinstance(item, tuple | list) else ()
    return [x for part in parts for x in arrays_in(part)]


def borrowed(chain):
    """All arrays that were given back."""
    return arrays_in(list(chain.structure.workspaces.values()))


def fresh(name):
    """A chain that nobody else uses, planar if it can be."""
    chain = kinematics.load(name).chain
    return replace(chain, structure=None)


@pytest.mark.parametrize("name", MODELS)
def test_results_stay_when_others_are_computed(name):
    chain = fresh(name)
    series = expand(chain, rays_of(chain), ORDER)
    results = [*series, regressor(chain, series), regressor(chain, series, True)]
    copies = [x.copy() for x in results]
    other = replace(chain, screws=freeze(1.5 * chain.screws))
    assert other.structure is chain.structure
    more = expand(other, rays_of(chain, 1), ORDER)
    others = [*more, regressor(other, more), regressor(other, more, True)]
    assert all(np.array_equal(x, copy) for x, copy in zip(results, copies, strict=True))
    kept = borrowed(chain)
    assert kept
    assert not any(np.shares_memory(x, y) for x in results for y in [*others, *kept])


@pytest.mark.parametrize("name", MODELS)
def test_results_do_not_depend_on_what_a_workspace_holds(name):
    """The second time, on NaNs."""
    chain, found = fresh(name), []
    for _ in range(2):
        for array in borrowed(chain):
            array.fill(np.nan)
        series = expand(chain, rays_of(chain), ORDER)
        found.append([*series, regressor(chain, series), regressor(chain, series, True)])
    assert all(np.array_equal(x, y) for x, y in zip(*found, strict=True))


@pytest.mark.parametrize("name", MODELS)
def test_orders_that_are_asked_for_in_turn_are_those_of_one_call(name):
    """Two series of one chain, of which each has to keep its lower orders."""
    chain = fresh(name)
    pair = [expand(chain, rays_of(chain, seed), ORDER) for seed in range(2)]
    whole = [regressor(chain, series) for series in pair]
    turns = [RegressorSeries(chain, series) for series in pair]
    parts = [[one.rows(0) for one in turns], [one.rows(ORDER) for one in turns]]
    for x, first, rest in zip(whole, *parts, strict=True):
        assert np.array_equal(x, np.concatenate([first, rest]))


def test_a_workspace_is_made_once():
    chain = fresh("three_rsr")
    pose = forward_kinematics(chain, np.zeros(chain.parent.size))
    for _ in range(3):
        regressor(chain, expand(chain, rays_of(chain), ORDER))
        rows_at(chain, pose)
        expand_at(chain, pose)
    assert {len(kept) for kept in chain.structure.workspaces.values()} == {1}


def test_threads_have_workspaces_of_their_own():
    chain = fresh("three_rsr")
    given = [rays_of(chain, seed) for seed in range(8)]

    def run(rays):
        return regressor(chain, expand(chain, rays, ORDER))

    alone = [run(rays) for rays in given]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(run, given * 20))
    assert all(np.array_equal(x, alone[i % 8]) for i, x in enumerate(together))
