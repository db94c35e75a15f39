"""Mobility, ranks by order and parts of the design space of a linkage, without rounding.

Nothing of the product is used. Numbers are remainders modulo a prime: a rank is never too
high, and too low with odds of 10⁻⁹; whoever doubts asks for the other prime.
"""

from __future__ import annotations

from fractions import Fraction
from math import comb
from typing import NamedTuple

import numpy as np

from tests.independent.plain_linkage import Linkage, edges
from tests.independent.prime_field import PRIMES, absorb, momentum, motion, reduced
from tests.independent.prime_roots import prime_with_roots, root_of_fraction
from tests.independent.split_bodies import Graph, serial

# Orders without a new condition after which, from a least order on, the rank counts as final;
# the least is for one degree of freedom. No more orders than HIGHEST are computed.
PLATEAU, LEAST, HIGHEST = 12, 30, 250
# To which loops must close, and at which what is idle does not move.
CLOSED = 30


class Truth(NamedTuple):
    """What is true of a linkage.

    Attributes:
        mobility: degrees of freedom, at first order.
        regular: whether its loops close at all orders computed.
        planar: whether planar parameters count.
        parameters: how many there are.
        ranks: by order, up to the last that adds a condition.
        serial: dimension of the serial space, once idle freedoms are locked.
        certain: whether rank and serial dimension add up to the number of parameters;
            otherwise no condition came in twelve orders and no serial freedom in many ways
            of opening.
        enumerated: whether all ways of opening were tried, or enough to be certain.
        idle: names of the freedoms that do not move.
    """

    mobility: int
    regular: bool
    planar: bool = False
    parameters: int = 0
    ranks: tuple[int, ...] = ()
    serial: int = 0
    certain: bool = False
    enumerated: bool = False
    idle: tuple[str, ...] = ()

    @property
    def rank(self) -> int:
        """Number of conditions."""
        return self.ranks[-1]

    @property
    def parallel(self) -> int:
        """Dimension of what only the loops free."""
        return self.parameters - self.rank - self.serial


class Selection(NamedTuple):
    """What counts: pairs of points and their parameter, rows, parameters of a body."""

    pairs: np.ndarray
    rows: np.ndarray
    parameters: int


class _Scene:
    """A linkage modulo a prime, with its loops solved at first order."""

    def __init__(self, linkage: Linkage, p: int, first: tuple[str, ...] = ()) -> None:
        self.linkage, self.p, self.edges = linkage, p, edges(linkage)
        self.before, self.after = np.array(
            [(e.before, -1 if e.closes else e.after) for e in self.edges], dtype=np.int64
        ).T.copy()
        self.screws = self._unit_screws()
        self.signs = self._loops()
        A = np.concatenate(
            [
                (self.signs[:, :, None] * self.screws % p)
                .transpose(0, 2, 1)
                .reshape(6 * len(self.signs), len(self.edges)),
                self._mimics(),
            ]
        )
        # Columns that come last stay independent.
        names = [e.name for e in self.edges]
        last = [names.index(name) for name in first or linkage.inputs]
        order = [e for e in range(len(names)) if e not in last] + last
        form, T, pivots = reduced(np.ascontiguousarray(A[:, order]), p)
        self.form, self.T = np.empty(form.shape, np.int64), np.ascontiguousarray(T)
        self.form[:, order] = form
        self.pivots = np.array([order[c] if c >= 0 else -1 for c in pivots], dtype=np.int64)
        self.free = [e for e in order if e not in self.pivots]

    def _unit_screws(self) -> np.ndarray:
        """Screws of the edges, those that relations name for unit directions."""
        screws, related = (
            _remainders([e.screw for e in self.edges], self.p),
            _related(self.linkage),
        )
        for e, edge in enumerate(self.edges):
            if edge.name in related:
                root = root_of_fraction(edge.square, self.p)
                screws[e] = screws[e] * pow(root, -1, self.p) % self.p
        return screws

    def _loops(self) -> np.ndarray:
        """Signs of the edges along each loop (loops, edges)."""
        carrier = {int(n): e for e, n in enumerate(self.after) if n >= 0}

        def path(node: int) -> np.ndarray:
            signs = np.zeros(len(self.edges), np.int64)
            while node:
                signs[carrier[node]] = 1
                node = self.edges[carrier[node]].before
            return signs

        found = []
        for e, edge in enumerate(self.edges):
            if edge.closes:
                signs = path(edge.before) - path(edge.after)
                signs[e] = 1
                found.append(signs)
        return np.array(found, dtype=np.int64).reshape(-1, len(self.edges))

    def _mimics(self) -> np.ndarray:
        """Rows of the relations of joints."""
        names = [e.name for e in self.edges]
        rows = [[Fraction(0)] * len(names) for _ in self.linkage.mimics]
        for row, mimic in zip(rows, self.linkage.mimics, strict=True):
            row[names.index(f"j{mimic.joint}")] = Fraction(1)
            row[names.index(f"j{mimic.source}")] -= mimic.ratio
        return _remainders(rows, self.p, len(names))

    def columns(self) -> np.ndarray:
        """Rates of the edges for each column of the motion asked for, dependent ones 0."""
        names = [self.edges[e].name for e in self.free]
        if not self.linkage.relations:
            basis = np.eye(len(names)).astype(np.int64)
        else:
            assert sorted(names) == sorted(self.linkage.inputs), "inputs are dependent"
            wanted = [self.linkage.inputs.index(name) for name in names]
            rows = [[row[k] for k in wanted] for row in self.linkage.relations]
            form, _, pivots = reduced(_remainders(rows, self.p), self.p)
            pivots = pivots[pivots >= 0]
            free = [c for c in range(len(names)) if c not in pivots]
            basis = np.zeros((len(names), len(free)), np.int64)
            basis[free, range(len(free))] = 1
            basis[pivots] = -form[: len(pivots), free] % self.p
        start = np.zeros((len(self.edges), basis.shape[1]), np.int64)
        start[self.free] = basis
        return start

    def move(self, start: np.ndarray, ray: np.ndarray, order: int):
        """Points, twists, rates, and the number of orders that close; see `motion`."""
        return motion(
            self.before,
            self.after,
            self.screws,
            self.signs,
            self.form,
            self.T,
            self.pivots,
            start,
            ray,
            order,
            self.p,
        )


