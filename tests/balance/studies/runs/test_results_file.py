"""The file of results: what it keeps, and what it refuses in one line."""

from __future__ import annotations

import csv
import hashlib
import math
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from balance.studies.runs import file_errors
from balance.studies.runs.chunk_job import Column
from balance.studies.runs.export import export_csv, export_parquet
from balance.studies.runs.program_version import program_version
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import FileError, LinkageError, UsageError
from tests.support.covering import ALL_CASES
from tests.support.squares import Squares

try:
    import fcntl
except ImportError:
    fcntl = None


def expected(rows: int) -> list[dict]:
    """The rows of `Squares`, computed one by one without NumPy."""
    return [
        {
            "row": n,
            "number": -1 if n % 5 == 0 else n * n,
            "Number": math.nan if n % 7 == 3 else math.sqrt(n) / 3.0,
            "words": "" if n % 11 == 0 else f"ä,{n}",
            'odd "name"': math.inf,
        }
        for n in range(rows)
    ]


def filled(path: Path, job: Squares, chunks=None) -> ResultsFile:
    """A file with some chunks of a job, written backwards; all by default."""
    file = ResultsFile.create(path, job)
    for chunk in reversed(list(file.pending()) if chunks is None else chunks):
        assert file.write_chunk(chunk, job.compute(chunk))
    return file


def csv_bytes(file: ResultsFile, path: Path) -> bytes:
    """What a file exports."""
    export_csv(file, str(path))
    return path.read_bytes()


def refused(path: Path, job: Squares, way: str = "resume") -> str:
    """The message of a refusal, which is one line and leaves the file as it is."""
    before = path.read_bytes()
    with pytest.raises(FileError) as caught:
        getattr(ResultsFile, way)(path, job)
    assert path.read_bytes() == before
    text = str(caught.value)
    assert "\n" not in text and text.startswith(str(path))
    return text


def test_what_is_written_comes_back(tmp_path):
    job = Squares()
    with filled(tmp_path / "a.db", job) as file:
        assert file.columns == job.columns and file.computed() == (1000, 1000)
        assert list(file.pending()) == []
        found = file.read()
        rows = zip(*(values.tolist() for values in found.values()), strict=True)
        for row, known in zip(rows, expected(1000), strict=True):
            assert repr(dict(zip(found, row, strict=True))) == repr(known)
        assert found["number"].dtype == np.int64 and not found["Number"].flags.writeable


def test_a_chunk_counts_once(tmp_path):
    job = Squares()
    with filled(tmp_path / "a.db", job, [3, 15]) as file:
        assert not file.write_chunk(3, job.compute(3))
        # Chunk 15 is the last one and has 40 rows.
        assert file.computed() == (104, 104)
        assert list(file.pending()) == [0, 1, 2, *range(4, 15)]
        assert file.read(["number"])["row"].tolist() == [*range(192, 256), *range(960, 1000)]


def test_columns_of_another_shape_are_a_defect_and_change_nothing(tmp_path):
    job = Squares()
    good = dict(job.compute(0))
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        short = {**good, "number": good["number"][:-1]}
        long = {name: np.tile(values, 2) for name, values in good.items()}
        missing = {name: good[name] for name in list(good)[1:]}
        for wrong in (short, long, missing, {**good, "more": good["number"]}):
            with pytest.raises(ValueError) as caught:
                file.write_chunk(0, wrong)
            assert not isinstance(caught.value, LinkageError)
        assert file.computed() == (0, 0)


def test_a_job_may_give_fewer_rows_than_its_bound(tmp_path):
    job = Squares()
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        few = {name: values[:2] for name, values in job.compute(2).items()}
        none = {name: values[:0] for name, values in job.compute(1).items()}
        assert file.write_chunk(2, few) and file.write_chunk(1, none)
        assert file.computed() == (128, 2)
        assert file.read()["row"].tolist() == [128, 129]


def test_any_program_for_sqlite_reads_it(tmp_path):
    filled(tmp_path / "a.db", Squares()).close()
    query = 'SELECT row, number, "Number (2)", words FROM results WHERE number = 169'
    with closing(sqlite3.connect(tmp_path / "a.db")) as connection:
        rows = connection.execute(query).fetchall()
    assert rows == [(13, 169, math.sqrt(13) / 3.0, "ä,13")]


def test_rows_are_sorted_with_missing_values_last(tmp_path):
    with filled(tmp_path / "a.db", Squares()) as file:
        for descending in (False, True):
            found = file.read(["Number"], order="Number", descending=descending)["Number"]
            kept = found[~np.isnan(found)]
            assert np.isnan(found[len(kept) :]).all() and len(kept) == 857
            assert (np.diff(kept) * (-1) ** descending > 0).all()
        best = file.read(["number"], order="number", descending=True, limit=3)
        assert best["number"].tolist() == [999**2, 998**2, 997**2]
        assert file.counts("number")[None] == 200
        for call in (file.read, file.counts):
            with pytest.raises(UsageError, match="no column 'nr'; the columns are number, Num"):
                call(["nr"] if call == file.read else "nr")


