"""HTML page of a sweep: parallel coordinates to brush, a table, and the linkage of a row."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.render import facts_list, render_page
from balance.app.answers.text.sweep import REASON, file_facts, show_data
from balance.studies.runs.chunk_job import ROW_NUMBER, Column
from balance.studies.runs.column_ranges import column_ranges
from balance.studies.runs.file_errors import damaged
from balance.studies.runs.results_file import ResultsFile
from balance.studies.sweeps.plan import Plan
from balance.studies.sweeps.study_data import StudyData
from balance.studies.sweeps.sweep_table import SweepTable
from balance.studies.sweeps.weight_columns import link_of_column
from kinematics.error_text import clean
from kinematics.errors import LinkageError, UsageError
from kinematics.model.chain import rigid_parts
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Most rows on a page: half of them the first of the order, half spread over all.
MAX_ROWS = 2000
# Most axes of the parallel coordinates.
MAX_AXES = 14
# View of a linkage in space: the rows are the axes of the drawing.
OBLIQUE = np.array([[0.866, -0.5, 0.0], [0.25, 0.433, 0.866]])


def table_page(table: SweepTable) -> str:
    """Render a sweep in memory as one HTML file."""
    with ResultsFile.in_memory(table.source, table.job, table.columns) as rows:
        return sweep_page(rows)


def sweep_page(file: ResultsFile, order: str = "", descending: bool = False) -> str:
    """Render the results of a sweep as one HTML file.

    Args:
        order: column whose first rows are all on the page; empty for none.
        descending: whether the largest comes first.

    Returns:
        The text of the file; the element ``report`` contains what ``sweep show --json`` prints.

    Raises:
        UsageError: the file holds no sweep, or no row has an answer.
    """
    if file.about["kind"] != "sweep":
        raise UsageError(f"{clean(file.path, 1000)}: holds no sweep, and only that has a page")
    table = _rows(file, order, descending)
    if not table[ROW_NUMBER].size:
        raise UsageError(f"{clean(file.path, 1000)}: no row has an answer yet; nothing to draw")
    plan = _plan_of(file, table)
    report = show_data(file, order, descending, 10)
    name = plan.linkage.name
    return render_page(
        "sweep.html",
        title=name,
        summary="A study of many geometries of this linkage.",
        report=report,
        data={"sweep": _page_data(file, table, order), "drawing": _drawing(plan, table)},
        scripts=("sweep",),
        facts=facts_list(
            [*file_facts(report), ("on this page", f"{table[ROW_NUMBER].size:,} rows")]
        ),
    )


def _plan_of(file: ResultsFile, table: dict[str, NDArray[Any]]) -> Plan:
    """Read the study of a file again.

    Raises:
        FileError: the file is damaged: it has no study, or not the values of its parameters.
    """
    try:
        plan = Plan(StudyData.from_text(file.about["description"]))
    except LinkageError as error:
        raise damaged(file.path, f"its study cannot be read ({error})") from None
    for name in plan.driven:
        if name not in table or not np.isfinite(table[name].astype(float)).all():
            raise damaged(file.path, f"values of the parameter '{name}' are missing")
    return plan


def _rows(file: ResultsFile, order: str, descending: bool) -> dict[str, NDArray[Any]]:
    """Read the rows of the page that have some answer, the first of the order first."""
    results = file.computed()[1]
    half = MAX_ROWS if results <= MAX_ROWS else MAX_ROWS // 2
    first = file.read(order=order, descending=descending, limit=half if order else 0)
    every = -(-results // half) if results else 1
    spread = file.read(every=every)
    joined = {name: np.concatenate([first[name], spread[name]]) for name in first}
    _, once = np.unique(joined[ROW_NUMBER], return_index=True)
    once = np.sort(once)
    if REASON in joined:
        answered = joined[REASON] == ""
        names = [column.name for column in file.columns]
        for column in file.columns[names.index(REASON) + 1 :]:
            answered |= ~_missing(joined[column.name], column)
        once = once[answered[once]]
    return {name: values[once] for name, values in joined.items()}


def _page_data(file: ResultsFile, table: dict[str, NDArray[Any]], order: str) -> dict[str, Any]:
    """List the columns that vary and their values, and why rows lack some of them."""
    varying = [each.column for each in column_ranges(file) if each.varies]
    columns = sorted(varying, key=lambda column: bool(link_of_column(column.name)))[:MAX_AXES]
    return {
        "rows": table[ROW_NUMBER].tolist(),
        "columns": [
            {
                "name": column.name,
                "unit": column.unit,
                "whole": column.kind == "integer",
                "values": short(
                    np.where(
                        _missing(table[column.name], column),
                        np.nan,
                        table[column.name].astype(float),
                    )
                ),
            }
            for column in columns
        ],
        "reasons": table[REASON].tolist() if REASON in table else [],
        "order": order,
    }


def _missing(values: NDArray[Any], column: Column) -> NDArray[np.bool_]:
    """Find the missing values of a column."""
    if column.kind == "text":
        return np.asarray(values == "")
    return values == -1 if column.kind == "integer" else ~np.isfinite(values)


def _drawing(plan: Plan, table: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """Compute the centres of the joints in the plane of the drawing, row by row."""
    linkage = plan.linkage
    closed = plan.close({name: table[name] for name in plan.driven})
    links = closed.H[:, [joint.parent for joint in linkage.joints]]
    points = (links[..., :3, :3] @ closed.placed.points[..., None])[..., 0] + links[..., :3, 3]
    axes = linkage.chain.frame.R[:2] if linkage.planar else OBLIQUE @ linkage.chain.frame.R
    seen = points @ axes.T
    return {
        "parts": _parts(linkage, seen[0]),
        "joints": [joint.name for joint in linkage.joints],
        "points": [short(row.ravel()) for row in seen],
        "axes": ["x (m)", "y (m)"] if linkage.planar else ["seen from a corner (m)", ""],
    }


def _parts(linkage: Linkage, seen: Array) -> list[list[int]]:
    """List the joints on each rigid part, around their middle; the ground comes first."""
    parent = np.array([joint.parent for joint in linkage.joints])
    part = rigid_parts(parent.size, linkage.chain.ends)
    parts = []
    for p in range(int(part.max()) + 1):
        joints = np.flatnonzero((part[parent] == p) | (part[:-1] == p))
        off = seen[joints] - seen[joints].mean(axis=0)
        parts.append(joints[np.argsort(np.arctan2(off[:, 1], off[:, 0]))].tolist())
    return parts
