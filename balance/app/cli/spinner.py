"""A spinner on the terminal while a command computes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread

from kinematics.numerics.compiled.background import compile_mode

# Seconds before the spinner appears; most commands are faster.
PATIENCE = 0.6
# File descriptor of standard error.
STANDARD_ERROR = 2


@contextmanager
def spinner(text: str) -> Iterator[None]:
    """Show a text and the elapsed time while a command computes.

    Only `logging` may print in the meantime. If kernels are compiled at once, their progress
    bar is shown instead.
    """
    if compile_mode() == "now" or not os.isatty(STANDARD_ERROR):
        yield
        return
    done = Event()
    thread = Thread(target=_show, args=(text, done), daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _show(text: str, done: Event) -> None:
    """Show the spinner after `PATIENCE` until the event is set."""
    if done.wait(PATIENCE):
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TimeElapsedColumn

    columns = SpinnerColumn(), "{task.description}", TimeElapsedColumn()
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, redirect_stdout=False) as line:
        line.add_task(text)
        done.wait()
