"""All modes that a linkage can change to from a singular pose, at it or further along a curve.

Modes of one degree of freedom are followed all around: branches on one curve are one mode, and
where a curve passes another singular pose, the modes that cross there are added. Modes of more
degrees of freedom are those that meet at the first pose.

Two curves that cross at a singular pose may be one motion, which passes that pose twice: a
four-bar with a + b = c + d is one closed curve with a double point. And a curve may pass
through other singular poses, where modes cross that do not come to the first one: a rhombus
folds in two ways, at two poses. Both show when the curve is followed, straight through the
singular poses on it. There the smallest singular value of the loop matrix that is not zero
falls to zero, linearly on both sides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kinematics.closure.mobility.finite_pose import finite_pose
from kinematics.closure.mobility.first_order import conditioning, first_order
from kinematics.closure.mobility.motion_modes import (
    Mode,
    ModeSearch,
    SheetPose,
    find_modes,
    follow_sheet,
)
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain, freeze
from kinematics.model.full_turns import within_turn
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg.ties import first_basis

# Most modes, and most singular poses, that are looked at.
MAX_MODES, MAX_NODES = 24, 12
# Relative size of singular values that count as zero at a singular pose on a curve: the pose is
# known to this part of the size of the linkage.
NODE_RANK_RELATIVE = 1e-5
# Difference of joint positions of two singular poses that are the same.
SAME_NODE = 1e-3
# Longest and first step along a curve (radians, characteristic lengths), the shortest, and the
# most of them.
LONGEST, FIRST, SHORTEST, MAX_STEPS = 0.12, 0.03, 1e-5, 3000
# Most steps times the square of the number of joints, with which the cost of a step grows.
MAX_WORK = 600_000
# Joint positions, in characteristic lengths, at which a curve is followed no further.
FAR = 30.0
# Smallest singular value, relative to the largest, next to which a singular pose is looked for;
# the one that a singular pose has; and steps of the search.
NEAR_NODE, NODE, NODE_STEPS = 0.2, 1e-6, 60
# Distance of a pose from a curve that is on it.
ON_CURVE = 1e-6
# Poses of a curve from which a pose next to it is looked for: the nearest ones. A curve that
# crosses itself has some of each passage.
NEAREST = 6


class ReachableMode(NamedTuple):
    """A mode, and a pose on it.

    Attributes:
        mobility: its degrees of freedom.
        q: joint positions (n,) of a well conditioned closed pose on it, chain units.
        here: whether it passes the first singular pose itself.
    """

    mobility: int
    q: Array
    here: bool


class ReachableModes(NamedTuple):
    """Modes that a linkage can change to.

    Attributes:
        modes: those that meet at the pose, in their order; then others, in the order in which
            singular poses are met.
        doubt: why there may be more; empty if nothing speaks for it.
    """

    modes: tuple[ReachableMode, ...]
    doubt: str


def reachable_modes(
    chain: Chain, search: ModeSearch, distance: float, turning: Flags
) -> ReachableModes:
    """List the modes at a singular pose, and those further along modes of one freedom.

    Args:
        chain: joints in loops that are closed; the singular pose is its reference pose.
        search: the modes that meet there, from `find_modes`.
        distance: of the poses on each mode from the singular pose.
        turning: joints that are in the same place after a full turn (n,).
    """
    doubts = [search.doubt]
    curves: list[_ModeCurve] = []
    reached: list[ReachableMode] = []
    nodes = [np.zeros(chain.parent.size)]

    def visit(local: Sequence[Mode], node: Array, at_node: Chain) -> None:
        here = node is nodes[0]
        for mode in local:
            if len(reached) == MAX_MODES:
                doubts.append(f"no more than {MAX_MODES} are listed")
                return
            near = mode.poses[0]
            if mode.mobility == 1:
                pose = near._replace(q=node + near.q)
                if any(curve.passes(chain, pose.q, turning) for curve in curves):
                    continue
                curves.append(_trace_curve(chain, pose, turning))
            elif not here:
                continue
            far = node + finite_pose(at_node, mode.poses)
            reached.append(ReachableMode(mode.mobility, far, here))

    visit(search.modes, nodes[0], chain)
    for curve in curves:  # grows on the way
        if not curve.ended:
            doubts.append("a mode was not followed to its end")
        for node in curve.nodes:
            visited = any(
                np.abs(within_turn(node - x, turning)).max() <= SAME_NODE for x in nodes
            )
            if visited:
                continue
            if len(nodes) > MAX_NODES:
                doubts.append(f"no more than {MAX_NODES} singular poses were looked at")
                break
            nodes.append(node)
            at_node = _chain_at(chain, node)
            N, _ = first_order(loop_matrix(at_node), NODE_RANK_RELATIVE)
            if N.shape[1] > 1:
                there = find_modes(at_node, first_basis(N.T).T, distance)
                doubts.append(there.doubt)
                visit(there.modes, node, at_node)
    return ReachableModes(tuple(reached), next(filter(None, doubts), ""))


def _chain_at(chain: Chain, q: Array) -> Chain:
    """Make a closed pose (n,) the reference pose of a chain."""
    return replace(chain, screws=freeze(forward_kinematics(chain, q).screws))


class _ModeCurve(NamedTuple):
    """Closed poses along a mode of one degree of freedom.

    Attributes:
        poses: along the curve, from its first pose (k, n), chain units; turns count on.
        tangents: unit tangents there (k, n).
        conditioning: smallest singular value of the loop matrix that is not zero everywhere,
            relative to the largest (k,).
        nodes: singular poses on it (m, n).
        ended: whether it comes back to its first pose, or leads far away both ways; otherwise
            it goes on where it was not followed.
    """

    poses: Array
    tangents: Array
    conditioning: Array
    nodes: Array
    ended: bool

    def passes(self, chain: Chain, q: Array, turning: Flags) -> bool:
        """Decide whether a closed pose is on the curve, up to full turns of joints.

        Args:
            chain: the linkage as arrays.
            q: joint positions (n,), chain units.
            turning: joints that are in the same place after a full turn (n,).
        """
        apart = np.linalg.norm(within_turn(q - self.poses, turning), axis=1)
        near = np.flatnonzero(apart <= 2.0 * LONGEST)
        return any(
            self._leads_to_pose(chain, k, q, turning)
            for k in near[np.argsort(apart[near], kind="stable")][:NEAREST].tolist()
        )

    def _leads_to_pose(self, chain: Chain, k: int, q: Array, turning: Flags) -> bool:
        """Decide whether the curve leads from one of its poses to another pose next to it."""
        pose = SheetPose(self.poses[k], self.tangents[k][:, None])
        for _ in range(5):
            away = within_turn(q - pose.q, turning)
            if np.abs(away).max() <= ON_CURVE:
                return True
            along = pose.T[:, 0] * float(pose.T[:, 0] @ away)
            there = follow_sheet(chain, pose, along) if along.any() else None
            if there is None:
                return False
            pose = there
        return False


def _trace_curve(chain: Chain, start: SheetPose, turning: Flags) -> _ModeCurve:
    """Follow a curve of closed poses all around, or both ways as far as it goes.

    Args:
        chain: joints in loops that are closed; spatial.
        start: a regular pose on the curve.
        turning: joints that are in the same place after a full turn (n,).
    """
    poses, closed, ended = _follow_curve(chain, start, turning)
    if not closed:
        back, _, both = _follow_curve(chain, start._replace(T=-start.T), turning)
        ended = ended and both
        poses = [pose._replace(T=-pose.T) for pose in back[:0:-1]] + poses
    values = np.array([conditioning(chain, pose.q, 1) for pose in poses])
    return _ModeCurve(
        np.array([pose.q for pose in poses]),
        np.array([pose.T[:, 0] for pose in poses]),
        values,
        np.reshape(list(_nodes(chain, poses, values, turning)), (-1, len(start.q))),
        closed or ended,
    )


def _follow_curve(
    chain: Chain, start: SheetPose, turning: Flags
) -> tuple[list[SheetPose], bool, bool]:
    """Follow a curve in one sense.

    Steps are bent as the curve was before, so that they stay on it where another is tangent to
    it.

    Returns:
        Its poses, whether it came back to the first, and whether it led far away.
    """
    pose, step = start, FIRST
    poses = [start]
    length, bend = 0.0, np.zeros(len(start.q))
    for _ in range(min(MAX_STEPS, MAX_WORK // len(start.q) ** 2)):
        there = follow_sheet(chain, pose, step * pose.T[:, 0] + 0.5 * step**2 * bend)
        if there is None or np.linalg.norm(there.q - pose.q) > 1.5 * step:
            step *= 0.43  # no simple part: a pose that hits a node is avoided at the next try
            if step < SHORTEST:
                break
            continue
        sense = np.sign(float(there.T[:, 0] @ pose.T[:, 0]))
        there = there._replace(T=there.T * sense)
        turned = 1.0 - float(there.T[:, 0] @ pose.T[:, 0])
        away = within_turn(start.q - pose.q, turning)
        ahead = float(away @ pose.T[:, 0])
        if (
            length > 2.0 * LONGEST
            and 0.0 <= ahead <= step
            and _arrives(chain, pose, start, away)
        ):
            return poses, True, False
        length += step
        bend = (there.T[:, 0] - pose.T[:, 0]) / step
        pose = there
        poses.append(pose)
        if np.abs(np.where(turning, 0.0, pose.q)).max() > FAR:
            return poses, False, True
        step = min(step * (1.4 if turned < 2e-3 else 0.8 if turned > 8e-3 else 1.0), LONGEST)
    return poses, False, False


def _arrives(chain: Chain, pose: SheetPose, start: SheetPose, away: Array) -> bool:
    """Decide whether the next pose on a curve is its first one, in the same sense."""
    if np.linalg.norm(away) > 2.0 * LONGEST or pose.T[:, 0] @ start.T[:, 0] < 0.9:
        return False
    there = follow_sheet(chain, pose, pose.T[:, 0] * float(pose.T[:, 0] @ away))
    return there is not None and bool(np.abs(there.q - pose.q - away).max() <= 1e-2 * LONGEST)


def _nodes(
    chain: Chain, poses: Sequence[SheetPose], values: Array, turning: Flags
) -> Iterator[Array]:
    """Yield the singular poses on a curve, each once."""
    nodes: list[Array] = []
    count = len(poses)
    for k in range(count):
        before, after = values[k - 1], values[(k + 1) % count]
        if values[k] > NEAR_NODE or values[k] > before or values[k] >= after:
            continue
        q = _node_near(chain, poses[k])
        if q is not None and all(
            np.abs(within_turn(q - each, turning)).max() > 1e-3 for each in nodes
        ):
            nodes.append(q)
            yield q


def _node_near(chain: Chain, pose: SheetPose) -> Array | None:
    """Find the singular pose next to a pose on a curve, where the conditioning is 0; or None.

    It is a minimum of the conditioning, which a golden section finds.
    """
    ratio = 0.5 * (np.sqrt(5.0) - 1.0)
    low, high = -1.2 * LONGEST, 1.2 * LONGEST
    best: tuple[float, Array] = (np.inf, pose.q)

    def value(s: float) -> float:
        nonlocal best
        there = follow_sheet(chain, pose, s * pose.T[:, 0]) if s else pose
        if there is None:
            return np.inf
        here = conditioning(chain, there.q, 1)
        if here < best[0]:
            best = here, there.q
        return here

    inner = [high - ratio * (high - low), low + ratio * (high - low)]
    values = [value(s) for s in inner]
    for _ in range(NODE_STEPS):
        if values[0] <= values[1]:
            high, inner[1], values[1] = inner[1], inner[0], values[0]
            inner[0] = high - ratio * (high - low)
            values[0] = value(inner[0])
        else:
            low, inner[0], values[0] = inner[0], inner[1], values[1]
            inner[1] = low + ratio * (high - low)
            values[1] = value(inner[1])
        if best[0] <= NODE or high - low < 1e-9:
            break
    return best[1] if best[0] <= NODE else None
