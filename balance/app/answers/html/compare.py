"""HTML page of several design spaces: the linkages move side by side above a table of facts."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from balance.app.answers.answer import joined_facts
from balance.app.answers.data import Report, report_data
from balance.app.answers.html.render import html_table, model_section, render_page
from balance.app.answers.html.robot_shapes import robot_shapes
from balance.app.answers.html.scene import scene
from balance.app.answers.text.report import comparison_facts
from balance.support.linkage_names import linkage_names


def compare_page(reports: Sequence[Report], meshes: bool = True) -> str:
    """Render several design spaces as one HTML file.

    The element ``report`` contains `report_data` of each.

    Args:
        reports: two or more design spaces.
        meshes: whether to draw the shapes of the files that have any.
    """
    spaces = [report.space for report in reports]
    names = linkage_names([space.linkage for space in spaces])
    scenes = [
        scene(
            space.linkage,
            space.motion,
            space.idle,
            robot_shapes(space.linkage) if meshes else (),
        )
        for space in spaces
    ]
    rows = joined_facts([comparison_facts(report) for report in reports])
    return render_page(
        "compare.html",
        title=" and ".join(names) if len(names) < 3 else f"{len(names)} linkages",
        summary="Mass distributions for which the total momentum vanishes: "
        + "; ".join(
            f"{name}: {space.nullity} dimensions of {space.rank + space.nullity}"
            for name, space in zip(names, spaces, strict=True)
        )
        + ".",
        report=[report_data(report) for report in reports],
        data={"scenes": scenes},
        scripts=["compare"],
        models="\n".join(
            model_section(k, name, f"{name} in three dimensions")
            for k, name in enumerate(names)
        ),
        facts=html_table(
            ["Fact", *map(escape, names)],
            [list(map(escape, row)) for row in rows],
        ),
    )
