"""Series of the motion of a spatial linkage, and of its conditions of balance, modulo a prime.

The twist of a part is ``(ω; v) = Σ_j V_j ξ_j`` over the screws ``ξ = (n; o × n)`` of the joints
that carry it; ``Ṙ = ω × R`` and ``Ȯ = v + ω × O``. A loop is ``Σ_j V_j ξ_j = 0``, order by
order: ``A_0 V_k = -Σ_a A_a V_{k-a}``.

Force balance: ``Σ_b m O + R s`` is constant. Dynamic balance: so is
``Σ_b O × (m O + R s)˙ + R s × Ȯ + R J Rᵀ ω``.
"""

from __future__ import annotations

from collections.abc import Sequence

from balance.space.formulas.rate_relations import RateRelation
from balance.space.formulas.spatial_parts import SpatialParts
from balance.space.formulas.spatial_pose import (
    ModularFrame,
    ModularVector,
    SpatialPose,
    modular_cross,
)
from kinematics.numerics.linalg.prime_field import invert_modulo

VectorSeries = list[ModularVector]
# Axes of the elements of an inertia tensor, in the order of the parameters.
ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
ZERO: ModularVector = (0, 0, 0)


def _add(a: ModularVector, b: ModularVector, p: int) -> ModularVector:
    return (a[0] + b[0]) % p, (a[1] + b[1]) % p, (a[2] + b[2]) % p


def _scaled(a: ModularVector, x: int, p: int) -> ModularVector:
    return a[0] * x % p, a[1] * x % p, a[2] * x % p


def _crossed(
    A: Sequence[ModularVector], B: Sequence[ModularVector], k: int, p: int
) -> ModularVector:
    """Compute order k of a vector product of series."""
    x = y = z = 0
    for a in range(k + 1):
        (f, g, h), (u, v, w) = A[a], B[k - a]
        x += g * w - h * v
        y += h * u - f * w
        z += f * v - g * u
    return x % p, y % p, z % p


def _dotted(A: Sequence[ModularVector], B: Sequence[ModularVector], p: int) -> list[int]:
    """Compute the scalar product of series."""
    return [
        sum(
            x * u + y * v + z * w
            for (x, y, z), (u, v, w) in zip(A[: k + 1], reversed(B[: k + 1]), strict=True)
        )
        % p
        for k in range(len(A))
    ]


def _times(A: Sequence[ModularVector], d: Sequence[int], p: int) -> VectorSeries:
    """Compute the product of a vector and a number as series."""
    out = []
    for k in range(len(A)):
        x = y = z = 0
        for (u, v, w), e in zip(A[: k + 1], reversed(d[: k + 1]), strict=True):
            x += u * e
            y += v * e
            z += w * e
        out.append((x % p, y % p, z % p))
    return out


