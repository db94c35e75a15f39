"""Pictures of flexible links: modes, supports, shaking over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from balance.app.answers.html.plot_style import image, tidy
from balance.app.answers.html.time_panels import COLOURS, STYLES
from balance.motion.flexible.free_beam_modes import FreeMode, mode_shape
from balance.motion.flexible.linkage_motion import FlexibleSimulation
from balance.motion.flexible.simulate import FlexibleMotion
from balance.motion.flexible.support_points import SupportPoints
from balance.motion.flexible.supported_beam_modes import SupportedModes

MOST_CURVES = 6
SMALL_FORCE = 0.05
"""Forces below this part of the moment (over the pitch, if there is one) are drawn in mN."""


def one_panel_picture(
    motion: FlexibleMotion, pitch: float | None = None, kind: str = "png"
) -> bytes:
    """Draw shaking force and moment about the origin in one panel, as the literature does.

    The force along x is dash-dotted, along y dashed; the moment is continuous.

    Args:
        motion: the motion of arms on a hub, or of translators.
        pitch: length by which the moment is divided, in metres; None: it is drawn as it is.
        kind: ``"png"`` or ``"svg"``.

    Raises:
        PackageError: Matplotlib is missing.
    """
    moment = motion.moment / (pitch or 1.0)
    small = motion.peak_force < SMALL_FORCE * np.abs(moment).max()
    unit = "mN" if small else "N"
    other = "moment (N m)" if pitch is None else "moment / pitch (N)"

    def draw(figure: Any) -> None:
        ax = figure.subplots()
        for k, style in enumerate(("-.", "--")):
            values = motion.force[:, k] * (1e3 if small else 1.0)
            ax.plot(
                motion.times,
                values,
                color=COLOURS[k],
                ls=style,
                lw=1.0,
                label=f"force along {'xy'[k]} ({unit})",
            )
        ax.plot(motion.times, moment, color=COLOURS[2], lw=1.2, label=other)
        ax.set_xlabel("time (s)")
        ax.set_ylabel("shaking of the mount")
        ax.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0))
        tidy(ax)

    return image((6.5, 4.0), kind, draw)


def shaking_picture(simulation: FlexibleSimulation, kind: str = "png") -> bytes:
    """Draw shaking force and moment over time."""
    motion, moment = simulation.motion, simulation.moment

    def draw(figure: Any) -> None:
        upper, lower = figure.subplots(2, 1, sharex=True)
        for k, axis in enumerate("xy"):
            upper.plot(
                motion.times,
                motion.force[:, k],
                color=COLOURS[k],
                ls=STYLES[k],
                lw=1.0,
                label=f"force along {axis}",
            )
        lower.plot(motion.times, moment, color=COLOURS[2], lw=1.0)
        upper.set_ylabel("shaking force (N)")
        lower.set_ylabel("shaking moment (N m)")
        lower.set_xlabel("time (s)")
        upper.legend(frameon=False, ncols=2, loc="upper left", bbox_to_anchor=(0.0, 1.12))
        for ax in (upper, lower):
            tidy(ax)

    return image((6.5, 5.0), kind, draw)


def free_modes_picture(modes: Sequence[FreeMode], kind: str = "png") -> bytes:
    """Draw the first modes of a free beam, with their nodes."""

    def draw(figure: Any) -> None:
        ax, xi = figure.subplots(), np.linspace(-0.5, 0.5, 401)
        for k, mode in enumerate(modes[:MOST_CURVES]):
            ax.plot(
                xi,
                mode_shape(mode.number, xi, mode.wave_number),
                color=COLOURS[k],
                ls=STYLES[k],
                lw=1.2,
                label=f"mode {mode.number}",
            )
            nodes = np.array([*mode.zeros, *(-zero for zero in mode.zeros)])
            ax.plot(nodes, 0.0 * nodes, "o", color=COLOURS[k], ms=4.0)
        ax.set_xlabel("distance from the middle, of the length")
        ax.set_ylabel("displacement, of the cosine's amplitude")
        ax.legend(
            frameon=False,
            ncols=MOST_CURVES,
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            columnspacing=1.0,
        )
        tidy(ax)

    return image((6.5, 4.0), kind, draw)


def supported_modes_picture(modes: SupportedModes, kind: str = "png") -> bytes:
    """Draw the first modes of a beam on supports."""

    def draw(figure: Any) -> None:
        ax = figure.subplots()
        for k, shape in enumerate(modes.shapes[:MOST_CURVES]):
            hertz = modes.frequencies[k] / (2.0 * np.pi)
            ax.plot(
                modes.positions,
                shape,
                color=COLOURS[k],
                ls=STYLES[k],
                lw=1.2,
                label=f"{hertz:.4g} Hz",
            )
        ax.set_xlabel("position along the beam (m)")
        ax.set_ylabel("displacement, of the largest")
        ax.legend(frameon=False, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.15))
        tidy(ax)

    return image((6.5, 4.0), kind, draw)


def supports_picture(supports: SupportPoints, kind: str = "png") -> bytes:
    """Draw supports: the weight of each point along the beam."""

    def draw(figure: Any) -> None:
        ax = figure.subplots()
        ax.plot([-0.5, 0.5], [0.0, 0.0], color=COLOURS[2], lw=3.0)
        ax.vlines(supports.points, 0.0, supports.weights, color=COLOURS[0], lw=1.5)
        ax.plot(supports.points, supports.weights, "o", color=COLOURS[0], ms=5.0)
        ax.set_xlabel("distance from the middle, of the length")
        ax.set_ylabel("weight")
        tidy(ax)

    return image((6.5, 2.6), kind, draw)
