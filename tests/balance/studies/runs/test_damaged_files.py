"""Files of results are checked like any input: what is damaged is one line, exit code 3."""

from __future__ import annotations

import sqlite3
from contextlib import closing

import pytest

from balance.studies.runs.results_file import ResultsFile
from tests.fuzz.random_requests import check
from tests.fuzz.results_mutants import SEARCH, good_file
from tests.fuzz.sweep_words import STUDY
from tests.support.command_runs import asked

pytestmark = pytest.mark.lanes

SHOW = ["sweep", "show", "{file}"]
PAGE = [*SHOW, "--html", "{folder}/page.html"]
EXPORT = ["sweep", "export", "{file}", "--out", "{folder}/a.csv"]
FAMILIES = ["discover", "show", "{file}", "--members", "1", "--tried", "0"]
RESUME = ["sweep", "run", "{folder}/study.toml", "--out", "{file}", "--resume"]
GEOMETRY = "UPDATE results SET geometry = '{}' WHERE geometry IS NOT NULL"
DESCRIPTION = "UPDATE about SET value = {} WHERE name = 'description'"
# Kind of the file, what is done to it, the command, and what it says.
DAMAGES = [
    ("sweep", "DELETE FROM about WHERE name = 'chunk_rows'", SHOW, "'chunk_rows' is missing"),
    ("sweep", "DELETE FROM about WHERE name = 'digest'", RESUME, "'digest' is missing"),
    ("sweep", "UPDATE about SET value = 'x' WHERE name = 'rows'", SHOW, "'rows' is missing"),
    ("sweep", "UPDATE about SET value = -1 WHERE name = 'rows'", SHOW, "'rows' is missing"),
    (
        "sweep",
        "UPDATE columns SET kind = 'ynteger' WHERE name = 'rank'",
        SHOW,
        "kind or unit of column 'rank'",
    ),
    ("sweep", "UPDATE columns SET unit = NULL", SHOW, "kind or unit of column"),
    ("sweep", "UPDATE columns SET name = 'rank'", SHOW, "stands twice"),
    ("sweep", "DELETE FROM columns", SHOW, "table 'columns' is empty"),
    ("sweep", "DROP TABLE columns", SHOW, "no table 'columns'"),
    ("sweep", "ALTER TABLE results DROP COLUMN rank", SHOW, "has other columns"),
    ("sweep", "ALTER TABLE about RENAME COLUMN value TO text", SHOW, "has other columns"),
    ("sweep", "UPDATE chunks SET rows = 'x'", SHOW, "chunks that the job does not have"),
    ("sweep", "INSERT INTO chunks VALUES (99, 2)", SHOW, "chunks that the job does not have"),
    ("sweep", "UPDATE results SET rank = 'x' WHERE row = 1", SHOW, "row 1 of 'rank' is not"),
    ("sweep", "UPDATE results SET rank = 0.5 WHERE row = 1", EXPORT, "row 1 of 'rank' is not"),
    ("sweep", "UPDATE results SET reason = x'00'", SHOW, "of 'reason' is not of kind text"),
    ("sweep", 'UPDATE results SET "rocker.length" = NULL', PAGE, "'rocker.length' are missing"),
    ("sweep", DESCRIPTION.format("substr(value, 9)"), PAGE, "study: is no JSON"),
    ("sweep", DESCRIPTION.format("'[1]'"), PAGE, "other entries than a study"),
    ("sweep", DESCRIPTION.format("json_set(value, '$.model', '')"), PAGE, "is no table"),
    (
        "sweep",
        DESCRIPTION.format("json_set(value, '$.model.options.x', '')"),
        PAGE,
        "options of its model",
    ),
    ("sweep", DESCRIPTION.format("json_set(value, '$.chunk_rows', 'x')"), PAGE, "chunk_rows"),
    (
        "sweep",
        "UPDATE columns SET unit = 'mm' WHERE unit = 'm'",
        RESUME,
        "are not those of its",
    ),
    ("sweep", "UPDATE about SET value = 7 WHERE name = 'rows'", RESUME, "are not those of its"),
    ("sweep", "DELETE FROM chunks WHERE chunk = 0", RESUME, "UNIQUE constraint failed"),
    ("search", GEOMETRY.format("{"), FAMILIES, "text of a geometry is damaged"),
    ("search", GEOMETRY.format("{}"), FAMILIES, "text of a geometry is damaged"),
    ("search", GEOMETRY.format('{"points": [[0]], "axes": [[1]]}'), FAMILIES, "this topology"),
    ("search", "UPDATE results SET geometry = NULL", FAMILIES, "geometry is damaged"),
    ("search", "UPDATE results SET nullity = 99 WHERE nullity > 0", FAMILIES, "its nullity"),
    ("search", DESCRIPTION.format("substr(value, 9)"), FAMILIES, "holds no search"),
    ("search", DESCRIPTION.format("json_set(value, '$.topology', '0-1')"), FAMILIES, "no loop"),
    ("search", DESCRIPTION.format("json_set(value, '$.starts', 'x')"), FAMILIES, "no search"),
    ("search", DESCRIPTION.format("json_set(value, '$.origin', '{')"), FAMILIES, "geometry is"),
    ("search", DESCRIPTION.format("json_set(value, '$.seed', -1)"), FAMILIES, "without a seed"),
]


@pytest.mark.table(12)
@pytest.mark.parametrize(("kind", "damage", "words", "said"), DAMAGES)
def test_a_damaged_file_is_told_in_one_line(tmp_path, kind, damage, words, said):
    path = tmp_path / "results.db"
    path.write_bytes(good_file(kind))
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute(damage)
    words = [word.format(file=path, folder=tmp_path) for word in words]
    before = path.read_bytes()
    done = asked(words)
    assert check(words, done) == f"{words[0]}: 3"
    assert said in done.err and str(path) in done.err
    # A run that goes on has begun to write by then.
    assert path.read_bytes() == before or "UNIQUE" in said
    assert len(list(tmp_path.glob("*"))) <= 3


def test_a_schema_that_is_no_text_is_told_in_one_line(tmp_path):
    """SQLite names its damaged words, which Python cannot read."""
    path, damage = (
        tmp_path / "results.db",
        (b"CREATE TABLE columns", b"CREATE TABL\xb7 columns"),
    )
    path.write_bytes(good_file("sweep").replace(*damage))
    words = [word.format(file=path) for word in SHOW]
    done = asked(words)
    assert check(words, done) == "sweep: 3" and "is damaged" in done.err


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sweep", "search"])
def test_the_good_files_are_read(tmp_path, kind):
    path = tmp_path / "results.db"
    path.write_bytes(good_file(kind))
    words = SHOW if kind == "sweep" else FAMILIES
    assert asked([word.format(file=path) for word in words]).code == 0


def test_rows_that_are_written_meanwhile_are_read_later(tmp_path, monkeypatch):
    """A run may write a chunk after the rows were counted, and before they are read."""
    path = tmp_path / "results.db"
    path.write_bytes(good_file("search"))
    with ResultsFile.open(path) as file:
        monkeypatch.setattr(file, "computed", lambda: (SEARCH.rows, 7))
        assert file.read(["outcome"])["row"].tolist() == list(range(7))
