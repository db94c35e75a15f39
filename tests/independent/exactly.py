"""The conditions of balance in rational numbers, by routes that share nothing with the product.

A planar four-bar by cosines and sines of its links; any chain by screws that the adjoint of
a displacement carries, and by pseudo-inertias that a displacement carries. Series are lists
of coefficients. Slow: for small linkages and low orders.
"""

from fractions import Fraction

import numpy as np

SECOND = {4: (0, 0), 5: (1, 1), 6: (2, 2), 7: (0, 1), 8: (0, 2), 9: (1, 2)}


def modulo(x, p):
    """A rational number modulo a prime."""
    return x.numerator * pow(x.denominator, -1, p) % p


def determinant(matrix, p):
    """Determinant of a matrix of whole numbers modulo a prime."""
    rows = [[x % p for x in row] for row in matrix]
    total = 1
    while rows:
        row = next((row for row in rows if row[0]), None)
        if row is None:
            return 0
        total = total * row[0] * (-1) ** rows.index(row) % p
        rows.remove(row)
        inverse = pow(row[0], -1, p)
        rows = [
            [(x - other[0] * inverse * y) % p for x, y in zip(other[1:], row[1:], strict=True)]
            for other in rows
        ]
    return total


def solved(A, b):
    """Solution of ``A x = b`` with independent columns, exactly; it must be consistent."""
    rows = [[*row, y] for row, y in zip(A.tolist(), b, strict=True)]
    unknowns = A.shape[1]
    for c in range(unknowns):
        pivot = next(i for i in range(c, len(rows)) if rows[i][c])
        rows[c], rows[pivot] = rows[pivot], [x / rows[pivot][c] for x in rows[c]]
        rows[c] = [x / rows[c][c] for x in rows[c]]
        for i, row in enumerate(rows):
            if i != c and row[c]:
                rows[i] = [x - row[c] * y for x, y in zip(row, rows[c], strict=True)]
    assert not any(row[-1] for row in rows[unknowns:])
    return [row[-1] for row in rows[:unknowns]]


def fractions(array):
    """An array of rational numbers."""
    return np.vectorize(Fraction, otypes=[object])(array)


def product(a, b, k, times=np.multiply):
    """Coefficient k of the product of two series."""
    return sum(times(a[i], b[k - i]) for i in range(k + 1))


class Planar4R:
    """Crank, coupler and rocker between pivots o1 … o4; the crank turns at unit rate."""

    def __init__(self, o1, o2, o3, o4):
        self.pivots = [np.array(o, dtype=object) for o in (o1, o2, o4)]
        self.arms = [
            np.array([x - y for x, y in zip(b, a, strict=True)], dtype=object)
            for a, b in ((o1, o2), (o2, o3), (o4, o3))
        ]

    def _angles(self, order):
        """Rates of the links, and cosines and sines of their angles, order by order."""
        rates = [[], [], []]
        c, s = [[[Fraction(1)] for _ in range(3)], [[Fraction(0)] for _ in range(3)]]
        for k in range(order + 1):
            rates[0].append(Fraction(int(k == 0)))
            if k:
                for i in range(3):
                    c[i].append(-product(s[i], rates[i], k - 1) / k)
                    s[i].append(product(c[i], rates[i], k - 1) / k)
            # Velocity of o3, from both sides, without the unknown rates of order k.
            sides = []
            for i in range(3):
                turned = [self._across(c[i][a], s[i][a], self.arms[i]) for a in range(k + 1)]
                known = rates[i] + [Fraction(0)] * (k + 1 - len(rates[i]))
                sides.append(sum(known[a] * turned[k - a] for a in range(k + 1)))
            A = np.array(
                [
                    self._across(Fraction(1), Fraction(0), self.arms[1]),
                    -self._across(Fraction(1), Fraction(0), self.arms[2]),
                ]
            ).T
            found = solved(A, (sides[2] - sides[0] - sides[1]).tolist())
            rates[1].append(found[0])
            rates[2].append(found[1])
        return rates, c, s

    @staticmethod
    def _across(c, s, a):
        """``J R a``."""
        return np.array([-s * a[0] - c * a[1], c * a[0] - s * a[1]], dtype=object)

    def rows(self, order):
        """Coefficients of the rows ``[ξ, px, py]``; (order + 1, 3, 12)."""
        rates, c, s = self._angles(order)
        found = [[[] for _ in range(3)] for _ in range(order + 1)]
        for i in range(3):
            R = [
                np.array([[c[i][k], -s[i][k]], [s[i][k], c[i][k]]], dtype=object)
                for k in range(order + 1)
            ]
            J = np.array([[0, -1], [1, 0]], dtype=object)
            N = [product(rates[i], [J @ r for r in R], k) for k in range(order + 1)]
            d = [-r @ self.pivots[i] for r in R]
            e = [-n @ self.pivots[i] for n in N]
            # The coupler turns about o2, which the crank carries about o1.
            d[0] = d[0] + self.pivots[0 if i == 1 else i]
            if i == 1:
                for k in range(order + 1):
                    crank = np.array([[c[0][k], -s[0][k]], [s[0][k], c[0][k]]], dtype=object)
                    d[k] = d[k] + crank @ self.arms[0]
                    e[k] = e[k] + sum(
                        rates[0][a] * self._across(c[0][k - a], s[0][k - a], self.arms[0])
                        for a in range(k + 1)
                    )
            for k in range(order + 1):
                moments = [
                    product([r[:, a] for r in R], e, k, self._moment)
                    + product(d, [n[:, a] for n in N], k, self._moment)
                    for a in range(2)
                ]
                found[k][0] += [product(d, e, k, self._moment), *moments, rates[i][k]]
                for row in range(2):
                    found[k][1 + row] += [e[k][row], N[k][row, 0], N[k][row, 1], Fraction(0)]
        return found

    @staticmethod
    def _moment(a, b):
        return a[0] * b[1] - a[1] * b[0]


