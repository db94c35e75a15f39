"""Runs of jobs: the same rows whoever computes them, and whatever ends on the way."""

from __future__ import annotations

import logging
import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path
from time import monotonic

import pytest

from balance.studies.runs import chunk_worker, dask_workers
from balance.studies.runs.chunk_runs import run_chunks, usable_cores
from balance.studies.runs.export import export_csv
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import LinkageError, UsageError, WorkerError
from tests.support.covering import number_of_cases
from tests.support.killed_runs import kill_and_resume, paths_of, start_held
from tests.support.run_squares import JOB
from tests.support.squares import Squares
from tests.support.waiting import HANGS, wait_until_true

ROOT = Path(__file__).parents[4]
RUN = "tests.support.run_squares"
ENVIRONMENT = paths_of(ROOT)
posix = pytest.mark.skipif(os.name != "posix", reason="SIGKILL")


def exported(path: Path, job: Squares) -> bytes:
    """The CSV of a complete file."""
    with ResultsFile.open(path) as file:
        assert not list(file.pending())
        export_csv(file, f"{path}.csv")
    return Path(f"{path}.csv").read_bytes()


def undisturbed(folder: Path, job: Squares) -> bytes:
    """The CSV of one run in one process."""
    path = folder / "undisturbed.db"
    with ResultsFile.create(path, job) as file:
        summary = run_chunks(job, file, workers=0)
    assert (summary.rows, summary.kept, summary.lost_workers) == (job.rows, 0, 0)
    return exported(path, job)


def covered(path: Path) -> int:
    """The rows that the file of a run in another process covers."""
    try:
        with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as connection:
            found = connection.execute("SELECT TOTAL(rows) FROM chunks").fetchone()[0]
        connection.close()
        return int(found)
    except sqlite3.OperationalError:
        return 0


@pytest.mark.slow
@pytest.mark.table(1)
@posix
@pytest.mark.parametrize("where", [{"workers": 2}, {"workers": 2, "dask": "local"}])
def test_a_worker_may_die(tmp_path, where):
    """Its chunks are computed again by another, and all rows are those of one process."""
    if "dask" in where:
        pytest.importorskip("distributed")
    job = Squares(rows=3000, deadly=5, grave=str(tmp_path / "grave"))
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        seen: list[tuple[int, int]] = []
        summary = run_chunks(job, file, progress=lambda *pair: seen.append(pair), **where)
    assert (tmp_path / "grave").exists()
    assert summary.chunks == 47 and summary.rate > 0.0
    assert summary.lost_workers == (0 if "dask" in where else 1)
    assert seen[0] == (0, 3000) and seen[-1] == (3000, 3000) and seen == sorted(seen)
    assert exported(tmp_path / "a.db", job) == undisturbed(tmp_path, job)


@pytest.mark.slow
@posix
def test_a_chunk_that_ends_every_worker_ends_the_run(tmp_path):
    job = Squares(deadly=5)
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        with pytest.raises(WorkerError, match="chunk 5 has ended its process 3 times"):
            run_chunks(job, file, workers=2)
        assert 0 < file.computed()[0] < job.rows


@pytest.mark.table(1)
@pytest.mark.parametrize("where", [{"workers": 0}, {"workers": 1}, {"dask": "local"}])
def test_what_a_chunk_is_refused_for_is_told(tmp_path, where):
    """A refusal stays one; anything else is a defect; what was written is kept.

    The chunk is handed out after others have come back, whatever computes them.
    """
    if "dask" in where:
        pytest.importorskip("distributed")
        where = {**where, "workers": 1}
    bad = dask_workers.LEAST + 3
    for number, job in enumerate((Squares(refused=bad), Squares(broken=bad))):
        with ResultsFile.create(tmp_path / f"{number}.db", job) as file:
            with pytest.raises((LinkageError, RuntimeError)) as caught:
                run_chunks(job, file, **where)
            assert file.computed()[0] >= 64 * 4
        if number == 0:
            assert str(caught.value) == f"chunk {bad} is not wanted"
            assert not isinstance(caught.value, UsageError)
        else:
            assert f"chunk {bad}: ZeroDivisionError: by zero" in str(caught.value)
            assert not isinstance(caught.value, LinkageError)


def test_workers_of_another_version_are_refused(tmp_path, monkeypatch):
    job = Squares()
    outcome = chunk_worker.compute_chunk(job, 0)
    chunk_worker.values_of(outcome)
    with pytest.raises(WorkerError, match=r"a worker runs version 0\.1, and this is"):
        chunk_worker.values_of(outcome._replace(program="0.1"))


