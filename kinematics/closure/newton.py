"""Finite poses, whose loops are closed by Newton's method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.series import Series, expand_from
from kinematics.compiled.jit import kernel
from kinematics.linalg.skyline_qr import COUNT, HEIGHT, JOINT, ROW, ROWS, factor, fill, solve
from kinematics.model.arrays import Chain, read_only
from kinematics.spatial.displacements import invert, multiply, place

__all__ = [
    "Pose",
    "expand_at",
    "follow",
    "follow_series",
    "forward",
    "mismatch",
    "newton",
    "radius",
    "radius_along",
    "step_room",
]

Array = NDArray[np.float64]

# Steps of Newton's method at most.
STEPS = 30
# Loops that are open by less are closed.
ROUNDED = 1e-15


@kernel(reference_counting=False)
def _mismatch(H, ends, gaps, b, dim, spare):
    """Twists (small) from each loop's successor to its end; zero if the loop is closed.

    Without ``gaps``, the loops are closed at the reference pose. There is room for four
    displacements in ``spare``.
    """
    m = H.shape[1]
    identity, inverse, product, D = spare[0], spare[1], spare[2], spare[3]
    for i in range(m):
        for j in range(m):
            identity[i, j] = 1.0 if i == j else 0.0
    for loop in range(ends.shape[0]):
        e, f = ends[loop, 0], ends[loop, 1]
        invert(H[f] if f >= 0 else identity, inverse)
        multiply(H[e] if e >= 0 else identity, inverse, D)
        if gaps.shape[0] > 0:
            invert(gaps[loop], D)
            multiply(H[e] if e >= 0 else identity, D, product)
            multiply(product, inverse, D)
        r = loop * dim
        if dim == 3:
            b[r] = 0.5 * (D[1, 0] - D[0, 1])
        else:
            b[r] = 0.5 * (D[2, 1] - D[1, 2])
            b[r + 1] = 0.5 * (D[0, 2] - D[2, 0])
            b[r + 2] = 0.5 * (D[1, 0] - D[0, 1])
        for i in range(m - 1):
            b[r + dim - m + 1 + i] = D[i, m - 1]


@kernel(reference_counting=False)
def close(chain, q, H, s, steps, room):
    """Newton's method on the dependent joints of q, in place.

    Puts displacements of the links and screws at the last pose looked at into H and s.

    Args:
        chain: arrays of the chain, as `Chain.walked`.
        q: joint positions.
        H: takes the displacements.
        s: takes the screws.
        steps: how many at most.
        room: as from `step_room`.

    Returns:
        The mismatch there; unless the steps were used up, that pose is q.
    """
    parent, screws, ends, mimics, _, _, lines = chain
    F, work, _, spare = room
    dim, loops, nd = screws.shape[1], ends.shape[0], F.shape[0]
    rows = lines[COUNT, ROWS]
    diagonal, b, sorted_b = work[:nd], work[nd : nd + rows], work[nd + rows :]
    best = error = np.inf
    for _ in range(steps):
        place(parent, screws, q, H, s, spare[0])
        _mismatch(H, ends, H[:0], b, dim, spare)
        for relation in range(mimics.shape[0]):
            total = 0.0
            for j in range(q.size):
                total += mimics[relation, j] * q[j]
            b[loops * dim + relation] = total
        square = 0.0
        for i in range(rows):
            square += b[i] * b[i]
        error = np.sqrt(square)
        stalled = error < 1e-12 and error >= 0.5 * best
        if not error < 1e6 or stalled or error < ROUNDED:
            return error
        best = min(best, error)
        fill(s, mimics, lines, F)
        factor(F, lines, diagonal)
        for i in range(rows):
            block = i // dim if i < loops * dim else i - loops * (dim - 1)
            first = block * dim if block < loops else i
            sorted_b[lines[ROW, block] + i - first] = -b[i]
        solve(F, lines, diagonal, sorted_b)
        for d in range(nd):
            q[lines[JOINT, d]] += sorted_b[d]
    return error


@kernel(reference_counting=False)
def radius_along(C, ray, rates):
    """Joint rates along a ray (order + 1, n) from C (…, …, width); their `radius`."""
    limit, first = 1.0, 0.0
    for k in range(C.shape[0]):
        square = 0.0
        for j in range(C.shape[1]):
            rate = 0.0
            for w in range(ray.size):
                rate += C[k, j, w] * ray[w]
            rates[k, j] = rate
            square += rate * rate
        size = np.sqrt(square)
        first = size if k == 0 else first
        limit = max(limit, size if k == 0 else (size / first) ** (1.0 / k))
    return 1.0 / limit


@kernel(reference_counting=False)
def follow_series(chain, start, C, ray, reach, q, H, s, room):
    """A closed pose along the ray; see `follow`.

    Args:
        chain: arrays of the chain, as `Chain.walked`.
        start: joint positions from which to start.
        C: the series there, of one ray (orders, n, width).
        ray: its direction.
        reach: longest step.
        q: takes the joint positions.
        H: takes the displacements.
        s: takes the screws.
        room: as from `step_room`.

    Returns:
        The length of the step, 0 if there is none.
    """
    orders, n = C.shape[:2]
    way = room[2]
    guess = way[orders]
    step = min(reach, 0.4 * radius_along(C, ray, way))
    for _ in range(7):
        for j in range(n):
            moved = 0.0
            for k in range(orders - 1, -1, -1):
                moved = (moved + way[k, j] / (k + 1)) * step
            guess[j] = moved
            q[j] = start[j] + moved
        error = close(chain, q, H, s, STEPS, room)
        off = size = 0.0
        for j in range(n):
            off += (q[j] - start[j] - guess[j]) ** 2
            size += guess[j] * guess[j]
        if error < 1e-10 and off <= 0.01 * size:
            return step
        step *= 0.5
    return 0.0


def step_room(chain: Chain, orders: int = 0) -> tuple[Array, ...]:
    """Room for Newton's method, and for a guess from the series of so many orders."""
    height, rows = chain.lines[COUNT, HEIGHT : ROWS + 1].tolist()
    nd, n = chain.dependent.size, chain.parent.size
    m = 3 if chain.planar else 4
    work = np.empty(nd + 2 * rows)
    return np.empty((nd, height)), work, np.empty((orders + 1, n)), np.empty((4, m, m))


