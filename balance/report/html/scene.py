"""A linkage as something to draw: rigid parts, joints, and poses along its motion.

Everything is in the inertial frame at the reference pose, in metres. A part is what moves
rigidly together; part 0 is the ground. A point of a part is drawn, at another pose, where
the displacement of the part takes it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from balance.spaces.design_space_result import DesignSpace
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

# How far an input goes to either side: radians, and characteristic lengths.
ANGLE, SHARE = np.pi / 3.0, 0.5
# Steps to either side; fewer where a linkage has so many links that they fill the page.
STEPS, FEWEST, NUMBERS = 20, 3, 400_000


def scene(space: DesignSpace) -> dict[str, object]:
    """What there is to draw, as plain data.

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
        "joints": _joints(space, part),
        "bodies": bodies,
        "columns": _columns(space, chain, part),
    }


def _centre(inertia: Array, frame: Array) -> Array:
    """Centre of mass, or the origin of the link frame if there is no mass."""
    return inertia[1:4] / inertia[0] if inertia[0] > 0.0 else frame[:3, 3]


def _size(points: Array, centres: Sequence[Array]) -> float:
    """Diagonal of the box around the joints, or around the bodies if they all coincide."""
    span = float(np.linalg.norm(np.ptp(points, axis=0)))
    if span == 0.0:
        span = float(np.linalg.norm(np.ptp([*points, *centres], axis=0)))
    return span or 1.0


def _outlines(
    parent: IntArray, part: IntArray, points: Array, size: float, bodies: Sequence[dict]
) -> list[dict[str, object]]:
    """For each part: its corners in an order to draw them, and the bodies that make it up.

    The corners are the joint centres. A part with a body and one corner gets the centre of
    the body as its other end.
    """
    outlines = []
    for p in range(int(part.max()) + 1):
        touching = (part[parent] == p) | (part[:-1] == p)
        own = [body for body in bodies if body["part"] == p]
        corners = _distinct(points[touching], POINT_EQUAL_RELATIVE * size)
        if p and len(corners) == 1:
            ends = [np.asarray(body["centre"]) for body in own]
            corners = _distinct(np.array([*corners, *ends]), POINT_EQUAL_RELATIVE * size)
        outlines.append({
            "names": [body["name"] for body in own],
            "corners": _around(corners, POINT_EQUAL_RELATIVE * size).round(9).tolist(),
        })  # fmt: skip
    return outlines


def _distinct(points: Array, apart: float) -> Array:
    """The points without repetitions."""
    return points[
        distinct_vectors(points, lambda some, one: np.linalg.norm(some - one, axis=1) <= apart)
    ]


def _around(points: Array, apart: float) -> Array:
    """The points in an order around their middle, or along their line."""
    if len(points) < 3:
        return points
    off = points - points.mean(axis=0)
    values, axes = np.linalg.svd(off, full_matrices=False)[1:]
    along = off @ axes.T
    if values[1] <= apart:
        return points[np.argsort(along[:, 0])]
    return points[np.argsort(np.arctan2(along[:, 1], along[:, 0]))]


def _joints(space: DesignSpace, part: IntArray) -> list[dict[str, object]]:
    """Joints: the parts they join, where, and in which direction."""
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


def _columns(space: DesignSpace, chain: Chain, part: IntArray) -> list[dict[str, object]]:
    """Poses along each degree of freedom of the motion, the others staying at 0."""
    motion = space.motion or Motion.free(space.inputs)
    count = motion.basis.shape[1] * (12 * int(part.max() + 1) + 6 * len(space.bodies))
    steps = int(np.clip(NUMBERS // (2 * count + 1), FEWEST, STEPS))
    return [_column(space, chain, part, motion, c, steps) for c in motion.basis.T]


def _column(
    space: DesignSpace, chain: Chain, part: IntArray, motion: Motion, column: Array, steps: int
) -> dict[str, object]:
    """Poses along one direction of input displacements, as far as the loops can be closed.

    ``poses`` holds for each value, for each part, the first three rows of its displacement
    in one list of 12, or None if it does not move; ``rates`` for each body its twist
    ``[ω; v]`` about the inertial origin while the column runs at unit speed.
    """
    linkage = space.linkage
    free = next((i for i, c in enumerate(column) if c == 1.0), int(np.argmax(np.abs(column))))
    slides = [
        linkage.joints[j].kind == "prismatic" for j in linkage.positions_of(motion.inputs)
    ]
    limits = np.where(slides, SHARE * space.length, ANGLE)
    reach = float(np.min(limits[column != 0.0] / np.abs(column[column != 0.0])))
    values, found = [0.0], [_drawn(space, chain, part, motion, column, np.zeros(len(part) - 1))]
    for side in (1, -1):
        for k in range(1, steps + 1):
            value = side * reach * k / steps
            try:
                q = _at(linkage, motion, value * column)
            except PoseError:
                break
            values.insert(k if side > 0 else 0, value)
            found.insert(k if side > 0 else 0, _drawn(space, chain, part, motion, column, q))
    return {
        "label": _label(motion.inputs, column, free),
        "input": motion.inputs[free],
        "angle": not slides[free],
        "stopped": [not np.isclose(values[0], -reach), not np.isclose(values[-1], reach)],
        "values": values,
        "poses": [rows for rows, _ in found],
        "rates": [twists for _, twists in found],
    }


def _at(linkage: Linkage, motion: Motion, u: Array) -> Array:
    """Positions of all joints at displacements of the inputs."""
    return joint_positions(linkage, dict(zip(motion.inputs, u.tolist(), strict=True)))


def _drawn(
    space: DesignSpace, chain: Chain, part: IntArray, motion: Motion, column: Array, q: Array
) -> tuple[list[list[float] | None], list[list[float]]]:
    """Displacements of all parts, and twists of all bodies at a unit rate along a column."""
    pose = forward_kinematics(chain, q)
    series = expand_from(chain, pose.screws, np.zeros((1, chain.width)), 0)
    links = [body.link for body in space.linkage.bodies]
    order = [motion.inputs.index(name) for name in space.linkage.inputs]
    twists = np.einsum("bwi,w->bi", series.T[0, 0, links], column[order])
    return _rows(pose.H, part), twists.round(9).tolist()


def _rows(H: Array, part: IntArray) -> list[list[float] | None]:
    """Displacements of all parts from those of all links; None for a part that stands."""
    _, first = np.unique(part[:-1], return_index=True)
    carried = H[first[part[first] > 0]]
    still = np.all(carried == np.eye(4), axis=(1, 2))
    rows = carried[:, :3].reshape(-1, 12).round(9).tolist()
    return [None, *(None if s else row for s, row in zip(still, rows, strict=True))]


def _label(inputs: Sequence[str], column: Array, free: int) -> str:
    """The inputs that a column moves: ``a``, ``a = b``, ``a = 2 b``."""
    moved = np.flatnonzero(column).tolist()
    if np.all(column[moved] == column[free]):
        return " = ".join(inputs[i] for i in moved)
    terms = []
    for i in (i for i in moved if i != free):
        ratio = f"{abs(column[i] / column[free]):.3g}"
        sign = "" if column[i] * column[free] > 0 else "−"
        terms.append(f"{inputs[i]} = {sign}{'' if ratio == '1' else f'{ratio} '}{inputs[free]}")
    return ", ".join(terms)
