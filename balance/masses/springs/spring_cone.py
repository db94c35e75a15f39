"""Stiffnesses and points of springs as a convex cone, and programs over it.

The unknowns of a spring are its stiffness k and k s_j for each coordinate that is free, with
``low ≤ k ≤ high`` and ``|k s_j| ≤ k``. Both programs are reduced to the least distance of a
polyhedron from the origin, and that to least squares with multipliers that are not negative
(C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974, chapter 23): a finite method,
which names the limits that hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.springs.attached_springs import AttachedSpring
from balance.space.conditions.rank import Conditions
from balance.support.tolerances import (
    SPRING_CARRIES_GRAVITY,
    SPRING_LIMIT_KEPT,
    SPRINGS_UNBOUNDED,
)
from kinematics.numerics.array_types import Array

# Price of unknowns beside torques, both relative, where several leave as little torque.
PRICE_OF_SIZE = 1e-5


class SpringCone(NamedTuple):
    """Limits of the unknowns: ``rows x + offset`` is not negative.

    Attributes:
        rows: shape (limits, unknowns).
        offset: shape (limits,).
        starts: first unknown of each spring, and the number of all.
    """

    rows: Array
    offset: Array
    starts: tuple[int, ...]

    def columns_of(self, springs: Sequence[int]) -> list[int]:
        """List the unknowns of some springs."""
        return [c for s in springs for c in range(self.starts[s], self.starts[s + 1])]

    def of(self, springs: Sequence[int]) -> SpringCone:
        """Restrict the cone to some springs; the others are left out of the linkage."""
        columns = self.columns_of(springs)
        counts = [self.starts[s + 1] - self.starts[s] for s in springs]
        rows = self.rows[:, columns]
        used = rows.any(axis=1)
        starts = tuple(np.concatenate([[0], np.cumsum(counts)]).astype(int).tolist())
        return SpringCone(rows[used], self.offset[used], starts)


def make_cone(
    springs: Sequence[AttachedSpring], unit: float, ranges: Sequence[tuple[float, float]]
) -> SpringCone:
    """Build the limits of springs.

    Args:
        springs: the springs.
        unit: stiffness that counts as 1, N/m.
        ranges: least and greatest stiffness of each, N/m.
    """
    starts = np.concatenate([[0], np.cumsum([spring.columns for spring in springs])])
    rows: list[Array] = []
    offset: list[float] = []
    unknowns = np.eye(int(starts[-1]))
    for spring, start, (low, high) in zip(springs, starts, ranges, strict=False):
        stiffness = unknowns[start]
        rows.append(stiffness)
        offset.append(-low / unit)
        if np.isfinite(high):
            rows.append(-stiffness)
            offset.append(high / unit)
        free = unknowns[start + 1 : start + 1 + spring.free]
        for coordinate in free:
            rows += [stiffness - coordinate, stiffness + coordinate]
            offset += [0.0, 0.0]
        first, second = np.split(free, [len(spring.ends[0].axes)])
        products = iter(unknowns[start + 1 + spring.free : start + spring.columns])
        for s in first:
            for t in second:
                both = next(products)
                for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                    rows.append(stiffness + a * s + b * t + a * b * both)
                    offset.append(0.0)
    return SpringCone(np.array(rows), np.array(offset), tuple(starts.tolist()))


def balanced_unknowns(conditions: Array, cone: SpringCone) -> Array | None:
    """Find unknowns that satisfy linear conditions within a cone, of least size.

    Args:
        conditions: rows (count, unknowns + 1), the last column that of gravity.
        cone: the limits.

    Returns:
        The unknowns whose squares have the least sum; None if there are none.
    """
    equal, cone = _split_equations(cone)
    rows = Conditions.none(conditions.shape[1]).append(np.concatenate([conditions, equal]))
    basis = rows.decide().basis
    last = basis[-1]
    if not last @ last > SPRING_CARRIES_GRAVITY**2:
        return None
    # Columns of the directions are orthonormal, and at right angles to the start.
    start = basis[:-1] @ last / (last @ last)
    directions = basis[:-1] @ np.linalg.qr(last[:, None], mode="complete")[0][:, 1:]
    v = _least_distance(cone.rows @ directions, -cone.offset - cone.rows @ start)
    if v is None:
        return None
    x = start + directions @ v
    return x if _keeps_limits(x, cone) else None


def _split_equations(cone: SpringCone) -> tuple[Array, SpringCone]:
    """Take limits that leave no room, ``low = k = high``, out of a cone as equations.

    Returns:
        Rows (count, unknowns + 1) that vanish, each of size 1; and the other limits.
    """
    opposite = [
        k
        for k in range(len(cone.rows) - 1)
        if cone.offset[k] == -cone.offset[k + 1] and (cone.rows[k] == -cone.rows[k + 1]).all()
    ]
    kept = np.setdiff1d(np.arange(len(cone.rows)), [*opposite, *(k + 1 for k in opposite)])
    equal = np.column_stack([cone.rows[opposite], cone.offset[opposite]])
    sizes = np.linalg.norm(equal, axis=1, keepdims=True)
    return equal / sizes, cone._replace(rows=cone.rows[kept], offset=cone.offset[kept])


def least_unknowns(rows: Array, cone: SpringCone) -> Array:
    """Find unknowns in a cone that leave the least sum of squares of ``rows [x; 1]``.

    Among equal ones, those whose squares have the least sum are taken. The cone must not be
    empty.

    Args:
        rows: shape (count, unknowns + 1).
        cone: the limits.
    """
    count = rows.shape[1] - 1
    price = PRICE_OF_SIZE * (float(np.linalg.norm(rows[:, :-1], 2)) or 1.0)
    A = np.vstack([rows[:, :-1], price * np.eye(count)])
    b = np.concatenate([rows[:, -1], np.zeros(count)])
    # With A = Q R and y = R x + Qᵀ b, the size of y is to be the least.
    Q, R = np.linalg.qr(A)
    turned, G = Q.T @ b, np.linalg.solve(R.T, cone.rows.T).T
    y = _least_distance(G, -cone.offset + G @ turned)
    assert y is not None
    return np.asarray(np.linalg.solve(R, y - turned))


def _least_distance(G: Array, h: Array) -> Array | None:
    """Find the least v with ``G v ≥ h``; None if there is none.

    Args:
        G: shape (limits, n).
        h: shape (limits,).
    """
    from scipy.optimize import nnls

    sizes = np.linalg.norm(G, axis=1)
    still = sizes <= SPRING_LIMIT_KEPT * sizes.max(initial=0.0)
    scale = float(np.abs(h).max(initial=0.0)) or 1.0
    if (h[still] > SPRING_LIMIT_KEPT * scale).any():
        return None
    G, h = G[~still] / sizes[~still, None], h[~still] / sizes[~still]
    scale = float(np.abs(h).max(initial=0.0))
    if not (h > 0.0).any():
        return np.zeros(G.shape[1])
    E = np.vstack([G.T, h / scale])
    goal = np.append(np.zeros(G.shape[1]), 1.0)
    multipliers, distance = nnls(E, goal, maxiter=100 * len(h))
    if distance < SPRINGS_UNBOUNDED:
        return None
    active = multipliers > 0.0
    return np.asarray(np.linalg.lstsq(G[active], h[active], rcond=1e-12)[0])


def _keeps_limits(x: Array, cone: SpringCone) -> bool:
    """Whether unknowns keep their limits but for round-off."""
    size = max(1.0, float(np.abs(x).max(initial=0.0)))
    return bool((cone.rows @ x + cone.offset).min(initial=0.0) > -SPRING_LIMIT_KEPT * size)
