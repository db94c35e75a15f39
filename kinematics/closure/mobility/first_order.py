"""First-order mobility of a pose, and poses further along its freedoms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinematics.closure.newton import closure_residual, forward_kinematics
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.gauss_newton import (
    Equations,
    Iterate,
    LeastNorm,
    gauss_newton,
    step_grows,
)
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.linalg.vectors import project_out
from kinematics.numerics.tolerances import (
    CLOSED_TO_ROUND_OFF,
    LOOP_RANK_RELATIVE,
    LOOP_RANK_RELATIVE_SOLVED,
)

# How far to look for a well conditioned pose, in radians and characteristic lengths.
FARTHEST = 0.5


def closure_equations(chain: Chain, gaps: Array | None = None) -> Equations:
    """Make the closure equations of the loops in all joint positions q (n,).

    Args:
        chain: the linkage as arrays.
        gaps: displacements of the welds at the reference pose, if they are not closed.

    Returns:
        The function from q to the closure residual of loops and mimic joints (rows,), in
        radians and units of the chain, and the loop matrix there (rows, n): its derivative
        where the loops are closed.
    """

    def equations(q: Array) -> tuple[Array, Array]:
        pose = forward_kinematics(chain, q)
        return closure_residual(chain, pose.H, q, gaps), loop_matrix(chain, pose.screws)

    return equations


def loop_singular_values(A: Array) -> tuple[Array, Array]:
    """Compute singular values of a loop matrix (rows, n), padded to n, and right vectors."""
    if not len(A):
        return np.zeros(A.shape[1]), np.eye(A.shape[1])
    _, values, Vt = np.linalg.svd(A)
    return np.concatenate([values, np.zeros(A.shape[1])])[: A.shape[1]], Vt


def first_order(
    A: Array, tolerance: float = LOOP_RANK_RELATIVE, rank: int | None = None
) -> tuple[Array, Array]:
    """Compute the joint rates that a loop matrix leaves free, and its singular values.

    Args:
        A: loop matrix (rows, n).
        tolerance: singular values below this part of the largest count as zero.
        rank: the rank, if it is known.

    Returns:
        Orthonormal rates (n, freedom), and the values, descending, padded to n.
    """
    values, Vt = loop_singular_values(A)
    if rank is None:
        rank = int(np.sum(values > tolerance * values.max(initial=0.0)))
    return Vt[rank:].T, values


def first_order_mobility_of(chain: Chain, q: Array) -> int:
    """Compute the first-order degrees of freedom at a closed pose.

    Args:
        chain: the linkage as arrays.
        q: joint positions that close the loops (n,), chain units.
    """
    return first_order(
        loop_matrix(chain, forward_kinematics(chain, q).screws), LOOP_RANK_RELATIVE_SOLVED
    )[0].shape[1]


def independent_rows(free: Array) -> IntArray:
    """Choose joints whose rates determine the others', well conditioned; ``free`` is (n, f)."""
    projected, chosen = free.copy(), []
    for _ in range(free.shape[1]):
        sizes = np.linalg.norm(projected, axis=1)
        chosen.append(first_largest(sizes))
        projected = project_out(projected.T, projected[chosen[-1]] / sizes[chosen[-1]]).T
    return np.sort(np.array(chosen))


def conditioning(chain: Chain, q: Array, freedom: int) -> float:
    """Compute the smallest nonzero singular value of the loop matrix over the largest.

    Args:
        chain: the linkage as arrays.
        q: joint positions that close the loops (n,), chain units.
        freedom: number of singular values that count as zero.
    """
    values, _ = loop_singular_values(loop_matrix(chain, forward_kinematics(chain, q).screws))
    return float(values[values.size - freedom - 1] / values[0])


def conditioning_beyond(chain: Chain, free: Array, distance: float) -> float:
    """Compute the `conditioning` at a closed pose at a distance; infinite if there is none.

    Args:
        chain: the linkage as arrays.
        free: orthonormal joint rates that close its loops (n, f).
        distance: of the pose from the reference pose, chain units.
    """
    v = free @ np.ones(free.shape[1]) / np.sqrt(free.shape[1])
    q = _close_to_round_off(chain, distance * v)
    return np.inf if q is None else conditioning(chain, q, free.shape[1])


def step_from_singular(chain: Chain, free: Array) -> Array:
    """Find a better conditioned pose on the branch of the reference pose, which is regular.

    Args:
        chain: the linkage as arrays.
        free: orthonormal joint rates that close its loops (n, f).

    Returns:
        Joint positions (n,), chain units; 0 if none was found.
    """
    v = free @ np.ones(free.shape[1]) / np.sqrt(free.shape[1])
    freedom, step = free.shape[1], 0.1 * conditioning(chain, np.zeros(len(v)), free.shape[1])
    starts = [
        q
        for sign in (1.0, -1.0)
        if (q := _close_to_round_off(chain, sign * step * v)) is not None
    ]
    starts.sort(key=lambda q: conditioning(chain, q, freedom))
    return step_along(chain, starts[-1]) if starts else np.zeros(len(v))


def step_along(chain: Chain, start: Array) -> Array:
    """Find the best conditioned pose along the branch of a pose near the reference pose.

    Args:
        chain: the linkage as arrays.
        start: a closed pose (n,), away from the singular one.

    Returns:
        Joint positions (n,), chain units.
    """
    q, tangent, step = start, start, 0.5 * float(np.abs(start).max())
    least = 0.01 * step
    best, freedom = (0.0, start), first_order_mobility_of(chain, start)
    for _ in range(80):
        values, Vt = loop_singular_values(
            loop_matrix(chain, forward_kinematics(chain, q).screws)
        )
        rank = values.size - freedom
        if values[rank - 1] > best[0]:
            best = float(values[rank - 1]), q
        along = Vt[rank:].T @ (Vt[rank:] @ tangent)
        size = float(np.linalg.norm(along))
        if np.abs(q).max() >= FARTHEST or step < least or size == 0.0:
            break
        along /= size
        ahead = _close_to_round_off(chain, q + step * along)
        if ahead is None or np.linalg.norm(ahead - q - step * along) > 0.2 * step:
            step *= 0.5
            continue
        q, tangent, step = ahead, ahead - q, min(1.3 * step, 0.1)
    return best[1]


def _close_to_round_off(chain: Chain, q: Array) -> Array | None:
    """Find the closed pose next to joint positions, to the last digit; None if there is none.

    Newton's method with steps of least norm.
    """
    grows = step_grows(0.5, CLOSED_TO_ROUND_OFF)

    def closed(path: Sequence[Iterate]) -> bool:
        best = min((x.error for x in path[:-1]), default=np.inf)
        error = path[-1].error
        return error <= CLOSED_TO_ROUND_OFF and (error >= 0.5 * best or grows(path))

    equations, rule = closure_equations(chain), LeastNorm(LOOP_RANK_RELATIVE_SOLVED)
    last, solved = gauss_newton(equations, q, rule, closed, grows, 15)
    return last.x if solved else None
