"""A notice on standard error when a command uses much memory."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread

# Memory above which a command says so, bytes, and the time between two looks at it, seconds.
MUCH = 2e9
INTERVAL = 0.25


@contextmanager
def memory_notice() -> Iterator[None]:
    """Log one line as soon as the memory of this process exceeds `MUCH`.

    Where the operating system does not tell the memory in ``/proc``, nothing is logged.
    """
    pages = Path("/proc/self/statm")
    done = Event()

    def watch() -> None:
        while not done.wait(INTERVAL):
            used = int(pages.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
            if used > MUCH:
                logging.warning("this command uses more than %g GB of memory", MUCH / 1e9)
                return

    watcher = Thread(target=watch, daemon=True)
    if pages.exists():
        watcher.start()
    try:
        yield
    finally:
        done.set()
        if watcher.is_alive():
            watcher.join()
