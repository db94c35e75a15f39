"""HTML page and picture of a synthesis: the mechanism at its positions, and the map."""

from __future__ import annotations

import cmath
from html import escape
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import image, short, tidy
from balance.app.answers.html.render import (
    facts_list,
    fill_template,
    render_page,
    rows_table,
    with_capital,
)
from balance.app.answers.html.synthesis_motion import mechanism_motion
from balance.app.answers.text.synthesis import mechanism_rows, synthesis_facts
from balance.studies.synthesis.construction import Construction
from balance.studies.synthesis.couplings import SlotCoupling
from balance.studies.synthesis.error_map import AngleErrorMap
from balance.studies.synthesis.mechanism import Synthesis
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.zero_contour import ZeroContour
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

Complex = NDArray[np.complex128]

# Errors beyond this are drawn in one colour, radians.
CLIPPED = 0.5
DASHES = {"line": "solid", "dash": "dash", "marks": "solid"}
SCALE = [[0.0, "#7fa6c9"], [0.5, "#ffffff"], [1.0, "#d9a48f"]]
COLOURS = ("#0b5fa5", "#b8520a", "#2e7d4f")
INK, GREY, FAINT = "#1b1e22", "#8a9299", "#b9c2c9"
# Points of a circle; margin of a drawing.
CIRCLE, MARGIN = 121, 0.08
# Longest part of a line of the construction, in sizes of the drawing.
FAR = 0.7


def synthesis_page(synthesis: Synthesis) -> str:
    """Render a synthesis as one HTML file.

    Returns:
        The text of the file; the element ``report`` contains `Synthesis.to_dict`.
    """
    figures, motion = [_mechanism_figure(synthesis)], mechanism_motion(synthesis)
    number = 1 if motion is None else 2
    shown = '<div id="traces1" role="img" aria-label="Map of the error"></div>'
    caption = "Colours: angle error of the tool, clipped at 0.5 rad. Lines: where it vanishes."
    if synthesis.map is None:
        section = ""
    else:
        figures.append(_map_figure(synthesis))
        section = (
            f"<figure>\n<h2>Map of the search</h2>\n{shown}\n"
            f"<figcaption><b>Figure {number + 1}.</b> {caption}</figcaption>\n</figure>"
        )
    steps = synthesis.construction.steps if synthesis.construction else ()
    items = "".join(f"<li>{escape(step)}</li>" for step in steps)
    drawn = f"<section><h2>Construction</h2><ol>{items}</ol></section>" if items else ""
    return render_page(
        "synthesis.html",
        title="Synthesis",
        summary=_summary(synthesis),
        report=synthesis.to_dict(),
        data={"figures": figures, **({"motion": motion} if motion else {})},
        scripts=("curves", *["motion"] * (motion is not None)),
        facts=facts_list(synthesis_facts(synthesis)),
        number=str(number),
        moving=fill_template("synthesis_motion.html", {}) if motion else "",
        construction=drawn,
        dashed=_dashed(synthesis),
        map=section,
        mechanisms=rows_table(mechanism_rows(synthesis)),
    )


def _dashed(synthesis: Synthesis) -> str:
    """Say what is dashed in the figure of the mechanism, if anything is."""
    if synthesis.construction is not None:
        return " Dashed: the construction with ruler and compass."
    slot = synthesis.mechanisms and isinstance(synthesis.mechanisms[0].coupling, SlotCoupling)
    return " Dashed: the slot in the base." if slot else ""


def _summary(synthesis: Synthesis) -> str:
    """Say what was found, and where the best mechanism stands."""
    sentence = f"{with_capital(synthesis.words)}."
    if not synthesis.mechanisms:
        return sentence
    best = synthesis.mechanisms[0]
    pivots = (
        f"{name.replace('_', ' ')} at ({_decimals(z.real)}, {_decimals(z.imag)})"
        for name, z in best.pivots.items()
    )
    return f"{sentence} The best is a {best.kind}: {', '.join(pivots)}, in metres."


def _decimals(value: float) -> str:
    return number_text(value, ".4g").replace("-", "−")


def synthesis_picture(synthesis: Synthesis, kind: str) -> bytes:
    """Draw a synthesis with Matplotlib.

    Args:
        kind: ``"png"`` or ``"svg"``.

    Returns:
        The bytes of the file.

    Raises:
        PackageError: Matplotlib is missing.
    """

    def draw(figure: Any) -> None:
        axes = figure.subplots(1, 1 if synthesis.map is None else 2, squeeze=False)[0]
        curves = _mechanism_curves(synthesis)
        for curve in curves:
            _draw_curve(axes[0], curve)
        (x0, x1), (y0, y1) = _limits(curves)
        axes[0].set(xlim=(x0, x1), ylim=(y0, y1), xlabel="x (m)", ylabel="y (m)")
        axes[0].set_aspect("equal")
        axes[0].legend(
            fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(0, -0.12), ncols=3
        )
        if synthesis.map is not None:
            _draw_map(axes[1], synthesis)
        for ax in axes:
            tidy(ax)

    return image((6.5 if synthesis.map is None else 11.0, 6.5), kind, draw)


