"""Tables of a file of results: names, statements, and conversions between NumPy and SQLite.

One row of the table ``results`` is one row of the job, under its number; each column of the job
is a column of the table, so that any program for SQLite can query it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.studies.runs.chunk_job import ROW_NUMBER, ChunkColumns, Column

# Marks of a file of results in the header of a SQLite file: "Bal1", and the version.
APPLICATION = 0x42616C31
FILE_VERSION = 2

TYPES = {"integer": "INTEGER", "real": "REAL", "text": "TEXT"}
DTYPES: dict[str, type] = {"integer": np.int64, "real": np.float64, "text": object}
MISSING: dict[str, Any] = {"integer": -1, "real": np.nan, "text": ""}


def sql_quoted(name: str) -> str:
    """Quote a name for SQL."""
    return '"' + name.replace('"', '""') + '"'


def sql_names(columns: Iterable[Column]) -> dict[str, str]:
    """Find the names of columns in SQL, which does not tell capital letters from small ones.

    A name that is taken gets a number: ``Q2``, ``q2 (2)``.
    """
    names: dict[str, str] = {}
    taken = {ROW_NUMBER}
    for column in columns:
        name, number = column.name, 1
        while name.lower() in taken:
            number += 1
            name = f"{column.name} ({number})"
        taken.add(name.lower())
        names[column.name] = name
    return names


def create_statements(columns: Sequence[Column]) -> list[str]:
    """Write the statements that create the tables.

    Args:
        columns: columns of the results.
    """
    names = sql_names(columns)
    typed = [f"{sql_quoted(names[column.name])} {TYPES[column.kind]}" for column in columns]
    return [
        "CREATE TABLE about (name TEXT PRIMARY KEY, value) WITHOUT ROWID",
        "CREATE TABLE columns (position INTEGER PRIMARY KEY, name TEXT, kind TEXT, unit TEXT, "
        "stored_as TEXT)",
        "CREATE TABLE chunks (chunk INTEGER PRIMARY KEY, rows INTEGER NOT NULL)",
        "CREATE TABLE begun (chunk INTEGER PRIMARY KEY, rows INTEGER NOT NULL)",
        f"CREATE TABLE results ({', '.join([f'{ROW_NUMBER} INTEGER PRIMARY KEY', *typed])})",
    ]


def insert_statement(count: int) -> str:
    """Write the statement that inserts a row of ``count`` columns after its number."""
    return f"INSERT INTO results VALUES ({', '.join('?' * (count + 1))})"


def to_rows(
    columns: Sequence[Column], values: ChunkColumns, first: int, limit: int
) -> list[tuple[Any, ...]]:
    """Convert columns of a chunk to rows of the table; a missing value becomes NULL.

    Args:
        columns: columns of the job.
        values: their values by name.
        first: number of the first row.
        limit: most rows of the chunk.

    Raises:
        ValueError: a column is missing or too long, or their lengths differ.
    """
    if values.keys() != {column.name for column in columns}:
        raise ValueError("the columns of a chunk are not those of its job")
    lists = [_to_list(column, values[column.name]) for column in columns]
    lengths = {len(items) for items in lists}
    if len(lengths) > 1 or max(lengths, default=0) > limit:
        raise ValueError(f"a chunk of {limit} rows has columns of {sorted(lengths)} values")
    numbers = range(first, first + max(lengths, default=0))
    return list(zip(numbers, *lists, strict=True))


def _to_list(column: Column, values: Any) -> list[Any]:
    """Convert the values of a column to a list for SQLite, which stores NaN as NULL."""
    if column.kind == "text":
        return [value or None for value in values]
    if column.kind == "real":
        return list(np.asarray(values, dtype=float).tolist())
    array = np.asarray(values)
    if array.dtype.kind in "iub" and not (array == MISSING["integer"]).any():
        return list(array.astype(np.int64).tolist())
    none = (None, MISSING["integer"])
    return [None if value in none or value != value else int(value) for value in values]


def to_arrays(
    columns: Sequence[Column], batches: Iterable[Sequence[tuple[Any, ...]]], count: int
) -> dict[str, NDArray[Any]]:
    """Gather columns from batches of rows; NULL becomes a missing value.

    Args:
        columns: the columns.
        batches: rows, each with its number and the values of the columns.
        count: most rows that there are.

    Returns:
        Read-only arrays by name, the numbers of the rows first: float64, int64, or texts as
        objects.
    """
    kinds = {ROW_NUMBER: "integer", **{column.name: column.kind for column in columns}}
    arrays: dict[str, NDArray[Any]] = {
        name: np.empty(count, dtype=DTYPES[kind]) for name, kind in kinds.items()
    }
    done = 0
    for batch in batches:
        for (name, kind), values in zip(kinds.items(), zip(*batch, strict=True), strict=True):
            missing = MISSING[kind]
            part = [missing if value is None else value for value in values]
            arrays[name][done : done + len(batch)] = part
        done += len(batch)
    for array in arrays.values():
        array.flags.writeable = False
    return {name: array[:done] for name, array in arrays.items()}
