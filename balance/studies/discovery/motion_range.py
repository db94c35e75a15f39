"""The range of motion of a linkage with one degree of freedom, up to its singularities.

From the reference pose the motion is followed both ways. It meets a singularity where

- the matrix of loops and tangent covector loses its rank: two motions meet, and the linkage may
  leave on either (its determinant changes its sign there), or
- the rate of the joint that drives it changes its sign: a dead point of that drive.
"""

from __future__ import annotations

from dataclasses import dataclass
from string import ascii_uppercase

import numpy as np

from balance.studies.discovery.lane_motion import follow_curves
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.topologies import Topology
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest

# Way of the fastest joint each way, radians, and poses on it: 0.02 rad apart.
WAY, POSES = 6.0 * np.pi, 960
# A joint that turns by a little more than this turns fully; one that meets the same singularity
# at either end turns by this.
TURN = 2.0 * np.pi + 0.01

DEAD_POINT, MEETING = "dead point", "meeting of motions"


@dataclass(frozen=True)
class MotionRange:
    """How far a joint on the ground can drive a linkage without a singularity.

    Attributes:
        joint: letter of the joint.
        low, high: least and largest position of it, degrees from the reference pose; -180 and
            180 for a full turn.
        full: whether it turns fully.
        ends: what ends the range at ``low`` and ``high``: ``"dead point"``,
            ``"meeting of motions"`` or, if neither is met, ``""``.
    """

    joint: str
    low: float
    high: float
    full: bool
    ends: tuple[str, str]

    @property
    def size(self) -> float:
        """Degrees from one end to the other."""
        return self.high - self.low


def motion_range(
    topology: Topology, structure: TopologyArrays, geometry: LaneGeometry
) -> MotionRange | None:
    """Compute the largest range over which a joint on the ground drives a linkage.

    Args:
        geometry: a linkage, in one lane.

    Returns:
        The range of the joint that has the largest one; None if the linkage has several
        degrees of freedom, or no revolute joint on the ground.
    """
    driving = [
        k for k, (kind, a, b) in enumerate(topology.edges) if kind == "R" and 0 in (a, b)
    ]
    if structure.width != 1 or not driving:
        return None
    ways = _ways(structure, geometry)
    ranges = [_range_of(structure, ways, k) for k in driving]
    return ranges[first_largest([span.size for span in ranges])]


def _ways(structure: TopologyArrays, geometry: LaneGeometry) -> list[tuple[Array, Array, bool]]:
    """Follow the motion both ways up to a meeting of motions: positions, rates, whether met."""
    poses = follow_curves(structure, geometry, WAY, POSES)
    start = follow_curves(structure, geometry, 1e-6, 1)
    ways = []
    for way in range(2):
        q, C, S = poses.q[0, way::2], poses.C[0, way::2, :, 0], poses.S[0, way::2]
        first = np.zeros((1, q.shape[1]))
        q, C = np.concatenate([first, q]), np.concatenate([start.C[0, way : 1 + way, :, 0], C])
        side = np.linalg.det(np.nan_to_num(np.concatenate([start.S[0, way : 1 + way], S])))
        apart = np.abs(np.diff(q, axis=0)).max(axis=1)
        lost = np.isnan(apart) | ~np.isfinite(C[1:]).all(axis=1) | (apart > 3.0 * WAY / POSES)
        crossed = side[1:] * np.sign(side[0]) <= 0.0
        stop = np.flatnonzero(lost | crossed)
        count = int(stop[0]) if stop.size else len(apart)
        q, C = q[: count + 1], C[: count + 1]
        if stop.size and not lost[count]:
            share = side[count] / (side[count] - side[count + 1])
            here = poses.q[0, way::2][count]
            q = np.concatenate([q, (q[-1] + share * (here - q[-1]))[None]])
            C = np.concatenate([C, C[-1:]])
        ways.append((q, C, bool(stop.size)))
    return ways


def _range_of(
    structure: TopologyArrays, ways: list[tuple[Array, Array, bool]], joint: int
) -> MotionRange:
    """Compute the range of one joint."""
    column = structure.origin.tolist().index(joint)
    ends = []
    for q, C, met in ways:
        rate, here = C[:, column] * np.sign(C[0, column]), q[:, column]
        back = np.flatnonzero(rate <= 0.0)
        cause = MEETING if met else ""
        reached = here[-1]
        if back.size:
            k = max(int(back[0]), 1)
            share = rate[k - 1] / (rate[k - 1] - rate[k])
            reached, cause = here[k - 1] + share * (here[k] - here[k - 1]), DEAD_POINT
        ends.append((float(reached), cause))
    (low, before), (high, after) = sorted(ends)
    full = high - low >= TURN
    if full:
        low, high, before, after = -np.pi, np.pi, "", ""
    degrees = np.degrees([low, high]).tolist()
    return MotionRange(ascii_uppercase[joint], degrees[0], degrees[1], full, (before, after))
