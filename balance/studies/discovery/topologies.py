"""Topologies by name: their graphs, symmetries and structures.

A graph names for each joint its kind and the two links that it connects; link 0 is the ground.
Kinds are R (revolute) and P (prismatic), in space also U (universal) and S (spherical).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np

from balance.studies.discovery.structure import TopologyArrays
from kinematics.error_text import did_you_mean
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array

Edge = tuple[str, int, int]

# Most links of a topology from a list of edges.
MOST = 10
DEGREES = {"R": 1, "P": 1, "U": 2, "S": 3}


@dataclass(frozen=True)
class Topology:
    """A graph of links and joints.

    Attributes:
        name: name in requests.
        edges: kind and links of each joint.
        space: ``"plane"``, ``"sphere"`` or ``"space"``.
        gears: joints whose positions are in a ratio: ``q_a = ratio q_b``.
    """

    name: str
    edges: tuple[Edge, ...]
    space: str = "plane"
    gears: tuple[tuple[int, int, float], ...] = ()

    @property
    def links(self) -> int:
        """Number of links, the ground included."""
        return 1 + max(max(a, b) for _, a, b in self.edges)

    def joints_of(self, link: int) -> list[int]:
        """Return the joints on a link."""
        return [k for k, (_, a, b) in enumerate(self.edges) if link in (a, b)]

    def structure(self) -> TopologyArrays:
        """Convert to arrays: a tree from the ground, and loops."""
        return _structure(self)

    def symmetries(self) -> list[tuple[int, ...]]:
        """Return permutations of the joints that keep graph and ground."""
        return list(self.matches(self))

    def matches(self, other: Topology) -> Iterator[tuple[int, ...]]:
        """Yield, for each way in which another graph is this one, the joint for each of its."""
        ends = {frozenset((a, b)): (k, kind) for k, (kind, a, b) in enumerate(self.edges)}
        for order in permutations(range(1, self.links)):
            image = (0, *order)
            moved = [ends.get(frozenset((image[a], image[b]))) for _, a, b in other.edges]
            same = zip(moved, other.edges, strict=True)
            if all(new is not None and new[1] == edge[0] for new, edge in same):
                yield tuple(new[0] for new in moved if new is not None)

    def four_link_loops(self) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
        """List the loops of four links: the links in order, and the joints between them.

        The first joint is between the first two links, the last between the last and the first.
        """
        joint = {frozenset((a, b)): k for k, (_, a, b) in enumerate(self.edges)}
        loops = []
        for four in combinations(range(self.links), 4):
            for order in ((0, 1, 2, 3), (0, 1, 3, 2), (0, 2, 1, 3)):
                links = tuple(four[k] for k in order)
                pairs = [frozenset((links[k], links[(k + 1) % 4])) for k in range(4)]
                if all(pair in joint for pair in pairs):
                    loops.append((links, tuple(joint[pair] for pair in pairs)))
        return loops

    def moving_parts(self) -> list[tuple[int, ...]]:
        """List sets of five or more links with the ground whose joints leave one freedom.

        Each is a part of a planar linkage with revolute joints that moves by itself.
        """
        parts = []
        for count in range(5, self.links):
            for others in combinations(range(1, self.links), count - 1):
                links = {0, *others}
                inner = [{a, b} for _, a, b in self.edges if {a, b} <= links]
                if 3 * (count - 1) - 2 * len(inner) == 1 and _connected(links, inner):
                    parts.append((0, *others))
        return parts

    @property
    def sliding_links(self) -> set[int]:
        """Links that slide on the ground, or on one another from there: they never turn."""
        reached = {0}
        for _ in self.edges:
            pairs = [{a, b} for kind, a, b in self.edges if kind == "P"]
            reached |= {x for pair in pairs for x in pair if pair & reached}
        return reached - {0}


def _connected(links: set[int], pairs: list[set[int]]) -> bool:
    """Tell whether pairs connect all links with the ground, each by two joints at least."""
    reached = {0}
    for _ in links:
        reached |= {x for pair in pairs for x in pair if pair & reached}
    ends = [x for pair in pairs for x in pair]
    return reached == links and all(ends.count(x) > 1 for x in links)


def _revolute(*links: tuple[int, int]) -> tuple[Edge, ...]:
    return tuple(("R", a, b) for a, b in links)


# The chains of six links with mobility 1: two ternary links T, t and four binary ones.
# Watt: T = t jointed, and twice a dyad between them. Stephenson: two single binary links and
# one dyad between T and t. The ground is a binary link, or a ternary one.
TOPOLOGIES = {
    entry.name: entry
    for entry in (
        Topology("four-bar", _revolute((0, 1), (1, 2), (2, 3), (0, 3))),
        Topology("slider-crank", (*_revolute((0, 1), (1, 2), (2, 3)), ("P", 0, 3))),
        Topology(
            "geared-five-bar",
            _revolute((0, 1), (0, 4), (1, 2), (2, 3), (3, 4)),
            gears=((1, 0, -1.0),),
        ),
        Topology("watt1", _revolute((0, 1), (1, 2), (2, 3), (0, 3), (2, 4), (4, 5), (3, 5))),
        Topology("watt2", _revolute((0, 1), (1, 2), (2, 3), (0, 3), (3, 4), (4, 5), (0, 5))),
        Topology(
            "stephenson1",
            _revolute((0, 1), (1, 2), (2, 3), (0, 3), (1, 4), (4, 5), (3, 5)),
        ),
        Topology(
            "stephenson2",
            _revolute((0, 1), (1, 2), (2, 3), (1, 4), (4, 3), (0, 5), (5, 3)),
        ),
        Topology(
            "stephenson3",
            _revolute((0, 1), (1, 2), (2, 3), (0, 3), (2, 4), (4, 5), (0, 5)),
        ),
        Topology("spherical-four-bar", _revolute((0, 1), (1, 2), (2, 3), (0, 3)), "sphere"),
        Topology("r-u-s-r", (("R", 0, 1), ("U", 1, 2), ("S", 2, 3), ("R", 0, 3)), "space"),
        Topology(
            "3-rsr",
            (
                ("R", 0, 1),
                ("S", 1, 2),
                ("R", 2, 3),
                ("R", 0, 4),
                ("S", 4, 5),
                ("R", 3, 5),
                ("R", 0, 6),
                ("S", 6, 7),
                ("R", 3, 7),
            ),
            "space",
        ),
    )
}


EDGE = re.compile(r"([RPUS]?)([0-9]{1,9})-([0-9]{1,9})")


def topology(name: str) -> Topology:
    """Return a topology by name, or from a list of edges as ``0-1 1-2 2-3 P0-3``.

    Args:
        name: one of `TOPOLOGIES`, or edges; see `edge_list`.

    Raises:
        UsageError: there is none of this name.
    """
    if (listed := name.replace("_", "-")) in TOPOLOGIES:
        return TOPOLOGIES[listed]
    if name.split() and EDGE.fullmatch(name.split()[-1]):
        return edge_list(name)
    names = ", ".join(TOPOLOGIES)
    meant = did_you_mean(listed, TOPOLOGIES)
    raise UsageError(f"no topology {name!r}{meant}: one of {names}, or '0-1 1-2 2-3 0-3'")


def edge_list(text: str) -> Topology:
    """Read a graph from the pairs of links that its joints connect.

    Args:
        text: pairs as ``0-1 1-2 2-3 P0-3``; links are numbered from 0, the ground. Joints are
            revolute; a letter P before a pair stands for a prismatic one. ``sphere:`` or
            ``space:`` may come first; in space there are also universal joints, U, and
            spherical ones, S.

    Raises:
        UsageError: a pair is no pair, the links are not all connected, or they form no loop.
    """
    words = text.split()
    space = words.pop(0)[:-1] if words[0] in ("sphere:", "space:") else "plane"
    pairs = [EDGE.fullmatch(word) for word in words]
    read = [(m[1] or "R", int(m[2]), int(m[3])) for m in pairs if m is not None]
    kinds = {"plane": "RP", "sphere": "R", "space": "RPUS"}[space]
    if len(read) < len(pairs) or any(a == b or kind not in kinds for kind, a, b in read):
        raise UsageError(f"{text!r} is no list of pairs of links, as 0-1 1-2 2-3 P0-3")
    if max(max(a, b) for _, a, b in read) >= MOST:
        raise UsageError(f"{text!r} has more than {MOST} links, the ground included")
    if len({frozenset(ends) for _, *ends in read}) < len(read):
        raise UsageError(f"{text!r} connects two links by two joints")
    edges = tuple((kind, min(a, b), max(a, b)) for kind, a, b in read)
    graph = Topology(text, edges, space)
    reached = {0}
    for _ in edges:
        reached |= {x for _, a, b in edges for x in (a, b) if {a, b} & reached}
    if reached != set(range(graph.links)) or graph.structure().width < 1:
        raise UsageError(f"{text!r}: its links are not connected, or it does not move")
    if not graph.structure().ends.size:
        raise UsageError(f"{text!r} has no loop: its joints alone decide its design space")
    return graph


def _tree(edges: tuple[Edge, ...]) -> Iterator[tuple[int, int, int]]:
    """Yield edge, reached link and new link from the ground on; -1 for an edge of a loop."""
    reached, remaining = {0}, list(range(len(edges)))
    while remaining:
        for k in remaining:
            _, a, b = edges[k]
            if (a in reached) != (b in reached):
                yield k, *((a, b) if a in reached else (b, a))
                reached |= {a, b}
                remaining.remove(k)
                break
        else:
            break
    for k in remaining:
        yield k, edges[k][1], -1


def _structure(graph: Topology) -> TopologyArrays:
    """Number the joints of the tree before those of loops, and expand U and S."""
    parent: list[int] = []
    origin: list[int] = []
    link_joint, ends = {0: -1}, []
    for k, base, new in _tree(graph.edges):
        before = link_joint[base]
        for _ in range(DEGREES[graph.edges[k][0]]):
            parent.append(before)
            before = len(parent) - 1
            origin.append(k)
        if new >= 0:
            link_joint[new] = before
        else:
            ends.append((before, link_joint[graph.edges[k][2]]))
    n = len(parent)
    relations = np.zeros((len(graph.gears), n))
    for row, (a, b, ratio) in zip(relations, graph.gears, strict=True):
        row[origin.index(a)], row[origin.index(b)] = 1.0, -ratio
    shifts, turns, moved = _changes(graph, origin)
    return TopologyArrays(
        planar=graph.space == "plane",
        spherical=graph.space == "sphere",
        sliding=np.array([graph.edges[k][0] == "P" for k in origin]),
        parent=np.array(parent),
        ends=np.array(ends).reshape(-1, 2),
        relations=relations,
        bodies=np.array([link_joint[link] for link in range(1, graph.links)]),
        shifts=shifts,
        turns=turns,
        moved=moved,
        origin=np.array(origin),
    )


def _changes(graph: Topology, origin: list[int]) -> tuple[Array, Array, Array]:
    """List the permitted changes: translations, rotations, and the joints that they move."""
    axes, rows = np.eye(3), []
    for k, (kind, _, _) in enumerate(graph.edges):
        joints = [j for j, edge in enumerate(origin) if edge == k]
        if graph.space != "sphere" and kind != "P":
            ways = axes[:2] if graph.space == "plane" else axes
            rows += [(axis, 0.0 * axis, joints) for axis in ways]
        if kind == "P":
            rows.append((0.0 * axes[0], axes[2], joints))
        elif graph.space != "plane" and kind in "RU":
            rows += [(0.0 * axis, axis, [j]) for j in joints for axis in axes]
    moved = np.zeros((len(rows), len(origin)))
    for row, (_, _, joints) in zip(moved, rows, strict=True):
        row[joints] = 1.0
    return np.array([r[0] for r in rows]), np.array([r[1] for r in rows]), moved
