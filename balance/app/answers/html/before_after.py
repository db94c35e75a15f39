"""Charts of the loads along motions before and after a change, on common axes."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.render import fill_template, rows_table
from balance.app.answers.html.time_panels import (
    DASHES,
    Panel,
    PanelColumn,
    drives_title,
    panels_figures,
)
from balance.app.answers.html.verification import (
    force_planes,
    motion_heading,
    pick_samples,
    polar_layout,
)
from balance.app.answers.text.verification import about_text
from balance.motion.verification.comparison import peak_change, round_off_of
from balance.motion.verification.harmonics import harmonic_peaks
from balance.motion.verification.verification import UNITS, Verification
from balance.support.change_text import change_text
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

# Colours of what was, and of what is.
BEFORE, AFTER = "#b8550a", "#0a5ea8"
# Most samples of a motion and most motions on a page, and most joints and inputs in a panel.
MAX_SAMPLES = 361
MAX_MOTIONS = 5
MAX_JOINTS = 3
# Harmonics that are drawn.
HARMONICS = 12


def comparison_charts(pair: Sequence[Verification], names: Sequence[str]) -> dict[str, Any]:
    """Build the charts of two verifications along the same motions.

    Args:
        pair: the verification before, and after.
        names: what they are, for legends.

    Returns:
        ``start``, the motion to show first, and ``motions``, each with its ``label``,
        ``number``, and the charts ``polar``, ``time`` and, of a crank that turns at constant
        speed, ``harmonics``.
    """
    before = pair[0]
    shown = _shaking_most(pair)
    return {
        "start": shown.index(before.plotted),
        "motions": [
            {
                "label": motion_heading(before, k),
                "number": k,
                "polar": _polar(pair, names, k),
                "time": _over_time(pair, names, k),
                "harmonics": _harmonics(pair, names, k),
            }
            for k in shown
        ],
    }


def comparison_section(pair: Sequence[Verification], names: Sequence[str]) -> str:
    """Render the places for the charts, and the table of the peaks of all motions."""
    return fill_template(
        "comparison.html",
        {
            "before": escape(names[0]),
            "after": escape(names[1]),
            "peaks": rows_table(_peak_rows(pair, names)),
            "about": about_text(pair[0]),
        },
    )


def _shaking_most(pair: Sequence[Verification]) -> list[int]:
    """List the motions that shake most before or after, in their order, and the plotted one."""
    count = min(len(check.runs) for check in pair)
    peaks = [
        max(
            max(check.runs[k].peak("force"), check.runs[k].peak("moment") / check.length)
            for check in pair
        )
        for k in range(count)
    ]
    return choose_motions(pair[0], peaks, MAX_MOTIONS)


def choose_motions(first: Verification, peaks: Sequence[float], most: int) -> list[int]:
    """Choose the plotted motion of a verification and those of the largest peaks, in order."""
    ranked = rank_least_first([-peak for peak in peaks], first.scale)
    ranked.sort(key=lambda k: k != first.plotted)
    return sorted(ranked[:most])


def _trace(name: str, x: Array, y: Array, state: int, **more: object) -> dict[str, object]:
    """Build a line in the colour of what was, or is."""
    line = {"color": (BEFORE, AFTER)[state], "width": 1.8, "dash": more.pop("dash", "solid")}
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": short(x),
        "y": short(y),
        "line": line,
        **more,
    }


def _polar(pair: Sequence[Verification], names: Sequence[str], k: int) -> dict[str, object]:
    """Build the polar plot of the shaking forces of one motion, both on one scale."""
    linkage = pair[0].linkage
    traces: list[dict[str, object]] = []
    reach = max(check.tolerance * check.scale for check in pair)
    for state, (check, name) in enumerate(zip(pair, names, strict=True)):
        run = check.runs[k]
        picked = pick_samples(run, MAX_SAMPLES)
        time, force = run.trajectory.time[picked], -run.about[picked, 3:]
        reach = max(reach, 1.05 * float(np.abs(force).max(initial=0.0)))
        for i, (plane, xy) in enumerate(force_planes(linkage, force)):
            label = f"{name}, {plane}" if plane else name
            traces.append(
                _trace(label, xy[:, 0], xy[:, 1], state, dash=DASHES[i], follows=short(time))
            )
    return {"data": traces, "layout": polar_layout(linkage, reach or 1.0)}


def _over_time(pair: Sequence[Verification], names: Sequence[str], k: int) -> dict[str, object]:
    """Build the panels of loads over time: shaking, drives and bearings of one motion."""
    runs = [check.runs[k] for check in pair]
    picked = [pick_samples(run, MAX_SAMPLES) for run in runs]
    least = max(check.tolerance * check.scale for check in pair)
    arm = max(check.length + check.lever for check in pair)
    panels = [
        ("shaking force (N)", [run.sizes("force")[:, None] for run in runs], [""], least),
        (
            "shaking moment (N m)",
            [run.sizes("moment")[:, None] for run in runs],
            [""],
            least * arm,
        ),
        (
            f"drive {drives_title(pair[0].linkage)}",
            *_largest([run.drive for run in runs], [check.linkage.inputs for check in pair]),
            0.0,
        ),
        (
            "bearing force (N)",
            *_largest(
                [run.bearing for run in runs],
                [[joint.name for joint in check.linkage.joints] for check in pair],
            ),
            0.0,
        ),
    ]
    # One scale for both, which are two columns of one row; the chart has all their lines.
    columns = [
        PanelColumn(
            "",
            runs[state].trajectory.time[picked[state]],
            [
                Panel(
                    title,
                    tuple(f"{names[state]} {label}".strip() for label in labels),
                    values[state][picked[state]].T,
                    floor,
                )
                for title, values, labels, floor in panels
            ],
        )
        for state in (0, 1)
    ]
    charts = panels_figures(columns)
    layout: Any = charts[0]["layout"]
    layout["title"] = {"text": ""}
    traces: list[dict[str, Any]] = []
    for state, chart in enumerate(charts):
        data: Any = chart["data"]
        for trace in data:
            trace["line"]["color"] = (BEFORE, AFTER)[state]
            traces.append(trace)
    return {"data": traces, "layout": layout}


def _largest(
    values: Sequence[Array], names: Sequence[Sequence[str]]
) -> tuple[list[Array], list[str]]:
    """Select the columns of the same joints with the largest values before or after."""
    shared = [name for name in names[0] if name in names[1]]
    columns = [
        array[:, [list(joints).index(name) for name in shared]]
        for array, joints in zip(values, names, strict=True)
    ]
    reach = np.max([np.abs(array).max(axis=0, initial=0.0) for array in columns], axis=0)
    ranked = rank_least_first([-size for size in reach.tolist()])
    chosen = sorted(ranked[:MAX_JOINTS])
    return [array[:, chosen] for array in columns], [shared[k] for k in chosen]


def _harmonics(
    pair: Sequence[Verification], names: Sequence[str], k: int
) -> dict[str, object] | None:
    """Build the harmonics of the loads over a revolution; None for other motions."""
    if any(check.crank is None or not check.crank.periodic for check in pair):
        return None
    traces: list[dict[str, object]] = []
    parts = (("force", slice(3, 6)), ("moment", slice(0, 3)))
    for row, (_, part) in enumerate(parts):
        for state, (check, name) in enumerate(zip(pair, names, strict=True)):
            sizes = harmonic_peaks(check.runs[k].about[:, part], HARMONICS)
            trace = _trace(name, np.arange(1.0, HARMONICS + 1.0), sizes, state)
            marker = {"color": (BEFORE, AFTER)[state], "size": 7}
            traces.append(
                {
                    **trace,
                    "mode": "lines+markers",
                    "marker": marker,
                    "yaxis": "y2" if row else "y",
                }
            )
    layout: dict[str, object] = {
        "hovermode": "x",
        "showlegend": True,
        "xaxis": {"title": {"text": "multiple of the speed"}, "range": [0.5, HARMONICS + 0.5]},
        "yaxis": {"title": {"text": "force (N)"}, "domain": [0.5, 1.0], "rangemode": "tozero"},
        "yaxis2": {
            "title": {"text": "moment (N m)"},
            "domain": [0.0, 0.5],
            "rangemode": "tozero",
        },
    }
    return {"data": traces, "layout": layout}


def _peak_rows(pair: Sequence[Verification], names: Sequence[str]) -> list[tuple[str, str]]:
    """Build the table of the peaks of all motions, its head first."""
    before, after = pair
    rows = [("peak", f"from {names[0]} to {names[1]}")]
    rows += [(f"shaking {part}", peak_change(pair, part)) for part in UNITS]
    earlier, later = before.drive_peaks, after.drive_peaks
    for name in (name for name in earlier if name in later):
        part = "force" if name in after.linkage.sliding else "moment"
        least = round_off_of(pair, part)
        text = change_text(earlier[name], later[name], UNITS[part], least)
        rows.append((f"drive {name}", text))
    joints = dict.fromkeys(filter(None, (check.most_loaded() for check in pair)))
    change = change_text(before.bearing, after.bearing, "N")
    where = f", in {' and then in '.join(joints)}" if joints else ""
    rows.append(("largest bearing force", f"{change}{where}"))
    return rows
