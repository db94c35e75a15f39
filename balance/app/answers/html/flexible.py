"""HTML page of flexible links: a linkage that bends, and its shaking over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.render import facts_list, render_page
from balance.app.answers.html.time_panels import COLOURS
from balance.app.answers.text.flexible import flexible_motion_facts
from balance.motion.flexible.flex_data import beam_deflection, moment_about, motion_data
from balance.motion.flexible.from_linkage import FlexibleLinkage
from balance.motion.flexible.linkage_motion import FlexibleSimulation
from balance.motion.flexible.simulate import FlexibleMotion
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, unit_text

# Points of a line over time.
_Lines: TypeAlias = "list[list[list[float | None]]]"

FRAMES = 151
"""Most poses of the animation."""
SEEN = 0.1
"""Largest deformation of the drawing at first, of its larger side."""
LARGEST_EXPONENT = 9.0
"""Largest power of ten by which the deformation is multiplied."""
MARGIN = 0.12
"""Margin of the drawing, of its larger side."""


def flexible_page(simulation: FlexibleSimulation) -> str:
    """Render a simulation as one HTML file, in which the beams bend.

    Returns:
        The text of the file; the element ``report`` contains `motion_data`.
    """
    linkage, motion = simulation.flexible, simulation.motion
    return render_page(
        "flexible.html",
        title=linkage.linkage.name,
        summary=_summary(linkage, motion),
        report=motion_data(linkage, motion),
        data={"figures": [_figure(linkage, motion)], "frames": _frames(linkage, motion)},
        scripts=("curves", "bend"),
        facts=facts_list(flexible_motion_facts(linkage, motion)),
    )


def _summary(linkage: FlexibleLinkage, motion: FlexibleMotion) -> str:
    """Say how much the linkage shakes its mount, and how far its beams bend."""
    moment = float(np.abs(moment_about(motion, linkage.point)).max())
    bends = (
        f"{name} bends by "
        f"{number_text(1e3 * float(beam_deflection(motion, linkage, name).max()), '.3g')} mm"
        for name in linkage.beams
    )
    return (
        f"It shakes its mount with at most {unit_text(motion.peak_force, 'N', '.3g')} and "
        f"{unit_text(moment, 'N m', '.3g')}; {', '.join(bends)}."
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
            "showlegend": k < 2,
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
    layout = {**axes, "hovermode": "x", "showlegend": True}
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
    rigid = {k: _corners(linkage, k, motion.positions[list(chosen)]) for k in linkage.outlines}
    straight = [_beam_lines(motion, k, chosen, 0.0) for k in beams]
    bent = [_beam_lines(motion, k, chosen, 1.0) for k in beams]
    lines = [
        *(np.array(each, dtype=float).reshape(-1, 2) for each in (*straight, *bent)),
        *(points.reshape(-1, 2) for points in rigid.values()),
        np.array(grounds, dtype=float).reshape(-1, 2),
    ]
    return {
        "box": _box(np.concatenate(lines)),
        "exponent": _exponent(straight, bent),
        "times": short(motion.times[::step]),
        "grounds": [short(point) for point in grounds],
        "links": [
            [[short(point) for point in points] for points in frames]
            for frames in rigid.values()
        ],
        "straight": straight,
        "bent": bent,
    }


def _exponent(straight: Sequence[_Lines], bent: Sequence[_Lines]) -> float:
    """Choose by which power of ten the deformation is multiplied, so that it is seen."""
    pairs = [
        tuple(np.array(each) for each in pair) for pair in zip(straight, bent, strict=True)
    ]
    peak = max((float(np.abs(b - a).max()) for a, b in pairs), default=0.0)
    size = max((float(np.ptp(a.reshape(-1, 2), axis=0).max()) for a, _ in pairs), default=0.0)
    if not 0.0 < peak < SEEN * size:
        return 0.0
    return float(min(np.floor(2.0 * np.log10(SEEN * size / peak)) / 2.0, LARGEST_EXPONENT))


def _box(points: Array) -> list[list[float]]:
    """Compute the ranges of x and y of a motion, with a margin for what is exaggerated."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = MARGIN * float((high - low).max())
    return np.column_stack([low - margin, high + margin]).tolist()


def _corners(linkage: FlexibleLinkage, k: int, positions: Array) -> Array:
    """Compute the corners of a rigid part over time (t, corners, 2), in order around it."""
    at = linkage.mechanism.slices[k]
    points = np.array([marker.at for marker in linkage.outlines[k]])
    aside = points - points.mean(axis=0)
    points = points[np.argsort(np.arctan2(aside[:, 1], aside[:, 0]), kind="stable")]
    x, y, angle = positions[:, at].T[:3]
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack(
        [
            x[:, None] + c * points[:, 0] - s * points[:, 1],
            y[:, None] + s * points[:, 0] + c * points[:, 1],
        ],
        axis=-1,
    )


def _beam_lines(motion: FlexibleMotion, k: int, chosen: Sequence[int], part: float) -> _Lines:
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
