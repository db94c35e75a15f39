"""What a terminal shows while a command computes: a spinner, or a bar of equal steps."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from threading import Event, Thread
from time import monotonic
from typing import TYPE_CHECKING, Protocol

from kinematics.numerics.compiled.background import compile_mode

if TYPE_CHECKING:
    from rich.progress import Progress

# Seconds before the spinner, and the bar, appear; most commands are faster.
SPINNER_PATIENCE, BAR_PATIENCE = 0.6, 2.0
# File descriptor of standard error.
STANDARD_ERROR = 2


class Advance(Protocol):
    """Takes the number of steps done and of all steps, and a remark to show."""

    def __call__(self, done: int, total: int, remark: str = "") -> None:
        """Show them."""


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
    thread = Thread(target=_show_spinner, args=(text, done), daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _show_spinner(text: str, done: Event) -> None:
    """Show the spinner after `SPINNER_PATIENCE` until the event is set."""
    if done.wait(SPINNER_PATIENCE):
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TimeElapsedColumn

    columns = SpinnerColumn(), "{task.description}", TimeElapsedColumn()
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, redirect_stdout=False) as line:
        line.add_task(text)
        done.wait()


def print_on_terminal(line: str) -> None:
    """Print a line on a terminal, above a progress bar; nothing where stderr is none."""
    if os.isatty(STANDARD_ERROR):
        from rich.console import Console

        Console(stderr=True).print(line, highlight=False, markup=False)


@contextmanager
def progress_bar(what: str, rate: bool = False) -> Iterator[Advance]:
    """Show a progress bar with the remaining time on a terminal after `BAR_PATIENCE`.

    The function that it yields takes the number of steps done and of all steps, and a remark to
    show. What its first call says was done before.

    Args:
        what: what is counted, in the plural.
        rate: whether to show how many are done in a second.
    """
    start, shown = monotonic(), ExitStack()
    bar: Progress | None = None
    before: int | None = None
    # Kernels of notebooks set FORCE_COLOR, which makes rich take a pipe for a terminal.
    piped = not os.isatty(STANDARD_ERROR)

    def advance(done: int, total: int, remark: str = "") -> None:
        nonlocal bar, before
        before = done if before is None else before
        if bar is None and not piped and monotonic() - start > BAR_PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            bar = Progress(console=Console(stderr=True), transient=True)
            bar.add_task(what, completed=before, total=total)
            shown.enter_context(bar)
        if bar is not None:
            speed = (done - before) / (monotonic() - start)
            parts = [what, *[f"{speed:,.0f} a second"] * rate, *[remark] * bool(remark)]
            text = ", ".join(parts)
            bar.update(
                bar.task_ids[0], completed=done, total=total, description=text, refresh=True
            )

    with shown:
        yield advance