class SpatialMotion:
    """The motion of a spatial linkage away from a pose.

    Attributes:
        columns: indices of the rates that are free.
    """

    def __init__(
        self, parts: SpatialParts, pose: SpatialPose, p: int, related: bool = True
    ) -> None:
        """Choose dependent rates, and independent rows.

        Args:
            parts: the linkage.
            pose: from which it moves.
            p: the modulus.
            related: whether the motion obeys the relations of the inputs.
        """
        self.parts, self.pose, self.p = parts, pose, p
        # Rate of a joint: its part, its axis there, and whether it slides.
        self.rates: list[tuple[int, int, bool]] = []
        self.path: list[list[int]] = [[]]
        self.closing: list[int] = []
        self.first: list[int] = []
        for joint in parts.joints:
            base, part = joint.parts
            several = (0, 1, 2) if joint.kind == "spherical" else (2,)
            rates = list(range(len(self.rates), len(self.rates) + len(several)))
            self.first.append(len(self.rates))
            self.rates += [(part, axis, joint.kind == "prismatic") for axis in several]
            if part:
                self.path.append([*self.path[base], *rates])
            else:
                self.closing = [*self.path[base], *rates]
        size = len(self.rates)
        self.rows: list[int] = []
        self.dependent: list[int] = []
        self.inverse: list[list[int]] = []
        A: list[list[int]] = []
        if parts.closed:
            screws = [self._screw(v, [pose.parts], 0) for v in range(size)]
            A = [[(w + u)[r] for w, u in screws] for r in range(6)]
        # Relations are constant: they add rows of order 0 after those of the loop.
        self.related = [self._related(row) for row in parts.relations] if related else []
        A += self.related
        if A:
            self.rows, self.dependent, self.inverse = invert_modulo(A, size, p)
        self.columns = [v for v in range(size) if v not in self.dependent]

    def _related(self, relation: RateRelation) -> list[int]:
        """Write a relation of joints as a row on the rates."""
        row = [0] * len(self.rates)
        for k, c in relation.items():
            row[self.first[k]] = c.numerator * pow(c.denominator, -1, self.p) % self.p
        return row

    def closing_step(self, gap: Sequence[int]) -> list[int]:
        """Compute rates of the dependent joints that remove a small gap of the loop."""
        step = [0] * len(self.rates)
        for r, v in enumerate(self.dependent):
            pairs = zip(self.inverse[r], (gap[row] for row in self.rows), strict=True)
            step[v] = -sum(x * y for x, y in pairs) % self.p
        return step

    def _screw(
        self, v: int, frames: Sequence[Sequence[ModularFrame]], k: int
    ) -> tuple[ModularVector, ModularVector]:
        """Compute order k of the screw of a rate; frames are by order, then by part."""
        part, axis, slides = self.rates[v]
        if not part:
            if k:
                return ZERO, ZERO
            last = self.pose.last
            assert last is not None
            n, moment = last[axis], modular_cross(last.o, last[axis], self.p)
        else:
            n = frames[k][part][axis]
            if slides:
                return ZERO, n
            x = y = z = 0
            for a in range(k + 1):
                f, g, h = frames[a][part].o
                q, r, s = frames[k - a][part][axis]
                x += g * s - h * r
                y += h * q - f * s
                z += f * r - g * q
            moment = x % self.p, y % self.p, z % self.p
        return (ZERO, n) if slides else (n, moment)

    def rows_along(
        self, ray: Sequence[int], order: int, bodies: Sequence[int], force: bool
    ) -> list[list[int]]:
        """Compute conditions of balance along a ray of the columns, up to an order.

        Columns are those of `Parameter`, by kind and then by body.
        """
        p, size = self.p, len(self.rates)
        frames: list[tuple[ModularFrame, ...]] = [self.pose.parts]
        screws: list[list[tuple[ModularVector, ModularVector]]] = []
        V: list[list[list[int]]] = [[] for _ in self.columns]
        whole: list[list[int]] = []
        for k in range(order + 1):
            screws.append([self._screw(v, frames, k) for v in range(size)])
            for w, column in enumerate(self.columns):
                V[w].append(self._next_rates(screws, V[w], column if k == 0 else -1))
            whole.append(
                [sum(d * V[w][k][v] for w, d in enumerate(ray)) % p for v in range(size)]
            )
            if k < order:
                frames.append(self._next_frames(frames, screws, whole, k))
        out: list[list[int]] = []
        series = [
            [[frame[part][axis] for frame in frames] for axis in range(4)]
            for part in range(len(self.parts.parts))
        ]
        for rates in V:
            twists = self._twists(screws, rates)
            columns = [_body_columns(series[b], *twists[b], force, p) for b in bodies]
            kinds = len(columns[0])
            ordered = [columns[b][kind] for kind in range(kinds) for b in range(len(bodies))]
            out += [list(row) for row in zip(*ordered, strict=True)]
        return [row for row in out if any(row)]

    def _twists(
        self,
        screws: Sequence[Sequence[tuple[ModularVector, ModularVector]]],
        rates: Sequence[Sequence[int]],
    ) -> list[tuple[VectorSeries, VectorSeries]]:
        """Compute the twists of all parts as series."""
        return [
            (
                [self._sum(screws, rates, path, k, 0) for k in range(len(rates))],
                [self._sum(screws, rates, path, k, 1) for k in range(len(rates))],
            )
            for path in self.path
        ]

    def _sum(
        self,
        screws: Sequence[Sequence[tuple[ModularVector, ModularVector]]],
        rates: Sequence[Sequence[int]],
        path: Sequence[int],
        k: int,
        side: int,
    ) -> ModularVector:
        """Compute order k of ``Σ_j V_j n_j``, or of the moments (side 1), along a path."""
        x = y = z = 0
        for a in range(k + 1):
            values = rates[k - a]
            for v in path:
                if rate := values[v]:
                    f, g, h = screws[a][v][side]
                    x += rate * f
                    y += rate * g
                    z += rate * h
        return x % self.p, y % self.p, z % self.p

    def _next_rates(
        self,
        screws: Sequence[Sequence[tuple[ModularVector, ModularVector]]],
        V: Sequence[list[int]],
        free: int,
    ) -> list[int]:
        """Solve for the rates of the next order; ``free`` is a column that moves at rate 1."""
        p, size, k = self.p, len(self.rates), len(V)
        rates = [0] * size
        if free >= 0:
            rates[free] = 1
        if not self.rows:
            return rates
        if free >= 0:
            total = screws[0][free]
        else:
            known = [*V, [0] * size]
            total = (
                self._sum(screws, known, self.closing, k, 0),
                self._sum(screws, known, self.closing, k, 1),
            )
        known_sums = [*total[0], *total[1]] if self.parts.closed else []
        known_sums += [row[free] if free >= 0 else 0 for row in self.related]
        sums = [known_sums[r] for r in self.rows]
        for r, v in enumerate(self.dependent):
            rates[v] = -sum(x * y for x, y in zip(self.inverse[r], sums, strict=True)) % p
        return rates

    def _next_frames(
        self,
        frames: Sequence[tuple[ModularFrame, ...]],
        screws: Sequence[Sequence[tuple[ModularVector, ModularVector]]],
        whole: Sequence[Sequence[int]],
        k: int,
    ) -> tuple[ModularFrame, ...]:
        """Integrate the frames: order k + 1 from the rates up to order k."""
        p, scale = self.p, pow(k + 1, -1, self.p)
        twists = self._twists(screws, whole)
        out = []
        for part, (omega, v) in enumerate(twists):
            vectors = []
            for axis in range(4):
                series = [frame[part][axis] for frame in frames]
                rate = _crossed(omega, series, k, p)
                if axis == 3:
                    rate = _add(rate, v[k], p)
                vectors.append(_scaled(rate, scale, p))
            out.append(ModularFrame(*vectors))
        return tuple(out)


