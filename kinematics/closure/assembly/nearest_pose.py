"""The nearest closed pose of open loops: many starts at once, and the least motion wins.

The motion from one pose to another is measured by the way that the links go. Joint j carries
the joints further out in the tree, and the welds; the furthest of them is d_j from its axis:

    motion = |y|,    y_j = w_j q_j,    w_j = max(d_j / size, 0.02)

for a joint that turns by q_j, within one turn; a joint that slides by q_j has
``w_j = 1 / size``. The size is that of `kinematics.model.chain.extent`. Joints of loops carry
no link of their own: they count by the least weight alone.

From every start, damped least-norm steps in y close the loops. Then steps

    y ← y - A⁺ b - 0.7 (1 - A⁺ A) y

along the freedoms that the loop matrix A leaves, with the closure residual b, lead to the pose
of least motion on the branch. All starts take their steps together, as arrays.
"""

from __future__ import annotations

import numpy as np

from kinematics.closure.mobility.components import Component
from kinematics.model.arrays import Chain
from kinematics.model.chain import extent, paths
from kinematics.model.full_turns import within_turn
from kinematics.model.spatial.screws import hat
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import CLOSED_SQUARE, ROTATION_PITCH

# Smallest weight of a joint in the motion, in parts of the size of the linkage.
LEAST_WEIGHT = 0.02
# Most damped steps that close the loops.
CLOSING_STEPS = 40
# Steps along the freedoms from every closed pose, further ones from the nearest, how many.
SLIDING_STEPS, FINAL_STEPS, FINALISTS = 3, 8, 2
# Part of the way along the freedoms that one step goes.
SLIDING_SHARE = 0.7
# Step along the freedoms, relative to the motion, at which the least motion is reached.
SETTLED = 0.03
# Largest step of one joint that closes loops, in radians and characteristic lengths, and of
# one entry of y along the freedoms.
LONGEST_STEP, LONGEST_SLIDE = 0.7, 0.5
# Damping at first, its factors after a step that opens the loops and after one that closes
# them, the least damping, and the one at which a start is given up.
FIRST_DAMPING, GROWTH, SHRINK, LEAST_DAMPING, MOST_DAMPING = 1e-2, 8.0, 0.1, 1e-9, 1e5
# Mean square of derivatives that is none: no joint changes the loops.
TINY = 1e-200


class OpenLoops:
    """The loops of a component at many poses at once.

    Attributes:
        chain: the component as arrays.
    """

    def __init__(self, chain: Chain, gaps: Array) -> None:
        """Prepare powers of the screws, and the order in which links are placed.

        Args:
            chain: the component as arrays.
            gaps: displacements of its welds at the reference pose (loops, 4, 4).
        """
        self.chain = chain
        s = hat(chain.screws)
        self._powers = np.stack([s, s @ s, s @ s @ s], axis=1).reshape(-1, 3, 16)
        self._screws, self._unfit = s, np.linalg.inv(gaps)
        # A helical joint is elsewhere after a turn, and so is one that another follows.
        n, m = chain.screws[:, :3], chain.screws[:, 3:]
        revolute = n.any(axis=1) & (np.abs(np.sum(n * m, axis=1)) <= ROTATION_PITCH)
        self._turning = revolute & ~chain.mimics.any(axis=0)
        before = paths(chain.parent)
        self._sides = [before[side][:, None, None, :] for side in chain.ends.T]
        depth = before[:-1].sum(axis=1)
        self._levels = [np.flatnonzero(depth == d) for d in range(1, int(depth.max()) + 1)]

    def residual(self, q: Array) -> tuple[Array, Array]:
        """Compute the closure residual and its derivatives by joint position.

        Args:
            q: joint positions (poses, n), chain units.

        Returns:
            Entries of ``D - 1`` for the displacement D of every loop, then the errors of mimic
            relations (poses, rows); and derivatives (poses, rows, n). They vanish at no other
            pose than a closed one.
        """
        count, n = q.shape
        H = self._place(q)
        inverse = np.zeros_like(H)
        inverse[..., :3, :3] = np.swapaxes(H[..., :3, :3], -1, -2)
        inverse[..., :3, 3] = -(inverse[..., :3, :3] @ H[..., :3, 3, None])[..., 0]
        inverse[..., 3, 3] = 1.0
        s = H[:, :-1] @ self._screws @ inverse[:, :-1]
        ends, successors = self.chain.ends.T
        D = H[:, ends] @ self._unfit @ inverse[:, successors]
        loops = len(ends)
        # Side by side, all products are one: (3n, 4) (4, 4 loops), and (3 loops, 4) (4, 4n).
        columns = D.transpose(0, 2, 1, 3).reshape(count, 4, -1)
        after = s[:, :, :3].reshape(count, -1, 4) @ columns
        columns = s.transpose(0, 2, 3, 1).reshape(count, 4, -1)
        before = D[:, :, :3].reshape(count, -1, 4) @ columns
        slopes = self._sides[0] * after.reshape(count, n, 3, loops, 4).transpose(0, 3, 2, 4, 1)
        slopes -= self._sides[1] * before.reshape(count, loops, 3, 4, n)
        relations = np.broadcast_to(self.chain.mimics, (count, *self.chain.mimics.shape))
        r = np.concatenate(
            [(D - np.eye(4))[:, :, :3].reshape(count, -1), q @ self.chain.mimics.T], axis=1
        )
        return r, np.concatenate([slopes.reshape(count, -1, n), relations], axis=1)

    def within_turn(self, q: Array) -> Array:
        """Take full turns off positions (..., n) of joints that turn and follow no other."""
        return within_turn(q, self._turning)

    def _place(self, q: Array) -> Array:
        """Compute displacements of the links, and of the ground (poses, n + 1, 4, 4)."""
        count, n = q.shape
        half = np.sin(0.5 * q)
        factors = np.stack([q, 2.0 * half * half, q - np.sin(q)], axis=-1)
        moved = (factors[:, :, None] @ self._powers).reshape(count, n, 4, 4) + np.eye(4)
        H = np.empty((count, n + 1, 4, 4))
        H[:, n] = np.eye(4)
        for joints in self._levels:
            H[:, joints] = H[:, self.chain.parent[joints]] @ moved[:, joints]
        return H


