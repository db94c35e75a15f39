"""Pictures of a verification: inputs, shaking and bearing loads over time.

The first motion is shown, with a second linkage beside the first if there is one: as a
Matplotlib figure, or as a page of HTML that needs no network.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.verification.verdict import Verification
from balance.web import html
from balance.web.drawing import GRID, LAYOUT, image, short, tidy

__all__ = ["Panel", "panels", "picture", "webpage"]

Array = NDArray[np.float64]

# Most lines in one panel: further joints and inputs are left out, those of most load kept.
LINES = 6
# Joints whose forces differ by less than this part of the largest are shown as one.
SAME = 1e-6
# Dark on white, and apart in grey as well.
COLOURS = ("#0a5ea8", "#b8550a", "#1b1e22", "#7a9a2e", "#8a4f9e", "#5a8f99")
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
STYLES = ("-", "--", ":", "-.", (0, (8, 3)), (0, (8, 3, 2, 3)))


class Panel(NamedTuple):
    """Lines over time.

    Attributes:
        title: what they are, with its unit.
        names: name of each line.
        lines: values (lines, N).
        least: how far its axis reaches at least: what is smaller counts as nothing.
    """

    title: str
    names: tuple[str, ...]
    lines: Array
    least: float = 0.0


def panels(found: Verification) -> list[Panel]:
    """The panels of the first motion of a verification.

    Shaking loads are those of the linkage on its base, opposite to the base's reaction;
    moments are about the middle of the mechanism.
    """
    run, axes = found.runs[0], ("x", "y", "z")
    least = found.tolerance * found.scale
    names = found.linkage.inputs, tuple(joint.name for joint in found.linkage.joints)
    inputs = _largest(names[0], run.trajectory.u, range(len(names[0])))
    joints = _largest(names[1], run.bearing, _different(run.bearing))
    return [
        Panel("inputs (rad or m)", *inputs),
        Panel("shaking force (N)", axes, -run.middle[:, 3:].T, least),
        Panel("shaking moment (N m)", axes, -run.middle[:, :3].T, least * found.length),
        Panel("bearing force (N)", *joints),
    ]


def _different(forces: Array) -> list[int]:
    """Columns (N, n) without those that repeat one before: axes of one joint, massless rods."""
    kept: list[int] = []
    near = SAME * forces.max(initial=0.0)
    for k, column in enumerate(forces.T):
        if all(np.abs(column - forces[:, j]).max() > near for j in kept):
            kept.append(k)
    return kept


def _largest(
    names: Sequence[str], values: Array, among: Sequence[int]
) -> tuple[tuple[str, ...], Array]:
    """Names and lines of the columns (N, n) that reach farthest, in their order."""
    reach = np.abs(values).max(axis=0)
    chosen = sorted(sorted(among, key=lambda k: -reach[k])[:LINES])
    return tuple(names[k] for k in chosen), values[:, chosen].T


def _limits(row: Sequence[Panel]) -> tuple[float, float]:
    """Common ends of the axes of panels that stand side by side; zero is between them."""
    low = min(min(panel.lines.min(initial=0.0), -panel.least) for panel in row)
    high = max(max(panel.lines.max(initial=0.0), panel.least) for panel in row)
    margin = 0.05 * (high - low) or 1.0
    return float(low - margin), float(high + margin)


def picture(found: Sequence[Verification], kind: str = "png") -> bytes:
    """The panels as an image; several verifications side by side, with common scales.

    Args:
        found: one or more verifications.
        kind: ``"png"`` or ``"svg"``.

    Raises:
        PackageError: Matplotlib is missing.
    """
    columns = [panels(one) for one in found]

    def draw(figure: Any) -> None:
        axes = figure.subplots(len(columns[0]), len(found), sharex=True, sharey="row",
                               squeeze=False)  # fmt: skip
        for column, (one, shown) in enumerate(zip(found, columns, strict=True)):
            axes[0, column].set_title(_heading(one), loc="left", pad=16.0)
            axes[-1, column].set_xlabel("time (s)")
            for ax, panel in zip(axes[:, column], shown, strict=True):
                _draw(ax, one.runs[0].trajectory.time, panel)
        for ax, row in zip(axes[:, 0], zip(*columns, strict=True), strict=True):
            ax.set_ylabel(row[0].title)
            ax.set_ylim(_limits(row))

    return image((1.0 + 5.0 * len(found), 9.0), kind, draw)


def _draw(ax: Any, time: Array, panel: Panel) -> None:
    """One panel on Matplotlib axes."""
    for line, name, colour, style in zip(
        panel.lines, panel.names, COLOURS, STYLES, strict=False
    ):
        ax.plot(time, line, color=colour, linestyle=style, linewidth=1.2, label=name)
    tidy(ax)
    columns = LINES if max(map(len, panel.names), default=0) <= 4 else LINES // 2
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), fontsize=8, frameon=False,
              ncols=columns)  # fmt: skip


def _heading(found: Verification) -> str:
    """Name and verdict."""
    return f"{found.model}: {found.verdict}"


def webpage(found: Sequence[Verification]) -> str:
    """The verdicts and the panels as the text of one HTML file.

    Raises:
        LinkageError: Plotly is missing.
    """
    return html.render(
        "verify.html",
        title=" and ".join(one.model for one in found),
        summary=_summary(found),
        report=[one.to_dict() for one in found],
        data={"figures": _plotly(found)},
        scripts=["curves"],
        facts="\n".join(
            f"<section><h2>{escape(one.model)}</h2>{html.facts(one.facts())}</section>"
            for one in found
        ),
        curves="\n".join(
            f'<div class="traces" id="traces{k}" role="img" aria-label="Inputs, shaking force, '
            f'shaking moment and bearing forces of {escape(one.model)} over time"></div>'
            for k, one in enumerate(found)
        ),
    )


def _summary(found: Sequence[Verification]) -> str:
    """The verdicts in a sentence."""
    verdicts = "; ".join(_heading(one) for one in found)
    return f"Shaking force and moment over {len(found[0].runs)} motions. {verdicts}."


def _plotly(found: Sequence[Verification]) -> list[dict[str, object]]:
    """Traces and layout of Plotly for each linkage; panels of a row have one scale."""
    columns = [panels(one) for one in found]
    limits = [_limits(row) for row in zip(*columns, strict=True)]
    return [_figure(one, column, limits) for one, column in zip(found, columns, strict=True)]


def _figure(
    found: Verification, shown: Sequence[Panel], limits: Sequence[tuple[float, float]]
) -> dict[str, object]:
    """The panels of one linkage, one below the other, each with its legend above it."""
    time = short(found.runs[0].trajectory.time)
    traces: list[dict[str, object]] = []
    layout: dict[str, Any] = {
        "margin": {"l": 64, "r": 8, "t": 56, "b": 48},
        "hovermode": "x", **LAYOUT,
        "title": {"text": escape(_heading(found)), "x": 0.0, "font": {"size": 16}},
        "xaxis": {"title": {"text": "time (s)"}, "gridcolor": GRID,
                  "anchor": f"y{len(shown)}"},
    }  # fmt: skip
    for row, (panel, limit) in enumerate(zip(shown, limits, strict=True)):
        mark = str(row + 1) if row else ""
        top = 1.0 - row / len(shown)
        layout[f"yaxis{mark}"] = {
            "domain": [top - 0.78 / len(shown), top], "range": limit,
            "title": {"text": panel.title}, "gridcolor": GRID,
            "zerolinecolor": "#c9ced4", "exponentformat": "power",
        }  # fmt: skip
        layout[f"legend{mark}"] = {
            "orientation": "h", "x": 1.0, "xanchor": "right", "y": top, "yanchor": "bottom",
        }  # fmt: skip
        lines = zip(panel.names, panel.lines, COLOURS, DASHES, strict=False)
        traces += [
            {
                "type": "scatter", "mode": "lines", "name": escape(name), "showlegend": True,
                "x": time, "y": short(line), "yaxis": f"y{mark}", "legend": f"legend{mark}",
                "line": {"color": colour, "dash": dash, "width": 1.5},
            }
            for name, line, colour, dash in lines
        ]  # fmt: skip
    return {"data": traces, "layout": layout}
