"""The planar 4-RRR of the IFToMM paper of 2011: its geometry, and its printed conditions.

The joints of the platform are the corners of a rectangle with the half-widths c and d:
C1 (+, -), C2 (-, -), C3 (-, +), C4 (+, +). Link i1 goes from Ai to Bi, link i2 from Bi to
Ci. The centre of mass of link ij lies at p along the link and q across it, that of the
platform at p5, q5 from the centre. The equations are those of the paper, typed anew.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.support.urdf_text import UNIT_INERTIA, along, joint, link, loop

Z = [0.0, 0.0, 1.0]
CORNERS = np.array([(1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)])
# Bodies in the order of the columns of every matrix here, three parameters each.
BODIES = (*(f"lower{i}" for i in range(1, 5)), *(f"upper{i}" for i in range(1, 5)), "platform")


@dataclass(frozen=True)
class Geometry:
    """Base pivots, lengths (lower, upper) and elbow signs of the legs, in metres."""

    base: tuple[tuple[float, float], ...]
    lengths: tuple[tuple[float, float], ...]
    elbows: tuple[int, int, int, int] = (1, -1, 1, -1)
    centre: tuple[float, float] = (0.02, 0.03)
    half: tuple[float, float] = (0.15, 0.10)

    @property
    def points(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Base pivots, elbows and platform joints; (4, 2) each."""
        A, C = np.array(self.base), np.array(self.centre) + CORNERS * self.half
        l1, l2 = np.array(self.lengths).T
        d = C - A
        r = np.hypot(*d.T)
        along_leg = (l1**2 - l2**2 + r**2) / (2.0 * r)
        across = np.array(self.elbows) * np.sqrt(l1**2 - along_leg**2)
        n = np.stack([-d[:, 1], d[:, 0]], axis=1)
        return A, A + (along_leg / r)[:, None] * d + (across / r)[:, None] * n, C

    def text(self) -> str:
        """The linkage as URDF, driven by the joints of leg 1."""
        A, B, C = (np.pad(points, [(0, 0), (0, 1)]) for points in self.points)
        marks = 'independent="true"'
        parts = [link("base"), *(link(name, **UNIT_INERTIA) for name in BODIES)]
        for i in range(4):
            k, m = i + 1, marks if i == 0 else ""
            ends = (("base", f"lower{k}"), (f"lower{k}", f"upper{k}"))
            for name, (parent, child), step in zip(
                "ab", ends, (A[i], B[i] - A[i]), strict=True
            ):
                at = along(step)
                parts.append(joint(f"{name}{k}", "continuous", parent, child, at, Z, marks=m))
            frames = along(C[i] - B[i]), along(C[i] - C[0])
            ends = (f"upper{k}", "platform")
            if i == 0:
                parts.append(joint("c1", "continuous", *ends, frames[0], Z, marks=m))
            else:
                parts.append(loop(f"c{k}", "revolute", ends, frames, Z))
        return f'<robot name="paper">{"".join(parts)}</robot>'


# The linkages of the table: two pairs of parallel legs, one pair, none.
CROSSED = Geometry(
    ((0.55, -0.12), (-0.5, -0.15), (-0.5, 0.05), (0.55, 0.08)),
    ((0.40, 0.50), (0.45, 0.38), (0.38, 0.45), (0.50, 0.40)),
)
SIDE_BY_SIDE = Geometry(
    CROSSED.base,
    ((0.40, 0.50), (0.45, 0.38), (0.45, 0.38), (0.40, 0.50)),
    (1, -1, -1, 1),
)
PAIR = Geometry(
    ((0.55, -0.12), (-0.5, -0.15), (-0.62, 0.2), (0.55, 0.08)),
    ((0.40, 0.50), (0.45, 0.38), (0.50, 0.40), (0.50, 0.40)),
)
GENERAL = Geometry(
    ((0.55, -0.12), (-0.5, -0.15), (-0.62, 0.2), (0.6, 0.11)),
    ((0.40, 0.50), (0.45, 0.38), (0.50, 0.40), (0.47, 0.42)),
)