def _body_columns(
    frame: Sequence[VectorSeries], omega: VectorSeries, v: VectorSeries, force: bool, p: int
) -> list[list[int]]:
    """Compute the columns of a body: sx, sy, sz, Jxx … Jyz, m; forces: sx, sy, sz, m."""
    *axes, o = frame
    orders = range(len(omega))
    rates = [[_crossed(omega, axis, k, p) for k in orders] for axis in axes]
    speed = [_add(_crossed(omega, o, k, p), v[k], p) for k in orders]
    linear = [[x for vector in each for x in vector] for each in (*rates, speed)]
    if force:
        return linear
    columns = []
    for axis, rate, values in zip((*axes, None), (*rates, None), linear, strict=True):
        if axis is None or rate is None:
            angular = [_crossed(o, speed, k, p) for k in orders]
        else:
            angular = [
                _add(_crossed(o, rate, k, p), _crossed(axis, speed, k, p), p) for k in orders
            ]
        columns.append([*values, *(x for vector in angular for x in vector)])
    mass = columns.pop()
    along = [_dotted(axis, omega, p) for axis in axes]
    zeros = [0] * (3 * len(omega))
    for i, j in ELEMENTS:
        element = _times(axes[i], along[j], p)
        if i != j:
            other = _times(axes[j], along[i], p)
            element = [_add(a, b, p) for a, b in zip(element, other, strict=True)]
        columns.append([*zeros, *(x for vector in element for x in vector)])
    return [*columns, mass]
