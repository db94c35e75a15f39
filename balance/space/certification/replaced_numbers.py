"""Numbers of a file that exact arithmetic replaces, or reads as roots: what rests on them.

An angle has no rational rotation, so exact arithmetic takes one within 2^-64 of it. If that
has more conditions than floating point finds, either a special geometry needs that angle, and
is lost, or the file is special but for less than round-off elsewhere, and floating point does
not see it. Other angles, further away, tell: without them the first loses its special geometry
for floating point too, and the second keeps it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from balance.space.certification.certified_space import CertifiedSpace, with_readings
from balance.space.certification.compare_integers import integers_differ
from balance.space.certification.correct_integers import Evidence
from balance.space.certification.exact_ranks import rank_of_geometry
from balance.space.many.placing_kernels import points_on_axes
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.readings import MOST_DIGITS, Reading
from kinematics.closure.assembly.assemble import assemble
from kinematics.errors import ExactError, LinkageError
from kinematics.files.urdf.rational_screws import change_replaced_numbers, exact_geometry
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Notice
from kinematics.wording import count_noun

# Digits with which a file can tell a linkage from a special one where floating point cannot.
DIGITS_BEYOND_TOLERANCE = 11


def replaced_text(evidence: Evidence) -> str:
    """Say how many numbers were replaced, or read as roots, as the end of a sentence.

    Args:
        evidence: the findings of exact arithmetic.
    """
    parts = []
    if evidence.replaced:
        parts.append(f"{count_noun(evidence.replaced, 'number')} of the file replaced")
    if evidence.roots:
        parts.append(f"{count_noun(evidence.roots, 'number')} of the file read as roots")
    return f", with {' and '.join(parts)} (see --exact)" if parts else ""


def add_roots_notice(space: CertifiedSpace, evidence: Evidence) -> CertifiedSpace:
    """State both answers where numbers are read as roots, if their decimals have another rank.

    Args:
        evidence: the findings of exact arithmetic that it rests on.

    Returns:
        The space, with the notice ``read_as_roots`` if they do.
    """
    if not evidence.roots:
        return space
    try:
        other = rank_of_geometry(space, exact_geometry(space.linkage))
    except ExactError:
        other = None
    if other == space.rank:
        return space
    relation = f"{count_noun(evidence.roots, 'number')} read as roots"
    reading = Reading("as_meant", (relation,), MOST_DIGITS, None, other, space.rank, 0.0, 0.0)
    text = (
        f"as written: {reading.written_text}; with {count_noun(evidence.roots, 'number')} of "
        "the file read as roots, sines and cosines, which they are to all their digits: "
        f"{space.rank} (--as-written for the other, --exact names them)"
    )
    return with_readings(space, [Notice("read_as_roots", text)], [reading])


def rests_on_replaced(space: DesignSpace, changed: DesignSpace | None) -> bool:
    """Decide whether exact arithmetic loses a special geometry because it replaces numbers.

    If the gap is wide, floating point still finds the geometry, and loses it with other
    numbers. A narrow gap comes from the numbers in the file, unless other numbers give more
    conditions.

    Args:
        space: the space by floating point.
        changed: the same with other numbers for those that are replaced; None if it does
            not exist.
    """
    if not space.doubts or _pose_changed(space):
        return changed is None or integers_differ(space, changed)
    return changed is not None and changed.rank > space.rank


def round_off_counts(space: DesignSpace, evidence: Evidence) -> bool:
    """Whether round-off counts as conditions in floating point.

    Replaced numbers are within 2^-64 of those of the file. They may lose a special geometry,
    and add conditions; conditions beside a narrow gap that they do not have are round-off.

    Args:
        space: the space by floating point.
        evidence: the findings of exact arithmetic.
    """
    return bool(space.doubts) and evidence.exact.rank < space.rank and evidence.exact.settled


def is_general_as_written(space: DesignSpace, evidence: Evidence) -> bool:
    """Whether the numbers of the file describe a general linkage.

    Exact arithmetic says so if no special geometry lies inside their digits, or none is wanted.
    Only where a file of few digits has numbers that are replaced, other than to close a loop,
    may a special geometry rest on them.

    Args:
        space: the space by floating point.
        evidence: the findings of exact arithmetic.
    """
    meant = space.linkage.meant
    return (
        meant is not None
        and evidence.exact.rank >= space.rank
        and (evidence.only_closed or meant.digits >= DIGITS_BEYOND_TOLERANCE)
    )


def notice_codes(space: DesignSpace) -> set[str]:
    """Collect the codes of the notices of the linkage."""
    return {notice.code for notice in space.linkage.notices}


def _pose_changed(space: DesignSpace) -> bool:
    """Whether the reference pose is not that of the file."""
    return bool(notice_codes(space) & {"assembled", "left_singular_pose"})


def with_changed_numbers(space: DesignSpace) -> DesignSpace | None:
    """Compute the design space of the linkage with other replaced numbers, in floating point.

    Returns:
        The space; None if the linkage does not assemble with these numbers.
    """
    linkage = space.linkage
    screws = change_replaced_numbers(linkage)
    units = np.array([[float(x) for x in screw] for screw in screws])
    turns = np.any(units[:, :3], axis=1)
    n = np.where(turns[:, None], units[:, :3], units[:, 3:])
    units /= np.sqrt(np.sum(n**2, axis=1, keepdims=True))
    near = np.array([joint.point for joint in linkage.joints])
    points = np.empty_like(near)
    points_on_axes(units, near, points)
    joints = tuple(
        replace(joint, screw=freeze(screw), point=freeze(point))
        for joint, screw, point in zip(linkage.joints, units, points, strict=True)
    )
    try:
        moved = assemble(replace(linkage, joints=joints), linkage.inputs, exactly=True)
        if space.planar and not moved.planar:
            return None
        return design_space(moved, **space.options)
    except LinkageError:
        return None
