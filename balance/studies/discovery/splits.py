"""Geometries that split: at all poses their loops leave more freedoms than elsewhere.

A kite that is folded along its axis turns as one, or opens as two pairs of links: its parts
move independently. Only a pose next to it, closed by steps of least norm, tells this from a
node, where two motions meet.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.studies.discovery.lane_motion import freedoms
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays

# Way from the reference pose, radians, and number of directions in which it is gone.
WAY, WAYS = 0.2, 3


def motion_splits(structure: TopologyArrays, geometry: LaneGeometry) -> NDArray[np.bool_]:
    """Tell which linkages have more freedoms than generic ones, at all poses around."""
    n = len(structure.parent)
    screws = structure.screws(geometry)
    more = np.ones(len(screws), bool)
    for direction in np.random.default_rng(3).standard_normal((WAYS, n)):
        q, count = freedoms(structure, screws, np.zeros((len(screws), n)), 0.0 * direction)
        for _ in range(2):
            more &= count > structure.width
            q, count = freedoms(structure, screws, q, 0.5 * WAY * direction)
        more &= count > structure.width
    return more
