"""The topology of a linkage of a file, and its own geometry, from which walks can start."""

from __future__ import annotations

from itertools import groupby

import numpy as np

from balance.studies.discovery.structure import LaneGeometry
from balance.studies.discovery.topologies import TOPOLOGIES, Edge, Topology, edge_list
from kinematics.errors import UsageError
from kinematics.model.linkage import GROUND, Joint, Linkage
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.ties import first_least

# Sines and relative distances up to which axes are parallel, or meet.
ALIGNED = 1e-6
# Most links of which all orders are compared with those of the topologies with names.
MOST_LINKS = 8


def from_linkage(linkage: Linkage) -> tuple[Topology, LaneGeometry]:
    """Read topology and joints of a linkage.

    The topology has its name where it is one of `TOPOLOGIES`, and is a list of edges elsewhere.

    Args:
        linkage: a linkage of revolute and prismatic joints, in space also universal and
            spherical ones, without followers.

    Returns:
        The topology, and the geometry in one lane, normalised.

    Raises:
        UsageError: the linkage has other joints, or its topology does not move in general.
    """
    if linkage.mimics:
        raise UsageError(
            f"{linkage.name}: walks start from no linkage whose joints follow others"
        )
    edges, points, axes = _graph(linkage)
    space, points, axes = _place(edges, points, axes)
    text = " ".join(f"{kind if kind != 'R' else ''}{a}-{b}" for kind, a, b in edges)
    prefix = {"plane": "", "sphere": "sphere: ", "space": "space: "}[space]
    graph = edge_list(prefix + text)
    topology, order = _named(graph)
    structure = topology.structure()
    first = [order[k] for k in structure.origin.tolist()]
    geometry = LaneGeometry(
        np.stack([points[k][0] for k in first])[None],
        np.stack([_axis(axes[k], j, structure.origin) for j, k in enumerate(first)])[None],
    )
    geometry.axes[:, structure.free_axes] = np.tile(
        np.eye(3), (int(structure.free_axes.sum()) // 3, 1)
    )
    return topology, structure.normalise(geometry)


def _axis(axes: Array, joint: int, origin: IntArray) -> Array:
    """Select the axis of a joint among those of its joint of the graph."""
    return np.asarray(axes[int(np.sum(origin[:joint] == origin[joint]))])


def _graph(linkage: Linkage) -> tuple[list[Edge], list[Array], list[Array]]:
    """List edges, and points and axes (joints, 3) of each; link 0 is the ground."""
    ends = {loop.end: loop.successor for loop in linkage.loops}
    number = {GROUND: 0}
    edges: list[Edge] = []
    points, axes = [], []
    for _, some in groupby(enumerate(linkage.joints), key=lambda item: _stem(item[1])):
        group = list(some)
        kind = _kind(linkage, [joint for _, joint in group])
        parent, last = group[0][1].parent, group[-1][0]
        parent_link = number.get(parent)
        new = number[ends[last]] if last in ends else number.setdefault(last, len(number))
        if parent_link is None:
            raise UsageError(
                f"{linkage.name}: joint {group[0][1].name} is on no link of its own"
            )
        edges.append((kind, min(parent_link, new), max(parent_link, new)))
        points.append(np.array([joint.point for _, joint in group]))
        axes.append(np.array([_direction(joint) for _, joint in group]))
    return edges, points, axes


def _stem(joint: Joint) -> str:
    """The name in the file of a joint of several degrees of freedom."""
    return joint.name.rsplit(".", 1)[0] if joint.numbered else joint.name


def _direction(joint: Joint) -> Array:
    """The unit vector along a joint."""
    screw = np.asarray(joint.screw)
    axis = screw[3:] if joint.kind == "prismatic" else screw[:3]
    return np.asarray(axis / np.sqrt(axis @ axis))


def _kind(linkage: Linkage, joints: list[Joint]) -> str:
    """The kind of a joint of the graph."""
    kinds = [joint.kind for joint in joints]
    if kinds == ["prismatic"]:
        return "P"
    if set(kinds) == {"revolute"} and len(kinds) <= 3:
        return "RUS"[len(kinds) - 1]
    raise UsageError(
        f"{linkage.name}: joint {_stem(joints[0])} is neither revolute, prismatic, universal "
        "nor spherical; walks start from no such linkage"
    )


def _place(
    edges: list[Edge], points: list[Array], axes: list[Array]
) -> tuple[str, list[Array], list[Array]]:
    """Decide where the linkage moves, and turn a planar one into the plane xy.

    The axes of a spherical linkage all pass through the origin afterwards.
    """
    kinds = [kind for kind, _, _ in edges]
    turning = np.concatenate([a for a, kind in zip(axes, kinds, strict=True) if kind != "P"])
    n = turning[0]
    sliding = [a[0] for a, kind in zip(axes, kinds, strict=True) if kind == "P"]
    across = all(abs(a @ n) < ALIGNED for a in sliding)
    if set(kinds) <= {"R", "P"} and across and np.abs(np.cross(turning, n)).max() < ALIGNED:
        R = _turn(n)
        flat = [p @ R.T * [1.0, 1.0, 0.0] for p in points]
        turned = [
            a @ R.T * [1.0, 1.0, 0.0] if kind == "P" else np.eye(3)[2:]
            for a, kind in zip(axes, kinds, strict=True)
        ]
        return "plane", flat, turned
    if set(kinds) == {"R"}:
        centre, off = _centre(np.concatenate(points), turning)
        if off < ALIGNED:
            return "sphere", [p - centre for p in points], axes
    return "space", points, axes


def _turn(n: Array) -> Array:
    """A rotation that carries a unit vector to z."""
    x = np.cross(np.eye(3)[first_least(np.abs(n), 1.0)], n)
    x = x / np.sqrt(x @ x)
    return np.stack([x, np.cross(n, x), n])


def _centre(points: Array, axes: Array) -> tuple[Array, float]:
    """The point nearest to all axes, and its distance from them over their size."""
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    right = (across @ points[..., None])[..., 0]
    centre = np.linalg.lstsq(across.reshape(-1, 3), right.ravel(), rcond=None)[0]
    off = np.abs(across @ (points - centre)[..., None]).max()
    size = np.abs(points - points.mean(axis=0)).max()
    return np.asarray(centre), float(off / size) if size > 0.0 else 0.0


def _named(graph: Topology) -> tuple[Topology, list[int]]:
    """Find the topology with a name that has the same graph, and the joint for each of its."""
    same = [
        entry
        for entry in TOPOLOGIES.values()
        if entry.links == graph.links
        and len(entry.edges) == len(graph.edges)
        and entry.space == graph.space
        and not entry.gears
    ]
    for entry in same if graph.links <= MOST_LINKS else ():
        for joints in graph.matches(entry):
            return entry, list(joints)
    return graph, list(range(len(graph.edges)))
