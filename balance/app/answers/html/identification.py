"""Pictures of an identification: loads and what explains them; of a plan: its inputs."""

from __future__ import annotations

from math import ceil
from typing import Any

from balance.app.answers.html.plot_style import image, tidy
from balance.app.answers.html.time_panels import COLOURS
from balance.masses.identification.exciting_motion import ExcitingMotion
from balance.masses.identification.measurements import WRENCH
from balance.masses.identification.result import Identification

# Most loads with a panel of their own, and most inputs with a line of their own.
MAX_PANELS = 9
MAX_LINES = 6


def identification_picture(answer: Identification, kind: str = "png") -> bytes:
    """Draw each measured load over time, and what file and identified masses predict."""
    measured = answer.measurements
    names = measured.channels[:MAX_PANELS]
    columns = min(3, len(names))
    rows = ceil(len(names) / columns)
    kinds = {joint.name: joint.kind for joint in answer.space.linkage.joints}

    from_file, identified = answer.predicted
    curves = (
        (measured.values, ".", COLOURS[2], "measured"),
        (from_file, "--", COLOURS[1], "masses of the file"),
        (identified, "-", COLOURS[0], "identified"),
    )

    def draw(figure: Any) -> None:
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True)
        for k, (ax, name) in enumerate(zip(panels.flat, names, strict=False)):
            for loads, style, colour, label in curves:
                ax.plot(
                    measured.time,
                    loads[:, k],
                    style,
                    markersize=2.0,
                    linewidth=1.2,
                    color=colour,
                    label=label,
                )
            force = name in WRENCH[:3] or kinds.get(name) == "prismatic"
            ax.set_ylabel(f"{name} ({'N' if force else 'N m'})")
            tidy(ax)
        for ax in panels.flat[len(names) :]:
            ax.set_axis_off()
        for ax in panels[-1]:
            ax.set_xlabel("time (s)")
        panels[0, 0].set_title(answer.space.linkage.name, loc="left")
        panels[0, 0].legend(frameon=False, fontsize=8)

    return image((4.0 * columns, 0.6 + 2.4 * rows), kind, draw)


def plan_picture(plan: ExcitingMotion, kind: str = "png") -> bytes:
    """Draw displacements, speeds and accelerations of the inputs over time."""
    time, *motions = plan.samples(401)
    titles = ("displacement of the inputs", "speed", "acceleration")

    def draw(figure: Any) -> None:
        panels = figure.subplots(3, 1, sharex=True)
        for ax, values, title in zip(panels, motions, titles, strict=True):
            for k, name in enumerate(plan.space.linkage.inputs[:MAX_LINES]):
                ax.plot(
                    time,
                    values[:, k],
                    color=COLOURS[k % len(COLOURS)],
                    linewidth=1.2,
                    label=name,
                )
            ax.set_ylabel(title)
            tidy(ax)
        panels[-1].set_xlabel("time (s)")
        panels[0].set_title(plan.space.linkage.name, loc="left")
        panels[0].legend(frameon=False, fontsize=8)

    return image((7.0, 6.4), kind, draw)
