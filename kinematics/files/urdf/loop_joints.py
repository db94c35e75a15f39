"""Convert joints to chains of single freedoms, and loops to such chains plus a weld.

A loop joins a predecessor and a successor link by a joint of any type. Its freedoms become
joints that the predecessor carries, and the far end of that chain is welded to the successor.
At the pose of the file the two frames of the loop may differ by a motion that the joint allows;
the rest of the difference is the gap of the weld.

Angular parts come first in screws, and everything is in the inertial frame, in SI units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinematics.files.urdf.robot_tree import pose_matrix
from kinematics.model.arrays import freeze
from kinematics.model.chain import loop_joints
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import coordinate_names
from kinematics.model.linkage import GROUND, Joint, LinkPose, Loop
from kinematics.model.spatial.screws import exp, prismatic, revolute
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.linalg.vectors import project_out
from kinematics.numerics.tolerances import (
    LOOP_FRAME_DISTANCE,
    LOOP_FRAME_ROUND_OFF,
    UNIVERSAL_AXES_PARALLEL_SINE,
)

FREEDOMS = {
    "fixed": (),
    "revolute": ("turn n",),
    "continuous": ("turn n",),
    "prismatic": ("slide n",),
    "universal": ("turn n", "turn u"),
    "cylindrical": ("turn n", "slide n"),
    "planar": ("slide u", "slide w", "turn n"),
    "spherical": ("turn n", "turn u", "turn w"),
    "floating": ("slide n", "slide u", "slide w", "turn n", "turn u", "turn w"),
}
"""The single freedoms of each type of joint, along its axes n, u and w = n × u."""


def unit_vector(axis: ArrayLike) -> Array:
    """Normalise an axis (3,), which is not zero."""
    a = np.asarray(axis, dtype=np.float64)
    a = a / np.abs(a).max()
    return a / np.linalg.norm(a)


def perpendicular_to(n: Array, direction: ArrayLike | None = None) -> Array:
    """Compute the unit vector perpendicular to ``n`` that is nearest to ``direction``.

    Args:
        n: unit vector (3,).
        direction: vector (3,), not along ``n``; by default the coordinate axis after the one
            nearest to ``n``: y if n = x, z if n = y, x if n = z.

    Returns:
        Unit vector (3,).
    """
    if direction is None:
        d = np.roll(np.eye(3), 1, axis=1)[first_largest(np.abs(n))]
    else:
        d = unit_vector(direction)
    return unit_vector(project_out(d, n))


def has_one_axis(kind: str) -> bool:
    """Whether a type of joint moves about and along its axis n alone."""
    return all(step.endswith(" n") for step in FREEDOMS[kind])


def freedoms_of_joint(
    kind: str, n: Array, u: Array | None, point: Array
) -> list[tuple[str, Array]]:
    """Compute the single freedoms of a joint, from its fixed side to its moving side.

    Args:
        kind: type of the joint in the file.
        n: its axis, a unit vector (3,): the normal of a planar joint and the first
            axis of a universal or spherical one.
        u: unit vector (3,) perpendicular to ``n``: second axis of a universal or spherical
            joint, first direction of a planar one. The third is ``n × u``. None for a joint
            that `has_one_axis`.
        point: a point of every rotation axis (3,), in metres.

    Returns:
        Kind (``"revolute"`` or ``"prismatic"``) and screw (6,) of each.
    """
    directions = {"n": n} if u is None else {"n": n, "u": u, "w": np.cross(n, u)}
    steps = []
    for motion, axis in (step.split() for step in FREEDOMS[kind]):
        if motion == "turn":
            steps.append(("revolute", revolute(directions[axis], point)))
        else:
            steps.append(("prismatic", prismatic(directions[axis])))
    return steps


def attach_loop(
    loop: Element, places: Mapping[str, LinkPose], before_it: Sequence[Joint], extent: float
) -> tuple[list[Joint], Loop]:
    """Compute the joints and the weld of a ``<loop>`` element.

    The loop's axis is in the frame of the predecessor, its second axis (universal loops
    only) in that of the successor, with the default of `perpendicular_to`.

    Args:
        places: rigid body and pose (4, 4) of each link of the file, inertial frame.
        before_it: the joints before those of the loop.
        extent: size of the linkage, metres.

    Returns:
        Up to three joints in a chain, and the weld at its end, in the inertial frame.
    """
    kind = loop.attributes["type"]
    start, before = _end(loop, "predecessor", places)
    end, after = _end(loop, "successor", places)
    axis = _direction(loop, "axis", np.array([1.0, 0.0, 0.0]))
    n, u = before[:3, :3] @ axis, before[:3, :3] @ perpendicular_to(axis)
    reached = _nearest_pose(kind, before, after, n)
    if kind == "universal":
        second = after[:3, :3] @ _direction(loop, "axis2", perpendicular_to(axis))
        angle = float(np.arctan2(n @ second, np.linalg.norm(np.cross(n, second))))
        tilt = _rotation(_across(n, np.cross(n, second)), angle)
        reached[:3, :3] = tilt @ after[:3, :3]
        u = _across(n, tilt @ second)
    centre = reached[:3, 3] if kind == "planar" else before[:3, 3]
    distance = LOOP_FRAME_DISTANCE * _loop_size(before_it, start, end, centre)
    distance += LOOP_FRAME_ROUND_OFF * extent
    joints: list[Joint] = []
    first = len(before_it)
    steps = freedoms_of_joint(kind, n, u, centre)
    names, point = coordinate_names(loop.name, kind), freeze(centre)
    for name, (motion, screw) in zip(names, steps, strict=True):
        parent = first + len(joints) - 1 if joints else start
        joints.append(Joint(name, motion, parent, freeze(screw), point, True, len(names) > 1))
    last = first + len(joints) - 1 if joints else start
    if last == GROUND:
        return joints, Loop(loop.name, end, GROUND, _gap(after, reached, distance))
    return joints, Loop(loop.name, last, end, _gap(reached, after, distance))


def _end(loop: Element, role: str, places: Mapping[str, LinkPose]) -> LinkPose:
    """Find the rigid body at one side of a loop, and the pose of the loop's frame there."""
    side = loop.first(role) or loop
    link, pose = places[side.attributes["link"]]
    return LinkPose(link, pose @ pose_matrix(side.first("origin")))


