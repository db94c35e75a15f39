"""HTML page of a walk: the linkage deforms from step to step while a singular value falls."""

from __future__ import annotations

from typing import Any

import numpy as np

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.render import facts_list, render_page
from balance.app.answers.html.scene import scene
from balance.app.answers.text.watched_walk import walk_data, walk_facts
from balance.studies.discovery.to_linkage import joint_places, to_linkage
from balance.studies.discovery.watch import WatchedWalk
from kinematics.numerics.array_types import Array

# Lower end of the axis of singular values: round-off.
LOWEST = 1e-17
INK, SOFT, WARM = "#0a5ea8", "#8d97a3", "#b8550a"


def walk_page(walk: WatchedWalk) -> str:
    """Render a walk as one HTML file.

    Returns:
        The text of the file; the element ``report`` holds what ``discover walk --json`` prints.
    """
    report = walk_data(walk)
    return render_page(
        "walk.html",
        title=f"A walk: {report['topology']}, start {walk.start}",
        summary=_summary(report),
        report=report,
        data={"walk": _frames(walk)},
        scripts=["walk"],
        facts=facts_list(walk_facts(report)),
    )


def _summary(report: dict[str, Any]) -> str:
    """Summarise the page in one sentence."""
    if report["outcome"] == "special":
        return (
            f"From a random geometry to a special one, whose design space has "
            f"{report['nullity']} dimensions instead of {report['generic']}."
        )
    return f"From a random geometry; the walk ends: {report['outcome']}."


def _frames(walk: WatchedWalk) -> dict[str, Any]:
    """Collect the drawing at the start, and what changes from step to step."""
    topology, structure = walk.job.topology, walk.job.structure
    drawing = scene(to_linkage(topology, structure, walk.geometry))
    points = joint_places(topology, structure, walk.geometry)
    last = len(walk.ratios) - 1
    names = [str(k) for k in range(last + 1)]
    if walk.polished:
        names[-1] = "polished"
    return {
        "scene": drawing,
        "corners": _corners(drawing, points[-1], structure.origin.tolist()),
        "points": [short(frame.ravel()) for frame in points],
        "axes": [short(frame.ravel()) for frame in walk.geometry.axes],
        "names": names,
        "ratios": np.maximum(walk.ratios, 0.0).tolist(),
        "chart": _chart(walk),
    }


def _corners(drawing: dict[str, Any], points: Array, origin: list[int]) -> list[list[int]]:
    """List the joints at the corners of each part, around their middle at the end."""
    corners = []
    for p in range(len(drawing["parts"])):
        joints = [j for j, joint in enumerate(drawing["joints"]) if p in joint["parts"]]
        once = [
            j for k, j in enumerate(joints) if origin[j] not in [origin[i] for i in joints[:k]]
        ]
        off = points[once] - points[once].mean(axis=0)
        sides = np.linalg.svd(off, full_matrices=False)[2] if len(once) > 2 else np.eye(3)
        angles = np.arctan2(off @ sides[1], off @ sides[0])
        corners.append([once[k] for k in np.argsort(angles)] if len(once) > 2 else once)
    return corners


def _chart(walk: WatchedWalk) -> dict[str, Any]:
    """Build traces and layout of the singular values over the steps."""
    steps = list(range(len(walk.ratios)))
    lines = [("s_min / s_max", walk.ratios, INK, 2.5)]
    if walk.job.buildable:
        lines.append(("momentum of the best masses", walk.falling, WARM, 1.5))
    elif walk.kept > 0:
        lines.append(("the next larger one", walk.values[:, walk.kept - 1], SOFT, 1.5))
    traces = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": name,
            "x": steps[: len(y)],
            "y": np.maximum(y, LOWEST).tolist(),
            "line": {"color": color, "width": width},
            "marker": {"color": color, "size": 6},
        }
        for name, y, color, width in lines
    ]
    layout = {
        "hovermode": "x",
        "xaxis": {"title": {"text": "step"}},
        "yaxis": {
            "title": {"text": "over the largest"},
            "type": "log",
            "range": [float(np.log10(LOWEST)), 0.0],
        },
    }
    return {"data": traces, "layout": layout}
