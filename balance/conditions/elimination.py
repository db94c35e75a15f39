"""Elimination with pivots: the compiled kernels behind every rank.

Householder reflections, largest column first, cut off where what remains is round-off (in
the spirit of T. F. Chan, 1987). What counts as round-off is for the caller to say.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from kinematics.kernels import kernel
from kinematics.lanes import LANES, load, spread, store

__all__ = [
    "FLOOR", "MARGIN", "absorb", "absorbed", "anew", "follows", "gather", "implied",
    "put_factor", "room_for", "round_off", "smallest_pivot", "take", "take_factor",
]  # fmt: skip

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Round-off of a regressor, relative to its largest singular value: measured values lie
# below 1e-14 for well-conditioned loops; the floor leaves two decades to those that are not.
FLOOR = 2.0**-40
# What is kept within this factor of round-off is uncertain.
MARGIN = 1e3
# Round-off of a factor's rows, which their multipliers amplify when others are eliminated.
ROUNDING = 2.0**-46


def round_off(origin: Array, length: float) -> float:
    """Relative size of what counts as round-off in a frame with this origin and length.

    Coordinates of a linkage far from the origin of its file are rounded accordingly.
    """
    x, y, z = origin.tolist()
    return max(
        FLOOR, 2.0**-44 * sqrt((x / length) ** 2 + (y / length) ** 2 + (z / length) ** 2)
    )


def room_for(p: int, m: int) -> Array:
    """Room for a factor of p unknowns, m rows to be absorbed, and a row of work."""
    return np.empty((p + m + 1, -(-p // LANES) * LANES))


@kernel(reference_counting=False)
def take_factor(R, permutation, F):
    """Put a factor, with columns in their own order, into the head of F."""
    for i in range(R.shape[0]):
        for j in range(permutation.size):
            F[i, j] = R[i, permutation[j]]
        for j in range(permutation.size, F.shape[1]):
            F[i, j] = 0.0


@kernel(reference_counting=False)
def put_factor(F, permutation, rank, R):
    """Put the factor, with its columns in their own order, into the head of R."""
    for i in range(rank):
        for j in range(permutation.size):
            R[i, permutation[j]] = F[i, j]


@kernel(reference_counting=False)
def take(F, permutation, rank, rows, columns, weight):
    """Put ``weight * rows`` below the factor; of each row, the entries at columns."""
    for i in range(rows.shape[0]):
        for j in range(columns.size):
            F[rank + i, j] = weight * rows[i, columns[permutation[j]]]
        for j in range(columns.size, F.shape[1]):
            F[rank + i, j] = 0.0


@kernel(reference_counting=False)
def absorb(F, permutation, rank, m, floor, scale):
    """Make the m rows below a triangular factor part of it.

    The columns that the factor has eliminated stay its first; the others follow, largest
    remainder first.

    Args:
        F: room as from `room_for`: first the factor, then the new rows; columns in the order
            in which they are eliminated.
        permutation: that order.
        rank: rows of the factor.
        m: rows to absorb.
        floor: relative size of round-off.
        scale: largest pivot so far.

    Returns:
        The rank, the largest pivot, and the norm of what was cut off.
    """
    p, P, end = permutation.size, F.shape[1], rank + m
    f = F.reshape(F.size)
    norms = f[f.size - P :]
    for k in range(rank):
        total = 0.0
        for i in range(rank, end):
            total += F[i, k] * F[i, k]
        if total > 0.0:
            size = np.sqrt(F[k, k] * F[k, k] + total)
            scale = max(scale, size)
            _fold(f, P, k, rank, end, -size if F[k, k] > 0.0 else size)
    for c in range(rank // LANES * LANES, P, LANES):
        squares = spread(0.0)
        for i in range(rank, end):
            x = load(f, i * P + c)
            squares = squares + x * x
        store(norms, c, squares)
    while True:
        remainder = 0.0
        pivot = rank
        for j in range(rank, p):
            remainder += norms[j]
            if norms[j] > norms[pivot]:
                pivot = j
        if rank == min(end, p):
            break
        size = np.sqrt(norms[pivot])
        scale = max(scale, size)
        if size <= floor * scale:
            break
        if pivot != rank:
            permutation[rank], permutation[pivot] = permutation[pivot], permutation[rank]
            for i in range(end):
                F[i, rank], F[i, pivot] = F[i, pivot], F[i, rank]
        _reflect(f, P, rank, end, -size if F[rank, rank] > 0.0 else size, norms)
        rank += 1
    return rank, scale, np.sqrt(remainder)


@kernel(reference_counting=False)
def _fold(f, P, k, begin, end, diagonal):
    """Reflect row k of the factor and rows begin … end, of which many entries are zero."""
    row = k * P
    head = f[row + k] - diagonal
    top, factor = spread(head), spread(1.0 / (diagonal * head))
    # The block with column k comes last: it holds the multipliers.
    for c in range(P - LANES, k // LANES * LANES - 1, -LANES):
        total = top * load(f, row + c)
        for i in range(begin, end):
            x = f[i * P + k]
            if x != 0.0:
                total = total + spread(x) * load(f, i * P + c)
        total = total * factor
        store(f, row + c, load(f, row + c) + top * total)
        for i in range(begin, end):
            x = f[i * P + k]
            if x != 0.0:
                store(f, i * P + c, load(f, i * P + c) + spread(x) * total)
    f[row + k] = diagonal
    for i in range(begin, end):
        f[i * P + k] = 0.0


@kernel(reference_counting=False)
def _reflect(f, P, k, end, diagonal, norms):
    """Reflect rows k … end so that column k ends with its diagonal; norms of what is left."""
    row = k * P
    head = f[row + k] - diagonal
    top, factor = spread(head), spread(1.0 / (diagonal * head))
    for c in range(P - LANES, k // LANES * LANES - 1, -LANES):
        total = top * load(f, row + c)
        for i in range(k + 1, end):
            total = total + spread(f[i * P + k]) * load(f, i * P + c)
        total = total * factor
        store(f, row + c, load(f, row + c) + top * total)
        squares = spread(0.0)
        for i in range(k + 1, end):
            x = load(f, i * P + c) + spread(f[i * P + k]) * total
            store(f, i * P + c, x)
            squares = squares + x * x
        store(norms, c, squares)
    f[row + k] = diagonal
    for i in range(k + 1, end):
        f[i * P + k] = 0.0


@kernel(reference_counting=False)
def implied(F, permutation, rank, rows, columns, weight, floor, scale):
    """Whether ``weight * rows`` follow from the factor.

    One generic combination of the rows is eliminated by the factor: if any of them adds a
    condition, so does almost every combination.
    """
    p, P = permutation.size, F.shape[1]
    f = F.reshape(F.size)
    x = f[f.size - P :]
    for j in range(P):
        x[j] = 0.0
    for i in range(rows.shape[0]):
        c = weight * np.cos((i + 1.0) ** 2)
        for j in range(p):
            x[j] += c * rows[i, columns[permutation[j]]]
    size = 0.0
    for j in range(p):
        size += x[j] * x[j]
    growth = 1.0
    for k in range(rank):
        multiplier = x[k] / F[k, k]
        growth = max(growth, abs(multiplier))
        factor = spread(-multiplier)
        for c in range(k // LANES * LANES, P, LANES):
            store(x, c, load(x, c) + factor * load(f, k * P + c))
    remainder = 0.0
    for j in range(rank, p):
        remainder += x[j] * x[j]
    return np.sqrt(remainder) <= floor * max(scale, np.sqrt(size)) + ROUNDING * growth * scale


@kernel(reference_counting=False)
def gather(
    F, permutation, rank, scale, dropped, rows, count, columns, per_ray, width, first, radius,
    fresh, stop, floor, ranks,
):  # fmt: skip
    """Absorb the rows of consecutive orders, along as many rays as it takes.

    ``C(w + k - 1, k)`` generic rays span all derivatives of order k in w coordinates; fewer
    will do once the rows of one more follow from those gathered. Rows of order k are
    weighted by ``radius**k``. Fresh rows, of a finite pose, decide whether another order is
    needed; without any, only conditions that are complete settle that.

    Args:
        F: factor so far, with room for the rows; see `absorb`.
        permutation: its permutation.
        rank: its rows.
        scale: its largest pivot.
        dropped: the largest remainder that was cut off.
        rows: shape (orders, ≥ rays * per_ray, parameters).
        count: rows of all rays.
        columns: the parameters that the columns of the factor stand for.
        per_ray: rows of each ray.
        width: number of coordinates.
        first: the first of the orders.
        radius: radius of convergence of the series.
        fresh: rows of a finite pose.
        stop: whether to stop at the order that needs no other; without fresh rows, at the
            first one that adds nothing.
        floor: relative size of round-off.
        ranks: takes the rank after each order (orders,).

    Returns:
        The rank, largest pivot and largest remainder; how many orders were gathered; whether
        it is settled that they are all there are, and whether there were enough rays.
    """
    orders, p = rows.shape[0], columns.size
    settled = False
    done = 0
    for k in range(orders):
        weight, every = 1.0, 1
        for i in range(first + k):
            weight *= radius
            every = every * (width + i) // (i + 1)
        used = 0
        before = rank
        while used < every and rank < p:
            wanted = 2 * used if used > 0 else -(-(p - rank) // per_ray)
            wanted = min(every, max(wanted, 1))
            if (wanted if wanted == every else wanted + 1) * per_ray > count:
                return rank, scale, dropped, done, False, False
            new = rows[k, used * per_ray : wanted * per_ray]
            take(F, permutation, rank, new, columns, weight)
            rank, scale, remainder = absorb(F, permutation, rank, new.shape[0], floor, scale)
            dropped = max(dropped, remainder)
            used = wanted
            next_ray = rows[k, used * per_ray : (used + 1) * per_ray]
            if used < every and implied(
                F, permutation, rank, next_ray, columns, weight, floor, scale
            ):
                break
        ranks[k] = rank
        done += 1
        settled = rank == p
        if not settled and fresh.shape[0] > 0:
            settled = implied(F, permutation, rank, fresh, columns, 1.0, floor, scale)
        if stop and (settled or (fresh.shape[0] == 0 and rank == before)):
            break
    return rank, scale, dropped, done, settled, True


@kernel(reference_counting=False)
def anew(R, rows, columns, floor, scale, F, order, out):
    """Factor a factor R and rows, all pivots chosen anew; see `absorbed`.

    Args:
        R: the factor.
        rows: the rows.
        columns: the parameters that the columns of the factor stand for.
        floor: relative size of round-off.
        scale: largest pivot so far.
        F: room as from `room_for`.
        order: takes the order in which columns are eliminated.
        out: takes the factor, with its columns in their own order.

    Returns:
        The rank, the largest pivot, and the norm of what was cut off.
    """
    old, end = R.shape[0], R.shape[0] + rows.shape[0]
    for j in range(order.size):
        order[j] = j
    take_factor(R, order, F)
    take(F, order, old, rows, columns, 1.0)
    rank, scale, remainder = absorb(F, order, 0, end, floor, scale)
    put_factor(F, order, rank, out)
    return rank, scale, remainder


def absorbed(
    R: Array, rows: Array, columns: IntArray, floor: float, scale: float
) -> tuple[Array, IntArray, float, float]:
    """The factor of a factor R and of rows, all pivots chosen anew.

    A factor that is only ever updated reveals the rank less and less well.

    Returns:
        The factor with its columns in their own order, the order in which they were
        eliminated, the largest pivot, and the norm of what was cut off.
    """
    p = columns.size
    F, order, out = room_for(p, len(R) + len(rows)), np.empty(p, np.int64), np.empty((p, p))
    rank, scale, remainder = anew(R, rows, columns, floor, scale, F, order, out)
    return out[:rank], order, scale, remainder


def follows(
    R: Array, permutation: IntArray, rows: Array, columns: IntArray, floor: float, scale: float
) -> bool:
    """Whether rows follow from a factor with its columns in their own order."""
    F = room_for(columns.size, 0)
    take_factor(R, permutation, F)
    found: bool = implied(F, permutation, len(R), rows, columns, 1.0, floor, scale)
    return found


@kernel(reference_counting=False)
def smallest_pivot(R, permutation):
    """Size of the smallest pivot of a triangular factor; infinite without any."""
    size = np.inf
    for i in range(R.shape[0]):
        size = min(size, abs(R[i, permutation[i]]))
    return size
