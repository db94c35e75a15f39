"""Ranks of the balance conditions of a linkage with one loop, with 60 digits.

Power series along rays, with pseudo-inertias P that twists carry along: ``P' = T P + P Tᵀ``;
the momentum of a twist T is the skew part of ``T P``. Numbers are those of mpmath, so that
conditions of the size 1e-24, the square of an error of 1e-12, are told from round-off. Nothing
of the product is used.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from mpmath import matrix, mp, mpf

from tests.independent.meant_linkages import MeantLinkage, add, cross

ZERO = mpf("1e-40")


def _screw(joint):
    if joint.kind == "prismatic":
        return [mpf(0)] * 3 + list(joint.axis)
    return [*joint.axis, *cross(joint.point, joint.axis)]


def _bracket(V, s):
    w = cross(V[:3], s[:3])
    return [*w, *add(cross(V[:3], s[3:]), cross(V[3:], s[:3]))]


def _hat(V):
    a, b, c, x, y, z = V
    return matrix([[0, -c, b, x], [c, 0, -a, y], [-b, a, 0, z], [0, 0, 0, 0]])


def _reduce(rows, columns):
    """Row echelon form with complete pivoting: pivots, and the rows."""
    rows, pivots = [list(row) for row in rows], []
    free = list(range(columns))
    top = 0
    while top < len(rows) and free:
        size, r, c = max((abs(rows[r][c]), r, c) for r in range(top, len(rows)) for c in free)
        if size < ZERO:
            break
        rows[top], rows[r] = rows[r], rows[top]
        pivots.append(c)
        free.remove(c)
        for k in range(len(rows)):
            if k != top and rows[k][c]:
                f = rows[k][c] / rows[top][c]
                rows[k] = [x - f * y for x, y in zip(rows[k], rows[top], strict=True)]
        top += 1
    return pivots, rows


def _basis(planar):
    """Symmetric matrices that span the pseudo-inertias that count."""
    if planar:
        some = [{(3, 3): 1}, {(0, 3): 1}, {(1, 3): 1}, {(0, 0): 1, (1, 1): 1}]
    else:
        some = [{(i, j): 1} for i in range(4) for j in range(i, 4)]
    found = []
    for entries in some:
        P = matrix(4, 4)
        for (i, j), x in entries.items():
            P[i, j] = P[j, i] = mpf(x)
        found.append(P)
    return found


def true_ranks(linkage: MeantLinkage, planar: bool, plateau: int = 3):
    """Mobility, and ranks by order up to the last that adds a condition.

    Args:
        linkage: a linkage with one loop, which closes at its last joint.
        planar: whether planar parameters count.
        plateau: how many orders must add nothing.

    Returns:
        Mobility and ranks; ranks are None if the loop does not close at some order.
    """
    joints = linkage.joints
    carrier = {joint.after: k for k, joint in enumerate(joints) if not joint.loop}
    above = [carrier.get(joint.before, -1) for joint in joints]
    signs = [0] * len(joints)
    for side, last in ((1, len(joints) - 1), (-1, carrier.get(joints[-1].after, -1))):
        while last >= 0:
            signs[last] += side
            last = above[last]
    S0 = [[signs[j] * _screw(joint)[i] for j, joint in enumerate(joints)] for i in range(6)]
    dependent, _ = _reduce(S0, len(joints))
    free = [j for j in range(len(joints)) if j not in dependent]
    mobility, collected, ranks = len(free), [], []
    if not mobility:
        return 0, None
    bodies = [k for k, joint in enumerate(joints) if not joint.loop]
    rng = np.random.default_rng(7)
    rays = [[mpf(int(x)) for x in rng.integers(1, 99, mobility)] for _ in range(4)]
    runs = [_Run(joints, above, signs, dependent, free, ray, bodies, planar) for ray in rays]
    while len(ranks) < 12:
        k = len(ranks)
        for run in runs if mobility > 1 else runs[:1]:
            rows = run.extend(k)
            if rows is None:
                return mobility, None
            collected += rows
        size = max((abs(x) for row in collected for x in row), default=mpf(1))
        collected = [[x / size for x in row] for row in collected]
        pivots, rows = _reduce(collected, len(collected[0]))
        collected = rows[: len(pivots)]
        ranks.append(len(pivots))
        if len(ranks) > plateau and ranks[-1] == ranks[-1 - plateau]:
            break
    return mobility, ranks[: ranks.index(ranks[-1]) + 1]


class _Run:
    """Series along one ray."""

    def __init__(self, joints, above, signs, dependent, free, ray, bodies, planar):
        self.above, self.signs, self.dependent, self.free = above, signs, dependent, free
        self.ray, self.bodies, self.planar = ray, bodies, planar
        self.s = [[_screw(joint) for joint in joints]]
        self.C, self.V, self.T = [], [], []
        self.P = {
            (b, i): [P]
            for b, i in product(bodies, range(len(_basis(planar))))
            for P in [_basis(planar)[i]]
        }

    def extend(self, k):
        """Rows of the conditions of order k; None if the loop does not close."""
        n, w = len(self.above), len(self.free)
        if k:
            s = []
            for j, parent in enumerate(self.above):
                total = [mpf(0)] * 6
                for a in range(k if parent >= 0 else 0):
                    total = add(total, _bracket(self.V[a][parent], self.s[k - 1 - a][j]))
                s.append([x / k for x in total])
            self.s.append(s)
        C = [[mpf(0)] * w for _ in range(n)]
        for column in range(w):
            if k == 0:
                C[self.free[column]][column] = mpf(1)
            right = [mpf(0)] * 6
            for a in range(k + 1):
                known = C if a == 0 else self.C[k - a]
                for j in range(n):
                    if self.signs[j] and known[j][column]:
                        right = add(right, self.s[a][j], -self.signs[j] * known[j][column])
            rows = [
                [self.signs[j] * self.s[0][j][i] for j in self.dependent] + [right[i]]
                for i in range(6)
            ]
            pivots, rows = _reduce(rows, len(self.dependent))
            if any(abs(row[-1]) > mpf("1e-35") for row in rows[len(pivots) :]):
                return None
            for row, c in zip(rows, pivots, strict=False):
                C[self.dependent[c]][column] = row[-1] / row[c]
        self.C.append(C)
        self._move(k)
        for key, series in self.P.items():
            if k:
                total = matrix(4, 4)
                for a in range(k):
                    A = _hat(self.V[a][key[0]])
                    total += A * series[k - 1 - a] + series[k - 1 - a] * A.T
                series.append(total / k)
        return self._rows(k)

    def _move(self, k):
        """Twists of the links at order k, for each column and along the ray."""
        n, w = len(self.above), len(self.free)
        T = [[None] * w for _ in range(n)]
        for j in range(n):
            for column in range(w):
                t = T[self.above[j]][column] if self.above[j] >= 0 else [mpf(0)] * 6
                for a in range(k + 1):
                    t = add(t, self.s[a][j], self.C[k - a][j][column])
                T[j][column] = t
        self.T.append(T)
        V = []
        for j in range(n):
            total = [mpf(0)] * 6
            for column in range(w):
                total = add(total, T[j][column], self.ray[column])
            V.append(total)
        self.V.append(V)

    def _rows(self, k):
        """Momentum of unit parameters at order k."""
        places = (
            [(0, 1), (0, 3), (1, 3)]
            if self.planar
            else [
                (0, 1),
                (0, 2),
                (1, 2),
                (0, 3),
                (1, 3),
                (2, 3),
            ]
        )
        rows = []
        for column in range(len(self.free)):
            momenta = []
            for b, i in self.P:
                total = matrix(4, 4)
                for a in range(k + 1):
                    total += _hat(self.T[a][b][column]) * self.P[b, i][k - a]
                momenta.append(total - total.T)
            rows += [[M[i, j] for M in momenta] for i, j in places]
        return rows


mp.dps = 60
