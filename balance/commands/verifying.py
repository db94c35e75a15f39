"""The command ``balance verify``: its options, and what it does with them."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

from balance.commands.readings import with_both
from balance.commands.words import page_path, picture_path, whole_number
from balance.files import replacing_all

if TYPE_CHECKING:
    from rich.progress import Progress

    from balance.verification.verdict import Verification
    from kinematics.linkage import Linkage, Notice

__all__ = ["Verified", "add_options", "progress", "verified"]

# Seconds after which a bar tells how far it is.
PATIENCE = 2.0


class Verified(NamedTuple):
    """What the command found.

    Attributes:
        first: the verification of the linkage.
        second: that of the linkage beside it, if there is one.
    """

    first: Verification
    second: Verification | None

    @property
    def notices(self) -> tuple[Notice, ...]:
        """What the readers of the files had to tell."""
        return (*self.first.notices, *(self.second.notices if self.second else ()))

    def to_dict(self) -> dict[str, object]:
        """The report as plain data, ready for JSON."""
        against = self.second.to_dict() if self.second else None
        return self.first.to_dict() | {"against": against}

    def text(self) -> str:
        """The report as plain text; the second linkage in a column of its own."""
        if self.second is None:
            return "\n".join(f"{label:<15} {value}" for label, value in self.first.facts())
        notes = [("note", f"{one.model}: {text}") for one in (self.first, self.second)
                 for text in one.remarks]  # fmt: skip
        pairs = zip(_plain(self.first), _plain(self.second), strict=True)
        table = [(label, left, right) for (label, left), (_, right) in pairs]
        width = max(len(left) for _, left, _ in table)
        lines = [f"{label:<15} {left:<{width}}  {right}" for label, left, right in table]
        return "\n".join([*lines, *(f"{label:<15} {text}" for label, text in notes)])


def _plain(found: Verification) -> list[tuple[str, str]]:
    """The facts without the notes."""
    return [(label, value) for label, value in found.facts() if label != "note"]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``verify`` beside those of every command on a model."""
    parser.add_argument(
        "--trajectories", type=whole_number(1, 10_000), default=10, metavar="N",
        help="number of random motions (default 10)",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=_seed, default=0, help="seed of the random motions (default 0)"
    )
    parser.add_argument(
        "--csv", metavar="FILE",
        help="motion to use instead: columns time and the inputs, displacements in SI units",
    )  # fmt: skip
    parser.add_argument(
        "--tolerance", type=_tolerance, metavar="T",
        help="part of the bodies' own inertia forces that counts as balanced (default 1e-9)",
    )  # fmt: skip
    parser.add_argument(
        "--against", metavar="MODEL", help="a second linkage, on the same motions, beside it"
    )
    parser.add_argument(
        "--plot", type=picture_path, metavar="FILE.png|.svg", help="write a picture"
    )
    parser.add_argument(
        "--html", type=page_path, metavar="FILE.html",
        help="write a page with the curves; it needs no network",
    )  # fmt: skip


def verified(
    arguments: argparse.Namespace,
    load: Callable[..., Linkage],
    advance: Callable[[int, int], None],
) -> Verified:
    """Verify what the options describe, and write the pictures that they name.

    Args:
        arguments: the options.
        load: gives the linkage for a reading of rounded angles; with ``other=`` a path or a
            name, that one.
        advance: called with the number of motions done and of all of them.

    Raises:
        LinkageError: a linkage, a motion, a file or a library cannot be used.
    """
    options = {
        "motion": arguments.motion, "balance": arguments.balance,
        "trajectories": arguments.trajectories, "seed": arguments.seed,
        "progress": advance,
    }  # fmt: skip
    if arguments.tolerance is not None:
        options["tolerance"] = arguments.tolerance

    def alone(angles: str) -> Verification:
        linkage = load(angles)
        # The file has been accepted; only now is it worth loading the kernels.
        from balance.verification.trajectory import from_csv
        from balance.verification.twin import verify
        from kinematics.motion import restriction

        along = None
        if arguments.csv:
            along = [from_csv(linkage, arguments.csv, restriction(linkage, arguments.motion))]
        return verify(linkage, along=along, **options)

    def second(angles: str) -> Verification:
        from balance.verification.twin import beside

        return beside(first, load(angles, other=arguments.against), **options)

    first = with_both(alone, arguments.angles)
    found = Verified(first, with_both(second, arguments.angles) if arguments.against else None)
    _write(found, arguments)
    return found


def _write(found: Verified, arguments: argparse.Namespace) -> None:
    """The pictures that were asked for."""
    from balance.web.traces import picture, webpage

    shown = [found.first, *([found.second] if found.second else [])]
    contents = []
    if arguments.plot:
        contents.append((arguments.plot, picture(shown, arguments.plot[-3:].lower())))
    if arguments.html:
        contents.append((arguments.html, webpage(shown).encode()))
    replacing_all(contents)


@contextmanager
def progress() -> Iterator[Callable[[int, int], None]]:
    """A bar on a terminal for what takes long; called with what is done and with all."""
    start, shown = monotonic(), ExitStack()
    bar: Progress | None = None

    def advance(done: int, total: int) -> None:
        nonlocal bar
        if bar is None and monotonic() - start > PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            console = Console(stderr=True)
            bar = Progress(console=console, transient=True, disable=not console.is_terminal)
            bar.add_task("motions")
            shown.enter_context(bar)
        if bar is not None:
            bar.update(bar.task_ids[0], completed=done, total=total, refresh=True)

    with shown:
        yield advance


def _seed(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 18):
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 0 up")
    return int(text)


def _tolerance(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 0 up to 1")
    return value
