"""Compiled kernel that collects the conditions of consecutive orders, ray by ray."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.pivoted_qr import append_rows, contains_rows, update_factor


class RaySeries(NamedTuple):
    """Rows of the regressor's series along rays, as kernels pass them to each other.

    Attributes:
        rows: shape (orders, ≥ rays * per_ray, parameters), non-dimensional.
        total: rows of all rays.
        per_ray: rows of each ray.
        width: number of coordinates.
        first: the first of the orders.
        radius: radius of convergence, in units of the coordinates.
    """

    rows: NDArray[np.float64]
    total: int
    per_ray: int
    width: int
    first: int
    radius: float


@kernel(reference_counting=False)
def collect_orders(factor, rank, scale, dropped, series, fresh, stop, ranks):
    """Collect the conditions of consecutive orders, along as many rays as needed.

    ``C(w + k - 1, k)`` generic rays span all derivatives of order k in w coordinates. Fewer
    are enough once the rows of one more ray follow from the others. Rows of order k are
    weighted by ``radius**k``. Fresh rows, of a finite pose, decide whether another order is
    needed. Without fresh rows, only a full column rank settles that.

    Args:
        factor: in, out: a `Factor`, with workspace for the rows of all rays.
        rank: its rows.
        dropped: the largest remainder that was cut off.
        series: in: a `RaySeries`.
        fresh: in: rows of a finite pose (m, parameters), or none of them.
        stop: whether to stop at the order that needs no other; without fresh rows, at the
            first one that adds nothing.
        ranks: out: the rank after each order (orders,).

    Returns:
        The rank, largest pivot and largest remainder; number of orders collected; whether
        no other order is needed, and whether there were enough rays.
    """
    rows, total, per_ray, width, first, radius = series
    orders, p = rows.shape[0], factor.columns.size
    settled = False
    done = 0
    for k in range(orders):
        # weight = radius**(first + k), every = C(width + first + k - 1, first + k)
        weight, every = 1.0, 1
        for i in range(first + k):
            weight *= radius
            every = every * (width + i) // (i + 1)
        used = 0
        before = rank
        # Twice as many rays each time, until the rows of the next one follow.
        while used < every and rank < p:
            wanted = 2 * used if used > 0 else -(-(p - rank) // per_ray)
            wanted = min(every, max(wanted, 1))
            if (wanted if wanted == every else wanted + 1) * per_ray > total:
                return rank, scale, dropped, done, False, False
            new = rows[k, used * per_ray : wanted * per_ray]
            append_rows(factor, rank, new, weight)
            rank, scale, remainder = update_factor(factor, rank, new.shape[0], scale)
            dropped = max(dropped, remainder)
            used = wanted
            next_ray = rows[k, used * per_ray : (used + 1) * per_ray]
            if used < every and contains_rows(factor, rank, next_ray, weight, scale):
                break
        ranks[k] = rank
        done += 1
        settled = rank == p
        if not settled and fresh.shape[0] > 0:
            settled = contains_rows(factor, rank, fresh, 1.0, scale)
        if stop and (settled or (fresh.shape[0] == 0 and rank == before)):
            break
    return rank, scale, dropped, done, settled, True
