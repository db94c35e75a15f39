"""HTML page and picture of a synthesis: the mechanism at its positions, and the map."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import image, short, tidy
from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.html.synthesis_curves import (
    Curve,
    limits,
    map_curves,
    mechanism_curves,
)
from balance.app.answers.text.synthesis import mechanism_rows, synthesis_facts
from balance.studies.synthesis.error_map import AngleErrorMap
from balance.studies.synthesis.mechanism import Synthesis

Array = NDArray[np.float64]

# Errors beyond this are drawn in one colour, radians.
CLIPPED = 0.5
DASHES = {"line": "solid", "dash": "dash", "marks": "solid"}
SCALE = [[0.0, "#7fa6c9"], [0.5, "#ffffff"], [1.0, "#d9a48f"]]


def synthesis_page(synthesis: Synthesis) -> str:
    """Render a synthesis as one HTML file.

    Returns:
        The text of the file; the element ``report`` contains `Synthesis.to_dict`.
    """
    figures = [_mechanism_figure(synthesis)]
    shown = '<div id="traces1" role="img" aria-label="Map of the error"></div>'
    caption = "Colours: angle error of the tool, clipped at 0.5 rad. Lines: where it vanishes."
    if synthesis.map is None:
        section = ""
    else:
        figures.append(_map_figure(synthesis))
        section = (
            f"<figure>\n<h2>Map of the search</h2>\n{shown}\n"
            f"<figcaption><b>Figure 2.</b> {caption}</figcaption>\n</figure>"
        )
    steps = synthesis.construction.steps if synthesis.construction else ()
    items = "".join(f"<li>{escape(step)}</li>" for step in steps)
    drawn = f"<section><h2>Construction</h2><ol>{items}</ol></section>" if items else ""
    return render_page(
        "synthesis.html",
        title="Synthesis",
        summary="Mechanisms that are balanced and whose tool passes through given positions.",
        report=synthesis.to_dict(),
        data={"figures": figures},
        scripts=("curves",),
        facts=facts_list(synthesis_facts(synthesis)),
        construction=drawn,
        map=section,
        mechanisms=rows_table(mechanism_rows(synthesis)),
    )


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
        curves = mechanism_curves(synthesis)
        for curve in curves:
            _draw_curve(axes[0], curve)
        (x0, x1), (y0, y1) = limits(curves)
        axes[0].set(xlim=(x0, x1), ylim=(y0, y1), xlabel="x (m)", ylabel="y (m)")
        axes[0].set_aspect("equal")
        axes[0].legend(fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(0, -0.12),
                       ncols=3)  # fmt: skip
        if synthesis.map is not None:
            _draw_map(axes[1], synthesis)
        for ax in axes:
            tidy(ax)

    return image((6.5 if synthesis.map is None else 11.0, 6.5), kind, draw)


def _draw_curve(ax: Any, curve: Curve) -> None:
    """Draw a curve with Matplotlib."""
    marks = {"marker": "o", "markersize": 4} if curve.style != "dash" else {}
    style = {"line": "-", "dash": "--", "marks": "none"}[curve.style]
    if curve.style == "line" and not curve.joints:
        marks = {}
    ax.plot(
        curve.points.real, curve.points.imag, color=curve.colour, label=curve.name or None,
        linestyle=style, linewidth=1.0 if curve.style == "dash" else 1.6, **marks,
    )  # fmt: skip
    for z, text in zip(curve.points, curve.labels, strict=False):
        ax.annotate(text, (z.real, z.imag), xytext=(4, 4), textcoords="offset points",
                    color=curve.colour)  # fmt: skip


def _draw_map(ax: Any, synthesis: Synthesis) -> None:
    """Draw the map with Matplotlib."""
    x, y, values, labels = _grid(synthesis)
    clipped = np.ma.masked_invalid(np.clip(values, -CLIPPED, CLIPPED))
    ax.pcolormesh(x, y, clipped, cmap="RdBu_r", vmin=-CLIPPED, vmax=CLIPPED, alpha=0.6)
    for curve in map_curves(synthesis):
        _draw_curve(ax, curve)
    ax.set(xlabel=labels[0], ylabel=labels[1], xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    ax.legend(fontsize=7, frameon=False, loc="upper left", bbox_to_anchor=(0, -0.12), ncols=3)


def _grid(synthesis: Synthesis) -> tuple[Array, Array, Array, tuple[str, str]]:
    """Return the axes of a map, its values, and the labels of the axes."""
    shown = synthesis.map
    assert shown is not None
    if isinstance(shown, AngleErrorMap):
        labels = (f"{shown.line.free} pivot from the chord (m)",
                  "(I1 + I3) / (I2 + I4 + I5)")  # fmt: skip
        return shown.offsets, shown.ratios, shown.errors, labels
    labels = ("x of the moving pivot (m)", "y of the moving pivot (m)")
    return shown.x, shown.y, shown.residuals[0], labels


def _mechanism_figure(synthesis: Synthesis) -> dict[str, Any]:
    """Build the figure of the mechanism at its positions."""
    curves = mechanism_curves(synthesis)
    (x0, x1), (y0, y1) = limits(curves)
    axes = {
        "xaxis": {"title": {"text": "x (m)"}, "range": [x0, x1]},
        "yaxis": {"title": {"text": "y (m)"}, "range": [y0, y1], "scaleanchor": "x"},
    }  # fmt: skip
    return {"data": [_trace(curve) for curve in curves], "layout": _layout(axes)}


def _map_figure(synthesis: Synthesis) -> dict[str, Any]:
    """Build the figure of the map."""
    x, y, values, labels = _grid(synthesis)
    colours = {
        "type": "heatmap", "x": short(x), "y": short(y), "z": [short(row) for row in values],
        "zmin": -CLIPPED, "zmax": CLIPPED, "colorscale": SCALE,
        "colorbar": {"title": {"text": "rad"}},
    }  # fmt: skip
    axes = {
        "xaxis": {"title": {"text": labels[0]}, "range": [x[0], x[-1]]},
        "yaxis": {"title": {"text": labels[1]}, "range": [y[0], y[-1]]},
    }
    traces = [colours, *map(_trace, map_curves(synthesis))]
    return {"data": traces, "layout": _layout(axes)}


def _trace(curve: Curve) -> dict[str, Any]:
    """Build the trace of a curve."""
    mode = "markers" if curve.style == "marks" else "lines+markers" if curve.joints else "lines"
    texts = {"mode": f"{mode}+text", "text": list(curve.labels), "textposition": "top right"}
    return {
        "type": "scatter", "name": curve.name, "mode": mode, "showlegend": bool(curve.name),
        "x": short(curve.points.real), "y": short(curve.points.imag),
        "line": {"color": curve.colour, "dash": DASHES[curve.style],
                 "width": 1 if curve.style == "dash" else 2},
        "marker": {"color": curve.colour, "size": 8 if curve.style == "marks" else 6},
        **(texts if curve.labels else {}),
    }  # fmt: skip


def _layout(axes: dict[str, Any]) -> dict[str, Any]:
    """Build the layout of a figure."""
    return {**axes, "height": 560, "showlegend": True}
