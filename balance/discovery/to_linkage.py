"""Linkages of found geometries, for all that the rest of the product computes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.discovery.structure import LaneGeometry, TopologyArrays
from balance.discovery.topologies import Topology
from kinematics.building.screw_joints import ScrewJoint, from_screws
from kinematics.model.linkage import Linkage

__all__ = ["to_linkage"]

Array = NDArray[np.float64]

KINDS = {"R": "revolute", "P": "prismatic", "U": "universal", "S": "spherical"}


def to_linkage(
    topology: Topology, structure: TopologyArrays, geometry: LaneGeometry, lane: int = 0
) -> Linkage:
    """Build the linkage of one geometry; its joints are named A, B, C … as the relations are.

    Args:
        topology: the graph.
        structure: its arrays.
        geometry: the linkages.
        lane: which of them.

    Raises:
        LinkageError: the linkage does not move, or its coordinates cannot be chosen.
    """
    tree: list[ScrewJoint] = []
    loops: list[ScrewJoint] = []
    named: dict[int, str] = {}
    ends = set(structure.ends[:, 0].tolist())
    reached = {0}
    for k in dict.fromkeys(structure.origin.tolist()):
        kind, a, b = topology.edges[k]
        own = np.flatnonzero(structure.origin == k)
        closes = own[-1] in ends
        known, new = (a, b) if a in reached else (b, a)
        if closes:
            known, new = a, b
        else:
            reached.add(new)
        axes = geometry.axes[lane, own]
        second = axes[1] - (axes[1] @ axes[0]) * axes[0] if kind == "U" else None
        named[k] = chr(ord("A") + k)
        joint = ScrewJoint(
            named[k], f"link{known}" if known else "ground", f"link{new}" if new else "ground",
            axes[0] if kind != "S" else (1.0, 0.0, 0.0), geometry.points[lane, own[0]],
            KINDS[kind], axis2=second,
        )  # fmt: skip
        (loops if closes else tree).append(joint)
    for a, b, ratio in topology.gears:
        side = loops if chr(ord("A") + a) in {joint.name for joint in loops} else tree
        place = [joint.name for joint in side].index(named[a])
        side[place] = side[place]._replace(mimic=(named[b], ratio))
    return from_screws(tree, loops, name=topology.name.replace(" ", "_"))
