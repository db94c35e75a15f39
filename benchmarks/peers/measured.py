"""Base classes of the benchmarks against other libraries."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from time import perf_counter

import numpy as np

from benchmarks.harness.show import seconds
from benchmarks.peers import jobs, library

# Number of batches of a row, and seconds of each.
BATCHES, BATCH = 15, 0.005


def start(peer: str, job: str, order: int) -> tuple[Callable, Callable]:
    """Return the functions of a library for a job."""
    ready: tuple[Callable, Callable] = getattr(import_module(f"benchmarks.peers.{peer}"), job)(
        order
    )
    return ready


class Against:
    """Times and coefficient errors of ours and of one other library on a job."""

    peer = ""

    def setup(self, job: str, order: int) -> None:
        self.ours = start("ours", job, order)
        self.theirs = start(self.peer, job, order)

    def time_ours(self, job: str, order: int) -> None:
        """All coefficients of another geometry."""
        self.ours[0]()

    def track_error(self, job: str, order: int) -> float:
        """Relative error of ours against mpmath."""
        return _error(self.ours, job, order)

    def track_error_of_theirs(self, job: str, order: int) -> float:
        """Relative error of the other library."""
        return _error(self.theirs, job, order)


class Rows:
    """Time with spread, and largest relative error, of every library, one row per order."""

    peers: tuple[str, ...] = ()
    repetitions = 3

    def setup(self, job: str, order: int) -> None:
        library("mpmath")
        self.found: dict[str, tuple[Callable, Callable]] = {}
        for peer in self.peers:
            try:
                self.found[peer] = start(peer, job, order)
            except NotImplementedError:
                continue

    def time_ours(self, job: str, order: int) -> None:
        """All coefficients of another geometry."""
        self.found["ours"][0]()

    def row(self, job: str, order: int) -> dict[str, str]:
        return {peer: self._cell(peer, job, order) for peer in self.peers}

    def _cell(self, peer: str, job: str, order: int) -> str:
        if peer not in self.found:
            return "-"
        found = self.found[peer]
        error = _error(found, job, order)
        return f"{' '.join(seconds(times(found[0])).split())}, {error:.0e}"


def _error(found: tuple[Callable, Callable], job: str, order: int) -> float:
    run, read = found
    return jobs.error(job, read(run()), order)


def times(run: Callable) -> np.ndarray:
    """Measure the seconds of one call in each batch."""
    before = perf_counter()
    run()
    count = max(1, int(BATCH / (perf_counter() - before)))
    found = []
    for _ in range(BATCHES if count > 1 else 3):
        before = perf_counter()
        for _ in range(count):
            run()
        found.append((perf_counter() - before) / count)
    return np.array(found)
