"""A closed pose of a component, other ones near it, and what the user is told of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from kinematics.closure.assembly.closure_residual import displacement_residual, weld_gaps
from kinematics.closure.mobility.components import Component
from kinematics.closure.mobility.first_order import first_order_mobility_of
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import OpenLoopError
from kinematics.model.arrays import freeze
from kinematics.model.full_turns import position_text, wrap_turns
from kinematics.model.linkage import Notice, UnassembledLinkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest, rank_least_first
from kinematics.numerics.tolerances import (
    ALMOST_CLOSED_RESIDUAL,
    MOTION_EQUAL,
    UNMOVED_DISTANCE,
)
from kinematics.wording import count_noun

# Other closed poses that are kept.
MAX_OTHER_POSES = 2


class ClosedComponent(NamedTuple):
    """A closed pose of a component.

    Attributes:
        part: the component.
        q: positions of its joints, in its own units.
        starts: how many starts led to closed poses.
        motion: of the links from the pose of the file, in parts of the size.
        others: positions of its joints at other closed poses nearby, and their motions.
        open: angle and distance (metres) by which welds stay open; empty if they do not.
        pieces: in how many pieces it was closed, one after another.
    """

    part: Component
    q: Array
    starts: int = 1
    motion: float = 0.0
    others: tuple[tuple[Array, float], ...] = ()
    open: tuple[float, ...] = ()
    pieces: int = 1


def joint_motion(closing: ClosedComponent) -> float:
    """Compute how far joints moved; 0 if welds were moved instead."""
    q, _ = wrap_turns(closing.part.draft.joints, closing.q)
    size = float(np.abs(q).max())
    return size if size > ALMOST_CLOSED_RESIDUAL or not closing.open else 0.0


def sum_positions(
    draft: UnassembledLinkage, units: Array, closings: Iterable[tuple[Component, Array]]
) -> Array:
    """Compute positions of all joints (n,), in the units of the linkage, from its components.

    Args:
        units: unit of each joint, in metres or radians; `Chain.units`.
        closings: components, and positions of their joints in their own units.
    """
    q = np.zeros(len(draft.joints))
    for part, positions in closings:
        q += part.all_positions(positions, units)
    return q


def other_poses_of(
    draft: UnassembledLinkage, units: Array, closings: Sequence[ClosedComponent]
) -> tuple[Array, ...]:
    """List positions of all joints (n,) at other closed poses nearby, the nearest first.

    One component is at another pose there, the others are where they were closed. Positions
    count from the pose of the file, in radians and metres.

    Args:
        draft: the linkage as its file describes it.
        units: unit of each joint, in metres or radians; `Chain.units`.
    """
    nearby_poses = []
    before = 0.0 if draft.displaced is None else draft.displaced
    for number, each in enumerate(closings):
        for q, motion in each.others:
            poses = [(x.part, x.q) for x in closings]
            poses[number] = (each.part, q)
            there = freeze(sum_positions(draft, units, poses) * units + before)
            nearby_poses.append((motion / each.motion, there))
    order = rank_least_first([motion for motion, _ in nearby_poses], relative=MOTION_EQUAL)
    return tuple(nearby_poses[k][1] for k in order[:MAX_OTHER_POSES])


def pose_words(draft: UnassembledLinkage, q: Array, joints: Iterable[int]) -> str:
    """Write positions of joints of the tree as an argument of ``--at``: ``a=0.5,b=-0.1``.

    Args:
        q: positions of all its joints from the pose of the file (n,), radians and metres.
        joints: numbers of the joints to name.
    """
    within, _ = wrap_turns(draft.joints, q)
    named = (j for j in joints if not draft.joints[j].in_loop)
    return ",".join(f"{draft.joints[j].name}={within[j]:.5g}" for j in named)


def mobility_notices(
    draft: UnassembledLinkage, units: Array, closings: Sequence[ClosedComponent]
) -> list[Notice]:
    """Make a notice of another closed pose nearby that has another first-order mobility.

    Args:
        draft: the linkage as its file describes it.
        units: unit of each joint, in metres or radians; `Chain.units`.
    """
    notices = []
    before = np.zeros(len(draft.joints)) if draft.displaced is None else draft.displaced
    for each in closings:
        here = first_order_mobility_of(each.part.chain, each.q) if each.others else 0
        for q, motion in each.others:
            there = first_order_mobility_of(each.part.chain, q)
            if there == here:
                continue
            words = [
                pose_words(
                    draft,
                    before + each.part.all_positions(x, units) * units,
                    each.part.joints.tolist(),
                )
                for x in (each.q, q)
            ]
            text = (
                f"the pose that closes the loops with the least motion ({each.motion:.2g} of "
                f"the size of the linkage) leaves {_degrees(here)}, another with {motion:.2g} "
                f"leaves {_degrees(there)}: --at {words[0]} is the one taken, --at {words[1]} "
                "the other"
            )
            notices.append(Notice("other_branch", text))
    return notices[:1]


def _degrees(count: int) -> str:
    return f"{count_noun(count, 'degree')} of freedom"


def closing_notices(closing: ClosedComponent) -> list[Notice]:
    """Make the notice about the pose that was found."""
    if joint_motion(closing) <= UNMOVED_DISTANCE:
        return []
    chain, joints = closing.part.chain, closing.part.draft.joints
    q, _ = wrap_turns(joints, closing.q)
    home = forward_kinematics(chain, np.zeros(q.size))
    residual = np.abs(displacement_residual(chain, weld_gaps(closing.part), home)).max()
    furthest = first_largest(np.abs(q), relative=MOTION_EQUAL)
    joint = joints[furthest]
    how = "from the pose of the file"
    if closing.pieces > 1:
        how = f"in {closing.pieces} pieces one after another, the joints that they share held"
    elif closing.starts > 1:
        how = f"at the nearest of the poses that {closing.starts} starts led to"
    text = (
        f"the loops were open by {residual:.2g} (radians, characteristic lengths); closed "
        f"{how}; joint '{joint.name}' moved furthest, by "
        f"{position_text(joint, q[furthest] * chain.units[furthest])}"
    )
    return [Notice("assembled", text)]


def open_loop_error(draft: UnassembledLinkage, hint: str, starts: int) -> OpenLoopError:
    """Make the error for the loop that is furthest open in the file.

    Args:
        draft: the linkage as its file describes it.
        hint: what the user can do; empty for the usual remedy.
        starts: number of poses from which closing it was tried.
    """
    worst, distance, angle = draft.loops[0], 0.0, 0.0
    for loop in draft.loops:
        p = draft.joints[loop.end].point
        gap = float(np.linalg.norm(loop.gap[:3, :3] @ p + loop.gap[:3, 3] - p))
        cosine = 0.5 * (np.trace(loop.gap[:3, :3]) - 1.0)
        turn = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        if gap + turn > distance + angle:
            worst, distance, angle = loop, gap, turn
    return OpenLoopError(draft.source, worst.name, distance, angle, starts, hint)
