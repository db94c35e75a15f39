"""The momentum of every body as a line in space: axis, direction and pitch.

The momentum ``h = [ξ; p]`` of a body is a wrench. It acts along its central axis, through
``p × ξ / |p|²`` in the direction of p, with the pitch ``ξ·p / |p|²``. (R. S. Ball, *A
Treatise on the Theory of Screws*, 1900; J. J. de Jong, PhD thesis, University of Twente,
chapter 2, for momentum wrenches.)

In a balanced linkage these wrenches add up to zero, as forces in equilibrium do. Three
bodies in a plane: their lines have no pitch and meet in one point, which moves with the
pose, or are parallel. Three bodies in space: the wrenches are linearly dependent, and their
axes meet one common line, each at a right angle (they lie on a cylindroid); they meet in one
point if their pitches are equal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.momentum.regressor import momentum_regressor
from balance.tolerances import BODY_AT_REST, LINES_MEET, LINES_PARALLEL_SINE
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import PackageError
from kinematics.linalg.vectors import project_out
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.motion import Motion, motion_of
from kinematics.model_gallery import LinkageLike, as_linkage
from kinematics.spatial.screws import wrench_axis
from kinematics.wording import vector_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "Meeting",
    "ScrewLine",
    "common_normal",
    "meeting",
    "momentum_lines",
    "momentum_wrenches",
    "screw_figure",
]

Array = NDArray[np.float64]


class ScrewLine(NamedTuple):
    """The line of a body's momentum, in the inertial frame.

    Attributes:
        body: name of the body.
        point: point of the line nearest to the origin (3,), metres; zero for a couple.
        direction: unit vector (3,); zero for a body at rest.
        pitch: metres; ``inf`` for a couple, a momentum without linear part.
        magnitude: size of the linear momentum, or of a couple, per unit rate.
    """

    body: str
    point: Array
    direction: Array
    pitch: float
    magnitude: float

    def __repr__(self) -> str:
        """One line: the line, and the pitch."""
        if not self.direction.any():
            return f"ScrewLine of {self.body}: at rest"
        where = f"through {vector_text(self.point)} m along {vector_text(self.direction)}"
        return f"ScrewLine of {self.body}: {where}, pitch {self.pitch:.4g} m"


class Meeting(NamedTuple):
    """The point nearest to several lines.

    Attributes:
        point: least squares point (3,), metres, inertial frame.
        miss: largest distance of a line to it, metres.
    """

    point: Array
    miss: float

    def __repr__(self) -> str:
        """One line: the point, and how far lines miss it."""
        return f"Meeting at {vector_text(self.point)} m, missed by {self.miss:.2g} m"


def momentum_wrenches(
    linkage: LinkageLike,
    q: ArrayLike | Mapping[str, float],
    motion: Motion | str | Sequence[str] | None = None,
) -> Array:
    """Momentum of each body for a unit rate of each coordinate of the motion.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: displacements from the reference pose, of all joints or of the inputs alone; see
            `kinematics.closure.joint_positions.joint_positions`.
        motion: restriction of the inputs; its columns are those of `Motion.basis`.

    Returns:
        Shape (coordinates, bodies, 6): wrenches ``[ξ; p]`` about the inertial origin in the
        inertial frame, SI units.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.
        MotionError: a relation of the motion is wrong.
    """
    linkage = as_linkage(linkage)
    moving = motion_of(linkage, motion) or Motion.free(linkage.inputs)
    X = momentum_regressor(linkage, q, spatial=True)
    z = np.array([body.inertia for body in linkage.bodies]).reshape(-1, 10)
    by_input = np.einsum("urbp,bp->ubr", X.reshape(*X.shape[:2], *z.shape), z)
    return np.einsum("uw,ubr->wbr", moving.basis, by_input)


def momentum_lines(
    linkage: LinkageLike,
    q: ArrayLike | Mapping[str, float],
    motion: Motion | str | Sequence[str] | None = None,
) -> tuple[tuple[ScrewLine, ...], ...]:
    """The momentum of each body as a line, for each coordinate of the motion.

    Arguments and errors are those of `momentum_wrenches`. Bodies at rest have no direction.
    """
    linkage = as_linkage(linkage)
    wrenches = momentum_wrenches(linkage, q, motion)
    return tuple(_lines(linkage, column) for column in wrenches)


def _lines(linkage: Linkage, wrenches: Array) -> tuple[ScrewLine, ...]:
    """The lines of one column of wrenches (bodies, 6)."""
    sizes = np.linalg.norm(wrenches, axis=1)
    resting = sizes <= BODY_AT_REST * sizes.max(initial=0.0)
    lines = []
    for body, wrench, rest in zip(linkage.bodies, wrenches, resting, strict=True):
        axis = wrench_axis(np.zeros(6) if rest else wrench, BODY_AT_REST)
        lines.append(
            ScrewLine(body.name, axis.point, axis.direction, axis.pitch, axis.magnitude)
        )
    return tuple(lines)


def _proper(lines: Sequence[ScrewLine]) -> tuple[Array, Array]:
    """Points and directions (n, 3) of the lines of bodies that have linear momentum."""
    kept = [line for line in lines if line.magnitude > 0.0 and np.isfinite(line.pitch)]
    points = np.array([line.point for line in kept]).reshape(-1, 3)
    return points, np.array([line.direction for line in kept]).reshape(-1, 3)


def meeting(lines: Sequence[ScrewLine]) -> Meeting | None:
    """The point nearest to lines, ``min Σ |(1 - d dᵀ)(x - point)|²``.

    Couples and bodies at rest have no line and are passed over. Lines in a plane meet in
    it; the point is the nearest to the origin of those that do equally well.

    Returns:
        None if fewer than two lines remain or all are parallel: they meet at infinity.
    """
    points, directions = _proper(lines)
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    if len(points) < 2 or np.linalg.svd(directions)[1][1] < LINES_PARALLEL_SINE:
        return None
    feet = (across @ points[:, :, None]).reshape(-1)
    point = np.asarray(np.linalg.lstsq(across.reshape(-1, 3), feet, rcond=None)[0], np.float64)
    off = (across @ (point - points)[:, :, None])[:, :, 0]
    return Meeting(point, float(np.linalg.norm(off, axis=1).max()))


def common_normal(lines: Sequence[ScrewLine]) -> ScrewLine | None:
    """The line that the first two lines which are not parallel both meet at right angles.

    In a balanced linkage of three moving bodies the third line meets it, too, at a right
    angle. Its body has no name, its pitch and magnitude are those of a pure line: 0 and 1.

    Returns:
        None if all lines are parallel.
    """
    points, directions = _proper(lines)
    for i in range(len(points)):
        for j in range(i):
            normal = np.cross(directions[j], directions[i])
            size = float(np.linalg.norm(normal))
            if size < LINES_PARALLEL_SINE:
                continue
            n = normal / size
            # Slide along line j to its foot: the point nearest to line i.
            slide = np.cross(points[i] - points[j], directions[i]) @ n / size
            foot = points[j] + slide * directions[j]
            return ScrewLine("", project_out(foot, n), n, 0.0, 1.0)
    return None


def screw_figure(
    linkage: LinkageLike,
    q: ArrayLike | Mapping[str, float],
    column: int = 0,
    motion: Motion | str | Sequence[str] | None = None,
) -> Figure:
    """A Matplotlib figure of the lines at a pose, with the point where they meet.

    A planar linkage is drawn in its plane, a spatial one in three dimensions. Arrows show
    linear momentum, the longest a third of the picture; save it with ``figure.savefig``.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: the pose; see `momentum_wrenches`.
        column: the coordinate of the motion whose unit rate is drawn.
        motion: restriction of the inputs.

    Raises:
        PackageError: Matplotlib is not installed.
        IndexError: the motion has no such coordinate.
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
    _draw(axes, lines, _pivots(linkage, q), axes_of)
    axes.set_title(f"{linkage.name}: momentum of each body")
    for name, label in zip("xyz", ("x (m)", "y (m)", "z (m)")[: len(axes_of)], strict=False):
        getattr(axes, f"set_{name}label")(label)
    axes.legend(loc="best", fontsize="small")
    return figure


def _pivots(linkage: Linkage, q: ArrayLike | Mapping[str, float]) -> Array:
    """Points of all joints at a pose, carried by their parents; shape (joints, 3)."""
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
    """Pivots, lines with arrows, and the meeting point, in the axes of the picture."""
    met = meeting(lines)
    points, _ = _proper(lines)
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
        label = line.body if line.pitch == 0.0 else f"{line.body}, pitch {line.pitch:.3g} m"
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
