"""Chunks that take long: rows are written every few seconds, and a run goes on from there."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import balance
from balance.studies.runs.chunk_job import chunk_size
from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.export import export_csv
from balance.studies.runs.results_file import ResultsFile
from balance.studies.sweeps import job as sweep_job
from kinematics.errors import FileError
from tests.support.squares import Squares


@dataclass(frozen=True)
class SlowSquares(Squares):
    """Squares of which a part of a chunk has so many rows."""

    part_rows: int = 7
    # A chunk that fails from its second part on, unless it is -1.
    fails: int = -1

    def compute_part(self, chunk: int, first: int):
        if chunk == self.fails and first:
            raise KeyboardInterrupt
        size = chunk_size(chunk, self.rows, self.chunk_rows)
        stop = min(first + self.part_rows, size)
        part = {name: values[first:stop] for name, values in self.compute(chunk).items()}
        return part, stop if stop < size else 0


def csv_of(path: Path) -> bytes:
    """The rows of a file."""
    with ResultsFile.open(path) as file:
        export_csv(file, f"{path}.csv")
    return Path(f"{path}.csv").read_bytes()


@pytest.fixture
def whole(tmp_path):
    """The rows of chunks that are computed as a whole."""
    job = Squares(rows=150)
    with ResultsFile.create(tmp_path / "whole.db", job) as file:
        run_chunks(job, file, workers=0)
    return csv_of(tmp_path / "whole.db")


def test_a_run_that_ends_amid_a_chunk_keeps_its_rows(tmp_path, whole):
    """Chunk 1 has 64 rows, of which 7 are done: what is left is computed, and nothing twice."""
    path = tmp_path / "a.db"
    job = SlowSquares(rows=150, fails=1)
    with ResultsFile.create(path, job) as file, pytest.raises(KeyboardInterrupt):
        run_chunks(job, file, workers=0)
    with ResultsFile.open(path) as file:
        assert file.computed() == (71, 71) and file.read(["number"])["row"].size == 71
    job = SlowSquares(rows=150)
    seen = []
    with ResultsFile.resume(path, job) as file:
        assert next(file.tasks()) == (1, 7)
        summary = run_chunks(job, file, workers=0, progress=lambda *pair: seen.append(pair))
    assert (summary.kept, summary.rows, summary.chunks) == (71, 79, 2)
    assert seen[:3] == [(71, 150), (78, 150), (85, 150)] and seen[-1] == (150, 150)
    assert csv_of(path) == whole


@pytest.mark.slow
@pytest.mark.parametrize("where", [{"workers": 2}, {"workers": 1, "dask": "local"}])
def test_processes_compute_the_same_rows(tmp_path, whole, where):
    if "dask" in where:
        pytest.importorskip("distributed")
    job = SlowSquares(rows=150)
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        summary = run_chunks(job, file, **where)
    assert (summary.chunks, summary.rows) == (3, 150)
    assert csv_of(tmp_path / "a.db") == whole


def test_rows_that_come_twice_are_written_once(tmp_path, whole):
    """As after the end of a worker, whose chunk another one begins again."""
    path = tmp_path / "a.db"
    job = Squares(rows=150)
    chunks = [job.compute(k) for k in range(3)]

    def rows(chunk: int, start: int, stop: int):
        return {name: values[start:stop] for name, values in chunks[chunk].items()}

    with ResultsFile.create(path, job) as file:
        assert file.write_chunk(0, rows(0, 0, 30), ended=False)
        assert not file.write_chunk(0, rows(0, 0, 10), ended=False)
        # Rows after a gap are none of the file.
        assert not file.write_chunk(0, rows(0, 40, 50), 40, ended=False)
        assert file.write_chunk(0, rows(0, 20, 50), 20, ended=False)
        assert file.computed() == (50, 50)
        assert file.write_chunk(0, rows(0, 0, 64))
        assert not file.write_chunk(0, rows(0, 0, 64))
        for chunk in (1, 2):
            file.write_chunk(chunk, chunks[chunk])
        assert file.computed() == (150, 150)
    assert csv_of(path) == whole


def test_a_chunk_that_is_begun_and_done_is_damage(tmp_path):
    path = tmp_path / "a.db"
    job = Squares(rows=150)
    with ResultsFile.create(path, job) as file:
        file.write_chunk(0, job.compute(0))
        file._connection.execute("INSERT INTO begun VALUES (0, 3)")
    with pytest.raises(FileError, match="chunks that the job does not have"):
        ResultsFile.open(path)


@pytest.mark.lanes
def test_parts_of_a_sweep_are_its_chunk(monkeypatch):
    """Row by row, and in parts of several rows; one of them does not close."""
    study = balance.studies.Study.from_tables(
        {
            "parameters": {"coupler.length": [0.9, 9.0, 1.0, 1.1, 1.05]},
            "compute": {"quantities": ["rank", "input_inertia"]},
        },
        balance.load("four_bar_general"),
    )
    job = study.job()
    chunk = job.compute(0)
    for seconds, calls in ((-1.0, 5), (600.0, 1)):
        monkeypatch.setattr(sweep_job, "PART_SECONDS", seconds)
        parts, first = [], 0
        while not parts or first:
            part, first = job.compute_part(0, first)
            parts.append(part)
        assert len(parts) == calls
        for column in job.columns:
            joined = [value for part in parts for value in part[column.name]]
            if column.kind == "text":
                assert joined == list(chunk[column.name])
            else:
                np.testing.assert_allclose(joined, chunk[column.name], rtol=1e-9)
    assert chunk["closed"].tolist() == [1, 0, 1, 1, 1]
