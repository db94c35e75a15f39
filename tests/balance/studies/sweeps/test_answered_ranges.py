"""Ranges that are proposed where a study has no answer: all their rows have some."""

from __future__ import annotations

import pytest

import balance
from balance.studies.sweeps.answered_ranges import answered_ranges
from balance.studies.sweeps.job import SweepJob
from balance.studies.sweeps.study_data import StudyData

pytestmark = pytest.mark.lanes

SPEED = {"quantities": ["shaking"], "shaking": {"speed": "300rpm"}}


def proposed(parameters, compute):
    """The ranges for a study of the four-bar."""
    tables = {
        "model": {"file": "four_bar_general"},
        "parameters": parameters,
        "compute": compute,
    }
    return answered_ranges(SweepJob.of_study(StudyData.from_tables(tables)))


@pytest.mark.parametrize(
    ("parameters", "moved"),
    [
        ({"crank.length": "0.8:0.9:4"}, {"crank.length"}),
        ({"crank.length": [0.8, 0.9], "rocker.length": "0.7:0.75:3"}, {"crank.length"}),
        # The coupler of the file is inside of its range, whose other end does not close.
        ({"crank.length": [0.8, 0.9], "coupler.length": "0.5:3:3"}, None),
        # The range has the value of the file, and is too wide on both sides of it.
        ({"coupler.length": "0.01:3:2"}, {"coupler.length"}),
    ],
)
def test_rows_of_proposed_ranges_have_answers(parameters, moved):
    """Between the ends too, of which alone the proposal knows."""
    ranges = proposed(parameters, SPEED)
    assert {*ranges} == (moved or {*parameters})
    table = balance.sweep(
        "four_bar_general", parameters | ranges, quantities={"shaking": {"speed": "300rpm"}}
    )
    assert not any(table["reason"])


def test_nothing_is_proposed_where_the_model_has_no_answer():
    """A crank alone gets no counterweights; samples and many parameters get no proposal."""
    crank = {"quantities": ["counterweights"], "counterweights": {"links": ["crank"]}}
    assert proposed({"coupler.length": "0.9:1:2"}, crank | {"balance": "force"}) == {}
    many = {f"{link}.mass": [1.0, 2.0] for link in ("crank", "coupler", "rocker")}
    assert proposed({"coupler.length": [7.0]} | many, SPEED) == {}
