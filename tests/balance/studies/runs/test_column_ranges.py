"""Columns that tell nothing: no axes of a picture, and no lines of a table."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import balance
from balance.app.answers.html.sweep_plot import default_columns
from balance.app.answers.text.render import body_text
from balance.app.answers.text.sweep import show_body, show_data
from balance.studies.runs.chunk_job import Column
from balance.studies.runs.column_ranges import column_ranges
from balance.studies.runs.results_file import ResultsFile
from tests.support.squares import Squares

# Two parameters, and quantities: shaking left at round-off, an empty one, one that varies.
COLUMNS = (
    Column("base", "real", "m"),
    Column("arm", "real", "m"),
    Column("closed", "integer"),
    Column("reason", "text"),
    Column("peak_force", "real", "N"),
    Column("peak_force_after", "real", "N"),
    Column("added_mass", "real", "kg"),
    Column("inertia", "real", "kg m²"),
    Column("margin", "real"),
)
VALUES = {
    "base": np.array([0.5, 0.5 * (1.0 + 3e-16), 0.5]),
    "arm": np.array([0.1, 0.2, 0.3]),
    "closed": np.array([1, 1, 0]),
    "reason": ["", "", "its loops do not close"],
    "peak_force": np.array([12.0, 12.0 * (1.0 + 4e-15), np.nan]),
    "peak_force_after": np.array([3e-15, 8e-15, np.nan]),
    "added_mass": np.full(3, np.nan),
    "inertia": np.array([1e-13, 2e-13, np.nan]),
    "margin": np.array([np.inf, 0.25, np.nan]),
}


@pytest.fixture
def rows():
    job = Squares(rows=3, columns=COLUMNS)
    with ResultsFile.in_memory("rows", job, VALUES) as file:
        yield file


def test_what_varies_is_more_than_round_off(rows):
    """Small numbers of a unit of their own are no round-off; an axis has no infinite end."""
    ranges = {each.column.name: each for each in column_ranges(rows)}
    assert [name for name, each in ranges.items() if each.varies] == [
        *("arm", "closed", "inertia")
    ]
    assert [name for name, each in ranges.items() if each.round_off] == ["peak_force_after"]
    assert (ranges["added_mass"].least, ranges["added_mass"].missing) == (None, 3)


def test_a_picture_has_the_columns_that_vary(rows):
    """The base does not vary, the force neither, and the mass is empty."""
    assert default_columns(rows) == ("arm", "inertia")


def test_a_table_names_the_columns_that_tell_nothing(rows):
    text = body_text(show_body(show_data(rows, "", False, 10)))
    assert re.search(r"^empty +added_mass$", text, re.MULTILINE)
    zero = r"^zero +peak_force_after: no more than round-off in all rows$"
    assert re.search(zero, text, re.MULTILINE)
    table = text.split("least", 1)[1].split("\n\n")[0]
    assert "arm (m)" in table and "added_mass" not in table and "_after" not in table
    assert "its loops do not close" in text


@pytest.mark.slow
def test_a_page_says_why_a_row_has_no_counterweights(tmp_path):
    """It has the row, with what could be computed of it."""
    table = balance.sweep(
        "four_bar_general",
        {"crank.mass": [1.0, 2.0]},
        balance="force",
        quantities={
            "counterweights": {"links": ["crank"], "density": "none"},
            "input_inertia": {},
        },
    )
    assert set(table["counterweights"]) == {"infeasible"}
    (text,) = re.findall(r'id="sweep"[^>]*>(.*?)</script>', table.to_html(), re.DOTALL)
    data = json.loads(text)
    assert data["rows"] == [0, 1] and all("infeasible" in why for why in data["reasons"])
    assert [column["name"] for column in data["columns"]] == ["crank.mass", "inertia_u1"]
