"""Page and picture of an identification: loads and what explains them; of a plan: inputs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.app.answers.html.plot_style import image, short, tidy
from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.html.time_panels import COLOURS, inputs_title
from balance.app.answers.text.identification import (
    identification_body,
    identification_facts,
    load_unit,
    plan_body,
    plan_sentence,
)
from balance.masses.identification.exciting_motion import ExcitingMotion
from balance.masses.identification.identification import Identification
from balance.support.tolerances import NOISE_LEAST
from kinematics.numerics.array_types import Array

# Most loads with a panel of their own, and most inputs with a line of their own.
MAX_PANELS = 9
MAX_LINES = 6
# Most samples of a load that a page draws.
MAX_SAMPLES = 300
# Most samples of a load that a picture draws.
MAX_DRAWN = 20_000
# Height of a panel of a page, and of what is above and below them, pixels.
PANEL_HEIGHT, REST_HEIGHT = 150, 60


class _Line(NamedTuple):
    """A line of a panel of a page.

    Attributes:
        name: in the legend.
        values: over time (N,).
        colour: of the line, or of its marks.
        dash: its dashes; empty for marks.
    """

    name: str
    values: Array
    colour: str
    dash: str


def identification_page(answer: Identification) -> str:
    """Render an identification as one HTML file: measured and explained loads, and masses.

    Returns:
        The text of the file; the element ``report`` contains `Identification.to_dict`.
    """
    time, loads = _loads_over_time(answer, MAX_SAMPLES)
    panels = [
        (
            f"{name} ({load_unit(answer, name)})",
            [
                _Line("measured", measured, COLOURS[2], ""),
                _Line("masses of the file", from_file, COLOURS[1], "dash"),
                _Line("identified", identified, COLOURS[0], "solid"),
            ],
        )
        for name, (measured, from_file, identified) in loads.items()
    ]
    return _page(
        answer.space.linkage.name,
        answer.sentence,
        answer.to_dict(),
        _figure(time, panels, _time_title(answer)),
        identification_body(answer),
        ("Combinations on which balance depends", "Loads", "Likeliest masses"),
        identification_facts(answer),
        heading="Measured loads, and what explains them",
        drawing="Measured loads over time, and those of the masses of the file and identified",
        caption="What the sensors measured, what the masses of the file would exert along the "
        "measured motion, and what the identified masses exert.",
    )


def plan_page(plan: ExcitingMotion) -> str:
    """Render a motion to be measured as one HTML file: inputs, speeds, accelerations.

    Returns:
        The text of the file; the element ``report`` contains `ExcitingMotion.to_dict`.
    """
    time, *motions = plan.samples(MAX_SAMPLES)
    linkage = plan.space.linkage
    quantities = (("displacement", ""), ("speed", "/s"), ("acceleration", "/s²"))
    panels = [
        (
            inputs_title(linkage, what, per),
            [
                _Line(name, values[:, k], COLOURS[k % len(COLOURS)], "solid")
                for k, name in enumerate(linkage.inputs[:MAX_LINES])
            ],
        )
        for (what, per), values in zip(quantities, motions, strict=True)
    ]
    body = plan_body(plan)
    facts = next(part.rows for part in body if isinstance(part, Facts))
    return _page(
        linkage.name,
        plan_sentence(plan),
        plan.to_dict(),
        _figure(time, panels, "time (s)"),
        body,
        ("Peaks of the inputs",),
        [(label, value) for label, value, *_ in facts],
        heading="The motion to measure",
        drawing="Displacements, speeds and accelerations of the inputs over time",
        caption="Inputs over time, from rest to rest at the reference pose.",
    )


def _page(
    title: str,
    summary: str,
    report: object,
    figure: dict[str, Any],
    body: AnswerBody,
    headings: Sequence[str],
    facts: Iterable[tuple[str, str]],
    **words: str,
) -> str:
    """Render a page with one chart, the tables of what is printed, and facts."""
    tables = [part.rows for part in body if isinstance(part, AnswerTable)]
    return render_page(
        "identification.html",
        title=title,
        summary=summary,
        report=report,
        data={"figures": [figure]},
        scripts=["curves"],
        facts=facts_list(facts),
        tables="\n".join(
            f'<section>\n<h2>{heading}</h2>\n<div class="scroll wide">\n'
            f"{rows_table(rows, _number_columns(rows), 1)}\n</div>\n</section>"
            for heading, rows in zip(headings, tables, strict=True)
        ),
        **{name: escape(text) for name, text in words.items()},
    )


def _number_columns(rows: Sequence[Sequence[str]]) -> list[int]:
    """List the columns of a table in which all rows, or all but words, are numbers."""
    return [
        k
        for k, cells in enumerate(zip(*rows[1:], strict=True))
        if any(cell.strip("-").replace(".", "").isdigit() for cell in cells)
    ]


def _loads_over_time(answer: Identification, most: int) -> tuple[Array, dict[str, Array]]:
    """Collect loads over time, those of several recordings one after another with a gap.

    Args:
        most: largest number of samples of all recordings.

    Returns:
        Time (N,), and of each load what was measured, what the masses of the file explain, and
        what the identified ones explain (3, N); NaN where it was not measured.
    """
    names = dict.fromkeys(
        name for each in answer.recordings for name in each.measurements.channels
    )
    shown = {name: [np.empty((3, 0))] for name in list(names)[:MAX_PANELS]}
    times, start = [np.empty(0)], 0.0
    total = sum(len(each.measurements.time) for each in answer.recordings)
    for k, recording in enumerate(answer.recordings):
        time, channels, values, _ = recording.measurements
        count = max(2, round(len(time) * min(1.0, most / total)))
        at = np.unique(np.linspace(0, len(time) - 1, count).round().astype(int))
        now = time[at] + (start - time[0] if k else 0.0)
        gap = [now[0]] if k else []
        start = float(now[-1])
        times += [np.array(gap), now]
        curves = np.concatenate([values[None], recording.predicted])[:, at]
        for name, parts in shown.items():
            parts.append(np.full((3, len(gap)), np.nan))
            known = name in channels
            unknown = np.full((3, len(at)), np.nan)
            parts.append(curves[:, :, channels.index(name)] if known else unknown)
    joined = {name: np.concatenate(parts, axis=1) for name, parts in shown.items()}
    return np.concatenate(times), joined


def _time_title(answer: Identification) -> str:
    """Return the title of the axis of time."""
    several = len(answer.recordings) > 1
    return "time (s), recordings one after another" if several else "time (s)"


def _figure(
    time: Array, panels: Sequence[tuple[str, Sequence[_Line]]], title: str
) -> dict[str, Any]:
    """Build the chart of panels one above the other; the first one has the legend."""
    traces, count = [], len(panels)
    scale = max(float(np.nanmax(np.abs(line.values))) for _, lines in panels for line in lines)
    layout: dict[str, Any] = {
        "hovermode": "x",
        "height": REST_HEIGHT + PANEL_HEIGHT * count,
        "xaxis": {"title": {"text": title}},
    }
    for row, (name, lines) in enumerate(panels):
        mark = str(row + 1) if row else ""
        layout[f"yaxis{mark}"] = {
            "domain": [1.0 - (row + 1) / count, 1.0 - row / count],
            "title": {"text": name},
        }
        if np.nanmax(np.abs([line.values for line in lines])) <= NOISE_LEAST * scale:
            layout[f"yaxis{mark}"]["range"] = [-scale, scale]
        traces += [
            {
                "type": "scatter",
                "mode": "lines" if line.dash else "markers",
                "name": line.name,
                "showlegend": row == 0,
                "x": short(time),
                "y": short(line.values),
                "yaxis": f"y{mark}",
                "line": {"color": line.colour, "dash": line.dash or "solid", "width": 1.5},
                "marker": {"color": line.colour, "size": 3},
            }
            for line in lines
        ]
    return {"data": traces, "layout": layout}


def identification_picture(answer: Identification, kind: str = "png") -> bytes:
    """Draw each measured load over time, and what file and identified masses predict."""
    time, loads = _loads_over_time(answer, MAX_DRAWN)
    columns = min(3, len(loads))
    rows = ceil(len(loads) / columns)
    curves = (
        (".", COLOURS[2], "measured"),
        ("--", COLOURS[1], "masses of the file"),
        ("-", COLOURS[0], "identified"),
    )

    def draw(figure: Any) -> None:
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True)
        for ax, (name, lines) in zip(panels.flat, loads.items(), strict=False):
            for values, (style, colour, label) in zip(lines, curves, strict=True):
                ax.plot(
                    time,
                    values,
                    style,
                    markersize=2.0,
                    linewidth=1.2,
                    color=colour,
                    label=label,
                )
            ax.set_ylabel(f"{name} ({load_unit(answer, name)})")
            tidy(ax)
        for ax in panels.flat[len(loads) :]:
            ax.set_axis_off()
        for ax in panels[-1]:
            ax.set_xlabel(_time_title(answer))
        panels[0, 0].set_title(answer.space.linkage.name, loc="left")
        panels[0, 0].legend(frameon=False, fontsize=8)

    return image((4.0 * columns, 0.6 + 2.4 * rows), kind, draw)


def plan_picture(plan: ExcitingMotion, kind: str = "png") -> bytes:
    """Draw displacements, speeds and accelerations of the inputs over time."""
    time, *motions = plan.samples(401)
    titles = ("displacement of the inputs", "speed", "acceleration")

    def draw(figure: Any) -> None:
        panels = figure.subplots(3, 1, sharex=True)
        for ax, values, title in zip(panels, motions, titles, strict=True):
            for k, name in enumerate(plan.space.linkage.inputs[:MAX_LINES]):
                ax.plot(
                    time,
                    values[:, k],
                    color=COLOURS[k % len(COLOURS)],
                    linewidth=1.2,
                    label=name,
                )
            ax.set_ylabel(title)
            tidy(ax)
        panels[-1].set_xlabel("time (s)")
        panels[0].set_title(plan.space.linkage.name, loc="left")
        panels[0].legend(frameon=False, fontsize=8)

    return image((7.0, 6.4), kind, draw)
