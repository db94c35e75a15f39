"""Connections to files of results: for reading, and for the first transaction of a new file."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager

from balance.studies.runs.chunk_job import ChunkJob
from balance.studies.runs.file_errors import sqlite_errors
from balance.studies.runs.program import program
from balance.studies.runs.tables import (
    APPLICATION,
    FILE_VERSION,
    create_statements,
    sql_names,
)

PATIENCE = 30.0
"""Seconds to wait for another program that holds a file."""


def connect_to_read(path: str) -> sqlite3.Connection:
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


def begin_file(path: str, connection: sqlite3.Connection, job: ChunkJob) -> None:
    """Write all of a new file but the chunks.

    Args:
        path: path of the file.

    Raises:
        FileError: it cannot be written.
    """
    facts = {
        "kind": job.kind, "digest": job.digest, "description": job.description,
        "program": program(), "rows": job.rows, "chunk_rows": job.chunk_rows,
    }  # fmt: skip
    names = sql_names(job.columns)
    columns = [
        (k, column.name, column.kind, column.unit, names[column.name])
        for k, column in enumerate(job.columns)
    ]
    with sqlite_errors(path), transaction(connection) as cursor:
        for statement in create_statements(job.columns):
            cursor.execute(statement)
        cursor.executemany("INSERT INTO about VALUES (?, ?)", facts.items())
        cursor.executemany("INSERT INTO columns VALUES (?, ?, ?, ?, ?)", columns)
        cursor.execute(f"PRAGMA application_id = {APPLICATION}")
        cursor.execute(f"PRAGMA user_version = {FILE_VERSION}")


@contextmanager
def transaction(connection: sqlite3.Connection) -> Iterator[sqlite3.Cursor]:
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
