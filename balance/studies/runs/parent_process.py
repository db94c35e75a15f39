"""Processes that do not outlive the process that started them."""

from __future__ import annotations

import os
from multiprocessing import parent_process
from multiprocessing.connection import wait
from threading import Thread


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
