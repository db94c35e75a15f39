"""A picture of the momentum of every body as a line in space, by Matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from balance.space.momentum.momentum_lines import (
    ScrewLine,
    lines_of_moving_bodies,
    meeting,
    momentum_lines,
)
from balance.support.tolerances import LINES_MEET
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import PackageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def screw_figure(
    linkage: LinkageLike,
    q: ArrayLike | Mapping[str, float],
    column: int = 0,
    motion: Motion | str | Sequence[str] | None = None,
) -> Figure:
    """Draw the momentum lines at a pose, with the point where they meet, by Matplotlib.

    A planar linkage is drawn in its plane, a spatial one in three dimensions. Arrows show
    linear momentum, the longest a third of the picture; save it with ``figure.savefig``.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: the pose; see `momentum_wrenches`.
        column: number of the coordinate of the motion whose unit rate is drawn.
        motion: restriction of the inputs.

    Returns:
        A Matplotlib figure; lengths in metres, in inertial axes or in the axes of the plane.

    Raises:
        PackageError: Matplotlib is not installed.
        IndexError: the motion has no such coordinate.
        PoseError: the pose does not close the loops, or cannot be reached.
        MotionError: a relation of the motion is wrong.

    Source:
        R. S. Ball, A Treatise on the Theory of Screws, 1900.

    Example:
        >>> import balance
        >>> figure = balance.momentum.screw_figure("robot.urdf", {"u1": 0.1})
        >>> len(figure.axes)
        1
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise PackageError("a picture", "Matplotlib", "pip install matplotlib") from None
    linkage = as_linkage(linkage)
    lines = momentum_lines(linkage, q, motion)[column]
    axes_of = linkage.chain.frame.R[:2] if linkage.planar else np.eye(3)
    figure = Figure(figsize=(7.0, 6.0), layout="constrained")
    axes = figure.add_subplot(projection=None if linkage.planar else "3d")
    _draw(axes, lines, _joint_points(linkage, q), axes_of)
    axes.set_title(f"{linkage.name}: momentum of each body")
    for name, label in zip("xyz", ("x (m)", "y (m)", "z (m)")[: len(axes_of)], strict=False):
        getattr(axes, f"set_{name}label")(label)
    axes.legend(loc="best", fontsize="small")
    return figure


def _joint_points(linkage: Linkage, q: ArrayLike | Mapping[str, float]) -> Array:
    """Compute the points of all joints at a pose, carried by their parents; (joints, 3)."""
    H = forward_kinematics(si_chain(linkage, True), joint_positions(linkage, q)).H
    return np.array(
        [
            joint.point
            if joint.parent == GROUND
            else (H[joint.parent] @ np.append(joint.point, 1.0))[:3]
            for joint in linkage.joints
        ]
    )


def _draw(axes: Axes, lines: Sequence[ScrewLine], pivots: Array, axes_of: Array) -> None:
    """Draw joints, lines with arrows, and the meeting point, in the axes of the picture."""
    met = meeting(lines)
    points, _ = lines_of_moving_bodies(lines)
    near = np.vstack([pivots, points]) if met is None else np.vstack([pivots, met.point])
    size = float(np.ptp(near, axis=0).max()) or 1.0
    centre = (near.max(axis=0) + near.min(axis=0)) / 2.0
    largest = max((line.magnitude for line in lines if np.isfinite(line.pitch)), default=0.0)
    axes.plot(*(pivots @ axes_of.T).T, "o", color="0.5", markersize=4, label="joints")
    for number, line in enumerate(lines):
        if not (line.magnitude > 0.0 and np.isfinite(line.pitch)):
            continue
        foot = line.point + (centre - line.point) @ line.direction * line.direction
        ends = foot + np.outer([-size, size], line.direction)
        colour = f"C{number}"
        label = (
            line.body
            if line.pitch == 0.0
            else f"{line.body}, pitch {number_text(line.pitch, '.3g')} m"
        )
        axes.plot(*(ends @ axes_of.T).T, color=colour, linewidth=1, label=label)
        step = line.direction * size * line.magnitude / (3.0 * largest)
        axes.quiver(*(axes_of @ foot), *(axes_of @ step), color=colour, **_arrow(axes_of))
    if met is not None and met.miss <= LINES_MEET * size:
        axes.plot(*(axes_of @ met.point)[:, None], "k*", markersize=11, label="meeting point")
    axes.set_aspect("equal")


def _arrow(axes_of: Array) -> dict[str, Any]:
    """Options of an arrow in data units, in the plane; in space these are the default."""
    if len(axes_of) == 3:
        return {}
    return {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.006}
