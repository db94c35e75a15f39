"""HTML page of flexible links: a linkage that bends, and its shaking over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.render import facts_list, render_page
from balance.app.answers.html.time_panels import COLOURS
from balance.app.answers.text.flexible import flexible_motion_facts
from balance.motion.flexible.flex_data import moment_about, motion_data
from balance.motion.flexible.from_linkage import FlexibleLinkage
from balance.motion.flexible.linkage_motion import FlexibleSimulation
from balance.motion.flexible.simulate import FlexibleMotion

Array = NDArray[np.float64]

FRAMES = 151
"""Most poses of the animation."""


def flexible_page(simulation: FlexibleSimulation) -> str:
    """Render a simulation as one HTML file, in which the beams bend.

    Returns:
        The text of the file; the element ``report`` contains `motion_data`.
    """
    linkage, motion = simulation.flexible, simulation.motion
    return render_page(
        "flexible.html",
        title=linkage.linkage.name,
        summary="A linkage with links that bend, and the force and moment with which it shakes "
        "its mount.",
        report=motion_data(linkage, motion),
        data={"figures": [_figure(linkage, motion)], "frames": _frames(linkage, motion)},
        scripts=("curves", "bend"),
        facts=facts_list(flexible_motion_facts(linkage, motion)),
    )


def _figure(linkage: FlexibleLinkage, motion: FlexibleMotion) -> dict[str, Any]:
    """Build the curves of shaking force and moment."""
    times = short(motion.times)
    lines = {
        "force along x (N)": motion.force[:, 0],
        "force along y (N)": motion.force[:, 1],
        "moment (N m)": moment_about(motion, linkage.point),
    }
    curves = [
        {
            "name": name,
            "x": times,
            "y": short(values),
            "mode": "lines",
            "type": "scatter",
            "yaxis": "y2" if k == 2 else "y",
            "line": {"color": COLOURS[k], "width": 1.5},
        }
        for k, (name, values) in enumerate(lines.items())
    ]
    axes = {
        "xaxis": {"title": {"text": "time (s)"}},
        "yaxis": {"title": {"text": "force (N)"}, "domain": [0.55, 1.0]},
        "yaxis2": {"title": {"text": "moment (N m)"}, "domain": [0.0, 0.45]},
    }
    layout = {**axes, "hovermode": "x", "height": 480, "showlegend": True}
    return {"data": curves, "layout": layout}


def _frames(linkage: FlexibleLinkage, motion: FlexibleMotion) -> Mapping[str, object]:
    """Build the poses of the animation: lines of rigid links, straight and bent beams.

    A bent beam is drawn exaggerated between ``straight`` and ``bent``, which the page does.
    """
    step = max(1, int(np.ceil(len(motion.times) / FRAMES)))
    chosen = range(0, len(motion.times), step)
    mechanism = motion.mechanism
    grounds = [
        mechanism.locate(end, motion.positions[0])
        for joint in mechanism.joints
        for end in (joint.first, joint.second)
        if end.part < 0
    ]
    beams = [k for k, part in enumerate(mechanism.parts) if part.size]
    rigid = {
        k: _star(linkage, k, motion.positions[list(chosen)])
        for k in linkage.outlines
        if len(linkage.outlines[k]) > 2
    }
    return {
        "times": short(motion.times[::step]),
        "grounds": [short(point) for point in grounds],
        "links": [
            [[short(point) for point in points] for points in frames]
            for frames in rigid.values()
        ],
        "straight": [_beam_lines(motion, k, chosen, 0.0) for k in beams],
        "bent": [_beam_lines(motion, k, chosen, 1.0) for k in beams],
    }


def _star(linkage: FlexibleLinkage, k: int, positions: Array) -> Array:
    """Compute the points of a rigid part over time (t, points, 2), its centre last."""
    at = linkage.mechanism.slices[k]
    points = np.array([marker.at for marker in linkage.outlines[k]])
    x, y, angle = positions[:, at].T[:3]
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack(
        [
            x[:, None] + c * points[:, 0] - s * points[:, 1],
            y[:, None] + s * points[:, 0] + c * points[:, 1],
        ],
        axis=-1,
    )


def _beam_lines(
    motion: FlexibleMotion, k: int, chosen: Sequence[int], part: float
) -> list[list[list[float | None]]]:
    """Compute the line of a beam over time, deformed by a part of its deformation."""
    body, at = motion.mechanism.parts[k], motion.mechanism.slices[k]
    outline = body.outline  # type: ignore[attr-defined]
    across, rest = (
        np.array([getattr(marker, name) for marker in outline]) for name in ("across", "at")
    )
    lines = []
    for i in chosen:
        p = motion.positions[i, at]
        c, s = np.cos(p[2]), np.sin(p[2])
        lx, ly = rest[:, 0], rest[:, 1] + part * (across @ p[3:])
        points = np.column_stack([p[0] + c * lx - s * ly, p[1] + s * lx + c * ly])
        lines.append([short(point) for point in points])
    return lines
