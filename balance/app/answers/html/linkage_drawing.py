"""Drawings of linkages in SVG, small and without a background, for pages.

Colours can be read on white and on black. A linkage in the plane is seen along its normal, one
in space obliquely from above.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np

from balance.app.answers.html.scene import scene
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Room around a drawing, at its sides if there are names, and above and below more elements.
PAD, SIDE, WIDE = 34, 90, 66
# Directions of the drawing of a linkage in space.
OBLIQUE = np.array([[0.866, -0.5, 0.0], [0.25, 0.433, 0.866]])
LINK, MARKED, INK = "#4f86c0", "#d06a10", "#7c858d"
# Least area of a plate, square pixels: a smaller one is drawn as a line.
LEAST_AREA = 60.0
# Least radius of a ball, pixels.
LEAST_RADIUS = 2.0
# Half coils of a spring, and half its width, pixels.
COILS, COIL_WIDTH = 14, 4.0
# Directions from the middle of a ball to its ends.
OUTWARD = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])


class Placement(NamedTuple):
    """Where the parts of a drawing are.

    Attributes:
        place: puts points (N, 3) in the inertial frame, metres, into the drawing, pixels.
        parts: the rigid parts of `scene`, the ground first.
        corners: their corners (N, 2) in the drawing.
        feet: points (2,) below which the ground is drawn.
    """

    place: Callable[[Array], Array]
    parts: Sequence[dict[str, Any]]
    corners: Sequence[Array]
    feet: Sequence[Array]


def linkage_drawing(
    linkage: Linkage,
    size: tuple[int, int] = (480, 300),
    names: bool = True,
    marked: Collection[str] = (),
    balls: Sequence[tuple[Array, float]] = (),
    over: Callable[[Placement], Sequence[str]] | None = None,
    springs: Sequence[Array] = (),
) -> str:
    """Draw a linkage at its reference pose.

    Args:
        linkage: the linkage.
        size: width and height, pixels.
        names: whether to name its bodies and its inputs.
        marked: bodies to draw in a second colour.
        balls: middles (3,) and radii of balls to draw in scale, metres, in that colour.
        over: draws more elements over it, with room for them at all sides.
        springs: both ends (2, 3) of each, metres, drawn in that colour.

    Returns:
        An SVG element.
    """
    drawing: Any = scene(linkage)
    rows = _upright(np.array(drawing["axes"][2])) if drawing["planar"] else OBLIQUE
    corners = [np.array(part["corners"]).reshape(-1, 3) for part in drawing["parts"]]
    points = np.array([joint["point"] for joint in drawing["joints"]])
    pad = np.array([SIDE if names else PAD, PAD]) if over is None else np.array([SIDE, WIDE])
    ends = [(np.asarray(p) @ rows.T)[None] + r * OUTWARD for p, r in balls]
    seen = np.concatenate([*corners, points, *springs]) @ rows.T
    place = _placed(np.concatenate([seen, *ends]), size, pad)
    at = [place(part @ rows.T) for part in corners]
    elements = [
        _link(points, MARKED if set(part["names"]) & set(marked) else LINK)
        for part, points in zip(drawing["parts"][1:], at[1:], strict=True)
        if len(points)
    ]
    sliding = [joint["point"] for joint in drawing["joints"] if joint["kind"] == "prismatic"]
    rails = place(np.array(sliding).reshape(-1, 3) @ rows.T)
    standing = [foot for foot in at[0] if not np.isclose(rails, foot, atol=0.5).all(1).any()]
    elements += map(draw_ground, standing)
    elements += [_joint(joint, place, rows, drawing) for joint in drawing["joints"]]
    elements += [_ball(place(end)) for end in ends]
    elements += [_spring(*place(np.asarray(pair) @ rows.T)) for pair in springs]
    if names:
        elements += _names(drawing, at, place(points @ rows.T), linkage.inputs)
    if over is not None:
        elements += over(Placement(lambda p: place(p @ rows.T), drawing["parts"], at, standing))
    width, height = size
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}">\n' + "\n".join(elements) + "\n</svg>\n"
    )


def _spring(start: Array, end: Array) -> str:
    """Draw a spring as a zigzag between two points, with a foot at its first end."""
    along = (end - start) / COILS
    across = COIL_WIDTH * np.array([-along[1], along[0]]) / (np.linalg.norm(along) or 1.0)
    turns = [
        start + (k + 0.5) * along + (across if k % 2 else -across) for k in range(1, COILS - 1)
    ]
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in [start, *turns, end])
    return (
        f'<polyline class="spring" points="{points}" fill="none" stroke="{MARKED}" '
        'stroke-width="1.5"/>' + draw_ground(start)
    )


def _upright(normal: Array) -> Array:
    """Return the directions to the right and up in a plane; up is z, or y in the x-y plane."""
    lying = abs(normal[2]) > 0.9
    up = np.array([0.0, 1.0, 0.0] if lying else [0.0, 0.0, 1.0])
    if normal[2] < 0.0 if lying else normal[0] - normal[1] < 0.0:
        normal = -normal
    up = up - (up @ normal) * normal
    up /= np.sqrt(up @ up)
    return np.array([np.cross(up, normal), up])


def _placed(seen: Array, size: tuple[int, int], pad: Array) -> Any:
    """Return the function that puts points (N, 2) into the frame, y down, as large as fits."""
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = np.array(size) - 2.0 * pad
    span = high - low
    scale = float(np.min(room / np.maximum(span, 1e-9 * max(float(span.max()), 1e-9))))
    middle = (low + high) / 2

    def place(points: Array) -> Array:
        return np.array(size) / 2 + (points - middle) * scale * np.array([1.0, -1.0])

    return place


def draw_path(points: Array, close: bool = False) -> str:
    """Write a path through points."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + "Z" * close


