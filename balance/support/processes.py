"""Processes that work for this one, and live no longer than it does."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from threading import Thread
from typing import TypeVar

from kinematics.errors import WorkerError
from kinematics.numerics.compiled.background import WORTH, kernel_clock

Item = TypeVar("Item")
Result = TypeVar("Result")
# Variables that set the threads of libraries: matrices are small.
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")


def map_in_processes(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    workers: int,
    begin: Callable[[], object] | None = None,
) -> Iterator[Result]:
    """Apply a function to items in processes, and yield the results in the order of the items.

    Function, items and results are pickled. Processes have the settings of this one, also of
    the threads of libraries, so that they compute the same bits.

    Args:
        workers: number of processes; this one alone if it is below 2.
        begin: called at the begin of each process, if there are several.

    Raises:
        WorkerError: a process has ended before its work did.
    """
    if workers < 2:
        yield from map(function, items)
        return
    kernel_clock.foresee(WORTH)
    context = get_context("spawn")
    with ProcessPoolExecutor(workers, context, _begin_worker, (begin,)) as pool:
        try:
            yield from pool.map(function, items)
        except BrokenProcessPool as error:
            raise WorkerError(
                "a worker process ended before its work did",
                "give the machine more memory, use one process, or in a script call this below "
                "'if __name__ == \"__main__\":'",
            ) from error


def _begin_worker(begin: Callable[[], object] | None) -> None:
    """Begin a process: it ends with this one, and silently with Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    end_with_parent()
    if begin is not None:
        begin()


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Let processes that start within the block use one thread each for their matrices."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def end_with_parent() -> None:
    """End this process as soon as its parent ends, also by SIGKILL, whatever it does then.

    It is for processes that `multiprocessing` has started: these hold the end of a pipe, in
    Windows a handle, that tells of the end of the parent.
    """
    parent = parent_process()
    if parent is not None:
        Thread(target=_wait_and_end, args=(parent.sentinel,), daemon=True).start()


def _wait_and_end(sentinel: int) -> None:
    """Wait for the end of the parent, and end this process at once."""
    wait([sentinel])
    os._exit(1)
