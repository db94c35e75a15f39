"""``balance sweep run MODEL --vary …``: the study of its options, the best row, refusals."""

from __future__ import annotations

import csv
import json
import re
import shlex
import tomllib

import numpy as np
import pytest

import balance
from balance.app.answers.text.sweep import show_data
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.motion.verification.verify_motions import PinocchioModel
from balance.studies.runs.best_row import best_row
from balance.studies.runs.chunk_job import Column
from balance.studies.runs.results_file import ResultsFile
from balance.studies.sweeps.job import SweepJob
from balance.studies.sweeps.study_text import study_text
from kinematics.errors import UsageError
from tests.fuzz.random_requests import asked, strict, validator

pytestmark = pytest.mark.lanes

STUDY = """
[model]
file = "four_bar_general"
[parameters]
"coupler.length" = "0.8:1.2:3"
"crank.mass" = ["400g", "600g"]
[compute]
quantities = ["counterweights", "input_inertia", "shaking", "shaking after counterweights"]
balance = "force"
[compute.counterweights]
links = ["crank", "rocker"]
density = "none"
[compute.shaking]
speed = "300rpm"
"""
OPTIONS = (
    *(
        "four_bar_general",
        "--vary",
        "coupler.length=0.8:1.2:3",
        "--vary",
        "crank.mass=400g,600g",
    ),
    *("--counterweights", "crank,rocker", "--balance", "force", "--speed", "300rpm"),
    *("--set", "compute.counterweights.density=none", "--compute", "input_inertia"),
)
BESIDE = ("--workers", "0")


