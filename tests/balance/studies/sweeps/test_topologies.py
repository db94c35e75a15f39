"""Columns of a sweep against files into which the numbers are written, one by one.

The files are written here, by another route than that of the sweep, read, closed and computed
by `balance.design_space`. Special geometries have the rank that is known for them, and no other
geometry has it.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
from tests.support.sweep_topologies import Topology, topologies

pytestmark = pytest.mark.lanes

TOPOLOGIES = topologies()
# Those of several loops or in space take seconds uncompiled.
LONG = ("3-RSR", "4-RRR", "Bennett")
CASES = [
    pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in TOPOLOGIES
]
INTEGERS = ("rank", "nullity", "serial", "kmax")


def integers(space: balance.DesignSpace) -> tuple[int, ...]:
    """The integers of a space, as the columns have them."""
    kmax = -1 if space.kmax is None else space.kmax
    return space.rank, space.nullity, space.serial_nullity, kmax


@pytest.mark.table(2)
@pytest.mark.parametrize("name", CASES)
def test_integers_are_those_of_the_written_files(name: str):
    model = TOPOLOGIES[name]
    table = model.sweep(100, seed=7)
    special, answered = table["s"] == 1, table["reason"] == ""
    assert special.sum() == 2 and answered[special].all()
    rows = [*np.flatnonzero(special), *np.flatnonzero(answered & ~special)[:3]]
    for row in rows:
        space = balance.design_space(model.linkage(table, row))
        assert tuple(table[column][row] for column in INTEGERS) == integers(space), row
    parallel = table["nullity"] - table["serial"]
    assert np.array_equal(table["parallel"][answered], parallel[answered])


@pytest.mark.table(2)
@pytest.mark.parametrize("name", CASES)
def test_special_geometries_are_found_and_none_is_invented(name: str):
    model = TOPOLOGIES[name]
    table = model.sweep(100, seed=8)
    special, rank = table["s"] == 1, table["rank"]
    if model.special_rank is not None:
        assert set(rank[special]) == {model.special_rank}
    if name == "Bennett":  # others are rigid
        assert set(table["reason"][~special]) == {"its loops do not close"}
        assert set(rank[~special]) == {-1}
    else:
        assert len(set(rank[~special])) == 1
        assert (rank[special] <= rank[~special].max()).all()


@pytest.mark.parametrize("name", ["four-bar", "gears"])
def test_special_geometries_by_exact_arithmetic(name: str):
    """Where the decimals of the file are those of the special geometry."""
    model = TOPOLOGIES[name]
    table = model.sweep(50, seed=9)
    row = int(np.flatnonzero(table["s"] == 1)[0])
    assert balance.checks.exact_ranks(model.linkage(table, row)).rank == table["rank"][row]


def test_a_special_geometry_whose_decimals_are_rounded():
    """The crank points where no decimals do: exact arithmetic needs others."""
    model = TOPOLOGIES["slider-crank"]
    table = model.sweep(50, seed=9)
    row = int(np.flatnonzero(table["s"] == 1)[0])
    space = balance.certify(balance.design_space(model.linkage(table, row)))
    assert space.certainty.level == "verified" and space.rank == table["rank"][row]


def test_a_wrong_number_is_seen():
    """The comparison can fail: another file has other integers."""
    model: Topology = TOPOLOGIES["four-bar"]
    table = model.sweep(50, seed=9)
    rows = [int(np.flatnonzero(table["s"] == s)[0]) for s in (0, 1)]
    ranks = [balance.design_space(model.linkage(table, row)).rank for row in rows]
    assert ranks == table["rank"][rows].tolist() and ranks[0] != ranks[1]
