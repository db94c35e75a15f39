"""daceypy: Newton's method with truncated polynomials, with its cache of memory.

Two angles an arm: the Jacobian is inverted as polynomials, and each pass doubles the order
that is exact. Six angles: a constant inverse, and each pass adds one order. The first passes
are truncated early.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.peers import jobs, library


def five_bar(order: int) -> tuple[Callable, Callable]:
    """Inverse kinematics of the five-bar."""
    DA = _start(order, 2)
    start = jobs.ANGLES.tolist()

    def run() -> list:
        y = DA(2) + jobs.TIP[1]
        xs = [DA(1) + (jobs.TIP[0] - base) for base in jobs.BASES]
        q, exact = [DA(angle) for angle in start], 0
        while exact < order:
            exact = min(2 * exact + 1, order)
            DA.setTO(exact)
            for i, x in zip((0, 2), xs, strict=True):
                both = q[i] + q[i + 1]
                bx, by = jobs.UPPER * both.cos(), jobs.UPPER * both.sin()
                ax, ay = bx + jobs.LOWER * q[i].cos(), by + jobs.LOWER * q[i].sin()
                dx, dy, inverse = ax - x, ay - y, (ax * by - ay * bx).minv()
                q[i] = q[i] - (bx * dx + by * dy) * inverse
                q[i + 1] = q[i + 1] + (ax * dx + ay * dy) * inverse
        return q

    def read(found: list) -> np.ndarray:
        wanted = jobs.exponents(order)
        return np.array([[q.getCoefficient(list(e)) for e in wanted] for q in found])

    return run, read


def six_r(order: int) -> tuple[Callable, Callable]:
    """The 6R arm along its line."""
    DA = _start(order, 1)
    start = jobs.POSE.tolist()
    at, turned = _flange(np.sin, np.cos, start)
    step = 1e-20
    columns = [
        _mismatch(
            np.sin,
            np.cos,
            [q + step * 1j * (i == k) for i, q in enumerate(start)],
            0.0,
            at,
            turned,
        )
        for k in range(6)
    ]
    J = np.linalg.inv(np.imag(columns).T / step).tolist()

    def run() -> list:
        u, q = DA(1), [DA(angle) for angle in start]
        for k in range(1, order + 1):
            DA.setTO(k)
            rest = _mismatch(DA.sin, DA.cos, q, u, at, turned)
            for i in range(6):
                for j in range(6):
                    q[i] = q[i] - J[i][j] * rest[j]
        return q

    def read(found: list) -> np.ndarray:
        return np.array([[q.getCoefficient([k]) for k in range(order + 1)] for q in found])

    return run, read


def _start(order: int, inputs: int):
    """Set up polynomials of an order, without a threshold for small terms."""
    DA = library("daceypy").DA
    DA.cache_disable()  # empties the cache, which holds data of the order before
    DA.init(order, inputs)
    DA.setEps(0.0)
    DA.cache_enable()
    return DA


def _flange(sine: Callable, cosine: Callable, q: list) -> tuple[list, list]:
    """Position and rotation of the flange; all axes are those of the coordinates."""
    p, R = jobs.FLANGE.tolist(), np.eye(3).tolist()
    for i in range(5, -1, -1):
        axis = int(np.argmax(np.abs(jobs.AXES[i])))
        a, b = (axis + 1) % 3, (axis + 2) % 3
        s, c = float(jobs.AXES[i, axis]) * sine(q[i]), cosine(q[i])
        x, y = jobs.POINTS[i, [a, b]].tolist()
        u, v = p[a] - x, p[b] - y
        p[a], p[b] = c * u - s * v + x, s * u + c * v + y
        R[a], R[b] = (
            [c * m - s * n for m, n in zip(R[a], R[b], strict=True)],
            [s * m + c * n for m, n in zip(R[a], R[b], strict=True)],
        )
    return p, R


def _mismatch(sine: Callable, cosine: Callable, q: list, u, at: list, turned: list) -> list:
    """Compute the distance of the flange from the line, and its rotation."""
    p, R = _flange(sine, cosine, q)

    def entry(i: int, j: int):
        return sum(turned[k][i] * R[k][j] for k in range(3))

    shift = [p[i] - at[i] - u * float(jobs.DIRECTION[i]) for i in range(3)]
    return [*shift, *(entry(k, j) - entry(j, k) for j, k in ((1, 2), (2, 0), (0, 1)))]