def _draw_curve(ax: Any, curve: _Curve) -> None:
    """Draw a curve with Matplotlib."""
    marks = {"marker": "o", "markersize": 4} if curve.style != "dash" else {}
    style = {"line": "-", "dash": "--", "marks": "none"}[curve.style]
    if curve.style == "line" and not curve.joints:
        marks = {}
    ax.plot(
        curve.points.real,
        curve.points.imag,
        color=curve.colour,
        label=curve.name or None,
        linestyle=style,
        linewidth=1.0 if curve.style == "dash" else 1.6,
        **marks,
    )
    for z, text in zip(curve.points, curve.labels, strict=False):
        ax.annotate(
            text,
            (z.real, z.imag),
            xytext=(4, 4),
            textcoords="offset points",
            color=curve.colour,
        )


def _draw_map(ax: Any, synthesis: Synthesis) -> None:
    """Draw the map with Matplotlib."""
    x, y, values, labels = _grid(synthesis)
    clipped = np.ma.masked_invalid(np.clip(values, -CLIPPED, CLIPPED))
    ax.pcolormesh(x, y, clipped, cmap="RdBu_r", vmin=-CLIPPED, vmax=CLIPPED, alpha=0.6)
    for curve in _map_curves(synthesis):
        _draw_curve(ax, curve)
    ax.set(xlabel=labels[0], ylabel=labels[1], xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    ax.legend(fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(0, -0.12), ncols=3)


def _grid(synthesis: Synthesis) -> tuple[Array, Array, Array, tuple[str, str]]:
    """Return the axes of a map, its values, and the labels of the axes."""
    shown = synthesis.map
    assert shown is not None
    if isinstance(shown, AngleErrorMap):
        labels = (f"{shown.line.free} pivot from the chord (m)", "(I1 + I3) / (I2 + I4 + I5)")
        return shown.offsets, shown.ratios, shown.errors, labels
    labels = ("x of the moving pivot (m)", "y of the moving pivot (m)")
    return shown.x, shown.y, shown.residuals[0], labels


def _mechanism_figure(synthesis: Synthesis) -> dict[str, Any]:
    """Build the figure of the mechanism at its positions."""
    curves = _mechanism_curves(synthesis)
    (x0, x1), (y0, y1) = _limits(curves)
    axes = {
        "xaxis": {"title": {"text": "x (m)"}, "range": [x0, x1]},
        "yaxis": {"title": {"text": "y (m)"}, "range": [y0, y1], "scaleanchor": "x"},
    }
    return {"data": [_trace(curve) for curve in curves], "layout": _layout(axes)}


def _map_figure(synthesis: Synthesis) -> dict[str, Any]:
    """Build the figure of the map."""
    x, y, values, labels = _grid(synthesis)
    colours = {
        "type": "heatmap",
        "x": short(x),
        "y": short(y),
        "z": [short(row) for row in values],
        "zmin": -CLIPPED,
        "zmax": CLIPPED,
        "colorscale": SCALE,
        "colorbar": {"title": {"text": "rad"}},
    }
    axes = {
        "xaxis": {"title": {"text": labels[0]}, "range": [x[0], x[-1]]},
        "yaxis": {"title": {"text": labels[1]}, "range": [y[0], y[-1]]},
    }
    traces = [colours, *map(_trace, _map_curves(synthesis))]
    return {"data": traces, "layout": _layout(axes)}


def _trace(curve: _Curve) -> dict[str, Any]:
    """Build the trace of a curve."""
    mode = "markers" if curve.style == "marks" else "lines+markers" if curve.joints else "lines"
    texts = {"mode": f"{mode}+text", "text": list(curve.labels), "textposition": "top right"}
    return {
        "type": "scatter",
        "name": curve.name,
        "mode": mode,
        "showlegend": bool(curve.name),
        "x": short(curve.points.real),
        "y": short(curve.points.imag),
        "line": {
            "color": curve.colour,
            "dash": DASHES[curve.style],
            "width": 1 if curve.style == "dash" else 2,
        },
        "marker": {"color": curve.colour, "size": 8 if curve.style == "marks" else 6},
        **(texts if curve.labels else {}),
    }


def _layout(axes: dict[str, Any]) -> dict[str, Any]:
    """Build the layout of a figure."""
    return {**axes, "height": 560, "showlegend": True}


class _Curve(NamedTuple):
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


def _mechanism_curves(synthesis: Synthesis) -> list[_Curve]:
    """Draw the best mechanism at its positions, its path, and the construction."""
    tool = "tip of the rocker" if synthesis.function else "tool"
    name = f"positions of the {tool}"
    if synthesis.timed:
        points = np.array([each.point for each in synthesis.positions])
        curves = [_Curve(name, points, INK, "marks")]
    else:
        curves = [_Curve(name, _arrows(synthesis.positions), INK, "line", True)]
    if not synthesis.mechanisms:
        return curves
    best = synthesis.mechanisms[0]
    for k, outline in enumerate(best.outlines):
        colour = COLOURS[k % len(COLOURS)]
        curves.append(_Curve(f"position {k + 1}", np.array(outline), colour, "line", True))
    curves.append(_Curve(f"path of the {tool}", best.path, GREY))
    names = tuple(name.replace("_", " ") for name in best.pivots)
    pivots = np.array([*best.pivots.values()])
    curves.append(_Curve("pivots at position 1", pivots, INK, "marks", labels=names))
    if isinstance(best.coupling, SlotCoupling):
        slot = best.coupling
        curves.append(_Curve(f"slot for a pin at {slot.pin}", slot.points, COLOURS[1], "dash"))
    if synthesis.construction is not None:
        curves += _construction(synthesis.construction, _size(curves))
    return curves


def _limits(curves: list[_Curve]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Compute the ranges of x and y of curves without dashes, with a margin."""
    points = np.concatenate([each.points for each in curves if each.style != "dash"])
    points = points[np.isfinite(points)]
    if not points.size:
        return (-1.0, 1.0), (-1.0, 1.0)
    margin = MARGIN * max(np.ptp(points.real), np.ptp(points.imag), 1e-9)
    x, y = (
        (float(part.min() - margin), float(part.max() + margin))
        for part in (points.real, points.imag)
    )
    return x, y


def _map_curves(synthesis: Synthesis) -> list[_Curve]:
    """Draw the zero contours of the map, and the designs.

    Args:
        synthesis: a synthesis with a map.
    """
    shown = synthesis.map
    assert shown is not None
    if isinstance(shown, AngleErrorMap):
        line = _pieces(shown.contour)
        masses = synthesis.mechanisms[0].numbers if synthesis.mechanisms else {}
        curves = [_Curve("no error", line, INK)]
        if masses.get("inertia_2"):
            ratio = masses["inertia_1"] / masses["inertia_2"]
            free = [mechanism.pivots[shown.line.free] for mechanism in synthesis.mechanisms]
            taus = [((z - shown.line.middle) / shown.line.direction).real for z in free]
            marks = np.array(taus) + 1j * ratio
            curves.append(_Curve("designs for these masses", marks, COLOURS[1], "marks"))
        return curves
    curves = []
    for k, contour in enumerate(shown.contours):
        line = _pieces(contour)
        curves.append(_Curve(f"position {k + 2} is met", line, COLOURS[k], "line"))
    return [*curves, _Curve("designs", shown.moving, INK, "marks")]


def _pieces(contour: ZeroContour) -> Complex:
    """Draw the segments of a contour, with NaN between them."""
    pairs = (contour.points[:, 0] + 1j * contour.points[:, 1])[contour.segments]
    gaps = np.full((len(pairs), 1), np.nan + 0j)
    return np.concatenate([pairs, gaps], axis=1).ravel()


def _arrows(positions: tuple[Position, ...]) -> Complex:
    """Draw the frames of the tool as short lines."""
    points = [each.point for each in positions]
    size = 0.15 * max((abs(a - b) for a in points for b in points), default=0.0) or 0.1
    pieces = [
        (z, z + size * cmath.exp(1j * p.angle), np.nan)
        for z, p in zip(points, positions, strict=True)
    ]
    return np.array(pieces, dtype=np.complex128).ravel()


def _construction(drawn: Construction, size: float) -> list[_Curve]:
    """Draw lines, circles and points of a construction."""
    lines = []
    for _, point, direction in drawn.lines:
        lines += [point - FAR * size * direction, point + FAR * size * direction, np.nan]
    turns = np.exp(2j * np.pi * np.linspace(0.0, 1.0, CIRCLE))
    circles = []
    for _, centre, radius in drawn.circles:
        if radius < FAR * size:
            circles += [*(centre + radius * turns), np.nan]
    curves = [_Curve("construction", np.array(lines, dtype=np.complex128), GREY, "dash")]
    if circles:
        curves.append(_Curve("circles", np.array(circles, dtype=np.complex128), FAINT, "dash"))
    points = np.array([*drawn.points.values()])
    names = tuple(drawn.points)
    return [*curves, _Curve("points of the construction", points, GREY, "marks", labels=names)]


def _size(curves: list[_Curve]) -> float:
    """Compute the larger side of a drawing."""
    return max(high - low for low, high in _limits(curves))
