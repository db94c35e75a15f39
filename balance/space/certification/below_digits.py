"""Reasons to doubt integers that rest on digits which a file does not have."""

from __future__ import annotations

from collections.abc import Iterable

from balance.space.certification.correct_integers import Evidence
from balance.space.certification.meant_notice import decimals_have_rank
from balance.space.exact.conditions import first_orders_of_motion
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
from balance.support.tolerances import (
    CONDITION_OF_TILTS,
    CONDITION_PER_CHANGE,
    DIGITS_CONDITION,
    DIGITS_OF_CONDITION,
    DOUBLE_ROUNDING,
    LARGEST_DIGITS_CONDITION,
    ROUNDING_OF_JOINTS,
)
from kinematics.loading.meant.digits import (
    DOUBLE_DIGITS,
    file_digits,
    half_unit_of_file,
)
from kinematics.model.chain import extent
from kinematics.wording import size_text


def reason_below_digits(space: DesignSpace, corrected: DesignSpace, evidence: Evidence) -> str:
    """State why conditions of a geometry inside the digits may not be meant; empty if not.

    A geometry that has the relations found is at another place inside the digits than the
    linkage, so that it may break relations that were not looked for. Nor are those looked for
    that rounded numbers break in loops that are neither planar nor spherical: the distance to
    a geometry of lower rank decides there, and where exact arithmetic adds a condition.

    Args:
        space: the space by floating point.
        corrected: the space with the integers of that geometry.
    """
    if doubt := _reason_freed_by_rounding(space, evidence):
        return doubt
    if doubt := _reason_at_special_pose(space, corrected, evidence):
        return doubt
    meant, limit = space.linkage.meant, 0.0
    adds = corrected.rank > space.rank
    if evidence.inside_digits and meant is not None:
        if adds or (meant.relations and meant.apart):
            limit = 10.0 ** (DIGITS_OF_CONDITION - (meant.digits or DOUBLE_DIGITS))
        if meant.apart and space.linkage.mended and meant.near is None:
            limit = max(limit, _condition_of_rounding(_rounding_of(space)))
        if adds:
            # As written, axes were moved by round-off alone; their lever enlarges it.
            tilted = space.linkage.as_written
            limit = max(limit, CONDITION_OF_TILTS if tilted else DIGITS_CONDITION)
    elif meant is None and adds and not space.linkage.as_written:
        if rounding := _rounding_of(space):
            limit = 10.0 ** (DIGITS_OF_CONDITION - DOUBLE_DIGITS - 1)
        if rounding > DOUBLE_ROUNDING:
            limit = max(limit, _condition_of_rounding(rounding))
    if not corrected.rank:
        return ""
    least = float(corrected.singular_values[-1])
    if least >= limit:
        # A lever of the pose enlarges what rounding adds: the distance decides then.
        small = adds or least <= CONDITION_PER_CHANGE * _rounding_of(space)
        inexact = small and evidence.replaced > 0 if meant is None else adds
        return _reason_within_rounding(space, corrected) if inexact else ""
    if decimals_have_rank(space, corrected.rank):
        return ""
    return (
        f"rank: the least condition is {size_text(least, '.0e')} of the largest, and may come "
        "from digits that the file does not have"
    )


def _reason_at_special_pose(
    space: DesignSpace, corrected: DesignSpace, evidence: Evidence
) -> str:
    """State that exact arithmetic has more conditions at a special pose, and in all.

    Up to round-off, the pose has fewer conditions of order 0 than the numbers: these miss
    relations of the pose, and so may those that were found of the geometry.
    """
    adds = corrected.rank > space.rank
    if not (evidence.inside_digits and adds and space.orders and corrected.orders):
        return ""
    rounded, exact = space.orders[0].rank, corrected.orders[0].rank
    if rounded == exact:
        return ""
    return (
        f"rank: {space.rank} up to rounding, and {corrected.rank} where the pose has {exact} "
        f"conditions of order 0, not {rounded} as up to rounding"
    )


def _reason_freed_by_rounding(space: DesignSpace, evidence: Evidence) -> str:
    """State which joints are idle but for rounded numbers, with which they move at once.

    By floating point they are at rest: slides that are parallel to the digits of the file
    leave the joints between them no rate but one of the size of a unit of these digits.
    """
    if not evidence.inside_digits:
        return ""
    names = [joint.name for joint in space.linkage.joints]
    freed = {names.index(name) for name in space.idle} - set(evidence.idle)
    if freed:
        lowest = first_orders_of_motion(evidence.exact.chain, 0)
        freed = {j for j in freed if lowest[j] == 0}
    if not freed:
        return ""
    joints = joints_as_subject(space, sorted(freed))
    return f"idle joints: {joints} at rest but for rates below the digits of the file"


def _reason_within_rounding(space: DesignSpace, corrected: DesignSpace) -> str:
    """State that a change of the geometry within the digits of the file lowers the rank.

    Args:
        space: the space by floating point.
        corrected: the space with the exact integers.

    Returns:
        The doubt; empty without one.
    """
    rounding = _rounding_of(space)
    if space.linkage.as_written or not space.linkage.loops or not rounding:
        return ""
    # Axes that are meant were placed within their rounding already.
    change = rounding if space.linkage.meant is not None else ROUNDING_OF_JOINTS * rounding
    if distance_to_rank_drop(corrected) > change:
        return ""
    return (
        f"rank: a change of the geometry by less than {change:.0e} of the size, within the "
        "rounding of the file, lowers it"
    )


def _condition_of_rounding(rounding: float) -> float:
    """Compute the largest condition, over the largest of all, that rounding may add."""
    return min(CONDITION_PER_CHANGE * rounding, LARGEST_DIGITS_CONDITION)


def _rounding_of(space: DesignSpace) -> float:
    """Compute the largest half unit of the numbers of a file, in parts of the size, or 0."""
    tree = space.linkage.tree
    digits = None if tree is None else file_digits(tree)
    if tree is None or digits is None:
        return 0.0
    return half_unit_of_file(tree, digits, max(extent(space.linkage).length, 1e-300))


def joints_as_subject(space: DesignSpace, joints: Iterable[int]) -> str:
    """Name joints as the subject of a sentence in the present tense."""
    names = [f"'{space.linkage.joints[j].name}'" for j in joints]
    return f"joint {names[0]} is" if len(names) == 1 else f"joints {', '.join(names)} are"
