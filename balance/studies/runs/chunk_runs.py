"""Run a job: many processes compute its chunks, and this one writes them."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import chain
from time import monotonic
from typing import Literal

from balance.studies.runs.chunk_job import ChunkJob, ChunkTask, chunk_size
from balance.studies.runs.chunk_worker import ChunkOutcome, compute_chunk, values_of
from balance.studies.runs.dask_workers import dask_outcomes
from balance.studies.runs.results_file import ResultsFile
from balance.studies.runs.worker_processes import WorkerProcesses


@dataclass(frozen=True)
class RunSummary:
    """What a run has done.

    Attributes:
        chunks: chunks that it has computed.
        rows: rows of the job that these cover.
        kept: rows that the file covered before.
        seconds: duration.
        lost_workers: processes on this machine that ended before their work did.
        ended: why the run ended: the file is ``"complete"``, or the ``"time"`` was up.
    """

    chunks: int
    rows: int
    kept: int
    seconds: float
    lost_workers: int
    ended: Literal["complete", "time"]

    @property
    def rate(self) -> float:
        """Rows per second."""
        return self.rows / self.seconds if self.seconds > 0.0 else 0.0


def usable_cores() -> int:
    """Count the cores of this machine."""
    return os.cpu_count() or 1


def run_chunks(
    job: ChunkJob,
    file: ResultsFile,
    *,
    workers: int | None = None,
    dask: str | None = None,
    deadline: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> RunSummary:
    """Compute the chunks that a file lacks, and write each as soon as it is done.

    Of chunks that take long, rows are written every few seconds. However the run ends, the file
    keeps all rows but those in flight, and another run of the job goes on from there.

    Args:
        file: its file, from `ResultsFile.create` or `ResultsFile.resume`.
        workers: number of processes, one per core by default; 0 computes in this process.
        dask: address of a Dask scheduler, or ``"local"``.
        deadline: time of `time.monotonic` from which a chunk that is done is the last one.
        progress: called with the rows that the file covers, and all rows of the job.

    Returns:
        What was done, and why it ended.

    Raises:
        FileError: the file cannot be written.
        LinkageError: a chunk is refused.
        WorkerError: workers fail again and again.
        PackageError: Dask is missing.
    """
    begin, (kept, _) = monotonic(), file.computed()
    count = usable_cores() if workers is None else workers
    processes = WorkerProcesses(job, count)
    chunks = covered = 0
    if progress is not None:
        progress(kept, file.rows)
    with closing(_outcomes(job, file.tasks(), count, dask, processes)) as outcomes:
        for outcome in outcomes:
            ended = not outcome.next_row
            file.write_chunk(outcome.chunk, values_of(outcome), outcome.first, ended)
            chunks += ended
            size = chunk_size(outcome.chunk, file.rows, file.chunk_rows)
            covered += (size if ended else outcome.next_row) - outcome.first
            if progress is not None:
                progress(kept + covered, file.rows)
            if deadline is not None and monotonic() > deadline:
                break
    why: Literal["complete", "time"] = "complete" if kept + covered == file.rows else "time"
    return RunSummary(chunks, covered, kept, monotonic() - begin, processes.lost, why)


def _outcomes(
    job: ChunkJob,
    tasks: Iterator[ChunkTask],
    count: int,
    dask: str | None,
    processes: WorkerProcesses,
) -> Generator[ChunkOutcome]:
    """Compute chunks where they are to be computed; nothing starts if none is left."""
    task = next(tasks, None)
    if task is None:
        return
    rest = chain([task], tasks)
    if dask is not None:
        yield from dask_outcomes(job, rest, dask, max(count, 1))
    elif count == 0:
        yield from _outcomes_here(job, rest)
    else:
        yield from processes.outcomes(rest)


def _outcomes_here(job: ChunkJob, tasks: Iterator[ChunkTask]) -> Iterator[ChunkOutcome]:
    """Compute chunks in this process, one after the other."""
    for chunk, first in tasks:
        outcome = compute_chunk(job, chunk, first)
        yield outcome
        while outcome.next_row:
            outcome = compute_chunk(job, chunk, outcome.next_row)
            yield outcome
