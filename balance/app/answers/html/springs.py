"""Page and picture of springs: what inputs hold over the workspace, without and with them."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from balance.app.answers.html.plot_style import image, short, tidy
from balance.app.answers.html.render import (
    bullets,
    facts_list,
    linkage_stage,
    render_page,
    rows_table,
    with_capital,
)
from balance.app.answers.html.robot_shapes import robot_shapes
from balance.app.answers.html.scene import scene
from balance.app.answers.html.time_panels import COLOURS
from balance.app.answers.text.springs import spring_table, springs_facts, torque_table
from balance.masses.springs.spring_balance import SpringBalance
from balance.support.linkage_names import linkage_title
from kinematics.closure.joint_positions import si_chain
from kinematics.model.chain import rigid_parts
from kinematics.numerics.array_types import Array

# Most inputs with a panel of their own.
MAX_PANELS = 6


def springs_page(answer: SpringBalance) -> str:
    """Render springs as one HTML file.

    The linkage moves by sliders with its springs between their points, beside their lengths
    and forces there; below are the springs, and the torques of the inputs over the workspace
    without and with them. The element ``report`` contains `SpringBalance.to_dict`.
    """
    linkage = answer.linkage
    charts = _charts(answer)
    loads = "" if answer.loads is None else bullets([answer.loads.words])
    return render_page(
        "springs.html",
        stage=linkage_stage("The linkage and its springs"),
        title=linkage_title(linkage),
        summary=f"{with_capital(answer.words)}.",
        report=answer.to_dict(),
        data={
            "scene": scene(linkage, shapes=robot_shapes(linkage)),
            "springs": _drawn(answer),
            "torques": charts,
        },
        scripts=["springs"],
        facts=facts_list(springs_facts(answer)),
        springs=rows_table(spring_table(answer).rows, range(3, 7), 3),
        payload=loads,
        charts="\n".join(_place(k, chart["name"]) for k, chart in enumerate(charts)),
        several=", the others anywhere in their ranges" if answer.inputs.shape[1] > 1 else "",
        torques=rows_table(torque_table(answer).rows, range(1, 3), 1),
    )


def _drawn(answer: SpringBalance) -> list[dict[str, object]]:
    """Collect the springs that are needed, with points in the inertial frame."""
    chain = si_chain(answer.linkage, spatial=True)
    part = rigid_parts(chain.parent.size, chain.ends)
    drawn = []
    for number, spring in enumerate(answer.springs, 1):
        if spring.stiffness == 0.0:
            continue
        ends = []
        for end in spring.ends:
            link, pose = answer.linkage.places[end.link]
            point = pose[:3, :3] @ end.point + pose[:3, 3]
            ends.append({"part": int(part[link]), "point": point.round(9).tolist()})
        drawn.append(
            {
                "name": f"spring {number}",
                "stiffness": spring.stiffness,
                "free": spring.free_length,
                "ends": ends,
            }
        )
    return drawn


def _charts(answer: SpringBalance) -> list[dict[str, Any]]:
    """Build a chart for each input: torques over the input, without and with the springs."""
    charts: list[dict[str, Any]] = []
    for k, name in enumerate(answer.linkage.inputs[:MAX_PANELS]):
        traces = []
        for x, torques, label, colour in _curves(answer, k):
            traces.append(
                {
                    "type": "scatter",
                    "mode": "lines" if answer.inputs.shape[1] == 1 else "markers",
                    "name": label,
                    "x": short(x),
                    "y": short(torques),
                    "line": {"color": colour, "width": 1.8},
                    "marker": {"color": colour, "size": 5},
                }
            )
        across, up = _titles(answer, name)
        layout = {"xaxis": {"title": {"text": across}}, "yaxis": {"title": {"text": up}}}
        charts.append(
            {"name": name, "input": k, "data": traces, "layout": {"showlegend": True, **layout}}
        )
    return charts


def _curves(answer: SpringBalance, k: int) -> list[tuple[Array, Array, str, str]]:
    """Sort the torques of an input by its displacement: without springs, and with them."""
    order = np.argsort(answer.inputs[:, k], kind="stable")
    pairs = ((answer.before, "gravity", COLOURS[1]), (answer.after, "left", COLOURS[0]))
    x = answer.inputs[order, k]
    return [(x, torques[order, k], label, colour) for torques, label, colour in pairs]


def _titles(answer: SpringBalance, name: str) -> tuple[str, str]:
    """Name the axes of the panel of an input."""
    slides = next(j.kind for j in answer.linkage.joints if j.name == name) == "prismatic"
    what, unit = ("force", "N") if slides else ("torque", "N m")
    return f"{name} ({'m' if slides else 'rad'})", f"{what} of {name} ({unit})"


def _place(k: int, name: str) -> str:
    """Render the place for the chart of an input."""
    label = f"Torque of {escape(name)} over the workspace, without and with the springs"
    return f'<div class="traces square" id="torque{k}" role="img" aria-label="{label}"></div>'


def springs_picture(answer: SpringBalance, kind: str = "png") -> bytes:
    """Draw the torques of the inputs over the workspace, each against its own input."""
    names = answer.linkage.inputs[:MAX_PANELS]

    def draw(figure: Any) -> None:
        panels = figure.subplots(1, len(names), squeeze=False)[0]
        for k, (ax, name) in enumerate(zip(panels, names, strict=True)):
            style = "-" if answer.inputs.shape[1] == 1 else "."
            for x, torques, label, colour in _curves(answer, k):
                ax.plot(x, torques, style, color=colour, label=label)
            across, up = _titles(answer, name)
            ax.set_xlabel(across)
            ax.set_ylabel(up)
            tidy(ax)
        panels[0].set_title(answer.linkage.name, loc="left")
        panels[0].legend(frameon=False, fontsize=8)

    return image((4.2 * len(names), 3.6), kind, draw)
