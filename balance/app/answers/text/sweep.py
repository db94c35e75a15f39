"""Data and text of ``balance sweep``: what a run did, and what a file of results holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.studies.runs.column_ranges import column_ranges
from balance.studies.runs.results_file import ResultsFile
from balance.studies.sweeps.weight_columns import link_of_column
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


def file_data(file: ResultsFile) -> Data:
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
        added: the quantity whose masses that linkage has; empty for those given.
    """
    return {
        "schema": SCHEMA,
        "what": "export",
        **file_data(file),
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
        what = f"row {export['row']} with {masses_text(export['added'])}"
    written = ("written", f"{export['out']}, {what}")
    return [Facts([*file_facts(export), *moment_facts(units), written])]


def masses_text(added: str | None) -> str:
    """Say which masses the file of a row has.

    Args:
        added: the quantity of the study that gives them; None or empty for those given.
    """
    if added == "design":
        return "the masses of its design"
    return f"the masses given {f'and the matter of {added}' if added else 'alone'}"


def show_data(file: ResultsFile, order: str, descending: bool, count: int) -> Data:
    """Collect what a file holds: its columns, and its first rows.

    Args:
        order: column to sort by; empty for the order of the job.
        descending: whether the largest comes first.
        count: number of rows.

    Raises:
        UsageError: there is no such column, or round-off decides it.
    """
    contents = contents_data(file, order, descending, count)
    if any(column["name"] == order and column["round_off"] for column in contents["columns"]):
        raise UsageError(f"--sort {order}: it is round-off in all rows; sort by another column")
    return {"schema": SCHEMA, "what": "show", **file_data(file), **contents}


def contents_data(file: ResultsFile, order: str, descending: bool, count: int) -> Data:
    """Collect the columns of a file, and its first rows.

    Args:
        order: column to sort by; empty for the order of the job.
        descending: whether the largest comes first.
        count: number of rows.

    Raises:
        UsageError: there is no such column.
    """
    table = file.read(order=order, descending=descending, limit=count)
    ranges = {each.column.name: each for each in column_ranges(file)}
    columns = []
    for column in file.columns:
        least, most, missing = file.extent(column.name)
        known = ranges.get(column.name)
        columns.append(
            {
                "name": column.name,
                "kind": column.kind,
                "unit": column.unit or None,
                "least": least,
                "most": most,
                "missing": missing,
                "round_off": known is not None and known.round_off,
                "varies": least != most if known is None else known.varies,
            }
        )
    rows = [
        [_plain(value) for value in values]
        for values in zip(*(array.tolist() for array in table.values()), strict=True)
    ]
    return {
        "columns": columns,
        "sort": order or None,
        "descending": descending,
        "head": list(table),
        "table": rows,
    }


def equal_order_text(contents: Data) -> str:
    """Say that the column of the order is equal in all rows; empty if it is not.

    Args:
        contents: from `show_data`.
    """
    columns = [column for column in contents["columns"] if column["kind"] != "text"]
    for column in columns:
        equal = not column["varies"] and column["least"] is not None
        if column["name"] == contents["sort"] and equal and contents["results"] > 1:
            others = ", ".join(varying_numbers(columns))
            what = f"--sort {column['name']}: {cell_text(column['least'])} in all rows"
            return f"{what}; those that vary are {others}" if others else what
    return ""


def varying_numbers(columns: Sequence[Data]) -> list[str]:
    """List the names of columns of numbers that tell rows apart."""
    numbers = (column for column in columns if column["kind"] != "text")
    return [column["name"] for column in numbers if column["varies"]]


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
    moments = moment_facts([column["unit"] for column in columns])
    facts = Facts([*file_facts(contents), *moments, *idle_columns(columns)])
    body: list[AnswerPart] = [facts, "", AnswerTable(ranges, "<>")]
    if contents["table"]:
        rows = [[cell_text(value) for value in row] for row in contents["table"]]
        kept = [
            k
            for k, name in enumerate(contents["head"])
            if k == 0 or (any(row[k] for row in rows) and not link_of_column(name))
        ]
        body += [
            "",
            AnswerTable([[row[k] for k in kept] for row in (contents["head"], *rows)], "<>"),
        ]
    return body


def moment_facts(units: Sequence[str | None]) -> list[tuple[str, str]]:
    """Say about which point the moments are, if a column has the unit of a moment."""
    return [("moments", MOMENT_POINT)] if "N m" in units else []


def idle_columns(columns: Sequence[Data]) -> list[tuple[str, str]]:
    """Name columns of numbers that tell nothing: no row has a value, or all are round-off."""
    numbers = [
        column
        for column in columns
        if column["kind"] != "text" and not link_of_column(column["name"])
    ]
    groups = {
        "empty": [column["name"] for column in numbers if column["least"] is None],
        "zero": [column["name"] for column in numbers if column["round_off"]],
    }
    ends = {"empty": "", "zero": ": no more than round-off in all rows"}
    return [(name, f"{', '.join(g)}{ends[name]}") for name, g in groups.items() if g]


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
