"""Compute motion and momentum of a chain in mpmath, from finite poses alone.

Poses are products of exponentials, closed by Newton's method at points of a small circle in
the complex plane; power series along ``u = t δ`` are Cauchy's integrals over it. The
route is independent of the package: there is no Lie bracket, no series and no least squares,
and momentum follows from pseudo-inertias at the pose, ``A = T̂ H P Hᵀ``, as ``A - Aᵀ``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg

from benchmarks.peers import library
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain

# Radius of the circle as a power of ten; digits beyond those that its powers take; terms of
# an exponential, enough for displacements of 1.
RADIUS, DIGITS, TERMS = -6, 30, 30
# Of the parameters [m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz], and of [ξ; p].
PLANAR, ROWS = [0, 1, 2, 6], [2, 3, 4]


def off(found: np.ndarray, true: np.ndarray) -> float:
    """Largest difference of series (order + 1, ...), relative to the largest entry by order."""
    orders = len(true)
    apart = np.abs(found - true).reshape(orders, -1).max(axis=1)
    return float((apart / np.abs(true).reshape(orders, -1).max(axis=1)).max())


def positions(chain: Chain, ray: np.ndarray, order: int) -> np.ndarray:
    """Joint positions along a ray, as a power series from order 1 on; (order, n)."""
    return _series(chain, ray, order, lambda poses, u: poses.close_loops(u))[1:]


def momentum(chain: Chain, ray: np.ndarray, order: int) -> np.ndarray:
    """Momentum regressor along a ray; (order + 1, width, rows, parameters)."""
    return _series(chain, ray, order, lambda poses, u: poses.regressor(poses.close_loops(u)))


def gap(chain: Chain, q: np.ndarray) -> float:
    """Compute the loop residual of joint positions (n,), in units of the chain."""
    mp = library("mpmath").mp
    with mp.workdps(DIGITS):
        poses = _Poses(mp, chain)
        return float(max(map(abs, poses.mismatch(_numbers(mp, q)))))


def _series(
    chain: Chain, ray: np.ndarray, order: int, value: Callable[[_Poses, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Compute series coefficients of an analytic function of t, by Cauchy's integrals."""
    mp = library("mpmath").mp
    with mp.workdps(DIGITS - RADIUS * order):
        poses, radius, count = _Poses(mp, chain), mp.mpf(10) ** RADIUS, 2 * (order // 2 + 2)
        circle = [mp.expjpi(mp.mpf(2 * i) / count) for i in range(count)]
        # The other half of the circle has the conjugate values.
        points = circle[: count // 2 + 1]
        values = [value(poses, _numbers(mp, ray) * (radius * point)) for point in points]
        values[1:-1] = [2 * v for v in values[1:-1]]
        terms = [
            sum(v * mp.conj(circle[i * k % count]) for i, v in enumerate(values))
            / (count * radius**k)
            for k in range(order + 1)
        ]
        found = [[float(mp.re(x)) for x in term.ravel()] for term in terms]
        return np.reshape(found, (order + 1, *values[0].shape))


def _numbers(mp, array: np.ndarray) -> np.ndarray:
    """An array of numbers of mpmath."""
    return np.array([mp.mpf(float(x)) for x in np.ravel(array)], object).reshape(array.shape)


class _Poses:
    """A chain at finite poses in numbers of mpmath, with 4×4 matrices also in a plane."""

    def __init__(self, mp, chain: Chain) -> None:
        """Convert screws to matrices, and choose equations for the dependent joints."""
        self.mp, self.chain = mp, chain
        screws = np.zeros((len(chain.screws), 6))
        screws[:, ROWS if chain.planar else slice(None)] = chain.screws
        self.screws = _numbers(mp, np.array([_hat(s) for s in screws]))
        self.terms = [_terms(s) for s in self.screws]
        self.columns, self.mimics = _numbers(mp, chain.columns), _numbers(mp, chain.mimics)
        units = np.eye(10)[PLANAR] if chain.planar else np.eye(10)
        self.parameters = _numbers(mp, np.array([_pseudo(z) for z in units]))
        A = loop_matrix(chain)[:, chain.dependent]
        count = A.shape[1]
        self.rows = scipy.linalg.qr(A.T, pivoting=True)[2][:count] if count else []
        # An approximate inverse: it affects the rate of convergence, not the solution.
        self.inverse = _numbers(mp, np.linalg.inv(A[self.rows])) if count else None

    def close_loops(self, u: np.ndarray) -> np.ndarray:
        """Joint positions at the coordinates u, near the reference pose."""
        return self._solve(self.columns @ u, self.mismatch)

    def _solve(self, q: np.ndarray, mismatch: Callable) -> np.ndarray:
        """Correct the dependent joints until the chosen equations hold."""
        while self.inverse is not None:
            step = self.inverse @ mismatch(q)[self.rows]
            q[self.chain.dependent] -= step
            if max(map(abs, step)) < self.mp.mpf(10) ** (5 - self.mp.dps):
                break
        return q

    def mismatch(self, q: np.ndarray) -> np.ndarray:
        """Compute the residuals of the loops and of the mimic relations."""
        H = self._link_poses(q)
        apart = [_vee(_inverse(H[f]) @ H[e] - np.eye(4)) for e, f in self.chain.ends]
        return self._equations(apart, q)

    def _equations(self, loops: list[np.ndarray], q: np.ndarray) -> np.ndarray:
        kept = [part[ROWS] if self.chain.planar else part for part in loops]
        return np.concatenate([*kept, self.mimics @ q])

    def _link_poses(self, q: np.ndarray) -> list[np.ndarray]:
        """Displacement of the link after each joint; the last is that of the ground."""
        H: list[np.ndarray] = [np.eye(4) * self.mp.mpf(1)] * (len(q) + 1)
        for j, parent in enumerate(self.chain.parent):
            H[j] = H[parent] @ self._exponential(j, q[j])
        return H

    def _exponential(self, j: int, q) -> np.ndarray:
        total, factor = np.eye(4), q
        for term in self.terms[j]:
            if abs(factor) < self.mp.eps:
                break
            total = total + term * factor
            factor = factor * q
        return total

    def regressor(self, q: np.ndarray) -> np.ndarray:
        """Momentum of every parameter for unit rates; (width, rows, parameters)."""
        H, chain = self._link_poses(q), self.chain
        moved = [H[j] @ s @ _inverse(H[j]) for j, s in enumerate(self.screws)]
        bodies = [
            self.parameters if b < 0 else H[b] @ self.parameters @ H[b].T for b in chain.links
        ]
        found = []
        for column in self.columns.T:
            rates = self._solve(column.copy(), lambda c: self._open(moved, c))
            T = self._twists(moved, rates)
            A = np.array([T[b] @ P for b, P in zip(chain.links, bodies, strict=True)])
            h = np.array([_vee(a) for a in (A - A.mT).reshape(-1, 4, 4)]).T
            found.append(h[ROWS] if chain.planar else h)
        return np.array(found)

    def _twists(self, moved: list[np.ndarray], rates: np.ndarray) -> list[np.ndarray]:
        """Twist of the link after each joint; the last is that of the ground."""
        T = [np.zeros((4, 4))] * (len(moved) + 1)
        for j, parent in enumerate(self.chain.parent):
            T[j] = T[parent] + moved[j] * rates[j]
        return T

    def _open(self, moved: list[np.ndarray], rates: np.ndarray) -> np.ndarray:
        """Rates at which the loops open."""
        T = self._twists(moved, rates)
        return self._equations([_vee(T[e] - T[f]) for e, f in self.chain.ends], rates)


def _hat(s: np.ndarray) -> np.ndarray:
    """Convert a twist [ω; v] to a matrix (4, 4)."""
    (x, y, z), v = s[:3], s[3:]
    return np.array([[0, -z, y, v[0]], [z, 0, -x, v[1]], [-y, x, 0, v[2]], [0, 0, 0, 0]])


def _terms(A: np.ndarray) -> list[np.ndarray]:
    """Terms A, A²/2, … of the exponential."""
    found = [A]
    for k in range(2, TERMS):
        found.append(found[-1] @ A / k)
    return found


def _vee(A: np.ndarray) -> np.ndarray:
    """The twist of a matrix whose rotation may be finite: of its skew part."""
    w = np.array([A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]]) / 2
    return np.concatenate([w, A[:3, 3]])


def _pseudo(z: np.ndarray) -> np.ndarray:
    """The pseudo-inertia of parameters (10,)."""
    xx, yy, zz, xy, xz, yz = z[4:]
    E = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    P = np.zeros((4, 4))
    P[:3, :3] = np.trace(E) / 2 * np.eye(3) - E
    P[3, :3] = P[:3, 3] = z[1:4]
    P[3, 3] = z[0]
    return P


def _inverse(H: np.ndarray) -> np.ndarray:
    """The inverse of a displacement."""
    found = H.copy()
    found[:3, :3] = H[:3, :3].T
    found[:3, 3] = -H[:3, :3].T @ H[:3, 3]
    return found
