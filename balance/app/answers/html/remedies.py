"""HTML page of remedies: their table, and added mass against input inertia."""

from __future__ import annotations

from html import escape
from typing import Any, NamedTuple

import numpy as np

from balance.app.answers.html.linkage_drawing import linkage_drawing
from balance.app.answers.html.plot_style import image, tidy
from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.html.time_panels import COLOURS
from balance.app.answers.text.remedies import (
    UNITS,
    applicable,
    following_lines,
    reason_lines,
    remedies_facts,
    remedies_sentence,
    remedy_rows,
)
from balance.masses.designs.density import STEEL
from balance.masses.remedies.applied import AppliedRemedy, total_inertia
from balance.masses.remedies.compare import RemedyComparison
from balance.masses.remedies.request import RemedyRequest
from balance.support.linkage_names import linkage_title
from kinematics.errors import LinkageError, UsageError
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from kinematics.numerics.array_types import Array

# Marks of plotly, and of Matplotlib.
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star")
MARKS = ("o", "s", "D", "^", "P", "X", "*")
# Size of a drawing, pixels, and most of them.
SIZE, MAX_DRAWINGS = (300, 220), 24
# Part of the given mass below which no weight is drawn.
DRAWN = 1e-6
# Ratio of costs from which their axis is logarithmic.
SPREAD = 20.0
RANGE_MODES = {"linear": "tozero", "log": "normal"}
AXES = (
    "added mass with gears, of that of the linkage",
    "inertia felt by the inputs, of that in the file",
)


class _Costs(NamedTuple):
    """Costs of the remedies of one name, or of the trade-off of one remedy.

    Attributes:
        name: the name in words.
        mass: added mass over that of the linkage, with gears, and without in a trade-off.
        inertia: inertia that the inputs feel over that of the file.
        words: what each one is.
        look: number of the mark and of the colour.
    """

    name: str
    mass: list[float]
    inertia: list[float]
    words: list[str]
    look: int

    @property
    def colour(self) -> str:
        """Colour of the marks or of the curve."""
        return COLOURS[self.look % len(COLOURS)]


def remedies_page(comparison: RemedyComparison) -> str:
    """Render a comparison of remedies as one HTML file.

    Returns:
        The text of the file; the element ``report`` contains `RemedyComparison.to_dict`.
    """
    reasons = [
        "what and why",
        *(f"{each.words}; {each.reason}" for each in applicable(comparison)),
    ]
    table = [(*row, why) for row, why in zip(remedy_rows(comparison), reasons, strict=True)]
    return render_page(
        "remedies.html",
        title=linkage_title(comparison.request.linkage),
        summary=_summary(comparison),
        report=comparison.to_dict(),
        data={"figures": [_cost_figure(comparison)]},
        scripts=("curves",),
        facts=facts_list(remedies_facts(comparison)),
        drawings=_drawings(comparison),
        remedies=rows_table(table, [*range(2, 11)]),
        units=escape(UNITS),
        refused="\n".join(f"<li>{escape(line)}</li>" for line in reason_lines(comparison)),
    )


def _summary(comparison: RemedyComparison) -> str:
    """Say what to build, and with which command its file is made."""
    lines = (line.strip() for line in following_lines(comparison))
    return " ".join([remedies_sentence(comparison), *lines])


def _drawings(comparison: RemedyComparison) -> str:
    """Draw the linkage with each remedy that helps, in order of preference."""
    request = comparison.request
    built = [applied for applied in comparison.by_preference if applied.urdf is not None]
    figures = []
    for applied in built[:MAX_DRAWINGS]:
        drawn = _drawing(request, applied)
        if drawn:
            figures.append(
                f"<figure>{drawn}<figcaption><b>{escape(applied.short)}</b>: "
                f"{escape(applied.words)}</figcaption></figure>"
            )
    if not figures:
        return ""
    note = (
        "New links and added matter have the second colour; matter is drawn as balls of steel, "
        "in the scale of the linkage."
    )
    return (
        '<section>\n<h2>What is built in</h2>\n<p class="note">'
        f'{note}</p>\n<div class="drawings">\n{"".join(figures)}\n</div>\n</section>'
    )


def _drawing(request: RemedyRequest, applied: AppliedRemedy) -> str:
    """Draw the file of one remedy; empty if it cannot be read without the request."""
    assert applied.urdf is not None
    try:
        linkage = load(Document(request.base.name, applied.urdf), angles=request.angles)
    except LinkageError:
        return ""
    given = {body.name: body.inertia for body in request.linkage.bodies}
    added = [body.inertia - given.get(body.name, np.zeros(10)) for body in linkage.bodies]
    springs: Any = applied.details.get("springs", ())
    return linkage_drawing(
        linkage,
        SIZE,
        names=False,
        marked=applied.new_links,
        balls=[steel_ball(z) for z in added if z[0] > DRAWN * request.given_mass],
        springs=[np.array([spring["base"], spring["at"]]) for spring in springs],
    )


