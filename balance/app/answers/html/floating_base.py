"""Pictures, pages and tables of the motion of a base that floats."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from balance.app.answers.html.render import facts_list, render_page
from balance.app.answers.html.time_panels import (
    MAX_LINES,
    Panel,
    PanelColumn,
    inputs_title,
    panels_figures,
    panels_picture,
)
from balance.app.answers.text.floating_base import floating_base_facts
from balance.motion.floating_base.floating_base_motion import FloatingBaseMotion
from balance.support.csv_text import csv_table
from balance.support.linkage_names import linkage_names
from kinematics.numerics.linalg.ties import rank_least_first

# Least limits of the axes, radians, metres and radians per second: less is round-off.
ROUND_OFF = 1e-9


def _panels(motion: FloatingBaseMotion) -> list[Panel]:
    """Build the panels of a simulation."""
    of, axes, names = motion.samples, ("x", "y", "z"), motion.linkage.inputs
    reach = np.abs(of.u).max(axis=0)
    shown = sorted(rank_least_first((-reach).tolist())[:MAX_LINES])
    lines = [of.rotation, of.displacement, of.turning]
    titles = ("base rotation (rad)", "base displacement (m)", "base turning (rad/s)")
    return [
        Panel(inputs_title(motion.linkage), tuple(names[k] for k in shown), of.u[:, shown].T),
        *(
            Panel(title, axes, line.T, ROUND_OFF)
            for title, line in zip(titles, lines, strict=True)
        ),
    ]


def _columns(motions: Sequence[FloatingBaseMotion]) -> list[PanelColumn]:
    """Build the column of panels of each simulation."""
    names = linkage_names([motion.linkage for motion in motions])
    return [
        PanelColumn(f"{name}\n{motion.verdict}", motion.time, _panels(motion))
        for name, motion in zip(names, motions, strict=True)
    ]


def floating_base_picture(*motions: FloatingBaseMotion, kind: str = "png") -> bytes:
    """Draw inputs and motions of bases over time as an image, side by side.

    Args:
        motions: one or more simulations.
        kind: ``"png"`` or ``"svg"``.
    """
    return panels_picture(_columns(motions), kind)


def floating_base_page(*motions: FloatingBaseMotion) -> str:
    """Render simulations as one HTML file."""
    names = linkage_names([motion.linkage for motion in motions])
    verdicts = "; ".join(
        f"{name}: {motion.verdict}" for name, motion in zip(names, motions, strict=True)
    )
    return render_page(
        "floating_base.html",
        title=" and ".join(names),
        summary=f"Motion of a base that floats, over {motions[0].duration:.4g} s. {verdicts}.",
        report=[motion.to_dict() for motion in motions],
        data={"figures": panels_figures(_columns(motions))},
        scripts=["curves"],
        facts="\n".join(
            f"<section><h2>{escape(name)}</h2>{facts_list(floating_base_facts(motion))}</section>"
            for name, motion in zip(names, motions, strict=True)
        ),
        curves="\n".join(
            f'<div class="traces" id="traces{k}" role="img" aria-label="Inputs, rotation, '
            f'displacement and angular velocity of the base of {escape(name)} over time"></div>'
            for k, name in enumerate(names)
        ),
    )


def floating_base_table(motion: FloatingBaseMotion) -> bytes:
    """Write a simulation as comma-separated values, one line per step, SI units.

    Columns are ``time``, the inputs by name (displacements from the reference pose), and the
    rotation vector of the base, the displacement of its centre of mass, and the velocities of
    both, in inertial axes.
    """
    of = motion.samples
    parts = ("rotation", "displacement", "turning", "velocity")
    names = [f"{part}_{axis}" for part in parts for axis in "xyz"]
    values = [getattr(of, part) for part in parts]
    return csv_table(["time", *motion.linkage.inputs, *names], [motion.time, of.u, *values])
