"""Drawing data of a linkage: rigid parts, joints, and what a page needs to move them.

All data are in the inertial frame at the reference pose, in metres. Links that move rigidly
together are one part; part 0 is the ground. At another pose the displacement of a part moves
its points. The page finds these displacements itself, from the screws and the loops.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from balance.support.tolerances import POINT_EQUAL_RELATIVE
from kinematics.closure.joint_positions import si_chain
from kinematics.model.arrays import Chain
from kinematics.model.chain import rigid_parts
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.model.spatial.inertia import pseudo_inertia
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.linalg.vectors import distinct_vectors
from kinematics.wording import number_text

# Range of a prismatic input to either side, characteristic lengths.
SLIDE_RANGE = 0.5


def scene(
    linkage: Linkage,
    motion: Motion | None = None,
    idle: Sequence[str] | None = None,
    shapes: Sequence[object] = (),
    unseen: Collection[str] = (),
) -> dict[str, object]:
    """Compute the drawing data of a linkage as plain data.

    Args:
        motion: relations of its inputs; None if they are free.
        idle: names of joints that do not move; by default those of the linkage.
        shapes: from `balance.app.answers.html.robot_shapes.robot_shapes`.
        unseen: names of joints that no one built, such as those that lead a tool.

    Returns:
        ``axes``, whose rows are the axes of the drawing, its last one the normal of a
        planar linkage; ``planar``; ``size``, the diagonal of the linkage in metres;
        ``parts``, ``joints``, ``bodies``, ``shapes``; ``mechanism``, the screws and loops that
        give the pose at joint positions; and ``columns``, the degrees of freedom of the motion.
    """
    chain = si_chain(linkage, spatial=True)
    part = rigid_parts(chain.parent.size, chain.ends)
    points = np.array([joint.point for joint in linkage.joints])
    seen = np.array([joint.name not in unseen for joint in linkage.joints])
    size = _size(points[seen], [_centre(body.inertia, body.frame) for body in linkage.bodies])
    bodies = [
        {
            "name": body.name,
            "part": int(part[body.link]),
            "link": body.link,
            "centre": _centre(body.inertia, body.frame).tolist(),
            "pseudo": pseudo_inertia(body.inertia).tolist(),
        }
        for body in linkage.bodies
    ]
    parts = _outlines(chain.parent, part, points, seen, size, bodies)
    for body in bodies:
        body["tip"] = _tip(parts[body["part"]]["corners"], body, linkage)
    return {
        "planar": linkage.planar,
        "axes": linkage.chain.frame.R.tolist(),
        "size": size,
        "parts": parts,
        "joints": _joint_data(linkage, part, seen, linkage.idle if idle is None else idle),
        "bodies": bodies,
        "shapes": list(shapes),
        "mechanism": _mechanism(linkage, chain, part),
        "columns": _motion_columns(linkage, motion or Motion.free(linkage.inputs)),
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
    parent: IntArray,
    part: IntArray,
    points: Array,
    seen: Flags,
    size: float,
    bodies: Sequence[dict],
) -> list[dict[str, object]]:
    """Compute the corners of each part in drawing order, and list its bodies.

    The corners are the centres of the joints that are seen. A part with one corner gets the
    centres of mass of its bodies as further corners.
    """
    outlines = []
    for p in range(int(part.max()) + 1):
        touching = ((part[parent] == p) | (part[:-1] == p)) & seen
        part_bodies = [body for body in bodies if body["part"] == p]
        corners = _distinct_points(points[touching], POINT_EQUAL_RELATIVE * size)
        if p and len(corners) == 1:
            ends = [np.asarray(body["centre"]) for body in part_bodies]
            corners = _distinct_points(np.array([*corners, *ends]), POINT_EQUAL_RELATIVE * size)
        outlines.append(
            {
                "names": [body["name"] for body in part_bodies],
                "corners": _sort_around(corners, POINT_EQUAL_RELATIVE * size).round(9).tolist(),
            }
        )
    return outlines


def _distinct_points(points: Array, apart: float) -> Array:
    """Return the points without repetitions."""
    if not len(points):
        return points
    return points[
        distinct_vectors(
            points, lambda some, point: np.linalg.norm(some - point, axis=1) <= apart
        )
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


def _tip(corners: Sequence[Sequence[float]], body: dict, linkage: Linkage) -> list[float]:
    """Choose the end of a body: the corner furthest from the joint that carries it."""
    start = linkage.joints[body["link"]].point
    ends = [*corners, body["centre"]] if len(corners) < 2 else corners
    away = [float(np.linalg.norm(np.asarray(corner) - start)) for corner in ends]
    return list(ends[first_largest(away)])


def _joint_data(
    linkage: Linkage, part: IntArray, seen: Flags, idle: Sequence[str]
) -> list[dict[str, object]]:
    """List the joints that are seen with their parts, points and directions."""
    entries = []
    for j, joint in enumerate(linkage.joints):
        if not seen[j]:
            continue
        direction = joint.screw[3:] if joint.kind == "prismatic" else joint.screw[:3]
        entries.append(
            {
                "name": joint.name,
                "kind": joint.kind,
                "idle": joint.name in idle,
                "parts": [int(part[joint.parent]), int(part[j])],
                "point": joint.point.tolist(),
                "direction": direction.tolist(),
            }
        )
    return entries


def _mechanism(linkage: Linkage, chain: Chain, part: IntArray) -> dict[str, object]:
    """Collect what gives the pose of every part at joint positions, in SI units.

    ``carriers`` has for each part the first link of it, -1 for the ground, whose displacement
    is that of the part.
    """
    _, first = np.unique(part[:-1], return_index=True)
    carriers = {int(part[link]): int(link) for link in first if part[link] > 0}
    return {
        "parent": chain.parent.tolist(),
        "screws": chain.screws.tolist(),
        "ends": chain.ends.tolist(),
        "mimics": chain.mimics.tolist(),
        "inputs": linkage.positions_of(linkage.inputs).tolist(),
        "length": linkage.chain.frame.length,
        "carriers": [carriers.get(p, -1) for p in range(int(part.max()) + 1)],
    }


def _motion_columns(linkage: Linkage, motion: Motion) -> list[dict[str, object]]:
    """List the degrees of freedom of a motion: one slider each.

    ``column`` has the displacements of the inputs of the linkage for a unit of the slider, and
    ``reach`` its range to either side if it slides, in metres; an angle has a full turn.
    """
    order = [motion.inputs.index(name) for name in linkage.inputs]
    length = linkage.chain.frame.length
    columns = []
    for c in motion.basis.T:
        free = next((i for i, x in enumerate(c) if x == 1.0), first_largest(np.abs(c)))
        columns.append(
            {
                "label": _label(motion.inputs, c, free),
                "angle": motion.inputs[free] not in linkage.sliding,
                "column": c[order].tolist(),
                "reach": SLIDE_RANGE * length / float(np.abs(c).max()),
            }
        )
    return columns


def _label(inputs: Sequence[str], column: Array, free: int) -> str:
    """Name the inputs that a direction moves: ``a``, ``a = b``, ``a = 2 b``."""
    moved = np.flatnonzero(column).tolist()
    if np.all(column[moved] == column[free]):
        return " = ".join(inputs[i] for i in moved)
    terms = []
    for i in (i for i in moved if i != free):
        ratio = number_text(abs(column[i] / column[free]), ".3g")
        sign = "" if column[i] * column[free] > 0 else "−"
        terms.append(f"{inputs[i]} = {sign}{'' if ratio == '1' else f'{ratio} '}{inputs[free]}")
    return ", ".join(terms)
