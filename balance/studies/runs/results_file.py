"""The file that keeps the results of a job: SQLite, written by one process, chunk by chunk.

A chunk, or what is done of it, is written in one transaction, so that it is in the file as a
whole or not at all, however the process ends. The file is in WAL mode: others may read while it
is written.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from filelock import FileLock, Timeout
from numpy.typing import NDArray

from balance.studies.runs.check_contents import check_values, read_contents
from balance.studies.runs.chunk_job import (
    ROW_NUMBER,
    ChunkColumns,
    ChunkJob,
    ChunkTask,
    Column,
    chunk_count,
    chunk_size,
)
from balance.studies.runs.file_errors import (
    check_header,
    check_job,
    refusal,
    sqlite_errors,
)
from balance.studies.runs.program_version import program_version
from balance.studies.runs.tables import (
    APPLICATION,
    FILE_VERSION,
    create_statements,
    insert_statement,
    sql_names,
    sql_quoted,
    to_arrays,
    to_rows,
)
from kinematics.error_text import did_you_mean
from kinematics.errors import UsageError

# Rows that are read at once.
BATCH = 10_000
PATIENCE = 30.0
"""Seconds to wait for another program that holds a file."""


class ResultsFile:
    """A file of results.

    Attributes:
        path: its path, or the name in messages of rows in memory.
        stored: whether there is a file, and not rows in memory only.
        about: ``kind``, ``digest``, ``description`` of the job, and the ``program``.
        columns: columns of the results.
        rows: number of rows of the job, or a bound of it.
        chunk_rows: most rows of a chunk.
    """

    def __init__(self, path: str, connection: sqlite3.Connection) -> None:
        """Read what the file says of itself; use `create`, `resume` and `open` instead.

        Raises:
            FileError: the file is damaged.
        """
        self.path, self._connection, self.stored = path, connection, True
        self._lock: FileLock | None = None
        self.about, self.columns, self.rows, self.chunk_rows = read_contents(path, connection)
        self._names = sql_names(self.columns)

    @classmethod
    def create(cls, path: str | os.PathLike[str], job: ChunkJob) -> ResultsFile:
        """Create the file of a job, to write its chunks.

        Args:
            path: path of the file, which must not exist.

        Raises:
            FileError: the file exists, cannot be written, or is being written.
        """
        return cls._to_write(os.fspath(path), job, False)

    @classmethod
    def resume(cls, path: str | os.PathLike[str], job: ChunkJob) -> ResultsFile:
        """Open the file of the same job, to write the chunks that it lacks; or create it.

        Args:
            path: path of the file.

        Raises:
            FileError: the file is of another job, of another version or no file of results,
                cannot be written, or is being written.
        """
        return cls._to_write(os.fspath(path), job, True)

    @classmethod
    def _to_write(cls, path: str, job: ChunkJob, resume: bool) -> ResultsFile:
        """Lock the file, then create it or check that it is that of the job."""
        folder = os.path.dirname(os.path.abspath(path))
        if not os.path.isdir(folder):
            raise refusal(path, "its folder does not exist", "create it, or give another file")
        if os.path.exists(path) and not os.path.isfile(path):
            raise refusal(path, "is no regular file", "give a file")
        lock = FileLock(os.path.join(folder, f".{os.path.basename(path)}.lock"), timeout=0)
        try:
            lock.acquire()
        except Timeout:
            raise refusal(
                path, "another run writes it", "wait for its end, or give another file"
            ) from None
        except OSError as error:
            raise refusal(
                path,
                f"cannot be written ({error.strerror})",
                "give a path in a folder that can be written to",
            ) from None
        try:
            return cls._locked(path, job, resume, lock)
        except BaseException:
            _release(lock)
            raise

    @classmethod
    def _locked(cls, path: str, job: ChunkJob, resume: bool, lock: FileLock) -> ResultsFile:
        """Create the file or check it, after the lock is taken."""
        begun = os.path.exists(path) and os.path.getsize(path) > 0
        if begun and not resume:
            raise refusal(path, "exists", "resume it (--resume), or give another file")
        with sqlite_errors(path):
            connection = sqlite3.connect(path, timeout=PATIENCE, isolation_level=None)
        try:
            begun = begun and check_header(path, connection)
            if begun:
                begun_file = cls(path, connection)
                size = begun_file.rows, begun_file.chunk_rows
                check_job(path, begun_file.about, size, begun_file.columns, job)
            with sqlite_errors(path):
                # A power cut may cost the last chunks, and never the file.
                connection.execute("PRAGMA synchronous = NORMAL")
                connection.execute("PRAGMA journal_mode = WAL")
            if not begun:
                _begin_file(path, connection, job)
            file = cls(path, connection)
        except BaseException:
            connection.close()
            raise
        file._lock = lock
        return file

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> ResultsFile:
        """Open a file to read it, also while it is written.

        Args:
            path: path of the file.

        Raises:
            FileError: there is no such file, or it is no file of results of this version.
        """
        path = os.fspath(path)
        if not os.path.isfile(path):
            raise refusal(path, "no such file", "give the file of a run")
        connection = _connect_to_read(path)
        try:
            if not check_header(path, connection):
                raise refusal(path, "holds no results yet", "give the file of a run")
            return cls(path, connection)
        except BaseException:
            connection.close()
            raise

    @classmethod
    def in_memory(cls, name: str, job: ChunkJob, values: ChunkColumns) -> ResultsFile:
        """Hold all rows of a job in memory, to read them as those of a file.

        Args:
            name: what stands for the path in messages and on pages.
            values: the columns by name, all rows of each.
        """
        connection = sqlite3.connect(":memory:", isolation_level=None)
        try:
            _begin_file(name, connection, job)
            file = cls(name, connection)
            file.stored = False
            for chunk in range(chunk_count(job.rows, job.chunk_rows)):
                rows = slice(chunk * job.chunk_rows, (chunk + 1) * job.chunk_rows)
                file.write_chunk(chunk, {key: each[rows] for key, each in values.items()})
        except BaseException:
            connection.close()
            raise
        return file

    def pending(self) -> Iterator[int]:
        """Yield the numbers of the chunks that the file lacks, in order."""
        with sqlite_errors(self.path):
            done = {chunk for (chunk,) in self._connection.execute("SELECT chunk FROM chunks")}
        return (k for k in range(chunk_count(self.rows, self.chunk_rows)) if k not in done)

    def tasks(self) -> Iterator[ChunkTask]:
        """Yield the chunks that the file lacks, in order, each with its first missing row."""
        with sqlite_errors(self.path):
            begun = dict(self._connection.execute("SELECT chunk, rows FROM begun"))
        return ((chunk, begun.get(chunk, 0)) for chunk in self.pending())

    def computed(self) -> tuple[int, int]:
        """Count the rows of the job that the file covers, and the rows that they gave.

        The two differ if a job gives fewer rows than its bound.
        """
        query = (
            "SELECT COUNT(*), TOTAL(rows), MAX(chunk), (SELECT TOTAL(rows) FROM begun) "
            "FROM chunks"
        )
        with sqlite_errors(self.path):
            chunks, rows, last, begun = self._connection.execute(query).fetchone()
        covered = chunks * self.chunk_rows
        if last == chunk_count(self.rows, self.chunk_rows) - 1:
            covered -= self.chunk_rows - chunk_size(last, self.rows, self.chunk_rows)
        return covered + int(begun), int(rows + begun)

    def write_chunk(
        self, chunk: int, values: ChunkColumns, first: int = 0, ended: bool = True
    ) -> bool:
        """Write a chunk, or rows of it, unless the file has them.

        Args:
            values: its columns by name.
            first: the first row of the chunk in the columns, from 0.
            ended: whether these are its last rows.

        Returns:
            Whether it was written.

        Raises:
            FileError: the disk is full, or the file cannot be written; chunks that were written
                before are kept.
            ValueError: the columns are not those of the file.
        """
        limit = chunk_size(chunk, self.rows, self.chunk_rows)
        start = chunk * self.chunk_rows + first
        rows = to_rows(self.columns, values, start, limit - first)
        size = first + len(rows)
        with sqlite_errors(self.path), _transaction(self._connection) as cursor:
            if cursor.execute("SELECT 1 FROM chunks WHERE chunk = ?", (chunk,)).fetchone():
                return False
            query = "SELECT TOTAL(rows) FROM begun WHERE chunk = ?"
            begun = int(cursor.execute(query, (chunk,)).fetchone()[0])
            if first > begun or (size <= begun and not ended):
                return False
            cursor.execute("DELETE FROM begun WHERE chunk = ?", (chunk,))
            table = "chunks" if ended else "begun"
            cursor.execute(f"INSERT INTO {table} VALUES (?, ?)", (chunk, size))
            cursor.executemany(insert_statement(len(self.columns)), rows[begun - first :])
        return True

    def read(
        self,
        names: Sequence[str] | None = None,
        *,
        order: str = "",
        descending: bool = False,
        limit: int = -1,
        every: int = 1,
    ) -> dict[str, NDArray[Any]]:
        """Read columns.

        Args:
            names: the columns; all by default.
            order: column to sort by, rows without a value last; by default in the order of
                the job.
            descending: whether the largest comes first.
            limit: most rows; all by default.
            every: take only each row whose number is a multiple of this.

        Returns:
            Read-only arrays by name, and ``row``, the numbers of the rows.

        Raises:
            UsageError: there is no such column.
        """
        columns = self.columns if names is None else [self.column(name) for name in names]
        # A run may write more rows meanwhile.
        count = self.computed()[1]
        if limit >= 0:
            count = min(count, limit)
        picked = [column.name for column in columns]
        batches = self.batches(picked, order, descending, count, every)
        return to_arrays(columns, batches, count)

    def batches(
        self,
        names: Sequence[str],
        order: str = "",
        descending: bool = False,
        limit: int = -1,
        every: int = 1,
    ) -> Iterator[list[tuple[Any, ...]]]:
        """Yield rows in lists, each with its number and the values of columns.

        Args:
            names: the columns.
            order: column to sort by, reals by ten digits: rows that differ by round-off stay
                in their order.
            descending: whether the largest comes first.
            limit: most rows.
            every: take only each row whose number is a multiple of this.

        Raises:
            UsageError: there is no such column.
        """
        columns = [self.column(name) for name in names]
        picked = ", ".join(
            [ROW_NUMBER, *(sql_quoted(self._names[column.name]) for column in columns)]
        )
        sort = ROW_NUMBER
        if order:
            column = self.column(order)
            name = sql_quoted(self._names[column.name])
            by = _ten_digits(name) if column.kind == "real" else name
            sort = f"{name} IS NULL, {by} {'DESC' if descending else 'ASC'}, {ROW_NUMBER}"
        query = f"SELECT {picked} FROM results WHERE row % ? = 0 ORDER BY {sort} LIMIT ?"
        with sqlite_errors(self.path):
            cursor = self._connection.execute(query, (every, limit))
            while rows := cursor.fetchmany(BATCH):
                check_values(self.path, columns, rows)
                yield rows

    def counts(self, name: str) -> dict[Any, int]:
        """Count the rows by the value of a column, the most frequent first.

        Args:
            name: the column.

        Raises:
            UsageError: there is no such column.
        """
        column = self.column(name)
        by = sql_quoted(self._names[column.name])
        query = f"SELECT {by}, COUNT(*) FROM results GROUP BY {by} ORDER BY 2 DESC, 1"
        with sqlite_errors(self.path):
            counts = dict(self._connection.execute(query))
        check_values(self.path, [column], [(None, value) for value in counts])
        return counts

    def extent(self, name: str) -> tuple[Any, Any, int]:
        """Find the least and the largest value of a column, and how many are missing.

        Args:
            name: the column.

        Returns:
            Both values, None if there is none, and the number of missing ones.

        Raises:
            UsageError: there is no such column.
        """
        column = self.column(name)
        of = sql_quoted(self._names[column.name])
        query = f"SELECT MIN({of}), MAX({of}), COUNT(*) - COUNT({of}) FROM results"
        with sqlite_errors(self.path):
            least, most, missing = self._connection.execute(query).fetchone()
        check_values(self.path, [column], [(None, least), (None, most)])
        return least, most, missing

    def column(self, name: str) -> Column:
        """Find a column by its name.

        Raises:
            UsageError: there is none; the message lists those that there are.
        """
        match = next((column for column in self.columns if column.name == name), None)
        if match is None:
            names = ", ".join(column.name for column in self.columns)
            meant = did_you_mean(name, (column.name for column in self.columns))
            raise UsageError(f"{self.path}: no column '{name}'{meant}; the columns are {names}")
        return match

    def close(self) -> None:
        """Close the file, and let others write it.

        Unless somebody reads it, all of it is then in one file, which can be read anywhere.
        """
        try:
            if self._lock is not None:
                with suppress(sqlite3.Error, UnicodeDecodeError):
                    self._connection.execute("PRAGMA busy_timeout = 0")
                    self._connection.execute("PRAGMA journal_mode = DELETE")
            self._connection.close()
        finally:
            if self._lock is not None:
                _release(self._lock)

    def __enter__(self) -> ResultsFile:
        """Return the file; it is closed at the end of the block."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()


