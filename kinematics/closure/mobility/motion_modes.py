"""Motion modes: the smooth motions that meet at a singular pose.

Near a singular pose the closed poses form several sheets: each is a mode, with a mobility of
its own. Directions of the tangent cone lead to closed poses at a small distance; at such a pose
the loop matrix is regular, and its kernel is tangent to the sheet. Poses belong to one mode if

- one is reached from the other along the sheet, whose tangent space turns gradually: a path
  goes straight through poses at which another mode crosses; or
- they are on opposite sides of the singular pose. A curve leaves it in two senses, with

      q(t) = u t + c t² + …,    q̇(t) t = u t + 2 c t² + …

  of which u changes its sign from one side to the other, and c does not.

(A. Müller, "Local kinematic analysis of closed-loop linkages - mobility, singularities, and
shakiness", J. Mech. Robotics 8, 2016.)
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cmp_to_key
from typing import NamedTuple

import numpy as np

from kinematics.closure.mobility.first_order import (
    closure_equations,
    first_order,
    loop_singular_values,
)
from kinematics.closure.mobility.tangent_cone import cone_directions, second_order_forms
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.linalg.gauss_newton import (
    FixedRank,
    Iterate,
    LevenbergMarquardt,
    gauss_newton,
    step_grows,
)
from kinematics.numerics.linalg.vectors import alike_groups
from kinematics.numerics.tolerances import (
    LOOP_RANK_RELATIVE_SOLVED,
    NEAR_SINGULAR_CONVERGED,
    NEAR_SINGULAR_RESIDUAL,
    NEAR_SINGULAR_STEP,
    SAME_POSE_RELATIVE,
)
from kinematics.wording import count_noun

# Most starts of one round of the search for modes, for each freedom, and the fewest.
MAX_STARTS, STARTS, MIN_STARTS = 240, 48, 32
# Rounds of random starts: another one follows while a mode is reached from fewer starts than
# this, since there may be modes that no start reaches.
ROUNDS, MIN_HITS = 3, 3
# Most starts times the square of the number of joints, with which the cost of a start grows.
MAX_WORK = 400_000
# Distance of directions beside the tangent cone in which the search starts too, and their seed.
ASIDE, SEED = 0.2, 7
# Largest step along a sheet, relative to the distance from the singular pose; the cosine of the
# angle by which its tangent space may turn on the way; and the most steps.
STEP, TURN, MAX_STEPS = 0.2, 0.9, 14
# Paths that are tried between two groups of poses, the shortest ones, and the longest of them,
# relative to the distance from the singular pose: longer ones come near it.
PATHS, LONGEST_PATH = 3, 1.5
# Distance from an opposite pose, relative to that from the singular one, up to which it is one.
OPPOSITE = 0.3
# Part of the distance from the singular pose at which poses are tried again, if they are not
# regular: next to where modes cross a sheet turns fast.
NEARER = 0.1
# Difference of the entries of two projectors onto tangent spaces that is none.
SAME_TANGENTS = 0.02


class SheetPose(NamedTuple):
    """A regular closed pose.

    Attributes:
        q: joint positions (n,), chain units.
        T: orthonormal tangents of the closed poses there (n, mobility).
    """

    q: Array
    T: Array


class Mode(NamedTuple):
    """A smooth motion through a singular pose.

    Attributes:
        mobility: its degrees of freedom.
        poses: closed poses on it near the singular pose, at one distance.
        hits: number of starts of the search that lead to them.
    """

    mobility: int
    poses: tuple[SheetPose, ...]
    hits: int

    @property
    def projector(self) -> Array:
        """Mean of the projectors onto the tangent spaces of the poses (n, n)."""
        return np.asarray(np.mean([pose.T @ pose.T.T for pose in self.poses], axis=0))


class ModeSearch(NamedTuple):
    """Modes that a search has found.

    Attributes:
        modes: by mobility, then by the number of joints that they move, then by the rates of
            the joints. None if the linkage is rigid.
        doubt: why there may be more; empty if nothing speaks for it.
    """

    modes: tuple[Mode, ...]
    doubt: str = ""


class _Start(NamedTuple):
    """A closed pose near the singular one, and how many starts lead to it."""

    pose: SheetPose
    hits: int


def find_modes(chain: Chain, N: Array, distance: float) -> ModeSearch:
    """Find the modes that meet at the reference pose of a chain.

    Args:
        chain: joints in loops that are closed; spatial.
        N: orthonormal joint rates that close the loops at first order (n, f).
        distance: of the poses on each mode from the reference pose, chain units.

    Returns:
        The modes, and why there may be more.
    """
    n, freedom = N.shape
    wanted = min(max(STARTS * (freedom - 1), MIN_STARTS), MAX_STARTS)
    count = max(min(wanted, MAX_WORK // n**2), MIN_STARTS)
    forms = second_order_forms(chain, N)
    starts: list[_Start] = []
    search = ModeSearch(())
    for seed in range(ROUNDS):
        starts = _closed_starts(chain, N, distance, starts, cone_directions(forms, count, seed))
        search = _group_modes(chain, N, distance, starts)
        rare = any(mode.hits < MIN_HITS for mode in search.modes)
        if freedom <= 2 or not rare:
            break
    else:
        text = f"one of them was reached from few of {ROUNDS * count} directions"
        search = search._replace(doubt=search.doubt or text)
    if count < wanted:
        text = f"for so many joints only {count} directions were searched"
        search = search._replace(doubt=search.doubt or text)
    return search


def _closed_starts(
    chain: Chain, N: Array, distance: float, starts: list[_Start], cone: tuple[Array, IntArray]
) -> list[_Start]:
    """Close the loops in directions of the tangent cone, and on both sides of them.

    Args:
        chain: the linkage as arrays.
        N: orthonormal freedoms (n, f).
        distance: of the poses from the reference pose, chain units.
        starts: poses from directions before.
        cone: directions in the freedoms (k, f), and how many starts lead to each (k,).

    Returns:
        The poses of the starts, and further ones.
    """
    poses: list[SheetPose | None] = [start.pose for start in starts]
    places, hits = [start.pose.q for start in starts], [start.hits for start in starts]
    directions = _both_sides(cone[0])
    weights = np.resize(cone[1], len(directions))
    for u, weight in zip(directions, weights.tolist(), strict=True):
        q, residual = closest_pose(chain, N, distance, N @ u)
        if residual <= NEAR_SINGULAR_RESIDUAL and np.abs(q).max() <= 10 * distance:
            places.append(q)
            poses.append(None)
            hits.append(weight)
    groups = (
        alike_groups(places, lambda some, q: _are_same(some, q, distance)) if places else []
    )
    return [
        _Start(
            poses[group[0]] or sheet_at(chain, places[group[0]]), sum(hits[k] for k in group)
        )
        for group in groups
    ]


def _group_modes(chain: Chain, N: Array, distance: float, starts: list[_Start]) -> ModeSearch:
    """Group poses near the singular one into modes, in order."""
    hits = {id(start.pose): start.hits for start in starts}
    sheets = [start.pose for start in starts if _is_regular(chain, start.pose, distance)]
    if starts and not sheets:
        # Shaky everywhere: what the modes are does not show in the first-order freedoms.
        most = max(start.pose.T.shape[1] for start in starts)
        poses = tuple(start.pose for start in starts)
        return ModeSearch((Mode(most, poses, sum(hits.values())),))
    modes: list[Mode] = []
    for mobility in sorted({pose.T.shape[1] for pose in sheets}):
        alike = [pose for pose in sheets if pose.T.shape[1] == mobility]
        join = _pair_half_branches if mobility == 1 else _join_sheets
        modes += [
            Mode(
                mobility,
                tuple(sorted(group, key=_first_rate_is_negative)),
                sum(hits.get(id(pose), 0) for pose in group),
            )
            for group in join(chain, N, distance, alike)
        ]
    sheet_ids = {id(pose) for pose in sheets}
    shaky = sum(
        not _is_regular(chain, start.pose, NEARER * distance)
        for start in starts
        if id(start.pose) not in sheet_ids
    )
    doubt = f"{count_noun(shaky, 'pose')} nearby cannot be told apart" if shaky else ""
    return ModeSearch(tuple(sorted(modes, key=cmp_to_key(_compare_modes))), doubt)


def _both_sides(cone: Array) -> Array:
    """Add directions on both sides of each of the tangent cone (k, f), if they are few.

    Modes that are tangent to one another have one direction in the cone. From beside it the
    search comes to that on its side.
    """
    f = cone.shape[1]
    if f < 2 or not 0 < len(cone) <= MAX_STARTS // 3:
        return cone
    rng = np.random.default_rng(SEED)
    aside = cone[:, ::-1] * [-1.0, 1.0] if f == 2 else rng.standard_normal(cone.shape)
    aside = aside - np.sum(aside * cone, axis=1, keepdims=True) * cone
    aside = ASIDE * aside / np.linalg.norm(aside, axis=1)[:, None]
    directions = np.concatenate([cone, cone + aside, cone - aside])
    return np.asarray(directions / np.linalg.norm(directions, axis=1)[:, None])


def closest_pose(chain: Chain, N: Array, distance: float, start: Array) -> tuple[Array, float]:
    """Find the pose at a distance from the reference pose whose loops are least open.

    At a distance ε, the part of the residual that joint rates can close is of the size ε, and
    the rest of ε²: each is scaled by its own.

    Args:
        chain: the linkage as arrays.
        N: orthonormal freedoms (n, f).
        distance: length of the part in N of the joint positions.
        start: direction from which to start (n,).

    Returns:
        Joint positions, and the residual of the loops there.
    """
    U = np.linalg.svd(loop_matrix(chain))[0][:, : len(N) - N.shape[1]]
    W = np.eye(len(U)) / distance**2 + (U @ U.T) * (1.0 / distance - 1.0 / distance**2)
    closure = closure_equations(chain)

    def residual(x: Array) -> tuple[Array, Array]:
        b, A = closure(distance * x)
        u = N.T @ x
        more, row = (u @ u - 1.0)[None], 2.0 * (N @ u)[None]
        return np.concatenate([W @ b, more]), np.concatenate([distance * W @ A, row])

    rule = LevenbergMarquardt(0.1)

    def closest(path: Sequence[Iterate]) -> bool:
        arrived = len(path) > 1 and np.linalg.norm(path[-2].step) <= NEAR_SINGULAR_STEP
        return bool(arrived or np.linalg.norm(path[-1].residual) <= NEAR_SINGULAR_CONVERGED)

    def damped_out(path: Sequence[Iterate]) -> bool:
        return rule.damping > 1e6

    x = gauss_newton(residual, start, rule, closest, damped_out, 61).last.x
    pose = forward_kinematics(chain, distance * x)
    return pose.q, pose.error


def sheet_at(chain: Chain, q: Array) -> SheetPose:
    """Find the tangents of the closed poses at one of them.

    Args:
        chain: the linkage as arrays.
        q: joint positions that close the loops (n,), chain units.
    """
    A = loop_matrix(chain, forward_kinematics(chain, q).screws)
    return SheetPose(q, first_order(A, LOOP_RANK_RELATIVE_SOLVED)[0])


def follow_sheet(chain: Chain, pose: SheetPose, step: Array) -> SheetPose | None:
    """Make one step along a sheet of closed poses.

    Newton's method keeps the rank of the loop matrix, so that it stays on the sheet next to
    poses where the rank drops.

    Args:
        chain: the linkage as arrays.
        pose: a pose on the sheet.
        step: tangent to it (n,), chain units.

    Returns:
        The closed pose next to ``q + step``; None if there is none, or if the sheet turns too
        much on the way.
    """
    rank, size = len(pose.q) - pose.T.shape[1], float(np.linalg.norm(step))
    grows = step_grows(0.5 * size, NEAR_SINGULAR_RESIDUAL)

    def closed(path: Sequence[Iterate]) -> bool:
        return path[-1].error <= NEAR_SINGULAR_RESIDUAL

    solution = gauss_newton(
        closure_equations(chain), pose.q + step, FixedRank(rank), closed, grows, 12
    )
    if not solution.solved:
        return None
    q = solution.last.x
    _, Vt = loop_singular_values(loop_matrix(chain, forward_kinematics(chain, q).screws))
    there = SheetPose(q, Vt[rank:].T)
    if np.linalg.norm(q - pose.q - step) > 0.5 * size or not _are_near(there.T, pose.T):
        return None
    return there


def _are_near(T: Array, other: Array) -> bool:
    """Decide whether no direction of a tangent space is far from another one (n, d)."""
    return bool(np.linalg.svd(T.T @ other, compute_uv=False)[-1] >= TURN)


def _are_same(some: Array, q: Array, distance: float) -> Flags:
    """Decide which poses (k, n) are the same as another (n,)."""
    return np.asarray(
        np.abs(some - q).max(axis=1, initial=0.0) <= SAME_POSE_RELATIVE * distance
    )


def _is_regular(chain: Chain, pose: SheetPose, distance: float) -> bool:
    """Decide whether all first-order freedoms of a pose are tangents of closed poses."""
    generic = pose.T @ np.random.default_rng(1).standard_normal(pose.T.shape[1])
    step = 0.1 * distance * generic / max(float(np.linalg.norm(generic)), 1e-300)
    return all(_goes_on(chain, pose, sign * step) for sign in (1.0, -1.0))


def _goes_on(chain: Chain, pose: SheetPose, step: Array) -> bool:
    """Decide whether a sheet goes on in a direction with as many freedoms."""
    there = follow_sheet(chain, pose, step)
    return there is not None and sheet_at(chain, there.q).T.shape == pose.T.shape


def _pair_half_branches(
    chain: Chain, N: Array, distance: float, poses: list[SheetPose]
) -> list[list[SheetPose]]:
    """Pair poses on curves: those on both sides of the singular pose on one curve.

    A pose without another one on the other side is looked for there; if there is none, as at a
    cusp, it is a curve by itself.
    """
    sheets = list(poses)
    for pose in poses:
        q, residual = closest_pose(chain, N, distance, -pose.q / distance)
        if residual <= NEAR_SINGULAR_RESIDUAL and not any(
            _are_same(each.q[None], q, distance)[0] for each in sheets
        ):
            sheets.append(sheet_at(chain, q))
    sheets = [pose for pose in sheets if pose.T.shape[1] == 1]
    curves = [_tangent_and_curvature(N, pose) for pose in sheets]
    misfits = sorted(
        (float(np.linalg.norm(u + v) + np.linalg.norm(c - d)), i, j)
        for i, (u, c) in enumerate(curves)
        for j, (v, d) in enumerate(curves[:i])
    )
    pairs: list[list[SheetPose]] = []
    free = set(range(len(sheets)))
    for misfit, i, j in misfits:
        if i in free and j in free and misfit <= 1.0:
            pairs.append([sheets[j], sheets[i]])
            free -= {i, j}
    return pairs + [[sheets[k]] for k in sorted(free)]


def _tangent_and_curvature(N: Array, pose: SheetPose) -> tuple[Array, Array]:
    """Estimate u and ``ε c`` of the curve ``q = u ε + c ε²`` from one pose on it (n,) each."""
    epsilon = float(np.linalg.norm(N.T @ pose.q))
    along = pose.T[:, 0] * np.sign(pose.T[:, 0] @ pose.q)
    radial = float((N.T @ along) @ (N.T @ pose.q)) / epsilon
    t = along / max(radial, 1e-3)
    return 2.0 * pose.q / epsilon - t, t - pose.q / epsilon


def _join_sheets(
    chain: Chain, N: Array, distance: float, poses: list[SheetPose]
) -> list[list[SheetPose]]:
    """Group poses that paths along one sheet join, or that are opposite one another."""
    groups: list[list[SheetPose]] = []
    for pose in poses:
        joined = [group for group in groups if _are_joined(chain, [pose], group, distance)]
        groups = [group for group in groups if not any(group is each for each in joined)]
        groups.append([pose, *(each for group in joined for each in group)])
    k = 0
    while k < len(groups):
        opposite = _opposite(chain, N, distance, groups[k][0])
        partner = next(
            (
                other
                for other in groups
                if other is not groups[k]
                and (
                    _are_joined(chain, groups[k], other, distance)
                    or (opposite and _are_joined(chain, [opposite], other, distance))
                )
            ),
            None,
        )
        if partner is None:
            k += 1
            continue
        groups[k] = groups[k] + partner
        groups = [group for group in groups if group is not partner]
        k = 0
    return groups


def _are_joined(
    chain: Chain, some: list[SheetPose], others: list[SheetPose], distance: float
) -> bool:
    """Decide whether a path along a sheet leads from one of some poses to one of others."""
    apart = np.linalg.norm([[a.q - b.q for b in others] for a in some], axis=2)
    nearest = np.argsort(apart, axis=None, kind="stable")[:PATHS]
    rows, columns = np.unravel_index(nearest, apart.shape)
    return any(
        apart[i, j] <= LONGEST_PATH * distance
        and _path_leads(chain, some[i], others[j], distance)
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
    )


def _opposite(chain: Chain, N: Array, distance: float, pose: SheetPose) -> SheetPose | None:
    """Find the pose on the other side of the singular pose; None without one."""
    q, residual = closest_pose(chain, N, distance, -pose.q / distance)
    if residual > NEAR_SINGULAR_RESIDUAL or np.linalg.norm(q + pose.q) > OPPOSITE * distance:
        return None
    opposite = sheet_at(chain, q)
    return opposite if opposite.T.shape == pose.T.shape else None


def _path_leads(chain: Chain, start: SheetPose, goal: SheetPose, distance: float) -> bool:
    """Decide whether a path along the sheet of one pose leads to another one."""
    pose, longest = start, STEP * distance
    for _ in range(MAX_STEPS):
        away = goal.q - pose.q
        if np.abs(away).max() <= SAME_POSE_RELATIVE * distance:
            return _are_near(pose.T, goal.T)
        along = pose.T @ (pose.T.T @ away)
        size = float(np.linalg.norm(along))
        if size <= 0.3 * float(np.linalg.norm(away)):
            return False
        there = follow_sheet(chain, pose, along * min(1.0, longest / size))
        if there is None:
            return False
        pose = there
    return False


def _first_rate_is_negative(pose: SheetPose) -> bool:
    """Decide whether the first joint that moves has moved backwards."""
    moving = np.abs(pose.q) > SAME_TANGENTS * np.abs(pose.q).max()
    return bool(pose.q[np.argmax(moving)] < 0.0)


def _compare_modes(mode: Mode, other: Mode) -> int:
    """Compare two modes for their order, up to round-off: negative if the first comes first."""
    if mode.mobility != other.mobility:
        return mode.mobility - other.mobility
    P, Q = mode.projector, other.projector
    moving = [int(np.sum(np.diag(each) > SAME_TANGENTS**2)) for each in (P, Q)]
    if moving[0] != moving[1]:
        return moving[0] - moving[1]
    for a, b in (
        (np.diag(P), np.diag(Q)),
        (P[np.triu_indices_from(P)], Q[np.triu_indices_from(Q)]),
    ):
        differ = np.flatnonzero(np.abs(a - b) > SAME_TANGENTS)
        if differ.size:
            return -1 if a[differ[0]] > b[differ[0]] else 1
    return 0
