"""What the benchmarks against other libraries share."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from time import perf_counter

import numpy as np

from benchmarks.peers import jobs, library

__all__ = ["Against", "Rows", "median", "start"]

# Batches of a row, and seconds of each.
BATCHES, BATCH = 15, 0.005


def start(peer: str, job: str, order: int) -> tuple[Callable, Callable]:
    """The functions of a library for a job."""
    ready: tuple[Callable, Callable] = getattr(import_module(f"benchmarks.peers.{peer}"), job)(
        order
    )
    return ready


class Against:
    """Times of ours and of one other on the same job."""

    peer = ""

    def setup(self, job: str, order: int) -> None:
        self.ours, _ = start("ours", job, order)
        self.theirs, _ = start(self.peer, job, order)

    def time_ours(self, job: str, order: int) -> None:
        """All coefficients of one more geometry."""
        self.ours()

    def time_theirs(self, job: str, order: int) -> None:
        """All coefficients once more."""
        self.theirs()


class Rows:
    """Median time and largest relative error of every library, a row for each order."""

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
        """All coefficients of one more geometry."""
        self.found["ours"][0]()

    def row(self, job: str, order: int) -> dict[str, str]:
        return {peer: self._cell(peer, job, order) for peer in self.peers}

    def _cell(self, peer: str, job: str, order: int) -> str:
        if peer not in self.found:
            return "-"
        run, read = self.found[peer]
        error = jobs.error(job, read(run()), order)
        return f"{1e6 * median(run):.3g} µs, {error:.0e}"


def median(run: Callable) -> float:
    """Seconds of one call."""
    before = perf_counter()
    run()
    count = max(1, int(BATCH / (perf_counter() - before)))
    times = []
    for _ in range(BATCHES if count > 1 else 3):
        before = perf_counter()
        for _ in range(count):
            run()
        times.append((perf_counter() - before) / count)
    return float(np.median(times))
