"""Rejections: special geometries that are degenerate, or that one loop alone explains."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from balance.studies.discovery.polish import far_conditions
from balance.studies.discovery.quantities import (
    measure_quantities,
    quantities_of,
    site_geometry,
)
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.topologies import Topology
from balance.studies.discovery.walk import LaneConditions
from kinematics.numerics.array_types import Array

# Shortest link, and shortest distance of joints that do not coincide, over the size (the root
# mean square of the joints' distances from their mean is 1).
SHORT, COINCIDE = 0.08, 0.02
# Smallest rate of a joint that is not idle, over the largest.
IDLE = 1e-7
# Differences of lengths in a loop that are taken for equal.
EQUAL = 1e-8
INDEPENDENT = 1e-8

OUTCOMES = (
    "special",
    "short link",
    "joints coincide",
    "idle joint",
    "idle link",
    "link does not turn",
    "motion splits",
    "explained by one loop",
    "explained by a part",
    "cannot be built",
    "not exact",
    "lost at a node",
    "not arrived",
)
"""What becomes of a walk."""


def judge_geometries(
    topology: Topology, structure: TopologyArrays, geometry: LaneGeometry
) -> list[str]:
    """Judge special geometries: ``"special"`` or why they are rejected.

    Args:
        geometry: polished ends of walks.

    Returns:
        One of `OUTCOMES` for each.
    """
    conditions = far_conditions(structure, geometry)
    quantities = quantities_of(topology)
    values = measure_quantities(quantities, site_geometry(structure, geometry))
    lengths = [k for k, entry in enumerate(quantities) if entry.kind in ("length", "arc")]
    out = []
    for lane in range(len(values)):
        if lengths and _shortest(topology, values[lane, lengths]) < SHORT:
            out.append("short link")
        elif _coincide(topology, structure, geometry, conditions, lane):
            out.append("joints coincide")
        elif _idle(structure, conditions, lane):
            out.append("idle joint")
        else:
            out.append(
                _still(topology, structure, conditions, lane)
                or explained(topology, structure, geometry, conditions, lane)
                or "special"
            )
    return out


def _shortest(topology: Topology, lengths: Array) -> float:
    """Return the shortest length; an arc counts from either end of its axis."""
    if topology.space == "sphere":
        lengths = np.minimum(lengths, np.pi - lengths)
    return float(lengths.min())


def _positions(
    structure: TopologyArrays, geometry: LaneGeometry, conditions: LaneConditions, lane: int
) -> Array:
    """Compute the joint points, or axes on a sphere, at all poses (poses, sites, 3)."""
    first = [structure.origin.tolist().index(k) for k in range(structure.origin.max() + 1)]
    H = conditions.poses.H[lane][:, structure.parent[first]]
    k = 2 if structure.planar else 3
    out = np.zeros((*H.shape[:2], 3))
    if structure.spherical:
        return np.asarray((H[..., :3, :3] @ geometry.axes[lane, first, :, None])[..., 0])
    points = geometry.points[lane, first, :k, None]
    out[..., :k] = (H[..., :k, :k] @ points)[..., 0] + H[..., :k, k]
    return out


def _coincide(
    topology: Topology,
    structure: TopologyArrays,
    geometry: LaneGeometry,
    conditions: LaneConditions,
    lane: int,
) -> bool:
    """Whether two joints stay at one place in all poses: the linkage is folded."""
    if topology.space == "space":
        return False
    x = _positions(structure, geometry, conditions, lane)
    turning = [k for k, (kind, _, _) in enumerate(topology.edges) if kind == "R"]
    for a, b in combinations(turning, 2):
        apart = np.sqrt(np.sum((x[:, a] - x[:, b]) ** 2, axis=-1))
        if topology.space == "sphere":
            apart = np.minimum(apart, np.sqrt(np.sum((x[:, a] + x[:, b]) ** 2, axis=-1)))
        if apart.max() < COINCIDE:
            return True
    return False


def _idle(structure: TopologyArrays, conditions: LaneConditions, lane: int) -> bool:
    """Whether a joint does not move in any pose, or no input in those of a requirement."""
    rates = np.abs(conditions.poses.C[lane]).max(axis=(0, 2))
    if rates.min() <= IDLE * rates.max():
        return True
    inputs = list(structure.inputs)
    others = [np.abs(poses.C[lane]).max(axis=(0, 2)) for poses in conditions.regions]
    return bool(inputs) and any(x[inputs].max() <= IDLE * x.max() for x in others)


def _still(
    topology: Topology, structure: TopologyArrays, conditions: LaneConditions, lane: int
) -> str:
    """Tell whether a link is at rest, or does not turn and explains the drop by that alone.

    The moment of inertia of a link that does not turn has no momentum: one dimension for each
    such link, beyond those that slide on the ground in all geometries of the topology.
    """
    H = conditions.poses.H[lane][:, structure.bodies]
    moved = np.abs(H - H[:1]).max(axis=0)
    size = 1.0 if structure.spherical else np.abs(H[..., :-1, -1]).max()
    if np.any(moved.max(axis=(1, 2)) <= IDLE * max(size, 1.0)):
        return "idle link"
    still = moved[:, :-1, :-1].max(axis=(1, 2)) <= IDLE
    still[[link - 1 for link in topology.sliding_links]] = False
    nullity = int(np.sum(conditions.values[lane] <= 1e-12 * conditions.values[lane, 0]))
    serial = len(topology.edges) + len(topology.sliding_links)
    if (
        topology.space == "plane"
        and not structure.regions
        and still.any()
        and nullity - serial <= still.sum()
    ):
        return "link does not turn"
    return ""


def _special_loop(lengths: Array, force: bool) -> bool:
    """Whether a four-bar is a kite, parallelogram or antiparallelogram.

    Args:
        lengths: of its four links, in order.
        force: whether forces alone are balanced, where kites are not special.
    """
    a, b, c, d = lengths
    same = EQUAL * float(np.max(lengths))
    pairs = ((a - c, b - d), (a - b, c - d), (a - d, b - c))[: 1 if force else None]
    return any(max(abs(x), abs(y)) <= same for x, y in pairs)


def explained(
    topology: Topology,
    structure: TopologyArrays,
    geometry: LaneGeometry,
    conditions: LaneConditions,
    lane: int,
) -> str:
    """Tell whether transfers at joints, and parts, explain the whole design space.

    The masses in question must be on the links of one loop of four links that would be special
    by itself, or on those of a part with the ground that moves by itself. That is known for
    dynamic balance and force balance in one motion, and of no other requirements.

    Returns:
        ``"explained by one loop"``, ``"explained by a part"`` or nothing.
    """
    if topology.space != "plane" or len(structure.ends) < 2 or structure.regions:
        return ""
    points = site_geometry(structure, geometry).points[lane]
    rank = int(np.sum(conditions.values[lane] > 1e-12 * conditions.values[lane, 0]))
    N = conditions.Vt[lane, rank:].T
    spaces = [_serial(topology, points)]
    if structure.force:
        spaces.append(np.eye(structure.unknowns)[:, 3::4])

    def on_links(links: tuple[int, ...]) -> Array:
        outside = [link - 1 for link in range(1, topology.links) if link not in links]
        rows = N.reshape(-1, 4, N.shape[1])[outside].reshape(-1, N.shape[1])
        return np.asarray(N @ _null(rows))

    for links, joints in topology.four_link_loops():
        corners = points[list(joints)]
        lengths = np.sqrt(np.sum((corners - np.roll(corners, 1, axis=0)) ** 2, axis=1))
        hinged = all(topology.edges[j][0] == "R" for j in joints)
        if hinged and _special_loop(lengths, structure.force):
            spaces.append(on_links(links))
    if _span(spaces) >= N.shape[1]:
        return "explained by one loop"
    spaces += [on_links(links) for links in topology.moving_parts()]
    return "explained by a part" if _span(spaces) >= N.shape[1] else ""


def _span(spaces: list[Array]) -> int:
    """Compute the dimension that columns span together."""
    values = np.linalg.svd(np.concatenate(spaces, axis=1), compute_uv=False)
    return int(np.sum(values > INDEPENDENT * values[0]))


def _serial(topology: Topology, points: Array) -> Array:
    """Compute unit columns of the transfers of point masses at revolute joints."""
    columns = []
    for (_, a, b), (x, y, _) in zip(topology.edges, points, strict=True):
        mass = np.array([1.0, x, y, x * x + y * y])
        z = np.zeros((topology.links, 4))
        z[b], z[a] = mass, -mass
        column = z[1:].ravel()
        columns.append(column / np.sqrt(column @ column))
    return np.stack(columns, axis=1)


def _null(rows: Array) -> Array:
    """Compute an orthonormal basis of the null space."""
    if not rows.size:
        return np.eye(rows.shape[1])
    _, values, Vt = np.linalg.svd(rows)
    return np.asarray(Vt[int(np.sum(values > INDEPENDENT)) :].T)
