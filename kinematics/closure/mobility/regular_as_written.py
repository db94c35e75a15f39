"""Components whose loops are regular in the decimals of their file, although axes look rounded.

Where the loop matrix has six independent rows for each loop, and one for each mimic relation,
the closed poses are a manifold (implicit function theorem), however small a singular value is.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from kinematics.closure.mobility.components import Component
from kinematics.errors import ExactError
from kinematics.files.urdf.rational_joints import RationalJoints
from kinematics.model.chain import loop_signs
from kinematics.model.linkage import UnassembledLinkage
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import Vector, dot, echelon, root
from kinematics.numerics.tolerances import (
    AXIS_ROUNDING,
    EXACT_SCREW_DIFFERENCE,
    LOOP_RANK_OF_FILE,
)


def regular_loop_ranks(
    draft: UnassembledLinkage,
    parts: Sequence[Component],
    spectra: Sequence[Array],
) -> list[int | None]:
    """Compute ranks of loop matrices that are regular as written, and nearly not.

    Args:
        spectra: singular values of the loop matrix of each (n,).

    Returns:
        The rank for each component that moves and is regular as written, but has singular
        values that rounded axes may leave; None for others, and where the joints or their
        positions are not those of the file.
    """
    doubtful = [
        bool(np.any((x > LOOP_RANK_OF_FILE * x.max()) & (x < AXIS_ROUNDING * x.max())))
        for x in spectra
    ]
    if not any(doubtful) or draft.tree is None or draft.displaced is not None:
        return [None] * len(parts)
    try:
        rational = RationalJoints(draft.tree)
    except ExactError:
        return [None] * len(parts)
    ranks = [
        _exact_rank(part, rational) if each else None
        for part, each in zip(parts, doubtful, strict=True)
    ]
    return [
        rank
        if rank == 6 * len(part.loops) + len(part.draft.mimics) < part.joints.size
        else None
        for part, rank in zip(parts, ranks, strict=True)
    ]


def _exact_rank(part: Component, rational: RationalJoints) -> int | None:
    """Compute the rank of the loop matrix of a component; None if its joints were moved."""
    joints = part.draft.joints
    if any(joint.name not in rational.joints for joint in joints):
        return None
    screws = [rational.joints[joint.name][1] for joint in joints]
    lengths = [dot(n, n) for n in (s[:3] if any(s[:3]) else s[3:] for s in screws)]
    doubles = np.array([joint.screw for joint in joints])
    units = np.array(screws, dtype=np.float64)
    units /= np.sqrt(np.array(lengths, dtype=np.float64))[:, None]
    if np.abs(units - doubles).max() > EXACT_SCREW_DIFFERENCE * max(1.0, np.abs(doubles).max()):
        return None
    rows: list[Vector] = []
    for signs in loop_signs(part.chain.parent, part.chain.ends).astype(int).tolist():
        columns = [[sign * x for x in s] for sign, s in zip(signs, screws, strict=True)]
        rows += zip(*columns, strict=True)
    for mimic in part.draft.mimics:
        row = [Fraction(0)] * len(joints)
        row[mimic.joint] = Fraction(1)
        if mimic.source != mimic.joint:
            size = root(lengths[mimic.source] / lengths[mimic.joint])
            if size is None:
                return None
            row[mimic.source] = -rational.mimics[joints[mimic.joint].name][1] * size
        rows.append(tuple(row))
    return len(echelon(rows)[0])