def motion_weights(part: Component) -> Array:
    """Compute the weights w (n,) of joint positions in the motion, in units of the chain."""
    draft, chain = part.draft, part.chain
    size, before = extent(draft).length, paths(chain.parent)
    points = [joint.point for joint in draft.joints]
    carried = [before[:-1], before[chain.ends[:, 1]]]
    for loop in draft.loops:  # the far side of the weld, where its successor has it
        points.append(loop.gap[:3, :3] @ draft.joints[loop.end].point + loop.gap[:3, 3])
    out, places = np.concatenate(carried) > 0.0, np.array(points)
    weights = np.zeros(len(draft.joints))
    for j, joint in enumerate(draft.joints):
        if joint.kind == "prismatic":
            weights[j] = chain.units[j] / size
        elif not joint.in_loop:
            arms = np.cross(places[out[:, j]] - joint.point, joint.screw[:3])
            weights[j] = np.sqrt(np.max(np.sum(arms**2, axis=1))) / size
    return np.maximum(weights, LEAST_WEIGHT)


def closed_poses(loops: OpenLoops, weights: Array, starts: Array, slide: bool = True) -> Array:
    """Close loops from many starts, and go along their freedoms to the least motion.

    Args:
        weights: those of `motion_weights` (n,).
        starts: joint positions (starts, n), chain units.
        slide: whether to go along the freedoms.

    Returns:
        Joint positions whose loops close, to about 1e-6 (poses, n), the least motion first.
    """
    q = loops.within_turn(_close(loops, weights, starts))
    if slide and len(q):
        q = _slide(loops, weights, q, SLIDING_STEPS)
        q = q[np.argsort(np.linalg.norm(q * weights, axis=1), kind="stable")]
        best = _slide(loops, weights, q[:FINALISTS], FINAL_STEPS)
        q = _close(loops, weights, np.concatenate([best, q[FINALISTS:]]))
    q = loops.within_turn(q)
    return np.asarray(q[np.argsort(np.linalg.norm(q * weights, axis=1), kind="stable")])


def _close(loops: OpenLoops, weights: Array, starts: Array) -> Array:
    """Close the loops by damped steps (Levenberg and Marquardt), all starts together."""
    q, damping = starts, np.full(len(starts), FIRST_DAMPING)
    r, A = loops.residual(q)
    poses = [q[:0]]
    for _ in range(CLOSING_STEPS):
        square = np.sum(r * r, axis=1)
        done = square < CLOSED_SQUARE
        poses.append(q[done])
        going = ~done & (damping < MOST_DAMPING) & np.isfinite(square)
        q, r, A, damping, square = (x[going] for x in (q, r, A, damping, square))
        if not len(q):
            break
        step = _damped_step(A / weights, r, damping) / weights
        ahead = q - _shortened(step, LONGEST_STEP)
        r_ahead, A_ahead = loops.residual(ahead)
        better = np.sum(r_ahead * r_ahead, axis=1) < square
        q = np.where(better[:, None], ahead, q)
        r = np.where(better[:, None], r_ahead, r)
        A = np.where(better[:, None, None], A_ahead, A)
        less = np.maximum(damping * SHRINK, LEAST_DAMPING)
        damping = np.where(better, less, damping * GROWTH)
    return np.concatenate(poses)


def _slide(loops: OpenLoops, weights: Array, q: Array, steps: int) -> Array:
    """Go along the freedoms of closed poses to the least motion; loops stay nearly closed.

    A step is taken if it makes ``|y| + 10 |b|`` smaller, with the closure residual b.
    """
    y, best = q * weights, np.full(len(q), np.inf)
    step = np.zeros_like(q)
    for _ in range(steps):
        ahead = y - step
        r, A = loops.residual(ahead / weights)
        A = A / weights
        merit = np.linalg.norm(ahead, axis=1) + 10.0 * np.linalg.norm(r, axis=1)
        better = merit < best
        y, best = np.where(better[:, None], ahead, y), np.where(better, merit, best)
        tiny = np.full(len(y), LEAST_DAMPING)
        along = ahead - _damped_step(A, (A @ ahead[..., None])[..., 0], tiny)
        if np.all(better & (np.linalg.norm(along, axis=1) <= SETTLED * merit)):
            break
        full = _damped_step(A, r, tiny) + SLIDING_SHARE * _shortened(along, LONGEST_SLIDE)
        step = np.where(better[:, None], full, 0.4 * step)
    return y / weights


def _damped_step(A: Array, r: Array, damping: Array) -> Array:
    """Compute ``(Aᵀ A + μ 1)⁻¹ Aᵀ r`` of many poses (poses, n), with μ relative to A."""
    transposed = np.swapaxes(A, 1, 2)
    normal = transposed @ A
    size = np.trace(normal, axis1=1, axis2=2) / A.shape[2]
    normal += (damping * np.maximum(size, TINY))[:, None, None] * np.eye(A.shape[2])
    return np.asarray(np.linalg.solve(normal, transposed @ r[..., None])[..., 0])


def _shortened(step: Array, longest: float) -> Array:
    """Shorten steps (poses, n) of which an entry is longer than that."""
    largest = np.abs(step).max(axis=1, keepdims=True)
    return np.asarray(step * np.minimum(1.0, longest / np.maximum(largest, longest)))
