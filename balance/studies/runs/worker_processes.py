"""Processes on this machine that compute chunks.

Each has a pipe to the writer. A worker ends when the writer does, also amid a chunk; if a
worker ends, the writer starts another one and gives it the lost chunks again.
"""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess

from balance.studies.runs.chunk_job import ChunkJob, ChunkTask
from balance.studies.runs.chunk_worker import ChunkOutcome, compute_chunk
from balance.support.processes import end_with_parent, one_thread_each
from kinematics.errors import WorkerError
from kinematics.numerics.compiled.background import WORTH, kernel_clock

# Chunks that a worker has at once: it computes one while another waits in its pipe.
AHEAD = 2
# Times that a chunk may end its worker, and that workers in a row may be killed as they start.
TRIES = 3
# Seconds that a worker has to end.
PATIENCE = 5.0
STARTED = "started"
MORE_MEMORY = "give the machine more memory, or use fewer workers"


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


class WorkerProcesses:
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
        kernel_clock.foresee(WORTH)
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
