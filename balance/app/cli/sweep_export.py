"""The command ``balance sweep export``: all rows as a table, or one row as a linkage."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Verbs, add_json_option
from balance.app.cli.exit_codes import DONE
from balance.app.cli.number_arguments import whole_number
from balance.app.cli.progress import progress_bar
from kinematics.errors import FileError

if TYPE_CHECKING:
    from balance.studies.runs.results_file import ResultsFile

# Largest number of a row.
MAX_ROW = 10**12
# Values of --added: the masses given, and quantities with others.
GIVEN, ADDED = "none", ("counterweights", "reduce", "design")
EXPORTS = (".csv", ".xlsx", ".parquet", ".urdf")


def add_export(kinds: Verbs) -> None:
    """Add ``sweep export``."""
    parser = kinds.add_parser(
        "export",
        help="write all results as a table, or one row as URDF",
        description="Writes all results as a table, or the linkage of one row as URDF, with "
        "its lengths and masses: with the counterweights of the study, else the matter of "
        "reduce, else the masses of its design.",
    )
    parser.add_argument("results", metavar="FILE.db", help="file of the results")
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=_export_path,
        required=True,
        help="the file to write: .csv, .xlsx or .parquet, or with --row .urdf",
    )
    parser.add_argument(
        "--row",
        type=whole_number(0, MAX_ROW),
        metavar="N",
        help="the row that is written as URDF; its number is that of sweep show",
    )
    parser.add_argument(
        "--added",
        choices=(GIVEN, *ADDED),
        help="with --row: the masses of the file, none for those given (default: the first "
        "that the row has)",
    )
    add_json_option(parser, _export)


def _export(arguments: argparse.Namespace) -> Answer:
    """Export the results of the options.

    Raises:
        LinkageError: a file cannot be read or written, or a library is missing.
    """
    urdf = arguments.out.lower().endswith(".urdf")
    if urdf != (arguments.row is not None):
        arguments.refuse("--row N and --out FILE.urdf need each other: one row is one linkage")
    if arguments.added is not None and not urdf:
        arguments.refuse("--added goes with --row N: a table has the numbers of all")
    from balance.app.answers.text.sweep import export_body, export_data
    from balance.studies.runs.results_file import ResultsFile
    from balance.support.atomic_files import write_all_atomic

    with ResultsFile.open(arguments.results) as file, progress_bar("rows", True) as advance:
        if urdf:
            content, added = row_file(file, arguments.row, added=arguments.added)
            write_all_atomic([(arguments.out, content)])
            data = export_data(file, arguments.out, 1, arguments.row, added)
        else:
            data = export_data(file, arguments.out, export_table(file, arguments.out, advance))
        units = [column.unit for column in file.columns]
    return Answer(DONE, lambda: data, lambda: export_body(data, units))


def export_table(file: ResultsFile, path: str, advance: Callable[[int, int], None]) -> int:
    """Write all rows as a table of the kind of the path, and count them."""
    from balance.studies.runs.export import export_csv, export_parquet, export_workbook

    kind = Path(path).suffix.lower()
    write = {".xlsx": export_workbook, ".parquet": export_parquet}.get(kind, export_csv)
    return write(file, path, advance)


def row_file(
    file: ResultsFile, row: int, column: str = "", added: str | None = None
) -> tuple[bytes, str]:
    """Write the linkage of one row as URDF.

    Args:
        column: see `balance.studies.sweeps.job.SweepJob.completed`.
        added: the quantity of its masses, or `GIVEN`; None for what the column asks for.

    Returns:
        The file; and the quantity of its masses, empty for those given.

    Raises:
        FileError: the file has no study of a sweep.
        LinkageError: the row is no linkage.
    """
    from balance.studies.sweeps.job import SweepJob

    if file.about["kind"] != "sweep":
        remedy = "balance discover export writes its members"
        raise FileError(file.path, "", "is no file of a sweep", remedy)
    job = SweepJob.from_description(file.about["description"])
    if added is None:
        linkage, added = job.completed(row, column)
    else:
        added = "" if added == GIVEN else added
        linkage = job.linkage(row, added)
    return linkage.to_urdf().encode(), added


def _export_path(text: str) -> str:
    """Check that a word names a file of a known kind.

    Raises:
        ArgumentTypeError: it ends otherwise.
    """
    if not text.lower().endswith(EXPORTS):
        raise argparse.ArgumentTypeError(f"'{text}' ends in none of {', '.join(EXPORTS)}")
    return text
