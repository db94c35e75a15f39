"""Singular poses: leave a pose with more first-order freedom than mobility, or refuse it.

Components that share no joint, and no mimic relation, are treated one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.assembly.close_loops import nearby_starts
from kinematics.assembly.rereference import rereference
from kinematics.closure.newton import Pose, follow_ray
from kinematics.closure.series import Series, expand, loop_matrix
from kinematics.errors import MobilityError
from kinematics.mobility.components import Component, split_components
from kinematics.mobility.first_order import (
    conditioning,
    first_order,
    first_order_mobility_of,
    independent_rows,
    step_along,
    step_from_singular,
)
from kinematics.mobility.higher_order import MAX_ORDER, LocalMobility, analyse_local_mobility
from kinematics.model.arrays import Chain
from kinematics.model.chain import arrange_loops, move_chain
from kinematics.model.full_turns import wrap_turns
from kinematics.model.linkage import Notice, UnassembledLinkage
from kinematics.tolerances import (
    LOOP_RANK_RELATIVE,
    NAMED_POSITION,
    NEAR_SINGULAR_CONDITIONING,
    OTHER_POSE_DISTANCE,
    SERIES_RESIDUAL,
    SINGULAR_CONDITIONING,
)

__all__ = [
    "is_near_singular",
    "generic_direction",
    "leave_singular_pose",
]

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Groups of more joints are not searched for branches.
MAX_JOINTS_SEARCHED = 120
# Joints, and branches, that a message names.
MAX_NAMED = 6


class _SingularComponent(NamedTuple):
    """A component, its local mobility, and poses on its branches (n,), in its own units."""

    part: Component
    local: LocalMobility
    poses: list[Array]


def generic_direction(chain: Chain) -> tuple[int, Pose | None]:
    """Find a finite pose in a generic direction of the columns of a chain.

    Returns:
        The order at which the loops do not close, 0 if they do; and a closed pose further
        on, None if there is none.
    """
    ray = np.random.default_rng(2).standard_normal(chain.width)
    ray /= np.linalg.norm(ray)
    series = expand(chain, ray[None], 4)
    if order := _find_open_order(series):
        return order, None
    pose, step = follow_ray(chain, np.zeros(chain.parent.size), series, ray)
    return (len(series.residual) + 1, None) if step == 0.0 else (0, pose)


def _find_open_order(series: Series) -> int:
    """Find the first order of motion at which loops do not close; 0 if they do."""
    sizes = np.abs(series.C[0]).max(axis=(1, 2))
    for order, (residual, size) in enumerate(zip(series.residual, sizes, strict=True)):
        if residual > SERIES_RESIDUAL * max(1.0, size, sizes[0] ** (order + 1)):
            return order + 1
    return 0


def is_near_singular(chain: Chain, values: Array, pose: Pose) -> bool:
    """Return whether a regular pose is near a singular one.

    It is, if its loop matrix is ill-conditioned, and better conditioned at the next pose.

    Args:
        chain: the linkage as arrays.
        values: singular values of its loop matrix.
        pose: a closed pose further on.
    """
    freedom = int(np.sum(values <= LOOP_RANK_RELATIVE * values.max(initial=0.0)))
    if freedom == values.size:
        return False
    here = float(values[values.size - freedom - 1] / values[0])
    return (
        here < NEAR_SINGULAR_CONDITIONING and conditioning(chain, pose.q, freedom) > 1.5 * here
    )


def leave_singular_pose(draft: UnassembledLinkage) -> UnassembledLinkage:
    """Move a linkage to a regular pose: its own, or one on the only branch that leaves it.

    Args:
        draft: a linkage whose loops are closed.

    Returns:
        The draft itself if its pose is regular; otherwise the draft at another pose, with a
        notice.

    Raises:
        MobilityError: joints move only infinitesimally, or several branches of motion meet
            at the pose of the file.
    """
    chain = arrange_loops(draft)
    parts = split_components(draft)
    groups = [g for part in parts if (g := _analyse_component(part))]
    if not groups:
        return draft
    if any(len(group.poses) > 1 for group in groups):
        raise _bifurcation_error(draft, chain, groups)
    q = np.zeros(len(draft.joints))
    for group in groups:
        q += group.part.all_positions(group.poses[0], chain.units)
    if not q.any():
        return draft
    outside = q.size - sum(part.joints.size for part in parts)
    here, there = (
        outside
        + sum(first_order_mobility_of(p.chain, p.own_positions(at, chain.units)) for p in parts)
        for at in (np.zeros(q.size), q)
    )
    text = (
        "the pose of the file is nearly singular; the reference pose is further along the "
        f"motion, away from it, by {_positions(draft, chain, q)}"
    )
    if here > there:
        text = (
            f"the pose of the file is singular: {_degrees(here)} there at first order, "
            f"{there} elsewhere; a single branch of motion leaves it, and the reference pose "
            f"is further along it, by {_positions(draft, chain, q)}"
        )
    notices = (*draft.notices, Notice("left_singular_pose", text))
    return replace(rereference(draft, chain, q), notices=notices)


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
        local = analyse_local_mobility(part, 2 * here) if here < SINGULAR_CONDITIONING else None
        if local is None or len(local.branches) < 2:
            return _SingularComponent(
                group,
                LocalMobility(freedom, freedom, 0, free.T),
                [step_from_singular(part, free)],
            )
    elif freedom == 0:
        return None
    else:
        local = analyse_local_mobility(part)
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
    return _SingularComponent(group, local, [step_along(part, q) for q in local.branches])


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
        order=local.order, joints=[draft.joints[j].name for j in joints],
    )  # fmt: skip


def _bifurcation_error(
    draft: UnassembledLinkage, chain: Chain, groups: Sequence[_SingularComponent]
) -> MobilityError:
    """Make the error for a pose at which branches of motion meet."""
    group = next(each for each in groups if len(each.poses) > 1)
    here, there = _count_freedoms(draft, groups)
    poses = []
    for choice in range(2):
        q = np.zeros(len(draft.joints))
        for each in groups:
            q += each.part.all_positions(each.poses[: choice + 1][-1], chain.units)
        poses.append(_positions(draft, chain, q))
    joints = group.part.joints
    names = [draft.joints[j].name for j in joints]
    how = f"several branches of motion meet there, of joints {_joint_list(draft, joints)}"
    if group.local.mobility == 1:
        ratios, names = _describe_branches(group)
        count = len(group.poses) if len(group.poses) <= MAX_NAMED else "many"
        how = f"{count} branches of motion meet there: {ratios}"
    return MobilityError(
        f"{draft.source}: singular at the pose of the file: {_degrees(here)} there, {there} "
        f"at other poses; {how}; the pose does not determine which one is meant: write the "
        f"file at a pose on that one, such as {poses[0]}, or {poses[1]}",
        joints=names,
    )


def _count_freedoms(
    draft: UnassembledLinkage, groups: Sequence[_SingularComponent]
) -> tuple[int, int]:
    """Count the freedoms of a linkage at a singular pose, at first order, and its mobility.

    Joints in no loop are free, and regular components have the freedoms of their own.
    """
    parts, singular = split_components(draft), {group.part.joints[0] for group in groups}
    beside = len(draft.joints) - sum(part.joints.size for part in parts)
    for part in parts:
        if part.joints[0] not in singular:
            beside += first_order(loop_matrix(part.chain))[0].shape[1]
    here = beside + sum(group.local.freedom for group in groups)
    return here, beside + sum(group.local.mobility for group in groups)


def _describe_branches(group: _SingularComponent) -> tuple[str, list[str]]:
    """Describe which joints move differently on the branches of a group; list their names."""
    joints = group.part.draft.joints
    rates = group.local.branches * group.part.chain.units
    least = np.abs(group.local.branches).min(axis=0)
    lead = int(np.flatnonzero(least >= 0.3 * least.max())[0])
    ratios = rates / rates[:, lead, None]
    differ = np.flatnonzero(np.ptp(ratios, axis=0) > 0.05 * np.abs(ratios).max(axis=0))
    rates_text = []
    for column in differ[:MAX_NAMED]:
        values = list(dict.fromkeys(f"{x:.2g}" for x in ratios[:, column]))
        rates_text.append(f"{joints[column].name} by {' or '.join(values)}")
    names = [joints[column].name for column in (lead, *differ)]
    return f"for each unit of {names[0]} move {', '.join(rates_text)}", names


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
