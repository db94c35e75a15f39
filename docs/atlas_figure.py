"""Figures of the atlas: a linkage as a small drawing in SVG."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.linkage_drawing import draw_ground, draw_path
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.to_linkage import joint_places
from balance.studies.discovery.topologies import Topology

Array = NDArray[np.float64]

WIDTH, HEIGHT, PAD = 360, 240, 34
# Directions of the drawing of a linkage in space.
OBLIQUE = np.array([[0.866, -0.5, 0.0], [0.25, 0.433, 0.866]])
# Colours that can be read on white and on black.
LINK, INK, PLATE = "#5b7fa6", "#7a8088", "#5b7fa633"


def member_figure(graph: Topology, structure: TopologyArrays, geometry: LaneGeometry) -> str:
    """Draw a linkage: links as lines or plates, joints as circles with their letters.

    Args:
        graph: its topology.
        structure: the arrays of the topology.
        geometry: the linkage, in one lane.
    """
    origin = structure.origin.tolist()
    sites = [origin.index(k) for k in range(len(graph.edges))]
    points = joint_places(graph, structure, geometry)[0, sites]
    seen = points[:, :2] if structure.planar else points @ OBLIQUE.T
    at = _fitted(seen)
    parts = [_link(at, graph.joints_of(link)) for link in range(1, graph.links)]
    ground = graph.joints_of(0)
    for k, (kind, _, _) in enumerate(graph.edges):
        if k in ground and kind != "P":
            parts.append(draw_ground(at[k], INK))
    for k, (kind, _, _) in enumerate(graph.edges):
        parts.append(_slide(at[k], geometry, sites[k]) if kind == "P" else _joint(at[k], kind))
    parts += _letters(at, graph)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'width="{WIDTH}" height="{HEIGHT}">\n' + "\n".join(parts) + "\n</svg>\n"
    )


def _fitted(seen: Array) -> Array:
    """Scale points into the frame, y up."""
    low, high = seen.min(axis=0), seen.max(axis=0)
    span = np.maximum(high - low, 1e-9)
    scale = min((WIDTH - 2 * PAD) / span[0], (HEIGHT - 2 * PAD) / span[1])
    middle = (low + high) / 2
    return np.array([WIDTH / 2, HEIGHT / 2]) + (seen - middle) * scale * np.array([1.0, -1.0])


def _link(at: Array, joints: list[int]) -> str:
    """Draw a link through its joints, around their middle."""
    points = at[joints]
    if len(joints) > 2:
        off = points - points.mean(axis=0)
        points = points[np.argsort(np.arctan2(off[:, 1], off[:, 0]))]
    fill = PLATE if len(joints) > 2 else "none"
    return (
        f'<path d="{draw_path(points, len(joints) > 2)}" fill="{fill}" stroke="{LINK}" '
        'stroke-width="5" stroke-linejoin="round" stroke-linecap="round"/>'
    )


def _joint(point: Array, kind: str) -> str:
    """Draw a joint that turns; spherical and universal ones are filled."""
    x, y = point
    fill = "#fff" if kind == "R" else LINK
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{fill}" stroke="{INK}" '
        'stroke-width="1.5"/>'
    )


def _slide(point: Array, geometry: LaneGeometry, joint: int) -> str:
    """Draw a joint that slides: its rail, and a block beside the pin that it carries."""
    x, y = point
    angle = -np.degrees(np.arctan2(geometry.axes[0, joint, 1], geometry.axes[0, joint, 0]))
    return (
        f'<g transform="translate({x:.1f} {y:.1f}) rotate({angle:.1f})" fill="none" '
        f'stroke="{INK}" stroke-width="1.5"><path d="M-34 8H34M-34 -8H34"/>'
        '<rect x="-13" y="-7" width="26" height="14"/></g>'
    )


def _letters(at: Array, graph: Topology) -> list[str]:
    """Write the letters of the joints, away from the middle; those in one place together."""
    named: dict[tuple[float, float], list[int]] = {}
    for k, point in enumerate(at):
        named.setdefault((round(float(point[0]), 1), round(float(point[1]), 1)), []).append(k)
    middle, out = at.mean(axis=0), []
    for place, joints in named.items():
        off = np.array(place) - middle
        off = off / (np.sqrt(off @ off) or 1.0) * 15.0
        kinds = {graph.edges[k][0] for k in joints}
        if "P" in kinds:
            off = np.array([0.0, -30.0 if off[1] < 0 else 32.0])
        elif any(0 in graph.edges[k][1:] for k in joints):
            off = np.array([14.0 if off[0] >= 0 else -14.0, -3.0])
        x, y = place[0] + off[0], place[1] + off[1] + 4.5
        text = ", ".join(chr(65 + k) for k in joints)
        out.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-family="serif" font-size="14" '
            f'text-anchor="middle" fill="{INK}">{text}</text>'
        )
    return out
