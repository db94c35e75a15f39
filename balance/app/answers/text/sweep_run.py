"""Data and text of ``balance sweep run``: what was computed, and its best rows."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.sweep import (
    REASON,
    SCHEMA,
    Data,
    cell_text,
    contents_data,
    file_data,
    file_facts,
    idle_columns,
    masses_text,
    moment_facts,
    varying_numbers,
)
from balance.studies.runs.chunk_runs import RunSummary
from balance.studies.runs.results_file import ResultsFile
from balance.studies.sweeps.job import SweepJob
from balance.studies.sweeps.weight_columns import link_of_column
from balance.support.change_text import UNCHANGED
from kinematics.wording import count_noun, number_text

# Rows of the table: all of a file that has no more than these, or so many of the first.
MOST_ROWS, FIRST_ROWS = 25, 10


class NoAnswerRemedy(NamedTuple):
    """What gives a study answers of which no row has all.

    Attributes:
        force_row: a row that has an answer for the forces alone; None if none is known.
        ranges: ranges whose ends have answers, by path, in place of those given; may be empty.
    """

    force_row: int | None
    ranges: Mapping[str, str]


def run_data(file: ResultsFile, job: SweepJob, summary: RunSummary, best: Data | None) -> Data:
    """Collect what a run has done, and the rows that it shows.

    Args:
        job: the job of the file.
        best: the best row; None if none was asked for. The rows are in its order.
    """
    facts = file_data(file)
    order = best["column"] if best else ""
    largest = best is not None and best["largest"]
    count = facts["results"] if facts["results"] <= MOST_ROWS else FIRST_ROWS
    return {
        "schema": SCHEMA,
        "what": "run",
        **facts,
        "answered": facts["results"] - sum(each["count"] for each in facts["reasons"]),
        "chunks": summary.chunks,
        "computed": summary.rows,
        "kept": summary.kept,
        "seconds": summary.seconds,
        "rate": summary.rate,
        "lost_workers": summary.lost_workers,
        **contents_data(file, order, largest, count),
        "growths": _find_growths(file),
        "in_model": [{"name": k, "value": v} for k, v in job.values_in_model().items()],
        "following_regions": [each._asdict() for each in job.following_regions()],
        "best": best,
    }


def run_body(
    run: Data, lines: Sequence[str], of_study: bool, remedy: NoAnswerRemedy | None = None
) -> AnswerBody:
    """Build what is printed on a run: facts, the rows, and commands that lead on.

    Args:
        run: from `run_data`.
        lines: the commands.
        of_study: whether the request is the file of a study, whose entries change it.
        remedy: what was sought for a study without an answer.
    """
    units = [column["unit"] for column in run["columns"]]
    facts = [*file_facts(run), *_progress_facts(run), *_model_facts(run)]
    facts += moment_facts(units)
    equal = [_equal_text(column) for column in run["columns"] if _is_equal(column)]
    if equal and run["results"] > 1:
        facts.append(("in all rows", ", ".join(equal)))
    facts += [*idle_columns(run["columns"]), *_cancelled_facts(run, of_study)]
    facts += [
        *_growth_facts(run),
        *_weight_facts(run),
        *_region_facts(run, of_study),
        *_mass_facts(run, of_study),
    ]
    facts += _best_facts(run)
    body: list[AnswerPart] = [Facts(facts)]
    if not run["answered"]:
        body[:0] = [_no_answer_text(run, of_study, remedy or NoAnswerRemedy(None, {})), ""]
    if run["table"]:
        shown = [column for column in run["columns"] if _is_shown(column, run["results"])]
        body += ["", _table(run, shown)]
        if len(run["table"]) < run["results"]:
            body.append(f"… {run['results'] - len(run['table']):,} more rows")
    heads = ["Next: ", *["      "] * len(lines)]
    if lines:
        body.append("")
    return [*body, *(f"{head}{line}" for head, line in zip(heads, lines, strict=False))]


def _find_growths(file: ResultsFile) -> list[Data]:
    """List the rms loads that are larger after matter is added, and in how many rows."""
    growths, names = [], {column.name for column in file.columns}
    for before in ("rms_force", "rms_moment"):
        for after in (f"{before}_after", f"{before}_reduced"):
            if not names >= {before, after}:
                continue
            table = file.read([before, after])
            with np.errstate(divide="ignore", invalid="ignore"):
                ratios = table[after] / table[before]
            ratios = ratios[np.isfinite(ratios)]
            larger = ratios[ratios > 1.0 + UNCHANGED / 100.0]
            if larger.size:
                limits = float(larger.min()), float(larger.max())
                growth = {"before": before, "after": after, "rows": int(larger.size)}
                growths.append({**growth, "least": limits[0], "most": limits[1]})
    return growths


def _growth_facts(run: Data) -> list[tuple[str, str]]:
    """Say which loads grow by the matter that is added."""
    pairs = []
    for growth in run["growths"]:
        least, most = (number_text(growth[key], ".3g") for key in ("least", "most"))
        times = least if least == most else f"{least} to {most}"
        rows = f"in {growth['rows']:,} of {run['results']:,} rows"
        pairs.append(("grows", f"{growth['after']}: {times} times {growth['before']} {rows}"))
    return pairs


def _model_facts(run: Data) -> list[tuple[str, str]]:
    """Say which values the file of the model has of what varies."""
    columns = {column["name"]: column for column in run["columns"]}
    texts = []
    for each in run["in_model"]:
        column = columns[each["name"]]
        unit = f" {column['unit']}" if column["unit"] else ""
        text = f"{each['name']} {cell_text(each['value'])}{unit}"
        if column["least"] is not None:
            text += "" if _is_inside(column, each["value"]) else ", outside the range"
        texts.append(text)
    return [("in the file", "; ".join(texts))] if texts else []


def _cancelled_facts(run: Data, of_study: bool) -> list[tuple[str, str]]:
    """Say why no force is left after counterweights, and what leaves some, for less mass."""
    column = next((x for x in run["columns"] if x["name"] == "rms_force_after"), None)
    if column is None or column["most"] is None or column["varies"]:
        return []
    remedy = "[compute.reduce] with a budget" if of_study else "--reduce L1,L2 --budget KG"
    what = "counterweights cancel all force wherever there are any"
    return [("by design", f"{what}; {remedy} leaves some, for less mass")]


def _weight_facts(run: Data) -> list[tuple[str, str]]:
    """Say in which columns the weights are, which the printed table does not have."""
    names = [column["name"] for column in run["columns"] if link_of_column(column["name"])]
    if not names:
        return []
    links = " and ".join(dict.fromkeys(map(link_of_column, names)))
    text = f"mass and place of those on {links}: columns {', '.join(names[:2])} … in --table"
    return [("weights", text)]


def _region_facts(run: Data, of_study: bool) -> list[tuple[str, str]]:
    """Say that the room of a weight follows the length of its link, and what holds it."""
    regions = {each["link"]: each["text"] for each in run["following_regions"]}
    if not regions:
        return []
    first = run["following_regions"][0]["quantity"]
    entries = ", ".join(f'{link} = "{text}"' for link, text in regions.items())
    options = (shlex.quote(f"{link}={text}") for link, text in regions.items())
    remedy = (
        f"regions = {{{entries}}} of [compute.{first}]"
        if of_study
        else " ".join(f"--region {option}" for option in options)
    )
    which = " and ".join(regions)
    length = f"half the length of {which}, to its farthest joint or centre of mass"
    what = f"a ball of {length}, which grows with it"
    return [("room", f"{what}; to hold that of the file: {remedy}")]


def _mass_facts(run: Data, of_study: bool) -> list[tuple[str, str]]:
    """Say that masses stay where lengths alone vary, and how they follow them."""
    columns = (column["name"] for column in run["columns"])
    names = [name for name in columns if not link_of_column(name)]
    links = [name.removesuffix(".length") for name in names if name.endswith(".length")]
    follow = any(re.search(r"\.(mass|mass_per_length|com\.\w|inertia\.\w+)$", x) for x in names)
    if not links or follow:
        return []
    entry = f"{links[0]}.mass_per_length"
    remedy = (
        f"the entry {entry} (kg/m) of [parameters]" if of_study else f"--vary {entry}=KG_PER_M"
    )
    text = f"{remedy} makes a bar of {links[0]} whose mass follows its length"
    return [("masses", f"those of the file at every length; {text}")]


def _progress_facts(run: Data) -> list[tuple[str, str]]:
    """Say what was computed, and what was there before."""
    rate = f"{run['seconds']:.1f} s, {run['rate']:,.0f} geometries a second"
    pairs = [("computed", f"{run['computed']:,} geometries in {rate}")]
    if not run["computed"]:
        pairs = [("computed", "nothing was left to compute")]
    if run["kept"]:
        pairs.append(("kept", f"{run['kept']:,} geometries of an earlier run"))
    if run["lost_workers"]:
        again = f"{count_noun(run['lost_workers'], 'process')} ended, and others went on"
        pairs.append(("workers", again))
    return pairs


def _is_equal(column: Data) -> bool:
    """Whether all rows have one value of a column."""
    told = column["least"] is not None and column["name"] != REASON
    told = told and not link_of_column(column["name"])
    return told and not (column["missing"] or column["varies"] or column["round_off"])


def _equal_text(column: Data) -> str:
    """Name a column and its only value."""
    unit = f" {column['unit']}" if column["unit"] else ""
    return f"{column['name']} {cell_text(column['least'])}{unit}"


def _is_shown(column: Data, rows: int) -> bool:
    """Whether the table has a column: one that tells rows apart, or any of a single row."""
    told = column["least"] is not None and not column["round_off"]
    told = told and not link_of_column(column["name"])
    return told and (column["varies"] or rows == 1 or column["missing"] > 0)


def _table(run: Data, shown: Sequence[Data]) -> AnswerTable:
    """Build the table of rows, with a line of units."""
    places = [0, *(run["head"].index(column["name"]) for column in shown)]
    rows = [[cell_text(row[k]) for k in places] for row in run["table"]]
    units = ["", *(column["unit"] or "" for column in shown)]
    head = [run["head"][k] for k in places]
    return AnswerTable([head, *([units] if any(units) else []), *rows], "<>")


def _best_facts(run: Data) -> list[tuple[str, str]]:
    """Say which row is the best, and what its file has, or why there is none."""
    best = run["best"]
    if best is None:
        return []
    if best["row"] is None:
        others = ", ".join(varying_numbers(run["columns"]))
        remedy = f"; --best takes one that varies: {others}" if others else ""
        return [("best", f"none: {best['why_none']}{remedy}")]
    which = "largest" if best["largest"] else "least"
    row = f"row {best['row']}, {which} {best['column']} {cell_text(best['value'])}"
    column = next(each for each in run["columns"] if each["name"] == best["column"])
    known = run["results"] - column["missing"]
    if known > 1 and not column["varies"]:
        row += ", as all rows that have one" if column["missing"] else ", as all rows"
    elif known > 2 and (ends := " and ".join(_ends_of_range(run))):
        row += f", at the end of the range of {ends}: there may be better ones beyond"
    return [("best", f"{row}: {best['file']}, with {masses_text(best['added'])}")]


def _ends_of_range(run: Data) -> list[str]:
    """Name what varies and has its least or largest value in the best row, the first shown."""
    row = dict(zip(run["head"], run["table"][0], strict=True))
    columns = {column["name"]: column for column in run["columns"]}
    names = (each["name"] for each in run["in_model"] if columns[each["name"]]["varies"])
    return [x for x in names if row[x] in (columns[x]["least"], columns[x]["most"])]


def _is_inside(column: Data, value: float) -> bool:
    return bool(column["least"] <= value <= column["most"])


def _no_answer_text(run: Data, of_study: bool, remedy: NoAnswerRemedy) -> str:
    """Say that no row has all answers, and what helps."""
    closed = any(column["name"] == "closed" and column["most"] for column in run["columns"])
    words = "No geometry closes its loops."
    if closed:
        reason = run["reasons"][0]["reason"] if run["reasons"] else ""
        words = f"No row has all answers: {reason}."
    if remedy.force_row is not None:
        option = 'balance = "force" of [compute]' if of_study else "--balance force"
        only = "asks for the shaking force alone"
        return f"{words} {option} {only}: row {remedy.force_row} has an answer then."
    columns = {column["name"]: column for column in run["columns"]}
    outside = [x for x in run["in_model"] if not _is_inside(columns[x["name"]], x["value"])]
    values = " and ".join(f"{x['name']}={cell_text(x['value'])}" for x in outside)
    about = f" Vary about the values of the file, {values}" if outside else ""
    if remedy.ranges:
        about = about or " Vary less about the values of the file"
        return f"{words}{about}: {_ends_text(remedy.ranges, of_study)} have answers."
    if closed:
        return words
    return f"{words}{about or ' Vary less'}."


def _ends_text(ranges: Mapping[str, str], of_study: bool) -> str:
    """Name the ends of ranges, or the values that ``they`` are."""
    if not any(":" in text for text in ranges.values()):
        return "they"
    form = '"{}" = "{}"' if of_study else "{}={}"
    entries = " and ".join(form.format(*pair) for pair in ranges.items())
    return f"the ends of {entries}{' of [parameters]' * of_study}"
