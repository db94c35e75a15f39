"""Which columns of results vary, are empty, or hold no more than round-off."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

from balance.studies.runs.chunk_job import Column
from balance.studies.runs.results_file import ResultsFile

# Size of a column over that of others of its unit, and its range over its size: up to this it
# is round-off.
ROUND_OFF = 1e-11


class ColumnRange(NamedTuple):
    """The values of a column of numbers.

    Attributes:
        column: the column.
        least: least value; None if it is empty.
        most: largest value; None likewise.
        missing: number of rows without a value.
        round_off: whether its values are round-off beside those of columns of its unit.
    """

    column: Column
    least: float | None
    most: float | None
    missing: int
    round_off: bool

    @property
    def varies(self) -> bool:
        """Whether two values differ by more than round-off."""
        if self.least is None or self.most is None or self.round_off:
            return False
        if self.column.kind == "integer":
            return self.least != self.most
        return self.most - self.least > ROUND_OFF * max(abs(self.least), abs(self.most))


def column_ranges(file: ResultsFile) -> list[ColumnRange]:
    """Find the ranges of all columns of numbers of a file.

    Args:
        file: a file of results.
    """
    numbers = [column for column in file.columns if column.kind != "text"]
    extents = {column.name: file.extent(column.name) for column in numbers}
    sizes = {
        name: max(abs(least), abs(most)) if least is not None else 0.0
        for name, (least, most, _) in extents.items()
    }
    largest: dict[str, float] = {}
    for column in numbers:
        if column.kind == "real" and isfinite(sizes[column.name]):
            largest[column.unit] = max(largest.get(column.unit, 0.0), sizes[column.name])
    return [
        ColumnRange(
            column,
            *extents[column.name],
            column.kind == "real"
            and 0.0 < sizes[column.name] <= ROUND_OFF * largest.get(column.unit, 0.0),
        )
        for column in numbers
    ]
