"""Quantities of a linkage that do not change when it moves: lengths, angles, offsets, arcs.

Joints go by letters in the order of the graph: A, B, C … Each link with joints A and B has the
length ``|AB|`` (on a sphere the arc between the axes); one with three joints in a plane has the
signed angles at their points. A sliding joint has the offsets of the points on either link.
"""

from __future__ import annotations

from itertools import combinations
from string import ascii_uppercase
from typing import NamedTuple

import numpy as np

from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.topologies import Topology
from kinematics.numerics.array_types import Array


class InvariantQuantity(NamedTuple):
    """A quantity that does not change in the motion.

    Attributes:
        kind: ``"length"``, ``"arc"``, ``"angle"``, ``"offset"``, ``"slope"`` or
            ``"constant"``.
        link: the link that it belongs to; -1 if it belongs to several.
        joints: the two joints; the vertex and the two others of an angle; the two points and
            the sliding joint of an offset; the joints around a loop for a slope k or constant
            c in ``cos(third) = c + k cos(first)`` of the angles at its corners.
    """

    kind: str
    link: int
    joints: tuple[int, ...]

    @property
    def text(self) -> str:
        """Name by the letters of the joints."""
        letters = [ascii_uppercase[j] for j in self.joints]
        if self.kind in ("slope", "constant"):
            return f"{self.kind[0]}({letters[0]}→{letters[2]} in {''.join(letters)})"
        if self.kind == "angle":
            return f"angle {letters[1]}{letters[0]}{letters[2]}"
        if self.kind == "offset":
            return f"offset of {letters[1]} from {letters[0]}"
        return "".join(letters)

    def image(
        self, order: tuple[int, ...], links: dict[frozenset[int], int]
    ) -> InvariantQuantity:
        """Apply a symmetry of the graph.

        Args:
            order: the image of each joint.
            links: the link of each pair of joints on one link.
        """
        moved = tuple(order[j] for j in self.joints)
        if self.kind in ("slope", "constant"):
            return InvariantQuantity(self.kind, -1, _loop_from(moved))
        if self.kind == "offset":
            return InvariantQuantity(self.kind, -1, (*sorted(moved[:2]), moved[2]))
        link = links[frozenset(moved[:2])]
        if self.kind == "angle":
            return InvariantQuantity(self.kind, link, (moved[0], *sorted(moved[1:])))
        return InvariantQuantity(self.kind, link, tuple(sorted(moved)))


def quantities_of(topology: Topology) -> tuple[InvariantQuantity, ...]:
    """List the quantities of a topology; none for a linkage in space."""
    if topology.space == "space":
        return ()
    quantities = []
    kinds = [kind for kind, _, _ in topology.edges]
    length = "arc" if topology.space == "sphere" else "length"
    for link in range(topology.links):
        points = [j for j in topology.joints_of(link) if kinds[j] == "R"]
        quantities += [
            InvariantQuantity(length, link, pair) for pair in combinations(points, 2)
        ]
        if topology.space == "plane":
            for three in combinations(points, 3):
                quantities += [
                    InvariantQuantity("angle", link, (j, *(k for k in three if k != j)))
                    for j in three
                ]
    for slide, (kind, a, b) in enumerate(topology.edges):
        if kind == "P":
            sides = [[j for j in topology.joints_of(x) if kinds[j] == "R"] for x in (a, b)]
            quantities += [
                InvariantQuantity("offset", -1, (*sorted((i, j)), slide))
                for i in sides[0]
                for j in sides[1]
            ]
    return tuple(quantities + (_loop_quantities(topology) if topology.space == "plane" else []))


def _loop_from(joints: tuple[int, ...]) -> tuple[int, ...]:
    """Run around a loop in the direction in which the second joint is less than the last."""
    a, b, c, d = joints
    return joints if b < d else (a, d, c, b)


def _loop_quantities(topology: Topology) -> list[InvariantQuantity]:
    """List slopes and constants of the loops of four links, from each corner."""
    loops = [
        joints
        for _, joints in topology.four_link_loops()
        if all(topology.edges[j][0] == "R" for j in joints)
    ]
    corners = [_loop_from((*x[k:], *x[:k])) for x in loops for k in range(4)]
    return [
        InvariantQuantity(kind, -1, corner)
        for kind in ("slope", "constant")
        for corner in corners
        if len(loops) > 1
    ]


def site_geometry(structure: TopologyArrays, geometry: LaneGeometry) -> LaneGeometry:
    """Select one joint for each joint of the graph."""
    first = [structure.origin.tolist().index(k) for k in range(structure.origin.max() + 1)]
    return LaneGeometry(geometry.points[:, first], geometry.axes[:, first])


def measure_quantities(quantities: tuple[InvariantQuantity, ...], sites: LaneGeometry) -> Array:
    """Compute quantities of linkages (lanes, quantities).

    Args:
        quantities: from `quantities_of`.
        sites: from `site_geometry`.
    """
    points, axes = sites
    with np.errstate(divide="ignore", invalid="ignore"):
        columns = [_value(entry, points, axes) for entry in quantities]
    return np.stack(columns, axis=1) if columns else np.zeros((len(points), 0))


def _value(entry: InvariantQuantity, points: Array, axes: Array) -> Array:
    """Compute one quantity of all lanes."""
    a, b = entry.joints[:2]
    if entry.kind in ("slope", "constant"):
        corners = points[:, list(entry.joints)]
        sides = np.sum((corners - np.roll(corners, -1, axis=1)) ** 2, axis=-1)
        ab, bc, cd, da = sides.T
        if entry.kind == "slope":
            return np.sqrt(ab * da / (bc * cd))
        return (bc + cd - ab - da) / (2.0 * np.sqrt(bc * cd))
    if entry.kind == "arc":
        sine = np.sqrt(np.sum(np.cross(axes[:, a], axes[:, b]) ** 2, axis=-1))
        return np.arctan2(sine, np.sum(axes[:, a] * axes[:, b], axis=-1))
    difference = points[:, b] - points[:, a]
    if entry.kind == "length":
        return np.sqrt(np.sum(difference**2, axis=-1))
    other = points[:, entry.joints[2]] - points[:, a]
    if entry.kind == "angle":
        cross = difference[:, 0] * other[:, 1] - difference[:, 1] * other[:, 0]
        return np.arctan2(cross, np.sum(difference * other, axis=-1))
    n = axes[:, entry.joints[2]]
    return n[:, 0] * difference[:, 1] - n[:, 1] * difference[:, 0]


def joint_pairs(topology: Topology) -> dict[frozenset[int], int]:
    """Return the link of each pair of joints that are on one link."""
    return {
        frozenset(pair): link
        for link in range(topology.links)
        for pair in combinations(topology.joints_of(link), 2)
    }
