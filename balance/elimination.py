"""Elimination with pivots: the compiled kernels behind every rank and null space.

Householder reflections, largest column first, cut off where what remains is round-off (in
the spirit of T. F. Chan, 1987). What counts as round-off is for the caller to say.
"""

from __future__ import annotations

import numpy as np

from kinematics.kernels import kernel

__all__ = [
    "FLOOR",
    "MARGIN",
    "absorb",
    "extend",
    "gather",
    "implied",
    "null_space",
    "smallest_pivot",
    "solutions",
]

# Round-off of a regressor, relative to its largest singular value: measured values lie
# below 1e-14 for well-conditioned loops; the floor leaves two decades to those that are not.
FLOOR = 2.0**-40
# What is kept within this factor of round-off is uncertain.
MARGIN = 1e3
# Entries of orthonormal vectors that are smaller are round-off.
NOTHING = 2.0**-48
# Round-off of a factor's rows, which their multipliers amplify when others are eliminated.
ROUNDING = 2.0**-46


@kernel
def absorb(R, rows, columns, begin, end, weight, floor, scale):
    """Pivoted triangular factor of R and ``weight * rows[begin:end]``, and what was cut off.

    Of the rows only the entries at ``columns`` are used.

    Returns:
        The factor (rank, columns) with columns in their own order, the order in which they
        were eliminated, the largest pivot, and the norm of the remainder.
    """
    old, p = R.shape
    m = old + end - begin
    W = np.empty((p, m))
    norms = np.zeros(p)
    permutation = np.arange(p)
    for j in range(p):
        for i in range(old):
            W[j, i] = R[i, j]
        for i in range(end - begin):
            W[j, old + i] = weight * rows[begin + i, columns[j]]
        for i in range(m):
            norms[j] += W[j, i] * W[j, i]
    rank = 0
    remainder = 0.0
    for k in range(min(m, p) + 1):
        remainder = 0.0
        pivot = k
        for j in range(k, p):
            remainder += norms[j]
            if norms[j] > norms[pivot]:
                pivot = j
        if k == min(m, p):
            break
        size = np.sqrt(norms[pivot])
        scale = max(scale, size)
        if size <= floor * scale:
            break
        if pivot != k:
            permutation[k], permutation[pivot] = permutation[pivot], permutation[k]
            norms[pivot] = norms[k]
            for i in range(m):
                W[k, i], W[pivot, i] = W[pivot, i], W[k, i]
        rank = k + 1
        v = W[k, k:]
        diagonal = -size if v[0] > 0.0 else size
        v[0] -= diagonal
        factor = 1.0 / (diagonal * v[0])
        for j in range(k + 1, p):
            u = W[j, k:]
            dot = 0.0
            for i in range(v.size):
                dot += v[i] * u[i]
            dot *= factor
            u[0] += dot * v[0]
            total = 0.0
            for i in range(1, v.size):
                u[i] += dot * v[i]
                total += u[i] * u[i]
            norms[j] = total
        v[0] = diagonal
    out = np.zeros((rank, p))
    for j in range(p):
        for i in range(min(j + 1, rank)):
            out[i, permutation[j]] = W[j, i]
    return out, permutation, scale, np.sqrt(remainder)


@kernel
def implied(R, permutation, rows, columns, begin, end, weight, floor, scale):
    """Whether ``weight * rows[begin:end]`` follow from the factor R.

    One generic combination of the rows is eliminated by the factor: if any of them adds a
    condition, so does almost every combination.
    """
    rank, p = R.shape
    x = np.zeros(p)
    for i in range(begin, end):
        c = weight * np.cos((i - begin + 1.0) ** 2)
        for j in range(p):
            x[j] += c * rows[i, columns[j]]
    size = 0.0
    for j in range(p):
        size += x[j] * x[j]
    size = np.sqrt(size)
    growth = 1.0
    for i in range(rank):
        multiplier = x[permutation[i]] / R[i, permutation[i]]
        growth = max(growth, abs(multiplier))
        for j in range(p):
            x[j] -= multiplier * R[i, j]
    remainder = 0.0
    for i in range(rank, p):
        remainder += x[permutation[i]] ** 2
    return np.sqrt(remainder) <= floor * max(scale, size) + ROUNDING * growth * scale


