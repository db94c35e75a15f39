"""Choose which joint follows which, for linear relations between pairs of joints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from kinematics.files.urdf.xml_tree import Refusal


class Relation(NamedTuple):
    """A relation ``first = offset + multiplier × second`` of joint positions.

    Attributes:
        first: name of a joint.
        second: name of another.
        multiplier: not zero.
        offset: rad or m.
        label: the constraint, in messages.
    """

    first: str
    second: str
    multiplier: float
    offset: float
    label: str


def follow_relations(relations: Iterable[Relation]) -> dict[str, tuple[str, float, float]]:
    """Let every joint follow at most one other, without circles.

    A relation is used as it stands if possible, otherwise solved for its second joint.

    Args:
        relations: in the order of the file.

    Returns:
        Source, multiplier and offset of each joint that follows another, by its name.

    Raises:
        Refusal: relations form a circle.
    """
    waiting: list[Relation] = []
    groups: dict[str, set[str]] = {}
    for relation in relations:
        group, other = (groups.setdefault(end, {end}) for end in relation[:2])
        if group is other:
            problem = "it couples joints that other constraints couple already"
            raise Refusal(relation.label, problem, "remove one of them")
        group |= other
        groups.update(dict.fromkeys(other, group))
        waiting.append(relation)
    firsts = {relation.first for relation in waiting}
    reached: set[str] = set()
    follows: dict[str, tuple[str, float, float]] = {}
    while waiting:
        r = next((r for r in waiting if r.first in reached or r.second in reached), None)
        if r is None:
            reached.add(next((r for r in waiting if r.second not in firsts), waiting[0]).second)
            continue
        waiting.remove(r)
        if r.second in reached:
            follows[r.first] = (r.second, r.multiplier, r.offset)
        else:
            follows[r.second] = (r.first, 1.0 / r.multiplier, -r.offset / r.multiplier)
        reached |= {r.first, r.second}
    return follows
