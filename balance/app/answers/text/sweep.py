"""Data and text of ``balance sweep``: what a run did, and what a file of results holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.studies.runs.chunk_runs import RunSummary
from balance.studies.runs.column_ranges import column_ranges
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import UsageError
from kinematics.wording import count_noun, number_text

SCHEMA = "balance.sweep/1"
REASON = "reason"
"""The column in which a sweep says why a row has no answer; empty if it has one."""
MOMENT_POINT = (
    "about the origin of the base frame, as by verify --about 0,0,0; without it, those of "
    "verify are about the middle of the mechanism"
)
# Most characters of a text in a table.
WIDEST = 40

Data = dict[str, Any]


def run_data(file: ResultsFile, summary: RunSummary) -> Data:
    """Collect what a run has done."""
    return {
        "schema": SCHEMA,
        "what": "run",
        **_file_data(file),
        "chunks": summary.chunks,
        "computed": summary.rows,
        "kept": summary.kept,
        "seconds": summary.seconds,
        "rate": summary.rate,
        "lost_workers": summary.lost_workers,
    }


def _file_data(file: ResultsFile) -> Data:
    """Collect the facts on a file that all answers have."""
    covered, results = file.computed()
    reasons = []
    if any(column.name == REASON for column in file.columns):
        counts = file.counts(REASON)
        reasons = [{"reason": k, "count": n} for k, n in counts.items() if k is not None]
    return {
        "file": file.path if file.stored else None,
        "kind": file.about["kind"],
        "program": file.about["program"],
        "rows": file.rows,
        "covered": covered,
        "results": results,
        "reasons": reasons,
    }


def run_body(run: Data) -> AnswerBody:
    """Build what is printed on a run.

    Args:
        run: from `run_data`.
    """
    rate = f"{run['seconds']:.1f} s, {run['rate']:,.0f} geometries a second"
    pairs = [("computed", f"{run['computed']:,} geometries in {rate}")]
    if not run["computed"]:
        pairs = [("computed", "nothing was left to compute")]
    if run["kept"]:
        pairs.append(("kept", f"{run['kept']:,} geometries of an earlier run"))
    if run["lost_workers"]:
        again = f"{count_noun(run['lost_workers'], 'process')} ended, and others went on"
        pairs.append(("workers", again))
    return [Facts([*file_facts(run), *pairs])]


def file_facts(data: Data) -> list[tuple[str, str]]:
    """List the facts on a file as pairs of label and value.

    Args:
        data: any data of a file.
    """
    done = f"{data['covered']:,} of {data['rows']:,} geometries"
    state = "complete" if data["covered"] == data["rows"] else f"{done} so far"
    pairs = [("file", f"{data['file']}, {state}")] if data["file"] else []
    pairs.append(("results", f"{data['results']:,} rows"))
    for reason in data["reasons"]:
        pairs.append(("no answer", f"{reason['count']:,} rows: {reason['reason']}"))
    return pairs


def export_data(
    file: ResultsFile, path: str, rows: int, row: int | None = None, added: str = ""
) -> Data:
    """Collect what was exported.

    Args:
        path: path of the file that was written.
        rows: its rows.
        row: number of the row that is written as a linkage.
        added: the quantity whose matter that linkage has; empty for the masses given.
    """
    return {
        "schema": SCHEMA,
        "what": "export",
        **_file_data(file),
        "out": path,
        "lines": rows,
        "row": row,
        "added": added or None,
    }


def export_body(export: Data, units: Sequence[str | None]) -> AnswerBody:
    """Build what is printed on an export.

    Args:
        export: from `export_data`.
        units: those of the columns of the file.
    """
    what = count_noun(export["lines"], "row")
    if export["row"] is not None:
        masses = f"and the matter of {export['added']}" if export["added"] else "alone"
        what = f"row {export['row']} with the masses given {masses}"
    written = ("written", f"{export['out']}, {what}")
    return [Facts([*file_facts(export), *_moment_facts(units), written])]


def show_data(file: ResultsFile, order: str, descending: bool, count: int) -> Data:
    """Collect what a file holds: its columns, and its first rows.

    Args:
        order: column to sort by; empty for the order of the job.
        descending: whether the largest comes first.
        count: number of rows.

    Raises:
        UsageError: there is no such column, or round-off decides it.
    """
    table = file.read(order=order, descending=descending, limit=count)
    round_off = {each.column.name for each in column_ranges(file) if each.round_off}
    if order in round_off:
        raise UsageError(f"--sort {order}: it is round-off in all rows; sort by another column")
    columns = [
        {
            "name": column.name,
            "kind": column.kind,
            "unit": column.unit or None,
            **dict(zip(("least", "most", "missing"), file.extent(column.name), strict=True)),
            "round_off": column.name in round_off,
        }
        for column in file.columns
    ]
    rows = [
        [_plain(value) for value in values]
        for values in zip(*(array.tolist() for array in table.values()), strict=True)
    ]
    return {
        "schema": SCHEMA,
        "what": "show",
        **_file_data(file),
        "columns": columns,
        "sort": order or None,
        "descending": descending,
        "head": list(table),
        "table": rows,
    }


def _plain(value: Any) -> Any:
    """Return a value, or None for a missing one."""
    missing = value == "" or (isinstance(value, int) and value == -1) or value != value
    return None if missing else value


def show_body(contents: Data) -> AnswerBody:
    """Build what is printed on a file: facts, ranges of the columns, and a table.

    Args:
        contents: from `show_data`.
    """
    ranges = [
        (
            _headed(column),
            *(cell_text(column[key]) for key in ("least", "most")),
            f"{column['missing']:,}" if column["missing"] else "",
        )
        for column in contents["columns"]
        if column["kind"] != "text" and column["least"] is not None and not column["round_off"]
    ]
    ranges.insert(0, ("column", "least", "most", "missing"))
    columns = contents["columns"]
    moments = _moment_facts([column["unit"] for column in columns])
    facts = Facts([*file_facts(contents), *moments, *_idle_columns(columns)])
    body: list[AnswerPart] = [facts, "", AnswerTable(ranges, "<>")]
    if contents["table"]:
        rows = [[cell_text(value) for value in row] for row in contents["table"]]
        kept = [
            k for k in range(len(contents["head"])) if k == 0 or any(row[k] for row in rows)
        ]
        body += [
            "",
            AnswerTable([[row[k] for k in kept] for row in (contents["head"], *rows)], "<>"),
        ]
    return body


def _moment_facts(units: Sequence[str | None]) -> list[tuple[str, str]]:
    """Say about which point the moments are, if a column has the unit of a moment."""
    return [("moments", MOMENT_POINT)] if "N m" in units else []


def _idle_columns(columns: Sequence[Data]) -> list[tuple[str, str]]:
    """Name columns of numbers that tell nothing: no row has a value, or all are round-off."""
    numbers = [column for column in columns if column["kind"] != "text"]
    groups = {
        "empty": [column["name"] for column in numbers if column["least"] is None],
        "round-off": [column["name"] for column in numbers if column["round_off"]],
    }
    return [(label, ", ".join(names)) for label, names in groups.items() if names]


def _headed(column: Mapping[str, Any]) -> str:
    """Name a column and its unit."""
    return f"{column['name']} ({column['unit']})" if column["unit"] else str(column["name"])


def cell_text(value: Any) -> str:
    """Format a value for a table; a missing one is empty."""
    if value is None:
        return ""
    if isinstance(value, float | np.floating):
        return number_text(float(value), ".6g")
    text = str(value)
    return text if len(text) <= WIDEST else f"{text[: WIDEST - 1]}…"
