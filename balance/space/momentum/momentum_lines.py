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
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.space.momentum.regressor import momentum_regressor
from balance.support.tolerances import BODY_AT_REST, LINES_PARALLEL_SINE
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion, motion_of
from kinematics.model.spatial.screws import wrench_axis
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out
from kinematics.wording import number_text, vector_text


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
        return f"ScrewLine of {self.body}: {where}, pitch {number_text(self.pitch)} m"


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
        return (
            f"Meeting at {vector_text(self.point)} m, missed by "
            f"{number_text(self.miss, '.2g')} m"
        )


def momentum_wrenches(
    linkage: LinkageLike,
    q: ArrayLike | Mapping[str, float],
    motion: Motion | str | Sequence[str] | None = None,
) -> Array:
    """Compute the momentum of each body for a unit rate of each coordinate of the motion.

    ``h = [ξ; p]`` of a body, linear in its parameters; see `balance.space.momentum.regressor`.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: displacements from the reference pose, of all joints or of the inputs alone; see
            `kinematics.closure.joint_positions.joint_positions`; radians and metres.
        motion: restriction of the inputs; its columns are those of `Motion.basis`.

    Returns:
        Shape (coordinates, bodies, 6): wrenches ``[ξ; p]`` about the inertial origin in the
        inertial frame, SI units.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.
        MotionError: a relation of the motion is wrong.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, chapter 2.

    Example:
        >>> import balance
        >>> balance.momentum.momentum_wrenches("robot.urdf", {"u1": 0.1}).shape
        (1, 3, 6)
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
    """Compute the momentum of each body as a line, for each coordinate of the motion.

    The axis of the momentum ``[ξ; p]`` passes through ``p × ξ / |p|²`` along p, with the pitch
    ``ξ·p / |p|²``.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: the pose; see `momentum_wrenches`.
        motion: restriction of the inputs; its columns are those of `Motion.basis`.

    Returns:
        The lines of all bodies, coordinate by coordinate, in the inertial frame; bodies at
        rest have no direction.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.
        MotionError: a relation of the motion is wrong.

    Source:
        R. S. Ball, A Treatise on the Theory of Screws, 1900; J. J. de Jong, PhD thesis,
        University of Twente, chapter 2.

    Example:
        >>> import balance
        >>> lines, = balance.momentum.momentum_lines("robot.urdf", {"u1": 0.0})
        >>> lines[0]
        ScrewLine of crank: through (0.09103, 0.2124, 0) m along (-0.9191, 0.3939, 0), pitch 0 m
    """
    linkage = as_linkage(linkage)
    wrenches = momentum_wrenches(linkage, q, motion)
    return tuple(_lines_of_wrenches(linkage, column) for column in wrenches)


def _lines_of_wrenches(linkage: Linkage, wrenches: Array) -> tuple[ScrewLine, ...]:
    """Compute the lines of one column of wrenches (bodies, 6)."""
    sizes = np.linalg.norm(wrenches, axis=1)
    resting = sizes <= BODY_AT_REST * sizes.max(initial=0.0)
    lines = []
    for body, wrench, at_rest in zip(linkage.bodies, wrenches, resting, strict=True):
        axis = wrench_axis(np.zeros(6) if at_rest else wrench, BODY_AT_REST)
        lines.append(
            ScrewLine(body.name, axis.point, axis.direction, axis.pitch, axis.magnitude)
        )
    return tuple(lines)


def lines_of_moving_bodies(lines: Sequence[ScrewLine]) -> tuple[Array, Array]:
    """Collect points and directions of the lines of bodies that have linear momentum.

    Args:
        lines: the lines of one coordinate; couples and bodies at rest are left out.

    Returns:
        A point on each line (n, 3), metres, and its unit direction (n, 3).
    """
    kept = [line for line in lines if line.magnitude > 0.0 and np.isfinite(line.pitch)]
    points = np.array([line.point for line in kept]).reshape(-1, 3)
    return points, np.array([line.direction for line in kept]).reshape(-1, 3)


def meeting(lines: Sequence[ScrewLine]) -> Meeting | None:
    """Find the point nearest to lines, ``min Σ |(1 - d dᵀ)(x - point)|²``.

    Couples and bodies at rest have no line and are left out. If several points are equally
    near, as for lines in one plane, the point is the one nearest to the origin.

    Args:
        lines: the lines of one coordinate, as from `momentum_lines`.

    Returns:
        The point, metres, inertial frame; None if fewer than two lines remain or all are
        parallel.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, chapter 2: in a balanced planar linkage
        of three moving bodies the lines meet in one point.

    Example:
        >>> import balance
        >>> lines, = balance.momentum.momentum_lines("robot.urdf", {"u1": 0.0})
        >>> balance.momentum.meeting(lines)
        Meeting at (0.05125, 0.3295, 0) m, missed by 0.17 m
    """
    points, directions = lines_of_moving_bodies(lines)
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    if len(points) < 2 or np.linalg.svd(directions)[1][1] < LINES_PARALLEL_SINE:
        return None
    feet = (across @ points[:, :, None]).reshape(-1)
    point = np.asarray(np.linalg.lstsq(across.reshape(-1, 3), feet, rcond=None)[0], np.float64)
    off = (across @ (point - points)[:, :, None])[:, :, 0]
    return Meeting(point, float(np.linalg.norm(off, axis=1).max()))


def common_normal(lines: Sequence[ScrewLine]) -> ScrewLine | None:
    """Find the line that meets the first two lines which are not parallel at right angles.

    In a balanced linkage of three moving bodies the third line meets it, too, at a right
    angle: the three lie on a cylindroid. The line found belongs to no body: its name is empty,
    its pitch 0 and its magnitude 1.

    Args:
        lines: the lines of one coordinate, as from `momentum_lines`.

    Returns:
        The line in the inertial frame; None if all lines are parallel.

    Source:
        R. S. Ball, A Treatise on the Theory of Screws, 1900, for the cylindroid.

    Example:
        >>> import balance
        >>> lines, = balance.momentum.momentum_lines("robot.urdf", {"u1": 0.0})
        >>> abs(float(balance.momentum.common_normal(lines).direction[2]))
        1.0
    """
    points, directions = lines_of_moving_bodies(lines)
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