class Pose(NamedTuple):
    """A finite pose, in the frame and units of the chain.

    Attributes:
        q: joint positions (n,).
        H: displacements of the links (n, 4, 4), or (n, 3, 3) if planar.
        screws: joint screws at this pose (n, 6 or 3).
        error: mismatch of the loops, in radians and units of the chain.
    """

    q: Array
    H: Array
    screws: Array
    error: float


def expand_at(chain: Chain, pose: Pose) -> Series:
    """The series of order 0 at a finite pose: rates and link twists there."""
    return expand_from(chain, pose.screws, np.zeros((1, chain.width)), 0)


def radius(rates: Array) -> float:
    """Radius of convergence estimated from the growth of joint rates (order + 1, n).

    At most 1, and such that no joint moves by more than 1 to first order.
    """
    sizes = np.sqrt(np.einsum("kj,kj->k", rates, rates))
    growth = (sizes[1:] / sizes[0]) ** (1.0 / np.arange(1, sizes.size))
    return float(1.0 / max(1.0, sizes[0], *growth))


def follow(
    chain: Chain, start: Array, series: Series, ray: Array, reach: float = np.inf
) -> tuple[Pose, float]:
    """A closed pose further along a ray, on the same branch.

    The step is the smaller of ``reach`` and 0.4 of the radius of convergence estimated
    from the series, whose sum is the first guess of Newton's method; it is halved until
    the method stays within a tenth of that guess.

    Args:
        chain: the linkage at its reference pose.
        start: joint positions from which to start (n,).
        series: the series there; its last ray is used.
        ray: the direction of that ray (w,).
        reach: longest step.

    Returns:
        The pose and the length of the step, 0 if none was found.
    """
    H, screws = _room(chain)
    q, C = np.empty(start.size), series.C[-1]
    step = follow_series(
        chain.walked, start, C, read_only(ray), reach, q, H, screws, step_room(chain, len(C))
    )
    screws.flags.writeable = False
    return Pose(q, H, screws, 0.0), step


def newton(chain: Chain, start: Array, steps: int = STEPS) -> tuple[Array, float]:
    """Joint positions that close the loops, by Newton's method on the dependent joints.

    Args:
        chain: the linkage at its reference pose.
        start: joint positions from which to start (n,).
        steps: how many to take at most.

    Returns:
        Joint positions (n,), and how far the loops were open when last looked at.
    """
    q = np.array(start, dtype=np.float64)
    error = close(chain.walked, q, *_room(chain), steps, step_room(chain))
    return q, float(error)


def _room(chain: Chain) -> tuple[Array, Array]:
    """Room for the displacements and the screws of a pose."""
    m = 3 if chain.planar else 4
    return np.empty((chain.parent.size, m, m)), np.empty(chain.screws.shape)


def forward(chain: Chain, q: Array) -> Pose:
    """The pose at given joint positions (n,), whether or not it closes the loops."""
    H, screws = _room(chain)
    place(chain.parent, chain.screws, q, H, screws, np.empty(H.shape[1:]))
    screws.flags.writeable = False
    error = mismatch(chain, H, q)
    return Pose(q, H, screws, float(np.sqrt(error @ error)))


def mismatch(chain: Chain, H: Array, q: Array, gaps: Array | None = None) -> Array:
    """Twists by which the loops are open at a pose, then errors of mimic joints; (rows,).

    Args:
        chain: the linkage as arrays.
        H: displacements of the links.
        q: joint positions.
        gaps: displacements of the welds at the reference pose, if they are not closed.
    """
    dim = chain.screws.shape[1]
    b = np.empty(len(chain.ends) * dim + len(chain.mimics))
    spare = np.empty((4, *H.shape[1:]))
    _mismatch(H, chain.ends, H[:0] if gaps is None else gaps, b, dim, spare)
    b[len(chain.ends) * dim :] = chain.mimics @ q
    return b
