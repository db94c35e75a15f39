"""Ways of a tool along reactionless paths, and where it gets at all.

The paths through a pose span the reactionless workspace, a part of the complete one (E.
Papadopoulos and A. Abu-Abed's arm in G. Becht, MSc thesis, TU Delft, 2020, Fig. 11; for a plane
of two inputs J. J. de Jong, PhD thesis, University of Twente, Fig. 3.6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.paths.path import ReactionlessPath
from balance.motion.pose.null_space import Components
from balance.motion.pose.workspace_map import MomentumMap, momentum_map
from balance.motion.quiet.sampled_loads import SampledLinkage
from balance.motion.quiet.tool_point import ToolPoint
from balance.motion.verification.joint_limits import joint_limits
from kinematics.errors import PoseError
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Most poses of the inputs by which the complete workspace is seen, and along one of them.
POSES, MOST_ALONG = 2048, 121
# Every which pose along both of two inputs has a stroke.
APART = 2


@dataclass(frozen=True, eq=False)
class ToolPaths:
    """Where paths take a tool; metres, inertial frame, or that of a base that floats.

    Attributes:
        link: name of the link.
        point: its point at the reference pose (3,).
        ways: positions along each path (N, 3), sample by sample.
        workspace: positions (P, 3) at poses on a grid of all inputs within their limits, else
            within half a turn and the characteristic length to either side, that are reached
            from the reference pose without a singular one.
        strokes: of a linkage with two inputs, positions and unit directions (M, 2, 3) in which
            the tool moves at the rates with the least momentum, in some of these poses.
    """

    link: str
    point: Array
    ways: tuple[Array, ...]
    workspace: Array
    strokes: Array

    def __repr__(self) -> str:
        """One line: the tool, and how many paths take it."""
        return f"ToolPaths of {self.link}: {len(self.ways)}"

    @property
    def lengths(self) -> tuple[float, ...]:
        """Length of each way, metres."""
        return tuple(
            float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()) for way in self.ways
        )

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "link": self.link,
            "point": self.point.tolist(),
            "ways": [way.tolist() for way in self.ways],
            "workspace": self.workspace.tolist(),
            "strokes": self.strokes.tolist(),
        }


def tool_paths(
    linkage: Linkage,
    paths: Sequence[ReactionlessPath],
    link: str,
    point: ArrayLike | None = None,
    *,
    components: Components | None = None,
    poses: int = POSES,
) -> ToolPaths:
    """Compute where paths take a tool.

    Args:
        paths: paths of the linkage.
        link: name of a moving link.
        point: its point (3,), metres, in the frame of the link; its origin by default.
        components: of the momentum whose least rates are strokes; None for no strokes.
        poses: most poses by which the complete workspace is seen; 0 to leave it out.

    Raises:
        BodyError: there is no such link.
    """
    tool = ToolPoint.of(linkage, link, point)
    model = SampledLinkage.of(linkage, np.zeros(3))
    ways = tuple(freeze(_positions(model, tool, path.q)) for path in paths)
    field = _momentum_grid(linkage, components or "both", poses) if poses else None
    seen = np.empty((0, 3))
    if field is not None:
        seen = _positions(model, tool, field.positions[field.reached])
    strokes = np.empty((0, 2, 3))
    if field is not None and components is not None and len(linkage.inputs) == 2:
        strokes = _strokes(model, tool, field)
    return ToolPaths(link, freeze(tool.at), ways, freeze(seen), freeze(strokes))


def _positions(model: SampledLinkage, tool: ToolPoint, q: Array) -> Array:
    """Compute the positions of the point (P, 3) at positions of all joints (P, n)."""
    H = model.displacements(q)[:, tool.link]
    return np.asarray(H[:, :3, :3] @ tool.at + H[:, :3, 3])


def _momentum_grid(linkage: Linkage, components: Components, poses: int) -> MomentumMap | None:
    """Compute poses on a grid of all inputs; None if none of them is reached."""
    names, length = linkage.inputs, linkage.spatial_chain.frame.length
    places = linkage.positions_of(names)
    kinds = [linkage.joints[place].kind for place in places]
    reach = np.array([length if kind == "prismatic" else np.pi for kind in kinds])
    low, high = np.clip(joint_limits(linkage)[:, places], -reach, reach)
    count = max(3, min(MOST_ALONG, int(poses ** (1.0 / len(names)) + 1e-9)))
    grid = {
        name: np.linspace(low[k], high[k], count)
        for k, name in enumerate(names)
        if low[k] < high[k]
    }
    try:
        return momentum_map(linkage, grid, components)
    except PoseError:
        return None


def _strokes(model: SampledLinkage, tool: ToolPoint, field: MomentumMap) -> Array:
    """Compute the directions of the tool at the quietest rates of two inputs (M, 2, 3)."""
    picked = (slice(None, None, APART),) * 2
    reached = field.reached[picked]
    poses = model.close(field.positions[picked][reached])
    if poses is None:
        return np.empty((0, 2, 3))
    at, J = tool.coordinates(model, poses)
    way = np.einsum("pij,pj->pi", J[:, :3], field.quietest[picked][reached])
    size = np.linalg.norm(way, axis=1)
    moving = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    way = way[moving] / size[moving, None]
    return np.stack([at[moving, :3] + tool.at, way], axis=1)
