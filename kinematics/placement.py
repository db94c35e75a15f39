"""Finite poses, whose loops are closed by Newton's method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.closure import Series, expand_from
from kinematics.displacement import invert, multiply, place
from kinematics.kernels import kernel
from kinematics.linkage import Chain
from kinematics.profile import JOINT, ROW, factor, fill, profile, solve

__all__ = [
    "Pose",
    "expand_at",
    "follow",
    "follow_series",
    "forward",
    "mismatch",
    "newton",
    "radius",
    "rates_along",
    "series_radius",
]

Array = NDArray[np.float64]

# Steps of Newton's method at most.
STEPS = 30
# Loops that are open by less are closed.
ROUNDED = 1e-15


@kernel(borrows=True)
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


@kernel(borrows=True)
def _close(parent, screws, ends, mimics, q, H, s, steps, lines, F, work, spare):
    """Newton's method on the dependent joints of q, in place; returns the last mismatch."""
    dim, loops, nd = screws.shape[1], ends.shape[0], F.shape[0]
    rows = loops * dim + mimics.shape[0]
    diagonal, b, sorted_b = work[:nd], work[nd : nd + rows], work[nd + rows :]
    row, joints = lines[ROW], lines[JOINT]
    best = error = np.inf
    for _ in range(steps):
        place(parent, screws, q, H, s, spare[0])
        _mismatch(H, ends, H[:0], b, dim, spare)
        for relation in range(mimics.shape[0]):
            b[loops * dim + relation] = 0.0
            for j in range(q.size):
                b[loops * dim + relation] += mimics[relation, j] * q[j]
        error = _size(b)
        stalled = error < 1e-12 and error >= 0.5 * best
        if not error < 1e6 or stalled or error < ROUNDED:
            return error
        best = min(best, error)
        fill(parent, s, ends, mimics, lines, F)
        factor(F, lines, diagonal)
        for block in range(loops + mimics.shape[0]):
            at = block * dim if block < loops else loops * (dim - 1) + block
            for i in range(dim if block < loops else 1):
                sorted_b[row[block] + i] = -b[at + i]
        solve(F, lines, diagonal, sorted_b)
        for d in range(nd):
            q[joints[d]] += sorted_b[d]
    return error


@kernel
def close(parent, screws, ends, mimics, dependent, q, H, s, steps):
    """Newton's method on the dependent joints of q, in place.

    Puts displacements of the links and screws at the last pose looked at into H and s.

    Returns:
        The mismatch there; unless the steps were used up, that pose is q.
    """
    m = H.shape[1]
    lines, F, rows = profile(parent, ends, mimics, dependent, screws.shape[1])
    work, spare = np.empty(dependent.size + 2 * rows), np.empty((4, m, m))
    return _close(parent, screws, ends, mimics, q, H, s, steps, lines, F, work, spare)


@kernel(borrows=True)
def _size(x):
    """Euclidean norm."""
    total = 0.0
    for i in range(x.size):
        total += x[i] * x[i]
    return np.sqrt(total)


@kernel(borrows=True)
def rates_along(C, ray, rates):
    """Joint rates along a ray (order + 1, n), from those for unit rates C (…, …, width)."""
    for k in range(C.shape[0]):
        for j in range(C.shape[1]):
            rates[k, j] = 0.0
            for w in range(ray.size):
                rates[k, j] += C[k, j, w] * ray[w]


@kernel(borrows=True)
def series_radius(rates):
    """Radius of convergence of the joint rates (order + 1, n); see `radius`."""
    limit = 1.0
    first = _size(rates[0])
    for k in range(rates.shape[0]):
        size = _size(rates[k])
        limit = max(limit, size if k == 0 else (size / first) ** (1.0 / k))
    return 1.0 / limit


@kernel(borrows=True)
def _follow(
    parent, screws, ends, mimics, start, C, ray, reach, q, H, s, way, lines, F, work, spare
):
    """A closed pose along the ray; see `follow_series`."""
    orders, n = C.shape[:2]
    rates, guess = way, way[orders]
    rates_along(C, ray, rates)
    step = min(reach, 0.4 * series_radius(rates[:orders]))
    for _ in range(7):
        for j in range(n):
            moved = 0.0
            for k in range(orders - 1, -1, -1):
                moved = (moved + rates[k, j] / (k + 1)) * step
            guess[j] = moved
            q[j] = start[j] + moved
        error = _close(parent, screws, ends, mimics, q, H, s, STEPS, lines, F, work, spare)
        off = size = 0.0
        for j in range(n):
            off += (q[j] - start[j] - guess[j]) ** 2
            size += guess[j] * guess[j]
        if error < 1e-10 and off <= 0.01 * size:
            return step
        step *= 0.5
    return 0.0


@kernel
def follow_series(parent, screws, ends, mimics, dependent, start, C, ray, reach, H, s):
    """A closed pose along the ray, and the length of the step, 0 if none; see `follow`."""
    m = H.shape[1]
    lines, F, rows = profile(parent, ends, mimics, dependent, screws.shape[1])
    work, spare = np.empty(dependent.size + 2 * rows), np.empty((4, m, m))
    q, way = np.empty(start.size), np.empty((C.shape[0] + 1, start.size))
    step = _follow(
        parent, screws, ends, mimics, start, C, ray, reach, q, H, s, way, lines, F, work, spare
    )
    return q, step


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
    return float(series_radius(rates))


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
    q, step = follow_series(
        chain.parent, chain.screws, chain.ends, chain.mimics, chain.dependent,
        start, series.C[-1], ray, reach, H, screws,
    )  # fmt: skip
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
    error = close(
        chain.parent, chain.screws, chain.ends, chain.mimics, chain.dependent,
        q, *_room(chain), steps,
    )  # fmt: skip
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
