"""The best row of a file of results: that of the least or largest value of a column."""

from __future__ import annotations

from typing import NamedTuple

from balance.studies.runs.column_ranges import column_ranges
from balance.studies.runs.results_file import ResultsFile

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

    Args:
        name: the column.
        largest: whether the largest value is the best.

    Raises:
        UsageError: there is no such column of numbers.
    """
    extent = next(each for each in column_ranges(file) if each.column == file.column(name))
    if extent.least is None or extent.most is None:
        return BestRow(None, None, f"no row has a value of {name}")
    if extent.round_off:
        return BestRow(None, None, f"{name} is zero up to round-off in all rows")
    best = extent.most if largest else extent.least
    numbers = []
    for rows in file.batches([name], name, largest):
        equal = [row for row, value in rows if _is_equal(value, best)]
        numbers += [min(equal, default=file.rows)]
        if len(equal) < len(rows):
            break
    return BestRow(min(numbers), best)


def _is_equal(value: float | None, best: float) -> bool:
    """Whether a value is as good as the best one."""
    return value is not None and abs(value - best) <= EQUAL * abs(best)
