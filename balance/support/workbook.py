"""Tables as workbooks of Excel, from their comma-separated values."""

from __future__ import annotations

import csv
import re
from datetime import datetime
from io import BytesIO, StringIO
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from kinematics.errors import PackageError

# The same table gives the same bytes: all parts of the file are of this time.
WRITTEN = datetime(2000, 1, 1)
# Characters of the narrowest column: Excel rounds numbers to what a column shows.
LEAST_WIDTH = 10
# The part of a workbook with its properties, and when it was modified.
PROPERTIES, MODIFIED = "docProps/core.xml", re.compile(rb"(<dcterms:modified[^>]*>)[^<]*")


def require_openpyxl() -> None:
    """Refuse a workbook, before anything is computed for it, if openpyxl is missing.

    Raises:
        PackageError: it is missing.
    """
    try:
        import openpyxl  # noqa: F401
    except ImportError:
        more = ", or write a .csv"
        raise PackageError("a workbook", "openpyxl", "pip install openpyxl", more) from None


def workbook_of(table: bytes, title: str = "motion") -> bytes:
    """Convert a table to a workbook of one sheet: a line of names, and numbers as numbers.

    Args:
        table: comma-separated values, of a motion or of results.
        title: name of the sheet.

    Raises:
        PackageError: openpyxl is missing.
    """
    require_openpyxl()
    from openpyxl import Workbook
    from openpyxl.styles import Font

    book = Workbook()
    book.properties.created = WRITTEN
    sheet = book.active
    sheet.title = title
    names, *rows = csv.reader(StringIO(table.decode()))
    sheet.append(names)
    for row in rows:
        sheet.append([_cell(word) for word in row])
    for cell in sheet[1]:
        cell.font = Font(bold=True)
        width = max(LEAST_WIDTH, len(str(cell.value)) + 2)
        sheet.column_dimensions[cell.column_letter].width = width
    sheet.freeze_panes = "A2"
    packed = BytesIO()
    book.save(packed)
    return _undated(packed)


def _cell(word: str) -> float | str | None:
    """Read what a cell holds: a number, nothing where there is none, or a word."""
    try:
        number = float(word)
    except ValueError:
        return word or None
    return number if abs(number) < float("inf") else None


def _undated(packed: BytesIO) -> bytes:
    """Pack the parts of a file again, all with one date, and so the properties of the book."""
    again = BytesIO()
    with ZipFile(packed) as old, ZipFile(again, "w", ZIP_DEFLATED) as new:
        for name in old.namelist():
            part = ZipInfo(name, WRITTEN.timetuple()[:6])
            part.compress_type = ZIP_DEFLATED
            text = old.read(name)
            if name == PROPERTIES:  # openpyxl writes the time of saving
                text = MODIFIED.sub(rb"\g<1>" + WRITTEN.isoformat().encode() + b"Z", text)
            new.writestr(part, text)
    return again.getvalue()
