"""Random members of a conjectured family, and whether all of them are special.

A member is moved at random, and brought back to the relations by Newton's method, several
times. If the family is what its relations say, all members reached have its nullity.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.studies.discovery.families import Family
from balance.studies.discovery.polish import decide_special
from balance.studies.discovery.quantities import (
    measure_quantities,
    quantities_of,
    site_geometry,
)
from balance.studies.discovery.rejections import judge_geometries
from balance.studies.discovery.relations import HOLDS, GeometryRelation, gradients, residuals
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from kinematics.numerics.array_types import Array, Flags

MOVES, MOVE, NEWTON_STEPS = 6, 0.12, 6
CLOSE = 1e-13
BATCH, BATCHES = 60, 8


class FamilyConfirmation(NamedTuple):
    """How many random members of a family are special.

    Attributes:
        members: number of members that were decided.
        agreed: how many of them have the nullity of the family, or more.
        geometry: the members.
    """

    members: int
    agreed: int
    geometry: LaneGeometry


def random_members(
    structure: TopologyArrays,
    family: Family,
    count: int,
    rng: np.random.Generator,
) -> LaneGeometry:
    """Draw geometries that fulfil the relations of a family, connected to found members.

    Args:
        family: the family; each member moves within its own relations.
        count: number of draws; fewer come back, since some lose their way.
    """
    geometries = []
    share = -(-count // len(family.members[:count]))
    for member in family.members[:count]:
        many = LaneGeometry(*(np.repeat(a, share, axis=0) for a in member.geometry))
        relations = list(member.relations)
        direction = rng.standard_normal((share, len(structure.shifts)))
        direction /= np.abs(direction).max(axis=1, keepdims=True)
        for _ in range(MOVES):
            many = structure.change(many, MOVE * direction)
            many, good = _project(structure, family, many, relations)
            many, direction = many.take(good), direction[good]
        geometries.append(many.take(_holds(structure, family, many, list(member.held))))
    return LaneGeometry(*(np.concatenate(arrays) for arrays in zip(*geometries, strict=True)))


def _holds(
    structure: TopologyArrays,
    family: Family,
    geometry: LaneGeometry,
    relations: list[GeometryRelation],
) -> Flags:
    """Tell which geometries fulfil all relations of a member, the implied ones too."""
    values = measure_quantities(
        quantities_of(family.topology), site_geometry(structure, geometry)
    )
    wrong = [np.abs(residuals(r.kind, [r], values)[:, 0]) <= HOLDS for r in relations]
    return np.all(wrong, axis=0) if wrong else np.ones(len(values), bool)


def _project(
    structure: TopologyArrays,
    family: Family,
    geometry: LaneGeometry,
    relations: list[GeometryRelation],
) -> tuple[LaneGeometry, Flags]:
    """Return to the relations by the shortest steps, and tell which lanes arrived."""
    quantities = quantities_of(family.topology)

    def wrong(geometry: LaneGeometry) -> Array:
        values = measure_quantities(quantities, site_geometry(structure, geometry))
        return np.stack([residuals(r.kind, [r], values)[:, 0] for r in relations], axis=1)

    close = False
    for _ in range(NEWTON_STEPS if relations else 0):
        if close:
            break
        close = bool(np.abs(wrong(geometry)).max() <= CLOSE)
        slopes = gradients(structure, quantities, geometry, relations)
        step = -(np.linalg.pinv(slopes) @ wrong(geometry)[..., None])[..., 0]
        geometry = structure.change(geometry, step)
    if not relations:
        return geometry, np.ones(len(geometry.points), bool)
    return geometry, np.abs(wrong(geometry)).max(axis=1) <= CLOSE


def confirm(structure: TopologyArrays, family: Family, count: int) -> FamilyConfirmation:
    """Decide as many random members of a family."""
    rng = np.random.default_rng([1, family.nullity, family.codimension])
    agreed, chosen = 0, []
    remaining = count
    for _ in range(BATCHES):
        members = random_members(structure, family, BATCH, rng)
        ends = decide_special(structure, members, family.generic)
        fates = judge_geometries(family.topology, structure, members)
        decided = np.array([fate in ("special", "explained by one loop") for fate in fates])
        lanes = np.flatnonzero(decided & ends.clear)[:remaining]
        agreed += int(np.sum(ends.nullity[lanes] >= family.nullity))
        chosen.append(members.take(lanes))
        remaining -= len(lanes)
        if remaining == 0 or not len(members.points):
            break
    geometry = LaneGeometry(*(np.concatenate(arrays) for arrays in zip(*chosen, strict=True)))
    return FamilyConfirmation(count - remaining, agreed, geometry)