def _link(points: Array, colour: str) -> str:
    """Draw a link through its corners, around their middle."""
    wide = len(points) > 2 and _polygon_area(points) > LEAST_AREA
    fill = f"{colour}33" if wide else "none"
    return (
        f'<path d="{draw_path(points, wide)}" fill="{fill}" stroke="{colour}" '
        'stroke-width="4.5" stroke-linejoin="round" stroke-linecap="round"/>'
    )


def _polygon_area(points: Array) -> float:
    """Compute the area inside a polygon."""
    x, y = points.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def draw_ground(point: Array, colour: str = INK) -> str:
    """Draw the ground below a joint."""
    x, y = point
    foot = np.array([[x, y], [x - 8, y + 14], [x + 8, y + 14]])
    hatch = "".join(f"M{x + d:.1f} {y + 14:.1f}l-4 5" for d in (-6, 0, 6))
    d = draw_path(foot, True) + hatch
    return f'<path d="{d}" fill="none" stroke="{colour}" stroke-width="1.5"/>'


def _joint(joint: dict[str, Any], place: Any, rows: Array, drawing: dict[str, Any]) -> str:
    """Draw a joint: a circle if it turns, a block on its rail if it slides."""
    point = np.array(joint["point"])
    (x, y), (a, b) = place(
        np.array([point, point + 0.1 * drawing["size"] * np.array(joint["direction"])]) @ rows.T
    )
    if joint["kind"] != "prismatic":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{INK}"/>'
    angle = float(np.degrees(np.arctan2(b - y, a - x)))
    return (
        f'<g transform="translate({x:.1f} {y:.1f}) rotate({angle:.1f})" fill="none" '
        f'stroke="{INK}" stroke-width="1.5"><path d="M-26 7H26M-26 -7H26"/>'
        '<rect x="-10" y="-6" width="20" height="12"/></g>'
    )


def _ball(ends: Array) -> str:
    """Draw a ball from its ends to both sides, above and below."""
    x, y = ends.mean(axis=0)
    radius = max(0.5 * float(np.ptp(ends[:, 0])), LEAST_RADIUS)
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{MARKED}99" '
        f'stroke="{MARKED}"/>'
    )


def _names(
    drawing: dict[str, Any], at: Sequence[Array], joints: Array, inputs: Sequence[str]
) -> list[str]:
    """Write the names of bodies beside their links, and those of inputs at their joints."""
    elements = [
        _text(", ".join(part["names"]), corners.mean(axis=0), _name_place(corners), LINK)
        for part, corners in zip(drawing["parts"], at, strict=True)
        if part["names"] and len(corners)
    ]
    for joint, point in zip(drawing["joints"], joints, strict=True):
        if joint["name"] in inputs:
            off, anchor = (
                ((13.0, 15.0), "start") if 0 in joint["parts"] else ((-7.0, 17.0), "end")
            )
            elements.append(_text(joint["name"], point, (*off, anchor), INK))
    return elements


def _name_place(corners: Array) -> tuple[float, float, str]:
    """Choose where a name stands beside a line: the offset from its middle, and the anchor."""
    x, y = corners[-1] - corners[0]
    if abs(y) < 0.3 * abs(x):
        return 0.0, -9.0, "middle"
    if abs(x) < 0.3 * abs(y):
        return 8.0, 4.0, "start"
    return 7.0, (13.0 if x * y < 0.0 else -5.0), "start"


def _text(text: str, point: Array, beside: tuple[float, float, str], colour: str) -> str:
    """Write a text beside a point."""
    x, y, anchor = beside
    return (
        f'<text x="{point[0] + x:.1f}" y="{point[1] + y:.1f}" font-family="sans-serif" '
        f'font-size="13" text-anchor="{anchor}" fill="{colour}">{escape(text)}</text>'
    )
