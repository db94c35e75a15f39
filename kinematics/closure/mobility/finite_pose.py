"""A finite pose on a mode, away from the singular pose at which it starts.

The pose is as well conditioned as one within reach, and its independent joints are at round
positions: half-angle tangents that are multiples of 1/16. Joints that turn as much as they, or
not at all, then have rational half-angle tangents too, so that exact arithmetic closes the
loops.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinematics.closure.mobility.first_order import independent_rows, loop_singular_values
from kinematics.closure.mobility.motion_modes import SheetPose, follow_sheet, sheet_at
from kinematics.closure.newton import forward_kinematics, solve_positions
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain
from kinematics.model.chain import move_chain
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.tolerances import (
    NEAR_SINGULAR_RESIDUAL,
    TIE_RELATIVE,
    UNMOVED_DISTANCE,
)

# Least and furthest distance of the pose from the singular one (radians, characteristic
# lengths); first, longest and shortest step on the way.
NEAREST, FURTHEST = 0.25, 0.75
FIRST, LONGEST, SHORTEST = 0.01, 0.08, 1e-4
# Poses near the singular one of which the best conditioned is the start.
MAX_COMPARED = 24
# Round positions are those whose half-angle tangent is a multiple of this.
ROUND = 1.0 / 16.0


def finite_pose(chain: Chain, starts: Sequence[SheetPose]) -> Array:
    """Find a well conditioned pose on a mode, away from the reference pose.

    Args:
        chain: joints in loops that are closed; the reference pose is singular.
        starts: poses on the mode, near the reference pose.

    Returns:
        Joint positions (n,), chain units.
    """
    start = starts[0]
    if start.T.shape[1] > 1:  # on a curve, the poses on both sides are alike
        few = starts[:MAX_COMPARED]
        start = few[first_largest([_conditioning(chain, each) for each in few])]
    pose, ahead, step = start, start.q / np.linalg.norm(start.q), FIRST
    best, most = start, 0.0
    while np.abs(pose.q).max() < FURTHEST and step >= SHORTEST:
        along = pose.T @ (pose.T.T @ ahead)
        size = float(np.linalg.norm(along))
        there = follow_sheet(chain, pose, along * (step / size)) if size else None
        if there is None:
            step *= 0.43
            continue
        ahead, pose, step = there.q - pose.q, there, min(1.4 * step, LONGEST)
        value = _conditioning(chain, pose)
        if value > (1.0 + TIE_RELATIVE) * most or np.abs(best.q).max() < NEAREST:
            best, most = pose, value
    return _with_round_positions(chain, best)


def _conditioning(chain: Chain, pose: SheetPose) -> float:
    """Compute the smallest singular value of the loop matrix that counts, over the largest."""
    values, _ = loop_singular_values(
        loop_matrix(chain, forward_kinematics(chain, pose.q).screws)
    )
    return float(values[pose.q.size - pose.T.shape[1] - 1] / values[0])


def _with_round_positions(chain: Chain, pose: SheetPose) -> Array:
    """Move the independent joints of a pose to round positions; leave it if that fails."""
    joints = _leading_joints(pose)
    goal = pose.q.copy()
    steps = np.rint(np.tan(0.5 * goal[joints]) / ROUND)
    # None at the singular pose, where two of them may be special together.
    steps[steps == 0.0] = np.where(goal[joints] < -UNMOVED_DISTANCE, -1.0, 1.0)[steps == 0.0]
    goal[joints] = 2.0 * np.arctan(ROUND * steps)
    for share in np.linspace(0.25, 1.0, 4):
        target = pose.q[joints] + (goal[joints] - pose.q[joints]) * share
        rates = np.linalg.solve(pose.T[joints], target - pose.q[joints])
        there = follow_sheet(chain, pose, pose.T @ rates)
        if there is None:
            return pose.q
        pose = there
    begun = pose.q.copy()
    begun[joints] = goal[joints]
    at_pose = move_chain(chain, joints, np.eye(joints.size))
    q, residual = solve_positions(at_pose, begun)
    same = np.abs(q - begun).max() <= 1e-2 and residual <= NEAR_SINGULAR_RESIDUAL
    return q if same and sheet_at(chain, q).T.shape == pose.T.shape else pose.q


def _leading_joints(pose: SheetPose) -> IntArray:
    """Choose the independent joints of a pose: the first ones in order that move well."""
    sizes = np.linalg.norm(pose.T, axis=1)
    chosen: list[int] = []
    for j in np.flatnonzero(sizes > 0.2 * sizes.max()).tolist():
        values = np.linalg.svd(pose.T[[*chosen, j]], compute_uv=False)
        if values[-1] > 0.2 * sizes.max():
            chosen.append(j)
        if len(chosen) == pose.T.shape[1]:
            return np.array(chosen, dtype=np.int64)
    return independent_rows(pose.T)