def hat(t):
    """The 4×4 matrix of a twist."""
    zero = Fraction(0)
    return np.array(
        [
            [zero, -t[2], t[1], t[3]],
            [t[2], zero, -t[0], t[4]],
            [-t[1], t[0], zero, t[5]],
            [zero] * 4,
        ],
        dtype=object,
    )


def vee(M):
    """The twist of a 4×4 matrix."""
    return np.array([M[2, 1], M[0, 2], M[1, 0], *M[:3, 3]], dtype=object)


class Series:
    """A chain that moves along one ray."""

    def __init__(self, chain, ray, order):
        self.chain, self.ray, self.order = chain, ray, order
        n = len(chain.parent)
        assert not chain.mimics
        self.H = [[fractions(np.eye(4, dtype=int))] for _ in range(n)]
        self.G = [[fractions(np.eye(4, dtype=int))] for _ in range(n)]  # inverses of H
        self.S = [[] for _ in range(n)]
        self.C = [[] for _ in range(n)]
        self.T = [[] for _ in range(n)]  # twists for unit rates, (w, 6) per order
        for k in range(order + 1):
            self._extend(k)

    def _extend(self, k):
        """All quantities of order k."""
        chain, width = self.chain, self.chain.width
        for j, parent in enumerate(chain.parent):
            s = hat(chain.screws[j])
            if parent >= 0:
                H, G = self.H[parent], self.G[parent]
                carried = sum(H[a] @ s @ G[k - a] for a in range(k + 1))
            else:
                carried = s if k == 0 else 0 * s
            self.S[j].append(vee(carried))
            self.C[j].append([x if k == 0 else Fraction(0) for x in chain.columns[j]])
        self._twists(k)
        if chain.ends:
            A = np.concatenate(
                [
                    np.array([self._sign(j, *ends) * self.S[j][0] for j in chain.dependent]).T
                    for ends in chain.ends
                ]
            )
            for w in range(width):
                gap = [-self._twist(e, k)[w] + self._twist(f, k)[w] for e, f in chain.ends]
                found = solved(A, np.concatenate(gap).tolist())
                for j, x in zip(chain.dependent, found, strict=True):
                    self.C[j][k][w] = x
            for T in self.T:
                T.pop()
            self._twists(k)
        for j in range(len(chain.parent)):
            V = [hat(sum(r * t for r, t in zip(self.ray, T, strict=True))) for T in self.T[j]]
            self.H[j].append(product(V, self.H[j], k, np.matmul) / Fraction(k + 1))
            self.G[j].append(-product(self.G[j], V, k, np.matmul) / Fraction(k + 1))

    def _twists(self, k):
        for j, parent in enumerate(self.chain.parent):
            own = [
                sum(self.C[j][a][w] * self.S[j][k - a] for a in range(k + 1))
                for w in range(self.chain.width)
            ]
            self.T[j].append(np.array(own) + self._twist(parent, k))

    def _twist(self, link, k):
        return self.T[link][k] if link >= 0 else fractions(np.zeros((self.chain.width, 6), int))

    def _sign(self, joint, end, successor):
        """1 if the joint carries the end of a loop, -1 if its successor, 0 if both or none."""
        total = 0
        for link, sign in ((end, 1), (successor, -1)):
            while link >= 0:
                total += sign * (link == joint)
                link = self.chain.parent[link]
        return total

    def rows(self):
        """Coefficients of all rows; (order + 1, w, 6, 10 bodies)."""
        blocks = [self._body(link) for link in self.chain.links]
        return np.concatenate(blocks, axis=-1)

    def _body(self, link):
        found = fractions(np.zeros((self.order + 1, self.chain.width, 6, 10), int))
        H, T = self.H[link], self.T[link]
        for parameter in range(10):
            P = pseudo_inertia(parameter)
            carried = [
                sum(H[a] @ P @ H[k - a].T for a in range(k + 1)) for k in range(self.order + 1)
            ]
            for k in range(self.order + 1):
                for a in range(k + 1):
                    for w in range(self.chain.width):
                        found[k, w, :, parameter] += momentum(carried[a], T[k - a][w])
        return found


