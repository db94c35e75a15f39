"""Run a job: many processes compute its chunks, and this one writes them.

Each has a pipe to the writer. A worker ends when the writer does, also amid a chunk; if a
worker ends, the writer starts another one and gives it the lost chunks again.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from itertools import chain
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from time import monotonic
from typing import Literal

from balance.studies.runs.chunk_job import ChunkJob, ChunkTask, chunk_size
from balance.studies.runs.chunk_worker import (
    ChunkOutcome,
    compute_chunk,
    one_thread_each,
    values_of,
)
from balance.studies.runs.dask_workers import dask_outcomes
from balance.studies.runs.parent_process import end_with_parent
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import WorkerError

# Chunks that a worker has at once: it computes one while another waits in its pipe.
AHEAD = 2
# Times that a chunk may end its worker, and that workers in a row may be killed as they start.
TRIES = 3
# Seconds that a worker has to end.
PATIENCE = 5.0
STARTED = "started"
MORE_MEMORY = "give the machine more memory, or use fewer workers"


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
    processes = _WorkerProcesses(job, count)
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
    processes: _WorkerProcesses,
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


class _Worker:
    """One process, its pipe, and the chunks that it has."""

    def __init__(self, job: ChunkJob) -> None:
        """Start the process."""
        context = multiprocessing.get_context("spawn")
        self.pipe, far = context.Pipe()
        self.process: SpawnProcess = context.Process(target=_work, args=(job, far), daemon=True)
        self.tasks: deque[ChunkTask] = deque()
        self.started = False
        with one_thread_each(), _interrupts_ignored():
            self.process.start()
        far.close()

    def give(self, task: ChunkTask) -> None:
        """Send a task; a process that has ended is noticed by `receive`."""
        self.tasks.append(task)
        with suppress(OSError):
            self.pipe.send(task)

    def receive(self) -> ChunkOutcome | None:
        """Receive a chunk; None for a sign of life.

        Raises:
            EOFError, OSError: the process has ended.
        """
        message = self.pipe.recv()
        if message == STARTED:
            self.started = True
            return None
        outcome: ChunkOutcome = message
        self.tasks.remove((outcome.chunk, outcome.first))
        return outcome

    def end(self) -> None:
        """End the process, whatever it does."""
        self.pipe.close()
        self.process.terminate()
        self.process.join(PATIENCE)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()


class _WorkerProcesses:
    """Processes that compute the chunks of a job.

    Attributes:
        lost: number of processes that have ended before their work did.
    """

    def __init__(self, job: ChunkJob, count: int) -> None:
        """Keep the job and the number of processes.

        Args:
            job: the job; it is pickled for each process.
        """
        self._job, self._count, self.lost = job, count, 0
        self._workers: list[_Worker] = []
        self._deaths: dict[int, int] = {}
        self._killed_at_start = 0

    def outcomes(self, tasks: Iterable[ChunkTask]) -> Iterator[ChunkOutcome]:
        """Compute chunks and yield them as they are done, in any order.

        What is left of a chunk of which some rows were computed comes next.

        Raises:
            WorkerError: a chunk has ended its process again and again, or processes cannot
                start.
        """
        rest, again = iter(tasks), deque[ChunkTask]()
        try:
            while True:
                self._hand_out(rest, again)
                if not any(worker.tasks for worker in self._workers):
                    return
                for worker in self._ready():
                    try:
                        outcome = worker.receive()
                    except (EOFError, OSError):
                        again.extend(self._bury(worker))
                        continue
                    if outcome is None:
                        self._killed_at_start = 0
                    else:
                        if outcome.next_row:
                            again.append((outcome.chunk, outcome.next_row))
                        yield outcome
        finally:
            for worker in self._workers:
                worker.end()

    def _hand_out(self, rest: Iterator[ChunkTask], again: deque[ChunkTask]) -> None:
        """Give every worker its chunks, and start workers as long as there are chunks."""
        for _ in range(AHEAD):
            for k in range(self._count):
                if k < len(self._workers) and len(self._workers[k].tasks) >= AHEAD:
                    continue
                task = again.popleft() if again else next(rest, None)
                if task is None:
                    return
                if k == len(self._workers):
                    self._workers.append(_Worker(self._job))
                self._workers[k].give(task)

    def _ready(self) -> list[_Worker]:
        """Wait for workers that have something to tell."""
        pipes = wait([worker.pipe for worker in self._workers])
        return [worker for worker in self._workers if worker.pipe in pipes]

    def _bury(self, worker: _Worker) -> list[ChunkTask]:
        """Count the death of a worker and return its tasks.

        Raises:
            WorkerError: workers cannot start, or its chunk has ended others too.
        """
        worker.end()
        self._workers.remove(worker)
        self.lost += 1
        code = worker.process.exitcode or 0
        if not worker.started:
            self._check_start(code)
        elif worker.tasks:
            chunk = worker.tasks[0][0]
            self._deaths[chunk] = self._deaths.get(chunk, 0) + 1
            if self._deaths[chunk] >= TRIES:
                raise WorkerError(
                    f"chunk {chunk} has ended its process {TRIES} times ({_end_text(code)})",
                    MORE_MEMORY,
                )
        return list(worker.tasks)

    def _check_start(self, code: int) -> None:
        """Refuse to go on if processes end as they start: at once, or killed again and again.

        Raises:
            WorkerError: the process ended by itself, or others in a row were killed too.
        """
        if code >= 0:
            raise WorkerError(
                f"a worker process does not start ({_end_text(code)})",
                "call this in a script below 'if __name__ == \"__main__\":', or with workers=0",
            )
        self._killed_at_start += 1
        if self._killed_at_start >= TRIES:
            raise WorkerError(
                f"{TRIES} worker processes in a row ended as they started ({_end_text(code)})",
                MORE_MEMORY,
            )


def _end_text(code: int) -> str:
    """Say how a process ended.

    Args:
        code: its exit code; that of a signal is negative.
    """
    if code >= 0:
        return f"exit code {code}"
    try:
        return f"killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"killed by signal {-code}"


def _work(job: ChunkJob, pipe: Connection) -> None:
    """Compute chunks until the pipe ends, in a process of its own."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    with suppress(EOFError, OSError):
        pipe.send(STARTED)
        while True:
            pipe.send(compute_chunk(job, *pipe.recv()))


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Let a process that starts within the block ignore Ctrl-C, which its writer handles."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
