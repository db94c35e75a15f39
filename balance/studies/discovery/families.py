"""Families of special geometries: members that fulfil the same relations.

Members whose relations differ by a symmetry of the graph are members of one family.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from balance.studies.discovery.quantities import (
    InvariantQuantity,
    joint_pairs,
    measure_quantities,
    quantities_of,
    site_geometry,
)
from balance.studies.discovery.relations import (
    GeometryRelation,
    gradients,
    held_relations,
    independent,
    list_relations,
)
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.topologies import Topology

Key = tuple[int, int, tuple[tuple[object, ...], ...]]

# Kinds that are the same up to the orientation of a link or loop.
ORIENTED = {
    "opposite angle": "same angle",
    "opposite function": "same function",
    "supplement": "equal",
}
# Most implied relations that are told.
MOST_IMPLIED = 4
# Kinds of which all relations that hold describe a family, not only the independent ones.
SIMPLE = {"zero", "straight", "right", "equal", "supplement"}


@dataclass(frozen=True, eq=False)
class Member:
    """A special geometry.

    Attributes:
        start: number of the walk that found it.
        geometry: the geometry, in one lane.
        nullity: dimension of its design space.
        codimension: number of equations that it fulfils.
        margin: how well its masses can be built; 0 if none can.
        relations: independent relations that hold.
        held: all relations of simple forms that hold.
        key: what all members of its family have in common.
    """

    start: int
    geometry: LaneGeometry
    nullity: int
    codimension: int
    margin: float
    relations: tuple[GeometryRelation, ...]
    held: tuple[GeometryRelation, ...]
    key: Key


@dataclass(frozen=True, eq=False)
class Family:
    """Members of one family.

    Attributes:
        topology: the graph.
        nullity: dimension of the design space of each member.
        generic: dimension of the design space of most geometries of the topology.
        codimension: number of equations that its members fulfil.
        relations: independent relations of its first member, in words.
        implied: short relations that hold as well: among the solutions of the independent ones,
            they select the members.
        complete: whether the relations are as many as the codimension.
        members: the members that walks found.
    """

    topology: Topology
    nullity: int
    generic: int
    codimension: int
    relations: tuple[str, ...]
    implied: tuple[str, ...]
    complete: bool
    members: tuple[Member, ...]

    @property
    def parallel(self) -> int:
        """Dimension of the part that most geometries do not have."""
        return self.nullity - self.generic


def relations_of(
    topology: Topology, structure: TopologyArrays, geometry: LaneGeometry
) -> list[tuple[list[GeometryRelation], list[GeometryRelation]]]:
    """Find the relations of special geometries, lane by lane.

    Returns:
        For each, all that hold, and independent ones.
    """
    quantities = quantities_of(topology)
    listed = list_relations(quantities)
    values = measure_quantities(quantities, site_geometry(structure, geometry))
    relations = []
    for lane in range(len(values)):
        held = held_relations(listed, values[lane])
        if held:
            lane_geometry = geometry.take(slice(lane, lane + 1))
            slopes = gradients(structure, quantities, lane_geometry, held)[0]
            relations.append((held, [held[k] for k in independent(slopes)]))
        else:
            relations.append(([], []))
    return relations


def group_members(
    topology: Topology,
    structure: TopologyArrays,
    generic: int,
    ends: Iterable[tuple[int, LaneGeometry, int, int, float]],
) -> tuple[Family, ...]:
    """Group special geometries to families, the largest first.

    Args:
        generic: nullity of most geometries.
        ends: number of the start, geometry in one lane, nullity, codimension and margin of
            each.
    """
    quantities, groups = quantities_of(topology), defaultdict(list)
    # Requirements that name joints or directions tell mirror images from each other.
    named = bool(structure.regions or structure.inputs)
    images = [list(range(len(quantities)))] if named else _images(topology, quantities)
    for start, geometry, nullity, codimension, margin in ends:
        held, chosen = relations_of(topology, structure, geometry)[0]
        key = (nullity, codimension, _canonical(held, chosen, images))
        groups[key].append(
            Member(
                start, geometry, nullity, codimension, margin, tuple(chosen), tuple(held), key
            )
        )
    families = []
    for (nullity, codimension, _), members in groups.items():
        first = members[0]
        texts = tuple(relation.text(quantities) for relation in first.relations)
        others = [r for r in first.held if r not in first.relations][:MOST_IMPLIED]
        implied = tuple(relation.text(quantities) for relation in others)
        families.append(
            Family(
                topology,
                nullity,
                generic,
                codimension,
                texts,
                implied,
                len(first.relations) == codimension,
                tuple(members),
            )
        )
    return tuple(sorted(families, key=lambda f: (-len(f.members), f.codimension, f.nullity)))


def _images(topology: Topology, quantities: tuple[InvariantQuantity, ...]) -> list[list[int]]:
    """Compute the number of the image of each quantity, for each symmetry of the graph."""
    number, links = {entry: k for k, entry in enumerate(quantities)}, joint_pairs(topology)
    return [
        [number[entry.image(order, links)] for entry in quantities]
        for order in topology.symmetries()
    ]


def _canonical(
    held: list[GeometryRelation], chosen: list[GeometryRelation], images: list[list[int]]
) -> tuple[tuple[object, ...], ...]:
    """Write relations so that symmetric sets read the same."""
    described = [r for r in held if r.kind in SIMPLE]
    described += [r for r in chosen if r.kind not in SIMPLE]
    best = None
    for image in images or [[]]:
        rows = []
        for kind, *sides in described:
            moved = [tuple(sorted(image[k] for k in side)) for side in sides]
            rows.append((ORIENTED.get(kind, kind), *sorted(moved)))
        text = tuple(sorted(rows))
        best = text if best is None or text < best else best
    return best or ()
