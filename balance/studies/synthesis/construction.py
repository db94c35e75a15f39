"""Graphical construction of an RR chain through two positions, with ruler and compass.

With the fixed pivot G chosen: the pole P is where the perpendicular bisectors of two points of
the tool meet; the line through G and P, turned about P by ∓φ/2 and about G by ∓β/2, meets
itself in W_1 and W_2. With the moving pivot chosen: G is where the perpendicular bisector of
W_1 and W_2 meets the line through W_1 at π/2 - β/2 to the chord.

Source: G. Becht, MSc thesis, TU Delft, 2020, section 3.2 of chapter 3; its step 4 for a chosen
moving pivot prints ``δ = π/2 - β`` between that line and the bisector; it is β/2.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from balance.studies.synthesis.positions import displacements
from balance.studies.synthesis.rr_chain import RRChain
from kinematics.errors import SynthesisError
from kinematics.wording import number_text


@dataclass(frozen=True)
class Construction:
    """Points, lines and circles of a drawing; metres, inertial frame.

    Attributes:
        points: by name.
        lines: name, a point, and the direction of length 1.
        circles: name, centre and radius.
        steps: what is drawn in turn, in words.
    """

    points: dict[str, complex]
    lines: tuple[tuple[str, complex, complex], ...]
    circles: tuple[tuple[str, complex, float], ...]
    steps: tuple[str, ...]


def construct_chain(chain: RRChain, chosen: str) -> Construction:
    """Draw the construction of a chain through two positions.

    Args:
        chosen: ``"fixed"`` or ``"moving"``: the pivot that was chosen.

    Raises:
        SynthesisError: two lines of the drawing are parallel.
    """
    step = displacements(chain.positions[:2])[0]
    if chosen == "fixed":
        return _from_fixed(chain)
    start = chain.moving
    end = step.move(start)
    beta = math.remainder(chain.link_turns[1], 2.0 * math.pi)
    chord = (end - start) / abs(end - start)
    bisector = ("bisector of W1 W2", 0.5 * (start + end), 1j * chord)
    ray = ("L1", start, chord * cmath.exp(1j * (0.5 * math.pi - 0.5 * beta)))
    centre = _meet(bisector, ray)
    return Construction(
        {**_tool_points(chain), "W1": start, "W2": end, "G": centre},
        (bisector, ray),
        (("path of W", centre, abs(start - centre)),),
        (
            "choose W1 and carry it with the tool to W2",
            "draw the perpendicular bisector of W1 and W2",
            "draw L1 through W1 at π/2 - β/2 = "
            f"{number_text(math.degrees(0.5 * (math.pi - beta)))}° to "
            "the chord",
            "they meet in G",
        ),
    )


def _from_fixed(chain: RRChain) -> Construction:
    """Draw the construction for a chosen fixed pivot."""
    points = _tool_points(chain)
    bisectors = [
        (
            f"bisector of {a}1 {a}2",
            0.5 * (points[f"{a}1"] + points[f"{a}2"]),
            _unit(1j * (points[f"{a}2"] - points[f"{a}1"])),
        )
        for a in "DQ"
    ]
    pole, fixed = _meet(*bisectors), chain.fixed
    phi, beta = chain.tool_turns[1], chain.link_turns[1]
    along = _unit(pole - fixed)
    about_pole, about_fixed = (
        [
            (f"L{row}{k}", at, along * cmath.exp(0.5j * sign * turn))
            for k, sign in ((1, -1), (2, 1))
        ]
        for row, at, turn in ((1, pole, phi), (2, fixed, beta))
    )
    ends = [_meet(a, b) for a, b in zip(about_pole, about_fixed, strict=True)]
    return Construction(
        {**points, "P12": pole, "G": fixed, "W1": ends[0], "W2": ends[1]},
        (*bisectors, ("V", fixed, along), *about_pole, *about_fixed),
        (
            ("path of W", fixed, abs(ends[0] - fixed)),
            ("circle about the pole", pole, abs(ends[0] - pole)),
        ),
        (
            "the perpendicular bisectors of D1 D2 and of Q1 Q2 meet in the pole P12",
            "draw V through G and P12",
            f"turn V about P12 by φ/2 = {number_text(math.degrees(0.5 * phi))}° to both "
            "sides: L11, L12",
            f"turn V about G by β/2 = {number_text(math.degrees(0.5 * beta))}° to both "
            "sides: L21, L22",
            "L11 and L21 meet in W1, L12 and L22 in W2",
        ),
    )


def _tool_points(chain: RRChain) -> dict[str, complex]:
    """Two points of the tool, D and Q, at both positions."""
    size = max(chain.length, abs(chain.reach))
    points = {}
    for k, position in enumerate(chain.positions[:2], 1):
        points[f"D{k}"] = position.point
        points[f"Q{k}"] = position.point + 0.3 * size * cmath.exp(1j * position.angle)
    return points


def _unit(z: complex) -> complex:
    """Scale to length 1.

    Raises:
        SynthesisError: it is zero: a point of the tool stays.
    """
    if not z:
        raise SynthesisError("a point of the tool is the pole", "choose another point")
    return z / abs(z)


def _meet(
    first_line: tuple[str, complex, complex], second_line: tuple[str, complex, complex]
) -> complex:
    """Intersect two lines."""
    (first, a, u), (second, b, v) = first_line, second_line
    area = (u.conjugate() * v).imag
    if not area:
        raise SynthesisError(f"lines {first} and {second} are parallel", "give other positions")
    return a + u * ((b - a).conjugate() * v).imag / area
