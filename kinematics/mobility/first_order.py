"""First-order freedoms of a pose, and poses further along them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.newton import forward, mismatch
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain

__all__ = [
    "DEPENDENT",
    "away",
    "conditioning",
    "first_order",
    "independent",
    "nullity",
    "onward",
    "spectrum",
]

Array = NDArray[np.float64]

# Singular values of a loop matrix below this part of the largest are zero: geometry in files
# is given to about 1e-12.
DEPENDENT = 1e-8
# At poses that were solved for.
SOLVED = 1e-7
# Opening of loops that were closed to round-off.
CLOSED = 1e-13


def spectrum(A: Array) -> tuple[Array, Array]:
    """Singular values of a loop matrix (rows, n), padded to n, and its right vectors."""
    if not len(A):
        return np.zeros(A.shape[1]), np.eye(A.shape[1])
    _, values, Vt = np.linalg.svd(A)
    return np.concatenate([values, np.zeros(A.shape[1])])[: A.shape[1]], Vt


def first_order(A: Array, tolerance: float = DEPENDENT) -> tuple[Array, Array]:
    """Joint rates that a loop matrix (rows, n) leaves free, and its singular values.

    Returns:
        Orthonormal rates (n, freedom), and the values, descending, padded to n.
    """
    values, Vt = spectrum(A)
    return Vt[int(np.sum(values > tolerance * values.max(initial=0.0))) :].T, values


def nullity(chain: Chain, q: Array) -> int:
    """First-order degrees of freedom at a closed pose."""
    return first_order(loop_matrix(chain, forward(chain, q).screws), SOLVED)[0].shape[1]


def independent(free: Array) -> NDArray[np.int64]:
    """Joints whose rates determine the others', well conditioned; ``free`` is (n, f)."""
    rest, chosen = free.copy(), []
    for _ in range(free.shape[1]):
        sizes = np.linalg.norm(rest, axis=1)
        chosen.append(int(np.argmax(sizes)))
        along = rest[chosen[-1]] / sizes[chosen[-1]]
        rest = rest - np.outer(rest @ along, along)
    return np.sort(np.array(chosen))


def conditioning(chain: Chain, q: Array, freedom: int) -> float:
    """Smallest singular value of the loop matrix that counts, relative to the largest."""
    values, _ = spectrum(loop_matrix(chain, forward(chain, q).screws))
    return float(values[values.size - freedom - 1] / values[0])


def away(chain: Chain, free: Array) -> Array:
    """A better conditioned pose on the branch of the reference pose, which is regular.

    Args:
        chain: the linkage as arrays.
        free: orthonormal joint rates that close its loops (n, f).
    """
    v = free @ np.ones(free.shape[1]) / np.sqrt(free.shape[1])
    freedom, step = free.shape[1], 0.1 * conditioning(chain, np.zeros(len(v)), free.shape[1])
    starts = [q for sign in (1.0, -1.0) if (q := _polished(chain, sign * step * v)) is not None]
    starts.sort(key=lambda q: conditioning(chain, q, freedom))
    return onward(chain, starts[-1]) if starts else np.zeros(len(v))


def onward(chain: Chain, start: Array, goal: float = 0.5) -> Array:
    """The best conditioned pose along the branch on which a pose near the reference pose is.

    Args:
        chain: the linkage as arrays.
        start: a closed pose (n,), away from the singular one.
        goal: how far to look (radians, characteristic lengths).
    """
    q, tangent, step = start, start, 0.5 * float(np.abs(start).max())
    least = 0.01 * step
    best, freedom = (0.0, start), nullity(chain, start)
    for _ in range(80):
        values, Vt = spectrum(loop_matrix(chain, forward(chain, q).screws))
        rank = values.size - freedom
        if values[rank - 1] > best[0]:
            best = float(values[rank - 1]), q
        along = Vt[rank:].T @ (Vt[rank:] @ tangent)
        size = float(np.linalg.norm(along))
        if np.abs(q).max() >= goal or step < least or size == 0.0:
            break
        along /= size
        ahead = _polished(chain, q + step * along)
        if ahead is None or np.linalg.norm(ahead - q - step * along) > 0.2 * step:
            step *= 0.5
            continue
        q, tangent, step = ahead, ahead - q, min(1.3 * step, 0.1)
    return best[1]


def _polished(chain: Chain, q: Array) -> Array | None:
    """The closed pose next to joint positions, to the last digit; None if there is none.

    Newton's method with steps of least norm.
    """
    last, best = 0.5, np.inf
    for _ in range(15):
        pose = forward(chain, q)
        b = mismatch(chain, pose.H, q)
        error = float(np.abs(b).max(initial=0.0))
        if error <= CLOSED and error >= 0.5 * best:
            return q
        best = min(best, error)
        step = np.linalg.lstsq(loop_matrix(chain, pose.screws), b, rcond=SOLVED)[0]
        size = float(np.abs(step).max())
        if size > last:
            return q if error <= CLOSED else None
        q, last = q - step, max(size, CLOSED)
    return None
