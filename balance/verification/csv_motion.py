"""Read motions from files of comma-separated values, with checks."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from itertools import islice
from os import PathLike, fsdecode

import numpy as np
from numpy.typing import NDArray

from kinematics.error_text import clean
from kinematics.errors import FileError

__all__ = ["read_columns", "refuse_row"]

Array = NDArray[np.float64]

# Most rows of a table: a larger file would fill the memory.
MAX_ROWS = 100_000
REMEDY = "write a line of names, then one line of numbers per sample"


def refuse_row(
    path: str | PathLike[str], where: str, problem: str, remedy: str = REMEDY
) -> FileError:
    """Build the exception for a table that cannot be used.

    Args:
        path: file of the table.
        where: the line or sample at fault, or an empty string.
        problem: the problem.
        remedy: the remedy.

    Returns:
        The exception; the caller raises it.
    """
    return FileError(clean(fsdecode(path), 1000), where, problem, remedy)


def read_columns(
    path: str | PathLike[str],
    wanted: Sequence[str],
    fewest: int = 1,
    short: Mapping[str, str] | None = None,
    further: Sequence[str] = (),
) -> Array:
    """Read named columns from a file of comma-separated values.

    Args:
        path: a file whose first line holds the wanted names in any order, and no others.
        wanted: the names.
        fewest: least number of rows.
        short: other names that the file may use, and the wanted names for them.
        further: names of columns that the file may have too, all of them or none.

    Returns:
        The columns in the order of the names (rows, columns).

    Raises:
        FileError: the file cannot be read as such a table.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            lines = list(islice(csv.reader(file), MAX_ROWS + 2))
    except (OSError, UnicodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or "it is not text of comma-separated values"
        raise refuse_row(path, "", f"cannot be read ({reason})") from None
    lines = [line for line in lines if any(cell.strip() for cell in line)]
    names = [name.strip() for name in lines[0]] if lines else []
    other = short or {}
    names = [name if name in wanted else other.get(name, name) for name in names]
    if further and set(further) <= set(names):
        wanted = [*wanted, *further]
    if sorted(names) != sorted(wanted):
        raise refuse_row(path, "line 1", f"the columns must be {', '.join(wanted)}")
    if not fewest < len(lines) <= MAX_ROWS + 1:
        raise refuse_row(
            path, "", f"holds {len(lines) - 1} samples, not {fewest} to {MAX_ROWS}"
        )
    order = [names.index(name) for name in wanted]
    rows = np.empty((len(lines) - 1, len(wanted)))
    for number, line in enumerate(lines[1:]):
        try:
            rows[number] = [float(line[column]) for column in order]
        except (ValueError, IndexError):
            raise refuse_row(
                path, f"sample {number + 1}", "cannot be read as numbers"
            ) from None
    if not np.isfinite(rows).all():
        raise refuse_row(path, "", "holds numbers that are not finite")
    return rows
