"""The poses of a plan, read from the words of a user, and closed poses between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.quiet.passed_poses import PassedPose
from balance.motion.quiet.problem import PoseLike, follow_poses, read_pose
from balance.motion.quiet.sampled_loads import SampledLinkage, SampledPoses
from balance.motion.quiet.tool_point import ToolPoint, ToolPose, inputs_of_tool
from kinematics.closure.assembly.tool_frame import DIRECTIONS
from kinematics.errors import PoseError, UsageError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

ToolLike = str | tuple[str, ArrayLike] | None
"""A link that is the tool; or the link and its point (3,), metres, in the frame of the link."""

# Poses on the straight line of the inputs between two stops.
LINE_POSES = 81


class Stops(NamedTuple):
    """The poses of a plan.

    Attributes:
        poses: in order; of a cycle, the first one does not come again.
        cycle: whether the motion returns to the first pose, and repeats.
        line: closed poses on the straight lines between them (N).
    """

    poses: tuple[PassedPose, ...]
    cycle: bool
    line: SampledPoses

    @property
    def inputs(self) -> list[Array]:
        """Displacements of the inputs at all stops; of a cycle with the first again."""
        stops = [pose.u for pose in self.poses]
        return [*stops, stops[0]] if self.cycle else stops

    @property
    def open_end(self) -> bool:
        """Whether the tool leaves inputs free at the end."""
        return not self.cycle and self.poses[-1].tool is not None

    @property
    def passes(self) -> tuple[PassedPose, ...]:
        """The poses that are passed; ends of which all inputs are given are none of them."""
        if self.cycle:
            return (self.poses[0]._replace(share=0.0), *self.poses[1:])
        last = (self.poses[-1]._replace(share=1.0),) if self.open_end else ()
        return (*self.poses[1:-1], *last)

    def reach(self, units: Array) -> float:
        """Compute the size of the motion, in units of the inputs (w,)."""
        return float((np.ptp(np.array(self.inputs), axis=0) / units).max())

    @property
    def known_ends(self) -> SampledPoses:
        """Closed poses at the stops where all inputs are given."""
        given = [k for k, pose in enumerate(self.poses) if pose.tool is None]
        places = (LINE_POSES - 1) * np.array(given, dtype=int)
        return SampledPoses(*(part[places] for part in self.line))


def read_tool(linkage: Linkage, tool: ToolLike) -> ToolPoint | None:
    """Find the tool that a user names.

    Raises:
        BodyError: there is no such link.
    """
    if tool is None:
        return None
    name, point = (tool, None) if isinstance(tool, str) else tool
    return ToolPoint.of(linkage, name, point)


def read_stops(
    model: SampledLinkage,
    units: Array,
    given: Sequence[PoseLike],
    tool: ToolPoint | None,
    cycle: bool,
) -> Stops:
    """Read the poses of a plan.

    Args:
        units: of the inputs (w,).
        given: the poses; those by name are of the inputs, or of the tool. Inputs that are not
            named stay.

    Raises:
        PoseError: there is only one pose, two that follow are one, or one cannot be reached.
        UsageError: a pose is one of a tool, and there is none.
    """
    linkage = model.linkage
    stops: list[PassedPose] = []
    for pose in given:
        before = stops[-1].u if stops else np.zeros(linkage.mobility)
        coordinates = _tool_coordinates(linkage, pose, tool)
        if coordinates is None:
            stops.append(PassedPose(read_pose(linkage, pose, before)))
            continue
        here = _last_pose(model, [stop.u for stop in stops] or [before])
        there = inputs_of_tool(model, units, here, coordinates)
        u = there.q[0, linkage.positions_of(linkage.inputs)]
        free = len(coordinates.directions) < linkage.mobility and bool(stops)
        stops.append(PassedPose(u, coordinates if free else None))
    inputs = [stop.u for stop in stops]
    inputs += inputs[:1] if cycle else []
    if any(np.abs(a - b).max() <= 1e-12 for a, b in zip(inputs[:-1], inputs[1:], strict=True)):
        which = "the two poses are" if len(stops) < 3 else "two poses that follow are"
        raise PoseError(f"{linkage.source}: {which} one: nothing moves")
    line = follow_poses(model, _polyline(inputs))
    return Stops(tuple(stops), cycle, line)


def _tool_coordinates(
    linkage: Linkage, pose: PoseLike, tool: ToolPoint | None
) -> ToolPose | None:
    """Read a pose of the tool; None if it is one of the inputs.

    Raises:
        UsageError: there is no tool.
    """
    if not isinstance(pose, Mapping) or not pose or set(pose) & set(linkage.inputs):
        return None
    if not set(pose) <= set(DIRECTIONS):
        return None
    if tool is None:
        raise UsageError(
            f"a pose with {', '.join(pose)} is one of a tool: name the link that is the tool"
        )
    return ToolPose.of(linkage, tool, pose)


def _last_pose(model: SampledLinkage, inputs: list[Array]) -> SampledPoses:
    """Compute the closed pose at the last of some stops, on the straight lines between them."""
    path = _polyline(inputs) if len(inputs) > 1 else np.array(inputs)
    return SampledPoses(*(part[-1:] for part in follow_poses(model, path)))


def _polyline(stops: list[Array]) -> Array:
    """Compute displacements of the inputs on the straight lines between stops."""
    share = np.linspace(0.0, 1.0, LINE_POSES)[:, None]
    legs = [a + share * (b - a) for a, b in zip(stops[:-1], stops[1:], strict=True)]
    return np.concatenate([legs[0], *(leg[1:] for leg in legs[1:])])