def independent(linkage: Linkage, last: tuple[str, ...]) -> tuple[tuple[str, ...], bool]:
    """Independent coordinates, of these names as far as possible; whether loops close."""
    scene = _Scene(linkage, _prime(linkage, 0), last)
    start = np.zeros((len(scene.edges), len(scene.free)), np.int64)
    start[scene.free, range(len(scene.free))] = 1
    ray = np.random.default_rng(1).integers(1, scene.p, len(scene.free))
    closed = scene.move(start, ray, CLOSED)[-1] > CLOSED if scene.free else True
    return tuple(scene.edges[e].name for e in scene.free), closed


def _related(linkage: Linkage) -> set[str]:
    """Names of the freedoms whose rates relations compare."""
    names = {f"j{x}" for mimic in linkage.mimics for x in (mimic.joint, mimic.source)}
    return names.union(
        *(
            {name for name, factor in zip(linkage.inputs, row, strict=True) if factor}
            for row in linkage.relations
        )
    )


def _prime(linkage: Linkage, seed: int) -> int:
    """The prime of a seed; another if lengths of related axes are no squares modulo it."""
    related = _related(linkage)
    squares = [e.square for e in edges(linkage) if e.name in related]
    return prime_with_roots(squares, PRIMES[seed % 2])


def truth(linkage: Linkage, seed: int = 0, effort: int = 1, orders: int = CLOSED) -> Truth:
    """What is true of a linkage, modulo one of the primes.

    Args:
        linkage: the linkage.
        seed: of random rays, poses and ways of opening; its parity is that of the prime.
        effort: how many times the usual number of ways of opening are tried, and orders.
        orders: at which loops must close, and idle joints rest.
    """
    scene = _Scene(linkage, _prime(linkage, seed))
    mobility, rng = len(scene.free), np.random.default_rng(seed)
    if mobility == 0:
        return Truth(0, False)
    start = scene.columns()
    rays = _Rays(scene, start, rng)
    if linkage.relations:
        free = np.zeros((len(scene.edges), mobility), np.int64)
        free[scene.free, range(mobility)] = 1
        if scene.move(free, rng.integers(1, scene.p, mobility), orders)[-1] <= orders:
            return Truth(mobility, False)
    if not rays.closes(orders):
        return Truth(mobility, False)
    idle = rays.idle()
    planar = None if linkage.spatial else _plane(scene, idle)
    selection = _selection(planar, linkage.force)
    size = selection.parameters * len(linkage.bodies)
    graph, bound, found = _graph(scene, idle), size, None
    order, least = orders, LEAST if start.shape[1] == 1 else 0
    while True:
        ranks = rays.ranks(selection, order, bound)
        if ranks is None:
            return Truth(mobility, False)
        if found is None or (found.complete and size - ranks[-1] < found.dimension):
            found = serial(graph, selection, scene.p, size - ranks[-1], seed, effort)
            bound = size - found.dimension
        kmax = ranks.index(ranks[-1])
        enough = min(max(kmax + PLATEAU, least) * effort, HIGHEST)
        if ranks[-1] == bound or order >= enough:
            break
        order = enough
    if ranks[-1] < bound and not found.complete:
        found = serial(graph, selection, scene.p, size - ranks[-1], seed + 1, 3 * effort)
    certain = ranks[-1] + found.dimension == size
    return Truth(
        mobility,
        True,
        planar is not None,
        size,
        ranks[: kmax + 1],
        found.dimension,
        certain,
        found.complete,
        tuple(edge.name for edge, still in zip(scene.edges, idle, strict=True) if still),
    )