def ran(words, code=0):
    """What ``sweep run`` prints as JSON, valid by the schema."""
    done = asked(["sweep", "run", *map(str, words), *BESIDE, "--json"])
    assert done.code == code, done.err
    answer = strict(done.out)
    validator("sweep").validate(answer)
    return answer


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder in which commands run."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_options_are_the_study_of_a_file(folder):
    """All rows are the same, byte for byte; so are those of the study that is written."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    ran(["study.toml", "--table", "file.csv"])
    (folder / "sub").mkdir()
    ran([*OPTIONS, "--table", "options.csv", "--write-study", "sub/again.toml"])
    ran(["sub/again.toml", "--table", "again.csv"])
    text = (folder / "file.csv").read_bytes()
    assert text.count(b"\n") == 7 and text.startswith(b"row,coupler.length (m),crank.mass (kg)")
    assert text == (folder / "options.csv").read_bytes() == (folder / "again.csv").read_bytes()


@pytest.mark.slow
def test_the_range_that_help_shows_has_units(folder):
    """Its rows are those of the same range in metres."""
    shown = re.search(r"coupler\.length=\d+mm:\d+mm:10", asked(["sweep", "run", "--help"]).out)
    for name, words in (("shown", shown[0]), ("metres", "coupler.length=0.8:1.2:10")):
        ran(["four_bar_general", "--vary", words, "--table", f"{name}.csv"])
    assert (folder / "shown.csv").read_bytes() == (folder / "metres.csv").read_bytes()


@pytest.mark.slow
def test_the_best_row_is_a_file_that_shakes_so(folder):
    """By Pinocchio, its moment has the peak of its column, the least of the table."""
    answer = ran([*OPTIONS, "--table", "rows.csv", "--best", "peak_moment_after=best.urdf"])
    with open("rows.csv", encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    peaks = [float(row["peak_moment_after (N m)"]) for row in rows]
    best = answer["best"]
    # The crank's mass changes nothing: of rows that differ by round-off, the first is best.
    first = next(row for row, peak in enumerate(peaks) if peak <= min(peaks) * (1.0 + 1e-9))
    assert best["row"] == first and best["value"] == pytest.approx(peaks[first], rel=1e-9)
    assert answer["table"][0][0] == best["row"] and best["added"] == "counterweights"
    linkage = balance.load("best.urdf")
    way, _ = revolve_crank(linkage, 10.0 * np.pi, steps=720)
    wrench = PinocchioModel(linkage, mass_parameters(linkage)).reactions(way)
    moment, force = (np.linalg.norm(w, axis=1).max() for w in (wrench[:, :3], wrench[:, 3:]))
    assert moment == pytest.approx(best["value"], rel=1e-4)
    assert force < 1e-9 * float(rows[0]["peak_force (N)"])


@pytest.mark.slow
def test_what_is_zero_everywhere_is_equal_in_all_rows(folder):
    words = ["sweep", "run", *OPTIONS, "--best", "rms_force_after=best.urdf", *BESIDE]
    done = asked(words)
    assert done.code == 0 and (folder / "best.urdf").is_file()
    assert "row 0, least rms_force_after 0, as all rows: best.urdf, with" in done.out
    assert "in all rows  closed 1, counterweights feasible" in done.out
    head, units = done.out.partition("\nrow ")[2].splitlines()[:2]
    assert "rms_moment_after" in head and "peak_force_after" not in head
    assert units.split()[:2] == ["m", "kg"]
    # The same request again, for another column, computes nothing.
    again = ran([*OPTIONS, "--best", "max:added_mass=best.urdf"])
    assert (again["computed"], again["kept"]) == (0, 6) and again["best"]["largest"]
    added = again["head"].index("added_mass")
    assert again["best"]["value"] == max(row[added] for row in again["table"])


@pytest.mark.slow
def test_reduce_moves_as_shaking_does(folder):
    """The share of the objective that it leaves is that of the root mean squares of both."""
    words = ["four_bar_general", "--vary", "coupler.length=0.9", "--balance", "force"]
    words += ["--speed", "300rpm", "--reduce", "crank,rocker", "--budget", "500g"]
    answer = ran([*words, "--best", "rms_force_reduced=best.urdf"])
    row = dict(zip(answer["head"], answer["table"][0], strict=True))
    share = row["rms_force_reduced"] / row["rms_force"]
    assert share == pytest.approx(row["share_left"], rel=1e-4) and share < 0.9
    force = balance.verify("best.urdf", speed="300rpm").force
    assert force == pytest.approx(row["peak_force_reduced"], rel=1e-3)


@pytest.mark.slow
def test_the_file_of_a_design_has_its_masses(folder):
    words = ["four_bar_kite", "--vary", "crank.length=0.45,0.5", "--vary", "coupler.length=0.5"]
    words += ["--compute", "design", "--set", "compute.design.minimise=mass"]
    best = ran([*words, "--best", "least_mass=best.urdf"])["best"]
    assert (best["row"], best["added"]) == (1, "design")
    linkage = balance.load("best.urdf")
    assert balance.verify("best.urdf").balanced
    total = sum(body.inertia[0] for body in linkage.bodies)
    assert total == pytest.approx(best["value"], rel=1e-9)
    export = ["sweep", "export", "four_bar_kite.db", "--row"]
    done = asked([*export, "1", "--out", "row.urdf"])
    assert "row 1 with the masses of its design" in done.out
    assert (folder / "row.urdf").read_bytes() == (folder / "best.urdf").read_bytes()
    assert "row 0 with the masses given alone" in asked([*export, "0", "--out", "a.urdf"]).out


def test_geometries_that_do_not_close(folder):
    done = asked(["sweep", "run", "four_bar_kite", "--vary", "coupler.length=7:9:3", *BESIDE])
    assert done.code == 1 and done.err == ""
    about = (
        "No geometry closes its loops. Vary about the values of the file, coupler.length=0.67"
    )
    assert done.out.startswith(about)
    assert "sweep show" not in done.out and (folder / "four_bar_kite.db").is_file()
    best = ["--best", "max:coupler.length=best.urdf"]
    some = ran(["four_bar_kite", "--vary", "coupler.length=1:9:5", *best])
    closed = [row[1] for row in some["table"] if row[2]]
    assert some["best"]["value"] == max(closed) < 9.0 and (folder / "best.urdf").is_file()
    # Another request has a file of its own.
    assert some["file"] == "four_bar_kite-2.db"
    done = asked(["sweep", "run", "four_bar_kite", "--vary", "coupler.length=1:9:3", *BESIDE])
    assert "four_bar_kite.db has another request, and stays" in done.err
    assert "in four_bar_kite-3.db" in done.err


def test_no_counterweights_say_what_helps(folder):
    """The forces alone are proposed where the row has masses for them: not by the crank."""
    words = ["four_bar_general", "--vary", "coupler.length=0.9", "--counterweights"]
    crank = asked(["sweep", "run", *words, "crank", *BESIDE])
    assert crank.code == 1 and "--balance force" not in crank.out
    assert "balance sweep run" not in crank.out  # the file has no answer either
    both = asked(["sweep", "run", *words, "crank,rocker", "--balance", "dynamic", *BESIDE])
    assert both.code == 1 and both.out.startswith("No row has all answers: counterweights: ")
    assert "--balance force asks for the shaking force alone: row 0 has an answer" in both.out
    command = shlex.split(re.search("Next: balance (sweep run .*)", both.out)[1])
    assert asked(command).code == 0 and "dynamic" not in command


SOME_CLOSE = ("four_bar_general", "--vary", "coupler.length=0.01:1.2:3")


@pytest.mark.slow
@pytest.mark.parametrize("held", ["", "rocker", "all"])
def test_regions_follow_lengths_unless_they_are_held(folder, held):
    """Point masses lie on the rim of the region; their moment is affine in the length.

    The rocker carries a share of the coupler at its end, and its own mass stays.
    """
    words = ["four_bar_general", "--vary", "rocker.length=0.6:0.9:3", "--balance", "force"]
    words += [
        "--counterweights",
        "crank,rocker",
        "--set",
        "compute.counterweights.density=none",
    ]
    linkage = balance.load("four_bar_general")
    points = {joint.name: joint.point for joint in linkage.joints}
    length = float(np.linalg.norm(points["q4"] - points["q3"]))
    answer = ran([*words, *["--region", f"{held}=364mm"] * bool(held)])
    rows = [dict(zip(answer["head"], row, strict=True)) for row in answer["table"]]
    place = np.array([[row[f"rocker.added.{axis}"] for axis in "xyz"] for row in rows])
    mass = np.array([row["rocker.added.mass"] for row in rows])
    radius = [0.364] * 3 if held else [0.3, 0.375, 0.45]
    assert np.linalg.norm(place, axis=1) == pytest.approx(radius, rel=1e-6)
    moment = mass[:, None] * place
    bend = np.linalg.norm(moment[0] - 2.0 * moment[1] + moment[2])
    assert bend < 1e-6 * np.linalg.norm(moment[2])
    assert (mass[2] > mass[0]) == bool(held)
    total = [row["crank.added.mass"] + row["rocker.added.mass"] for row in rows]
    assert total == pytest.approx([row["added_mass"] for row in rows], rel=1e-12)
    assert answer["in_model"] == [
        {"name": "rocker.length", "value": pytest.approx(length, rel=1e-12)}
    ]
    region = {"quantity": "counterweights", "link": "rocker", "text": "364mm"}
    assert answer["following_regions"] == ([] if held else [region])


def test_what_the_model_has_and_where_weights_may_be(folder):
    words = ["four_bar_general", "--vary", "rocker.length=0.6,0.7", "--speed", "300rpm"]
    words += ["--counterweights", "crank,rocker", "--balance", "force"]
    done = asked(["sweep", "run", *words, *BESIDE])
    assert re.search(r"in the file  rocker\.length 0\.728\d* m, outside the range", done.out)
    assert "to hold that of the file: --region rocker=364mm" in done.out
    assert "; --reduce L1,L2 --budget KG leaves some, for less mass" in done.out
    assert "columns crank.added.mass, crank.added.x … in --table" in done.out
    assert "crank.added" not in done.out.partition("\nrow ")[2]


def test_a_range_without_an_answer_is_told_where_the_file_is(folder):
    """No crank of these lengths turns fully; those of the next command do, with its masses."""
    words = ["four_bar_general", "--vary", "crank.length=0.8:0.9:3", "--speed", "300rpm"]
    words += ["--vary", "crank.mass=400g,600g", "--table", "rows.csv", *BESIDE]
    done = asked(["sweep", "run", *words])
    assert done.code == 1
    about = "cannot turn fully. Vary about the values of the file, crank.length=0.316228: "
    assert f"{about}the ends of crank.length=0.285:0.348:3 have answers." in done.out
    assert "written: rows.csv\nno row of rows.csv has all answers: its column" in done.err
    with open("rows.csv", encoding="utf-8") as text:
        reasons = [row["reason"] for row in csv.DictReader(text)]
    assert reasons == ["shaking: the crank u1 cannot turn fully"] * 6
    command = shlex.split(re.search("Next: balance (sweep run .*)", done.out)[1])
    assert "crank.mass=400g,600g" in command
    inside = strict(asked([*command, "--json"]).out)
    assert inside["answered"] == inside["rows"] == 6


def test_one_value_without_an_answer_is_replaced_by_that_of_the_file(folder):
    words = ["four_bar_general", "--vary", "coupler.length=7", "--write-study", "s.toml"]
    done = asked(["sweep", "run", *words, *BESIDE])
    assert "of the file, coupler.length=0.894427: they have answers." in done.out
    assert "--vary coupler.length=0.894427\n" in done.out
    assert "they have answers" in asked(["sweep", "run", "s.toml", *BESIDE]).out


def test_commands_that_lead_on_can_be_run(folder):
    """The first row has no linkage, the second no shaking, and the speed has a blank."""
    done = asked(["sweep", "run", *SOME_CLOSE, "--speed", "u1=300 rpm", *BESIDE])
    command = re.search("Next: balance (sweep export .*)", done.out)[1]
    assert command == "sweep export four_bar_general.db --row 2 --out row.urdf"
    assert asked(shlex.split(command)).code == 0 and (folder / "row.urdf").is_file()
    best = ["--speed", "u1=300 rpm", "--best", "rms_moment=v=1.urdf"]
    done = asked(["sweep", "run", *SOME_CLOSE, *best, *BESIDE])
    command = re.search("Next: balance (verify .*)", done.out)[1]
    assert command == "verify v=1.urdf --speed 'u1=300 rpm' --about 0,0,0"
    assert asked(shlex.split(command)).code == 1 and (folder / "v=1.urdf").is_file()


@pytest.mark.parametrize(
    ("lengths", "column", "text"),
    [
        ("0.01:1.2:3", "rms_moment", ": b.urdf"),
        ("0.01,0.9,1.0", "rank", ", as all rows that have one: b.urdf"),
        ("0.9,1.0", "rank", ", as all rows: b.urdf"),
        ("0.9,1.0", "rms_moment", ": b.urdf"),
        (
            "0.8:1.2:5",
            "rms_moment",
            ", at the end of the range of coupler.length: there may be better ones beyond: ",
        ),
    ],
)
def test_the_best_of_equal_rows(folder, lengths, column, text):
    """One row alone with a value is like no other."""
    words = ["four_bar_general", "--vary", f"coupler.length={lengths}", "--speed", "300rpm"]
    best = ["--compute", "rank", "--best", f"{column}=b.urdf"]
    done = asked(["sweep", "run", *words, *best, *BESIDE])
    assert re.search(rf"least {column} [\d.]+{text}", done.out), done.out


def test_masses_that_follow_lengths_are_asked_for_where_they_can_be(folder):
    """By an option of a model, and by an entry of a study, which refuses that option."""
    words = ["--counterweights", "crank,rocker", "--write-study", "study.toml"]
    done = asked(["sweep", "run", *SOME_CLOSE, *words, *BESIDE])
    assert "length; --vary coupler.mass_per_length=KG_PER_M makes a bar" in done.out
    assert ". --balance force asks for" in done.out
    done = asked(["sweep", "run", "study.toml", *BESIDE])
    assert "; the entry coupler.mass_per_length (kg/m) of [parameters] makes" in done.out
    assert '. balance = "force" of [compute] asks for' in done.out


def test_a_table_that_cannot_be_written_leaves_the_other_files(folder):
    (folder / "t.csv").mkdir()
    words = ["--best", "max:coupler.length=b.urdf", "--write-study", "s.toml"]
    done = asked(["sweep", "run", *SOME_CLOSE, *words, "--table", "t.csv", *BESIDE])
    assert (done.code, done.out) == (3, "") and "t.csv: cannot be written" in done.err
    assert (folder / "b.urdf").is_file() and (folder / "s.toml").is_file()


KITE = "four_bar_kite --vary coupler.length=0.6:0.7:2"
REFUSALS = [
    ("four_bar_kite", 2, "nothing varies: give --vary, such as coupler.length="),
    ("ghost --vary a.length=1:2:3", 3, "no such file, and no model of this name"),
    ("four_bar_kite --vary couplr.length=1:2:3", 3, "--vary couplr.length: .* mean 'coupler'"),
    ("four_bar_kite --vary coupler.size=1:2:3", 3, "link 'coupler' has the numbers length"),
    ("four_bar_kite --vary coupler.length=1:2", 3, "--vary coupler.length: .*first:last:count"),
    (f"{KITE} --vary coupler.length=1", 2, "--vary coupler.length is given twice"),
    (f"{KITE} --best rnk=a.urdf", 2, "--best rnk: .*did you mean 'rank'"),
    (f"{KITE} --best reason=a.urdf", 2, "--best reason: no column of numbers"),
    (f"{KITE} --best rank", 2, "'rank' is not COLUMN=FILE.urdf"),
    (f"{KITE} --best rank=a.urdf --write-study a.urdf", 2, "both --best and --write-study"),
    (f"{KITE} --counterweights rockr", 3, "--counterweights: link 'rockr': .* mean 'rocker'"),
    (f"{KITE} --compute counterweights", 2, "it needs --counterweights crank,rocker"),
    (f"{KITE} --compute shaking", 2, "it needs --speed 300rpm"),
    (f"{KITE} --compute shakng", 3, "--compute shakng: .* mean 'shaking'"),
    (
        f"{KITE} --counterweights crank --region rocker=ball(0,0,0,1)",
        2,
        "--region rocker: noth",
    ),
    ("study.toml --region crank=ball(0,0,0,1)", 2, "--region goes with a model"),
    (f"{KITE} --reduce crank", 2, "--reduce L1,L2 and --budget KG need each other"),
    (f"{KITE} --set grashof=crank", 2, "is not TABLE.KEY=VALUE"),
    (f"{KITE} --set constraint.grashof=crank", 3, "no such table .did you mean 'constraints'"),
    (
        f"{KITE} --set compute.quantities.x=1",
        2,
        "--set compute.quantities.x: compute.quantities is a list, and has no entries",
    ),
    (
        f"{KITE} --balance force --set compute.balance.x=1",
        2,
        "--set compute.balance.x: compute.balance is a single value, and has no entries",
    ),
    (
        f"{KITE} --compute design --set compute.design=5 --set compute.design.minimise=mass",
        2,
        "--set compute.design: .* set one of them, --set compute.design.OPTION=VALUE",
    ),
    (
        f"{KITE} --reduce crank --budget 1kg --set compute.reduce=3",
        2,
        "--set compute.reduce: it is a table of options",
    ),
    (
        f"{KITE} --counterweights crank --set compute.counterweights.minimise=5",
        3,
        "--set compute.counterweights.minimise: '5' has no meaning",
    ),
    (f"{KITE} --set compute.balance=weak", 3, "--set compute.balance: is 'weak'"),
    (f"{KITE} --set compute.shakng.speed=3", 3, "--set compute.shakng: no such entry"),
    (f"{KITE} --speed x=300rpm", 3, "--speed: input x: not an input"),
    (f"{KITE} --best rank=v/1.urdf", 3, "v/1.urdf: --best: its folder does not exist"),
    (f"{KITE} --table v/1.csv", 3, "v/1.csv: --table: its folder does not exist"),
    (f"{KITE} --write-study v/1.toml", 3, "--write-study: its folder does not exist"),
    (f"{KITE} --at u1=20mm", 3, "its position is an angle"),
    ("study.toml --speed 300rpm", 2, "--speed goes with a model: study.toml has its own"),
    ("study.toml --at u1=0.1", 2, "--at goes with a model"),
    ("study.toml --write-study study.toml", 2, "would replace a file that is read"),
    ("study.toml --write-study a.toml", 2, "--write-study goes with a model"),
]


@pytest.mark.table
@pytest.mark.parametrize(("words", "code", "reason"), REFUSALS)
def test_refusals_write_nothing(folder, words, code, reason):
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    done = asked(["sweep", "run", *words.split(), *BESIDE])
    assert (done.code, done.out) == (code, "")
    assert re.search(reason, done.err), done.err
    assert [path.name for path in folder.iterdir()] == ["study.toml"]


def test_a_column_of_one_value_is_no_order(folder):
    ran([*KITE.split(), "--out", "kite.db"])
    done = asked(["sweep", "show", "kite.db", "--sort", "closed"])
    assert done.code == 0 and "--sort closed: 1 in all rows; those that vary are" in done.err
    done = asked(["sweep", "show", "kite.db", "--sort", "coupler.length"])
    assert done.code == 0 and done.err == ""


def test_studies_are_written_as_they_are_read(folder):
    tables = {
        "model": {"file": 'a "b".urdf', "at": {"u1": 0.1}, "massless": ["ä", "\x7f"]},
        "parameters": {"q2.origin.x": "1:2:3", "n": {"uniform": [1e-5, 2]}, "m": [1.5, "2g"]},
        "compute": {"quantities": ["a after b"], "spatial": True, "a after b": {"speed": 3.0}},
    }
    text = study_text(tables)
    assert tomllib.loads(text) == tables
    assert '[compute."a after b"]' in text


@pytest.mark.parametrize(
    ("values", "closed", "largest", "row"),
    [
        ([3.0, 1.0, 1.0 + 1e-12, 2.0], [1, 1, 1, 1], False, 1),
        ([3.0, 1.0 + 1e-12, 1.0, 2.0], [1, 1, 1, 1], False, 1),
        ([3.0, 1.0, 1.0 + 1e-6, 2.0], [1, 0, 1, 1], False, 2),
        ([3.0, 1.0, np.nan, 4.0], [1, 1, 1, 2], True, 3),
        ([np.nan, np.nan], [1, 1], False, None),
        ([2.0, 2.0], [0, 1], False, 1),
    ],
)
def test_the_best_row(values, closed, largest, row):
    """The first of those that are equally good, of rows whose loops close."""
    columns = Column("x", "real"), Column("closed", "integer")
    job = SweepJob("d", json.dumps({}), columns, len(values), len(values))
    given = {"x": np.array(values), "closed": np.array(closed)}
    with ResultsFile.in_memory("rows", job, given) as file:
        assert best_row(file, "x", largest).row == row


@pytest.mark.parametrize("name", ["reason", "y"])
def test_a_column_without_numbers_has_no_best_row(name):
    columns = Column("x", "real"), Column("closed", "integer"), Column("reason", "text")
    job = SweepJob("d", json.dumps({}), columns, 1, 1)
    given = {"x": np.ones(1), "closed": np.ones(1, dtype=int), "reason": [""]}
    with (
        ResultsFile.in_memory("rows", job, given) as file,
        pytest.raises(UsageError, match=f"rows: .*column '{name}'"),
    ):
        best_row(file, name, False)


def test_round_off_is_no_order_and_has_no_best_row():
    columns = Column("x", "real"), Column("y", "real"), Column("closed", "integer")
    job = SweepJob("d", json.dumps({}), columns, 2, 2)
    given = {"x": np.ones(2), "y": np.array([1e-14, 2e-14]), "closed": np.ones(2, dtype=int)}
    with ResultsFile.in_memory("rows", job, given) as file:
        best = best_row(file, "y", False)
        assert best.row is None and "zero up to round-off in all rows" in best.why_none
        with pytest.raises(UsageError, match="--sort y: it is round-off in all rows"):
            show_data(file, "y", False, 2)