def test_rows_that_differ_by_round_off_stay_in_their_order(tmp_path):
    """Three values of almost one size, a smaller one, none, and infinite ones."""
    values = [2.0, 2.0 - 1e-15, 2.0 + 1e-15, 1.999999, np.nan, np.inf, -np.inf, 1e305]
    job = Squares(rows=len(values), columns=(Column("value", "real"),))
    with ResultsFile.create(tmp_path / "a.db", job) as file:
        file.write_chunk(0, {"value": np.array(values)})
        rows = [[row for row, _ in batch] for batch in file.batches(["value"], "value")]
        assert rows == [[6, 3, 0, 1, 2, 7, 5, 4]]
        rows = [[row for row, _ in batch] for batch in file.batches(["value"], "value", True)]
        assert rows == [[5, 7, 0, 1, 2, 3, 6, 4]]


def test_the_name_of_the_number_of_a_row_is_taken():
    with pytest.raises(UsageError, match="'row'"):
        Column("row", "real")


@pytest.mark.slow
def test_csv_and_parquet_give_the_numbers_back(tmp_path):
    pyarrow = pytest.importorskip("pyarrow.parquet")
    with filled(tmp_path / "a.db", Squares()) as file:
        text = csv_bytes(file, tmp_path / "a.csv").decode()
        export_parquet(file, str(tmp_path / "a.parquet"))
    head, *rows = csv.reader(text.splitlines())
    parquet = pyarrow.read_table(tmp_path / "a.parquet")
    assert parquet.column_names == ["row", "number", "Number", "words", 'odd "name"']
    assert head == ["row", "number", "Number (m)", "words", 'odd "name"']
    assert parquet.schema.field("Number").metadata == {b"unit": b"m"}
    columns = parquet.to_pydict()
    for n, row in enumerate(rows):
        known = expected(1000)[n]
        cells = [None if values[n] is None else str(values[n]) for values in columns.values()]
        assert [cell or None for cell in row] == cells
        for cell, value in zip(row, known.values(), strict=True):
            missing = value in (-1, "") or value != value
            assert (cell == "") if missing else type(value)(cell) == value
    assert len(rows) == parquet.num_rows == 1000


def test_the_same_job_goes_on_and_no_other_does(tmp_path, monkeypatch):
    path, job = tmp_path / "a.db", Squares()
    filled(path, job, [0]).close()
    with ResultsFile.resume(path, job) as file:
        assert file.computed() == (64, 64)
    assert "exists; resume it (--resume)" in refused(path, job, "create")
    assert "of another study or model; give another file" in refused(path, Squares(seed="x"))
    assert "of a squares, not of a cubes" in refused(path, Squares(kind="cubes", seed="x"))
    assert "of another study or model" in refused(path, Squares(rows=1001))
    monkeypatch.setattr(file_errors, "program_version", lambda: "999.0 (code x)")
    assert "was begun by version" in (text := refused(path, job))
    assert "and this is 999.0 (code x); give another file, or go on" in text


def test_the_program_is_its_code(tmp_path, monkeypatch):
    """Any change of any module is another program, and so is a module of another name."""
    names = {program_version.__wrapped__()}
    for package in ("kinematics", "balance"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "a.py").write_text("1")
    monkeypatch.setattr("balance.studies.runs.program_version.ROOT", tmp_path)
    names.add(program_version.__wrapped__())
    names.add(program_version.__wrapped__())
    assert len(names) == 2
    (tmp_path / "balance" / "a.py").write_text("2")
    names.add(program_version.__wrapped__())
    (tmp_path / "balance" / "a.py").rename(tmp_path / "balance" / "b.py")
    names.add(program_version.__wrapped__())
    assert len(names) == 4


def test_two_runs_do_not_share_a_file(tmp_path):
    path, job = tmp_path / "a.db", Squares()
    with filled(path, job, [0]):
        for way in ("resume", "create"):
            with pytest.raises(FileError, match="another run writes it"):
                getattr(ResultsFile, way)(path, job)
        with ResultsFile.open(path) as reader:
            assert reader.computed() == (64, 64)
        # What keeps runs apart is no file that a listing of the folder shows.
        names = {each.name for each in tmp_path.iterdir()}
        assert names - {"a.db", "a.db-shm", "a.db-wal"} == {".a.db.lock"}
    first = ResultsFile.resume(path, job)
    first.close()
    with ResultsFile.resume(path, job):
        first.close()  # once more: the lock of the other run stays
        assert (tmp_path / ".a.db.lock").exists()
    assert [each.name for each in tmp_path.iterdir()] == ["a.db"]