def _direction(loop: Element, tag: str, default: Array) -> Array:
    """Compute the unit vector (3,) of an axis of a loop, in the frame of its link."""
    item = loop.first(tag)
    return default if item is None else unit_vector(item.vector("xyz", ""))


def _across(n: Array, second: Array) -> Array:
    """``second``, made perpendicular to ``n``; any perpendicular if it is along ``n``."""
    along = np.linalg.norm(np.cross(n, second)) <= UNIVERSAL_AXES_PARALLEL_SINE
    return perpendicular_to(n) if along else perpendicular_to(n, second)


def _rotation(axis: Array, angle: float) -> Array:
    """Rotation matrix (3, 3) about a unit vector."""
    return exp(revolute(axis, np.zeros(3)), angle)[:3, :3]


def _nearest_pose(kind: str, before: Array, after: Array, n: Array) -> Array:
    """Compute the pose (4, 4) nearest to ``after`` to which the joint can move ``before``.

    Positions: the foot of the offset d on the line or the plane of the joint. Rotations
    about n: ``tr(Q Rot(n, θ)ᵀ) = nᵀQn + (tr Q - nᵀQn) cos θ + n·vee(Q - Qᵀ) sin θ`` is
    greatest at the θ taken, with Q the rotation from ``before`` to ``after``.
    """
    reached = before.copy()
    d = after[:3, 3] - before[:3, 3]
    if kind in ("prismatic", "cylindrical"):
        reached[:3, 3] += (n @ d) * n
    elif kind == "planar":
        reached[:3, 3] += project_out(d, n)
    if kind == "spherical":
        reached[:3, :3] = after[:3, :3]
    elif kind in ("revolute", "continuous", "cylindrical", "planar"):
        Q = after[:3, :3] @ before[:3, :3].T
        skew_part = np.array([Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]])
        angle = float(np.arctan2(n @ skew_part, np.trace(Q) - n @ Q @ n))
        reached[:3, :3] = _rotation(n, angle) @ before[:3, :3]
    return reached


def _loop_size(joints: Sequence[Joint], start: int, end: int, centre: Array) -> float:
    """Distance of the furthest joint along a loop from the point where it closes, metres."""
    around = loop_joints([joint.parent for joint in joints], start, end)
    points = [joints[j].point - centre for j in around]
    return max((float(np.linalg.norm(point)) for point in points), default=0.0)


def _gap(here: Array, there: Array, size: float) -> Array:
    """Compute the displacement D with ``D here = there``.

    It is exactly the identity if the frames coincide, no further apart than ``size`` metres.
    """
    D = np.eye(4)
    D[:3, :3] = there[:3, :3] @ here[:3, :3].T
    offset = np.abs(there[:3, 3] - here[:3, 3]).max()
    angle = np.abs(D[:3, :3] - np.eye(3)).max()
    if offset <= size and angle <= LOOP_FRAME_DISTANCE:
        return freeze(np.eye(4))
    D[:3, 3] = there[:3, 3] - D[:3, :3] @ here[:3, 3]
    return freeze(D)
