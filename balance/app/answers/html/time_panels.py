"""Columns of panels with curves over time, as an image or for a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from balance.app.answers.html.plot_style import image, short, tidy
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Most lines in one panel; joints and inputs of smaller size are left out.
MAX_LINES = 6
# Colours with contrast to white, distinguishable in grey.
COLOURS = ("#0a5ea8", "#b8550a", "#1b1e22", "#7a9a2e", "#8a4f9e", "#5a8f99")
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
STYLES = ("-", "--", ":", "-.", (0, (8, 3)), (0, (8, 3, 2, 3)))


def inputs_title(linkage: Linkage, what: str = "inputs", per: str = "") -> str:
    """Name a quantity of the inputs with its unit: ``speed (rad/s)``, ``inputs (rad or m)``.

    Args:
        what: the quantity.
        per: what its unit ends with.
    """
    slides = _sliding_inputs(linkage)
    units = ["rad"] * (not all(slides)) + ["m"] * any(slides)
    return f"{what} ({' or '.join(f'{unit}{per}' for unit in units)})"


def drives_title(linkage: Linkage) -> str:
    """Name the loads of the inputs with their units: ``torque (N m)``."""
    slides = _sliding_inputs(linkage)
    return ", ".join(["torque (N m)"] * (not all(slides)) + ["force (N)"] * any(slides))


def _sliding_inputs(linkage: Linkage) -> list[bool]:
    """Say which inputs slide."""
    return [name in linkage.sliding for name in linkage.inputs]


class Panel(NamedTuple):
    """Lines over time.

    Attributes:
        title: name of the quantity, with its unit.
        names: name of each line.
        lines: values (lines, N).
        least: least limit of the axis; smaller values count as zero.
    """

    title: str
    names: tuple[str, ...]
    lines: Array
    least: float = 0.0


class PanelColumn(NamedTuple):
    """Panels over one time.

    Attributes:
        heading: above them, on one line or two.
        time: seconds (N,).
        panels: from top to bottom.
    """

    heading: str
    time: Array
    panels: Sequence[Panel]


def panels_picture(columns: Sequence[PanelColumn], kind: str = "png") -> bytes:
    """Draw columns of panels side by side as an image; panels of a row have one scale.

    Args:
        columns: the columns, with equally many panels.
        kind: ``"png"`` or ``"svg"``.
    """
    rows = list(zip(*(column.panels for column in columns), strict=True))

    def draw(figure: Any) -> None:
        axes = figure.subplots(
            len(rows), len(columns), sharex=True, sharey="row", squeeze=False
        )
        for k, column in enumerate(columns):
            axes[0, k].set_title(column.heading, loc="left", pad=16.0)
            axes[-1, k].set_xlabel("time (s)")
            for ax, panel in zip(axes[:, k], column.panels, strict=True):
                _draw_panel(ax, column.time, panel)
        for ax, row in zip(axes[:, 0], rows, strict=True):
            ax.set_ylabel(row[0].title)
            ax.set_ylim(_axis_limits(row))

    return image((1.0 + 5.0 * len(columns), 9.0), kind, draw)


def _axis_limits(row: Sequence[Panel]) -> tuple[float, float]:
    """Compute the common axis limits of adjacent panels, which include zero."""
    low = min(min(panel.lines.min(initial=0.0), -panel.least) for panel in row)
    high = max(max(panel.lines.max(initial=0.0), panel.least) for panel in row)
    margin = 0.05 * (high - low) or 1.0
    return float(low - margin), float(high + margin)


def _draw_panel(ax: Any, time: Array, panel: Panel) -> None:
    """Draw one panel on Matplotlib axes."""
    for line, name, colour, style in zip(
        panel.lines, panel.names, COLOURS, STYLES, strict=False
    ):
        ax.plot(time, line, color=colour, linestyle=style, linewidth=1.2, label=name)
    tidy(ax)
    columns = MAX_LINES if max(map(len, panel.names), default=0) <= 4 else MAX_LINES // 2
    ax.legend(
        loc="lower right", bbox_to_anchor=(1.0, 0.98), fontsize=8, frameon=False, ncols=columns
    )


def panels_figures(columns: Sequence[PanelColumn]) -> list[dict[str, object]]:
    """Build traces and layout of a chart for each column; panels of a row have one scale."""
    rows = zip(*(column.panels for column in columns), strict=True)
    limits = [_axis_limits(row) for row in rows]
    return [_chart(column, limits) for column in columns]


def _chart(column: PanelColumn, limits: Sequence[tuple[float, float]]) -> dict[str, object]:
    """Build the panels of one linkage, one above the other, each with a legend."""
    time, count = short(column.time), len(column.panels)
    traces: list[dict[str, object]] = []
    layout: dict[str, Any] = {
        "hovermode": "x",
        "title": {"text": column.heading},
        "showlegend": True,
        "xaxis": {"title": {"text": "time (s)"}},
    }
    for row, (panel, limit) in enumerate(zip(column.panels, limits, strict=True)):
        mark = str(row + 1) if row else ""
        layout[f"yaxis{mark}"] = {
            "domain": [1.0 - (row + 1) / count, 1.0 - row / count],
            "range": limit,
            "title": {"text": panel.title},
        }
        lines = zip(panel.names, panel.lines, COLOURS, DASHES, strict=False)
        traces += [
            {
                "type": "scatter",
                "mode": "lines",
                "name": name,
                "x": time,
                "y": short(line),
                "yaxis": f"y{mark}",
                "line": {"color": colour, "dash": dash, "width": 1.5},
            }
            for name, line, colour, dash in lines
        ]
    return {"data": traces, "layout": layout}
