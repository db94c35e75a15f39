"""The command ``balance sweep run``: a study of a file, or of a model and options.

Options of a model become the tables of a study, see `balance.app.cli.sweep_study`: both are
computed by the same code.
"""

from __future__ import annotations

import argparse
import logging
import os
import shlex
from collections.abc import Mapping
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser, Verbs
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.model_options import add_model_options
from balance.app.cli.next_command import without_options
from balance.app.cli.number_arguments import add_workers
from balance.app.cli.outputs import (
    TABLE_NOT_CSV,
    add_table_option,
    check_file_folders,
    describe_written,
    join_remarks,
)
from balance.app.cli.progress import progress_bar
from balance.app.cli.sweep_export import export_table, row_file
from balance.app.cli.sweep_study import (
    add_study_options,
    check_study_options,
    is_study,
    job_of_options,
    study_of_options,
)
from kinematics.error_text import clean, did_you_mean
from kinematics.errors import FileError, LinkageError, UsageError, WorkerError

if TYPE_CHECKING:
    from balance.app.answers.text.sweep import Data
    from balance.app.answers.text.sweep_run import NoAnswerRemedy
    from balance.studies.runs.chunk_runs import RunSummary
    from balance.studies.runs.results_file import ResultsFile
    from balance.studies.sweeps.job import SweepJob

logger = logging.getLogger(__name__)

# Before a column of --best: its largest value is the best.
LARGEST = "max:"
# Options that another request of the same model does without.
OF_RESULTS = {"--out": 1, "--resume": 0}
# What to write in place of options of other commands.
ELSEWHERE = {
    "--links": "write --counterweights L1,L2, or --reduce L1,L2 --budget KG",
    **TABLE_NOT_CSV,
    "--row": "write --best COLUMN=FILE.urdf, or balance sweep export FILE.db --row N",
    "--sort": "write --best COLUMN=FILE.urdf, or balance sweep show FILE.db --sort COLUMN",
}


class BestFile(str):
    """The path of the file of the best row.

    Attributes:
        column: column that says which row is the best.
        largest: whether its largest value is.
    """

    column: str
    largest: bool

    def __new__(cls, path: str, column: str, largest: bool) -> Self:
        """Make the path, with what says which row is the best."""
        file = super().__new__(cls, path)
        file.column, file.largest = column, largest
        return file


def add_run(kinds: Verbs) -> None:
    """Add ``sweep run`` to the parser of ``sweep``."""
    parser = kinds.add_parser(
        "run",
        help="compute a model with --vary, or a study",
        description="Computes a model in many geometries into one file, which keeps what is "
        "done however the run ends. Exits with 1 if no row has all answers, or none is best.",
    )
    named = "MODEL|STUDY.toml", "robot file or name of a model; or a study"
    add_model_options(parser, ("--motion",), motion_alone=True, named=named)
    add_study_options(parser)
    _add_outputs(parser)
    run = parser.group("run")
    run.add_argument(
        "--resume", action="store_true", help="go on with the file of --out, or begin it"
    )
    add_workers(run, keeps_results=True)
    run.add_argument(
        "--dask", metavar="ADDRESS", help="on the Dask cluster tcp://host:8786, or 'local'"
    )
    run.add_argument(
        "--yes", action="store_true", help="allow more than 100 million geometries"
    )
    parser.set_defaults(run=_compute)
    parser.elsewhere = ELSEWHERE
    parser.add_examples(
        "balance sweep run robot.urdf --vary coupler.length=800mm:1200mm:10",
        "balance sweep run robot.urdf --vary coupler.length=800mm:1200mm:10 \\\n"
        "    --counterweights crank,rocker --balance force --speed 300rpm \\\n"
        "    --table sweep.xlsx --best rms_moment_after=best.urdf",
        "balance sweep run study.toml --out study.db --resume",
    )


def _add_outputs(parser: Parser) -> None:
    """Add the options for files."""
    output = parser.group("output")
    add_table_option(output, "write all rows")
    output.add_argument(
        "--best",
        type=_best_file,
        metavar="COLUMN=FILE.urdf",
        help="write the row of least COLUMN (max:COLUMN: largest)",
    )
    output.add_argument(
        "--out", metavar="FILE.db", help="results (default: ./MODEL.db; STUDY.db beside it)"
    )
    output.add_argument(
        "--write-study", metavar="FILE.toml", help="write the options as a study to edit"
    )


