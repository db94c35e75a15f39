"""The best row of a file of results: that of the least or largest value of a column."""

from __future__ import annotations

from typing import NamedTuple

from balance.studies.runs.column_ranges import column_ranges
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import UsageError

# Column of a sweep that says whether the loops of a row close; 0 if they do not.
CLOSED = "closed"
# Values that differ by less, relative to the best, are equally good.
EQUAL = 1e-9


class BestRow(NamedTuple):
    """The best row of a file.

    Attributes:
        row: its number, the first of those that are equally good; None if there is none.
        value: its value, or None.
        why_none: why there is none; empty if there is one.
    """

    row: int | None
    value: float | None
    why_none: str = ""


def best_row(file: ResultsFile, name: str, largest: bool) -> BestRow:
    """Find the row with the least or largest value of a column of numbers.

    Rows whose loops do not close are no linkages, and do not count.

    Args:
        file: results of a sweep.
        name: the column.
        largest: whether the largest value is the best.

    Raises:
        UsageError: there is no such column of numbers.
    """
    ranges = {each.column.name: each for each in column_ranges(file)}
    if file.column(name).name not in ranges:
        raise UsageError(f"{file.path}: column '{name}' has texts: name one of numbers")
    if ranges[name].round_off:
        return BestRow(None, None, f"{name} is zero up to round-off in all rows")
    best: float | None = None
    first = file.rows
    for rows in file.batches([name, CLOSED], name, largest):
        valued = [(row, value) for row, value, closed in rows if closed and value is not None]
        for row, value in valued:
            best = value if best is None else best
            if abs(value - best) > EQUAL * abs(best):
                return BestRow(first, best)
            first = min(first, row)
    if best is None:
        return BestRow(None, None, f"no row whose loops close has a value of {name}")
    return BestRow(first, best)
