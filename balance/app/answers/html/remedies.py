"""HTML page of remedies: their table, and added mass against input inertia."""

from __future__ import annotations

from typing import Any

from balance.app.answers.html.render import facts_list, render_page, rows_table
from balance.app.answers.html.time_panels import COLOURS
from balance.app.answers.text.remedies import remedies_facts, remedy_rows
from balance.masses.remedies.compare import RemedyComparison

SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star")


def remedies_page(comparison: RemedyComparison) -> str:
    """Render a comparison of remedies as one HTML file.

    Returns:
        The text of the file; the element ``report`` contains `RemedyComparison.to_dict`.
    """
    reasons = [
        "what and why",
        *(f"{each.words}; {each.reason}" for each in comparison.by_preference),
    ]
    table = [(*row, why) for row, why in zip(remedy_rows(comparison), reasons, strict=True)]
    return render_page(
        "remedies.html",
        title=comparison.request.linkage.name,
        summary="Remedies of the literature, applied to this linkage, and what each costs.",
        report=comparison.to_dict(),
        data={"figures": [_cost_figure(comparison)]},
        scripts=("curves",),
        facts=facts_list(remedies_facts(comparison)),
        remedies=rows_table(table, [2, 3, 4, 5, 6, 7]),
    )


def _cost_figure(comparison: RemedyComparison) -> dict[str, Any]:
    """Build the figure of added mass against input inertia, a mark for each remedy."""
    marks: list[dict[str, Any]] = []
    shown = [
        applied
        for applied in comparison.results
        if applied.helps and applied.inertia_ratio is not None
    ]
    for name in dict.fromkeys(applied.short for applied in shown):
        group = [applied for applied in shown if applied.short == name]
        k = len(marks)
        marks.append({
            "name": name,
            "x": [applied.mass_ratio for applied in group],
            "y": [applied.inertia_ratio for applied in group],
            "text": [applied.words for applied in group],
            "mode": "markers", "type": "scatter",
            "marker": {"size": 11, "symbol": SYMBOLS[k % len(SYMBOLS)],
                       "color": COLOURS[k % len(COLOURS)]},
        })  # fmt: skip
    axes = {
        "xaxis": {"title": {"text": "added mass, of that of the linkage"},
                  "rangemode": "tozero"},
        "yaxis": {"title": {"text": "inertia felt by the inputs, of that in the file"},
                  "rangemode": "tozero"},
    }  # fmt: skip
    return {"data": marks, "layout": {**axes, "height": 460, "showlegend": True}}
