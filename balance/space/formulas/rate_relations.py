"""Relations of inputs, as rows on the rates of joints that move."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from balance.space.spaces.design_space import DesignSpace
from kinematics.errors import ExactError
from kinematics.numerics.linalg.rational import echelon

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