def pseudo_inertia(parameter):
    """The 4×4 matrix of a body of which one of the ten parameters is 1."""
    P = fractions(np.zeros((4, 4), int))
    if parameter == 0:
        P[3, 3] = Fraction(1)
    elif parameter < 4:
        P[parameter - 1, 3] = P[3, parameter - 1] = Fraction(1)
    else:
        i, j = SECOND[parameter]
        for a in range(3):
            P[a, a] += Fraction(int(i == j), 2)
        for a, b in {(i, j), (j, i)}:
            P[a, b] -= Fraction(1)
    return P


def momentum(P, t):
    """``[E ω + mc × v; m v - mc × ω]`` for a pseudo-inertia and a twist."""
    E = -P[:3, :3]
    for a in range(3):
        E[a, a] = E[a, a] + P[0, 0] + P[1, 1] + P[2, 2]
    mc, m, w, v = P[:3, 3], P[3, 3], t[:3], t[3:]
    return np.concatenate([E @ w + np.cross(mc, v), m * v - np.cross(mc, w)])


def coupled(number, seed=1):
    """URDF of coupled planar four-bars: each rocker drives the next, at random pivots."""
    rng = np.random.default_rng(seed)
    off = rng.uniform(-1, 1, (number + 1, 6))
    ground = [(2 * k + 0.3 * x[0], 0.3 * x[1]) for k, x in enumerate(off)]
    driving = [
        (g[0] + 0.4 * x[2], g[1] + 1.2 + 0.3 * x[3]) for g, x in zip(ground, off, strict=True)
    ]
    driven = [
        (g[0] + 0.4 * x[4], g[1] + 1.2 + 0.3 * x[5]) for g, x in zip(ground, off, strict=True)
    ]
    ground, driving, driven = (np.round(p, 3) for p in (ground, driving, driven))
    body = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial>"
    )

    def origin(p, q):
        return f'<origin xyz="{p[0] - q[0]:.3f} {p[1] - q[1]:.3f} 0"/>'

    def joint(name, parent, child, place, mark=""):
        return (
            f'<joint name="{name}" type="continuous"{mark}><parent link="{parent}"/>'
            f'<child link="{child}"/>{place}<axis xyz="0 0 1"/></joint>'
        )

    links = ["r0"] + [f"{kind}{k}" for k in range(1, number + 1) for kind in "rc"]
    parts = ['<link name="base"/>', *(f'<link name="{name}">{body}</link>' for name in links)]
    parts.append(joint("j0", "base", "r0", origin(ground[0], (0, 0)), ' independent="true"'))
    for k in range(1, number + 1):
        parts.append(joint(f"j{k}", "base", f"r{k}", origin(ground[k], (0, 0))))
        place = origin(driving[k - 1], ground[k - 1])
        parts.append(joint(f"a{k}", f"r{k - 1}", f"c{k}", place))
        parts.append(
            f'<loop name="b{k}" type="revolute"><axis xyz="0 0 1"/>'
            f'<predecessor link="c{k}">{origin(driven[k], driving[k - 1])}</predecessor>'
            f'<successor link="r{k}">{origin(driven[k], ground[k])}</successor></loop>'
        )
    return f'<robot name="chain">{"".join(parts)}</robot>'
