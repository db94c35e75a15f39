"""Pictures, pages and tables of the motion of a base that floats."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from balance.csv_text import csv_table
from balance.floating_base.result import FloatingBaseMotion
from balance.report.html.render import facts_list, render_page
from balance.report.html.time_panels import (
    MAX_LINES,
    Panel,
    PanelColumn,
    linkage_names,
    panels_figures,
    panels_picture,
)
from balance.report.text.floating_base import floating_base_facts
from kinematics.linalg.ties import rank_least_first

__all__ = ["floating_base_page", "floating_base_picture", "floating_base_table"]

# Least limits of the axes, radians, metres and radians per second: less is round-off.
ROUND_OFF = 1e-9


def _panels(found: FloatingBaseMotion) -> list[Panel]:
    """Build the panels of a simulation."""
    of, axes, names = found.samples, ("x", "y", "z"), found.linkage.inputs
    reach = np.abs(of.u).max(axis=0)
    shown = sorted(rank_least_first((-reach).tolist())[:MAX_LINES])
    lines = [of.rotation, of.displacement, of.turning]
    titles = ("base rotation (rad)", "base displacement (m)", "base turning (rad/s)")
    return [
        Panel("inputs (rad or m)", tuple(names[k] for k in shown), of.u[:, shown].T),
        *(
            Panel(title, axes, line.T, ROUND_OFF)
            for title, line in zip(titles, lines, strict=True)
        ),
    ]


def _columns(found: Sequence[FloatingBaseMotion]) -> list[PanelColumn]:
    """Build the column of panels of each simulation."""
    names = linkage_names([one.linkage for one in found])
    return [
        PanelColumn(f"{name}\n{one.verdict}", one.time, _panels(one))
        for name, one in zip(names, found, strict=True)
    ]


def floating_base_picture(found: Sequence[FloatingBaseMotion], kind: str = "png") -> bytes:
    """Draw inputs and motions of bases over time as an image, side by side.

    Args:
        found: one or more simulations.
        kind: ``"png"`` or ``"svg"``.

    Returns:
        The bytes of the image.

    Raises:
        PackageError: Matplotlib is missing.
    """
    return panels_picture(_columns(found), kind)


def floating_base_page(found: Sequence[FloatingBaseMotion]) -> str:
    """Render simulations as one HTML file."""
    names = linkage_names([one.linkage for one in found])
    verdicts = "; ".join(
        f"{name}: {one.verdict}" for name, one in zip(names, found, strict=True)
    )
    return render_page(
        "floating_base.html",
        title=" and ".join(names),
        summary=f"Motion of a base that floats, over {found[0].duration:.4g} s. {verdicts}.",
        report=[one.to_dict() for one in found],
        data={"figures": panels_figures(_columns(found))},
        scripts=["curves"],
        facts="\n".join(
            f"<section><h2>{escape(name)}</h2>{facts_list(floating_base_facts(one))}</section>"
            for name, one in zip(names, found, strict=True)
        ),
        curves="\n".join(
            f'<div class="traces" id="traces{k}" role="img" aria-label="Inputs, rotation, '
            f'displacement and angular velocity of the base of {escape(name)} over time"></div>'
            for k, name in enumerate(names)
        ),
    )  # fmt: skip


def floating_base_table(found: FloatingBaseMotion) -> bytes:
    """Write a simulation as comma-separated values, one line per step, SI units.

    Columns are ``time``, the inputs by name (displacements from the reference pose), and the
    rotation vector of the base, the displacement of its centre of mass, and the velocities of
    both, in inertial axes.
    """
    of = found.samples
    parts = ("rotation", "displacement", "turning", "velocity")
    names = [f"{part}_{axis}" for part in parts for axis in "xyz"]
    values = [getattr(of, part) for part in parts]
    return csv_table(["time", *found.linkage.inputs, *names], [found.time, of.u, *values])
