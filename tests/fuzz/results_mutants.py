"""Files of results that are damaged: their bytes, tables, cells, and JSON texts in cells."""

from __future__ import annotations

import json
import random
import sqlite3
import tempfile
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import balance
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.runs.chunk_runs import run_chunks
from balance.studies.runs.results_file import ResultsFile
from tests.fuzz.json_mutants import changed, odd_value
from tests.fuzz.mutant_bytes import cut, cut_out, insert, repeat_span
from tests.fuzz.sweep_words import STUDY

SEARCH = DiscoveryJob("slider-crank", 30)
TABLES = ("about", "columns", "chunks", "results")


@cache
def good_file(kind: str) -> bytes:
    """A complete file of a sweep or of a search."""
    with tempfile.TemporaryDirectory() as folder:
        path, study = Path(folder) / "good.db", Path(folder) / "study.toml"
        study.write_text(STUDY, encoding="utf-8")
        job = SEARCH if kind == "search" else balance.studies.read_study(study).job()
        with ResultsFile.create(path, job) as file:
            run_chunks(job, file, workers=0)
        return path.read_bytes()


def write_mutant(rng: random.Random, path: Path, kind: str) -> list[str]:
    """Write a damaged file.

    Args:
        rng: chooses the damages.
        path: of the file.
        kind: ``"sweep"`` or ``"search"``.

    Returns:
        What was done, for messages.
    """
    data, done = good_file(kind), []
    if rng.random() < 0.12:
        damage = rng.choice((cut, cut_out, insert, repeat_span, _flip))
        path.write_bytes(damage(rng, data))
        return [damage.__name__]
    path.write_bytes(data)
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        for _ in range(rng.choice((1, 1, 1, 1, 2, 3))):
            damage = rng.choice(DAMAGES)
            try:
                done.append(damage(rng, connection))
            # Some damages exclude each other.
            except (sqlite3.Error, OverflowError, ValueError, TypeError, LookupError) as error:
                done.append(f"{damage.__name__}: {error}")
    return done


def _flip(rng: random.Random, data: bytes) -> bytes:
    """Replace some bytes."""
    found = bytearray(data)
    for _ in range(rng.choice((1, 3, 30))):
        found[rng.randrange(len(found))] = rng.randrange(256)
    return bytes(found)


def _cell_value(rng: random.Random) -> Any:
    """Take a value that SQLite keeps in any cell."""
    value = odd_value(rng)
    if isinstance(value, int) and abs(value) >= 2**63:
        return str(value)
    if isinstance(value, str) and rng.random() < 0.2:
        return value.encode()
    return (
        value
        if isinstance(value, int | float | str) or value is None
        else json.dumps(value, default=str)
    )


def _columns_of(connection: sqlite3.Connection, table: str) -> list[str]:
    return [row[1] for row in connection.execute(f"PRAGMA table_info({table})")]


def change_cell(rng: random.Random, connection: sqlite3.Connection) -> str:
    """Put another value into a cell, or into all cells of a column."""
    table = rng.choice((*TABLES, "about", "columns"))
    column = rng.choice(_columns_of(connection, table))
    key = _columns_of(connection, table)[0]
    keys = [row[0] for row in connection.execute(f"SELECT {key} FROM {table}")]
    row, value = rng.choice(keys or [0]), _cell_value(rng)
    where = f" WHERE {key} = ?" if rng.random() < 0.8 else ""
    given = (value, row) if where else (value,)
    connection.execute(f'UPDATE {table} SET "{column}" = ?{where}', given)
    return f"{table}.{column} of {row if where else 'all'} = {value!r}"


def change_json(rng: random.Random, connection: sqlite3.Connection) -> str:
    """Change a JSON text inside: the description of the job, or geometries of a search."""
    names = _columns_of(connection, "results")
    if "geometry" in names and rng.random() < 0.5:
        query = "SELECT row, geometry FROM results WHERE geometry IS NOT NULL"
        rows = connection.execute(query).fetchall()
        for row, text in rng.sample(rows, rng.choice((1, len(rows)))):
            new = _changed_text(rng, text)
            connection.execute("UPDATE results SET geometry = ? WHERE row = ?", (new, row))
        return f"geometry = {new!r}"
    query = "SELECT value FROM about WHERE name = 'description'"
    new = _changed_text(rng, connection.execute(query).fetchone()[0])
    connection.execute("UPDATE about SET value = ? WHERE name = 'description'", (new,))
    return f"description = {new!r}"


def _changed_text(rng: random.Random, text: str) -> str:
    """Change a JSON text: its values, or its characters."""
    if rng.random() < 0.2:
        damage = rng.choice((cut, cut_out, insert, repeat_span))
        return damage(rng, text.encode()).decode("utf-8", "replace")
    return json.dumps(changed(rng, json.loads(text)), default=str)


def change_table(rng: random.Random, connection: sqlite3.Connection) -> str:
    """Drop or rename a table or a column, or add one."""
    table = rng.choice(TABLES)
    column = rng.choice(_columns_of(connection, table))
    statement = rng.choice(
        (
            "DROP TABLE {table}",
            "ALTER TABLE {table} RENAME TO other",
            'ALTER TABLE {table} DROP COLUMN "{column}"',
            'ALTER TABLE {table} RENAME COLUMN "{column}" TO other',
            "ALTER TABLE {table} ADD COLUMN other",
            "DELETE FROM {table}",
            "CREATE TABLE other (x)",
            "CREATE VIEW other AS SELECT * FROM {table}",
        )
    ).format(table=table, column=column)
    connection.execute(statement)
    return statement


def change_rows(rng: random.Random, connection: sqlite3.Connection) -> str:
    """Delete rows of a table, repeat one, or add one."""
    table = rng.choice(TABLES)
    key, *others = _columns_of(connection, table)
    rows = connection.execute(f"SELECT * FROM {table}").fetchall()
    if rng.random() < 0.5 or not rows:
        connection.execute(f"DELETE FROM {table} WHERE {key} = ?", (rng.choice(rows)[0],))
        return f"DELETE FROM {table}"
    row = rng.choice(rows)
    new = rng.choice((-1, 99, 2**62, "x", None))
    marks = ", ".join("?" * (1 + len(others)))
    connection.execute(f"INSERT INTO {table} VALUES ({marks})", (new, *row[1:]))
    return f"INSERT INTO {table} {new!r}"


def change_header(rng: random.Random, connection: sqlite3.Connection) -> str:
    """Change the marks of the file."""
    name = rng.choice(("application_id", "user_version", "encoding", "journal_mode"))
    value = {"encoding": "'UTF-16'", "journal_mode": "WAL"}.get(name, rng.choice((0, 1, 2, -1)))
    connection.execute(f"PRAGMA {name} = {value}")
    return f"PRAGMA {name} = {value}"


DAMAGES = (
    change_cell,
    change_cell,
    change_cell,
    change_json,
    change_json,
    change_json,
    change_table,
    change_rows,
    change_header,
)
