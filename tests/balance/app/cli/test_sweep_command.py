"""The command ``balance sweep``: what it computes, keeps, shows, exports and refuses."""

from __future__ import annotations

import csv
import json
import os
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import balance
from balance.app.answers.html.sweep import sweep_page
from balance.app.answers.html.sweep_plot import is_grid
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import UsageError
from tests.fuzz.random_requests import asked, check, strict, validator
from tests.fuzz.sweep_words import LENGTHS, STUDY
from tests.support.covering import number_of_cases
from tests.support.killed_runs import kill_and_resume, start_held
from tests.support.waiting import HANGS, wait_until_true

pytestmark = pytest.mark.lanes

ROOT = Path(__file__).parents[4]
MANY = """
[model]
file = "four_bar_kite"
[parameters]
"rocker.length" = {uniform = [0.8, 1.2]}
"coupler.length" = {normal = [0.7, 0.01]}
[sampling]
count = 6000
[run]
chunk_rows = 100
"""


def ran(words, code=0):
    """The JSON that a command prints, valid by the schema."""
    done = asked(["sweep", *map(str, words), "--json"])
    assert done.code == code, done.err
    found = strict(done.out)
    validator("sweep").validate(found)
    return found


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A study that was run, in a folder of its own."""
    folder = tmp_path_factory.mktemp("sweep")
    path = folder / "kite.toml"
    path.write_text(STUDY, encoding="utf-8")
    found = ran(["run", path, "--workers", "1"])
    assert (found["file"], found["rows"], found["computed"]) == (str(folder / "kite.db"), 5, 5)
    return path, folder / "kite.db"


@pytest.mark.slow
def test_a_study_is_the_same_from_any_folder(study, monkeypatch):
    monkeypatch.chdir(study[0].parent)
    assert ran(["run", "kite.toml", "--out", "kite.db", "--resume"])["kept"] == 5


def test_a_study_is_computed_once(study):
    path, file = study
    found = ran(["run", path, "--resume"])
    assert (found["computed"], found["kept"], found["covered"]) == (0, 5, 5)
    assert found["reasons"] == [{"reason": "its loops do not close", "count": 1}]
    assert "nothing was left to compute" in asked(["sweep", "run", str(path), "--resume"]).out
    again = asked(["sweep", "run", str(path)])
    assert again.code == 3 and "exists; resume it (--resume)" in again.err
    assert not list(file.parent.glob("kite.db-*"))


def test_the_table_is_that_of_the_linkages(study, tmp_path):
    """The rank of each row is that of the linkage itself, read from a file with its length."""
    found = ran(["show", study[1], "--sort", "rank", "--count", "9"])
    rows = [dict(zip(found["head"], row, strict=True)) for row in found["table"]]
    kite = balance.design_space("four_bar_kite")
    assert rows[0]["rocker.length"] == 1.0 and rows[0]["rank"] == kite.rank == 7
    assert rows[0]["nullity"] == kite.nullity
    assert [row["rank"] for row in rows[1:]] == [8, 8, 8, None]
    assert [row["row"] for row in rows] == [2, 0, 1, 3, 4]
    text = asked(["sweep", "show", str(study[1]), "--sort", "rank", "--descending"]).out
    assert text.splitlines()[-1].startswith("4") and "its loops do not close" in text
    lengths = next(c for c in found["columns"] if c["name"] == "rocker.length")
    assert (lengths["least"], lengths["most"], lengths["unit"]) == (0.8, 3.0, "m")


def test_exports_hold_all_rows(study, tmp_path):
    found = ran(["export", study[1], "--out", tmp_path / "kite.csv"])
    assert found["lines"] == 5
    with open(tmp_path / "kite.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["rocker.length (m)"]) for row in rows] == list(LENGTHS)
    assert [row["rank"] for row in rows] == ["8", "8", "7", "8", ""]
    pyarrow = pytest.importorskip("pyarrow.parquet")
    assert (
        "5 rows"
        in asked(
            ["sweep", "export", str(study[1]), "--out", str(tmp_path / "kite.parquet")]
        ).out
    )
    ranks = pyarrow.read_table(tmp_path / "kite.parquet")["rank"].to_pylist()
    assert ranks == [8, 8, 7, 8, None]


def element(text, name):
    """The data of an element of a page."""
    head = f'<script type="application/json" id="{name}">'
    return json.loads(text.partition(head)[2].partition("</script>")[0])


def test_the_page_draws_linkages_of_their_lengths(study, tmp_path):
    """Distances between the joints of each row are the lengths of its links."""
    page = tmp_path / "kite.html"
    found = ran(["show", study[1], "--html", page, "--sort", "rank"])
    text = page.read_text(encoding="utf-8")
    assert element(text, "report") == found and "http://" not in text.split("<script>")[0]
    sweep, drawing = element(text, "sweep"), element(text, "drawing")
    assert sweep["rows"] == [2, 0, 1, 3] and sweep["order"] == "rank"
    columns = {column["name"]: column["values"] for column in sweep["columns"]}
    assert columns["rocker.length"] == [1.0, 0.8, 0.9, 1.1] and columns["rank"] == [7, 8, 8, 8]
    at = {name: k for k, name in enumerate(drawing["joints"])}
    for length, flat in zip(columns["rocker.length"], drawing["points"], strict=True):
        points = np.reshape(flat, (-1, 2))

        def apart(one, other, points=points):
            return np.linalg.norm(points[at[one]] - points[at[other]])

        expected = {
            ("u1", "q2"): 0.45**0.5,
            ("q2", "q3"): 0.45**0.5,
            ("q4", "q3"): length,
            ("u1", "q4"): 1.0,
        }
        for (one, other), known in expected.items():
            assert apart(one, other) == pytest.approx(known, abs=1e-5)
    ground, *moving = [{drawing["joints"][j] for j in part} for part in drawing["parts"]]
    assert ground == {"u1", "q4"}
    assert {"u1", "q2"} in moving and {"q2", "q3"} in moving and {"q4", "q3"} in moving


@pytest.mark.slow
def test_pictures_are_maps_or_points(study, tmp_path):
    for axes in ("rocker.length,rank", "rocker.length,rank,kmax"):
        for name in ("a.svg", "a.png"):
            ran(["show", study[1], "--plot", axes, "--out", tmp_path / name])
            assert (tmp_path / name).stat().st_size > 3000
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0))
    x, y = x.ravel(), y.ravel()
    assert is_grid(x, y) and is_grid(x[3:], y[3:]) and is_grid(np.tile(x, 2), np.tile(y, 2))
    rng = np.random.default_rng(0)
    assert not is_grid(rng.random(50), rng.random(50)) and not is_grid(x, 0.0 * y)


REFUSALS = [
    (["run", "none.toml"], 3, "no such file"),
    (["run", "kite.toml", "--workers", "1025"], 2, "from 0 to 1024"),
    (["run", "kite.toml", "--workers", "2", "--dask", "tcp://x:1"], 2, "a cluster has its own"),
    (["run", "kite.toml", "--out", "kite.toml"], 2, "would replace a file that is read"),
    (["run", "kite.toml", "--out", "no/a.db"], 3, "its folder does not exist"),
    (["run", "kite.toml", "--out", "text.db"], 3, "exists"),
    (["run", "kite.toml", "--out", "text.db", "--resume"], 3, "is no file of results"),
    (["run", "other.toml", "--out", "kite.db", "--resume"], 3, "another study or model"),
    (["run", "huge.toml", "--out", "huge.db"], 2, "--yes"),
    (["run", "still.toml", "--out", "still.db"], 3, "moves nothing"),
    (["run", "nan.toml", "--out", "nan.db"], 3, "nan"),
    (["run", "ghost.toml", "--out", "ghost.db"], 3, "ghost"),
    (["show", "none.db"], 3, "no such file"),
    (["show", "text.db"], 3, "is no file of results"),
    (["show", "kite.db", "--sort", "ghost"], 2, "no column 'ghost'; the columns are rocker"),
    (["show", "kite.db", "--descending"], 2, "--descending needs --sort"),
    (["show", "kite.db", "--plot", "rank,kmax"], 2, "need each other"),
    (["show", "kite.db", "--out", "a.svg"], 2, "need each other"),
    (["show", "kite.db", "--plot", "rank", "--out", "a.svg"], 2, "is not X,Y or X,Y,COLOUR"),
    (["show", "kite.db", "--plot", "rank,ghost", "--out", "a.svg"], 2, "no column 'ghost'"),
    (["show", "kite.db", "--plot", "rank,reason", "--out", "a.svg"], 2, "holds texts"),
    (["show", "kite.db", "--count", "0"], 2, "from 1 to"),
    (["show", "kite.db", "--html", "a.txt"], 2, "neither in .html nor in .htm"),
    (["export", "kite.db", "--out", "a.xls"], 2, "ends in none of .csv, .xlsx, .parquet"),
    (["export", "kite.db", "--out", "a.urdf"], 2, "--row N and --out FILE.urdf need each"),
    (["export", "kite.db", "--out", "a.csv", "--row", "1"], 2, "one row is one linkage"),
    (
        ["export", "kite.db", "--out", "a.urdf", "--row", "5"],
        2,
        "no row 5: give one from 0 to 4",
    ),
    (["export", "kite.db", "--out", "no/a.csv"], 3, "cannot be written"),
    (["export", "none.db", "--out", "a.csv"], 3, "no such file"),
]


@pytest.mark.table
@pytest.mark.parametrize(("words", "code", "reason"), REFUSALS, ids=lambda x: str(x)[-40:])
def test_refusals_are_one_line_and_write_nothing(study, monkeypatch, words, code, reason):
    folder = study[0].parent
    monkeypatch.chdir(folder)
    for name, ranges in {
        "other": "[0.8]",
        "huge": "{uniform = [0.8, 1.2]}",
        "still": "[1.0, 2.0]",
        "nan": "[nan]",
        "ghost": "[1.0]",
    }.items():
        path = {"still": "u1.axis.z", "ghost": "ghost.length"}.get(name, "rocker.length")
        text = f'[model]\nfile = "four_bar_kite"\n[parameters]\n"{path}" = {ranges}\n'
        text += "[sampling]\ncount = 1_000_000_000_000\n" * (name == "huge")
        Path(f"{name}.toml").write_text(text, encoding="utf-8")
    Path("text.db").write_text("row,rank\n" * 99, encoding="utf-8")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    done = asked(["sweep", *words, "--json"])
    assert check(["sweep", *words, "--json"], done) == f"sweep: {code}"
    assert reason in done.err
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_page_needs_a_sweep_with_answers(study, tmp_path):
    with ResultsFile.open(study[1]) as file:
        file.about["kind"] = "squares"
        with pytest.raises(UsageError, match="no sweep"):
            sweep_page(file)


@pytest.mark.slow
def test_an_interrupt_says_what_is_kept(study, tmp_path, monkeypatch):
    """As by Ctrl-C on a terminal: exit code 130, one line, nothing on standard output."""

    def interrupted(job, file, **_):
        file.write_chunk(0, job.compute(0))
        raise KeyboardInterrupt

    monkeypatch.setattr("balance.studies.runs.chunk_runs.run_chunks", interrupted)
    file = tmp_path / "a.db"
    code, out, err = asked(["sweep", "run", str(study[0]), "--out", str(file)])
    assert (code, out) == (130, "")
    assert err == f"{file} keeps 2 of 5 geometries; --resume goes on from there\n"
    monkeypatch.undo()
    resumed = ran(["run", study[0], "--out", file, "--resume", "--workers", "0"])
    assert resumed["kept"] == 2


def covered(path):
    """The rows that the file of a run in another process covers."""
    try:
        with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as connection:
            found = connection.execute("SELECT TOTAL(rows) FROM chunks").fetchone()[0]
        connection.close()
        return int(found)
    except sqlite3.OperationalError:
        return 0


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="SIGKILL")
def test_a_killed_study_resumes_to_the_same_bytes(tmp_path):
    """The command itself, with two workers, beside one process that nobody kills.

    Before both, one run compiles the kernels: results of the process that compiles them may
    differ in their last bits from those of processes that load them.
    """
    path, file = tmp_path / "many.toml", tmp_path / "killed.db"
    path.write_text(MANY, encoding="utf-8")
    words = ["sweep", "run", str(path), "--workers"]
    environment = {"PYTHONPATH": str(ROOT), "BALANCE_COMPILE": "now"}
    first, whole = tmp_path / "first.db", tmp_path / "whole.db"
    for out in (first, whole):
        subprocess.run(
            [sys.executable, "-m", "balance", *words, "1", "--out", str(out)],
            check=True,
            env=os.environ | environment,
            capture_output=True,
        )
    rows = kill_and_resume(
        "tests.support.held_runs",
        [*words, "2", "--resume", "--out", str(file)],
        lambda: covered(file),
        6000,
        number_of_cases(1, 10),
        26,
        environment,
    )
    assert 0 < rows[-1] < 6000
    ran(["export", file, "--out", tmp_path / "killed.csv"])
    ran(["export", whole, "--out", tmp_path / "whole.csv"])
    text = (tmp_path / "killed.csv").read_bytes()
    assert text == (tmp_path / "whole.csv").read_bytes() and text.count(b"\n") == 6001


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="SIGKILL")
def test_a_cluster_that_is_lost_is_told_in_one_line(tmp_path):
    """Its library prints nothing beside it; the rows are kept, and another run goes on."""
    pytest.importorskip("distributed")
    path, file = tmp_path / "many.toml", tmp_path / "many.db"
    path.write_text(MANY.replace("6000", "600"), encoding="utf-8")
    environment = {"PYTHONPATH": str(ROOT), "BALANCE_COMPILE": "never"}
    cluster = subprocess.Popen(
        [sys.executable, "-m", "tests.support.dask_cluster"],
        env=os.environ | environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    words = ["sweep", "run", str(path), "--dask", cluster.stdout.readline().strip()]
    run = start_held(200, "tests.support.held_runs", words, environment)
    wait_until_true(lambda: covered(file) >= 200 or run.poll() is not None)
    cluster.kill()
    cluster.communicate()
    _, errors = run.communicate(timeout=HANGS)
    assert run.returncode == 3
    assert errors.startswith(f"balance: the cluster {words[-1]} is lost (")
    assert errors.endswith(
        f"{file} keeps {covered(file)} of 600 geometries; --resume goes on from there\n"
    )
    assert errors.count("\n") == 1 and 200 <= covered(file) < 600
    resumed = ran(["run", path, "--out", file, "--resume", "--workers", "1"])
    assert resumed["kept"] >= 200 and resumed["covered"] == 600
