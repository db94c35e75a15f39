"""Plots of a verification: inputs, shaking loads and joint forces over time.

They show the motion that decides the verdict, with a second linkage next to the first one. The
output is a Matplotlib image or a table.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import short
from balance.app.answers.html.time_panels import (
    COLOURS,
    DASHES,
    MAX_LINES,
    Panel,
    PanelColumn,
    inputs_title,
    panels_picture,
)
from balance.motion.verification.comparison import VerificationComparison
from balance.motion.verification.run import Run
from balance.motion.verification.verification import Verification
from balance.support.csv_text import csv_table
from balance.support.linkage_names import linkage_names, linkage_title
from balance.support.tolerances import FORCE_EQUAL_RELATIVE
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first

# Planes of the polar plots of a spatial linkage: two axes each.
PLANES = ((0, 1), (0, 2), (1, 2))


def panels(verification: Verification, number: int | None = None) -> list[Panel]:
    """Build the panels of a motion of a verification.

    Shaking loads are those of the linkage on its base, opposite to the base reaction. Moments
    are about the point of the verification.

    Args:
        number: index of the motion; the plotted one by default.
    """
    run, axes = (
        verification.runs[verification.plotted if number is None else number],
        ("x", "y", "z"),
    )
    least, arm = (
        verification.tolerance * verification.scale,
        verification.length + verification.lever,
    )
    names = (
        verification.linkage.inputs,
        tuple(joint.name for joint in verification.linkage.joints),
    )
    inputs = _largest_columns(names[0], run.trajectory.u, range(len(names[0])))
    alike = _alike_columns(run.bearing)
    labels = [
        _names_alike([names[1][k] for k in alike.get(j, ())]) for j in range(len(names[1]))
    ]
    joints = _largest_columns(labels, run.bearing, [*alike])
    return [
        Panel(inputs_title(verification.linkage), *inputs),
        Panel("shaking force (N)", axes, -run.about[:, 3:].T, least),
        Panel(
            "shaking moment (N m)",
            axes,
            -run.about[:, :3].T,
            least * arm,
        ),
        Panel("bearing force (N)", *joints),
    ]


def _plotted_run(verification: Verification) -> Run:
    """Return the loads along the plotted motion."""
    return verification.runs[verification.plotted]


def verification_table(verification: Verification) -> bytes:
    """Write the plotted motion as comma-separated values, one line per sample, SI units.

    Columns are ``time``, the inputs by name (displacements from the reference pose), and the
    shaking force and moment of the linkage on its base, in inertial axes, moments about the
    point of the verification.
    """
    run = _plotted_run(verification)
    axes = [f"{part}_{axis}" for part in ("force", "moment") for axis in "xyz"]
    loads = np.roll(-run.about, 3, axis=1)
    names = ["time", *verification.linkage.inputs, *axes]
    return csv_table(names, [run.trajectory.time, run.trajectory.u, loads])


def _alike_columns(forces: Array) -> dict[int, list[int]]:
    """Group columns (N, n) that are alike, by the first one of each group.

    Axes of one joint and joints of massless rods have equal forces: one line shows them.
    """
    groups: dict[int, list[int]] = {}
    near = FORCE_EQUAL_RELATIVE * forces.max(initial=0.0)
    for k, column in enumerate(forces.T):
        first = next((j for j in groups if np.abs(column - forces[:, j]).max() <= near), k)
        groups.setdefault(first, []).append(k)
    return groups


def _names_alike(names: Sequence[str]) -> str:
    """Name the joints of one line: one, both, or the first and how many others."""
    if len(names) <= 2:
        return ", ".join(names)
    return f"{names[0]}, {len(names) - 1} alike"


def _largest_columns(
    names: Sequence[str], values: Array, among: Sequence[int]
) -> tuple[tuple[str, ...], Array]:
    """Select the columns (N, n) of the largest values, in their order."""
    reach = np.abs(values).max(axis=0)
    ranked = rank_least_first([-reach[k] for k in among])
    chosen = sorted(among[i] for i in ranked[:MAX_LINES])
    return tuple(names[k] for k in chosen), values[:, chosen].T


def verification_picture(
    *verifications: Verification, kind: str = "png", masses: Sequence[str] = ()
) -> bytes:
    """Draw the panels as an image; verifications are side by side with common scales.

    Args:
        verifications: one or more verifications.
        kind: ``"png"`` or ``"svg"``.
        masses: what tells verifications of one linkage apart, such as ``as given``.
    """
    return panels_picture(_columns(verifications, masses), kind)


def comparison_picture(comparison: VerificationComparison, kind: str = "png") -> bytes:
    """Draw two verifications side by side; see `verification_picture`."""
    return verification_picture(comparison.after, comparison.before, kind=kind)


def _columns(verifications: Sequence[Verification], masses: Sequence[str]) -> list[PanelColumn]:
    """Build the column of panels of each linkage."""
    headings = _headings(verifications, masses)
    return [
        PanelColumn(heading, _plotted_run(verification).trajectory.time, panels(verification))
        for verification, heading in zip(verifications, headings, strict=True)
    ]


def _headings(verifications: Sequence[Verification], masses: Sequence[str]) -> list[str]:
    """Build the heading of each linkage: name, verdict and plotted motion, on two lines."""
    linkages = [verification.linkage for verification in verifications]
    names = [f"{linkage_title(linkages[0])} {text}" for text in masses]
    return [
        f"{name}\n{verification.verdict}, {motion_heading(verification, verification.plotted)}"
        for name, verification in zip(
            names or linkage_names(linkages), verifications, strict=True
        )
    ]


def motion_heading(verification: Verification, number: int) -> str:
    """Name a motion of a verification.

    Args:
        number: index of the motion.
    """
    if verification.crank is not None:
        return f"{verification.crank.joint} at {verification.crank.rpm:.6g} rpm"
    return f"motion {number + 1} of {len(verification.runs)}"


def pick_samples(run: Run, most: int) -> NDArray[np.int64]:
    """Choose samples of a motion evenly, at most so many."""
    size = run.trajectory.time.size
    return np.linspace(0, size - 1, min(size, most)).round().astype(np.int64)


def force_planes(linkage: Linkage, force: Array) -> list[tuple[str, Array]]:
    """Project forces (N, 3) on the planes of polar plots, each named by its axes.

    That of a planar linkage is its own, without a name.
    """
    if linkage.planar:
        return [("", force @ linkage.chain.frame.R[:2].T)]
    return [(f"{'xyz'[a]}{'xyz'[b]}", force[:, [a, b]]) for a, b in PLANES]


def run_curves(
    linkage: Linkage, time: Array, q: Array, force: Array, reach: float
) -> dict[str, object]:
    """Collect poses and curves of one motion.

    Args:
        q: positions of the joints (N, n).
        force: on the base (N, 3), N.
        reach: largest force that the polar plot shows, N.
    """
    seconds = short(time)
    return {
        "polar": polar_plot(linkage, seconds, force, reach),
        "time": seconds,
        "q": [short(each) for each in q],
        "force": [short(each) for each in force],
    }


def polar_plot(
    linkage: Linkage, time: list[float | None], force: Array, reach: float
) -> dict[str, object]:
    """Build the polar plot of the shaking force: its direction and size over the motion."""
    traces = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": ", ".join(plane),
            "x": short(xy[:, 0]),
            "y": short(xy[:, 1]),
            "follows": time,
            "line": {"color": COLOURS[k], "dash": DASHES[k], "width": 1.6},
        }
        for k, (plane, xy) in enumerate(force_planes(linkage, force))
    ]
    return {"data": traces, "layout": polar_layout(linkage, reach)}


def polar_layout(linkage: Linkage, reach: float) -> dict[str, object]:
    """Build the axes of a polar plot of forces, N, which reaches so far each way."""
    axes = ("first component of force (N)", "second component (N)")
    if linkage.planar:
        axes = ("force along the first axis (N)", "along the second axis (N)")
        if np.allclose(np.abs(linkage.chain.frame.R[:2, :2]), np.eye(2)):
            axes = ("force along x (N)", "force along y (N)")
    return {
        "polar": True,
        "xaxis": {"title": {"text": axes[0]}, "range": [-reach, reach]},
        "yaxis": {"title": {"text": axes[1]}, "range": [-reach, reach], "scaleanchor": "x"},
    }
