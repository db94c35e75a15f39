"""What a file of results is refused for, in one line that says what to do."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from balance.studies.runs.chunk_job import ChunkJob, Column
from balance.studies.runs.program_version import program_version
from balance.studies.runs.tables import APPLICATION, FILE_VERSION
from kinematics.error_text import clean
from kinematics.errors import FileError

FULL = (
    "the disk is full or fails; the chunks that were written are kept",
    "make room and resume the run",
)
AGAIN = "run the study again with another file"
HELD = ("another program holds it", "close that program and resume the run")
# By the name of the error in SQLite, its primary part.
PROBLEMS = {
    "SQLITE_FULL": FULL,
    "SQLITE_IOERR": FULL,
    "SQLITE_BUSY": HELD,
    "SQLITE_LOCKED": HELD,
    "SQLITE_READONLY": ("cannot be written to", "give a file that can be written to"),
    "SQLITE_CANTOPEN": ("cannot be opened", "give a file that can be read, in such a folder"),
    "SQLITE_NOTADB": ("is no file of results", "give the file of a run"),
    "SQLITE_CORRUPT": ("is damaged", AGAIN),
}


def refusal(path: str, problem: str, remedy: str) -> FileError:
    """Make the error of a file of results.

    Args:
        path: path of the file.
    """
    return FileError(clean(path, 1000), "", problem, remedy)


def damaged(path: str, problem: str) -> FileError:
    """Make the error of a file of results whose contents are not those that a run writes.

    Args:
        path: path of the file.
    """
    return refusal(path, f"is damaged: {clean(problem, 300)}", AGAIN)


@contextmanager
def sqlite_errors(path: str) -> Iterator[None]:
    """Raise the errors of SQLite within the block as refusals of the file.

    Args:
        path: path of the file.

    Raises:
        FileError: an error of SQLite.
    """
    try:
        yield
    except UnicodeDecodeError:
        # Python cannot read what SQLite says of a damaged schema.
        raise refusal(path, *PROBLEMS["SQLITE_CORRUPT"]) from None
    except sqlite3.Error as error:
        name = "_".join(getattr(error, "sqlite_errorname", "").split("_")[:2])
        reason = f"cannot be used ({clean(str(error), 200)})"
        problem, remedy = PROBLEMS.get(name, (reason, "give another file"))
        raise refusal(path, problem, remedy) from None


def check_header(path: str, connection: sqlite3.Connection) -> bool:
    """Check that a file is one of results and of this version.

    Args:
        path: path of the file.

    Returns:
        Whether it is; False for a database that nothing was written to, which a run leaves
        that ends at once.

    Raises:
        FileError: it is another file, or one of another version.
    """
    with sqlite_errors(path):
        (application,) = connection.execute("PRAGMA application_id").fetchone()
        (version,) = connection.execute("PRAGMA user_version").fetchone()
        (tables,) = connection.execute("SELECT COUNT(*) FROM sqlite_master").fetchone()
    if application == 0 and version == 0 and tables == 0:
        return False
    if application != APPLICATION:
        raise refusal(path, "is no file of results", "give the file of a run")
    if version != FILE_VERSION:
        raise refusal(
            path,
            f"is a file of results of version {version}, and this reads {FILE_VERSION}",
            "use the version of the program that wrote it",
        )
    return True


def check_job(
    path: str,
    about: Mapping[str, str],
    size: tuple[int, int],
    columns: tuple[Column, ...],
    job: ChunkJob,
) -> None:
    """Refuse a job whose results are not those of a file.

    Args:
        path: path of the file.
        about: what the file says of its job.
        size: its rows, and those of a chunk.
        columns: its columns.

    Raises:
        FileError: it is another job, or the program has changed.
    """
    if about["kind"] != job.kind:
        problem = f"holds the results of a {clean(about['kind'])}, not of a {job.kind}"
    elif about["program"] != program_version():
        problem = (
            f"was begun by version {clean(about['program'])}, and this is {program_version()}"
        )
    elif about["digest"] != job.digest:
        problem = "holds the results of another study or model"
    elif size != (job.rows, job.chunk_rows) or columns != job.columns:
        raise damaged(path, "its rows or columns are not those of its study")
    else:
        return
    raise refusal(path, problem, "give another file, or go on with what began it")