@kernel
def gather(
    R, permutation, scale, dropped, rows, columns, per_ray, width, first, radius, fresh, stop,
    floor,
):  # fmt: skip
    """Absorb the rows of consecutive orders, along as many rays as it takes.

    ``C(w + k - 1, k)`` generic rays span all derivatives of order k in w coordinates; fewer
    will do once the rows of one more follow from those gathered. Rows of order k are
    weighted by ``radius**k``. Fresh rows, of a finite pose, decide whether another order is
    needed; without any, only conditions that are complete settle that.

    Args:
        R: factor so far.
        permutation: its permutation.
        scale: its largest pivot.
        dropped: the largest remainder that was cut off.
        rows: shape (orders, rays * per_ray, parameters).
        columns: the parameters that the columns of the factor stand for.
        per_ray: rows of each ray.
        width: number of coordinates.
        first: the first of the orders.
        radius: radius of convergence of the series.
        fresh: rows of a finite pose.
        stop: whether to stop at the order that needs no other; without fresh rows, at the
            first one that adds nothing.
        floor: relative size of round-off.

    Returns:
        The factor, its permutation, largest pivot and largest remainder; the rank after each
        order; whether it is settled that they are all there are, and whether there were
        enough rays.
    """
    orders, count, _ = rows.shape
    p = columns.size
    ranks = np.zeros(orders, np.int64)
    settled = False
    done = 0
    for k in range(orders):
        order = first + k
        weight = radius**order
        every = 1
        for i in range(order):
            every = every * (width + i) // (i + 1)
        used = 0
        before = R.shape[0]
        while used < every and R.shape[0] < p:
            wanted = 2 * used if used > 0 else -(-(p - R.shape[0]) // per_ray)
            wanted = min(every, max(wanted, 1))
            if (wanted if wanted == every else wanted + 1) * per_ray > count:
                return R, permutation, scale, dropped, ranks[:done], False, False
            begin, end = used * per_ray, wanted * per_ray
            R, permutation, scale, remainder = absorb(
                R, rows[k], columns, begin, end, weight, floor, scale
            )
            dropped = max(dropped, remainder)
            used = wanted
            if used < every and implied(
                R, permutation, rows[k], columns, end, end + per_ray, weight, floor, scale
            ):
                break
        ranks[k] = R.shape[0]
        done += 1
        settled = R.shape[0] == p
        if not settled and fresh.shape[0] > 0:
            settled = implied(
                R, permutation, fresh, columns, 0, fresh.shape[0], 1.0, floor, scale
            )
        if stop and (settled or (fresh.shape[0] == 0 and R.shape[0] == before)):
            break
    return R, permutation, scale, dropped, ranks[:done], settled, True


@kernel
def smallest_pivot(R, permutation):
    """Size of the smallest pivot of a triangular factor; infinite without any."""
    size = np.inf
    for i in range(R.shape[0]):
        size = min(size, abs(R[i, permutation[i]]))
    return size


@kernel
def null_space(A, floor):
    """Orthonormal null space of A, as columns.

    Pivots up to ``floor`` times the largest pivot, or times 1, are round-off.
    """
    m, n = A.shape
    W = A.copy()
    Q = np.zeros((n, n))
    for i in range(n):
        Q[i, i] = 1.0
    norms = np.zeros(m)
    for i in range(m):
        for j in range(n):
            norms[i] += W[i, j] * W[i, j]
    scale = 1.0
    rank = 0
    for k in range(min(m, n)):
        pivot = k
        for i in range(k, m):
            if norms[i] > norms[pivot]:
                pivot = i
        size = np.sqrt(norms[pivot])
        scale = max(scale, size)
        if size <= floor * scale:
            break
        rank = k + 1
        norms[pivot] = norms[k]
        for j in range(n):
            W[k, j], W[pivot, j] = W[pivot, j], W[k, j]
        v = W[k, k:]
        diagonal = -size if v[0] > 0.0 else size
        v[0] -= diagonal
        factor = 1.0 / (diagonal * v[0])
        for i in range(k + 1, m):
            dot = 0.0
            for j in range(v.size):
                dot += W[i, k + j] * v[j]
            dot *= factor
            norms[i] = 0.0
            for j in range(v.size):
                W[i, k + j] += dot * v[j]
                if j > 0:
                    norms[i] += W[i, k + j] * W[i, k + j]
        for i in range(n):
            dot = 0.0
            for j in range(v.size):
                dot += Q[i, k + j] * v[j]
            dot *= factor
            for j in range(v.size):
                Q[i, k + j] += dot * v[j]
    return Q[:, rank:].copy()


@kernel
def orthonormal(rows):
    """Make independent rows orthonormal, each in turn against those before it.

    A row that lost more than half its size to the others is treated twice (J. W. Daniel et
    al., 1976).
    """
    for i in range(rows.shape[0]):
        x = rows[i]
        size = 0.0
        for j in range(x.size):
            size += x[j] * x[j]
        before = np.inf
        while size < 0.25 * before:
            before = size
            for k in range(i):
                y = rows[k]
                dot = 0.0
                for j in range(x.size):
                    dot += x[j] * y[j]
                if dot != 0.0:
                    for j in range(x.size):
                        x[j] -= dot * y[j]
            size = 0.0
            for j in range(x.size):
                size += x[j] * x[j]
        for j in range(x.size):
            x[j] /= np.sqrt(size)


@kernel
def extend(known, without, factor, columns):
    """Rows of a factor, written for all unknowns so that every row of ``known`` solves them.

    The head of ``known``, its columns ``without``, is upper triangular.
    """
    s, count = known.shape
    rows = np.zeros((factor.shape[0], count))
    for r in range(factor.shape[0]):
        for j in range(columns.size):
            rows[r, columns[j]] = factor[r, j]
        for k in range(s - 1, -1, -1):
            total = 0.0
            for j in range(count):
                total += known[k, j] * rows[r, j]
            rows[r, without[k]] = -total / known[k, without[k]]
    return rows


@kernel
def solutions(known, factor, columns):
    """Orthonormal solutions as rows: those known, and then the others that a factor leaves."""
    s, count = known.shape
    others = columns.size - factor.shape[0]
    out = np.zeros((s + others, count))
    out[:s] = known
    if others > 0:
        rest = null_space(factor, 0.0)
        for i in range(others):
            for j in range(columns.size):
                out[s + i, columns[j]] = rest[j, i]
    orthonormal(out)
    for i in range(out.shape[0]):
        for j in range(count):
            if abs(out[i, j]) < NOTHING:
                out[i, j] = 0.0
    return out
