"""What a file of results must hold: its tables, facts, columns, and types of values.

A file is checked like any input. Whatever is wrong is one line that says what is damaged.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from balance.studies.runs.chunk_job import ROW_NUMBER, Column, chunk_count
from balance.studies.runs.file_errors import damaged, sqlite_errors
from balance.studies.runs.tables import TYPES, sql_names

FACTS = ("kind", "digest", "description", "program")
NUMBERS = ("rows", "chunk_rows")
# Columns of the tables that all files have.
TABLES = {
    "about": ("name", "value"),
    "columns": ("position", "name", "kind", "unit", "stored_as"),
    "chunks": ("chunk", "rows"),
    "begun": ("chunk", "rows"),
}
# Types of Python that each kind of column may hold.
VALUES: Mapping[str, frozenset[type]] = {
    "integer": frozenset((int, type(None))),
    "real": frozenset((float, type(None))),
    "text": frozenset((str, type(None))),
}


class Contents(NamedTuple):
    """What a file says of itself.

    Attributes:
        about: kind, digest and description of the job, and the program.
        columns: columns of the results.
        rows: number of rows of the job.
        chunk_rows: most rows of a chunk.
    """

    about: dict[str, str]
    columns: tuple[Column, ...]
    rows: int
    chunk_rows: int


def read_contents(path: str, connection: sqlite3.Connection) -> Contents:
    """Read and check all but the results.

    Args:
        path: path of the file.

    Raises:
        FileError: a table, a fact or a column is missing, or is not what a run writes.
    """
    with sqlite_errors(path):
        for table, names in TABLES.items():
            _check_table(path, connection, table, names)
        about = _read_about(path, connection)
        columns = tuple(_read_columns(path, connection))
        stored = sql_names(columns)
        names = (ROW_NUMBER, *(stored[column.name] for column in columns))
        _check_table(path, connection, "results", names)
        rows, chunk_rows = about.pop("rows"), about.pop("chunk_rows")
        _check_chunks(path, connection, rows, chunk_rows)
    return Contents(about, columns, rows, chunk_rows)


def check_values(path: str, columns: Sequence[Column], rows: Sequence[tuple[Any, ...]]) -> None:
    """Check the types of the values of rows.

    Args:
        path: path of the file.
        columns: columns of the rows, after the number of the row.
        rows: the rows, each with its number, or None, before the values.

    Raises:
        FileError: a value is not of the kind of its column.
    """
    for k, column in enumerate(columns, 1):
        types = VALUES[column.kind]
        if not types.issuperset(map(type, (row[k] for row in rows))):
            row = next(row[0] for row in rows if type(row[k]) not in types)
            where = "a value" if row is None else f"the value in row {row}"
            raise damaged(path, f"{where} of '{column.name}' is not of kind {column.kind}")


def _check_table(
    path: str, connection: sqlite3.Connection, table: str, names: Sequence[str]
) -> None:
    """Check the columns of a table."""
    there = [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]
    if not there:
        raise damaged(path, f"it has no table '{table}'")
    if there != list(names):
        problem = f"its table '{table}' has other columns than a run writes"
        raise damaged(path, problem)


def _read_about(path: str, connection: sqlite3.Connection) -> dict[str, Any]:
    """Read the facts: texts, and two whole numbers."""
    about = dict(connection.execute("SELECT name, value FROM about"))
    for name in (*FACTS, *NUMBERS):
        value = about.get(name)
        if not (isinstance(value, str) if name in FACTS else _is_positive(value)):
            raise damaged(path, f"'{name}' is missing in its table 'about', or has no meaning")
    return {name: about[name] for name in (*FACTS, *NUMBERS)}


def _is_positive(value: object) -> bool:
    return isinstance(value, int) and value > 0


def _read_columns(path: str, connection: sqlite3.Connection) -> list[Column]:
    """Read the columns of the results."""
    columns: list[Column] = []
    query = "SELECT name, kind, unit, stored_as FROM columns ORDER BY position"
    for name, kind, unit, _ in connection.execute(query):
        if not isinstance(name, str) or name in {ROW_NUMBER, *(c.name for c in columns)}:
            raise damaged(path, "its table 'columns' has a name that is none, or stands twice")
        if kind not in TYPES or not isinstance(unit, str):
            raise damaged(path, f"kind or unit of column '{name}' has no meaning")
        columns.append(Column(name, kind, unit))
    if not columns:
        raise damaged(path, "its table 'columns' is empty")
    return columns


def _check_chunks(
    path: str, connection: sqlite3.Connection, rows: int, chunk_rows: int
) -> None:
    """Check the numbers and the sizes of the chunks."""
    query = (
        "SELECT COUNT(*) FROM (SELECT * FROM chunks UNION ALL SELECT * FROM begun) WHERE "
        "typeof(rows) != 'integer' OR rows < 0 OR rows > ? OR chunk < 0 OR chunk >= ?"
    )
    (wrong,) = connection.execute(query, (chunk_rows, chunk_count(rows, chunk_rows))).fetchone()
    (twice,) = connection.execute(
        "SELECT COUNT(*) FROM begun WHERE chunk IN (SELECT chunk FROM chunks)"
    ).fetchone()
    if wrong or twice:
        raise damaged(path, "it has chunks that the job does not have")
