"""Planar linkages whose relations are planted, as geometries of many lanes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.topologies import Topology, topology

Points = NDArray[np.complex128]


def mirrored(point: Any, through: Any, along: Any) -> Any:
    """A point mirrored in a line, as complex numbers."""
    return through + along * np.conj((point - through) / along)


def lanes_of(graph: Topology, corners: Points) -> tuple[TopologyArrays, LaneGeometry]:
    """The arrays of a planar topology, and geometries with joints at complex points.

    Args:
        graph: a topology in the plane; a joint that slides does so along x.
        corners: the joints in the order of the graph (lanes, joints).
    """
    structure = graph.structure()
    points = np.zeros((*corners.shape, 3))
    points[..., 0], points[..., 1] = corners.real, corners.imag
    axes = np.where(structure.sliding[:, None], np.eye(3)[0], np.eye(3)[2])
    axes = np.tile(axes, (len(corners), 1, 1))
    plain = LaneGeometry(points[:, structure.origin], axes)
    return structure, structure.normalise(plain)


def four_bar_lanes(corners: Points) -> tuple[Topology, TopologyArrays, LaneGeometry]:
    """Four-bars with joints A, B, C, D at complex points (lanes, 4)."""
    graph = topology("four-bar")
    return graph, *lanes_of(graph, corners)


def similar_ternaries(rng: np.random.Generator, parallel: bool) -> Points:
    """A Stephenson III linkage: ADG and BCE are similar; GF, FE turn with AB and DC, or not.

    With ``g = AG / AD`` as complex numbers, ``GE = (1 - g) AB + g DC`` at all poses. So a dyad
    of these two vectors reaches from G to E at all poses; its mirror image has equal lengths.
    """
    A, D, G, turned, shift = rng.standard_normal((5, 2)) @ (1, 1j)
    B, C, E = (turned * z + shift for z in (A, D, G))
    g = (G - A) / (D - A)
    F = G + (g * (C - D) if rng.random() < 0.5 else (1.0 - g) * (B - A))
    return np.array([A, B, C, D, E, F if parallel else mirrored(F, E, G - E), G])


def _four_bar(kind: str) -> Callable[[np.random.Generator], Points]:
    def corners(rng: np.random.Generator) -> Points:
        A, B, C = rng.standard_normal((3, 2)) @ (1, 1j)
        D = A + C - B
        if kind == "kite":
            D = mirrored(B, A, C - A)
        if kind == "antiparallelogram":
            D = mirrored(D, A, C - A)
        return np.array([A, B, C, D])

    return corners


def _slider_crank(rng: np.random.Generator) -> Points:
    angle, length = rng.uniform(0.5, 1.1), rng.uniform(0.5, 2.0)
    B = length * np.exp(1j * angle)
    return np.array([0.0, B, 2.0 * B.real, 0.0])


# Topology, nullity, codimension and a random member of each family.
FAMILIES: dict[str, tuple[str, int, int, Callable[[np.random.Generator], Points]]] = {
    "kite": ("four-bar", 5, 2, _four_bar("kite")),
    "antiparallelogram": ("four-bar", 5, 2, _four_bar("antiparallelogram")),
    "parallelogram": ("four-bar", 7, 2, _four_bar("parallelogram")),
    "isosceles slider-crank": ("slider-crank", 6, 2, _slider_crank),
    "similar ternaries": ("stephenson3", 8, 4, lambda rng: similar_ternaries(rng, False)),
    "parallel ternaries": ("stephenson3", 10, 4, lambda rng: similar_ternaries(rng, True)),
}


def planted_corners(name: str, count: int, seed: int) -> Points:
    """Random members of a family, with joints that are well apart and links not in line.

    Args:
        name: one of `FAMILIES`.
        count: number of members.
        seed: of the members.
    """
    graph, draw = topology(FAMILIES[name][0]), FAMILIES[name][3]
    rng, found = np.random.default_rng(seed), []
    turning = [k for k, (kind, _, _) in enumerate(graph.edges) if kind == "R"]
    while len(found) < count:
        corners = draw(rng)
        own = corners[turning]
        apart = abs(own[:, None] - own)[np.triu_indices(len(own), 1)]
        if apart.min() > 0.3 * np.median(apart) and _bent(graph, corners) > 0.3:
            found.append(corners)
    return np.array(found)


def _bent(graph: Topology, corners: Points) -> float:
    """The least sine of the angles at the corners of loops of four links, and of dyads."""
    turns = [
        (loop[k - 1], loop[k], loop[(k + 1) % 4])
        for _, loop in graph.four_link_loops()
        for k in range(4)
        if all(graph.edges[j][0] == "R" for j in loop)
    ]
    for k, (kind, a, b) in enumerate(graph.edges):
        sides = [[j for j in graph.joints_of(link) if j != k] for link in (a, b)]
        if kind == "R" and all(len(side) == 1 for side in sides) and 0 not in (a, b):
            turns.append((sides[0][0], k, sides[1][0]))
    ratios = [(corners[a] - corners[k]) / (corners[b] - corners[k]) for a, k, b in turns]
    return float(min((abs(x.imag) / abs(x) for x in ratios), default=1.0))
