"""Results of the search for reactionless paths: poses, paths, and why there is none."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from numpy.typing import ArrayLike

from balance.motion.paths.demand import Demand
from balance.motion.paths.path import ReactionlessPath
from balance.support.result_files import WithPage, WithPicture
from kinematics.model.linkage import Linkage, Notice
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, html_facts, number_text, repr_lines

if TYPE_CHECKING:
    from balance.motion.paths.tool_paths import ToolPaths

SCHEMA = "balance.paths/1"


@dataclass(frozen=True, eq=False)
class StartPose:
    """A pose through which paths are looked for.

    Attributes:
        u: displacements of the inputs (mobility,), rad and m.
        q: positions of all joints (n,).
        values: singular values of the equations over the momenta of the bodies (w,), falling.
        dimension: dimension of the null space in this pose.
        kind: see `balance.motion.paths.branches.Tangents`; ``"none"`` if the null space
            is empty.
        directions: tangents of the paths through it, as rates of the inputs (count, mobility).
        family: dimension of the set of paths through it.
        distance: distance from the pose asked for, in which less than 0.01 away several paths
            meet; else 0. Of a meeting: from the start from which it was found.
    """

    u: Array
    q: Array
    values: Array
    dimension: int
    kind: str
    directions: Array
    family: int
    distance: float

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "inputs": self.u.tolist(),
            "singular_values": self.values.tolist(),
            "dimension": self.dimension,
            "kind": self.kind,
            "directions": self.directions.tolist(),
            "family": self.family,
            "distance": self.distance,
        }


class PathTarget(NamedTuple):
    """What a path should reach.

    Attributes:
        u: displacements of the inputs (mobility,), rad and m.
        turn: rotation vector of a base that turns (3,), rad; None if it does not.
        reason: why the pose is not reached on one smooth path; empty if it is.
    """

    u: Array
    turn: Array | None
    reason: str

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "inputs": self.u.tolist(),
            "turn": None if self.turn is None else self.turn.tolist(),
        }


@dataclass(frozen=True, eq=False)
class ReactionlessPaths(WithPage, WithPicture):
    """Result of `find_paths`.

    Attributes:
        linkage: the linkage.
        demand: what vanishes along the paths.
        motion: relations of the inputs, or None.
        dimension: dimension of the null space of the equations in general.
        poses: number of poses that were looked at to decide that.
        starts: the poses asked for, or the meeting of paths close to one.
        meetings: poses in which several paths meet, within the length of a path.
        paths: the paths.
        notices: remarks for the user.
        target: the pose to reach, if one is given; the paths are then the segments to it, in
            order.
        tool: where the paths take a tool; see `with_tool`.
    """

    page_maker = "paths:paths_page"
    picture_maker = "paths:paths_picture"

    linkage: Linkage
    demand: Demand
    motion: Motion | None
    dimension: int
    poses: int
    starts: tuple[StartPose, ...]
    meetings: tuple[StartPose, ...]
    paths: tuple[ReactionlessPath, ...]
    notices: tuple[Notice, ...]
    target: PathTarget | None = None
    tool: ToolPaths | None = None

    def _repr_html_(self) -> str:
        """Table of the paths, for notebooks."""
        rows = (
            (f"path {k}", repr(path).removeprefix("ReactionlessPath "))
            for k, path in enumerate(self.paths, 1)
        )
        reason = [("none", self.reason)] if self.reason else []
        dimension = ("null space", f"{self.dimension} in general")
        title = f"ReactionlessPaths of {self.linkage.name}"
        return html_facts(title, dimension, *rows, *reason)

    def __repr__(self) -> str:
        """Two lines: the dimension, and the paths."""
        return repr_lines(
            f"ReactionlessPaths of {self.linkage.name}: null space of dimension "
            f"{self.dimension} in general",
            f"{count_noun(len(self.paths), 'path')} through "
            f"{count_noun(len(self.starts), 'pose')}, "
            f"{count_noun(len(self.meetings), 'meeting')} of paths found",
        )

    @property
    def reason(self) -> str:
        """Why there is no path; empty if there is one."""
        if self.paths:
            return ""
        if self.target is not None:
            return self.target.reason
        if self.demand.tolerance:
            return (
                "the least momentum in all starts is above "
                f"{number_text(self.demand.tolerance, '.3g')} of the bodies' own"
            )
        if any(start.kind == "isolated" for start in self.starts):
            return "rates without reaction exist in the pose, but no path leaves it along one"
        return (
            "the momentum matrix has full column rank in all of "
            f"{count_noun(self.poses, 'pose')} looked at"
        )

    def with_tool(self, link: str, point: ArrayLike | None = None) -> ReactionlessPaths:
        """Add where the paths take a tool, and where it gets at all.

        The paths span its reactionless workspace: ask `find_paths` for many in a family of two
        or more dimensions (``fan=24``), or for paths from many poses (``line=20``).

        Args:
            link: name of a moving link.
            point: its point (3,), metres, in the frame of the link; its origin by default.

        Returns:
            The same paths, with `tool`.

        Raises:
            BodyError: there is no such link, or no such point.

        Example:
            >>> import balance
            >>> paths = balance.find_paths("robot.urdf").with_tool("coupler")
            >>> len(paths.tool.ways), paths.tool.workspace.shape[1]
            (0, 3)
        """
        from balance.motion.paths.tool_paths import tool_paths

        components = self.demand.components
        tool = tool_paths(self.linkage, self.paths, link, point, components=components)
        return replace(self, tool=tool)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``balance/app/schemas/paths.schema.json``."""
        base = self.demand.base
        return {
            "schema": SCHEMA,
            "model": self.linkage.name,
            "at": self.linkage.at,
            "kept": self.demand.kept,
            "tolerance": self.demand.tolerance,
            "about": None if self.demand.about is None else list(self.demand.about),
            "base": None if base is None else {"mass": base.mass, "com": list(base.com)},
            "motion": [] if self.motion is None else list(self.motion.relations),
            "inputs": list(self.linkage.inputs),
            "joints": [joint.name for joint in self.linkage.joints],
            "length_unit": self.linkage.spatial_chain.frame.length,
            "dimension": self.dimension,
            "poses": self.poses,
            "starts": [start.to_dict() for start in self.starts],
            "meetings": [start.to_dict() for start in self.meetings],
            "target": None if self.target is None else self.target.to_dict(),
            "paths": [path.to_dict() for path in self.paths],
            "tool": None if self.tool is None else self.tool.to_dict(),
            "reason": self.reason or None,
            "warnings": [notice.to_dict() for notice in self.notices],
        }
