"""Picture of springs: what each input holds over the workspace, without and with them."""

from __future__ import annotations

from typing import Any

import numpy as np

from balance.app.answers.html.plot_style import image, tidy
from balance.app.answers.html.time_panels import COLOURS
from balance.masses.springs.answer import SpringBalance

# Most inputs with a panel of their own.
MAX_PANELS = 6


def springs_picture(answer: SpringBalance, kind: str = "png") -> bytes:
    """Draw the torques of the inputs over the workspace, each against its own input."""
    kinds = {joint.name: joint.kind for joint in answer.linkage.joints}
    names = answer.linkage.inputs[:MAX_PANELS]

    def draw(figure: Any) -> None:
        panels = figure.subplots(1, len(names), squeeze=False)[0]
        for k, (ax, name) in enumerate(zip(panels, names, strict=True)):
            order = np.argsort(answer.inputs[:, k], kind="stable")
            style = "-" if answer.inputs.shape[1] == 1 else "."
            for torques, label, colour in (
                (answer.before, "gravity", COLOURS[1]),
                (answer.after, "left", COLOURS[0]),
            ):
                ax.plot(
                    answer.inputs[order, k], torques[order, k], style, color=colour, label=label
                )
            slides = kinds[name] == "prismatic"
            ax.set_xlabel(f"{name} ({'m' if slides else 'rad'})")
            ax.set_ylabel(
                f"{'force' if slides else 'torque'} of {name} ({'N' if slides else 'N m'})"
            )
            tidy(ax)
        panels[0].set_title(answer.linkage.name, loc="left")
        panels[0].legend(frameon=False, fontsize=8)

    return image((4.2 * len(names), 3.6), kind, draw)
