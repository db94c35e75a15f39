"""Four-bars whose relations are planted, as geometries of many lanes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.discovery.structure import LaneGeometry, TopologyArrays
from balance.discovery.topologies import Topology, topology

__all__ = ["four_bar_lanes", "lanes_of", "mirrored"]


def mirrored(point: Any, through: Any, along: Any) -> Any:
    """A point mirrored in a line, as complex numbers."""
    return through + along * np.conj((point - through) / along)


def lanes_of(
    graph: Topology, corners: NDArray[np.complex128]
) -> tuple[TopologyArrays, LaneGeometry]:
    """The arrays of a planar topology, and geometries with joints at complex points (lanes, joints).

    Args:
        graph: a topology of revolute joints in the plane.
        corners: the joints in the order of the graph.
    """
    structure = graph.structure()
    points = np.zeros((*corners.shape, 3))
    points[..., 0], points[..., 1] = corners.real, corners.imag
    axes = np.tile(np.eye(3)[2], (len(corners), corners.shape[1], 1))
    plain = LaneGeometry(points[:, structure.origin], axes[:, structure.origin])
    return structure, structure.normalise(plain)


def four_bar_lanes(
    corners: NDArray[np.complex128],
) -> tuple[Topology, TopologyArrays, LaneGeometry]:
    """Four-bars with joints A, B, C, D at complex points (lanes, 4)."""
    graph = topology("four-bar")
    return graph, *lanes_of(graph, corners)
