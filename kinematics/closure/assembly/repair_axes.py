"""Repair of overconstrained loops that close only to the decimals of their file.

Components of loops that depend on one another are repaired one by one: tolerances are relative
to the size of the component.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinematics.closure.assembly.fit_axes import fit_axes
from kinematics.closure.mobility.components import component_of, split_components
from kinematics.model.arrays import freeze
from kinematics.model.chain import arrange_loops, extent
from kinematics.model.linkage import Joint, Notice, UnassembledLinkage
from kinematics.model.plane import plane_normal
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out
from kinematics.numerics.tolerances import (
    AXIS_ROUNDING,
    FIT_RESIDUAL,
    LOOP_RANK_OF_FILE,
    LOOP_RANK_RELATIVE,
)
from kinematics.wording import size_text


def has_near_zero_singular_values(values: Array, planar: bool) -> bool:
    """Return whether a singular value of a loop matrix may be zero but for rounded axes.

    Args:
        values: singular values of the spatial chain (n,), in any unit.
        planar: whether the linkage was reduced to its plane, which drops all components out of
            it, so that only values above ``LOOP_RANK_RELATIVE`` count.
    """
    relative = values / max(values.max(initial=0.0), 1e-300)
    least = LOOP_RANK_RELATIVE if planar else LOOP_RANK_OF_FILE
    return bool(np.any((relative > least) & (relative < AXIS_ROUNDING)))


def repair_axes(draft: UnassembledLinkage) -> UnassembledLinkage | str:
    """Move axes within rounding so that the loops move, component by component.

    Args:
        draft: a linkage whose loops are closed at the reference pose.

    Returns:
        The repaired draft, or a text as of `repair_component` if no component was repaired.

    Raises:
        MobilityError: a component is too small for double precision.
    """
    better, texts = draft, []
    for part in split_components(draft):
        outcome = repair_component(better, part.joints.tolist())
        if isinstance(outcome, str):
            texts.append(outcome)
        else:
            better = outcome
    return max(texts, key=len, default="") if better is draft else better


def repair_component(
    draft: UnassembledLinkage, joints: Sequence[int], angle: float = 0.0, distance: float = 0.0
) -> UnassembledLinkage | str:
    """Move the axes of one component within rounding so that its loops move.

    Args:
        draft: a linkage whose loops are closed at the reference pose.
        joints: the joints of the component.
        angle: largest angle by which its loops were open before their welds were moved, rad.
        distance: largest distance by which they were open then, m.

    Returns:
        The repaired draft, with a notice; or a text that states how far the axes are from
        closing the loops, empty if the loops close as they are or no axes nearby let them
        close.

    Raises:
        MobilityError: the component is too small for double precision.
    """
    normal = _mean_normal(draft)
    fit = fit_axes(component_of(draft, joints).draft, normal)
    if fit is None:
        return _aligned_draft(draft, normal, angle, distance)
    gap = max(angle, distance / fit.size, fit.gap)
    if gap <= FIT_RESIDUAL:
        return ""
    turn, shift = max(angle, fit.angle), max(distance, fit.shift)
    by = f"by up to {turn:.2g} rad and {size_text(shift, '.2g', fit.size)} m"
    degrees = f"{fit.freedom} degree{'s' if fit.freedom > 1 else ''} of freedom"
    change = max(fit.change, gap)
    if change > AXIS_ROUNDING:
        return (
            f"as written they stay open by {gap:.2g} (radians, parts of the size of the "
            f"linkage); with axes and welds moved {by}, that of joint '{fit.furthest}' "
            f"furthest, they would close and have {degrees}, but that is {change:.2g} of the "
            f"size of {size_text(fit.size, '.2g')} m, and more than {AXIS_ROUNDING:.0e} is no "
            "rounding: correct the axes along them"
        )
    text = (
        f"overconstrained loops close only to rounding: as written they stay open by "
        f"{gap:.2g} (radians, parts of the size of the linkage; up to {AXIS_ROUNDING:.0e} "
        "counts as "
        f"rounding); their axes and welds were moved {by}, after which they close exactly and "
        f"have {degrees}"
    )
    notices = (*draft.notices, Notice("closes_to_rounding", text))
    new = [
        joint if normal is None else _align_with_normal(joint, normal) for joint in draft.joints
    ]
    for j, joint in zip(joints, fit.draft.joints, strict=True):
        new[j] = replace(draft.joints[j], screw=joint.screw)
    mended = max(draft.mended, change)
    return replace(draft, joints=tuple(new), notices=notices, mended=mended)


def _aligned_draft(
    draft: UnassembledLinkage, normal: Array | None, angle: float, distance: float
) -> UnassembledLinkage | str:
    """Close planar loops by moving welds alone, where a singular pose is too near for a fit.

    Args:
        draft: the linkage, whose welds were moved.
        normal: of its plane; None if it is not nearly planar.
        angle: largest angle by which its loops were open before, rad.
        distance: largest distance by which they were open then, m.

    Returns:
        The draft with axes along the normal, and a notice; empty if welds were not moved, or by
        more than rounding.
    """
    gap = max(angle, distance / max(extent(draft).length, 1e-300))
    if normal is None or not 0.0 < gap <= AXIS_ROUNDING:
        return ""
    text = (
        "overconstrained loops close only to rounding, next to a singular pose: as written "
        f"they stay open by {gap:.2g} (radians, parts of the size of the linkage; up to "
        f"{AXIS_ROUNDING:.0e} counts as rounding); their welds were moved by that"
    )
    return replace(
        draft,
        joints=tuple(_align_with_normal(joint, normal) for joint in draft.joints),
        notices=(*draft.notices, Notice("closes_to_rounding", text)),
        mended=max(draft.mended, gap),
    )


def _mean_normal(draft: UnassembledLinkage) -> Array | None:
    """Compute the mean direction of all axes of rotation, if the linkage is nearly planar."""
    chain = arrange_loops(draft)
    near = plane_normal(chain, AXIS_ROUNDING)
    if near is None:
        return None
    turning = chain.screws[np.any(chain.screws[:, :3], axis=1), :3]
    mean = np.sign(turning @ near) @ turning if len(turning) else near
    return np.array(mean / np.linalg.norm(mean))


def _align_with_normal(joint: Joint, normal: Array) -> Joint:
    """Make the axis of a joint exactly parallel to a normal, or perpendicular if it slides."""
    n, m = joint.screw[:3], joint.screw[3:]
    if joint.kind == "prismatic":
        flat = project_out(m, normal)
        screw = np.concatenate([n, flat / np.linalg.norm(flat)])
    else:
        upright = np.sign(n @ normal) * normal
        screw = np.concatenate([upright, np.cross(joint.point, upright) + (n @ m) * upright])
    return replace(joint, screw=freeze(screw))
