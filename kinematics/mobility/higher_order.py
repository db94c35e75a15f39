"""Local mobility beyond the first order: the branches of motion through a singular pose.

Joint rates that close the loops at first order span the freedoms F of a pose. Where they are
more than the linkage really has, the closed poses do not form a smooth surface there: near
that pose they form a cone, whose section by a small sphere in F, its *link*, determines the
branches (J. Milnor, "Singular points of complex hypersurfaces", 1968; A. Müller, "Local
kinematic analysis of closed-loop linkages", 2019). The link is found by solving for closed
poses at a given distance from many starts. A branch with one degree of freedom meets it in
two points, one for each sense of the motion. If it is empty, no pose is left: the linkage
moves only infinitesimally, up to the order at which the loops stop closing, which is the
exponent k of the least residual ``c ε^k`` at the distance ε.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand, loop_matrix
from kinematics.linalg.gauss_newton import Iterate, LevenbergMarquardt, gauss_newton
from kinematics.linalg.ties import first_largest
from kinematics.linalg.vectors import distinct_vectors, project_out
from kinematics.mobility.first_order import (
    closure_equations,
    first_order,
    first_order_mobility_of,
)
from kinematics.model.arrays import Chain
from kinematics.model.chain import move_chain
from kinematics.tolerances import (
    LOOP_RANK_RELATIVE,
    NEAR_SINGULAR_CONVERGED,
    NEAR_SINGULAR_RESIDUAL,
    NEAR_SINGULAR_STEP,
    SAME_POSE_RELATIVE,
    SERIES_RESIDUAL,
)

__all__ = ["MAX_ORDER", "LocalMobility", "analyse_local_mobility"]

Array = NDArray[np.float64]

# Radii of the sphere about the pose (radians, characteristic lengths). They shrink until two
# of them give the same branches.
SPHERE_RADII = (0.06, 0.02, 0.006)
# Highest order at which loops are tested.
MAX_ORDER = 8
# Most starts of the search for branches.
MAX_STARTS = 240
# Most starts times the square of the number of joints, with which the cost of a start grows.
MAX_WORK = 400_000
# Seed of the directions in which the search starts.
SEED = 4


class LocalMobility(NamedTuple):
    """Degrees of freedom of a linkage near a pose; n joints.

    Attributes:
        freedom: degrees of freedom at first order.
        mobility: most degrees of freedom of a branch that leaves the pose, 0 without one.
        order: at which the loops stop closing if no branch leaves the pose, otherwise 0.
        branches: closed poses near the pose (branches, n), one on each branch; of a branch
            of several degrees of freedom any one. A single one is the only branch to follow.
    """

    freedom: int
    mobility: int
    order: int
    branches: Array


def analyse_local_mobility(
    chain: Chain, tolerance: float = LOOP_RANK_RELATIVE
) -> LocalMobility:
    """Find the branches of motion through the reference pose of a chain with closed loops.

    Args:
        chain: joints that one another's motion depends on; spatial, nothing chosen as
            independent.
        tolerance: relative size of singular values of the loop matrix that count as zero.
    """
    N, _ = first_order(loop_matrix(chain), tolerance)
    freedom = N.shape[1]
    empty = np.empty((0, len(N)))
    if freedom == 0:
        return LocalMobility(0, 0, 1, empty)
    if freedom == 1:
        order = _order_of_single_freedom(chain, N)
        if (
            order
            or _closest_pose(chain, N, SPHERE_RADII[0], N[:, 0])[1] > NEAR_SINGULAR_RESIDUAL
        ):
            return LocalMobility(1, 0, order or MAX_ORDER, empty)
        return LocalMobility(1, 1, 0, SPHERE_RADII[0] * N.T)
    seen = None
    for distance in SPHERE_RADII:
        mobility, branches = _find_branches(chain, N, distance)
        if seen == (mobility, len(branches)):
            break
        seen = mobility, len(branches)
    if mobility == 0:
        return LocalMobility(freedom, 0, _estimate_order(chain, N), empty)
    return LocalMobility(freedom, mobility, 0, branches)


def _order_of_single_freedom(chain: Chain, N: Array) -> int:
    """Find the order at which a single freedom stops closing the loops; 0 if none is found."""
    joint = first_largest(np.abs(N[:, 0]))
    moved = move_chain(chain, np.array([joint]), np.eye(1))
    series = expand(moved, np.ones((1, 1)), MAX_ORDER - 1)
    sizes = np.abs(series.C[0]).max(axis=(1, 2))
    for order, residual in enumerate(series.residual):
        if residual > SERIES_RESIDUAL * max(1.0, sizes[order], sizes[0] ** (order + 1)):
            return order + 1
    return 0


def _start_directions(N: Array) -> Iterator[Array]:
    """Yield directions in the freedoms of a pose, evenly in two of them, at random in more."""
    rng = np.random.default_rng(SEED)
    freedom = N.shape[1]
    if freedom == 2:
        for angle in np.linspace(0.0, 2 * np.pi, 32, endpoint=False) + 0.05:
            yield N @ [np.cos(angle), np.sin(angle)]
        return
    for _ in range(min(48 * (freedom - 1), MAX_STARTS, MAX_WORK // len(N) ** 2)):
        v = N @ rng.standard_normal(freedom)
        yield v / np.linalg.norm(v)


def _closest_pose(
    chain: Chain, N: Array, distance: float, start: Array, fixed: Array | None = None
) -> tuple[Array, float]:
    """Find the pose at a distance from the reference pose whose loops are least open.

    At a distance ε, the part of the residual that joint rates can close is of the size ε, and
    the rest of ε²: each is scaled by its own.

    Args:
        chain: the linkage as arrays.
        N: orthonormal freedoms (n, f).
        distance: length of the part in N of the joint positions.
        start: direction from which to start (n,).
        fixed: directions (n, d) in which the start is kept, instead of the length alone.

    Returns:
        Joint positions, and the residual of the loops there.
    """
    U = np.linalg.svd(loop_matrix(chain))[0][:, : len(N) - N.shape[1]]
    W = np.eye(len(U)) / distance**2 + (U @ U.T) * (1.0 / distance - 1.0 / distance**2)

    closure = closure_equations(chain)

    def residual(x: Array) -> tuple[Array, Array]:
        b, A = closure(distance * x)
        if fixed is None:
            u = N.T @ x
            more, row = (u @ u - 1.0)[None], 2.0 * (N @ u)[None]
        else:
            more, row = fixed.T @ (x - start), fixed.T
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


def _find_branches(chain: Chain, N: Array, distance: float) -> tuple[int, Array]:
    """Find the mobility of the branches at a distance, and a closed pose on each."""
    points: list[Array] = []
    for start in _start_directions(N):
        q, residual = _closest_pose(chain, N, distance, start)
        if residual <= NEAR_SINGULAR_RESIDUAL and np.abs(q).max() <= 10 * distance:
            points.append(q)
    if not points:
        return 0, np.empty((0, len(N)))
    sizes = [first_order_mobility_of(chain, q) for q in points]
    mobility = max(sizes)
    if mobility == 1:
        return 1, _one_pose_per_branch(
            _select_distinct([*points, *_opposite_poses(chain, N, distance, points)], distance)
        )
    flat = _tangent_space(np.array(points) @ N / distance, mobility)
    if (
        min(sizes) == mobility
        and flat is not None
        and _is_one_sheet(chain, N, distance, N @ flat)
    ):
        return mobility, np.array(points[:1])
    return mobility, _most_different_pair(np.array(points), N)


def _opposite_poses(
    chain: Chain, N: Array, distance: float, points: list[Array]
) -> Iterator[Array]:
    """Yield closed poses in the senses opposite to those found."""
    for q in _select_distinct(points, distance):
        other, residual = _closest_pose(chain, N, distance, -q / distance)
        if residual <= NEAR_SINGULAR_RESIDUAL:
            yield other


def _select_distinct(points: list[Array], distance: float) -> list[Array]:
    """Select poses that differ from one another."""
    first = distinct_vectors(
        points, lambda some, q: np.abs(some - q).max(axis=1) <= SAME_POSE_RELATIVE * distance
    )
    return [points[k] for k in first]


def _one_pose_per_branch(points: list[Array]) -> Array:
    """Select one pose on each branch: a branch leaves in two senses, mostly opposite ones."""
    left, kept = list(points), []
    while left:
        q = left.pop(0)
        kept.append(q)
        if left:
            cosines = [q @ p / np.linalg.norm(q) / np.linalg.norm(p) for p in left]
            left.pop(int(np.argmin(cosines)))
    return np.array(kept)


def _tangent_space(directions: Array, dimension: int) -> Array | None:
    """Find the subspace (f, dimension) that unit directions (count, f) fill, or None."""
    _, values, Vt = np.linalg.svd(directions / np.sqrt(len(directions)))
    values = np.concatenate([values, np.zeros(len(Vt))])
    if values[dimension - 1] < 0.1 or values[dimension] > 0.1 * values[dimension - 1]:
        return None
    return Vt[:dimension].T


def _is_one_sheet(chain: Chain, N: Array, distance: float, T: Array) -> bool:
    """Return whether the closed poses are one smooth sheet over tangent directions T (n, d)."""
    rng = np.random.default_rng(SEED)
    for _ in range(2 * T.shape[1] + 2):
        t = T @ rng.standard_normal(T.shape[1])
        t /= np.linalg.norm(t)
        found = []
        for _ in range(4):
            aside = N @ rng.standard_normal(N.shape[1])
            start = t + 0.3 * project_out(aside, T)
            q, residual = _closest_pose(chain, N, distance, start, T)
            if residual <= NEAR_SINGULAR_RESIDUAL:
                found.append(q)
        if len(_select_distinct(found, distance)) != 1:
            return False
    return True


def _most_different_pair(points: Array, N: Array) -> Array:
    """Select two poses in directions as different as possible."""
    directions = points @ N
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    far = int(np.argmin(np.abs(directions @ directions[0])))
    return points[[0, far]]


def _estimate_order(chain: Chain, N: Array) -> int:
    """Estimate the order at which no direction closes the loops, from the least residuals.

    The residual at the distance ε is ``c ε^k``: k follows from two distances.
    """
    least = []
    for distance in (0.1, 0.05):
        residuals = [
            _closest_pose(chain, N, distance, start)[1] for start in _start_directions(N)
        ]
        least.append(min(residuals))
    return int(np.clip(np.rint(np.log2(least[0] / least[1])), 2, MAX_ORDER))
