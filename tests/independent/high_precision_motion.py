"""Closed motions of linkages of the gallery in arithmetic of 70 digits.

The loops are closed at points of a circle in the complex plane of the ray's parameter, by
Newton's method on the coincidence of points and axes, and the coefficients of the motion's
power series are read off by Cauchy's integral formula. The decimals of the file are read as
they stand: nothing is rounded to double precision on the way.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
from mpmath import mp

DIGITS = 70
RADIUS, SAMPLES = "0.02", 28
"""Aliasing with order k + 28 leaves ``(0.02 / ρ)²⁸``: below 1e-30 for ρ > 0.25."""


def exact(text):
    """The numbers of an attribute, as decimals."""
    return np.array([mp.mpf(word) for word in text.split()], dtype=object)


def cross_matrix(a):
    x, y, z = a
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)


class Exact:
    """A linkage read from a gallery file, and its closed motion in high precision."""

    def __init__(self, path):
        robot = ElementTree.parse(path).getroot()
        self.joints, self.parents, self.axes, self.points, self.sliding = [], [], [], [], []
        links = {"base": (-1, exact("0 0 0"))}
        for joint in robot.findall("joint"):  # the gallery writes parents first
            parent, at = links[joint.find("parent").get("link")]
            at = at + exact(joint.find("origin").get("xyz"))
            links[joint.find("child").get("link")] = (len(self.joints), at)
            axis = exact(joint.find("axis").get("xyz"))
            self.joints.append(joint.get("name"))
            self.parents.append(parent)
            self.points.append(at)
            self.axes.append(axis / mp.sqrt(axis @ axis))
            self.sliding.append(joint.get("type") == "prismatic")
        self.cuts = []
        for loop in robot.findall("loop"):
            ends = [loop.find(tag) for tag in ("predecessor", "successor")]
            (i, at), (j, other) = (links[end.get("link")] for end in ends)
            at = at + exact(ends[0].find("origin").get("xyz"))
            gap = at - other - exact(ends[1].find("origin").get("xyz"))
            assert max(abs(x) for x in gap) < mp.mpf(10) ** (2 - DIGITS)
            revolute = loop.get("type") == "revolute"
            axis = exact(loop.find("axis").get("xyz")) if revolute else None
            self.cuts.append((i, j, at, axis))

    def placed(self, q):
        """Rotation and translation of every link, and of the ground last."""
        steps = [(np.eye(3, dtype=object), exact("0 0 0"))] * (len(q) + 1)
        for j, parent in enumerate(self.parents):
            (R, d), n, r = steps[parent], self.axes[j], self.points[j]
            if self.sliding[j]:
                steps[j] = R, d + R @ n * q[j]
            else:
                K = cross_matrix(n)
                turn = np.eye(3, dtype=object) + mp.sin(q[j]) * K + (1 - mp.cos(q[j])) * (K @ K)
                steps[j] = R @ turn, d + R @ (r - turn @ r)
        return steps

    def residual(self, q):
        """Gaps of the cuts, and their derivatives by every joint; (rows,), (rows, n)."""
        steps = self.placed(q)
        gaps, slopes = [], []
        for i, j, point, axis in self.cuts:
            ends = [(steps[k][0] @ point + steps[k][1], self.rates(steps, k)) for k in (i, j)]
            gaps.append(ends[0][0] - ends[1][0])
            slope = np.zeros((3, len(q)), dtype=object)
            for sign, (x, rates) in zip((1, -1), ends, strict=True):
                for k, (omega, v) in rates.items():
                    slope[:, k] += sign * (cross_matrix(omega) @ x + v)
            slopes.append(slope)
            if axis is None:
                continue
            first, second = (steps[k][0] @ axis for k in (i, j))
            gaps.append(cross_matrix(first) @ second)
            slope = np.zeros((3, len(q)), dtype=object)
            for k, (omega, _) in ends[0][1].items():
                slope[:, k] -= cross_matrix(second) @ cross_matrix(omega) @ first
            for k, (omega, _) in ends[1][1].items():
                slope[:, k] += cross_matrix(first) @ cross_matrix(omega) @ second
            slopes.append(slope)
        return np.concatenate(gaps), np.vstack(slopes)

    def rates(self, steps, link):
        """Twist (ω, v) that each joint below a link gives it, per unit rate."""
        found = {}
        while link >= 0:
            R, d = steps[self.parents[link]]
            n = R @ self.axes[link]
            if self.sliding[link]:
                found[link] = (exact("0 0 0"), n)
            else:
                found[link] = (n, cross_matrix(R @ self.points[link] + d) @ n)
            link = self.parents[link]
        return found

    def closed(self, inputs, u, start):
        """Joint positions that close the cuts at inputs u, and rates per input rate."""
        q = start.copy()
        q[inputs] = u
        others = [j for j in range(len(q)) if j not in inputs]
        for _ in range(12):
            gap, slope = self.residual(q)
            fix = solved(slope[:, others], -gap[:, None])[:, 0]
            q[others] += fix
            if max(abs(x) for x in fix) < mp.mpf(10) ** (10 - DIGITS):
                break
        gap, slope = self.residual(q)
        # Overconstrained loops close too: the geometry of the file is exact.
        assert max(abs(x) for x in gap) < mp.mpf(10) ** (12 - DIGITS)
        C = np.zeros((len(q), len(inputs)), dtype=object)
        C[inputs, range(len(inputs))] = mp.mpf(1)
        C[others] = solved(slope[:, others], -slope[:, inputs])
        return q, C

    def series(self, inputs, ray, order):
        """Coefficients of q (n, order + 2) and of C (order + 1, n, inputs) along u = t δ."""
        radius, q = mp.mpf(RADIUS), np.array([mp.mpf(0)] * len(self.joints), dtype=object)
        turns = [mp.expjpi(mp.mpf(2 * i) / SAMPLES) for i in range(SAMPLES)]
        circle = []
        # The points below the real axis are conjugate to those above it.
        for turn in turns[: SAMPLES // 2 + 1]:
            u = np.array([radius * turn * mp.mpf(x) for x in ray], dtype=object)
            q, C = self.closed(inputs, u, q)
            circle.append(np.column_stack([q, C]))
        circle += [np.conj(value) for value in circle[SAMPLES // 2 - 1 : 0 : -1]]
        found = []
        for k in range(order + 2):
            weights = [turns[-(i * k) % SAMPLES] for i in range(SAMPLES)]
            total = sum(w * value for w, value in zip(weights, circle, strict=True))
            found.append(np.vectorize(lambda x: float(x.real))(total / SAMPLES / radius**k))
        found = np.array(found)
        return found[:, :, 0], found[:-1, :, 1:]


def solved(A, B):
    """Least squares of a consistent system with full column rank, in high precision.

    The transpose, not the conjugate transpose: the solution is analytic in A.
    """
    n = A.shape[1]
    M = np.hstack([A.T @ A, A.T @ B])
    for k in range(n):
        pivot = k + int(np.argmax([float(abs(x)) for x in M[k:, k]]))
        M[[k, pivot]] = M[[pivot, k]]
        M[k] = M[k] / M[k, k]
        for i in range(n):
            if i != k:
                M[i] = M[i] - M[i, k] * M[k]
    return M[:, n:]
