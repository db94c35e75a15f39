"""Plots of a verification: inputs, shaking loads and joint forces over time.

They show the motion that decides the verdict, with a second linkage next to the first one. The
output is a Matplotlib image, an HTML page that needs no network, or a table.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from html import escape
from io import StringIO
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.report.html.plot_style import GRID, LAYOUT, image, short, tidy
from balance.report.html.render import facts_list, render_page
from balance.report.text.verification import verification_facts
from balance.tolerances import FORCE_EQUAL_RELATIVE
from balance.verification.result import Run, Verification
from kinematics.wording import count_noun

__all__ = [
    "COLOURS", "Panel", "panels", "verification_page", "verification_picture",
    "verification_table",
]  # fmt: skip

Array = NDArray[np.float64]

# Most lines in one panel; joints and inputs of smaller size are left out.
MAX_LINES = 6
# Colours with contrast to white, distinguishable in grey.
COLOURS = ("#0a5ea8", "#b8550a", "#1b1e22", "#7a9a2e", "#8a4f9e", "#5a8f99")
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
STYLES = ("-", "--", ":", "-.", (0, (8, 3)), (0, (8, 3, 2, 3)))


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


def panels(found: Verification) -> list[Panel]:
    """Build the panels of the plotted motion of a verification.

    Shaking loads are those of the linkage on its base, opposite to the base reaction. Moments
    are about the middle of the mechanism.
    """
    run, axes = _plotted_run(found), ("x", "y", "z")
    least = found.tolerance * found.scale
    names = found.linkage.inputs, tuple(joint.name for joint in found.linkage.joints)
    inputs = _largest_columns(names[0], run.trajectory.u, range(len(names[0])))
    joints = _largest_columns(names[1], run.bearing, _distinct_columns(run.bearing))
    return [
        Panel("inputs (rad or m)", *inputs),
        Panel("shaking force (N)", axes, -run.middle[:, 3:].T, least),
        Panel("shaking moment (N m)", axes, -run.middle[:, :3].T, least * found.length),
        Panel("bearing force (N)", *joints),
    ]


def _plotted_run(found: Verification) -> Run:
    """Return the loads along the plotted motion."""
    return found.runs[found.plotted]


def verification_table(found: Verification) -> str:
    """Write the plotted motion as comma-separated values, one line per sample, SI units.

    Columns are ``time``, the inputs by name (displacements from the reference pose), and the
    shaking force and moment of the linkage on its base, in inertial axes, moments about the
    middle of the mechanism.
    """
    run = _plotted_run(found)
    axes = [f"{part}_{axis}" for part in ("force", "moment") for axis in "xyz"]
    loads = np.roll(-run.middle, 3, axis=1)
    rows = np.column_stack([run.trajectory.time, run.trajectory.u, loads]).tolist()
    text = StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *found.linkage.inputs, *axes])
    writer.writerows([[repr(value) for value in row] for row in rows])
    return text.getvalue()


def _distinct_columns(forces: Array) -> list[int]:
    """Select columns (N, n) that do not repeat an earlier one.

    Axes of one joint and joints of massless rods have equal forces.
    """
    kept: list[int] = []
    near = FORCE_EQUAL_RELATIVE * forces.max(initial=0.0)
    for k, column in enumerate(forces.T):
        if all(np.abs(column - forces[:, j]).max() > near for j in kept):
            kept.append(k)
    return kept


def _largest_columns(
    names: Sequence[str], values: Array, among: Sequence[int]
) -> tuple[tuple[str, ...], Array]:
    """Select the columns (N, n) of the largest values, in their order."""
    reach = np.abs(values).max(axis=0)
    chosen = sorted(sorted(among, key=lambda k: -reach[k])[:MAX_LINES])
    return tuple(names[k] for k in chosen), values[:, chosen].T


def _axis_limits(row: Sequence[Panel]) -> tuple[float, float]:
    """Compute the common axis limits of adjacent panels, which include zero."""
    low = min(min(panel.lines.min(initial=0.0), -panel.least) for panel in row)
    high = max(max(panel.lines.max(initial=0.0), panel.least) for panel in row)
    margin = 0.05 * (high - low) or 1.0
    return float(low - margin), float(high + margin)


def verification_picture(found: Sequence[Verification], kind: str = "png") -> bytes:
    """Draw the panels as an image; verifications are side by side with common scales.

    Args:
        found: one or more verifications.
        kind: ``"png"`` or ``"svg"``.

    Returns:
        The bytes of the image.

    Raises:
        PackageError: Matplotlib is missing.
    """
    columns, heads = [panels(one) for one in found], _headings(found)

    def draw(figure: Any) -> None:
        axes = figure.subplots(len(columns[0]), len(found), sharex=True, sharey="row",
                               squeeze=False)  # fmt: skip
        for column, (one, shown) in enumerate(zip(found, columns, strict=True)):
            axes[0, column].set_title(heads[column], loc="left", pad=16.0)
            axes[-1, column].set_xlabel("time (s)")
            for ax, panel in zip(axes[:, column], shown, strict=True):
                _draw_panel(ax, _plotted_run(one).trajectory.time, panel)
        for ax, row in zip(axes[:, 0], zip(*columns, strict=True), strict=True):
            ax.set_ylabel(row[0].title)
            ax.set_ylim(_axis_limits(row))

    return image((1.0 + 5.0 * len(found), 9.0), kind, draw)


def _draw_panel(ax: Any, time: Array, panel: Panel) -> None:
    """Draw one panel on Matplotlib axes."""
    for line, name, colour, style in zip(
        panel.lines, panel.names, COLOURS, STYLES, strict=False
    ):
        ax.plot(time, line, color=colour, linestyle=style, linewidth=1.2, label=name)
    tidy(ax)
    columns = MAX_LINES if max(map(len, panel.names), default=0) <= 4 else MAX_LINES // 2
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), fontsize=8, frameon=False,
              ncols=columns)  # fmt: skip


def _linkage_names(found: Sequence[Verification]) -> list[str]:
    """Return the name of each linkage, with its file if there are several."""
    if len(found) == 1:
        return [found[0].model]
    files = [PurePath(one.linkage.source).parts for one in found]
    longest = max(map(len, files))
    # Use as many folders as distinguish the files.
    tails = ([PurePath(*file[-k:]).as_posix() for file in files] for k in range(1, longest + 1))
    apart = next((tail for tail in tails if len({*tail}) == len(tail)), None)
    known = apart or [file[-1] for file in files]
    return [f"{one.model} ({file})" for one, file in zip(found, known, strict=True)]


def _headings(found: Sequence[Verification]) -> list[str]:
    """Build the heading of each linkage: name, verdict and plotted motion, on two lines."""
    return [
        f"{name}\n{one.verdict}, {_motion_text(one)}"
        for name, one in zip(_linkage_names(found), found, strict=True)
    ]


def _motion_text(found: Verification) -> str:
    """Describe the plotted motion."""
    if found.crank is not None:
        return f"{found.crank.joint} at {found.crank.rpm:.6g} rpm"
    return f"motion {found.plotted + 1} of {len(found.runs)}"


def verification_page(found: Sequence[Verification]) -> str:
    """Render verifications as one HTML file.

    Raises:
        PackageError: Plotly is missing.
    """
    names = _linkage_names(found)
    return render_page(
        "verify.html",
        title=" and ".join(names),
        summary=_summary(found),
        report=[one.to_dict() for one in found],
        data={"figures": _plotly_figures(found)},
        scripts=["curves"],
        facts="\n".join(
            f"<section><h2>{escape(name)}</h2>{facts_list(verification_facts(one))}</section>"
            for name, one in zip(names, found, strict=True)
        ),
        curves="\n".join(
            f'<div class="traces" id="traces{k}" role="img" aria-label="Inputs, shaking force, '
            f'shaking moment and bearing forces of {escape(name)} over time"></div>'
            for k, name in enumerate(names)
        ),
        motions=escape("; ".join(f"{name}: {_motion_text(one)}"
                                 for name, one in zip(names, found, strict=True))),
    )  # fmt: skip


def _summary(found: Sequence[Verification]) -> str:
    """Summarise the verdicts in one sentence."""
    first = found[0]
    verdicts = "; ".join(
        f"{name}: {one.verdict}" for name, one in zip(_linkage_names(found), found, strict=True)
    )
    if first.crank is not None:
        motions = f"one revolution of {first.crank.joint} at {first.crank.rpm:.6g} rpm"
    else:
        motions = count_noun(len(first.runs), "motion")
    return f"Shaking force and moment over {motions} ({first.duration:.4g} s). {verdicts}."


def _plotly_figures(found: Sequence[Verification]) -> list[dict[str, object]]:
    """Build traces and layout of Plotly for each linkage; panels of a row have one scale."""
    columns = [panels(one) for one in found]
    limits = [_axis_limits(row) for row in zip(*columns, strict=True)]
    parts = zip(found, _headings(found), columns, strict=True)
    return [_plotly_figure(one, heading, column, limits) for one, heading, column in parts]


def _plotly_figure(
    found: Verification,
    heading: str,
    shown: Sequence[Panel],
    limits: Sequence[tuple[float, float]],
) -> dict[str, object]:
    """Build the Plotly panels of one linkage, in one column, each with a legend above it."""
    time = short(_plotted_run(found).trajectory.time)
    traces: list[dict[str, object]] = []
    layout: dict[str, Any] = {
        "margin": {"l": 64, "r": 8, "t": 80, "b": 48},
        "hovermode": "x", **LAYOUT,
        "title": {
            "text": escape(heading).replace("\n", "<br>"), "x": 0.0, "font": {"size": 16}
        },
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
