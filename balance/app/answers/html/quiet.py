"""Picture of a planned motion: shaking and inputs over time, beside the quintic law."""

from __future__ import annotations

from typing import Any

import numpy as np

from balance.app.answers.html.plot_style import image, tidy
from balance.app.answers.html.time_panels import COLOURS
from balance.motion.quiet.quiet_motion_result import QuietMotion
from balance.motion.verification.input_paths import InputPath
from balance.motion.verification.shaking_wrench import move_wrenches, shaking
from balance.motion.verification.trajectory import drive
from kinematics.errors import PoseError

SAMPLES = 161
# Most inputs with a line of their own.
MAX_LINES = 6


def quiet_picture(plan: QuietMotion, kind: str = "png") -> bytes:
    """Draw a plan as an image: shaking force and moment, speeds and accelerations over time.

    The dashed lines are those of the quintic law, from rest to rest between all poses.
    """
    law = plan.laws[0]
    motions = [(plan.path, "-", "planned"), (law.path, "--", law.name)]

    def draw(figure: Any) -> None:
        (force, moment), (speed, change) = figure.subplots(2, 2, sharex=True)
        for path, style, label in motions:
            _draw_motion(plan, path, style, label, (force, moment, speed, change))
        titles = (
            "shaking force (N)",
            "shaking moment (N m)",
            "speed of the inputs",
            "acceleration of the inputs",
        )
        for ax, title in zip((force, moment, speed, change), titles, strict=True):
            tidy(ax)
            ax.set_ylabel(title)
        for ax in (speed, change):
            ax.set_xlabel("time (s)")
        force.set_title(plan.linkage.name, loc="left")
        force.legend(frameon=False, fontsize=8)
        speed.legend(frameon=False, fontsize=8)

    return image((9.6, 5.6), kind, draw)


def _draw_motion(
    plan: QuietMotion, path: InputPath, style: str, label: str, axes: tuple[Any, ...]
) -> None:
    """Draw one motion; nothing if its loops cannot be closed."""
    time = np.linspace(0.0, plan.duration, SAMPLES)
    try:
        motion = drive(plan.linkage, time, *path.at(time))
    except PoseError:
        return
    wrench = shaking(plan.linkage, motion.u, motion.ud, motion.udd)
    wrench = move_wrenches(wrench, plan.objective.point)
    force, moment, speed, change = axes
    colour = COLOURS[0] if style == "-" else COLOURS[1]
    for ax, part in ((force, slice(3, 6)), (moment, slice(0, 3))):
        ax.plot(time, np.linalg.norm(wrench[:, part], axis=1), style, color=colour, label=label)
    for k, name in enumerate(plan.linkage.inputs[:MAX_LINES]):
        line = {"color": COLOURS[k % len(COLOURS)], "linestyle": style, "linewidth": 1.2}
        speed.plot(time, motion.ud[:, k], label=name if style == "-" else None, **line)
        change.plot(time, motion.udd[:, k], **line)