def steel_ball(z: Array) -> tuple[Array, float]:
    """Return the middle (3,) and the radius of a ball of steel of parameters z (10,), m."""
    return z[1:4] / z[0], float((0.75 * z[0] / (np.pi * STEEL)) ** (1.0 / 3.0))


def remedies_picture(comparison: RemedyComparison, kind: str = "png") -> bytes:
    """Draw what each remedy that helps costs: added mass, and inertia that the inputs feel.

    Args:
        kind: ``"png"`` or ``"svg"``.

    Returns:
        The bytes of the image.

    Raises:
        UsageError: no remedy helps.
        PackageError: Matplotlib is missing.
    """
    groups = _cost_groups(comparison)
    if not groups:
        name = comparison.request.linkage.name
        raise UsageError(f"{name}: none of these remedies helps; there is nothing to draw")

    def draw(figure: Any) -> None:
        ax = figure.subplots()
        for group in groups:
            ax.plot(
                group.mass,
                group.inertia,
                MARKS[group.look % len(MARKS)],
                ms=7,
                ls="none",
                color=group.colour,
                label=group.name,
            )
        for curve in _trade_offs(comparison, groups):
            ax.plot(curve.mass, curve.inertia, ".-", lw=0.8, color=curve.colour)
        kinds = _scales(groups)
        ax.set_xscale(kinds[0])
        ax.set_yscale(kinds[1])
        if kinds[0] == "linear":
            most = max(x for group in groups for x in group.mass)
            ax.set_xlim(0.0, 1.05 * max(1e-3, most))
        if kinds[1] == "linear":
            ax.set_ylim(0.0, 1.05 * max(1.0, *(y for group in groups for y in group.inertia)))
        ax.set_xlabel(AXES[0])
        ax.set_ylabel(AXES[1])
        tidy(ax)
        figure.legend(frameon=False, fontsize=8, loc="outside upper left", ncols=2)

    return image((6.4, 5.2), kind, draw)


def _cost_groups(comparison: RemedyComparison) -> list[_Costs]:
    """List the costs of the remedies that help, by the name of the remedy."""
    groups: dict[str, _Costs] = {}
    for applied in comparison.results:
        if applied.helps and None not in (applied.inertia_ratio, applied.added_mass):
            blank = _Costs(applied.short, [], [], [], len(groups))
            group = groups.setdefault(applied.short, blank)
            group.mass.append(applied.added_mass_with_gears / comparison.request.given_mass)
            group.inertia.append(applied.inertia_ratio or 0.0)
            group.words.append(applied.words)
    return list(groups.values())


def _scales(groups: list[_Costs]) -> list[str]:
    """Choose the scales of mass and inertia: logarithmic where costs differ much."""
    scales = []
    for name in ("mass", "inertia"):
        costs = [cost for group in groups for cost in getattr(group, name)]
        wide = bool(costs) and 0.0 < SPREAD * min(costs) < max(costs)
        scales.append("log" if wide else "linear")
    return scales


def _trade_offs(comparison: RemedyComparison, groups: list[_Costs]) -> list[_Costs]:
    """List the points of trade-offs, in the colour of their remedy."""
    request = comparison.request
    felt = total_inertia(request, request.input_inertia)
    looks = {group.name: group.look for group in groups}
    return [
        _Costs(
            f"{applied.short}: trade-off, without gears",
            [point.added_mass / request.given_mass for point in applied.trade_off],
            [point.inertia / felt for point in applied.trade_off],
            [f"gear {point.gear:g}" for point in applied.trade_off],
            looks[applied.short],
        )
        for applied in comparison.results
        if applied.trade_off and felt > 0.0 and applied.short in looks
    ]


def _cost_figure(comparison: RemedyComparison) -> dict[str, Any]:
    """Build the figure of added mass against input inertia, a mark for each remedy."""
    groups = _cost_groups(comparison)
    traces = []
    for group in groups:
        symbol = SYMBOLS[group.look % len(SYMBOLS)]
        marker = {"size": 11, "symbol": symbol, "color": group.colour}
        traces.append(_trace(group, "markers", marker))
    for curve in _trade_offs(comparison, groups):
        trace = _trace(curve, "lines+markers", {"size": 5, "color": curve.colour})
        traces.append(trace | {"line": {"color": curve.colour, "width": 1}})
    x, y = (
        {"title": {"text": text}, "type": kind, "rangemode": RANGE_MODES[kind], "tight": False}
        for text, kind in zip(AXES, _scales(groups), strict=True)
    )
    layout = {"xaxis": x, "yaxis": y, "height": 460, "showlegend": True}
    return {"data": traces, "layout": layout}


def _trace(costs: _Costs, mode: str, marker: dict[str, Any]) -> dict[str, Any]:
    """Build the trace of costs, as Plotly names it."""
    return {
        "name": costs.name,
        "x": costs.mass,
        "y": costs.inertia,
        "text": costs.words,
        "mode": mode,
        "type": "scatter",
        "marker": marker,
    }
