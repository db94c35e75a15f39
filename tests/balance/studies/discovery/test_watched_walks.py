"""Watched walks: their steps, and that watching changes nothing."""

import numpy as np
import pytest

from balance.studies.discovery.job import DiscoveryJob, geometry_of_text
from balance.studies.discovery.walk import ARRIVED, conditions_at
from balance.studies.discovery.watch import first_special_start, watch_walk

pytestmark = pytest.mark.lanes


@pytest.fixture(scope="module")
def watched():
    job = DiscoveryJob("four-bar", 50)
    return watch_walk(job, first_special_start(job))


@pytest.mark.slow
def test_the_singular_value_falls_at_each_step(watched):
    assert len(watched.ratios) > 3
    assert (np.diff(watched.ratios) < 0.0).all()
    assert watched.ratios[0] > 1e-4 and watched.ratios[-2] <= ARRIVED
    assert watched.polished and watched.ratios[-1] < 1e-14


def test_the_values_are_those_of_the_geometries(watched):
    again = conditions_at(watched.job.structure, watched.geometry).values
    ratios = again[:, watched.kept] / again[:, 0]
    np.testing.assert_allclose(ratios, watched.ratios, rtol=1e-6, atol=1e-14)
    steps = watched.ratios[: len(watched.falling)]
    np.testing.assert_allclose(watched.falling, steps, rtol=1e-6, atol=1e-14)


def test_the_next_singular_value_does_not_vanish(watched):
    assert watched.values[-1, watched.kept - 1] > 1e-4
    assert watched.nullity == watched.job.generic + 1


@pytest.mark.slow
def test_watching_changes_nothing(watched):
    numbers = range(watched.start, watched.start + 1)
    seen = []
    alone = watched.job.rows_of(numbers)
    again = watched.job.rows_of(numbers, lambda lanes, _, values: seen.append(lanes))
    assert alone["geometry"] == again["geometry"] and alone["outcome"] == ["special"]
    assert len(seen) == len(watched.falling) == len(watched.ratios) - watched.polished
    chunk = watched.job.compute(0)
    assert chunk["outcome"][watched.start] == watched.outcome
    assert chunk["steps"][watched.start] >= len(seen) - 1


@pytest.mark.slow
def test_the_start_that_is_found_is_the_first(watched):
    outcomes = watched.job.compute(0)["outcome"]
    assert outcomes.index("special") == watched.start


def test_the_relations_hold_at_the_end(watched):
    """Opposite or neighbouring links are equal, by the distances of the joints themselves."""
    text = watched.job.rows_of(range(watched.start, watched.start + 1))["geometry"][0]
    for points in (geometry_of_text(text).points[0], watched.geometry.points[-1]):
        sites = points[[watched.job.structure.origin.tolist().index(k) for k in range(4)]]
        ab, bc, cd, da = np.sqrt(np.sum((sites - np.roll(sites, -1, axis=0)) ** 2, axis=1))
        pairs = (((ab, cd), (bc, da)), ((ab, da), (bc, cd)), ((ab, bc), (cd, da)))
        assert min(max(abs(a - b), abs(c - d)) for (a, b), (c, d) in pairs) < 1e-9


@pytest.mark.slow
def test_a_walk_that_does_not_arrive_has_no_relations():
    job = DiscoveryJob("four-bar", 50)
    outcomes = job.compute(0)["outcome"]
    found = watch_walk(job, outcomes.index("not arrived"))
    assert (found.outcome, found.nullity, found.relations) == ("not arrived", -1, ())
    assert not found.polished and found.ratios[-1] > ARRIVED


@pytest.mark.slow
def test_a_walk_to_masses_that_can_be_built():
    """What it lowers falls at each step; the singular value need not."""
    job = DiscoveryJob("four-bar", 50, buildable=True)
    found = watch_walk(job, first_special_start(job))
    assert (np.diff(found.falling) < 0.0).all() and found.falling[-1] < 1e-5
    assert found.ratios[-1] < 1e-14 and found.outcome == "special"
