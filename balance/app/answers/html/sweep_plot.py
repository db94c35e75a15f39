"""Picture of a sweep: two columns over each other, a third in colour, and drops of the rank."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import image, tidy
from balance.studies.runs.chunk_job import Column
from balance.studies.runs.column_ranges import column_ranges
from balance.studies.runs.results_file import ResultsFile
from balance.studies.sweeps.sweep_table import SweepTable
from kinematics.error_text import clean
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array

RANK = "rank"
# Most values of a column on a map, and the part of its cells that must have a row.
MAX_LINES, FILLED = 2000, 0.5
# Points beyond which they are drawn as an image in a picture of vectors.
MANY = 5000


def table_picture(table: SweepTable, kind: str = "png", columns: Sequence[str] = ()) -> bytes:
    """Draw columns of a sweep in memory, those of `default_columns` if none are named."""
    with ResultsFile.in_memory(table.source, table.job, table.columns) as rows:
        return sweep_picture(rows, columns or default_columns(rows), kind)


def sweep_picture(file: ResultsFile, names: Sequence[str], kind: str = "png") -> bytes:
    """Draw two columns over each other, as a map if they form a grid, or else as points.

    Rows whose rank is below that of most rows are marked.

    Args:
        names: columns of numbers: of the axes, and of the colour, if there is one.
        kind: ``"png"`` or ``"svg"``.

    Returns:
        The bytes of the image.

    Raises:
        UsageError: there is no such column, or it holds texts.
        PackageError: Matplotlib is missing.
    """
    columns = [file.column(name) for name in names]
    for column in columns:
        if column.kind == "text":
            place = f"{clean(file.path, 1000)}: column '{clean(column.name)}'"
            raise UsageError(f"{place} holds texts; draw a column of numbers")
    ranked = any(column.name == RANK for column in file.columns)
    table = file.read(list(dict.fromkeys([*names, *([RANK] if ranked else [])])))
    values = [_numbers(table[column.name], column) for column in columns]
    finite = np.isfinite(values[0]) & np.isfinite(values[1])
    drops = np.zeros(finite.size, dtype=bool)
    if ranked:
        drops = _rank_drops(table[RANK]) & finite
    return image((6.4, 4.8), kind, partial(_draw, columns, values, finite, drops))


def default_columns(file: ResultsFile) -> tuple[str, ...]:
    """Choose what to draw: two parameters and a quantity, or the one parameter and it.

    Those that vary come first, those that are empty or round-off last.

    Raises:
        UsageError: no two columns hold numbers.
    """
    ranges = column_ranges(file)
    names = [each.column.name for each in ranges]
    middle = names.index("closed")
    parameters, quantities = (
        sorted(group, key=lambda each: (not each.varies, each.least is None, each.round_off))
        for group in (ranges[:middle], ranges[middle + 1 :])
    )
    varied = [each for each in parameters if each.varies] or parameters
    quantity = next((each.column.name for each in quantities), "closed")
    return (*(each.column.name for each in varied[:2]), quantity)


def _numbers(values: NDArray[Any], column: Column) -> Array:
    """Convert a column to floating point, NaN for a missing value."""
    numbers = values.astype(float)
    if column.kind == "integer":
        numbers[values == -1] = np.nan
    return numbers


def _rank_drops(rank: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Find the rows of lower rank than most rows have; those without a rank are none."""
    ranked = rank >= 0
    if not ranked.any():
        return ranked
    usual = int(np.bincount(rank[ranked]).argmax())
    return ranked & (rank < usual)


def is_grid(x: Array, y: Array) -> bool:
    """Whether points lie on a grid, most of whose cells have one.

    Args:
        x: first coordinates (points,).
        y: second coordinates (points,).
    """
    across, along = np.unique(x), np.unique(y)
    if min(across.size, along.size) < 2 or max(across.size, along.size) > MAX_LINES:
        return False
    cells = np.unique(np.searchsorted(across, x) * along.size + np.searchsorted(along, y))
    return cells.size >= FILLED * across.size * along.size


def _draw(
    columns: Sequence[Column],
    values: Sequence[Array],
    finite: NDArray[np.bool_],
    drops: NDArray[np.bool_],
    figure: Any,
) -> None:
    """Draw the picture on a Matplotlib figure."""
    ax = figure.subplots()
    x, y = values[0], values[1]
    shade = values[2] if len(values) > 2 else None
    picture = None
    if shade is not None and is_grid(x[finite], y[finite]):
        picture = _draw_map(ax, x[finite], y[finite], shade[finite])
    else:
        colour = "#1f5a94" if shade is None else shade[finite]
        picture = ax.scatter(
            x[finite], y[finite], c=colour, s=9, linewidths=0, rasterized=finite.sum() > MANY
        )
    if shade is not None:
        figure.colorbar(picture, ax=ax, label=columns[2].heading)
    if drops.any():
        ax.scatter(
            x[drops],
            y[drops],
            s=34,
            facecolors="none",
            edgecolors="#c05a10",
            linewidths=1.2,
            label=f"lower rank: {int(drops.sum())} rows",
        )
        ax.legend(frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0))
    ax.set_xlabel(columns[0].heading)
    ax.set_ylabel(columns[1].heading)
    tidy(ax)


def _draw_map(ax: Any, x: Array, y: Array, shade: Array) -> Any:
    """Draw a map of the least value in each cell; cells without one stay white."""
    across, along = np.unique(x), np.unique(y)
    cells = np.full((along.size, across.size), np.inf)
    where = np.searchsorted(along, y), np.searchsorted(across, x)
    np.fmin.at(cells, where, shade)
    cells[~np.isfinite(cells)] = np.nan
    ax.set_axisbelow(True)
    return ax.pcolormesh(across, along, cells, shading="nearest", rasterized=cells.size > MANY)
