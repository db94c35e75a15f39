"""Linkages of found geometries, for all that the rest of the product computes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from balance.studies.discovery.lane_regions import frame_of
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.topologies import Topology
from kinematics.loading.building.screw_joints import ScrewJoint, from_screws
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

KINDS = {"R": "revolute", "P": "prismatic", "U": "universal", "S": "spherical"}


def joint_places(
    topology: Topology, structure: TopologyArrays, geometry: LaneGeometry
) -> Array:
    """Choose a point on the axis of each joint (lanes, joints, 3), apart from each other.

    On a sphere, where all axes meet, the points are at distance 1; a slider is at the next
    joint.
    """
    if structure.spherical:
        return geometry.axes.copy()
    points, first = geometry.points.copy(), structure.origin.tolist()
    for j in np.flatnonzero(structure.sliding).tolist():
        slide = topology.edges[first[j]]
        beside = [k for k in topology.joints_of(slide[2]) if topology.edges[k][0] != "P"]
        if beside:
            points[:, j] = geometry.points[:, first.index(beside[0])]
    return points


def in_frame(structure: TopologyArrays, geometry: LaneGeometry) -> LaneGeometry:
    """Place geometries in the frame of their ground, if requirements have one.

    Its origin comes to 0, its x along x, and the distance of two turning joints to 1.
    """
    if not structure.frame:
        return geometry
    A, d = frame_of(structure, geometry)
    size = np.sqrt(np.sum(d**2, axis=-1))[:, None]
    x, y = (d / size).T
    R = np.zeros((len(x), 3, 3))
    R[:, 0, 0] = R[:, 1, 1] = x
    R[:, 0, 1], R[:, 1, 0] = y, -y
    R[:, 2, 2] = 1.0
    points = geometry.points.copy()
    points[..., :2] -= A[:, None]
    points = np.einsum("lij,lnj->lni", R, points / size[..., None])
    return LaneGeometry(points, np.einsum("lij,lnj->lni", R, geometry.axes))


def to_linkage(
    topology: Topology,
    structure: TopologyArrays,
    geometry: LaneGeometry,
    lane: int = 0,
    inputs: Sequence[str] | None = None,
) -> Linkage:
    """Build the linkage of one geometry; its joints are named A, B, C … as the relations are.

    Args:
        inputs: names of the joints that drive it; by default those that requirements name, or
            a well-conditioned set.

    Raises:
        LinkageError: the linkage does not move, or its coordinates cannot be chosen.
    """
    tree: list[ScrewJoint] = []
    loops: list[ScrewJoint] = []
    named: dict[int, str] = {}
    ends = set(structure.ends[:, 0].tolist())
    reached = {0}
    geometry = in_frame(structure, geometry.take(slice(lane, lane + 1)))
    places = joint_places(topology, structure, geometry)[0]
    for k in dict.fromkeys(structure.origin.tolist()):
        kind, a, b = topology.edges[k]
        indices = np.flatnonzero(structure.origin == k)
        closes = indices[-1] in ends
        base, new = (a, b) if a in reached else (b, a)
        if closes:
            base, new = a, b
        else:
            reached.add(new)
        axes = geometry.axes[0, indices]
        second = axes[1] - (axes[1] @ axes[0]) * axes[0] if kind == "U" else None
        named[k] = chr(ord("A") + k)
        joint = ScrewJoint(
            named[k],
            f"link{base}" if base else "ground",
            f"link{new}" if new else "ground",
            axes[0] if kind != "S" else (1.0, 0.0, 0.0),
            places[indices[0]],
            KINDS[kind],
            axis2=second,
        )
        (loops if closes else tree).append(joint)
    for a, b, ratio in topology.gears:
        side = loops if chr(ord("A") + a) in {joint.name for joint in loops} else tree
        place = [joint.name for joint in side].index(named[a])
        side[place] = side[place]._replace(mimic=(named[b], ratio))
    if inputs is None and structure.inputs:
        inputs = [named[structure.origin[j]] for j in structure.inputs]
    return from_screws(tree, loops, inputs=inputs, name=topology.name.replace(" ", "_"))
