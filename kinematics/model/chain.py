"""Conversion of a linkage to a chain of arrays, and selections of its joints.

Positions are measured from the middle of the mechanism in units of a characteristic
length, joints that cannot move are left out, and a planar linkage is reduced to its plane.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from kinematics.model.arrays import Chain, Frame, freeze
from kinematics.model.linkage import Body, UnassembledLinkage
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.linalg.vectors import cross_products
from kinematics.numerics.tolerances import (
    AXIS_ROUNDING,
    MEETING_AXES_COORDINATE,
    MEETING_AXES_SIZE,
)


def arrange_loops(draft: UnassembledLinkage, frame: Frame | None = None) -> Chain:
    """Make the spatial chain of all joints of a linkage, with no independent coordinates.

    Args:
        frame: coordinates to use; by default amid the mechanism, in units of its size.

    Returns:
        The chain, with no columns.
    """
    frame = frame or fitted_frame(draft)
    n = len(draft.joints)
    screws = np.array([joint.screw for joint in draft.joints]).reshape(n, 6)
    sliding = np.array([joint.kind == "prismatic" for joint in draft.joints], dtype=bool)
    # v + n × origin, written with arms from the origin to the joints: where the mechanism is
    # far from the inertial origin, moments about that are large, and so is their rounding.
    points = np.array([joint.point for joint in draft.joints]).reshape(n, 3)
    axes = screws[:, :3]
    screws[:, 3:] -= cross_products(points, axes)
    screws[:, 3:] += cross_products(points - frame.origin, axes)
    screws[~sliding, 3:] /= frame.length
    units = np.where(sliding, frame.length, 1.0)
    ends = [(loop.end, loop.successor) for loop in draft.loops]
    mimics = np.zeros((len(draft.mimics), n))
    for row, mimic in zip(mimics, draft.mimics, strict=True):
        row[mimic.joint] = 1.0
        row[mimic.source] = -mimic.ratio * units[mimic.source] / units[mimic.joint]
    return Chain(
        frame=frame,
        joints=freeze(range(n), np.int64),
        units=freeze(units),
        parent=freeze([joint.parent for joint in draft.joints], np.int64),
        screws=freeze(screws),
        ends=freeze(np.reshape(ends, (-1, 2)), np.int64),
        mimics=freeze(mimics),
        dependent=freeze([], np.int64),
        columns=freeze(np.zeros((n, 0))),
        moves=freeze(np.zeros((n, 0)), np.bool_),
        links=freeze([body.link for body in draft.bodies], np.int64),
    )


def extent(draft: UnassembledLinkage) -> Frame:
    """Compute coordinates amid the joints, in units of the distance of the furthest joint.

    Unlike those of `arrange_loops` they do not degenerate where all axes nearly meet: there
    half of the centres of mass are further away, and the median of their distances counts.
    """
    points = np.array([joint.point for joint in draft.joints]).reshape(-1, 3)
    origin = points.mean(axis=0)
    far = float(np.linalg.norm(points - origin, axis=1).max())
    centres = np.linalg.norm(centres_of_mass(draft.bodies) - origin, axis=1)
    length = max(far, float(np.median(centres)) if centres.size else 0.0)
    return Frame(freeze(np.eye(3)), freeze(origin), length or 1.0)


def fitted_frame(draft: UnassembledLinkage) -> Frame:
    """Compute coordinates amid the joints, in units of the distances of their axes.

    The distances vanish where all axes meet in a point, but for rounding, or nothing turns:
    then those of the centres of mass, and of the joints themselves, replace them. The
    parallel axes of a loop meet nowhere: however near each other, their distances count.
    """
    points = np.array([joint.point for joint in draft.joints]).reshape(-1, 3)
    origin = points.mean(axis=0)
    screws = [joint.screw for joint in draft.joints if joint.kind != "prismatic"]
    turning = np.array(screws).reshape(-1, 6)
    arms = cross_products(
        turning[:, :3], turning[:, 3:] + cross_products(turning[:, :3], origin)
    )
    centres = centres_of_mass(draft.bodies)
    largest = max(float(np.abs(a).max(initial=0.0)) for a in (points, centres))
    meeting = not (draft.loops and screws and _are_parallel(turning))
    least = MEETING_AXES_COORDINATE * largest
    if meeting:
        least = max(least, MEETING_AXES_SIZE * extent(draft).length)
    for candidate in (arms, centres - origin, points - origin):
        if len(candidate):
            length = float(np.sqrt(np.mean(np.sum(candidate**2, axis=1))))
            if length > least:
                return Frame(freeze(np.eye(3)), freeze(origin), length)
    return Frame(freeze(np.eye(3)), freeze(origin), 1.0)


def _are_parallel(turning: Array) -> bool:
    """Return whether the axes of screws (n, 6) are parallel but for rounding."""
    return bool(np.abs(cross_products(turning[:, :3], turning[0, :3])).max() <= AXIS_ROUNDING)


def centres_of_mass(bodies: Sequence[Body]) -> Array:
    """Compute the centres of mass (count, 3) of the bodies that have one."""
    massive = [body.inertia for body in bodies if body.inertia[0] > 0.0]
    return np.array([z[1:4] / z[0] for z in massive]).reshape(-1, 3)


def lock_joints(chain: Chain, idle: Flags) -> Chain:
    """Remove idle joints from a chain; the links that they join become one.

    Args:
        chain: the linkage as arrays.
        idle: whether each joint is locked (n,).
    """
    if not idle.any():
        return chain
    kept = np.flatnonzero(~idle)
    carried = carriers(chain.parent, kept)
    ends = carried[chain.ends]
    mimics = chain.mimics[:, kept]
    dependent = chain.dependent[~idle[chain.dependent]]
    return replace(
        chain,
        joints=freeze(chain.joints[kept], np.int64),
        units=freeze(chain.units[kept]),
        parent=freeze(carried[chain.parent[kept]], np.int64),
        screws=freeze(chain.screws[kept]),
        ends=freeze(ends[ends[:, 0] != ends[:, 1]], np.int64),
        mimics=freeze(mimics[np.any(mimics != 0.0, axis=1)]),
        dependent=freeze(carried[dependent], np.int64),
        columns=freeze(chain.columns[kept]),
        moves=freeze(chain.moves[kept], np.bool_),
        links=freeze(carried[chain.links], np.int64),
    )


def move_chain(chain: Chain, independent: IntArray, basis: Array) -> Chain:
    """Choose the independent joints of a chain and the columns of its motion.

    Args:
        chain: the linkage as arrays.
        independent: joints that serve as coordinates.
        basis: their rates for each column, in the units of the chain; (independent, w).

    Returns:
        The chain with w columns; all other joints are dependent.
    """
    n = chain.parent.size
    depends = np.ones(n, dtype=bool)
    depends[independent] = False
    columns = np.zeros((n, basis.shape[1]))
    columns[independent] = basis
    active = columns != 0.0
    for group in clusters(chain):
        active[[j for j in group if depends[j]]] = active[group].any(axis=0)
    moves = active.copy()
    for j in range(n):
        if chain.parent[j] >= 0:
            moves[j] |= moves[chain.parent[j]]
    return replace(
        chain,
        dependent=freeze(np.flatnonzero(depends), np.int64),
        columns=freeze(columns),
        moves=freeze(moves, np.bool_),
    )


def clusters(chain: Chain, locked: frozenset[int] = frozenset()) -> list[list[int]]:
    """Group joints that loops and mimic relations couple.

    Args:
        chain: the linkage as arrays.
        locked: joints that do not move: they are in no group, and couple none.

    Returns:
        Joints of each group, ascending.
    """
    groups: list[set[int]] = []
    for end, successor in chain.ends.tolist():
        groups.append(loop_joints(chain.parent, end, successor))
    groups += [set(np.flatnonzero(row).tolist()) for row in chain.mimics]
    merged: list[set[int]] = []
    for group in groups:
        group -= locked
        for other in [m for m in merged if m & group]:
            merged.remove(other)
            group |= other
        if group:
            merged.append(group)
    return [sorted(group) for group in merged]


def loop_joints(parent: Sequence[int] | IntArray, end: int, successor: int) -> set[int]:
    """Find the joints of a loop: those between the ground and one of its two links alone.

    Args:
        parent: link that carries each joint, -1 for the ground (n,).
        end: one link of the loop's weld.
    """
    return set(path(parent, end)) ^ set(path(parent, successor))


def path(parent: Sequence[int] | IntArray, link: int) -> list[int]:
    """List the joints from a link down to the ground.

    Args:
        parent: link that carries each joint, -1 for the ground (n,).
        link: the link; -1, the ground, has an empty path.
    """
    path = []
    while link >= 0:
        path.append(link)
        link = int(parent[link])
    return path


def paths(parent: Sequence[int] | IntArray) -> Array:
    """Compute which joints lie between each link and the ground: 1 or 0.

    Args:
        parent: link that carries each joint, -1 for the ground (n,).

    Returns:
        Links by joints (n + 1, n); the last row is that of the ground, as index -1 is.
    """
    incidence = np.zeros((len(parent) + 1, len(parent)))
    for j, link in enumerate(parent):
        incidence[j] = incidence[link]
        incidence[j, j] = 1.0
    return incidence


def loop_signs(
    parent: Sequence[int] | IntArray, ends: Sequence[tuple[int, int]] | IntArray
) -> Array:
    """Compute which joints lie on the two paths from the ground to each weld, as signs.

    Args:
        parent: link that carries each joint, -1 for the ground (n,).
        ends: the two links that each loop welds, its end and its successor (loops, 2).

    Returns:
        Loops by joints (loops, n): 1 on the path to the end alone, -1 on the path to the
        successor alone, 0 on both and on neither.
    """
    before, pairs = paths(parent), np.array(ends, dtype=np.int64).reshape(-1, 2)
    return np.asarray(before[pairs[:, 0]] - before[pairs[:, 1]])


def carriers(parent: Sequence[int] | IntArray, kept: Sequence[int] | IntArray) -> IntArray:
    """Find the joint that carries each link when all joints but some are locked.

    Args:
        parent: link that carries each joint, -1 for the ground (n,).
        kept: joints that are not locked, ascending.

    Returns:
        For each link, and for the ground as the last entry (n + 1,), the place in ``kept`` of
        the first of these joints on the path to the ground; -1 if there is none.
    """
    place = {int(joint): k for k, joint in enumerate(kept)}
    places = np.full(len(parent) + 1, -1)
    for j, link in enumerate(parent):
        places[j] = place.get(j, places[link])
    return places


def rigid_parts(count: int, welds: Iterable[tuple[int, int]] | IntArray) -> IntArray:
    """Number the rigid parts that welds make of links.

    Args:
        count: number of links (n).
        welds: pairs of links that move as one, -1 for the ground.

    Returns:
        Part of each link and, as the last entry, of the ground (n + 1,): 0 for links welded
        to the ground, the others from 1 in the order of their first links.
    """
    part = np.arange(1, count + 2)
    part[count] = 0
    for link, other in welds:
        keep, drop = sorted((part[link], part[other]))
        part[part == drop] = keep
    return np.unique(part, return_inverse=True)[1]