@pytest.mark.slow
def test_no_cluster_is_told_in_one_line(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(dask_workers, "PATIENCE", 1)
    job = Squares()
    for address in ("tcp://127.0.0.1:1", "nonsense://x"):
        with ResultsFile.resume(tmp_path / "a.db", job) as file:
            with pytest.raises(WorkerError, match=f"no cluster at {address} .*; give the"):
                run_chunks(job, file, dask=address)
    # Some loggers of the library have levels of their own.
    for name in ("distributed", "distributed.client", "distributed.nanny"):
        assert not logging.getLogger(name).isEnabledFor(logging.ERROR)


def test_a_run_ends_with_the_chunk_at_its_deadline(tmp_path):
    """It computes one at least, says why it ended, and another run goes on from there."""
    job, path = Squares(), tmp_path / "a.db"
    with ResultsFile.create(path, job) as file:
        for number in (1, 2):
            summary = run_chunks(job, file, workers=0, deadline=monotonic() - 1.0)
            assert (summary.chunks, summary.ended) == (1, "time")
            assert file.computed()[0] == 64 * number
        assert run_chunks(job, file, workers=0, deadline=monotonic() + 1e6).ended == "complete"
        assert run_chunks(job, file, workers=0, deadline=monotonic() - 1.0).ended == "complete"
    assert exported(path, job) == undisturbed(tmp_path, job)


def test_a_complete_file_starts_nobody(tmp_path):
    job = Squares()
    undisturbed(tmp_path, job)
    with ResultsFile.resume(tmp_path / "undisturbed.db", job) as file:
        summary = run_chunks(job, file, dask="tcp://127.0.0.1:1")
    assert (summary.chunks, summary.rows, summary.kept) == (0, 0, 1000)
    assert usable_cores() >= 1


@pytest.mark.slow
@posix
@pytest.mark.parametrize(("where", "few", "every"), [(["2"], 3, 50), (["2", "local"], 1, 50)])
def test_killed_runs_resume_to_the_same_bytes(tmp_path, where, few, every):
    if "local" in where:
        pytest.importorskip("distributed")
    path, kills = tmp_path / "a.db", number_of_cases(few, every)
    words = [str(path), *where]
    rows = kill_and_resume(RUN, words, lambda: covered(path), JOB.rows, kills, 26, ENVIRONMENT)
    assert rows == sorted(rows) and 0 < rows[-1] < JOB.rows
    assert exported(path, JOB) == undisturbed(tmp_path, JOB)


def held_halfway(path: Path) -> subprocess.Popen:
    """A run with two workers that has begun to write, and does not end by itself."""
    writer = start_held(JOB.rows // 2, RUN, [str(path), "2"], ENVIRONMENT)
    wait_until_true(lambda: covered(path) > 0 or writer.poll() is not None)
    assert writer.poll() is None, writer.communicate()
    return writer


@pytest.mark.slow
@posix
@pytest.mark.table(1)
@pytest.mark.parametrize("files", [["a.db"], []], ids=["file", "table"])
def test_workers_end_with_their_writer(tmp_path, files):
    """At once, also amid chunks that never end."""
    psutil = pytest.importorskip("psutil")
    sign = tmp_path / "sign"
    words = ["-m", "tests.support.run_stuck", str(sign), *(str(tmp_path / x) for x in files)]
    writer = subprocess.Popen([sys.executable, *words], env=os.environ | ENVIRONMENT)
    wait_until_true(
        lambda: (sign.exists() and len(sign.read_text()) == 2) or writer.poll() is not None
    )
    assert writer.poll() is None
    workers = psutil.Process(writer.pid).children(recursive=True)
    assert len(workers) >= 2
    os.kill(writer.pid, signal.SIGKILL)
    writer.communicate()
    _, alive = psutil.wait_procs(workers, timeout=HANGS / 2)
    assert not alive


@pytest.mark.slow
@posix
def test_workers_that_are_killed_as_they_start_are_started_again(tmp_path):
    """If they always are, the answer says so, and advises nothing that would not help."""
    killed = tmp_path / "killed"
    killed.write_text("xx")
    job = Squares(killed=str(killed))
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        assert run_chunks(job, file, workers=1).lost_workers == 2
    assert exported(tmp_path / "a.db", job) == undisturbed(tmp_path, Squares())
    killed.write_text("xxx")
    with ResultsFile.create(tmp_path / "b.db", job) as file:
        with pytest.raises(WorkerError) as caught:
            run_chunks(job, file, workers=1)
    assert str(caught.value) == (
        "3 worker processes in a row ended as they started (killed by SIGKILL); give the "
        "machine more memory, or use fewer workers"
    )


@pytest.mark.slow
@posix
def test_an_interrupt_reaches_the_writer_alone(tmp_path):
    """Ctrl-C goes to all processes of the terminal: one of them speaks, none stays."""
    path = tmp_path / "a.db"
    writer = held_halfway(path)
    os.killpg(writer.pid, signal.SIGINT)
    writer.wait(timeout=HANGS)
    _, errors = writer.communicate()
    assert errors.count("Traceback") == 1 and errors.rstrip().endswith("KeyboardInterrupt")
    assert 0 < covered(path) < JOB.rows

    def all_ended() -> bool:
        try:
            os.killpg(writer.pid, 0)
        except ProcessLookupError:
            return True
        return False

    wait_until_true(all_ended)
