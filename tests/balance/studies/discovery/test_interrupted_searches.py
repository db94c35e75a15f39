"""Searches that are stopped, killed and resumed find the same families as one run."""

import json
from pathlib import Path

import pytest

from balance.app.cli.main import main
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.search_results import FamilyTally, read_search
from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import FileError
from tests.support.killed_runs import kill_and_resume, paths_of

pytestmark = pytest.mark.lanes

ROOT = Path(__file__).parents[4]
STARTS = 200
WORDS = (
    "discover",
    "run",
    "--topology",
    "slider-crank",
    "--starts",
    str(STARTS),
    "--seed",
    "5",
)


def families(path):
    """What tells the families of a file apart, and the walks that found them."""
    with ResultsFile.open(path) as file:
        assert file.computed()[0] == STARTS
        return [
            (f.relations, f.nullity, f.codimension, [m.start for m in f.members])
            for f in read_search(file).families
        ]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The families of one run."""
    path = tmp_path_factory.mktemp("whole") / "whole.db"
    job = DiscoveryJob("slider-crank", STARTS, 5)
    with ResultsFile.create(path, job) as file:
        run_chunks(job, file, workers=0)
    found = families(path)
    assert found
    return found


@pytest.mark.slow
def test_short_runs_give_the_families_of_one_run(tmp_path, capsys, caplog, whole):
    """Each run is stopped after its first chunk, and tells so with the families so far."""
    path, runs = tmp_path / "pieces.db", 0
    words = [*WORDS, "--out", str(path), "--resume", "--workers", "0", "--seconds", "1e-9"]
    counts = []
    while True:
        runs += 1
        main([*words, "--json"])
        data = json.loads(capsys.readouterr().out)
        counts.append(len(data["families"]))
        if data["walked"] == STARTS:
            break
        said = f"time is up after {data['walked']} of {STARTS} walks, with {counts[-1]} "
        assert said in caplog.text
        assert runs < 10
    assert runs > 2 and families(path) == whole
    assert counts == sorted(counts) and counts[-1] == len(whole)


@pytest.mark.slow
def test_killed_runs_give_the_families_of_one_run(tmp_path, whole):
    path = tmp_path / "killed.db"

    def covered():
        try:
            with ResultsFile.open(path) as file:
                return file.computed()[0]
        except FileError:
            return 0

    words = [*WORDS, "--out", str(path), "--resume", "--workers", "1"]
    run = "tests.support.held_runs"
    rows = kill_and_resume(run, words, covered, STARTS, 2, 1, paths_of(ROOT))
    assert rows == sorted(rows) and rows[-1] < STARTS
    assert families(path) == whole


@pytest.mark.slow
def test_the_progress_tells_the_families_so_far(tmp_path, monkeypatch, whole):
    """The bar gets a count that grows to that of the families found."""
    from contextlib import contextmanager

    remarks = []

    @contextmanager
    def bar(what, rate=False):
        yield lambda done, total, remark="": remarks.append((done, remark))

    monkeypatch.setattr("balance.app.cli.discover.progress_bar", bar)
    monkeypatch.setattr("balance.studies.discovery.search_results.TALLY_PAUSE", 0.0)
    main([*WORDS, "--out", str(tmp_path / "a.db"), "--workers", "0"])
    counts = [int(text.split()[0]) for _, text in remarks]
    assert remarks[0] == (0, "0 families so far") and remarks[-1][0] == STARTS
    assert counts == sorted(counts) and counts[-1] == len(whole)


@pytest.mark.slow
def test_families_are_not_counted_all_the_time(tmp_path, monkeypatch):
    """A count is kept for a while."""
    monkeypatch.setattr("balance.studies.discovery.search_results.TALLY_PAUSE", 1e9)
    job = DiscoveryJob("slider-crank", 100, 5)
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        tally = FamilyTally(file)
        assert tally.count() == 0
        file.write_chunk(0, job.compute(0))
        found = len(read_search(file).families)
        assert found > 0 and tally.count() == 0 and FamilyTally(file).count() == found
