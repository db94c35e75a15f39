"""Curves of a synthesis: links, path, construction, and contours of the map."""

from __future__ import annotations

import cmath
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.studies.synthesis.construction import Construction
from balance.studies.synthesis.error_map import AngleErrorMap
from balance.studies.synthesis.mechanism import Synthesis
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.zero_contour import ZeroContour

Complex = NDArray[np.complex128]

COLOURS = ("#0b5fa5", "#b8520a", "#2e7d4f")
INK, GREY, FAINT = "#1b1e22", "#8a9299", "#b9c2c9"
# Points of a circle; margin of a drawing.
CIRCLE, MARGIN = 121, 0.08
# Longest part of a line of the construction, in sizes of the drawing.
FAR = 0.7


class Curve(NamedTuple):
    """A curve of a drawing.

    Attributes:
        name: in the legend; empty: not there.
        points: complex; NaN between pieces.
        colour: of the line and its marks.
        style: ``"line"``, ``"dash"`` or ``"marks"``.
        joints: whether its points are marked.
        labels: texts at its points; empty: none.
    """

    name: str
    points: Complex
    colour: str
    style: str = "line"
    joints: bool = False
    labels: tuple[str, ...] = ()


def mechanism_curves(synthesis: Synthesis) -> list[Curve]:
    """Draw the best mechanism at its positions, its path, and the construction."""
    curves = [Curve("positions of the tool", _arrows(synthesis.positions), INK, "line", True)]
    if not synthesis.mechanisms:
        return curves
    best = synthesis.mechanisms[0]
    for k, outline in enumerate(best.outlines):
        colour = COLOURS[k % len(COLOURS)]
        curves.append(Curve(f"position {k + 1}", np.array(outline), colour, "line", True))
    curves.append(Curve("path of the tool", best.path, INK))
    if synthesis.construction is not None:
        curves += _construction(synthesis.construction, _size(curves))
    return curves


def limits(curves: list[Curve]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Compute the ranges of x and y of curves without dashes, with a margin."""
    points = np.concatenate([each.points for each in curves if each.style != "dash"])
    points = points[np.isfinite(points)]
    margin = MARGIN * max(np.ptp(points.real), np.ptp(points.imag), 1e-9)
    x, y = (
        (float(part.min() - margin), float(part.max() + margin))
        for part in (points.real, points.imag)
    )
    return x, y


def map_curves(synthesis: Synthesis) -> list[Curve]:
    """Draw the zero contours of the map, and the designs.

    Args:
        synthesis: a synthesis with a map.
    """
    shown = synthesis.map
    assert shown is not None
    if isinstance(shown, AngleErrorMap):
        line = _pieces(shown.contour)
        masses = synthesis.mechanisms[0].numbers if synthesis.mechanisms else {}
        curves = [Curve("no error", line, INK)]
        if masses.get("inertia_2"):
            ratio = masses["inertia_1"] / masses["inertia_2"]
            free = [mechanism.pivots[shown.line.free] for mechanism in synthesis.mechanisms]
            taus = [((z - shown.line.middle) / shown.line.direction).real for z in free]
            marks = np.array(taus) + 1j * ratio
            curves.append(Curve("designs for these masses", marks, COLOURS[1], "marks"))
        return curves
    curves = []
    for k, contour in enumerate(shown.contours):
        line = _pieces(contour)
        curves.append(Curve(f"position {k + 2} is met", line, COLOURS[k], "line"))
    return [*curves, Curve("designs", shown.moving, INK, "marks")]


def _pieces(contour: ZeroContour) -> Complex:
    """Draw the segments of a contour, with NaN between them."""
    pairs = (contour.points[:, 0] + 1j * contour.points[:, 1])[contour.segments]
    gaps = np.full((len(pairs), 1), np.nan + 0j)
    return np.concatenate([pairs, gaps], axis=1).ravel()


def _arrows(positions: tuple[Position, ...]) -> Complex:
    """Draw the frames of the tool as short lines."""
    points = [each.point for each in positions]
    size = 0.15 * max(abs(a - b) for a in points for b in points) or 0.1
    pieces = [(z, z + size * cmath.exp(1j * p.angle), np.nan)
              for z, p in zip(points, positions, strict=True)]  # fmt: skip
    return np.array(pieces, dtype=np.complex128).ravel()


def _construction(drawn: Construction, size: float) -> list[Curve]:
    """Draw lines, circles and points of a construction."""
    lines = []
    for _, point, direction in drawn.lines:
        lines += [point - FAR * size * direction, point + FAR * size * direction, np.nan]
    turns = np.exp(2j * np.pi * np.linspace(0.0, 1.0, CIRCLE))
    circles = []
    for _, centre, radius in drawn.circles:
        if radius < FAR * size:
            circles += [*(centre + radius * turns), np.nan]
    curves = [Curve("construction", np.array(lines, dtype=np.complex128), GREY, "dash")]
    if circles:
        curves.append(Curve("circles", np.array(circles, dtype=np.complex128), FAINT, "dash"))
    points = np.array([*drawn.points.values()])
    names = tuple(drawn.points)
    return [*curves, Curve("points of the construction", points, GREY, "marks", labels=names)]


def _size(curves: list[Curve]) -> float:
    """Compute the larger side of a drawing."""
    return max(high - low for low, high in limits(curves))