def _compute(arguments: argparse.Namespace) -> Answer:
    """Compute the study of the options, and write its files.

    Raises:
        LinkageError: the study, its model or the file cannot be used, or workers fail.
    """
    if arguments.dask not in (None, "local") and arguments.workers is not None:
        arguments.refuse("--workers: only on this machine; a cluster has its own")
    check_study_options(arguments)
    job = job_of_options(arguments)
    if arguments.best is not None:
        _check_column(job, arguments.best.column)
    check_file_folders(arguments)
    study = "" if arguments.write_study is None else study_of_options(arguments)
    from balance.app.answers.text.sweep_run import run_body, run_data
    from balance.support.atomic_files import write_all_atomic

    with _open_results(arguments, job) as file:
        if study:
            write_all_atomic([(arguments.write_study, study.encode())])
        summary = _compute_chunks(arguments, job, file)
        best = _write_best(arguments, file)
        data = run_data(file, job, summary, best)
        remedy = None if data["answered"] else _find_remedy(job, file)
        lines = _next_lines(arguments, file, data, remedy)
        if arguments.table is not None:
            with progress_bar("rows", True) as advance:
                export_table(file, arguments.table, advance)
    no_best = best is not None and best["row"] is None
    return Answer(
        NEGATIVE if no_best or not data["answered"] else DONE,
        lambda: data,
        lambda: run_body(data, lines, is_study(arguments), remedy),
        remark=join_remarks(
            describe_written(arguments, True, without=("out", *["best"] * no_best)),
            _empty_table_text(arguments.table, data),
            _kept_results_text(arguments, file),
        ),
    )


def _write_best(arguments: argparse.Namespace, file: ResultsFile) -> Data | None:
    """Find the row of ``--best``, and write its file.

    Returns:
        What `run_data` takes; None if no best row is asked for.
    """
    if arguments.best is None:
        return None
    from balance.studies.runs.best_row import best_row
    from balance.support.atomic_files import write_all_atomic

    column, largest = arguments.best.column, arguments.best.largest
    best = best_row(file, column, largest)
    path, added = None, ""
    if best.row is not None:
        path = str(arguments.best)
        content, added = row_file(file, best.row, column)
        write_all_atomic([(path, content)])
    given = {"column": column, "largest": largest, **best._asdict()}
    return {**given, "added": added or None, "file": path}


def _compute_chunks(
    arguments: argparse.Namespace, job: SweepJob, file: ResultsFile
) -> RunSummary:
    """Compute the chunks that the file lacks; say what it keeps if that fails."""
    from balance.studies.runs.chunk_runs import run_chunks

    try:
        with progress_bar("geometries", True) as advance:
            return run_chunks(
                job, file, workers=arguments.workers, dask=arguments.dask, progress=advance
            )
    except KeyboardInterrupt:
        logger.warning(_kept_text(file))
        raise
    except WorkerError as error:
        error.add_note(_kept_text(file))
        raise


def _kept_text(file: ResultsFile) -> str:
    """Say what a file keeps of a run that did not end."""
    rows = file.computed()[0]
    return f"{file.path} keeps {rows} of {file.rows} geometries; --resume goes on from there"


def _open_results(arguments: argparse.Namespace, job: SweepJob) -> ResultsFile:
    """Open the file of the results to write it.

    Without ``--out``, that of a study has its name, and that of a model the first one of
    ``MODEL.db``, ``MODEL-2.db`` … that is new or has results of the same request.

    Raises:
        FileError: it exists, cannot be written, or is being written.
    """
    from balance.studies.runs.results_file import ResultsFile

    model = Path(arguments.model)
    if arguments.out is not None or is_study(arguments):
        path = arguments.out or str(model.with_suffix(".db"))
        return (ResultsFile.resume if arguments.resume else ResultsFile.create)(path, job)
    names = (f"{model.stem}{f'-{k}' if k > 1 else ''}.db" for k in count(1))
    return ResultsFile.resume(
        next(path for path in names if _is_free_or_same_job(path, job)), job
    )


def _kept_results_text(arguments: argparse.Namespace, file: ResultsFile) -> str:
    """Say that results of another request stay, if they have the name of the model."""
    first = f"{Path(arguments.model).stem}.db"
    if arguments.out is not None or is_study(arguments) or file.path == first:
        return ""
    return f"{first} has another request, and stays: these results are in {file.path}"


def _is_free_or_same_job(path: str, job: SweepJob) -> bool:
    """Whether a path is free, or is that of results of the same job."""
    from balance.studies.runs.results_file import ResultsFile

    if not os.path.lexists(path):
        return True
    try:
        with ResultsFile.open(path) as file:
            return file.about["digest"] == job.digest
    except FileError:
        return False


def _check_column(job: SweepJob, name: str) -> None:
    """Refuse a column of ``--best`` that there is not, or that has no numbers.

    Raises:
        UsageError: it is none.
    """
    numbers = [column.name for column in job.columns if column.kind != "text"]
    if name not in numbers:
        meant = did_you_mean(name, numbers)
        raise UsageError(
            f"--best {clean(name)}: no column of numbers has this name{meant}; there are "
            f"{', '.join(numbers)}"
        )


