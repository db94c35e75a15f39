"""Drawing of a linkage with the dimensions of its formulas, in SVG.

A dimension line is parallel to its distance, with arrows at both ends of a length and at the
end of a point. Lines and labels stand where they cover least of what is drawn before them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from html import escape
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from balance.app.answers.html.linkage_drawing import (
    INK,
    LINK,
    MARKED,
    Placement,
    linkage_drawing,
)
from balance.space.formulas.formula_data import Formulas
from balance.space.formulas.planar_parts import Dimension, PlanarParts
from balance.space.formulas.spatial_parts import SpatialParts
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least

SIZE = (820, 560)
# Width of a character over the size of the font, and sizes of the fonts, pixels.
WIDTH, FONT, SMALL = 0.58, 14, 11
# Half the side of the square that a point of a line covers; steps along a line, pixels.
COVERED, STEP = 3.0, 7.0
# Distances of dimension lines from what they measure, and of labels from their places.
AWAY = (17.0, 31.0, 45.0)
# A label costs this for each pixel of its distance, a line less, outside of the drawing more.
FAR, LINE_FAR, OUTSIDE = 10.0, 0.2, 50.0
# What it costs to cover a square pixel of a label.
ON_LABEL = 1000.0
# How far a subscript hangs below the other letters, pixels.
SUBSCRIPT = 4
# Steps by which labels stand away from their places, pixels.
STEPS = (0.0, 8.0, 18.0, 32.0, 48.0)
# Length of an arrow; below twice this it has no room.
ARROW = 7.0
# Angles around a place at which a label may stand.
AROUND = np.exp(0.25j * np.pi * np.arange(8))


class _Box(NamedTuple):
    """A rectangle that is covered: its middle and half its sides, pixels.

    The weight says how bad it is to cover it once more.
    """

    x: float
    y: float
    half_x: float
    half_y: float
    weight: float = 1.0


_NOTHING = _Box(0.0, 0.0, 0.0, 0.0, 0.0)


def dimension_drawing(formulas: Formulas) -> str:
    """Draw the linkage of formulas with its named dimensions, joints and links.

    Returns:
        An SVG element, in which a label of a dimension has its name as ``title``.
    """
    over = partial(_labels, _things(formulas))
    return linkage_drawing(formulas.linkage, SIZE, names=False, over=over)


def find_ends(parts: PlanarParts, index: int) -> tuple[complex, complex]:
    """Return the two points in the plane between which a dimension is, metres."""
    dimension = parts.dimensions[index]
    for joint in parts.joints:
        if joint.offset == index:
            first, second = (parts.parts[part] for part in joint.parts)
            along = ((second.origin - first.origin) / first.axis).real
            return first.origin + first.axis * along, second.origin
    part = parts.parts[dimension.part]
    value = dimension.value
    if dimension.kind == "offset":
        value = 1j * value.real
    return part.origin, part.origin + part.axis * value


class _Things(NamedTuple):
    """What is labelled, in points (3,) in the inertial frame, metres.

    Attributes:
        joints: letter, name, place, and whether it slides.
        dimensions: each with its two ends.
    """

    joints: list[tuple[str, str, Array, bool]]
    dimensions: list[tuple[Dimension, Array, Array]]


def _things(formulas: Formulas) -> _Things:
    """Find what is labelled, and where it is."""
    parts = formulas.parts
    if isinstance(parts, SpatialParts):
        joints = [(j.letter, j.name, j.place, j.kind == "prismatic") for j in parts.joints]
        return _Things(joints, list(dimension_lines(parts)))

    def point(z: complex) -> Array:
        return np.array([z.real, z.imag]) @ formulas.axes[:2]

    flat = [(j.letter, j.name, point(j.place), j.slides) for j in parts.joints]
    ends = [find_ends(parts, index) for index in range(len(parts.dimensions))]
    lines = [
        (dimension, point(a), point(b))
        for dimension, (a, b) in zip(parts.dimensions, ends, strict=True)
    ]
    return _Things(flat, lines)


def dimension_lines(parts: SpatialParts) -> Iterator[tuple[Dimension, Array, Array]]:
    """List the lengths of a linkage in space, each with its ends; angles have none."""
    for number, part in enumerate(parts.parts):
        for k, place in part.places.items():
            foot, end = parts.normal_ends(number, k)
            for index, a, b in ((place.along, part.origin, foot), (place.normal, foot, end)):
                if index is not None:
                    yield parts.dimensions[index], a, b
            constant, child = parts.joints[k].constant, parts.joints[k].parts[1]
            if constant is not None and parts.joints[k].kind == "revolute":
                yield parts.dimensions[constant], end, parts.parts[child].origin


def _labels(things: _Things, placement: Placement) -> list[str]:
    """Draw dimension lines, letters of joints and names of links."""

    def pixels(points: Sequence[Array]) -> list[complex]:
        seen = placement.place(np.array(points).reshape(-1, 3))
        return [complex(x, y) for x, y in seen]

    joints = pixels([place for _, _, place, _ in things.joints])
    covered = [_Box(z.real, z.imag, 7, 7) for z in joints]
    for z, (*_, slides) in zip(joints, things.joints, strict=True):
        covered += [_Box(z.real, z.imag, 24, 9)] * slides
    covered += [_Box(float(x), float(y) + 12, 11, 11, 3.0) for x, y in placement.feet]
    for corners in placement.corners[1:]:
        outline = [complex(x, y) for x, y in corners]
        for ends in pairwise([*outline, *outline[:1]] if len(outline) > 2 else outline):
            covered += _boxes_along(*ends, weight=3.0)
    elements, lines = [], []
    for dimension, start, end in things.dimensions:
        a, b = pixels([start, end])
        lines.append(_place_dimension_line(dimension, a, b, covered))
        elements += _drawn_line(dimension, a, b, *lines[-1])
    for z, (letter, name, _, _) in zip(joints, things.joints, strict=True):
        text = _text(letter, weight="bold", colour=INK, title=name)
        elements.append(_place_label([z], _width(letter), text, covered, near=12.0))
    for (dimension, _, _), ends in zip(things.dimensions, lines, strict=True):
        elements.append(_dimension_label(dimension, *ends, covered))
    named = zip(placement.parts[1:], placement.corners[1:], strict=True)
    for part, corners in sorted(named, key=lambda each: -len(each[1])):  # plates first
        if part["names"] and len(corners):
            name = ", ".join(part["names"])
            text = _text(escape(name), colour=LINK)
            first, last = corners[0] @ [1, 1j], corners[-1] @ [1, 1j]
            middle = complex(corners.mean(axis=0) @ [1, 1j])
            spots = [middle, *(first + t * (last - first) for t in (0.5, 0.35, 0.65))]
            elements.append(_place_label(spots, _width(name), text, covered, near=12.0))
    return elements


def _boxes_along(a: complex, b: complex, weight: float = 1.0) -> list[_Box]:
    """Cover a line with squares."""
    count = max(2, round(abs(b - a) / STEP))
    points = [a + (b - a) * t for t in np.linspace(0.0, 1.0, count)]
    return [_Box(z.real, z.imag, COVERED, COVERED, weight) for z in points]


def _costs(boxes: Sequence[_Box], covered: Sequence[_Box]) -> Array:
    """Compute for each box the area that it covers once more, and how far it is outside.

    An area counts with the weight of what is covered.
    """
    ours, others = np.array(boxes)[:, :, None], np.array(covered or [_NOTHING]).T
    shared = 1.0
    outside = 0.0
    for k, side in enumerate(SIZE):
        apart = np.abs(ours[:, k] - others[k])
        reach = np.minimum(ours[:, 2 + k] + others[2 + k] - apart, 2 * ours[:, 2 + k])
        shared = shared * np.maximum(reach, 0.0)
        beyond = np.abs(ours[:, k, 0] - side / 2) + ours[:, 2 + k, 0] - side / 2
        outside = outside + np.maximum(beyond, 0.0)
    return np.asarray(shared @ others[4] + OUTSIDE * outside)


def _place_dimension_line(
    dimension: Dimension, a: complex, b: complex, covered: list[_Box]
) -> tuple[complex, complex]:
    """Find the ends of a dimension line, beside what it measures."""
    length = abs(b - a)
    across = 1j * (b - a) / length if length else 1j
    lines = [(a + across * s * d, b + across * s * d) for d in AWAY for s in (1, -1)]
    if dimension.name.startswith("h_"):
        lines.insert(0, (a, b))  # it is drawn where it is, between two lines
    costs = [
        _costs(_boxes_along(*line), covered).sum() + LINE_FAR * abs(line[0] - a) * length / STEP
        for line in lines
    ]
    line = lines[first_least(costs, 1.0)]
    covered += _boxes_along(*line)
    return line


def _drawn_line(
    dimension: Dimension, a: complex, b: complex, p: complex, q: complex
) -> list[str]:
    """Draw a dimension line from p to q, and the lines to what it measures, from a to b."""
    thin = f'fill="none" stroke="{MARKED}" stroke-width="1"'
    arrows = "".join(_arrows(dimension, p, q))
    elements = [f'<path d="M{_at(p)}L{_at(q)}{arrows}" {thin}/>']
    if p != a:
        extension = f"M{_at(a)}L{_at(p)}M{_at(b)}L{_at(q)}"
        elements.append(f'<path d="{extension}" {thin} stroke-opacity="0.45"/>')
    return elements


def _dimension_label(dimension: Dimension, p: complex, q: complex, covered: list[_Box]) -> str:
    """Write the name of a dimension beside its line."""
    letter, _, rest = dimension.name.partition("_")
    text = _text(
        f'<tspan font-style="italic">{letter}</tspan>'
        f'<tspan dy="{SUBSCRIPT}" font-size="{SMALL}">{escape(rest)}</tspan>',
        colour=MARKED,
        title=dimension.name,
    )
    spots = [p + (q - p) * t for t in (0.5, 0.35, 0.65, 0.2, 0.8)]
    width = _width(letter) + WIDTH * SMALL * len(rest)
    return _place_label(spots, width, text, covered, near=9.0, hangs=SUBSCRIPT)


def _arrows(dimension: Dimension, p: complex, q: complex) -> Iterator[str]:
    """Draw the arrows of a dimension line that have room."""
    ends = [(q, p)] if dimension.kind == "point" else [(q, p), (p, q)]
    if abs(q - p) < 2 * ARROW:
        return
    for tip, tail in ends:
        back = ARROW * (tail - tip) / abs(tail - tip)
        sides = [tip + back * np.exp(1j * angle) for angle in (0.35, -0.35)]
        yield f"M{_at(sides[0])}L{_at(tip)}L{_at(sides[1])}"


def _at(z: complex) -> str:
    """Write a point."""
    return f"{z.real:.1f} {z.imag:.1f}"


def _width(text: str) -> float:
    """Estimate the width of a text, pixels."""
    return WIDTH * FONT * len(text)


def _text(words: str, colour: str, weight: str = "normal", title: str = "") -> str:
    """Write a text in SVG, with its place left open."""
    named = f"<title>{escape(title)}</title>" if title else ""
    return (
        f'<text x="{{x:.1f}}" y="{{y:.1f}}" font-family="sans-serif" font-size="{FONT}" '
        f'font-weight="{weight}" text-anchor="middle" fill="{colour}">{named}'
        f"{words.replace('{', '{{').replace('}', '}}')}</text>"
    )


def _place_label(
    spots: Sequence[complex],
    width: float,
    text: str,
    covered: list[_Box],
    near: float,
    hangs: float = 0.0,
) -> str:
    """Put a label beside one of several places, where it covers least, and no other label.

    Args:
        spots: the places.
        width: of the label, pixels.
        text: of the label, with its place left open.
        covered: what is drawn; the label is added.
        near: least distance from a place, pixels.
        hangs: how far a part of it hangs below the other letters, pixels.
    """
    half_x, half_y = width / 2 + 2, (FONT + hangs) / 2 + 1
    boxes, far = [], []
    for spot in spots:
        for step in STEPS:
            distance = near + step
            for turn in AROUND:
                off = turn.real * (distance - 4 + half_x), turn.imag * (distance + hangs / 2)
                boxes.append(_Box(spot.real + off[0], spot.imag + off[1], half_x, half_y))
                far.append(FAR * distance)
    costs = _costs(boxes, covered) + far
    box = boxes[first_least(costs.tolist(), 1.0)]
    covered.append(box._replace(weight=ON_LABEL))
    return text.format(x=box.x, y=box.y - hangs / 2 + 0.36 * FONT)
