"""A progress bar on the terminal, for commands with many equal steps."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from time import monotonic
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rich.progress import Progress


class Advance(Protocol):
    """Takes the number of steps done and of all steps, and a remark to show."""

    def __call__(self, done: int, total: int, remark: str = "") -> None:
        """Show them."""


# Seconds before the progress bar appears; most commands are faster.
PATIENCE = 2.0


@contextmanager
def progress_bar(what: str, rate: bool = False) -> Iterator[Advance]:
    """Show a progress bar with the remaining time on a terminal after `PATIENCE`.

    The function that it yields takes the number of steps done and of all steps, and a remark to
    show. What its first call says was done before.

    Args:
        what: what is counted, in the plural.
        rate: whether to show how many are done in a second.
    """
    start, shown = monotonic(), ExitStack()
    bar: Progress | None = None
    before: int | None = None

    def advance(done: int, total: int, remark: str = "") -> None:
        nonlocal bar, before
        before = done if before is None else before
        if bar is None and monotonic() - start > PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            console = Console(stderr=True)
            bar = Progress(console=console, transient=True, disable=not console.is_terminal)
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
