"""The same questions put to CVXPY, from finite poses: matrices are the unknowns.

No basis of a design space is used, but the momentum rows of random poses as equations on the
entries of the pseudo-inertias, in the coordinates of the chain and in units of the mean mass.
"""

from __future__ import annotations

import warnings

import cvxpy as cp
import numpy as np

from tests.support.shapes import conditions, matrix, units

PRECISE = {"tol_gap_rel": 1e-10, "tol_gap_abs": 1e-10, "tol_feas": 1e-10}


def solved(problem, **settings):
    """The optimum; that it has fewer digits than asked for is worth a warning there."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Solution may be inaccurate")
        return float(problem.solve(solver=cp.CLARABEL, **settings))


class Model:
    """A linkage's pseudo-inertias as variables, balanced at random poses."""

    def __init__(self, space, reach=0.25, balls=()):
        """Balls, one for each body if there are any: a centre (3,) and a radius in metres."""
        self.space, self.k = space, 3 if space.planar else 4
        R, origin, length = units(space)
        self.H = np.zeros((4, self.k))
        self.H[:3, : self.k - 1] = length * R.T[:, : self.k - 1]
        self.H[:, -1] = [*origin, 1.0]
        self.length, self.count = length, len(space.bodies)
        given = np.array([body.inertia for body in space.linkage.bodies])
        self.unit = given[:, 0].mean()
        self.given = [self.seen(matrix(z)) / self.unit for z in given]
        rows = conditions(space, reach=reach).reshape(-1, 10)
        own = np.array([self.entries(row) for row in rows])
        own = own.reshape(-1, self.count * self.k**2)
        _, sizes, V = np.linalg.svd(own, full_matrices=False)
        self.rows = V[sizes > 1e-10 * sizes[0]]
        self.P = [cp.Variable((self.k, self.k), symmetric=True) for _ in range(self.count)]
        stacked = cp.hstack([cp.vec(P, order="C") for P in self.P])
        self.balanced = [self.rows @ stacked == 0]
        for P, (c, r) in zip(self.P, balls, strict=False):
            G = np.diag([-1.0, -1.0, -1.0, r * r - c @ c])
            G[:3, 3] = G[3, :3] = c
            G = self.H.T @ G @ self.H
            self.balanced.append(cp.sum(cp.multiply(G / np.linalg.norm(G), P)) >= 0)
        self.trace = sum(cp.trace(P) for P in self.P)

    def seen(self, P):
        """A matrix in SI units (4, 4) in the coordinates of the chain (k, k)."""
        full = np.linalg.pinv(self.H)
        return full @ P @ full.T

    def entries(self, row):
        """A functional of ten parameters as one of the entries of a matrix (k, k)."""
        m, x, y, w, xx, yy, zz, xy, xz, yz = row
        G = np.array(
            [
                [yy + zz, -xy / 2, -xz / 2, x / 2],
                [-xy / 2, xx + zz, -yz / 2, y / 2],
                [-xz / 2, -yz / 2, xx + yy, w / 2],
                [x / 2, y / 2, w / 2, m],
            ]
        )
        return self.H.T @ G @ self.H

    def margin(self):
        """The largest t with all matrices at least t, when their traces add up to 1."""
        t, one = cp.Variable(), np.eye(self.k)
        limits = [P - t * one >> 0 for P in self.P]
        problem = cp.Problem(cp.Maximize(t), [*self.balanced, *limits, self.trace == 1])
        return solved(problem, **PRECISE)

    def verdict(self):
        """Whether there are balanced matrices of at least 1."""
        rest = [P - np.eye(self.k) >> 0 for P in self.P]
        problem = cp.Problem(cp.Minimize(self.trace), [*self.balanced, *rest])
        solved(problem)
        return {"optimal": "feasible", "infeasible": "infeasible"}[problem.status.split("_")[0]]

    def best(self, wanted, margin, floor=1e-2, room=10.0):
        """The least value of an objective in SI units."""
        limits = [P - floor * np.eye(self.k) >> 0 for P in self.P]
        limits.append(self.trace <= room * floor / margin)
        if wanted == "change":
            limits = []
        goal, unit = getattr(self, wanted)()
        problem = cp.Problem(cp.Minimize(goal), [*self.balanced, *limits])
        return solved(problem, **PRECISE) * unit

    def mass(self):
        return sum(P[-1, -1] for P in self.P), self.unit

    def inertia(self):
        moments = []
        for P, frame in zip(self.P, self.space.frames, strict=True):
            shift = np.eye(self.k)
            shift[:, -1] -= np.linalg.pinv(self.H) @ [*frame[:3, 3], 1.0]
            shift[-1, -1] = 1.0
            S = (shift @ P @ shift.T)[:-1, :-1]
            E = cp.trace(S) * np.eye(self.k - 1) - S
            moments.append(cp.trace(S) if self.space.planar else cp.lambda_max(E))
        return cp.maximum(*moments), self.unit * self.length**2

    def change(self):
        goal = 0
        for P, P0 in zip(self.P, self.given, strict=True):
            W = np.linalg.inv(np.linalg.cholesky(P0))
            own = W @ P @ W.T
            goal += 2.0 * (cp.trace(own) - cp.log_det(own) - self.k)
        return goal, 1.0
