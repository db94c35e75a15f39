"""The motions of a verification as data for its page: poses, curves and numbers of each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.robot_shapes import robot_shapes
from balance.app.answers.html.scene import scene
from balance.app.answers.html.time_panels import COLOURS, DASHES, PanelColumn, panels_figures
from balance.app.answers.html.verification import motion_heading, panels
from balance.motion.verification.result import Verification
from balance.motion.verification.run import Run
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import number_text

Array = NDArray[np.float64]

# Most samples of a motion on a page, and most numbers of all its motions.
MAX_SAMPLES = 201
MAX_NUMBERS = 60_000
# Planes of the polar plot of a spatial linkage: two axes each.
PLANES = ((0, 1), (0, 2), (1, 2))


def motions_data(verifications: Sequence[Verification], meshes: bool) -> list[dict[str, Any]]:
    """Collect what the page of verifications draws: for each, its scene and its motions.

    Panels of one motion have one scale for all linkages. The motion that decides the verdict
    is there; of many motions, so are those that shake most.

    Args:
        verifications: one or more verifications.
        meshes: whether to collect the shapes of the files.
    """
    chosen = motion_choice(verifications)
    figures = [_figures(verifications, k) for k in chosen]
    return [
        {
            "name": verification.model,
            "scene": scene(
                verification.linkage,
                shapes=robot_shapes(verification.linkage) if meshes else (),
            ),
            "least": verification.tolerance * verification.scale,
            "runs": [
                _run_data(verification, verification.runs[k], charts[i])
                for k, charts in zip(chosen, figures, strict=True)
            ],
        }
        for i, verification in enumerate(verifications)
    ]


def motion_choice(verifications: Sequence[Verification]) -> list[int]:
    """List the indices of the motions on a page, in their order, with the plotted ones."""
    count = min(len(verification.runs) for verification in verifications)
    per_motion = sum(
        min(verification.runs[0].trajectory.time.size, MAX_SAMPLES)
        * (len(verification.linkage.joints) + 6 * len(panels(verification)))
        for verification in verifications
    )
    most = int(np.clip(MAX_NUMBERS // per_motion, 1, count))
    first = verifications[0]
    peaks = [
        max(run.peak("force"), run.peak("moment") / first.length) for run in first.runs[:count]
    ]
    ranked = rank_least_first([-peak for peak in peaks], first.scale)
    ranked.sort(key=lambda k: k != first.plotted)
    return sorted(ranked[:most])


def _figures(verifications: Sequence[Verification], number: int) -> list[dict[str, object]]:
    """Build the curves of one motion for each linkage."""
    columns = []
    for verification in verifications:
        picked = _picked(verification.runs[number])
        kept = [
            panel._replace(lines=panel.lines[:, picked])
            for panel in panels(verification, number)
        ]
        time = verification.runs[number].trajectory.time[picked]
        columns.append(PanelColumn(motion_heading(verification, number), time, kept))
    return panels_figures(columns)


def _picked(run: Run) -> NDArray[np.int64]:
    """Choose samples of a motion, at most `MAX_SAMPLES`, evenly."""
    size = run.trajectory.time.size
    return np.linspace(0, size - 1, min(size, MAX_SAMPLES)).round().astype(np.int64)


def _run_data(verification: Verification, run: Run, chart: dict[str, object]) -> dict[str, Any]:
    """Collect poses, curves and numbers of one motion of one linkage."""
    picked = _picked(run)
    force = -run.about[picked, 3:]
    return {
        "chart": chart,
        "polar": _polar(verification, short(run.trajectory.time[picked]), force),
        "time": short(run.trajectory.time[picked]),
        "q": [short(q) for q in run.trajectory.q[picked]],
        "force": [short(f) for f in force],
        "rows": _numbers(verification, run),
    }


def _polar(
    verification: Verification, time: list[float | None], force: Array
) -> dict[str, object]:
    """Build the polar plot of the shaking force: its direction and size over the motion."""
    linkage = verification.linkage
    if linkage.planar:
        lines = [("", force @ linkage.chain.frame.R[:2].T)]
        axes = ("force along the first axis (N)", "along the second axis (N)")
        if np.allclose(np.abs(linkage.chain.frame.R[:2, :2]), np.eye(2)):
            axes = ("force along x (N)", "force along y (N)")
    else:
        lines = [(f"{'xyz'[a]}, {'xyz'[b]}", force[:, [a, b]]) for a, b in PLANES]
        axes = ("first component of force (N)", "second component (N)")
    least = verification.tolerance * verification.scale
    reach = max(1.05 * float(np.abs(force).max(initial=0.0)), least) or 1.0
    traces = [
        {
            "type": "scatter", "mode": "lines", "name": name, "x": short(xy[:, 0]),
            "y": short(xy[:, 1]), "follows": time,
            "line": {"color": COLOURS[k], "dash": DASHES[k], "width": 1.6},
        }
        for k, (name, xy) in enumerate(lines)
    ]  # fmt: skip
    layout = {
        "polar": True, "xaxis": {"title": {"text": axes[0]}, "range": [-reach, reach]},
        "yaxis": {"title": {"text": axes[1]}, "range": [-reach, reach], "scaleanchor": "x"},
    }  # fmt: skip
    return {"data": traces, "layout": layout}


def _numbers(verification: Verification, run: Run) -> list[tuple[str, str]]:
    """List the peaks and the root mean squares of one motion."""
    rows = []
    for part in ("force", "moment"):
        rows.append((f"shaking {part}", verification.load_text(part, run.peak(part))))
        rows.append((f"shaking {part}, rms", verification.load_text(part, run.rms(part))))
    bearing = float(run.bearing.max(initial=0.0))
    rows.append(("bearing force", f"{number_text(bearing, '.3g')} N"))
    rows.append(("duration", f"{run.trajectory.duration:.4g} s"))
    return rows