@pytest.mark.skipif(fcntl is None, reason="Windows removes no open file")
def test_no_run_locks_a_file_that_another_removes(tmp_path, monkeypatch):
    """One run ends after a second one has opened the lock, and before it locks it."""
    path, job, flock = tmp_path / "a.db", Squares(), fcntl.flock
    first = ResultsFile.create(path, job)

    def end_first(descriptor: int, how: int) -> None:
        monkeypatch.setattr(fcntl, "flock", flock)
        first.close()
        flock(descriptor, how)

    monkeypatch.setattr(fcntl, "flock", end_first)
    with pytest.raises(FileError, match="another run writes it"):
        ResultsFile.resume(path, job)
    assert [each.name for each in tmp_path.iterdir()] == ["a.db"]


def test_a_run_that_ended_at_once_is_begun_again(tmp_path):
    job = Squares()
    empty, bare = tmp_path / "empty.db", tmp_path / "bare.db"
    empty.touch()
    connection = sqlite3.connect(bare)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.close()
    assert bare.stat().st_size > 0
    for path in (empty, bare):
        with pytest.raises(FileError, match="holds no results yet"):
            ResultsFile.open(path)
        with ResultsFile.resume(path, job) as file:
            assert file.computed() == (0, 0)


def test_files_of_others_are_refused(tmp_path):
    job = Squares()
    text, foreign, future = (tmp_path / name for name in ("text.db", "foreign.db", "future.db"))
    text.write_text("name,value\n" * 100)
    other = sqlite3.connect(foreign)
    other.execute("CREATE TABLE results (row INTEGER)")
    other.close()
    filled(future, job).close()
    with sqlite3.connect(future) as changed:
        changed.execute("PRAGMA user_version = 3")
    changed.close()
    for path, reason in (
        (text, "is no file of results"),
        (foreign, "is no file of results"),
        (future, "is a file of results of version 3, and this reads 2"),
    ):
        assert reason in refused(path, job)
        with pytest.raises(FileError, match=reason):
            ResultsFile.open(path)
    for path in (tmp_path, tmp_path / "none.db"):
        with pytest.raises(FileError, match="no such file"):
            ResultsFile.open(path)
    absent = tmp_path / "none" / "a.db"
    for path, reason in ((tmp_path, "is no regular file"), (absent, "its folder")):
        with pytest.raises(FileError, match=reason):
            ResultsFile.create(path, job)
    assert not (tmp_path / "none").exists()


def test_a_full_disk_loses_no_chunk_that_was_written(tmp_path):
    """The disk is full for this process: the system lets its files grow to 200 kB."""
    resource = pytest.importorskip("resource")
    job = Squares(rows=20_000, chunk_rows=500)
    path = tmp_path / "a.db"
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    file = ResultsFile.create(path, job)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, hard))
    try:
        with pytest.raises(FileError) as caught:
            for chunk in file.pending():
                file.write_chunk(chunk, job.compute(chunk))
        file.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert "disk is full or fails; the chunks that were written are kept" in str(caught.value)
    with ResultsFile.resume(path, job) as file:
        assert file.computed() == (chunk * 500,) * 2 and chunk > 0
        for rest in file.pending():
            file.write_chunk(rest, job.compute(rest))
        whole = csv_bytes(file, tmp_path / "a.csv")
    with filled(tmp_path / "b.db", job) as other:
        assert csv_bytes(other, tmp_path / "b.csv") == whole


MEMORY = """
import sys
from tests.support.squares import Squares
from balance.studies.runs.export import export_csv, export_parquet
from balance.studies.runs.program_version import program_version
from balance.studies.runs.results_file import ResultsFile
job = Squares(rows=int(sys.argv[1]), chunk_rows=4000)
with ResultsFile.create("many.db", job) as file:
    for chunk in file.pending():
        file.write_chunk(chunk, job.compute(chunk))
    print(export_csv(file, "many.csv"), export_parquet(file, "many.parquet"))
    print(file.read(["number"], order="number", descending=True, limit=1)["number"][0])
with open("/proc/self/status") as status:  # getrusage counts the memory of the parent, too
    print(next(line.split()[1] for line in status if line.startswith("VmHWM")))
"""


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is counted in kB")
def test_memory_does_not_grow_with_the_rows(tmp_path):
    """The limit holds for a million rows, too: 500 MB."""
    pytest.importorskip("pyarrow")
    rows = 1_000_000 if ALL_CASES else 100_000
    root = Path(__file__).parents[4]
    done = subprocess.run(
        [sys.executable, "-c", MEMORY, str(rows)],
        cwd=tmp_path,
        env={"PYTHONPATH": str(root), "PATH": ""},
        capture_output=True,
        text=True,
        check=True,
    )
    *printed, memory = done.stdout.split()
    assert printed == [str(rows), str(rows), str((rows - 1) ** 2)]
    assert int(memory) < 500_000
    lines = hashlib.sha256()
    with open(tmp_path / "many.csv", "rb") as file:
        assert sum(not lines.update(line) for line in file) == rows + 1
