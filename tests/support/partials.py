"""Mixed partial derivatives from differences of finite poses, in 120 digits.

The loops are closed at the points of a grid with a step of 1e-15, where differences of order
k lose 15 k digits and leave an error of about 1e-15.
"""

from __future__ import annotations

from itertools import product
from math import comb, factorial

import numpy as np
from mpmath import mp

import kinematics
from tests.independent.high_precision_motion import Exact, cross_matrix, solved

DIGITS, STEP = 110, "1e-15"


def multi_indices(width, order):
    """All multi-indices of at most this order."""
    every = product(range(order + 1), repeat=width)
    return [alpha for alpha in every if sum(alpha) <= order]


class Grid:
    """Closed poses of a linkage of the gallery on a grid of inputs, in high precision.

    Attributes:
        linkage: the linkage as loaded.
        joints: names of the joints of the tree.
        q: their positions by grid point.
        model: the linkage.
    """

    def __init__(self, name, order):
        self.linkage = kinematics.load(name)
        inputs = self.linkage.inputs
        with mp.workdps(DIGITS):
            self.model = Exact(kinematics.gallery()[name])
            self.joints = self.model.joints
            at = [self.joints.index(x) for x in inputs]
            self.others = [j for j in range(len(self.joints)) if j not in at]
            zero = np.array([mp.mpf(0)] * len(self.joints), dtype=object)
            slope = self.model.residual(zero)[1]
            rows = np.eye(len(slope), dtype=object) * mp.mpf(1)
            self.inverse = solved(slope[:, self.others], rows)
            self.q = {}
            for beta in multi_indices(len(inputs), order):
                q = zero.copy()
                q[at] = [mp.mpf(STEP) * b for b in beta]
                self.q[beta] = self.closed(q)

    def gaps(self, q):
        """How far the cuts are open."""
        steps, found = self.model.placed(q), []
        for i, j, point, axis in self.model.cuts:
            (R, d), (Q, e) = steps[i], steps[j]
            found.append(R @ point + d - Q @ point - e)
            if axis is not None:
                found.append(cross_matrix(R @ axis) @ (Q @ axis))
        return np.concatenate(found)

    def closed(self, q):
        """The dependent joints, by steps with the slope at the reference pose."""
        for _ in range(12):
            change = self.inverse @ self.gaps(q)
            q[self.others] -= change
            if max(abs(x) for x in change) < mp.mpf(10) ** (3 - DIGITS):
                return q
        raise AssertionError("not closed")

    def placed(self):
        """Rotation and translation of every link, by grid point."""
        with mp.workdps(DIGITS):
            return {beta: self.model.placed(q) for beta, q in self.q.items()}

    def derivatives(self, values, alpha):
        """``∂^α`` of what has these values (arrays of numbers) on the grid, as floats."""
        with mp.workdps(DIGITS):
            total = 0
            for beta in product(*(range(a + 1) for a in alpha)):
                weight = (-1) ** (sum(alpha) - sum(beta))
                for a, b in zip(alpha, beta, strict=True):
                    weight *= comb(a, b)
                total = total + weight * values[beta]
            scale = mp.mpf(STEP) ** -sum(alpha)
            return np.vectorize(lambda x: float(x * scale), otypes=[float])(total)


def factorials(alpha):
    """``α!``"""
    return float(np.prod([factorial(a) for a in alpha]))
