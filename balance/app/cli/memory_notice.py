"""A notice on standard error when a command uses much memory."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread

# Memory above which a command says so, bytes, and the time between two looks at it, seconds.
MUCH = 2e9
INTERVAL = 0.25


def resident_memory() -> int:
    """Return the memory of this process that is in use, bytes."""
    # psutil is imported by commands that take longer than `INTERVAL` only.
    from psutil import Process

    return int(Process().memory_info().rss)


@contextmanager
def memory_notice() -> Iterator[None]:
    """Log one line as soon as the memory of this process exceeds `MUCH`."""
    done = Event()

    def watch() -> None:
        while not done.wait(INTERVAL):
            if resident_memory() > MUCH:
                logging.warning("this command uses more than %g GB of memory", MUCH / 1e9)
                return

    watcher = Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        done.set()
        watcher.join()