class Terms:
    """The quantities of the printed conditions, as rows over ``[m, mcx, mcy]`` of 9 bodies.

    ``m(i, j)``, ``p(i, j)``, ``q(i, j)`` are m, m p and m q of link ij; ``m5, p5, q5`` those
    of the platform.
    """

    def __init__(self, points: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
        """Rows at the pose with these base pivots, elbows and platform joints."""
        self.points = points
        centre = points[2].mean(axis=0)
        self.m5, self.p5, self.q5 = self._rows(8, centre, np.array([1.0, 0.0]))
        self.c, self.d = np.abs(points[2] - centre).max(axis=0)
        self.U = self.c / self.d + self.d / self.c

    @staticmethod
    def _rows(body: int, start: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Mass, and the mass moment about ``start`` along x and across; (3, 27)."""
        y = np.array([-x[1], x[0]])
        rows = np.zeros((3, 27))
        rows[:, 3 * body : 3 * body + 3] = [[1, 0, 0], [-x @ start, *x], [-y @ start, *y]]
        return rows

    def link(self, i: int, j: int) -> np.ndarray:
        """Rows m, m p, m q of link ij, numbered from 1 as in the paper."""
        start, end = self.points[j - 1][i - 1], self.points[j][i - 1]
        x = (end - start) / np.hypot(*(end - start))
        return self._rows(i - 1 + 4 * (j - 1), start, x)

    def length(self, i: int, j: int) -> float:
        """Length of link ij."""
        return float(np.hypot(*(self.points[j][i - 1] - self.points[j - 1][i - 1])))


def equation_17(points: tuple[np.ndarray, np.ndarray, np.ndarray]) -> dict[str, np.ndarray]:
    """The twelve general conditions, by the link and the component they begin with."""
    t = Terms(points)
    c, d, U = t.c, t.d, t.U
    (_, p12, q12), (_, p32, q32) = t.link(1, 2), t.link(3, 2)
    l12, l32 = t.length(1, 2), t.length(3, 2)
    # Masses of the platform at its joints, by Eqs. 5 to 7.
    one_less_three = (t.p5 / c - t.q5 / d) / 2.0
    two_and_three = (t.m5 - t.p5 / c) / 2.0
    four_and_three = (t.m5 + t.q5 / d) / 2.0
    found = {}
    for i, (p, q, far) in {1: (p12, q12, l12), 3: (p32, q32, l32)}.items():
        (_, own_p, own_q), length, (mass, _, _) = t.link(i, 1), t.length(i, 1), t.link(i, 2)
        found[f"p{i}1"] = own_p + length * (mass - p / far)
        found[f"q{i}1"] = own_q - length / far * q
    sides = {2: (1.0, d / c, two_and_three), 4: (-1.0, c / d, four_and_three)}
    for i, (s, ratio, pair) in sides.items():
        for j in (1, 2):
            _, own_p, own_q = t.link(i, j)
            mass = t.link(i, 2)[0] if j == 1 else 0.0 * own_p
            along_link = mass + own_p / t.length(i, j)
            along_link = along_link + (ratio * p12 - s * q12) / (U * l12)
            along_link = along_link + p32 / l32 + (s * q32 - ratio * p32) / (U * l32)
            found[f"p{i}{j}"] = t.length(i, j) * (
                along_link + ratio / U * one_less_three + pair
            )
            across = own_q / t.length(i, j) + (s * p12 + ratio * q12) / (U * l12)
            across = across + q32 / l32 - (s * p32 + ratio * q32) / (U * l32)
            found[f"q{i}{j}"] = t.length(i, j) * (across + s / U * one_less_three)
    return found


def combined(conditions: dict[str, np.ndarray], pairs: dict[str, str]) -> np.ndarray:
    """Conditions with those of paired links added up, as in Eqs. 19 and 21; (8, 27).

    The links of a pair turn alike; ``pairs`` takes the second to the first.
    """
    total: dict[str, np.ndarray] = {}
    for name, row in conditions.items():
        key = name[0] + pairs.get(name[1:], name[1:])
        total[key] = total.get(key, 0.0) + row
    return np.array(list(total.values()))


def leg_by_leg(points: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Eqs. 8 to 11: sixteen conditions on the links and four masses of the platform.

    Returns:
        Shape (16, 28): over ``[m, mcx, mcy]`` of 8 links, then the masses at C1 … C4.
    """
    t, rows = Terms(points), []
    for i in range(1, 5):
        (_, p1, q1), (m2, p2, q2) = t.link(i, 1), t.link(i, 2)
        l1, l2 = t.length(i, 1), t.length(i, 2)
        share = np.eye(4)[i - 1]
        none = np.zeros(4)
        terms: list[tuple[np.ndarray, np.ndarray]] = [
            (q1, none),
            (q2, none),
            (p1 + l1 * m2, l1 * share),
            (p2, l2 * share),
        ]
        rows += [np.append(row[:24], tail) for row, tail in terms]
    return np.array(rows)


def gathered(points: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """The map from the 28 unknowns of `leg_by_leg` to the 27 parameters; (27, 28)."""
    total = np.zeros((27, 28))
    total[:24, :24] = np.eye(24)
    total[24:, 24:] = np.vstack([np.ones(4), points[2].T])
    return total
