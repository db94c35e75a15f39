"""HTML page of remedies: their table, and added mass against input inertia."""

from __future__ import annotations

from typing import Any

from balance.remedies.compare import RemedyComparison
from balance.report.html.render import facts_list, render_page, rows_table
from balance.report.html.time_panels import COLOURS
from balance.report.text.remedies import remedies_facts, remedy_rows

__all__ = ["remedies_page"]

SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star")


def remedies_page(found: RemedyComparison) -> str:
    """Render a comparison of remedies as one HTML file.

    Args:
        found: the comparison.

    Returns:
        The text of the file; the element ``report`` contains `RemedyComparison.to_dict`.
    """
    reasons = ["what and why", *(f"{one.words}; {one.reason}" for one in found.results)]
    table = [(*row, why) for row, why in zip(remedy_rows(found), reasons, strict=True)]
    return render_page(
        "remedies.html",
        title=found.request.linkage.name,
        summary="Remedies of the literature, applied to this linkage, and what each costs.",
        report=found.to_dict(),
        data={"figures": [_cost_figure(found)]},
        scripts=("curves",),
        facts=facts_list(remedies_facts(found)),
        remedies=rows_table(table, [2, 3, 4, 5, 6, 7]),
    )


def _cost_figure(found: RemedyComparison) -> dict[str, Any]:
    """Build the figure of added mass against input inertia, a mark for each remedy."""
    marks: list[dict[str, Any]] = []
    shown = [one for one in found.results if one.helps and one.inertia_ratio is not None]
    for name in dict.fromkeys(one.remedy for one in shown):
        own = [one for one in shown if one.remedy == name]
        k = len(marks)
        marks.append({
            "name": name,
            "x": [one.mass_ratio for one in own],
            "y": [one.inertia_ratio for one in own],
            "text": [one.words for one in own],
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
