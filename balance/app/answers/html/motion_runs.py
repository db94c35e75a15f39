"""Poses and joint curves of a Taylor motion, for its page."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.scene import scene
from balance.app.answers.html.time_panels import COLOURS, MAX_LINES
from balance.motion.taylor_poses.prediction import Predictions
from kinematics.errors import UnreachedError
from kinematics.model.chain import rigid_parts
from kinematics.numerics.linalg.ties import rank_least_first

Array = NDArray[np.float64]

# Poses of a run along a line, and most poses of a path.
LINE_POSES, PATH_POSES = 41, 201
# Length of a run along a coordinate, in radii of convergence, or without one.
RADII, WITHOUT_RADIUS = 0.9, 1.0


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


def motion_runs(predictions: Predictions) -> dict[str, Any]:
    """Collect what the page of a Taylor motion moves: the scene, the tool, and the runs.

    A run is the way to the target, the path, or a line along each coordinate of the motion.
    """
    linkage = predictions.linkage
    return {
        "scene": scene(linkage),
        "tool": _tool(predictions),
        "runs": [
            {"label": run.label, "x": short(run.x), "q": [short(q) for q in run.q],
             "chart": _chart(predictions, run)}
            for run in _runs(predictions) if len(run.x) > 1
        ],
    }  # fmt: skip


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
        predicted = [np.full(len(motion.joints), np.nan) if pose.predicted is None
                     else pose.predicted for pose in poses]  # fmt: skip
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
    layout: dict[str, Any] = {"hovermode": "x", "showlegend": True,
                              "xaxis": {"title": {"text": run.axis}}}  # fmt: skip
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
            "title": {"text": f"joints ({unit})"}, "range": [low - margin, high + margin],
        }  # fmt: skip
        for colour, j in zip(COLOURS, most, strict=False):
            line = {"color": colour, "width": 1.8}
            name = predictions.motion.joints[j]
            axis = {"type": "scatter", "mode": "lines", "x": short(run.x), "yaxis": f"y{mark}"}
            traces += [
                {**axis, "name": name, "y": short(run.q[:, j]), "line": line},
                {**axis, "name": f"{name}, series", "y": short(run.predicted[:, j]),
                 "line": line | {"dash": "dot", "width": 1.2}, "showlegend": False},
            ]  # fmt: skip
    return {"data": traces, "layout": layout}
