"""The command ``balance sweep``: run a study, show its results, export them."""

from __future__ import annotations

import argparse
import logging
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser, Verbs, add_json_option
from balance.app.cli.exit_codes import DONE
from balance.app.cli.number_arguments import add_workers, whole_number
from balance.app.cli.outputs import add_page_option, describe_written, kind_of, picture_path
from balance.app.cli.progress import progress_bar
from kinematics.errors import FileError, WorkerError

if TYPE_CHECKING:
    from balance.studies.runs.results_file import ResultsFile

logger = logging.getLogger(__name__)

# Rows of the table of results.
ROWS = 10
MAX_ROWS = 100_000
# Largest number of a row.
MAX_ROW = 10**12
EXPORTS = (".csv", ".xlsx", ".parquet", ".urdf")
# Help of a study: the least that is one.
STUDY = (
    'the study, such as these lines: [model], file = "robot.urdf", [parameters], '
    'q4.origin.x = "0.9:1.2:7", [compute], quantities = ["rank", "design"]'
)


def add_sweep(parser: Parser) -> None:
    """Add the commands below ``sweep``."""
    parser.description = (
        "Computes a study of many geometries, chunk by chunk, into one file, from "
        "which an interrupted run goes on."
    )
    kinds = parser.add_subparsers(title="jobs", metavar="what", prog=parser.prog, required=True)
    _add_run(kinds)
    add_show(kinds)
    _add_export(kinds)


def _add_run(kinds: Verbs) -> None:
    """Add ``sweep run``."""
    parser = kinds.add_parser(
        "run",
        help="compute a study",
        description="Computes a study. Results that were written stay, however the run ends.",
    )
    parser.add_argument("study", metavar="STUDY.toml", help=STUDY)
    parser.add_argument(
        "--out",
        metavar="FILE.db",
        help="file of the results (default: that of the study, with .db at its end)",
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="go on with a file that this study has begun; begin it, if there is none",
    )
    add_workers(parser, keeps_results=True)
    parser.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="compute on the Dask cluster with this scheduler, such as tcp://host:8786; "
        "'local' starts one on this machine",
    )
    parser.add_argument(
        "--yes", action="store_true", help="allow more than 100 million geometries"
    )
    add_json_option(parser, _compute)


def _compute(arguments: argparse.Namespace) -> Answer:
    """Compute the study of the options.

    Raises:
        LinkageError: the study, its model or the file cannot be used, or workers fail.
    """
    if arguments.dask not in (None, "local") and arguments.workers is not None:
        arguments.refuse("--workers: only on this machine; a cluster has its own")
    from balance.studies.sweeps.study import read_study

    path = arguments.out or str(Path(arguments.study).with_suffix(".db"))
    job = read_study(arguments.study).job(yes=arguments.yes)
    from balance.studies.runs.chunk_runs import run_chunks
    from balance.studies.runs.results_file import ResultsFile

    open_file = ResultsFile.resume if arguments.resume else ResultsFile.create
    with open_file(path, job) as file:
        try:
            with progress_bar("geometries", True) as advance:
                summary = run_chunks(
                    job, file, workers=arguments.workers, dask=arguments.dask, progress=advance
                )
        except KeyboardInterrupt:
            logger.warning(_kept_text(path, file))
            raise
        except WorkerError as error:
            error.add_note(_kept_text(path, file))
            raise
        from balance.app.answers.text.sweep import run_body, run_data

        data = run_data(file, summary)
    return Answer(DONE, lambda: data, lambda: run_body(data))


def _kept_text(path: str, file: ResultsFile) -> str:
    """Say what a file keeps of a run that did not end.

    Args:
        path: path of the file, as it was given.
    """
    rows = file.computed()[0]
    return f"{path} keeps {rows} of {file.rows} geometries; --resume goes on from there"


def _add_export(kinds: Verbs) -> None:
    """Add ``sweep export``."""
    parser = kinds.add_parser(
        "export",
        help="write all results as a table, or one row as URDF",
        description="Writes all results as a table, or the linkage of one row as URDF, with "
        "its lengths and masses, and with the counterweights of the study (else the matter of "
        "reduce) in the masses of its links.",
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
    add_json_option(parser, _export)


def _export(arguments: argparse.Namespace) -> Answer:
    """Export the results of the options.

    Raises:
        LinkageError: a file cannot be read or written, or a library is missing.
    """
    urdf = arguments.out.lower().endswith(".urdf")
    if urdf != (arguments.row is not None):
        arguments.refuse("--row N and --out FILE.urdf need each other: one row is one linkage")
    from balance.app.answers.text.sweep import export_body, export_data
    from balance.studies.runs.results_file import ResultsFile

    with ResultsFile.open(arguments.results) as file, progress_bar("rows", True) as advance:
        if urdf:
            added = _export_row(file, arguments.row, arguments.out)
            data = export_data(file, arguments.out, 1, arguments.row, added)
        else:
            data = export_data(file, arguments.out, _export_table(file, arguments.out, advance))
        units = [column.unit for column in file.columns]
    return Answer(DONE, lambda: data, lambda: export_body(data, units))


def _export_table(file: ResultsFile, path: str, advance: Callable[[int, int], None]) -> int:
    """Write all rows as a table of the kind of the path, and count them."""
    from balance.studies.runs.export import export_csv, export_parquet, export_workbook

    kind = Path(path).suffix.lower()
    write = {".xlsx": export_workbook, ".parquet": export_parquet}.get(kind, export_csv)
    return write(file, path, advance)


def _export_row(file: ResultsFile, row: int, path: str) -> str:
    """Write the linkage of one row as URDF; return what added matter to it, or nothing.

    Raises:
        FileError: the file has no study of a sweep, or cannot be written.
        LinkageError: the row is no linkage.
    """
    from balance.studies.sweeps.job import SweepJob
    from balance.support.atomic_files import write_all_atomic

    if file.about["kind"] != "sweep":
        remedy = "balance discover export writes its members"
        raise FileError(file.path, "", "is no file of a sweep", remedy)
    linkage, added = SweepJob.from_description(file.about["description"]).completed(row)
    write_all_atomic([(path, linkage.to_urdf().encode())])
    return added


def _export_path(text: str) -> str:
    """Check that a word names a file of a known kind.

    Raises:
        ArgumentTypeError: it ends otherwise.
    """
    if not text.lower().endswith(EXPORTS):
        raise argparse.ArgumentTypeError(f"'{text}' ends in none of {', '.join(EXPORTS)}")
    return text


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
    from balance.app.answers.text.sweep import show_body, show_data
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
        remark=describe_written(arguments, True),
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
