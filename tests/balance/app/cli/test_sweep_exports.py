"""What ``balance sweep export`` writes: a workbook, and one row as a linkage."""

from __future__ import annotations

import csv

import numpy as np
import pytest

import balance
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.motion.verification.verify_motions import PinocchioModel
from kinematics.errors import UsageError
from tests.support.command_runs import asked

pytestmark = [pytest.mark.lanes, pytest.mark.slow]

STUDY = """
[model]
file = "four_bar_general"
[parameters]
"coupler.length" = "900mm:1100mm:2"
"coupler.mass" = "500g:1500g:2"
[compute]
quantities = ["counterweights", "shaking", "shaking after counterweights"]
balance = "force"
[compute.counterweights]
links = ["crank", "rocker"]
density = "none"
[compute.shaking]
speed = "300rpm"
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The file of a study of a length and a mass."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    done = asked(["sweep", "run", str(folder / "study.toml"), "--workers", "1"])
    assert done.code == 0, done.err
    return folder / "study.db"


def _exported(results, *words):
    done = asked(["sweep", "export", str(results), *map(str, words)])
    assert done.code == 0, done.err
    return words[1]


def test_a_row_is_the_linkage_that_was_computed(results):
    """The file of a row shakes with the force of its column along the turn of its crank."""
    with open(
        _exported(results, "--out", results.with_suffix(".csv")), encoding="utf-8"
    ) as text:
        rows = list(csv.DictReader(text))
    table = balance.studies.read_study(results.with_suffix(".toml")).run(workers=0)
    for number in (1, 2):
        path = results.parent / f"{number}.urdf"
        path.write_text(table.linkage(number).to_urdf(), encoding="utf-8")
        linkage = balance.load(str(path))
        masses = {body.name: body.inertia[0] for body in linkage.bodies}
        assert masses["coupler"] == pytest.approx(float(rows[number]["coupler.mass (kg)"]))
        places = {joint.name: joint.point for joint in linkage.joints}
        length = np.linalg.norm(places["q2"] - places["q3"])
        assert length == pytest.approx(float(rows[number]["coupler.length (m)"]))
        check = balance.verify(str(path), speed="300rpm")
        assert check.force == pytest.approx(float(rows[number]["peak_force (N)"]), rel=1e-3)


def test_the_file_of_a_row_has_its_counterweights(results):
    """By Pinocchio, the force vanishes, and the moment has the peak of the column."""
    table = balance.studies.read_study(results.with_suffix(".toml")).run(workers=0)
    for number in (0, 3):
        path = results.parent / f"{number}_balanced.urdf"
        words = ["--row", str(number), "--out", str(path)]
        done = asked(["sweep", "export", str(results), *words])
        assert (
            f"row {number} with the masses given and the matter of counterweights" in done.out
        )
        assert table.linkage(number, "counterweights").to_urdf() == path.read_text("utf-8")
        written, given = balance.load(str(path)), table.linkage(number)
        added = [sum(body.inertia[0] for body in x.bodies) for x in (written, given)]
        assert added[0] - added[1] == pytest.approx(table["added_mass"][number], rel=1e-9)
        way, _ = revolve_crank(written, 10.0 * np.pi, steps=720)
        wrench = PinocchioModel(written, mass_parameters(written)).reactions(way)
        moment, force = (
            np.linalg.norm(part, axis=1).max() for part in (wrench[:, :3], wrench[:, 3:])
        )
        assert moment == pytest.approx(table["peak_moment_after"][number], rel=1e-4)
        assert force < 1e-9 * table["peak_force"][number]


def test_the_weights_of_a_row_are_in_the_table(results):
    """Their mass and first moment are what the file gains over that without them."""
    table = balance.studies.read_study(results.with_suffix(".toml")).run(workers=0)
    linkages = []
    for added in ("none", "counterweights"):
        path = results.parent / f"{added}.urdf"
        words = ["--row", "3", "--added", added, "--out", str(path)]
        assert asked(["sweep", "export", str(results), *words]).code == 0
        linkages.append(balance.load(str(path)))
    for before, after in zip(*(linkage.bodies for linkage in linkages), strict=True):
        gained = after.inertia - before.inertia
        if before.name == "coupler":
            assert not gained.any()
            continue
        mass, *com = (table[f"{before.name}.added.{k}"][3] for k in ("mass", "x", "y", "z"))
        assert gained[0] == pytest.approx(mass, rel=1e-9)
        place = before.frame[:3, :3] @ com + before.frame[:3, 3]
        assert gained[1:4] == pytest.approx(mass * place, rel=1e-9, abs=1e-12)


def test_a_row_without_counterweights_is_written_as_given(tmp_path):
    study = STUDY.replace('"crank", "rocker"]', '"coupler"]')
    (tmp_path / "study.toml").write_text(study, encoding="utf-8")
    assert asked(["sweep", "run", str(tmp_path / "study.toml"), "--workers", "1"]).code == 1
    path = tmp_path / "0.urdf"
    words = [str(tmp_path / "study.db"), "--row", "0", "--out", str(path)]
    assert "row 0 with the masses given alone" in asked(["sweep", "export", *words]).out
    table = balance.studies.read_study(tmp_path / "study.toml").run(workers=0)
    assert path.read_text("utf-8") == table.linkage(0).to_urdf()
    with pytest.raises(UsageError, match="row 0: no masses of counterweights: infeasible"):
        table.linkage(0, "counterweights")
    with pytest.raises(UsageError, match="added='reduce'"):
        table.linkage(0, "reduce")


def test_a_workbook_has_the_table(results):
    openpyxl = pytest.importorskip("openpyxl")
    sheet = openpyxl.load_workbook(
        _exported(results, "--out", results.with_suffix(".xlsx"))
    ).active
    with open(
        _exported(results, "--out", results.with_suffix(".csv")), encoding="utf-8"
    ) as text:
        names, *rows = csv.reader(text)
    cells = [["" if x is None else x for x in row] for row in sheet.iter_rows(values_only=True)]
    heads = {"added_mass (kg)", "peak_moment_after (N m)", "coupler.length (m)", "closed"}
    assert cells[0] == names and heads <= {*names} and len(cells) == 5
    for words, row in zip(rows, cells[1:], strict=True):
        for word, value in zip(words, row, strict=True):
            if isinstance(value, str):
                assert value == word
            else:
                assert value == pytest.approx(float(word), rel=1e-14, abs=0.0)


def test_what_is_zero_everywhere_is_no_order(results):
    done = asked(["sweep", "show", str(results), "--sort", "peak_force_after"])
    assert done.code == 0
    assert "--sort peak_force_after: 0 in all rows; those that vary are" in done.err


def test_show_says_which_files_it_wrote(results):
    page, picture = results.with_suffix(".html"), results.with_suffix(".svg")
    axes = ["--plot", "coupler.length,coupler.mass,peak_moment", "--out", str(picture)]
    done = asked(["sweep", "show", str(results), "--html", str(page), *axes])
    assert done.code == 0 and page.is_file() and picture.is_file()
    assert f"written: {picture}, {page}" in done.err
    assert "written" not in asked(["sweep", "show", str(results)]).err


def test_moments_are_about_the_point_that_is_said(results, tmp_path):
    """The command that is named gives the moment of the column, another point gives another."""
    for words in (
        ["show", str(results)],
        ["export", str(results), "--out", str(tmp_path / "a.csv")],
    ):
        done = asked(["sweep", *words])
        assert "about the origin of the base frame, as by verify --about 0,0,0" in done.out
    table = balance.studies.read_study(results.with_suffix(".toml")).run(workers=0)
    path = tmp_path / "given.urdf"
    path.write_text(table.linkage(1).to_urdf(), encoding="utf-8")
    peak = pytest.approx(table["peak_moment"][1], rel=1e-3)
    assert balance.verify(str(path), speed="300rpm", about=(0.0, 0.0, 0.0)).moment == peak
    assert balance.verify(str(path), speed="300rpm").moment != peak
