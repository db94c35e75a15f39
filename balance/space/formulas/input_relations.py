"""Relations of inputs, as rows on the rates of joints that move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from balance.space.spaces.design_space import DesignSpace
from kinematics.errors import ExactError
from kinematics.numerics.linalg.rational import echelon

if TYPE_CHECKING:
    from balance.space.formulas.planar_parts import PartJoint

RateRelation = Mapping[int, Fraction]
"""Coefficients of the rates of joints of the chain, by their indices; the sum vanishes."""


def rate_relations(space: DesignSpace) -> list[RateRelation]:
    """Write the relations of the motion of a design space on the joints of its chain.

    Joints that the motion leaves at rest are not in the chain.

    Raises:
        ExactError: a relation is between angles and displacements, and has a length in it.
    """
    if space.motion is None:
        return []
    chain, joints = space.chain, space.linkage.joints
    place = {joints[index].name: k for k, index in enumerate(chain.joints.tolist())}
    relations: list[RateRelation] = []
    for text, row in space.motion.coefficients():
        relation = {
            place[name]: c
            for name, c in zip(space.motion.inputs, row, strict=True)
            if c and name in place
        }
        kinds = {joints[int(chain.joints[k])].kind == "prismatic" for k in relation}
        if len(kinds) > 1:
            raise ExactError(
                f"{space.source}: motion '{text}': formulas know no relation between angles "
                "and displacements"
            )
        if relation:
            relations.append(relation)
    if not relations:
        return []
    count = len(chain.joints)
    rows = [[relation.get(k, Fraction(0)) for k in range(count)] for relation in relations]
    solved, _ = echelon(rows)
    return [{k: c for k, c in enumerate(row) if c} for row in solved]


def parts_without_turn(
    relations: Sequence[RateRelation], joints: Sequence[PartJoint]
) -> frozenset[int]:
    """Find the moving parts that relations keep from turning; those that slide do not count.

    Args:
        relations: of the rates of the joints, about the normal of the plane.
        joints: of the linkage; part 0 is the ground.
    """
    count = 1 + max((max(joint.parts) for joint in joints), default=0)
    rows = []
    for relation in relations:
        row = [Fraction(0)] * count
        for k, c in relation.items():
            if not joints[k].slides:
                base, part = joints[k].parts
                row[part] += c
                row[base] -= c
        rows.append(row[1:])
    sliding = {part for joint in joints if joint.slides for part in joint.parts}
    solved, _ = echelon(rows) if rows else ([], [])
    still = {
        next(k for k, c in enumerate(row, start=1) if c)
        for row in solved
        if sum(c != 0 for c in row) == 1
    }
    return frozenset(still - sliding)
