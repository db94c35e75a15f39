"""Searches: what they find, in pieces or at once, and what they never find."""

import numpy as np
import pytest

from balance.discovery.confirm import confirm
from balance.discovery.families import group_members
from balance.discovery.job import DiscoveryJob, geometry_of_text
from balance.discovery.results import found_in
from balance.result_files.chunk_runs import run_chunks
from balance.result_files.results_file import ResultsFile
from kinematics.errors import UsageError

FOUR_BARS = {
    frozenset(["AD = BC", "AB = CD"]), frozenset(["AD = AB", "BC = CD"]),
    frozenset(["AD = CD", "AB = BC"]),
}  # fmt: skip


def searched(name, starts, seed=1):
    """The job, its outcomes and its families."""
    job = DiscoveryJob(name, starts, seed)
    outcomes, found = [], []
    for chunk in range(-(-starts // job.chunk_rows)):
        rows = job.compute(chunk)
        for k, fate in enumerate(rows["outcome"]):
            outcomes.append(fate)
            if fate == "special":
                where = geometry_of_text(rows["geometry"][k])
                numbers = (
                    int(rows["nullity"][k]),
                    int(rows["codimension"][k]),
                    rows["margin"][k],
                )
                found.append((chunk * job.chunk_rows + k, where, *numbers))
    return job, outcomes, group_members(job.topology, job.structure, job.generic, found)


@pytest.fixture(scope="module")
def four_bars():
    return searched("four-bar", 100)


def test_one_four_bar_in_ten_ends_on_a_special_one(four_bars):
    _, outcomes, _ = four_bars
    assert outcomes.count("special") >= 10


def test_the_families_of_the_four_bar_are_the_known_ones(four_bars):
    """The list is proved complete: B. Moore, J. Schicho, C. Gosselin, 2009."""
    _, _, families = four_bars
    assert {frozenset(family.relations) for family in families} <= FOUR_BARS
    assert {(family.nullity, family.codimension) for family in families} <= {(5, 2), (7, 2)}
    assert len(families) >= 2


def test_random_members_confirm_a_family(four_bars):
    job, _, families = four_bars
    done = confirm(job.structure, families[0], 30)
    assert (done.members, done.agreed) == (30, 30)


def test_relations_that_do_not_suffice_are_not_confirmed(four_bars):
    """A family that is told by half of its relations has other members."""
    from dataclasses import replace

    job, _, families = four_bars
    half = [replace(m, relations=m.relations[:1], held=()) for m in families[0].members]
    done = confirm(job.structure, replace(families[0], members=tuple(half)), 20)
    assert done.agreed == 0 < done.members


def test_only_one_family_of_the_slider_crank():
    _, _, families = searched("slider-crank", 100)
    (family,) = families
    assert family.relations == ("offset of C from A = 0", "AB = BC")
    assert (family.nullity, family.parallel, family.codimension) == (6, 1, 2)


def test_chunks_do_not_depend_on_each_other(tmp_path):
    """A search in two runs gives the rows of one run."""
    job = DiscoveryJob("slider-crank", 100, 3)
    whole, pieces = tmp_path / "whole.db", tmp_path / "pieces.db"
    with ResultsFile.create(whole, job) as file:
        run_chunks(job, file, workers=0)
        expected = file.read()
        families = found_in(file).families
    with ResultsFile.create(pieces, job) as file:
        file.write_chunk(1, job.compute(1))
        assert len(found_in(file).families) <= len(families)
    again = DiscoveryJob.from_description(job.description)
    with ResultsFile.resume(pieces, again) as file:
        run_chunks(again, file, workers=0)
        rows = file.read()
        assert [f.relations for f in found_in(file).families] == [f.relations for f in families]
    assert all(np.array_equal(rows[name], expected[name]) for name in ("outcome", "geometry"))


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"topology": "four-bar"}'])
def test_what_describes_no_search_is_refused(text):
    with pytest.raises(UsageError, match="no search"):
        DiscoveryJob.from_description(text)
