"""The plane of two inputs behind reactionless paths: how quiet each pose is, and which way.

The shade of a pose is the smallest singular value of the momentum matrix over the bodies' own
momenta, of those that do not vanish everywhere: it vanishes where further paths meet.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.html.plot_style import short
from balance.motion.paths.found_paths import ReactionlessPaths
from balance.motion.pose.null_space import Components
from balance.motion.pose.workspace_map import momentum_map
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import PoseError

Array = NDArray[np.float64]

# Poses along each input, and every which of them has a stroke.
POSES = 61
APART = 3
# Half of the width if there are no paths, radians and characteristic lengths.
HALF_WIDTH = 0.5


class MomentumField(NamedTuple):
    """How quiet the poses in the plane of two inputs are.

    Attributes:
        first: positions of the first input (poses,), rad or m.
        second: those of the second input (poses,).
        size: smallest singular value that counts over the bodies' own momenta (poses, poses),
            first input first; NaN where no pose is reached.
        strokes: points (N, 2) of strokes along the directions with the least momentum, apart
            by NaN.
    """

    first: Array
    second: Array
    size: Array
    strokes: Array

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for the script of a page."""
        return {
            "x": short(self.first), "y": short(self.second),
            "size": [short(row) for row in self.size.T],
            "strokes": [short(values) for values in self.strokes.T],
        }  # fmt: skip


def momentum_field(solution: ReactionlessPaths) -> MomentumField | None:
    """Compute the field around paths, or around the first start if there are none.

    Returns:
        The field; None if the linkage has not two inputs, if its base floats, if the moment is
        about another point than the origin, or if no pose is reached.
    """
    linkage = solution.linkage
    demand = solution.demand
    if len(linkage.inputs) != 2 or demand.base is not None or solution.motion is not None:
        return None
    if demand.about is not None:
        return None
    first, second = _axes(solution)
    grid = dict(zip(linkage.inputs, (first, second), strict=True))
    kept = demand.kept
    components: Components = kept if kept in ("moment", "force") else "both"
    try:
        field = momentum_map(linkage, grid, components)
    except PoseError:
        return None
    counted = max(0, len(linkage.inputs) - 1 - solution.dimension)
    size = field.singular_values[..., counted] / field.scale
    picked = (slice(None, None, APART),) * 2
    at = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1)[picked]
    way = field.quietest[picked]
    step = max(first[1] - first[0], second[1] - second[0])
    half = 0.4 * APART * step * way / np.linalg.norm(way, axis=-1, keepdims=True)
    strokes = np.stack([at - half, at + half, np.full_like(at, np.nan)], axis=2)
    return MomentumField(first, second, size, strokes.reshape(-1, 2))


def _axes(solution: ReactionlessPaths) -> list[Array]:
    """Choose positions of both inputs: around the paths, alike in width."""
    linkage = solution.linkage
    units = input_chain(linkage).units[linkage.positions_of(linkage.inputs)]
    if solution.paths:
        u = np.concatenate([path.u for path in solution.paths])
        low, high = u.min(axis=0), u.max(axis=0)
        half = 0.6 * max(float(((high - low) / units).max()), 1e-3) * units
    else:
        low = high = solution.starts[0].u
        half = HALF_WIDTH * units
    middle, spread = 0.5 * (low + high), np.linspace(-1.0, 1.0, POSES)
    return [middle[k] + half[k] * spread for k in range(2)]
