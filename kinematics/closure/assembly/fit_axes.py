"""Fit of the axes of overconstrained loops: the nearest axes with which the loops close.

A loop that moves although its joints leave it no freedom in general, such as a spherical
one, does so because its axes fulfil relations; axes with rounded decimals fulfil them to
round-off only. Here the axes are moved by as little as possible until the loops close at
several finite poses at once, by the Gauss-Newton method with steps of least norm. Moving
axis j by the small displacement δ_j turns and shifts the end of its loop by

    Ad(H_parent(j)) (1 - Ad(exp(q_j ŝ_j))) δ_j

at a finite pose, for every kind of joint. The part of the residual that joint displacements can
remove is projected out at each pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.mobility.first_order import closure_equations, loop_singular_values
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain, freeze
from kinematics.model.chain import arrange_loops, extent, loop_signs
from kinematics.model.linkage import Joint, UnassembledLinkage
from kinematics.model.spatial.screws import Ad, exp, skew
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.gauss_newton import (
    FixedRank,
    Iterate,
    LeastNorm,
    gauss_newton,
    never_stop,
)
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.linalg.vectors import alike_groups
from kinematics.numerics.tolerances import (
    AXIS_ROUNDING,
    FIT_CONVERGED,
    FIT_RESIDUAL,
    FIT_STEP_RELATIVE_MAX,
    FIT_STEP_RELATIVE_MIN,
    LOOP_RANK_RELATIVE,
    MAX_TRIED_AXIS_CHANGE,
    MOTION_EQUAL,
)

# Distances of the nearest and of the furthest pose of the fit (radians, parts of the size).
NEAREST_POSE = 0.15
FURTHEST_POSE = 0.75
# Number of poses for each freedom, and for one more.
POSES_PER_FREEDOM = 8
# Seed of the directions of these poses.
SEED = 6
# Most steps that may pass before the residual halves, and most steps in all.
PATIENCE, MAX_STEPS = 4, 24


class Fit(NamedTuple):
    """Axes near those of a draft that let its loops move.

    Attributes:
        draft: the linkage with these axes.
        angle: largest change of a direction, in radians.
        shift: largest shift of an axis, in metres.
        furthest: name of the joint whose axis changes most, empty if none does.
        size: of the linkage, in metres, amid its joints.
        change: the larger of the two, with the shift in parts of the size of the linkage.
        freedom: degrees of freedom that the loops have.
        gap: closure residual with the axes as given, at poses that close them as well as
            possible; in radians and parts of the size.
    """

    draft: UnassembledLinkage
    angle: float
    shift: float
    furthest: str
    size: float
    change: float
    freedom: int
    gap: float


def fit_axes(draft: UnassembledLinkage, normal: Array | None = None) -> Fit | None:
    """Find the axes nearest to those of a linkage that let its loops move.

    Args:
        draft: a linkage whose joints depend on one another, with its loops closed at the
            reference pose.
        normal: normal (3,) of the plane in which the whole linkage moves but for rounding, if
            there is one.

    Returns:
        The fit; None if no axes nearby let the loops move.
    """
    chain = arrange_loops(draft, extent(draft))
    size = chain.frame.length
    rank = _rank_without_rounding(chain)
    poses = _sample_poses(chain, rank) if 0 < rank < chain.parent.size else []
    if 4 * len(poses) < 3 * POSES_PER_FREEDOM * (chain.parent.size - rank + 1):
        return None
    fresh, used = poses[::4], [q for i, q in enumerate(poses) if i % 4]
    gap = max(np.abs(_close_at_rank(chain, q, rank)[1]).max() for q in fresh)
    if gap <= FIT_RESIDUAL:
        return Fit(draft, 0.0, 0.0, "", size, 0.0, chain.parent.size - rank, float(gap))
    points = np.array([joint.point for joint in draft.joints])
    points = (points - chain.frame.origin) / size
    moved = _fitted_chain(chain, used, fresh, rank, points, normal)
    if moved is None:
        return None
    new = _write_axes(draft, moved)
    pairs = list(zip(draft.joints, new.joints, strict=True))
    turns, shifts = (
        np.array(
            [np.linalg.norm(_axis_at_point(a)[k] - _axis_at_point(b, a)[k]) for a, b in pairs]
        )
        for k in range(2)
    )
    changes = np.maximum(turns, shifts / size)
    angle, shift, change = (float(part.max()) for part in (turns, shifts, changes))
    furthest = draft.joints[first_largest(changes, relative=MOTION_EQUAL)].name
    freedom = chain.parent.size - rank
    return Fit(new, angle, shift, furthest, size, change, freedom, float(gap))


def _fitted_chain(
    chain: Chain,
    used: list[Array],
    fresh: list[Array],
    rank: int,
    points: Array,
    normal: Array | None,
) -> Chain | None:
    """Move axes until the loops close at poses, and at fresh ones; None if they do not."""
    for groups in (_group_parallel_joints(chain), [[j] for j in range(len(points))]):
        aligned = _align_axes(chain, groups, points, normal)
        moved = _move_axes(aligned, used, rank, _axis_displacements(groups, points))
        if moved and _closes(moved, fresh, rank):
            return moved
    moved = _through_one_point(chain)
    return moved if moved and _closes(moved, fresh, rank) else None


def _closes(chain: Chain, poses: list[Array], rank: int) -> bool:
    """Whether loops close to round-off next to poses."""
    residuals = (np.abs(_close_at_rank(chain, q, rank)[1]).max() for q in poses)
    return bool(max(residuals) <= FIT_RESIDUAL)


def _through_one_point(chain: Chain) -> Chain | None:
    """Shift axes that meet in one point but for rounding into it; None if they do not."""
    n, m = chain.screws[:, :3], chain.screws[:, 3:]
    if not n.any(axis=1).all() or np.abs(np.sum(n * m, axis=1)).max() > AXIS_ROUNDING:
        return None
    across = np.eye(3) - n[:, :, None] * n[:, None, :]
    centre, *_ = np.linalg.lstsq(across.sum(axis=0), np.cross(n, m).sum(axis=0), rcond=1e-6)
    there = np.concatenate([n, np.cross(centre, n)], axis=1)
    if np.abs(there - chain.screws).max() > AXIS_ROUNDING:
        return None
    return replace(chain, screws=freeze(there))


def _axis_at_point(joint: Joint, other: Joint | None = None) -> tuple[Array, Array]:
    """Compute the direction of a joint, and if it turns the moment about ``other.point``."""
    n, m = joint.screw[:3], joint.screw[3:]
    if joint.kind == "prismatic":
        return m, np.zeros(3)
    return n, m + np.cross(n, (other or joint).point)


def _group_parallel_joints(chain: Chain) -> list[list[int]]:
    """Group joints whose axes are parallel but for rounding."""
    directions = np.where(
        np.any(chain.screws[:, :3], axis=1)[:, None], chain.screws[:, :3], chain.screws[:, 3:]
    )
    return alike_groups(
        directions,
        lambda some, direction: (
            np.linalg.norm(np.cross(some, direction), axis=1) <= 2 * AXIS_ROUNDING
        ),
    )


def _align_axes(
    chain: Chain, groups: list[list[int]], points: Array, normal: Array | None = None
) -> Chain:
    """Align the axes of each group with their mean direction, at the same points.

    If the linkage is planar but for rounding, turning axes are along its normal.
    """
    screws = chain.screws.copy()
    for group in (g for g in groups if len(g) > 1):
        turning = [bool(chain.screws[j, :3].any()) for j in group]
        ns = np.array(
            [
                chain.screws[j, :3] if t else chain.screws[j, 3:]
                for j, t in zip(group, turning, strict=True)
            ]
        )
        signs = np.sign(ns @ ns[0])
        mean = signs @ ns
        if normal is not None and all(turning):
            mean = np.sign(mean @ normal) * normal
        mean /= np.linalg.norm(mean)
        for j, t, sign in zip(group, turning, signs, strict=True):
            n, p = sign * mean, points[j]
            pitch = chain.screws[j, :3] @ chain.screws[j, 3:]
            screws[j] = np.concatenate([n, pitch * n - np.cross(n, p)] if t else [0 * n, n])
    return replace(chain, screws=freeze(screws))


def _axis_displacements(groups: list[list[int]], points: Array) -> Array:
    """Compute twists of the axes (6 n) for turns of each group and shifts of each axis."""
    n = len(points)
    T = np.zeros((n, 6, 3 * len(groups) + 3 * n))
    for k, group in enumerate(groups):
        for j in group:
            T[j, :3, 3 * k : 3 * k + 3] = np.eye(3)
            T[j, 3:, 3 * k : 3 * k + 3] = skew(points[j])
    for j in range(n):
        T[j, 3:, 3 * (len(groups) + j) : 3 * (len(groups) + j) + 3] = np.eye(3)
    return T.reshape(6 * n, -1)


def _rank_without_rounding(chain: Chain) -> int:
    """Find the rank of the loop matrix without rounding, by its widest gap below."""
    values, _ = loop_singular_values(loop_matrix(chain))
    values = values / max(values[0], 1e-300)
    rank = int(np.sum(values > LOOP_RANK_RELATIVE))
    last = min(rank, len(values) - 1)
    choices = [r for r in range(1, last + 1) if values[r] < MAX_TRIED_AXIS_CHANGE]
    return max(choices, key=lambda r: values[r - 1] / max(values[r], 1e-300), default=rank)


def _sample_poses(chain: Chain, rank: int) -> list[Array]:
    """Find joint positions in many directions that close the loops as well as possible."""
    _, Vt = loop_singular_values(loop_matrix(chain))
    N, rng, poses = Vt[rank:].T, np.random.default_rng(SEED), []
    for distance in np.linspace(
        NEAREST_POSE, FURTHEST_POSE, POSES_PER_FREEDOM * (N.shape[1] + 1)
    ):
        v = N @ rng.standard_normal(N.shape[1])
        start = distance * v / np.linalg.norm(v)
        q, residual = _close_at_rank(chain, start, rank)
        if (
            np.abs(residual).max() <= MAX_TRIED_AXIS_CHANGE
            and np.linalg.norm(q - start) <= 0.7 * distance
        ):
            poses.append(q)
    return poses


def _close_at_rank(chain: Chain, q: Array, rank: int) -> tuple[Array, Array]:
    """Find joint positions next to q that close the loops best, and the residual there."""

    def converged(path: Sequence[Iterate]) -> bool:
        return path[-1].size <= FIT_CONVERGED

    rule = FixedRank(rank)
    last, _ = gauss_newton(closure_equations(chain), q, rule, converged, never_stop, 12)
    return last.next, last.residual


def _move_axes(chain: Chain, poses: list[Array], rank: int, moves: Array) -> Chain | None:
    """Move the axes of a chain until its loops close at the poses; None if they do not."""
    rule = _HalvingSteps()

    def relations(moved: Chain) -> tuple[Array, Array]:
        nonlocal poses
        poses, residuals, slopes = _irreducible_residual(moved, poses, rank)
        return residuals, slopes @ moves

    def move(moved: Chain, step: Array) -> Chain:
        small = (moves @ -step).reshape(-1, 6)
        return replace(
            moved,
            screws=freeze(
                [
                    Ad(_exp_of_small_twist(d)) @ s
                    for d, s in zip(small, moved.screws, strict=True)
                ]
            ),
        )

    def closed(path: Sequence[Iterate]) -> bool:
        return path[-1].error <= FIT_CONVERGED

    def failed(path: Sequence[Iterate]) -> bool:
        if rule.stalled or not np.isfinite(path[-1].error):
            return True
        return bool(
            np.abs(path[-1].next.screws - chain.screws).max() > 2 * MAX_TRIED_AXIS_CHANGE
        )

    best = gauss_newton(relations, chain, rule, closed, failed, MAX_STEPS, move).last
    return best.x if best.error <= FIT_RESIDUAL else None


class _HalvingSteps:
    """Steps of least norm by which the residual of the relations between the axes must halve.

    Where two solutions meet, as the parallelogram and the kite, it may grow before each step
    leaves a quarter of it: several steps may pass before it is half of the least so far.

    Attributes:
        stalled: whether more have passed.
    """

    def __init__(self) -> None:
        """Begin without steps."""
        self.stalled = False
        self._least, self._waited = np.inf, 0

    def step(self, residual: Array, jacobian: Array) -> Array:
        """Compute the step, without singular values that belong to no relation."""
        rcond = float(
            np.clip(100 * np.abs(residual).max(), FIT_STEP_RELATIVE_MIN, FIT_STEP_RELATIVE_MAX)
        )
        return LeastNorm(rcond).step(residual, jacobian)

    def accepts(self, before: Array, after: Array) -> bool:
        """Accept a step unless too many have not halved the residual, or it is round-off."""
        self._least = min(self._least, float(np.abs(before).max()))
        halved = np.abs(after).max() < 0.5 * self._least
        self._waited = 0 if halved else self._waited + 1
        self.stalled = self._waited > (PATIENCE if self._least > FIT_RESIDUAL else 0)
        return not self.stalled


def _irreducible_residual(
    chain: Chain, poses: list[Array], rank: int
) -> tuple[list[Array], Array, Array]:
    """Compute the part of the closure residual at poses that joint displacements cannot remove.

    Args:
        chain: the linkage as arrays.
        poses: joint positions (n,) near which the loops are closed as well as possible.
        rank: of the loop matrix.

    Returns:
        The poses; the residual left (count,); its derivatives by displacements of the axes
        (count, 6 n).
    """
    solved, residuals, slopes = [], [], []
    for start in poses:
        q, b = _close_at_rank(chain, start, rank)
        A = loop_matrix(chain, forward_kinematics(chain, q).screws)
        apart = np.linalg.svd(A)[0][:, rank:]
        solved.append(q)
        residuals.append(apart.T @ b)
        slopes.append(apart.T @ _axis_jacobian(chain, q))
    return solved, np.concatenate(residuals), np.concatenate(slopes)


def _axis_jacobian(chain: Chain, q: Array) -> Array:
    """Compute derivatives of the loop residual by displacements of the axes; (rows, 6 n)."""
    pose = forward_kinematics(chain, q)
    n, signs = q.size, loop_signs(chain.parent, chain.ends)
    J = np.zeros((len(chain.ends), 6, n, 6))
    for j in range(n):
        H = pose.H[chain.parent[j]] if chain.parent[j] >= 0 else np.eye(4)
        turn = Ad(H) @ (np.eye(6) - Ad(exp(chain.screws[j], q[j])))
        J[:, :, j] = signs[:, j, None, None] * turn
    return np.concatenate([J.reshape(-1, 6 * n), np.zeros((len(chain.mimics), 6 * n))])


def _exp_of_small_twist(small: NDArray[np.floating]) -> Array:
    """Compute the displacement ``exp(δ)`` of a small twist (6,); shape (4, 4)."""
    size = float(np.linalg.norm(small[:3]))
    return exp(small / size, size) if size > 0.0 else exp(small, 1.0)


def _write_axes(draft: UnassembledLinkage, chain: Chain) -> UnassembledLinkage:
    """Write the axes of a chain into a draft."""
    o, length = chain.frame.origin, chain.frame.length
    joints = []
    for joint, s in zip(draft.joints, chain.screws, strict=True):
        screw = s.copy()
        if joint.kind != "prismatic":
            screw[3:] = length * s[3:] - np.cross(s[:3], o)
        joints.append(replace(joint, screw=freeze(screw)))
    return replace(draft, joints=tuple(joints))
