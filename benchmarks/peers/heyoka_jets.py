"""heyoka: jets of the differential equation ``dq/dt = J(q)⁻¹ v``, one step of its integrator.

For two inputs, along a batch of directions, whose coefficients of one degree give those of
the monomials by least squares; one matrix product for all degrees. The five-bar's geometry is
compiled in, that of the 6R arm is a parameter at run time. No disk cache.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp

import numpy as np

from benchmarks.peers import jobs, library


def _heyoka():
    hk = library("heyoka")
    hk.llvm_state.set_diskcache_enabled(False)
    return hk


def _tolerance(order: int) -> float:
    """The integrator chooses its order from this."""
    return exp(-2.0 * (max(order, 2) - 1.5))


def five_bar(order: int) -> tuple[Callable, Callable]:
    """Inverse kinematics of the five-bar."""
    hk = _heyoka()
    count = 2 if order == 1 else -(-(order + 1) // 4) * 4
    turn = np.pi * (np.arange(count) + 0.25) / count
    rays = np.array([np.cos(turn), np.sin(turn)])
    batch = hk.taylor_adaptive_batch(
        _arms(hk), np.zeros((4, count)), pars=np.zeros((2, count)), tol=_tolerance(order)
    )
    state, direction, jets = batch.state, batch.pars, batch.tc
    start = np.repeat(jobs.ANGLES[:, None], count, axis=1)
    fit = np.zeros((order + 1, count, order + 1))
    fit[0, 0, 0] = 1.0
    for k in range(1, order + 1):
        powers = [rays[0] ** (k - j) * rays[1] ** j for j in range(k + 1)]
        fit[k, :, : k + 1] = np.linalg.pinv(np.array(powers).T).T
    by_degree = jets[:, : order + 1].transpose(1, 0, 2)
    out = np.empty((order + 1, 4, order + 1))

    def run() -> np.ndarray:
        state[:] = start
        direction[:] = rays
        batch.step(write_tc=True)
        return np.matmul(by_degree, fit, out=out)

    def read(found: np.ndarray) -> np.ndarray:
        return np.concatenate([found[k, :, : k + 1] for k in range(order + 1)], axis=1)

    return run, read


def _arms(hk) -> list:
    """The differential equation of both arms; the velocity of the tip is a parameter."""
    found = []
    for arm in "ab":
        lower, upper = hk.make_vars(f"lower_{arm}", f"upper_{arm}")
        both = lower + upper
        b = -jobs.UPPER * hk.sin(both), jobs.UPPER * hk.cos(both)
        a = b[0] - jobs.LOWER * hk.sin(lower), b[1] + jobs.LOWER * hk.cos(lower)
        determinant = a[0] * b[1] - a[1] * b[0]
        x, y = hk.par[0], hk.par[1]
        found += [
            (lower, (b[1] * x - b[0] * y) / determinant),
            (upper, (a[0] * y - a[1] * x) / determinant),
        ]
    return found


def six_r(order: int) -> tuple[Callable, Callable]:
    """The 6R arm along its line."""
    hk = _heyoka()
    geometry = _frames()
    q, matrix = _jacobian(hk)
    system = [
        row + [hk.par[75 + r] if r < 3 else hk.expression(0.0)] for r, row in enumerate(matrix)
    ]
    numbers = hk.cfunc([e for row in system for e in row], vars=q)
    values = np.reshape(numbers(jobs.POSE, pars=geometry), (6, 7))
    rates = _eliminate(system, values)
    integrator = hk.taylor_adaptive(
        list(zip(q, rates, strict=True)), np.zeros(6), pars=geometry, tol=_tolerance(order)
    )
    state, jets = integrator.state, integrator.tc

    def run() -> np.ndarray:
        state[:] = jobs.POSE
        integrator.step(write_tc=True)
        return jets[:, : order + 1]

    return run, np.array


def _frames() -> np.ndarray:
    """Pose of each joint's frame, with its axis as z, in the one before; tool; direction."""
    numbers: list[np.ndarray] = []
    R, p = np.eye(3), np.zeros(3)
    for axis, at in zip(jobs.AXES, jobs.POINTS, strict=True):
        x = np.roll(np.abs(axis), 1)
        new = np.column_stack([x, np.cross(axis, x), axis])
        numbers += [np.ravel(R.T @ new), R.T @ (at - p)]
        R, p = new, at
    return np.concatenate([*numbers, R.T @ (jobs.FLANGE - p), jobs.DIRECTION])


def _jacobian(hk) -> tuple[list, list]:
    """Variables, and the Jacobian of the flange with all geometry as parameters (6, 6)."""
    q = hk.make_vars(*(f"q{i}" for i in range(6)))
    R = [[1.0 if r == c else 0.0 for c in range(3)] for r in range(3)]
    p: list = [0.0] * 3
    frames = []
    for i in range(6):
        par = [hk.par[12 * i + k] for k in range(12)]
        if i == 0:
            R, p = [par[3 * r : 3 * r + 3] for r in range(3)], par[9:]
        else:
            p = [p[r] + sum(R[r][c] * par[9 + c] for c in range(3)) for r in range(3)]
            R = [
                [sum(R[r][k] * par[3 * k + c] for k in range(3)) for c in range(3)]
                for r in range(3)
            ]
        frames.append(([row[2] for row in R], p))
        s, c = hk.sin(q[i]), hk.cos(q[i])
        R = [[row[0] * c + row[1] * s, row[1] * c - row[0] * s, row[2]] for row in R]
    end = [p[r] + sum(R[r][c] * hk.par[72 + c] for c in range(3)) for r in range(3)]
    columns = []
    for axis, at in frames:
        arm = [e - a for e, a in zip(end, at, strict=True)]
        u, v = (1, 2, 0), (2, 0, 1)
        shift = [axis[u[r]] * arm[v[r]] - axis[v[r]] * arm[u[r]] for r in range(3)]
        columns.append(shift + axis)
    return list(q), [[column[r] for column in columns] for r in range(6)]


def _eliminate(rows: list[list], values: np.ndarray) -> list:
    """Gauss's elimination of expressions, with the pivots that their values call for."""
    rows, values = [list(row) for row in rows], values.copy()
    for c in range(6):
        best = c + int(np.argmax(np.abs(values[c:, c])))
        rows[c], rows[best] = rows[best], rows[c]
        values[[c, best]] = values[[best, c]]
        for r in range(c + 1, 6):
            ratio = rows[r][c] / rows[c][c]
            values[r] -= values[c] * (values[r, c] / values[c, c])
            for k in range(c + 1, 7):
                rows[r][k] = rows[r][k] - ratio * rows[c][k]
    found: list = [None] * 6
    for c in range(5, -1, -1):
        rest = rows[c][6]
        for k in range(c + 1, 6):
            rest = rest - rows[c][k] * found[k]
        found[c] = rest / rows[c][c]
    return found