def _release(lock: FileLock) -> None:
    """Remove the file of a lock, and release it, if it is held.

    It is removed while it is locked: another run that opened it before locks a file that is
    gone, which `filelock` refuses.
    """
    if lock.is_locked:
        with suppress(OSError):  # Windows removes no open file
            os.remove(lock.lock_file)
        lock.release()


def _connect_to_read(path: str) -> sqlite3.Connection:
    """Connect to a file for reading, also on a medium that cannot be written to.

    Raises:
        FileError: it cannot be opened.
    """
    from urllib.request import pathname2url

    address = f"file:{pathname2url(os.path.abspath(path))}?mode=ro"
    with sqlite_errors(path):
        connection = sqlite3.connect(address, uri=True, timeout=PATIENCE, isolation_level=None)
        try:
            connection.execute("PRAGMA schema_version")
        except sqlite3.Error as error:
            connection.close()
            unopened = getattr(error, "sqlite_errorname", "") == "SQLITE_CANTOPEN"
            if not unopened or os.path.exists(f"{path}-wal"):
                raise
            connection = sqlite3.connect(f"{address}&immutable=1", uri=True)
    return connection


def _begin_file(path: str, connection: sqlite3.Connection, job: ChunkJob) -> None:
    """Write all of a new file but the chunks.

    Args:
        path: path of the file.

    Raises:
        FileError: it cannot be written.
    """
    facts = {
        "kind": job.kind,
        "digest": job.digest,
        "description": job.description,
        "program": program_version(),
        "rows": job.rows,
        "chunk_rows": job.chunk_rows,
    }
    names = sql_names(job.columns)
    columns = [
        (k, column.name, column.kind, column.unit, names[column.name])
        for k, column in enumerate(job.columns)
    ]
    with sqlite_errors(path), _transaction(connection) as cursor:
        for statement in create_statements(job.columns):
            cursor.execute(statement)
        cursor.executemany("INSERT INTO about VALUES (?, ?)", facts.items())
        cursor.executemany("INSERT INTO columns VALUES (?, ?, ?, ?, ?)", columns)
        cursor.execute(f"PRAGMA application_id = {APPLICATION}")
        cursor.execute(f"PRAGMA user_version = {FILE_VERSION}")


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[sqlite3.Cursor]:
    """Run statements that all have effect, or none."""
    cursor = connection.cursor()
    cursor.execute("BEGIN IMMEDIATE")
    try:
        yield cursor
        cursor.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            cursor.execute("ROLLBACK")
        raise


def _ten_digits(name: str) -> str:
    """Write the expression of SQL for a real number to ten digits; infinite ones stay."""
    short = f"CAST(printf('%.9e', {name}) AS REAL)"
    return f"CASE WHEN abs({name}) < 1e300 THEN {short} ELSE {name} END"
