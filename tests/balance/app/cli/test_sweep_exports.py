"""What ``balance sweep export`` writes: a workbook, and one row as a linkage."""

from __future__ import annotations

import csv

import numpy as np
import pytest

import balance
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
    """Pinocchio finds the force of its column along the turn of its crank."""
    with open(
        _exported(results, "--out", results.with_suffix(".csv")), encoding="utf-8"
    ) as text:
        rows = list(csv.DictReader(text))
    table = balance.studies.read_study(results.with_suffix(".toml")).run(workers=0)
    for number in (1, 2):
        path = _exported(results, "--out", results.parent / f"{number}.urdf", "--row", number)
        linkage = balance.load(str(path))
        masses = {body.name: body.inertia[0] for body in linkage.bodies}
        assert masses["coupler"] == pytest.approx(float(rows[number]["coupler.mass"]))
        places = {joint.name: joint.point for joint in linkage.joints}
        length = np.linalg.norm(places["q2"] - places["q3"])
        assert length == pytest.approx(float(rows[number]["coupler.length"]))
        check = balance.verify(str(path), speed="300rpm")
        assert check.force == pytest.approx(float(rows[number]["peak_force"]), rel=1e-3)
        assert table.linkage(number).to_urdf() == path.read_text(encoding="utf-8")


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
    assert cells[0] == names and len(cells) == 5
    for words, row in zip(rows, cells[1:], strict=True):
        for word, value in zip(words, row, strict=True):
            if isinstance(value, str):
                assert value == word
            else:
                assert value == pytest.approx(float(word), rel=1e-14, abs=0.0)


def test_round_off_is_no_order(results):
    done = asked(["sweep", "show", str(results), "--sort", "peak_force_after"])
    assert done.code == 2 and "it is round-off in all rows" in done.err
