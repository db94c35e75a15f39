"""Read motions from files of comma-separated values, with checks."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from itertools import islice
from os import PathLike, fsdecode
from typing import NamedTuple

import numpy as np

from balance.support.units import read_unit
from kinematics.error_text import clean, did_you_mean
from kinematics.errors import FileError, UsageError
from kinematics.numerics.array_types import Array, IntArray
from kinematics.wording import first_names

# Most rows of a table: a larger file would fill the memory.
MAX_ROWS = 100_000
# Quantities of a column, of which its head may name a unit.
COLUMN_UNITS = {
    "time": ("time",),
    "coordinate": (
        "angle",
        "length",
        "angular velocity",
        "velocity",
        "angular acceleration",
        "acceleration",
    ),
}
# Most names in a message.
MOST_NAMES = 8
REMEDY = "write a line of names, then one line of numbers per sample"


class Table(NamedTuple):
    """Columns of numbers, and how far the written ones can be from those that were meant.

    Attributes:
        values: numbers (rows, columns).
        rounding: half a unit of the last digit of each number (rows, columns); 0 in a column
            whose numbers are all the same.
        decimals: most decimals of a number in each column, exponents counted.
        quantities: quantity of the unit in the head of each column; empty without one.
        names: names of the columns.
    """

    values: Array
    rounding: Array
    decimals: tuple[int, ...]
    quantities: tuple[str, ...] = ()
    names: tuple[str, ...] = ()


def refuse_row(
    path: str | PathLike[str], where: str, problem: str, remedy: str = REMEDY
) -> FileError:
    """Build the exception for a table that cannot be used.

    Args:
        path: file of the table.
        where: the line or sample at fault, or an empty string.

    Returns:
        The exception; the caller raises it.
    """
    return FileError(clean(fsdecode(path), 1000), where, problem, remedy)


def read_columns(
    path: str | PathLike[str],
    wanted: Sequence[str],
    fewest: int = 1,
    short: Mapping[str, str] | None = None,
) -> Array:
    """Read named columns from a file of comma-separated values.

    Args:
        path: see `read_table`, as for the other arguments.
        fewest: least number of rows.
        short: other names that the file may use, and the wanted names for them.

    Returns:
        The numbers (rows, columns).
    """
    return read_table(path, wanted, fewest, short).values


def read_table(
    path: str | PathLike[str],
    wanted: Sequence[str],
    fewest: int = 1,
    short: Mapping[str, str] | None = None,
    further: Sequence[str] = (),
    some: Mapping[str, Sequence[str]] | None = None,
) -> Table:
    """Read named columns from a file of comma-separated values, and how they are rounded.

    Args:
        path: a file whose first line holds the wanted names in any order, and no others; each
            may be followed by a unit, as in ``main [deg]``.
        fewest: least number of rows.
        short: other names that the file may use, and the wanted names for them.
        further: names of columns that the file may have too, all of them or none.
        some: names of which the file must have at least one, in any number, and the quantities
            of their units, keys of `balance.support.units.UNITS`.

    Returns:
        The columns in the order of the names; of ``some``, those that there are.

    Raises:
        FileError: the file cannot be read as such a table.
    """
    lines = _read_lines(path, MAX_ROWS + 2)
    other, units = short or {}, some or {}
    cells = [cell.strip() for cell in lines[0]] if lines else []
    heads = [_split_head(path, cell, units, other) for cell in cells]
    names = [name if name in wanted else other.get(name, name) for name, _ in heads]
    if further and set(further) <= set(names):
        wanted = [*wanted, *further]
    present = [name for name in units if name in names]
    if sorted(names) != sorted([*wanted, *present]) or (some and not present):
        more = f" and some of {', '.join(units)}" if some else ""
        told = _what_is_wrong(names, wanted, list(units))
        raise refuse_row(path, "line 1", f"the columns must be {', '.join(wanted)}{more}{told}")
    wanted = [*wanted, *present]
    if not fewest < len(lines) <= MAX_ROWS + 1:
        raise refuse_row(
            path, "", f"holds {len(lines) - 1} samples, not {fewest} to {MAX_ROWS}"
        )
    order = [names.index(name) for name in wanted]
    rows = np.empty((len(lines) - 1, len(wanted)))
    digits = np.empty((2, *rows.shape), dtype=np.int64)
    for number, line in enumerate(lines[1:]):
        try:
            rows[number] = [float(line[column]) for column in order]
            digits[:, number] = np.transpose([_digits(line[column]) for column in order])
        except (ValueError, IndexError):
            raise refuse_row(
                path, f"sample {number + 1}", "cannot be read as numbers"
            ) from None
    if not np.isfinite(rows).all():
        raise refuse_row(path, "", "holds numbers that are not finite")
    quantities, factors = zip(*(heads[column][1] for column in order), strict=True)
    rounding = _rounding(rows, *digits) * factors
    decimals = tuple(digits[0].max(axis=0).tolist())
    return Table(rows * factors, rounding, decimals, quantities, tuple(wanted))


def _what_is_wrong(names: Sequence[str], needed: Sequence[str], some: Sequence[str]) -> str:
    """Say what the names in a table are, and what may be wrong with them."""
    for sign, word in ((";", "semicolons"), ("\t", "tabs")):
        if sign in "".join(names):
            return f"; commas part them, no {word}"
    wanted = [*needed, *some]
    missing = [name for name in wanted if name not in names]
    strange = [name for name in names if name not in wanted]
    told = [f"{clean(name, 40)}{did_you_mean(name, missing)}" for name in strange[:MOST_NAMES]]
    if told:
        return f", not {', '.join(told)}"
    still = [name for name in needed if name not in names and name != "time"]
    if not still or not set(needed) & set(names) - {"time"}:
        return ""
    verb = "has" if len(still) == 1 else "have"
    return f"; {first_names(still)} {verb} none: one number in all rows is an input at rest"


def column_names(path: str | PathLike[str]) -> list[str]:
    """Read the names of the columns of a table, without their units.

    Raises:
        FileError: the file cannot be read, or a unit is unknown.
    """
    lines = _read_lines(path, 1)
    return [_split_head(path, cell.strip(), {}, {})[0] for cell in lines[0]] if lines else []


def _read_lines(path: str | PathLike[str], most: int) -> list[list[str]]:
    """Read the first lines of a table that hold anything.

    Raises:
        FileError: the file cannot be read as text of comma-separated values.
    """
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            filled = (line for line in csv.reader(file) if any(map(str.strip, line)))
            return list(islice(filled, most))
    except (OSError, UnicodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or "it is not text of comma-separated values"
        raise refuse_row(path, "", f"cannot be read ({reason})") from None


def _split_head(
    path: str | PathLike[str],
    head: str,
    units: Mapping[str, Sequence[str]],
    short: Mapping[str, str],
) -> tuple[str, tuple[str, float]]:
    """Split ``main [deg]`` to the name of a column, and quantity and factor of its unit.

    Raises:
        FileError: there is no such unit.
    """
    name, bracket, unit = head.removesuffix("]").rpartition(" [")
    if not bracket or not head.endswith("]"):
        return head, ("", 1.0)
    name = name.strip()
    quantities = COLUMN_UNITS["time" if name == "time" else "coordinate"]
    quantities = tuple(units.get(short.get(name, name), quantities))
    try:
        return name, read_unit(unit, *quantities)
    except UsageError as error:
        raise refuse_row(path, f"column '{clean(head, 100)}'", str(error)) from None


def _digits(cell: str) -> tuple[int, int]:
    """Count the decimals of a number, its exponent included, and its significant digits."""
    mantissa, _, exponent = cell.strip().lower().partition("e")
    whole, _, fraction = mantissa.lstrip("+-").partition(".")
    significant = (whole + fraction).replace("_", "").lstrip("0")
    return len(fraction) - int(exponent or 0), len(significant)


def _rounding(rows: Array, decimals: IntArray, significant: IntArray) -> Array:
    """Compute half a unit of the last digit of each number; see `Table`.

    A column has one number of decimals or one number of significant digits, and zeros at the
    end of a number may be left out: of both, the coarser unit counts.
    """
    size = np.abs(rows)
    leading = np.floor(np.log10(np.where(size > 0.0, size, 1.0))) + 1.0
    places = np.maximum(-decimals.max(axis=0), leading - significant.max(axis=0))
    places = np.where(size > 0.0, places, -decimals.max(axis=0))
    round_off = np.finfo(np.float64).eps * size.max(axis=0)
    half_units = np.maximum(0.5 * 10.0 ** np.maximum(places, -300.0), round_off)
    return np.where(np.ptp(rows, axis=0) > 0.0, half_units, 0.0)
