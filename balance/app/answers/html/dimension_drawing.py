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
FAR, LINE_FAR, OUTSIDE = 0.6, 0.2, 50.0
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

    def overlap(self, other: _Box) -> float:
        """Compute the area in both, times the weight of the other."""
        x = min(self.half_x + other.half_x - abs(self.x - other.x), 2 * self.half_x)
        y = min(self.half_y + other.half_y - abs(self.y - other.y), 2 * self.half_y)
        return max(x, 0.0) * max(y, 0.0) * other.weight

    def outside(self) -> float:
        """Compute how far it reaches out of the drawing."""
        x = abs(self.x - SIZE[0] / 2) + self.half_x - SIZE[0] / 2
        y = abs(self.y - SIZE[1] / 2) + self.half_y - SIZE[1] / 2
        return max(x, 0.0) + max(y, 0.0)


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
    elements = []
    for dimension, start, end in things.dimensions:
        a, b = pixels([start, end])
        elements += _dimension(dimension, a, b, covered)
    for z, (letter, name, _, _) in zip(joints, things.joints, strict=True):
        text = _text(letter, weight="bold", colour=INK, title=name)
        elements.append(_beside([z], _width(letter), text, covered, near=12.0))
    for part, corners in zip(placement.parts[1:], placement.corners[1:], strict=True):
        if part["names"] and len(corners):
            name = ", ".join(part["names"])
            text = _text(escape(name), colour=LINK)
            ends = corners[0] @ [1, 1j], corners[-1] @ [1, 1j]
            middle = complex(corners.mean(axis=0) @ [1, 1j])
            spots = [middle, *(ends[0] + t * (ends[1] - ends[0]) for t in (0.5, 0.35, 0.65))]
            elements.append(_beside(spots, _width(name), text, covered, near=12.0))
    return elements


def _boxes_along(a: complex, b: complex, weight: float = 1.0) -> list[_Box]:
    """Cover a line with squares."""
    count = max(2, round(abs(b - a) / STEP))
    points = [a + (b - a) * t for t in np.linspace(0.0, 1.0, count)]
    return [_Box(z.real, z.imag, COVERED, COVERED, weight) for z in points]


def _cost(boxes: Sequence[_Box], covered: Sequence[_Box]) -> float:
    """Compute the area that boxes share with what is covered, and how far they are outside."""
    area = sum(box.overlap(other) for box in boxes for other in covered)
    return area + OUTSIDE * sum(box.outside() for box in boxes)


def _dimension(dimension: Dimension, a: complex, b: complex, covered: list[_Box]) -> list[str]:
    """Draw a dimension line and its label."""
    length = abs(b - a)
    across = 1j * (b - a) / length if length else 1j
    lines = [(a + across * s * d, b + across * s * d) for d in AWAY for s in (1, -1)]
    if dimension.name.startswith("h_"):
        lines.insert(0, (a, b))  # it is drawn where it is, between two lines
    costs = [
        _cost(_boxes_along(*line), covered) + LINE_FAR * abs(line[0] - a) * length / STEP
        for line in lines
    ]
    p, q = lines[first_least(costs, 1.0)]
    covered += _boxes_along(p, q)
    thin = f'fill="none" stroke="{MARKED}" stroke-width="1"'
    extension = f"M{_at(a)}L{_at(p)}M{_at(b)}L{_at(q)}" if p != a else ""
    elements = [
        f'<path d="M{_at(p)}L{_at(q)}{"".join(_arrows(dimension, p, q))}" {thin}/>',
        f'<path d="{extension}" {thin} stroke-opacity="0.45"/>' if extension else "",
    ]
    letter, _, rest = dimension.name.partition("_")
    text = _text(
        f'<tspan font-style="italic">{letter}</tspan>'
        f'<tspan dy="4" font-size="{SMALL}">{escape(rest)}</tspan>',
        colour=MARKED,
        title=dimension.name,
    )
    spots = [p + (q - p) * t for t in (0.5, 0.35, 0.65, 0.2, 0.8)]
    width = _width(letter) + WIDTH * SMALL * len(rest)
    elements.append(_beside(spots, width, text, covered, near=9.0))
    return [each for each in elements if each]


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


def _beside(
    spots: Sequence[complex], width: float, text: str, covered: list[_Box], near: float
) -> str:
    """Put a label beside one of several places, where it covers least."""
    half_x, half_y = width / 2 + 2, FONT / 2 + 1
    boxes, costs = [], []
    for spot in spots:
        for distance in (near, near + 8.0, near + 18.0):
            for turn in AROUND:
                off = turn.real * (distance - 4 + half_x), turn.imag * distance
                box = _Box(spot.real + off[0], spot.imag + off[1], half_x, half_y)
                boxes.append(box)
                costs.append(_cost([box], covered) + FAR * distance)
    box = boxes[first_least(costs, 1.0)]
    covered.append(box._replace(weight=4.0))
    return text.format(x=box.x, y=box.y + 0.36 * FONT)
