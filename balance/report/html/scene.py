"""Drawing data of a linkage: rigid parts, joints, and poses along its motion.

All data are in the inertial frame at the reference pose, in metres. Links that move rigidly
together are one part; part 0 is the ground. At another pose the displacement of a part moves
its points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from balance.spaces.design_space import DesignSpace
from balance.tolerances import POINT_EQUAL_RELATIVE
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.errors import PoseError
from kinematics.linalg.vectors import distinct_vectors
from kinematics.model.arrays import Chain
from kinematics.model.chain import rigid_parts
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.spatial.inertia import pseudo_inertia

__all__ = ["scene"]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Range of a revolute input to either side, radians.
ANGLE_RANGE = np.pi / 3.0
# Range of a prismatic input to either side, characteristic lengths.
SLIDE_RANGE = 0.5
# Poses to either side of the reference pose.
MAX_STEPS = 20
# The least number of them, for linkages with many links.
MIN_STEPS = 3
# Most numbers in all poses, which limits the size of the page.
MAX_NUMBERS = 400_000


def scene(space: DesignSpace) -> dict[str, object]:
    """Compute the drawing data of a linkage as plain data.

    Returns:
        ``axes``, whose rows are the axes of the drawing, its last one the normal of a
        planar linkage; ``planar``; ``size``, the diagonal of the linkage in metres;
        ``parts``, ``joints``, ``bodies``, and ``columns``: the poses along each degree of
        freedom of the motion.
    """
    linkage = space.linkage
    chain = si_chain(linkage, spatial=True)
    part = rigid_parts(chain.parent.size, chain.ends)
    points = np.array([joint.point for joint in linkage.joints])
    size = _size(points, [_centre(body.inertia, body.frame) for body in linkage.bodies])
    bodies = [
        {"name": body.name, "part": int(part[body.link]),
         "centre": _centre(body.inertia, body.frame).tolist(),
         "pseudo": pseudo_inertia(body.inertia).tolist()}
        for body in linkage.bodies
    ]  # fmt: skip
    return {
        "planar": linkage.planar,
        "axes": linkage.chain.frame.R.tolist(),
        "size": size,
        "parts": _outlines(chain.parent, part, points, size, bodies),
        "joints": _joint_data(space, part),
        "bodies": bodies,
        "columns": _motion_columns(space, chain, part),
    }


def _centre(inertia: Array, frame: Array) -> Array:
    """Return the centre of mass, or the origin of the link frame without mass."""
    return inertia[1:4] / inertia[0] if inertia[0] > 0.0 else frame[:3, 3]


def _size(points: Array, centres: Sequence[Array]) -> float:
    """Compute the diagonal of the box around the joints, or the bodies if joints coincide."""
    span = float(np.linalg.norm(np.ptp(points, axis=0)))
    if span == 0.0:
        span = float(np.linalg.norm(np.ptp([*points, *centres], axis=0)))
    return span or 1.0


def _outlines(
    parent: IntArray, part: IntArray, points: Array, size: float, bodies: Sequence[dict]
) -> list[dict[str, object]]:
    """Compute the corners of each part in drawing order, and list its bodies.

    The corners are the joint centres. A part with one corner gets the centres of mass of its
    bodies as further corners.
    """
    outlines = []
    for p in range(int(part.max()) + 1):
        touching = (part[parent] == p) | (part[:-1] == p)
        own = [body for body in bodies if body["part"] == p]
        corners = _distinct_points(points[touching], POINT_EQUAL_RELATIVE * size)
        if p and len(corners) == 1:
            ends = [np.asarray(body["centre"]) for body in own]
            corners = _distinct_points(np.array([*corners, *ends]), POINT_EQUAL_RELATIVE * size)
        outlines.append({
            "names": [body["name"] for body in own],
            "corners": _sort_around(corners, POINT_EQUAL_RELATIVE * size).round(9).tolist(),
        })  # fmt: skip
    return outlines


def _distinct_points(points: Array, apart: float) -> Array:
    """Return the points without repetitions."""
    return points[
        distinct_vectors(points, lambda some, one: np.linalg.norm(some - one, axis=1) <= apart)
    ]


def _sort_around(points: Array, apart: float) -> Array:
    """Sort points around their mean, or along their line."""
    if len(points) < 3:
        return points
    off = points - points.mean(axis=0)
    values, axes = np.linalg.svd(off, full_matrices=False)[1:]
    along = off @ axes.T
    if values[1] <= apart:
        return points[np.argsort(along[:, 0])]
    return points[np.argsort(np.arctan2(along[:, 1], along[:, 0]))]


def _joint_data(space: DesignSpace, part: IntArray) -> list[dict[str, object]]:
    """List the joints with their parts, points and directions."""
    found = []
    for j, joint in enumerate(space.linkage.joints):
        direction = joint.screw[3:] if joint.kind == "prismatic" else joint.screw[:3]
        found.append({
            "name": joint.name,
            "kind": joint.kind,
            "idle": joint.name in space.idle,
            "parts": [int(part[joint.parent]), int(part[j])],
            "point": joint.point.tolist(),
            "direction": direction.tolist(),
        })  # fmt: skip
    return found


def _motion_columns(
    space: DesignSpace, chain: Chain, part: IntArray
) -> list[dict[str, object]]:
    """Compute poses along each degree of freedom of the motion; the others stay at 0."""
    motion = space.motion or Motion.free(space.inputs)
    count = motion.basis.shape[1] * (12 * int(part.max() + 1) + 6 * len(space.bodies))
    steps = int(np.clip(MAX_NUMBERS // (2 * count + 1), MIN_STEPS, MAX_STEPS))
    return [_poses_along(space, chain, part, motion, c, steps) for c in motion.basis.T]


def _poses_along(
    space: DesignSpace, chain: Chain, part: IntArray, motion: Motion, column: Array, steps: int
) -> dict[str, object]:
    """Compute poses along one direction of input displacements, while the loops close.

    ``poses`` has for each value and part the first three rows of its displacement in one list
    of 12, or None if the part does not move. ``rates`` has for each value and body its twist
    ``[ω; v]`` about the inertial origin, for a unit rate along the direction.
    """
    linkage = space.linkage
    free = next((i for i, c in enumerate(column) if c == 1.0), int(np.argmax(np.abs(column))))
    slides = [
        linkage.joints[j].kind == "prismatic" for j in linkage.positions_of(motion.inputs)
    ]
    limits = np.where(slides, SLIDE_RANGE * space.length, ANGLE_RANGE)
    reach = float(np.min(limits[column != 0.0] / np.abs(column[column != 0.0])))
    values, found = (
        [0.0],
        [_pose_data(space, chain, part, motion, column, np.zeros(len(part) - 1))],
    )
    for side in (1, -1):
        for k in range(1, steps + 1):
            value = side * reach * k / steps
            try:
                q = _positions_at(linkage, motion, value * column)
            except PoseError:
                break
            values.insert(k if side > 0 else 0, value)
            found.insert(
                k if side > 0 else 0,
                _pose_data(space, chain, part, motion, column, q),
            )
    return {
        "label": _label(motion.inputs, column, free),
        "input": motion.inputs[free],
        "angle": not slides[free],
        "stopped": [not np.isclose(values[0], -reach), not np.isclose(values[-1], reach)],
        "values": values,
        "poses": [rows for rows, _ in found],
        "rates": [twists for _, twists in found],
    }


def _positions_at(linkage: Linkage, motion: Motion, u: Array) -> Array:
    """Compute positions of all joints at displacements of the inputs."""
    return joint_positions(linkage, dict(zip(motion.inputs, u.tolist(), strict=True)))


def _pose_data(
    space: DesignSpace, chain: Chain, part: IntArray, motion: Motion, column: Array, q: Array
) -> tuple[list[list[float] | None], list[list[float]]]:
    """Compute displacements of all parts, and twists of all bodies at a unit rate."""
    pose = forward_kinematics(chain, q)
    series = expand_from(chain, pose.screws, np.zeros((1, chain.width)), 0)
    links = [body.link for body in space.linkage.bodies]
    order = [motion.inputs.index(name) for name in space.linkage.inputs]
    twists = np.einsum("bwi,w->bi", series.T[0, 0, links], column[order])
    return _part_rows(pose.H, part), twists.round(9).tolist()


def _part_rows(H: Array, part: IntArray) -> list[list[float] | None]:
    """Convert displacements of links to those of parts; None for a part that rests."""
    _, first = np.unique(part[:-1], return_index=True)
    carried = H[first[part[first] > 0]]
    still = np.all(carried == np.eye(4), axis=(1, 2))
    rows = carried[:, :3].reshape(-1, 12).round(9).tolist()
    return [None, *(None if s else row for s, row in zip(still, rows, strict=True))]


def _label(inputs: Sequence[str], column: Array, free: int) -> str:
    """Name the inputs that a direction moves: ``a``, ``a = b``, ``a = 2 b``."""
    moved = np.flatnonzero(column).tolist()
    if np.all(column[moved] == column[free]):
        return " = ".join(inputs[i] for i in moved)
    terms = []
    for i in (i for i in moved if i != free):
        ratio = f"{abs(column[i] / column[free]):.3g}"
        sign = "" if column[i] * column[free] > 0 else "−"
        terms.append(f"{inputs[i]} = {sign}{'' if ratio == '1' else f'{ratio} '}{inputs[free]}")
    return ", ".join(terms)
