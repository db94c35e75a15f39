"""The command ``balance sweep show``: a table, a picture and a page of results."""

from __future__ import annotations

import argparse

from balance.cli.arguments import Verbs, page_path, picture_path
from balance.cli.exit_codes import DONE
from balance.cli.number_arguments import whole_number
from balance.cli.outcome import Outcome

__all__ = ["add_show"]

# Rows of the table.
ROWS = 10
MAX_ROWS = 100_000


def add_show(kinds: Verbs) -> None:
    """Add ``sweep show`` to the parser of ``sweep``."""
    parser = kinds.add_parser(
        "show",
        help="show results, also while they are computed",
        description="Shows the results in a file, also while a run writes it.",
    )
    parser.add_argument("results", metavar="FILE.db", help="file of the results")
    parser.add_argument("--sort", metavar="COLUMN", help="sort by a column, the least first")
    parser.add_argument(
        "--descending", action="store_true", help="with --sort: the largest first"
    )
    parser.add_argument(
        "--count", type=whole_number(1, MAX_ROWS), default=ROWS, metavar="N",
        help=f"rows of the table (default {ROWS})",
    )  # fmt: skip
    parser.add_argument(
        "--plot", dest="axes", type=_axes, metavar="X,Y[,COLOUR]",
        help="draw columns over each other, into the file of --out: a map if X and Y form a "
        "grid, points if not; drops of the rank are marked",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=picture_path, metavar="FILE.png|.svg", help="with --plot: the picture"
    )
    parser.add_argument(
        "--html", type=page_path, metavar="FILE.html",
        help="write a page with parallel coordinates to brush, and the linkage of a row; it "
        "needs no network",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_show, refuse=parser.error, force=False)


def _show(arguments: argparse.Namespace) -> Outcome:
    """Show the results of the options and write their files.

    Raises:
        LinkageError: a file cannot be read or written, or there is no such column.
    """
    if (arguments.axes is None) != (arguments.out is None):
        arguments.refuse("--plot X,Y and --out FILE.png|.svg need each other")
    if arguments.descending and arguments.sort is None:
        arguments.refuse("--descending needs --sort")
    from balance.report.text.sweep import show_data, show_text
    from balance.result_files.results_file import ResultsFile

    with ResultsFile.open(arguments.results) as file:
        found = show_data(file, arguments.sort or "", arguments.descending, arguments.count)
        contents = []
        if arguments.axes is not None:
            from balance.report.html.sweep_plot import sweep_picture

            kind = arguments.out[-3:].lower()
            contents.append((arguments.out, sweep_picture(file, arguments.axes, kind)))
        if arguments.html is not None:
            from balance.report.html.sweep import sweep_page

            page = sweep_page(file, arguments.sort or "", arguments.descending)
            contents.append((arguments.html, page.encode()))
    from balance.atomic_files import write_all_atomic

    write_all_atomic(contents)
    return Outcome(DONE, lambda: found, lambda: show_text(found))


def _axes(text: str) -> tuple[str, ...]:
    """Parse ``X,Y`` or ``X,Y,COLOUR``.

    Raises:
        ArgumentTypeError: there are fewer or more names.
    """
    names = tuple(name.strip() for name in text.split(","))
    if len(names) not in (2, 3) or not all(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not X,Y or X,Y,COLOUR, names of columns")
    return names
