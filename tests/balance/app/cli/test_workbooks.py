"""Tables as workbooks: what another program reads in them, and what is refused."""

import csv
import sys
from datetime import datetime

import openpyxl
import pytest

from balance.support.workbook import workbook_of
from tests.support.command_runs import asked

WORDS = ["verify", "slider_crank", "--trajectories", "1", "--table"]


def test_cells_are_numbers_and_names(tmp_path):
    """Excel would show a word as it is, and add up no column of words."""
    table = b'time,"a, b",note\n0.1,-2.5e-300,up\n1e6,nan,\n'
    path = tmp_path / "t.xlsx"
    path.write_bytes(workbook_of(table))
    book = openpyxl.load_workbook(path)
    assert book.sheetnames == ["motion"]
    rows = [[cell.value for cell in row] for row in book["motion"].iter_rows()]
    assert rows == [["time", "a, b", "note"], [0.1, -2.5e-300, "up"], [1e6, None, None]]
    dates = book.properties.created, book.properties.modified
    assert dates == (datetime(2000, 1, 1),) * 2  # the same table gives the same bytes
    assert workbook_of(table) == path.read_bytes()


def test_columns_are_as_wide_as_their_names(tmp_path):
    path = tmp_path / "t.xlsx"
    path.write_bytes(workbook_of(b"row,crank.counterweight.mass (kg)\n0,0.123456789\n"))
    widths = openpyxl.load_workbook(path)["motion"].column_dimensions
    assert widths["A"].width >= 10 and widths["B"].width > len("crank.counterweight.mass (kg)")


@pytest.mark.slow
def test_the_command_writes_the_numbers_of_the_table(tmp_path):
    """Cell by cell, to the last digit that Excel keeps."""
    book, table = tmp_path / "t.xlsx", tmp_path / "t.csv"
    for path in (book, table):
        assert asked([*WORDS, str(path)]).code == 1
    names, *rows = csv.reader(table.read_text("utf-8").splitlines())
    sheet = openpyxl.load_workbook(book)["motion"]
    head, *found = [[cell.value for cell in row] for row in sheet.iter_rows()]
    assert head == names and len(found) == len(rows) > 100
    for row, cells in zip(rows, found, strict=True):
        assert cells == pytest.approx([float(word) for word in row], rel=1e-14)


def test_a_workbook_without_openpyxl_is_refused_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    done = asked([*WORDS, str(tmp_path / "t.xlsx")])
    assert done.code == 2 and not done.out and not list(tmp_path.iterdir())
    assert "a workbook needs openpyxl, which is not installed" in done.err
    assert "'pip install openpyxl', or write a .csv" in done.err


def test_other_endings_are_refused(tmp_path):
    for name in ("t.xls", "t.ods", "t"):
        done = asked([*WORDS, str(tmp_path / name)])
        assert done.code == 2 and f"{name}' ends neither in .csv nor in .xlsx" in done.err
    assert not list(tmp_path.iterdir())
