"""Searches: what they find, in pieces or at once, and what they never find."""

import numpy as np
import pytest

from balance.studies.discovery.confirm import confirm
from balance.studies.discovery.job import CHUNK_ROWS, DiscoveryJob
from balance.studies.discovery.search_results import read_search
from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import UsageError
from tests.support.covering import number_of_cases

pytestmark = pytest.mark.lanes

FOUR_BARS = {
    frozenset(["AD = BC", "AB = CD"]),
    frozenset(["AD = AB", "BC = CD"]),
    frozenset(["AD = CD", "AB = BC"]),
}


# Two chunks of walks, the second of which may be short.
STARTS = number_of_cases(CHUNK_ROWS + 10, 2 * CHUNK_ROWS)


@pytest.fixture(scope="module")
def four_bars(tmp_path_factory):
    """A search among four-bars, and its families."""
    job = DiscoveryJob("four-bar", STARTS)
    path = tmp_path_factory.mktemp("search") / "four_bars.db"
    with ResultsFile.create(path, job) as file:
        run_chunks(job, file, workers=0)
        return read_search(file)


@pytest.fixture(scope="module")
def sliders(tmp_path_factory):
    """The same among slider-cranks, with the rows of its file."""
    job = DiscoveryJob("slider-crank", STARTS)
    path = tmp_path_factory.mktemp("search") / "sliders.db"
    with ResultsFile.create(path, job) as file:
        run_chunks(job, file, workers=0)
        return job, file.read(), read_search(file).families


@pytest.mark.slow
def test_one_four_bar_in_ten_ends_on_a_special_one(four_bars):
    assert 10 * four_bars.outcomes["special"] >= STARTS


@pytest.mark.slow
def test_the_families_of_the_four_bar_are_the_known_ones(four_bars):
    """The list is proved complete: B. Moore, J. Schicho, C. Gosselin, 2009."""
    families = four_bars.families
    assert {frozenset(family.relations) for family in families} <= FOUR_BARS
    assert {(family.nullity, family.codimension) for family in families} <= {(5, 2), (7, 2)}
    assert len(families) >= 2


@pytest.mark.slow
def test_random_members_confirm_a_family(four_bars):
    done = confirm(four_bars.job.structure, four_bars.families[0], 30)
    assert (done.members, done.agreed) == (30, 30)


@pytest.mark.slow
def test_relations_that_do_not_suffice_are_not_confirmed(four_bars):
    """A family that is told by half of its relations has other members."""
    from dataclasses import replace

    family = four_bars.families[0]
    half = [replace(m, relations=m.relations[:1], held=()) for m in family.members]
    done = confirm(four_bars.job.structure, replace(family, members=tuple(half)), 20)
    assert done.agreed == 0 < done.members


@pytest.mark.slow
def test_only_one_family_of_the_slider_crank(sliders):
    _, _, families = sliders
    (family,) = families
    assert family.relations == ("offset of C from A = 0", "AB = BC")
    assert (family.nullity, family.parallel, family.codimension) == (6, 1, 2)


@pytest.mark.slow
def test_chunks_do_not_depend_on_each_other(sliders, tmp_path):
    """A search in two runs, the second chunk first, gives the rows of one run."""
    job, expected, families = sliders
    pieces = tmp_path / "pieces.db"
    with ResultsFile.create(pieces, job) as file:
        file.write_chunk(1, job.compute(1))
        assert len(read_search(file).families) <= len(families)
    again = DiscoveryJob.from_description(job.description)
    with ResultsFile.resume(pieces, again) as file:
        run_chunks(again, file, workers=0)
        rows = file.read()
        assert [f.relations for f in read_search(file).families] == [
            f.relations for f in families
        ]
    assert all(np.array_equal(rows[name], expected[name]) for name in ("outcome", "geometry"))


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"topology": "four-bar"}'])
def test_what_describes_no_search_is_refused(text):
    with pytest.raises(UsageError, match="no search"):
        DiscoveryJob.from_description(text)