class _Rays:
    """Random rays through the reference pose, drawn as they are needed."""

    def __init__(self, scene: _Scene, start: np.ndarray, rng) -> None:
        self.scene, self.start, self.rng = scene, start, rng
        self.directions: list[np.ndarray] = []
        self.order, self.moved, self.rows = -1, [], []

    def _ray(self, number: int, order: int):
        """Points, twists, rates and closed orders along a ray."""
        if order > self.order:
            self.order, self.moved, self.rows = order, [], []
        while len(self.moved) <= number:
            at = len(self.moved)
            if at == len(self.directions):
                self.directions.append(self.rng.integers(1, self.scene.p, self.start.shape[1]))
            self.moved.append(self.scene.move(self.start, self.directions[at], self.order))
        return self.moved[number]

    def closes(self, order: int) -> bool:
        """Whether the loops close up to an order."""
        return self._ray(0, order)[-1] > order

    def idle(self) -> np.ndarray:
        """Edges whose rates vanish at all orders."""
        return ~self._ray(0, self.order)[2].any(axis=(0, 2))

    def _conditions(self, number: int, k: int, selection, order: int) -> np.ndarray | None:
        """Rows of order k along a ray; None if the loops do not close."""
        X, V, _, closed = self._ray(number, order)
        if closed <= order:
            return None
        while len(self.rows) <= number:
            bodies = self.scene.linkage.bodies
            X, V, _, _ = self._ray(len(self.rows), order)
            M = momentum(
                X[bodies],
                V[bodies],
                selection.pairs,
                selection.rows,
                selection.parameters,
                self.scene.p,
            )
            self.rows.append(M.reshape(len(M), -1, len(bodies) * selection.parameters))
        return self.rows[number][k]

    def ranks(self, selection, order: int, bound: int) -> tuple[int, ...] | None:
        """Ranks up to an order, or up to the one that reaches the bound."""
        width = self.start.shape[1]
        size = selection.parameters * len(self.scene.linkage.bodies)
        basis, pivots = np.zeros((size, size), np.int64), np.zeros(size, np.int64)
        found, rank = [], 0
        for k in range(order + 1):
            for number in range(comb(width + k - 1, k)):
                rows = self._conditions(number, k, selection, order)
                if rows is None:
                    return None
                before, rank = rank, absorb(basis, pivots, rank, rows, self.scene.p)
                if rank == before or rank >= bound:
                    break
            found.append(rank)
            if rank >= bound:
                break
        return tuple(found)


def _plane(scene: _Scene, idle: np.ndarray) -> int | None:
    """The coordinate axis normal to the plane in which all links move; None if there is none.

    Planes of other normals are not looked for: let --spatial be asked for there.
    """
    S = scene.screws[~idle]
    for normal in (2, 0, 1):
        others = [a for a in range(3) if a != normal]
        turning = S[:, :3].any(axis=1)
        if not S[:, others].any() and not S[~turning, 3 + normal].any():
            return normal
    return None


def _selection(normal: int | None, force: bool) -> Selection:
    """What counts in a plane with that normal, or in space."""
    axes = [a for a in range(3) if a != normal]
    pairs = [(0, 0), *((0, 1 + a) for a in axes)]
    count = len(pairs)
    numbers = list(range(count))
    if not force and normal is None:
        pairs += [(1 + a, 1 + b) for a in range(3) for b in range(a, 3)]
        numbers = list(range(10))
    elif not force:
        pairs += [(1 + a, 1 + a) for a in axes]
        numbers += [count, count]
    rows = [3 + a for a in axes]
    if not force:
        rows += [0, 1, 2] if normal is None else [normal]
    table = [(i, j, number) for (i, j), number in zip(pairs, numbers, strict=True)]
    return Selection(
        np.array(table, dtype=np.int64), np.array(rows, dtype=np.int64), numbers[-1] + 1
    )


def _graph(scene: _Scene, idle: np.ndarray) -> Graph:
    """Rigid parts and the joints between them."""
    part = list(range(max(max(e.before, e.after) for e in scene.edges) + 1))
    for edge in (e for e, still in zip(scene.edges, idle, strict=True) if still):
        keep, drop = sorted((part[edge.before], part[edge.after]))
        part = [keep if x == drop else x for x in part]
    number = {x: k for k, x in enumerate(sorted(set(part)))}
    part = [number[x] for x in part]
    moving = [e for e, still in enumerate(idle) if not still]
    pairs = [(part[scene.edges[e].before], part[scene.edges[e].after]) for e in moving]
    bodies = [part[link] for link in scene.linkage.bodies]
    return Graph(pairs, scene.screws[moving], bodies, len(number))


def _remainders(rows, p: int, width: int = 0) -> np.ndarray:
    """Rational numbers modulo p."""
    found = [[x.numerator * pow(x.denominator, -1, p) % p for x in row] for row in rows]
    return np.array(found, dtype=np.int64).reshape(len(found), -1 if found else width)
