"""Singular poses: leave a pose with more first-order freedom than mobility, or refuse it.

Components that share no joint, and no mimic relation, are treated one after the other: where
modes of motion meet in several of them, the modes of the linkage are their combinations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice, product
from math import prod
from typing import NamedTuple

import numpy as np

from kinematics.closure.assembly.close_loops import nearby_starts
from kinematics.closure.assembly.generic_pose import generic_direction, is_near_singular
from kinematics.closure.assembly.rereference import rereference
from kinematics.closure.mobility.components import Component, split_components
from kinematics.closure.mobility.first_order import (
    first_order,
    independent_rows,
    step_from_singular,
)
from kinematics.closure.mobility.higher_order import (
    MAX_ORDER,
    LocalMobility,
    analyse_local_mobility,
)
from kinematics.closure.mobility.reachable_modes import ReachableMode
from kinematics.closure.newton import Pose
from kinematics.closure.series import loop_matrix
from kinematics.errors import MobilityError
from kinematics.model.arrays import Chain
from kinematics.model.chain import arrange_loops, move_chain
from kinematics.model.full_turns import wrap_turns
from kinematics.model.linkage import Linkage, Notice, UnassembledLinkage
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.tolerances import (
    NAMED_POSITION,
    OTHER_POSE_DISTANCE,
    SINGULAR_CONDITIONING,
)

# Groups of more joints are not searched for modes.
MAX_JOINTS_SEARCHED = 120
# Joints that a message names.
MAX_NAMED = 6
# Most modes of a linkage: combinations of those of its components.
MAX_MODES = 64


class ModeStart(NamedTuple):
    """A mode of motion of a linkage that leaves a singular pose.

    Attributes:
        draft: the linkage at a regular pose on it.
        mobility: its degrees of freedom.
        here: whether the mode passes the singular pose, or one further along another mode.
    """

    draft: UnassembledLinkage
    mobility: int
    here: bool


class ModeStarts(NamedTuple):
    """The modes of motion that leave a singular pose.

    Attributes:
        starts: those that pass the pose before those that another mode leads to, by mobility,
            then by the rates of the joints; none if the pose is regular.
        doubt: why there may be more; empty if nothing speaks for it.
    """

    starts: tuple[ModeStart, ...] = ()
    doubt: str = ""


class _SingularComponent(NamedTuple):
    """A component, and its local mobility."""

    part: Component
    local: LocalMobility


def leave_singular_pose(draft: UnassembledLinkage) -> ModeStarts:
    """Find the modes of motion that leave the pose of a linkage, and a regular pose on each.

    Args:
        draft: a linkage whose loops are closed.

    Returns:
        The modes; a single one, with a notice, if the linkage can leave its pose in one way
        only.

    Raises:
        MobilityError: joints move only infinitesimally.
    """
    chain = arrange_loops(draft)
    parts = split_components(draft)
    groups = [g for part in parts if (g := _analyse_component(part))]
    if not groups:
        return ModeStarts()
    starts = []
    doubt = next((group.local.doubt for group in groups if group.local.doubt), "")
    if prod(len(group.local.modes) for group in groups) > MAX_MODES:
        doubt = doubt or f"no more than {MAX_MODES} are listed"
    beside = _freedoms_beside(draft, parts, groups)
    for choice in islice(product(*(group.local.modes for group in groups)), MAX_MODES):
        q = np.zeros(len(draft.joints))
        for group, mode in zip(groups, choice, strict=True):
            q += group.part.all_positions(mode.q, chain.units)
        mobility = beside + sum(mode.mobility for mode in choice)
        there = rereference(draft, chain, q) if q.any() else draft
        starts.append(ModeStart(there, mobility, all(mode.here for mode in choice)))
    if len(starts) > 1:
        starts.sort(key=lambda start: (not start.here, start.mobility))
        return ModeStarts(tuple(starts), doubt)
    (start,) = starts
    if start.draft is draft:
        return ModeStarts()
    text = _leaving_text(draft, chain, start, beside + sum(g.local.freedom for g in groups))
    text += f"; there may be others: {doubt}" if doubt else ""
    notices = (*start.draft.notices, Notice("left_singular_pose", text))
    return ModeStarts((start._replace(draft=replace(start.draft, notices=notices)),), doubt)


def check_mobility(linkage: Linkage, start: ModeStart) -> Linkage:
    """Return a linkage that was assembled on a mode, if it has the mobility of the mode.

    Args:
        linkage: the linkage at the pose on the mode.

    Raises:
        MobilityError: it has another one: joints have first-order freedoms at every pose, and
            round-off decides which of them are motions.
    """
    if linkage.mobility == start.mobility:
        return linkage
    raise MobilityError(
        f"{linkage.source}: part of the linkage moves only infinitesimally: there are "
        f"{_degrees(start.mobility)} at first order at every pose nearby, and not all of them "
        "are motions; replace that part by one rigid link"
    )


def _freedoms_beside(
    draft: UnassembledLinkage, parts: Sequence[Component], groups: Sequence[_SingularComponent]
) -> int:
    """Count the freedoms of joints in no loop, and of the components that are regular."""
    singular = {group.part.joints[0] for group in groups}
    beside = len(draft.joints) - sum(part.joints.size for part in parts)
    for part in parts:
        if part.joints[0] not in singular:
            beside += first_order(loop_matrix(part.chain))[0].shape[1]
    return beside


def _leaving_text(
    draft: UnassembledLinkage, chain: Chain, start: ModeStart, freedom: int
) -> str:
    """Describe how far the reference pose is from that of the file, and why."""
    there = start.draft.displaced
    assert there is not None
    before = 0.0 if draft.displaced is None else draft.displaced
    where = _positions(draft, chain, (there - before) / chain.units)
    if freedom > start.mobility:
        return (
            f"the pose of the file is singular: {_degrees(freedom)} there at first order, "
            f"{start.mobility} elsewhere; a single motion leaves it, and the reference pose is "
            f"further along it, by {where}"
        )
    return (
        "the pose of the file is nearly singular; the reference pose is further along the "
        f"motion, away from it, by {where}"
    )


def _analyse_component(group: Component) -> _SingularComponent | None:
    """Analyse the local mobility of a component at a singular pose; None if it is regular.

    Raises:
        MobilityError: its joints move only infinitesimally.
    """
    draft, part = group.draft, group.chain
    joints = range(len(draft.joints))
    free, values = first_order(loop_matrix(part))
    freedom = free.shape[1]
    pose = _find_pose_ahead(part, free) if freedom else None
    if pose is None and freedom and len(joints) > MAX_JOINTS_SEARCHED:
        raise MobilityError(
            f"{draft.source}: singular at the pose of the file: not all of the "
            f"{_degrees(freedom)} that joints {_joint_list(draft, joints)} have at first "
            f"order are motions, and with {len(joints)} joints in loops the branches were not "
            "looked for; write the file at another pose",
            joints=[draft.joints[j].name for j in joints],
        )
    if pose is not None:
        if not is_near_singular(part, values, pose):
            return None
        here = float(values[values.size - freedom - 1] / values[0])
        turning = _turning_joints(draft)
        local = (
            analyse_local_mobility(part, turning, 2 * here)
            if here < SINGULAR_CONDITIONING
            else None
        )
        if local is None or len(local.modes) < 2:
            far = step_from_singular(part, free)
            mode = ReachableMode(freedom, far, True)
            return _SingularComponent(group, LocalMobility(freedom, 0, (mode,)))
    elif freedom == 0:
        return None
    else:
        local = analyse_local_mobility(part, _turning_joints(draft))
    if local.mobility == 0:
        raise _rigid_error(group, local)
    if local.mobility >= local.freedom:
        raise MobilityError(
            f"{draft.source}: part of the linkage moves only infinitesimally: joints "
            f"{_joint_list(draft, joints)} have {_degrees(local.freedom)} at first "
            "order at every pose nearby, but cannot follow them all; replace that part by one "
            "rigid link",
            joints=[draft.joints[j].name for j in joints],
        )
    return _SingularComponent(group, local)


def _turning_joints(draft: UnassembledLinkage) -> Flags:
    """Find the joints that are in the same place after a full turn (n,).

    A joint in a mimic relation is not, if its turn is no number of full turns of another joint.
    """
    turning = np.array([joint.kind == "revolute" for joint in draft.joints], dtype=np.bool_)
    for mimic in draft.mimics:
        if mimic.ratio != np.rint(mimic.ratio):
            turning[[mimic.joint, mimic.source]] = False
    return turning


def _find_pose_ahead(chain: Chain, free: Array) -> Pose | None:
    """Find a pose in a generic direction of the first-order freedoms (n, f), or None."""
    return generic_direction(move_chain(chain, independent_rows(free), np.eye(free.shape[1])))[
        1
    ]


def _rigid_error(group: Component, local: LocalMobility) -> MobilityError:
    """Make the error for joints that move only infinitesimally."""
    draft, chain = group.draft, group.chain
    joints = range(len(draft.joints))
    order = (
        f"at order {local.order}" if local.order <= MAX_ORDER else f"beyond order {MAX_ORDER}"
    )
    remedy = "it is a structure: check the origins and axes along its loops"
    for far in nearby_starts(group):
        q, _ = wrap_turns(draft.joints, far)
        there = arrange_loops(rereference(draft, chain, q))
        free, _ = first_order(loop_matrix(there))
        if (
            np.abs(q).max() > OTHER_POSE_DISTANCE
            and free.shape[1]
            and _find_pose_ahead(there, free)
        ):
            where = _positions(draft, chain, q)
            remedy = f"it moves at other poses: write the file at one, such as {where}"
            break
    return MobilityError(
        f"{draft.source}: the linkage moves only infinitesimally: joints "
        f"{_joint_list(draft, joints)} have {_degrees(local.freedom)} at first order, "
        f"but are not mobile {order}; {remedy}",
        order=local.order,
        joints=[draft.joints[j].name for j in joints],
    )


def _degrees(count: int) -> str:
    return f"{count} degree{'s' if count > 1 else ''} of freedom"


def _joint_list(draft: UnassembledLinkage, joints: Sequence[int] | IntArray) -> str:
    """List names of joints, the first few of many."""
    more = ["…"] if len(joints) > MAX_NAMED else []
    return ", ".join([draft.joints[j].name for j in joints[:MAX_NAMED]] + more)


def _positions(draft: UnassembledLinkage, chain: Chain, q: Array) -> str:
    """Format positions of the joints of the tree within one turn, as far as they move."""
    within, _ = wrap_turns(draft.joints, q * chain.units)
    return ", ".join(
        f"{joint.name}={value:.3g}"
        for joint, value in zip(draft.joints, within, strict=True)
        if not joint.in_loop and abs(value) > NAMED_POSITION
    )
