"""Plots of a Taylor motion: error of every order over distance.

The output is a Matplotlib image, or an HTML page that needs no network.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from html import escape
from typing import Any, NamedTuple

import numpy as np

from balance.app.answers.html.plot_style import image, short, tidy
from balance.app.answers.html.render import facts_list, html_table, render_page
from balance.app.answers.html.scene import scene
from balance.app.answers.html.time_panels import COLOURS, MAX_LINES
from balance.app.answers.text.motion import measure, motion_facts, motion_tables
from balance.motion.taylor_poses.error_curves import Curves
from balance.motion.taylor_poses.prediction import Predictions
from kinematics.closure.assembly.tool_frame import tool_coordinates
from kinematics.errors import UnreachedError
from kinematics.model.chain import rigid_parts
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

# Lower end of the error axis: round-off.
LOWEST_ERROR = 1e-16
# Upper end of the error axis: such predictions are useless.
HIGHEST_ERROR = 1e2
# Larger errors are drawn here, above the axis: Matplotlib cannot draw some of them.
ERROR_CAP = 1e30
# Colours: low orders are light, high ones dark, the estimate is orange.
LIGHT = (0x9C, 0xC3, 0xE4)
DARK = (0x08, 0x26, 0x4A)
WARM = "#b8550a"
SHADE = "#f0f1f3"
INK = "#1b1e22"
# Most poses in the table.
MAX_POSES = 20
# Poses of a run along a line, and most poses of a path.
LINE_POSES, PATH_POSES = 41, 201
# Length of a run along a coordinate, in radii of convergence, or without one.
RADII, WITHOUT_RADIUS = 0.9, 1.0


def _colours(count: int) -> list[str]:
    """Compute the colours of the orders."""
    shares = np.linspace(0.0, 1.0, count) if count > 1 else np.ones(1)
    mixed = np.round(np.outer(1.0 - shares, LIGHT) + np.outer(shares, DARK)).astype(int)
    return ["#{:02x}{:02x}{:02x}".format(*rgb) for rgb in mixed.tolist()]


def _axis_limits(panels: Sequence[Curves]) -> tuple[float, float]:
    """Compute the common limits of the error axes."""
    values = np.concatenate([panel.errors.ravel() for panel in panels])
    values = values[values > 0.0]
    if values.size == 0:
        return LOWEST_ERROR, 1.0
    return max(LOWEST_ERROR, 0.5 * float(values.min())), min(
        HIGHEST_ERROR, 2.0 * float(values.max())
    )


def motion_picture(
    predictions: Predictions, panels: Sequence[Curves], kind: str = "png"
) -> bytes:
    """Draw the panels as an image.

    Args:
        panels: from `balance.motion.taylor_poses.error_curves.error_curves`.
        kind: ``"png"`` or ``"svg"``.
    """
    columns = min(2, len(panels))
    lines = -(-len(panels) // columns)
    size = (1.5 + 5.0 * columns, 1.2 + 3.2 * lines)
    return image(size, kind, partial(_draw_panels, predictions, panels, (lines, columns)))


def _draw_panels(
    predictions: Predictions, panels: Sequence[Curves], shape: tuple[int, int], figure: Any
) -> None:
    """Draw the panels on a Matplotlib figure, with one legend below."""
    axes = figure.subplots(*shape, sharey=True, squeeze=False)
    figure.suptitle(_heading(predictions), x=0.01, ha="left", fontsize=11)
    for ax in axes.flat[len(panels) :]:
        ax.set_visible(False)
    for ax, panel in zip(axes.flat, panels, strict=False):
        _draw_panel(ax, panel, f"{panel.axis} ({measure(predictions)})")
        ax.set_ylim(_axis_limits(panels))
    for ax in axes[:, 0]:
        ax.set_ylabel("error")
    named: dict[str, Any] = {}
    for ax in axes.flat:
        lines, names = ax.get_legend_handles_labels()
        named |= dict(zip(names, lines, strict=True))
    figure.legend(
        named.values(),
        named.keys(),
        loc="outside lower left",
        ncols=4 * shape[1],
        frameon=False,
        fontsize=8,
    )


def _draw_panel(ax: Any, panel: Curves, axis: str) -> None:
    """Draw one panel on Matplotlib axes."""
    colours = _colours(len(panel.errors))
    for k, (line, colour) in enumerate(zip(panel.errors, colours, strict=True), 1):
        capped = np.minimum(line, ERROR_CAP)
        ax.plot(panel.x, capped, color=colour, linewidth=1.3, label=f"order {k}")
    ax.plot(
        panel.x,
        panel.estimate,
        color=WARM,
        linewidth=1.6,
        linestyle=":",
        label=f"order {len(colours)}, estimated",
    )
    for first, last in panel.beyond:
        ax.axvspan(first, last, color=SHADE, linewidth=0.0, zorder=0, label="beyond the radius")
    for x in panel.closed:
        ax.axvline(x, color=INK, linewidth=1.4, label="the loops close no further")
    if panel.target is not None:
        ax.axvline(panel.target, color=INK, linewidth=0.9, linestyle="--", label="target")
    ax.set_yscale("log", nonpositive="mask")
    ax.set_xlabel(axis)
    ax.set_title(panel.title, loc="left", fontsize=9)
    ax.margins(x=0.0)
    tidy(ax)


def _heading(predictions: Predictions) -> str:
    """Build the heading: name, orders and radius."""
    radius = predictions.motion.radius
    circle = f", radius of convergence {radius:.3g}" if np.isfinite(radius) else ""
    return f"{predictions.linkage.name}: orders 1 to {predictions.motion.order}{circle}"


def motion_page(predictions: Predictions, panels: Sequence[Curves]) -> str:
    """Render predictions of a Taylor motion as one HTML file.

    Args:
        panels: from `balance.motion.taylor_poses.error_curves.error_curves`.

    Returns:
        The text of the file.
    """
    limits, unit = _axis_limits(panels), measure(predictions)
    figures = [_figure(panel, f"{panel.axis} ({unit})", limits) for panel in panels]
    return render_page(
        "motion.html",
        title=predictions.linkage.name,
        summary=_summary(predictions),
        report=predictions.to_dict(),
        data={"figures": figures, "motion": _motion_runs(predictions)},
        scripts=["curves", "motion"],
        facts=facts_list(motion_facts(predictions)),
        poses=_pose_sections(predictions),
        legend=_legend(panels),
        curves="\n".join(
            f'<div class="traces low" id="traces{k}" role="img" aria-label="Error of every '
            f'order against distance, {escape(panel.title)}"></div>'
            for k, panel in enumerate(panels)
        ),
    )


def _summary(predictions: Predictions) -> str:
    """Summarise the page: whether the poses are reached, and what was expanded."""
    count = predictions.motion.scales.size
    size = f"{count} coordinate{'' if count == 1 else 's'}"
    degree = predictions.motion.order
    what = f"All joints as polynomials of degree {degree} in {size}, and their error."
    verdict = dict(motion_facts(predictions)).get("verdict")
    if verdict is None:
        return what
    subject = "The pose is" if predictions.line else "The path is"
    return f"{subject} {verdict}. {what}"


def _pose_sections(predictions: Predictions) -> str:
    """Render the joints of the one pose, or the first poses of a path and their joints."""
    tables = motion_tables(predictions, MAX_POSES)
    titles = ["Joints at the target"]
    if predictions.line and predictions.poses[0].reason:
        titles = ["Joints at the furthest pose on the way to the target"]
    elif not predictions.line and tables:
        count = len(tables[0]) - 1
        titles = [
            f"Poses of the path: {count} of {len(predictions.poses)}",
            "Joints at these poses",
        ]
    firsts = [2] if predictions.line else [1, 2]
    sections = zip(titles, tables, firsts, strict=False)
    return "\n".join(_section(title, table, first) for title, table, first in sections)


def _section(title: str, table: Sequence[Sequence[str]], first: int) -> str:
    """Render a table under its title; columns from index ``first`` on hold numbers."""
    head, *lines = table
    cells = [
        [escape(name), *(x.strip().replace("-", "−") for x in rest)] for name, *rest in lines
    ]
    body = html_table([escape(x) for x in head], cells, range(first, len(head)))
    return f'<section>\n<h2>{title}</h2>\n<div class="scroll wide">\n{body}\n</div>\n</section>'


def _legend(panels: Sequence[Curves]) -> str:
    """Render the legend of lines and shades as list items."""
    count = len(panels[0].errors)
    marks = [(f"order {k}", colour, "") for k, colour in enumerate(_colours(count), 1)]
    marks.append((f"order {count}, estimated", WARM, "2 3"))
    if any(panel.closed for panel in panels):
        marks.append(("the loops close no further", INK, ""))
    if panels[0].target is not None:
        marks.append(("target", INK, "5 3"))
    items = [
        f'<svg width="24" height="10" aria-hidden="true" data-ink="{colour}"><path '
        f'd="M0 5h24" fill="none" stroke="currentColor" stroke-width="2" '
        f'stroke-dasharray="{dash}"/></svg>{name}'
        for name, colour, dash in marks
    ]
    if any(panel.beyond for panel in panels):
        items.append(
            f'<svg width="24" height="10" aria-hidden="true" data-ink="{SHADE}"><rect '
            f'width="24" height="10" fill="currentColor"/></svg>beyond the radius'
        )
    return "\n".join(f"<li>{item}</li>" for item in items)


def _figure(panel: Curves, axis: str, limits: tuple[float, float]) -> dict[str, object]:
    """Build traces and layout of one chart."""
    x, colours = short(panel.x), _colours(len(panel.errors))
    lines = enumerate(zip(panel.errors, colours, strict=True), 1)
    kinds = [(f"order {k}", line, colour, "solid") for k, (line, colour) in lines]
    kinds.append(("estimated", panel.estimate, WARM, "dot"))
    traces = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "showlegend": False,
            "x": x,
            "y": short(line),
            "line": {"color": colour, "dash": dash, "width": 1.6},
        }
        for name, line, colour, dash in kinds
    ]
    solid, dashed = ({"color": INK, "width": 1.5, "dash": dash} for dash in ("solid", "dash"))
    shapes = [_shape("rect", a, b, fillcolor=SHADE, layer="below") for a, b in panel.beyond]
    shapes += [_shape("line", a, a, line=solid) for a in panel.closed]
    if panel.target is not None:
        shapes.append(_shape("line", panel.target, panel.target, line=dashed))
    layout = {
        "hovermode": "x",
        "title": {"text": panel.title},
        "xaxis": {"title": {"text": axis}},
        "yaxis": {
            "title": {"text": "error"},
            "type": "log",
            "range": np.log10(limits).tolist(),
        },
        "shapes": shapes,
    }
    return {"data": traces, "layout": layout}


def _shape(kind: str, first: float, last: float, **style: object) -> dict[str, object]:
    """Build a shape that spans the panel from bottom to top."""
    return {"type": kind, "x0": first, "x1": last, **style}


class _Run(NamedTuple):
    """Poses one after the other.

    Attributes:
        label: name of the run.
        axis: what ``x`` is.
        x: place of each pose (N,).
        q: positions of all joints that close the loops (N, n).
        predicted: the same by the series (N, n).
    """

    label: str
    axis: str
    x: Array
    q: Array
    predicted: Array


def _motion_runs(predictions: Predictions) -> dict[str, Any]:
    """Collect what the page of a Taylor motion moves: the scene, the tool, and the runs.

    A run is the way to the target, the path, or a line along each coordinate of the motion.
    """
    linkage = predictions.linkage
    tool_joints = tool_coordinates(predictions.tool) if predictions.tool else ()
    return {
        "scene": scene(linkage, unseen=tool_joints),
        "tool": _tool(predictions),
        "runs": [
            {
                "label": run.label,
                "x": short(run.x),
                "q": [short(q) for q in run.q],
                "chart": _chart(predictions, run),
            }
            for run in _runs(predictions)
            if len(run.x) > 1
        ],
    }


def _tool(predictions: Predictions) -> dict[str, Any] | None:
    """Place the moving point of the tool at the reference pose; None without a tool."""
    place = predictions.linkage.places.get(predictions.tool or "")
    if place is None:
        return None
    chain = predictions.linkage.spatial_chain
    part = rigid_parts(chain.parent.size, chain.ends)
    point = np.zeros(3) if predictions.point is None else np.asarray(predictions.point)
    return {
        "name": predictions.tool,
        "part": int(part[place.link]),
        "point": (place.pose[:3, :3] @ point + place.pose[:3, 3]).tolist(),
    }


def _runs(predictions: Predictions) -> list[_Run]:
    """List the runs of a page."""
    motion = predictions.motion
    if predictions.poses and not predictions.line:
        poses = [pose for pose in predictions.poses if pose.corrected is not None]
        poses = poses[:: -(-len(poses) // PATH_POSES) or 1]
        corrected = [pose.corrected for pose in poses]
        predicted = [
            np.full(len(motion.joints), np.nan) if pose.predicted is None else pose.predicted
            for pose in poses
        ]
        x = np.arange(1.0, len(poses) + 1.0)
        return [_Run("the path", "pose", x, np.array(corrected), np.array(predicted))]
    if predictions.line and predictions.poses[0].distance > 0.0:
        pose = predictions.poses[0]
        shares = np.linspace(0.0, pose.share, LINE_POSES)
        return [_line(predictions, "the way to the target", "part of the way", shares, pose.y)]
    far = RADII * motion.radius if np.isfinite(motion.radius) else WITHOUT_RADIUS
    x = np.linspace(-far, far, LINE_POSES)
    count = min(motion.scales.size, MAX_LINES)
    return [
        _line(
            predictions,
            f"coordinate {k + 1}",
            "distance",
            x,
            motion.scales * np.eye(len(motion.scales))[k],
        )
        for k in range(count)
    ]


def _line(predictions: Predictions, label: str, axis: str, x: Array, y: Array) -> _Run:
    """Compute the poses on a straight line, as far as the loops close."""
    motion = predictions.motion
    kept, q = [], []
    for value in x:
        try:
            q.append(motion.polish(value * y))
        except UnreachedError:
            continue
        kept.append(value)
    predicted = [motion.evaluate(value * y) for value in kept]
    return _Run(label, axis, np.array(kept), np.array(q), np.array(predicted))


def _chart(predictions: Predictions, run: _Run) -> dict[str, Any]:
    """Build the curves of the joints that move most, and of the series beside them."""
    units = np.array(predictions.units)
    traces: list[dict[str, Any]] = []
    layout: dict[str, Any] = {
        "hovermode": "x",
        "showlegend": True,
        "xaxis": {"title": {"text": run.axis}},
    }
    shown = [unit for unit in ("rad", "m") if unit in units]
    for row, unit in enumerate(shown):
        mark = str(row + 1) if row else ""
        reach = np.where(units == unit, np.ptp(run.q, axis=0), -1.0)
        ranks = rank_least_first((-reach).tolist())
        most = sorted(ranks[: min(MAX_LINES, int((units == unit).sum()))])
        values = run.q[:, most]
        low, high = float(values.min()), float(values.max())
        margin = 0.08 * (high - low) or 1.0
        layout[f"yaxis{mark}"] = {
            "domain": [1.0 - (row + 1) / len(shown), 1.0 - row / len(shown)],
            "title": {"text": f"joints ({unit})"},
            "range": [low - margin, high + margin],
        }
        for colour, j in zip(COLOURS, most, strict=False):
            line = {"color": colour, "width": 1.8}
            name = predictions.motion.joints[j]
            axis = {"type": "scatter", "mode": "lines", "x": short(run.x), "yaxis": f"y{mark}"}
            traces += [
                {**axis, "name": name, "y": short(run.q[:, j]), "line": line},
                {
                    **axis,
                    "name": f"{name}, series",
                    "y": short(run.predicted[:, j]),
                    "line": line | {"dash": "dot", "width": 1.2},
                    "showlegend": False,
                },
            ]
    return {"data": traces, "layout": layout}
