"""The pose of a tool at closed poses of a plan, and inverse kinematics.

Coordinates of a tool are those of `kinematics.tool`: shifts x, y, z of its point along the
inertial axes, and turns rx, ry, rz about x, about the y that it carries along, and about the z
that both carry along, all from the reference pose:

    R = X(rx) Y(ry) Z(rz)        ω = ex rx' + X ey ry' + X Y ez rz'
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.quiet.sampled_loads import SampledLinkage, SampledPoses
from kinematics.closure.assembly.tool_frame import DIRECTIONS, find_carrier
from kinematics.errors import PoseError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Steps on the straight line of the coordinates of a tool, and most Newton steps of each.
LINE_STEPS, NEWTON_STEPS = 40, 12
# Distance from a pose of the tool at which it is reached, rad and characteristic lengths.
REACHED = 1e-11
# Longest Newton step of an input, rad and characteristic lengths.
LONGEST = 0.5
# Size of the cosine of ry, and of a singular value over the largest one, that count as zero.
SINGULAR = 1e-8


@dataclass(frozen=True, eq=False)
class ToolPoint:
    """A link whose point moves, and which turns about it.

    Attributes:
        name: of the link.
        link: index of the rigid body.
        at: the point at the reference pose (3,), metres, inertial frame.
        units: of its coordinates: the characteristic length, or 1 rad (6,).
    """

    name: str
    link: int
    at: Array
    units: Array

    @classmethod
    def of(cls, linkage: Linkage, link: str, point: ArrayLike | None = None) -> ToolPoint:
        """Find a tool.

        Args:
            link: name of a moving link.
            point: its point (3,), metres, in the frame of the link; its origin by default.

        Raises:
            BodyError: there is no such link.
        """
        carrier, at = find_carrier(linkage, link, point, "link")
        length = linkage.spatial_chain.frame.length
        return cls(link, carrier, at, np.repeat([length, 1.0], 3))

    def coordinates(self, model: SampledLinkage, poses: SampledPoses) -> tuple[Array, Array]:
        """Compute the coordinates (P, 6) and their derivatives by the inputs (P, 6, w)."""
        H = model.displacements(poses.q)[:, self.link]
        R, p = H[:, :3, :3], H[:, :3, :3] @ self.at + H[:, :3, 3]
        rx = np.arctan2(-R[:, 1, 2], R[:, 2, 2])
        ry = np.arcsin(np.clip(R[:, 0, 2], -1.0, 1.0))
        rz = np.arctan2(-R[:, 0, 1], R[:, 0, 0])
        turns = poses.twists[:, self.link, :3]
        moves = poses.twists[:, self.link, 3:] - np.cross(p[:, :, None], turns, axis=1)
        # Columns are the axes of the three turns.
        axes = np.zeros((len(p), 3, 3))
        axes[:, 0, 0] = 1.0
        axes[:, 1, 1], axes[:, 2, 1] = np.cos(rx), np.sin(rx)
        cosine = np.where(np.cos(ry) > SINGULAR, np.cos(ry), SINGULAR)
        axes[:, 0, 2] = np.sin(ry)
        axes[:, 1, 2], axes[:, 2, 2] = -np.sin(rx) * cosine, np.cos(rx) * cosine
        rates = np.linalg.solve(axes, turns)
        values = np.concatenate([p - self.at, np.stack([rx, ry, rz], axis=1)], axis=1)
        return values, np.concatenate([moves, rates], axis=1)


@dataclass(frozen=True, eq=False)
class ToolPose:
    """Some coordinates of a tool.

    Attributes:
        tool: the tool.
        directions: indices of the coordinates in `DIRECTIONS`.
        values: of these coordinates, metres and rad.
    """

    tool: ToolPoint
    directions: tuple[int, ...]
    values: Array

    @classmethod
    def of(cls, linkage: Linkage, tool: ToolPoint, given: Mapping[str, float]) -> ToolPose:
        """Read coordinates by name.

        Raises:
            PoseError: a name is none of a coordinate, or a value is not finite.
        """
        for name, value in given.items():
            if name not in DIRECTIONS or not np.isfinite(value):
                raise PoseError(
                    f"{linkage.source}: '{name}={value:g}' is no coordinate of the tool: give "
                    f"some of {', '.join(DIRECTIONS)}, in metres and radians"
                )
        directions = tuple(k for k, name in enumerate(DIRECTIONS) if name in given)
        values = np.array([given[DIRECTIONS[k]] for k in directions])
        return cls(tool, directions, values)

    @property
    def words(self) -> str:
        """The coordinates, in words."""
        pairs = zip(self.directions, self.values, strict=True)
        return ", ".join(f"{DIRECTIONS[k]}={number_text(value)}" for k, value in pairs)

    def miss(self, model: SampledLinkage, poses: SampledPoses) -> tuple[Array, Array]:
        """Compute how far poses are from it (P, m), in units, and the derivatives (P, m, w)."""
        values, J = self.tool.coordinates(model, poses)
        rows = list(self.directions)
        off = values[:, rows] - self.values
        turning = np.array(rows) >= 3
        off[:, turning] = (off[:, turning] + np.pi) % (2.0 * np.pi) - np.pi
        units = self.tool.units[rows]
        return off / units, J[:, rows] / units[:, None]


def inputs_of_tool(
    model: SampledLinkage, units: Array, start: SampledPoses, pose: ToolPose
) -> SampledPoses:
    """Compute the closed pose in which a tool has given coordinates, by Newton's method.

    The coordinates move on a straight line from those of the start, so that the pose is on its
    branch. Where more inputs move than coordinates are given, each step is the shortest one.

    Args:
        units: of the inputs (w,).
        start: one closed pose.

    Raises:
        PoseError: the tool cannot get there.
    """
    linkage, now = model.linkage, start
    inputs = linkage.positions_of(linkage.inputs)
    first = pose.miss(model, start)[0][0]
    for share in np.linspace(0.0, 1.0, LINE_STEPS + 1)[1:]:
        for _ in range(NEWTON_STEPS):
            off, J = (part[0] for part in pose.miss(model, now))
            residual = off - (1.0 - share) * first
            if np.abs(residual).max() <= REACHED:
                break
            sizes = np.linalg.svd(J * units, compute_uv=False)
            step = -np.linalg.pinv(J * units, rcond=SINGULAR) @ residual
            beside = None
            if sizes.min() > SINGULAR * sizes.max() and np.abs(step).max() <= LONGEST:
                beside = model.near(now, (now.q[0, inputs] + units * step)[None])
            if beside is None:
                raise _out_of_reach(linkage, pose, share)
            now = beside
        else:
            raise _out_of_reach(linkage, pose, share)
    return now


def _out_of_reach(linkage: Linkage, pose: ToolPose, share: float) -> PoseError:
    """Make the error of a pose that the tool does not reach."""
    return PoseError(
        f"{linkage.source}: {pose.tool.name} cannot reach {pose.words} on a straight line: not "
        f"beyond {share - 1.0 / LINE_STEPS:.2g} of the way; the arm is too short there, "
        "stretched, or cannot move this way"
    )
