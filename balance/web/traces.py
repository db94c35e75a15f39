"""Pictures of a verification: inputs, shaking and bearing loads over time.

The first motion is shown, with a second linkage beside the first if there is one: as a
Matplotlib figure, or as a page of HTML that needs no network.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.verdict import Verification
from kinematics.errors import LinkageError

__all__ = ["FORMATS", "Panel", "panels", "picture", "webpage"]

Array = NDArray[np.float64]

FORMATS = ("png", "svg")
# Most lines in one panel: further joints and inputs are left out, those of most load kept.
LINES = 6
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
    """

    title: str
    names: tuple[str, ...]
    lines: Array


def panels(found: Verification) -> list[Panel]:
    """The panels of the first motion of a verification.

    Shaking loads are those of the linkage on its base, opposite to the base's reaction;
    moments are about the middle of the mechanism.
    """
    run = found.runs[0]
    u, bearing = run.trajectory.u, run.bearing
    wide = np.argsort(-np.abs(u).max(axis=0), kind="stable")[:LINES]
    heavy = np.argsort(-bearing.max(axis=0), kind="stable")[:LINES]
    rows = [(np.sort(wide), found.inputs, u), (np.sort(heavy), found.joints, bearing)]
    inputs, joints = (
        (tuple(names[k] for k in chosen), values[:, chosen].T) for chosen, names, values in rows
    )
    return [
        Panel("inputs (rad or m)", *inputs),
        Panel("shaking force (N)", ("x", "y", "z"), -run.middle[:, 3:].T),
        Panel("shaking moment (N m)", ("x", "y", "z"), -run.middle[:, :3].T),
        Panel("bearing force (N)", *joints),
    ]


def picture(found: Sequence[Verification], kind: str = "png") -> bytes:
    """The panels as an image; several verifications side by side, with common scales.

    Args:
        found: one or more verifications.
        kind: ``"png"`` or ``"svg"``.

    Raises:
        LinkageError: Matplotlib is missing.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError:
        raise LinkageError(
            "a picture needs Matplotlib, which is not installed; "
            "install it with 'pip install matplotlib'"
        ) from None
    columns = [panels(one) for one in found]
    with rc_context({"svg.hashsalt": "balance", "font.size": 9.0}):
        figure = Figure(figsize=(1.0 + 5.0 * len(found), 9.0), layout="constrained")
        axes = figure.subplots(len(columns[0]), len(found), sharex=True, sharey="row",
                               squeeze=False)  # fmt: skip
        for column, (one, shown) in enumerate(zip(found, columns, strict=True)):
            axes[0, column].set_title(_heading(one), loc="left", pad=16.0)
            axes[-1, column].set_xlabel("time (s)")
            for ax, panel in zip(axes[:, column], shown, strict=True):
                _draw(ax, one.runs[0].trajectory.time, panel)
        for ax, panel in zip(axes[:, 0], columns[0], strict=True):
            ax.set_ylabel(panel.title)
        file = BytesIO()
        undated = {"Date": None} if kind == "svg" else {}
        figure.savefig(file, format=kind, dpi=150, metadata=undated)
    return file.getvalue()


def _draw(ax: Any, time: Array, panel: Panel) -> None:
    """One panel on Matplotlib axes."""
    for line, name, colour, style in zip(
        panel.lines, panel.names, COLOURS, STYLES, strict=False
    ):
        ax.plot(time, line, color=colour, linestyle=style, linewidth=1.2, label=name)
    ax.grid(color="#e6e9ec", linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), fontsize=8, frameon=False, ncols=3)


def _heading(found: Verification) -> str:
    """Name and verdict."""
    return f"{found.model}: {found.verdict}"


def webpage(found: Sequence[Verification]) -> str:
    """The verdicts and the panels as the text of one HTML file.

    Raises:
        LinkageError: Plotly is missing.
    """
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise LinkageError(
            "a page needs Plotly, which is not installed; install it with 'pip install plotly'"
        ) from None
    parts = {
        "title": escape(" and ".join(one.model for one in found)),
        "summary": escape(_summary(found)),
        "facts": "\n".join(_facts(one) for one in found),
        "report": _json([one.to_dict() for one in found], indent=2),
        "figure": _json(_plotly(found)),
        "plotly": get_plotlyjs(),
        "style": _source("page.css"),
        "template": _source("verify.html"),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], parts["template"])


def _summary(found: Sequence[Verification]) -> str:
    """The verdicts in a sentence."""
    verdicts = "; ".join(_heading(one) for one in found)
    return f"Shaking force and moment over {len(found[0].runs)} motions. {verdicts}."


def _facts(found: Verification) -> str:
    """The facts of one verification as a section."""
    terms = "\n".join(
        f"<div><dt>{escape(label)}</dt><dd>{escape(value)}</dd></div>"
        for label, value in found.facts()
    )
    return f"<section><h2>{escape(found.model)}</h2><dl>\n{terms}\n</dl></section>"


def _source(name: str) -> str:
    """A file that the page is made of."""
    return files("balance").joinpath("web", name).read_text(encoding="utf-8")


def _json(data: object, indent: int | None = None) -> str:
    """JSON that may stand in a script element: no ``<`` can end it."""
    text = json.dumps(data, indent=indent, ensure_ascii=False, allow_nan=False)
    return text.replace("<", "\\u003c")


def _plotly(found: Sequence[Verification]) -> dict[str, object]:
    """Traces and layout of Plotly: a row for each panel, a column for each linkage."""
    traces: list[dict[str, object]] = []
    layout: dict[str, Any] = {
        "grid": {"rows": 4, "columns": len(found), "pattern": "independent", "ygap": 0.18},
        "margin": {"l": 80, "r": 20, "t": 40, "b": 50},
        "hovermode": "x", "plot_bgcolor": "#fff", "paper_bgcolor": "#fff",
        "font": {"family": "Charter, Liberation Serif, Georgia, serif", "color": "#1b1e22"},
        "legend": {"orientation": "h", "y": -0.06}, "annotations": [],
    }  # fmt: skip
    known = set()
    for column, one in enumerate(found):
        time = [float(f"{t:.6g}") for t in one.runs[0].trajectory.time]
        for row, panel in enumerate(panels(one)):
            number = row * len(found) + column + 1
            mark = "" if number == 1 else str(number)
            first = str(row * len(found) + 1) if row else ""
            layout[f"xaxis{mark}"] = {"matches": "x", "gridcolor": "#e6e9ec"}
            layout[f"yaxis{mark}"] = {
                "title": {"text": panel.title if column == 0 else ""},
                "matches": f"y{first}", "gridcolor": "#e6e9ec", "zerolinecolor": "#c9ced4",
                "exponentformat": "power",
            }  # fmt: skip
            for k, (name, line) in enumerate(zip(panel.names, panel.lines, strict=True)):
                what = panel.title.partition(" (")[0]
                traces.append({
                    "type": "scatter", "mode": "lines", "name": f"{what} {escape(name)}",
                    "x": time, "y": [float(f"{value:.6g}") for value in line],
                    "xaxis": f"x{mark}", "yaxis": f"y{mark}",
                    "showlegend": (row, name) not in known,
                    "legendgroup": f"{row}.{name}",
                    "line": {"color": COLOURS[k], "dash": DASHES[k], "width": 1.5},
                })  # fmt: skip
                known.add((row, name))
    for number in range(len(found)):
        layout[f"xaxis{3 * len(found) + number + 1}"]["title"] = {"text": "time (s)"}
    return {"data": traces, "layout": layout}