def _empty_table_text(table: str | None, data: Mapping[str, Any]) -> str:
    """Say what a table of rows without answers is good for."""
    if table is None or data["answered"]:
        return ""
    why = "its column reason says why, row by row"
    return f"no row of {clean(table, 1000)} has all answers: {why}"


def _find_remedy(job: SweepJob, file: ResultsFile) -> NoAnswerRemedy:
    """Find what gives a study without an answer some: the force alone, or other ranges."""
    from balance.app.answers.text.sweep_run import NoAnswerRemedy
    from balance.studies.sweeps.answered_ranges import answered_ranges

    row = _row_of_forces(job, file)
    return NoAnswerRemedy(row, {} if row is not None else answered_ranges(job))


def _row_of_forces(job: SweepJob, file: ResultsFile) -> int | None:
    """Find a row without masses that balance all shaking, which has masses for the force.

    Returns:
        The first row without, if it has those; else None.
    """
    from dataclasses import replace

    from balance.app.answers.text.sweep import REASON
    from balance.studies.sweeps.job import SweepJob
    from balance.studies.sweeps.study_data import StudyData

    study = StudyData.from_text(job.description)
    rows = chain.from_iterable(file.batches([REASON]))
    reasons = ((row, reason.partition(": ")[0]) for row, reason in rows if reason)
    unbalanced = ((row, name) for row, name in reasons if name in ("counterweights", "design"))
    row, name = next(unbalanced, (0, ""))
    if study.balance == "force" or not name:
        return None
    try:
        SweepJob.of_study(replace(study, balance="force")).linkage(row, name)
    except LinkageError:
        return None
    return row


def _next_lines(
    arguments: argparse.Namespace,
    file: ResultsFile,
    data: Mapping[str, Any],
    remedy: NoAnswerRemedy | None,
) -> list[str]:
    """List commands that lead on from the results.

    Args:
        data: from `balance.app.answers.text.sweep_run.run_data`.
        remedy: from `_find_remedy`; None if rows have answers.
    """
    from balance.app.answers.text.sweep import REASON

    path, best = shlex.quote(data["file"]), data["best"]
    lines = []
    if remedy is not None and not is_study(arguments):
        lines += _remedied_command(arguments, remedy)
    if best is not None and best["row"] is not None:
        crank, speed = arguments.speed or ("", "")
        motion = shlex.quote(f"{crank}={speed}" if crank else speed)
        turn = f" --speed {motion} --about 0,0,0" * bool(speed)
        lines.append(f"balance verify {shlex.quote(best['file'])}{turn}")
    elif data["answered"]:
        rows = chain.from_iterable(file.batches([REASON]))
        row = next(row for row, reason in rows if not reason)
        lines.append(f"balance sweep export {path} --row {row} --out row.urdf")
    page = shlex.quote(str(Path(data["file"]).with_suffix(".html")))
    if any(column["name"] == "closed" and column["most"] for column in data["columns"]):
        lines.append(f"balance sweep show {path} --html {page}")
    if not is_study(arguments) and arguments.write_study is None:
        lines.append("the same command with --write-study study.toml, a file to edit")
    return lines


def _remedied_command(arguments: argparse.Namespace, remedy: NoAnswerRemedy) -> list[str]:
    """Write the same request with what gives it answers; empty if nothing is known to."""
    words = without_options(arguments.words, OF_RESULTS)
    if remedy.force_row is not None:
        changed = [*without_options(words, {"--balance": 1}), "--balance", "force"]
    elif remedy.ranges and {*remedy.ranges} <= {path for path, _ in arguments.vary}:
        ranges = {
            path: ",".join(map(str, x)) if isinstance(x, list) else str(x)
            for path, x in arguments.vary
        }
        ranges.update(remedy.ranges)
        varied = (["--vary", f"{path}={text}"] for path, text in ranges.items())
        changed = [*without_options(words, {"--vary": 1}), *chain.from_iterable(varied)]
    else:
        return []
    return [shlex.join(["balance", "sweep", "run", *changed])]


def _best_file(text: str) -> BestFile:
    """Parse ``COLUMN=FILE.urdf`` or ``max:COLUMN=FILE.urdf``.

    Raises:
        ArgumentTypeError: it is neither.
    """
    name, _, path = text.partition("=")
    largest = name.startswith(LARGEST)
    column = name.removeprefix(LARGEST).strip()
    if not column or not path.lower().endswith(".urdf"):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not COLUMN=FILE.urdf, such as added_mass=best.urdf"
        )
    return BestFile(path, column, largest)
