"""Pages and pictures of paths over ratios of inertia, and of a path through given poses."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from html import escape
from typing import Any, NamedTuple

import numpy as np

from balance.app.answers.html.paths import axis_labels, in_plane, path_plane
from balance.app.answers.html.plot_style import image, short, tidy
from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.html.time_panels import COLOURS
from balance.app.answers.text.path_inertia import (
    chart_facts,
    chart_rows,
    moments_facts,
    moments_rows,
)
from balance.motion.paths.inertia_ratios import InertiaChart, PathMoments
from kinematics.closure.joint_positions import input_chain
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import number_text


class _Line(NamedTuple):
    """A line, or points, of a drawing.

    Attributes:
        name: in the legend; empty for the name of the line before.
        points: in the plane of the drawing (N, 2).
        colour: of it.
        dots: whether it is points.
    """

    name: str
    points: Array
    colour: str
    dots: bool = False


class _Drawing(NamedTuple):
    """Lines in a plane: the titles of its axes, and whether both have one scale."""

    axes: tuple[str, str]
    lines: Sequence[_Line]
    equal: bool


def _chart_drawing(chart: InertiaChart) -> _Drawing:
    """Draw the paths of a chart: of the tool, or in the two inputs that move most."""
    linkage, tool = chart.solutions[0].linkage, chart.solutions[0].tool is not None
    paths = [path for solution in chart.solutions for path in solution.paths]
    labels = axis_labels(linkage)
    axes = (0, -1) if tool or not paths else path_plane(linkage, paths, None).axes
    lines = []
    for k, (factor, solution) in enumerate(zip(chart.factors, chart.solutions, strict=True)):
        for j, path in enumerate(solution.paths):
            points = np.column_stack([path.u, path.s])[:, list(axes)]
            if solution.tool is not None:
                points = in_plane(linkage, solution.tool.ways[j])
            name = f"{number_text(factor)} of the inertia of {chart.link}" if j == 0 else ""
            lines.append(_Line(name, points, COLOURS[k % len(COLOURS)]))
    titles = ("x (m)", "y (m)") if tool else (labels[axes[0]], labels[axes[1]])
    return _Drawing(titles, lines, tool)


def _moments_drawing(answer: PathMoments) -> _Drawing:
    """Draw a path and the poses in the two inputs that move most, or one of them."""
    linkage = answer.linkage
    units = input_chain(linkage).units[linkage.positions_of(linkage.inputs)]
    reach = np.ptp(np.concatenate([answer.u, answer.poses]), axis=0) / units
    shown = sorted(rank_least_first((-reach).tolist(), float(reach.max()))[:2])
    labels = axis_labels(linkage)
    if len(shown) < 2:
        share = np.linspace(0.0, 1.0, len(answer.u))
        return _Drawing(
            ("part of the path", labels[0]),
            [_Line("path", np.column_stack([share, answer.u]), COLOURS[0])],
            False,
        )
    lines = [
        _Line("path" if not answer.reason else "nearest curve", answer.u[:, shown], COLOURS[0]),
        _Line("poses", answer.poses[:, shown], COLOURS[1], True),
    ]
    return _Drawing((labels[shown[0]], labels[shown[1]]), lines, False)


def chart_page(chart: InertiaChart) -> str:
    """Render paths over ratios of inertia as one HTML file."""
    count = sum(bool(solution.paths) for solution in chart.solutions)
    return _page(
        chart.solutions[0].linkage.name,
        f"Paths for {count} of {len(chart.factors)} factors of the moments of inertia of "
        f"{chart.link}.",
        chart.to_dict(),
        _chart_drawing(chart),
        chart_rows(chart),
        chart_facts(chart),
        "Paths over ratios of inertia",
        "A colour for each factor; mass and centre of mass of the link stay.",
    )


def moments_page(answer: PathMoments) -> str:
    """Render moments of inertia for a path through poses as one HTML file."""
    texts = (f"{name} times {number_text(value)}" for name, value in answer.factors.items())
    passes = (
        f"A path passes through all poses with the moments of inertia of {', '.join(texts)}."
    )
    return _page(
        answer.linkage.name,
        f"No path: {answer.reason}." if answer.reason else passes,
        answer.to_dict(),
        _moments_drawing(answer),
        [] if answer.reason else moments_rows(answer),
        moments_facts(answer),
        "The path through the poses",
        "The path in the inputs that move most, from the first pose to the last.",
    )


def _page(
    title: str,
    summary: str,
    report: object,
    drawing: _Drawing,
    rows: Sequence[tuple[str, ...]],
    facts: Sequence[tuple[str, str]],
    heading: str,
    caption: str,
) -> str:
    """Render a page with one chart, a table and facts."""
    traces = [
        {
            "type": "scatter",
            "mode": "markers" if line.dots else "lines",
            "name": line.name,
            "showlegend": bool(line.name),
            "x": short(line.points[:, 0]),
            "y": short(line.points[:, 1]),
            "line": {"color": line.colour, "width": 1.8},
            "marker": {"color": line.colour, "size": 8},
        }
        for line in drawing.lines
    ]
    yaxis: dict[str, Any] = {"title": {"text": drawing.axes[1]}}
    layout = {
        "showlegend": True,
        "xaxis": {"title": {"text": drawing.axes[0]}}
        | ({"scaleanchor": "y"} if drawing.equal else {}),
        "yaxis": yaxis,
    }
    table = (
        f"<section>\n<h2>Numbers</h2>\n{rows_table(rows, [0], 1)}\n</section>" if rows else ""
    )
    return render_page(
        "identification.html",
        title=title,
        summary=summary,
        report=report,
        data={"figures": [{"data": traces, "layout": layout}]},
        scripts=["curves"],
        facts=facts_list(facts),
        tables=table,
        heading=escape(heading),
        drawing=escape(heading),
        caption=escape(caption),
    )


def chart_picture(chart: InertiaChart, kind: str = "png") -> bytes:
    """Draw the paths of a chart, a colour for each factor: of the tool, or in two inputs."""
    title = f"{chart.solutions[0].linkage.name}: paths over ratios of inertia"
    return image((6.4, 4.8), kind, partial(_draw, _chart_drawing(chart), title))


def moments_picture(answer: PathMoments, kind: str = "png") -> bytes:
    """Draw the path through the poses in the two inputs that move most."""
    title = f"{answer.linkage.name}: path through poses"
    return image((6.4, 4.8), kind, partial(_draw, _moments_drawing(answer), title))


def _draw(drawing: _Drawing, title: str, figure: Any) -> None:
    """Draw lines on a Matplotlib figure."""
    ax = figure.subplots()
    for line in drawing.lines:
        style = {"linestyle": "", "marker": "o"} if line.dots else {"linewidth": 1.8}
        ax.plot(*line.points.T, color=line.colour, label=line.name or None, **style)
    ax.set(xlabel=drawing.axes[0], ylabel=drawing.axes[1])
    if drawing.equal:
        ax.set_aspect("equal")
    ax.set_title(title, loc="left", fontsize=9)
    if drawing.lines:
        ax.legend(frameon=False, fontsize=8)
    tidy(ax)
