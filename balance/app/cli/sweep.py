"""The command ``balance sweep``: run a study, show its results, export them."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser, Verbs, add_json_option
from balance.app.cli.exit_codes import DONE
from balance.app.cli.number_arguments import whole_number
from balance.app.cli.outputs import (
    add_page_option,
    describe_written,
    join_remarks,
    kind_of,
    picture_path,
)
from balance.app.cli.sweep_export import add_export
from balance.app.cli.sweep_run import add_run

# Rows of the table of results.
ROWS = 10
MAX_ROWS = 100_000


def add_sweep(parser: Parser) -> None:
    """Add the commands below ``sweep``."""
    parser.description = (
        "Computes a model in many geometries, chunk by chunk, into one file, from "
        "which an interrupted run goes on."
    )
    kinds = parser.add_subparsers(title="jobs", metavar="what", prog=parser.prog, required=True)
    add_run(kinds)
    add_show(kinds)
    add_export(kinds)


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
        "--count",
        type=whole_number(1, MAX_ROWS),
        default=ROWS,
        metavar="N",
        help=f"rows of the table (default {ROWS})",
    )
    parser.add_argument(
        "--plot",
        dest="axes",
        type=_axes,
        metavar="X,Y[,COLOUR]",
        help="draw columns over each other, into the file of --out: a map if X and Y form a "
        "grid, points if not; drops of the rank are marked",
    )
    parser.add_argument(
        "--out", type=picture_path, metavar="FILE.png|.svg", help="with --plot: the picture"
    )
    add_page_option(parser, "with parallel coordinates to brush, and the linkage of a row")
    add_json_option(parser, _show)


def _show(arguments: argparse.Namespace) -> Answer:
    """Show the results of the options.

    Raises:
        LinkageError: a file cannot be read or written, or there is no such column.
    """
    if (arguments.axes is None) != (arguments.out is None):
        arguments.refuse("--plot X,Y and --out FILE.png|.svg need each other")
    if arguments.descending and arguments.sort is None:
        arguments.refuse("--descending needs --sort")
    from balance.app.answers.text.sweep import equal_order_text, show_body, show_data
    from balance.studies.runs.results_file import ResultsFile

    order = arguments.sort or "", arguments.descending
    files: dict[str, Callable[[], str | bytes]] = {}
    with ResultsFile.open(arguments.results) as file:
        data = show_data(file, *order, arguments.count)
        if arguments.axes is not None:
            from balance.app.answers.html.sweep_plot import sweep_picture

            picture = sweep_picture(file, arguments.axes, kind_of(arguments.out))
            files["out"] = lambda: picture
        if arguments.html is not None:
            from balance.app.answers.html.sweep import sweep_page

            page = sweep_page(file, *order)
            files["html"] = lambda: page
    return Answer(
        DONE,
        lambda: data,
        lambda: show_body(data),
        remark=join_remarks(equal_order_text(data), describe_written(arguments, True)),
        files=lambda: files,
    )


def _axes(text: str) -> tuple[str, ...]:
    """Parse ``X,Y`` or ``X,Y,COLOUR``.

    Raises:
        ArgumentTypeError: there are fewer or more names.
    """
    names = tuple(name.strip() for name in text.split(","))
    if len(names) not in (2, 3) or not all(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not X,Y or X,Y,COLOUR, names of columns")
    return names
