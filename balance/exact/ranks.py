"""Ranks without a tolerance: the conditions of balance over prime fields.

The joint screws come as rational numbers from the decimals of the file. The conditions of
each order are rational functions of them, so that they can be computed modulo a prime: a
rank modulo a prime is a lower bound of the true one, whatever the prime, and falls short of
it only where the prime divides a minor, at which another prime would differ. Axes are not
normalised, so a relation between inputs is rescaled by the lengths of their axes.

The loops must close at every order. Where their screws span all that the links on them can
do relative to each other, they do (implicit function theorem); an overconstrained linkage is
tested order by order, and one in rounded decimals is refused, not called rigid.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import comb, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.answer import Balance
from balance.exact.chain import ExactChain, exact_chain, regular
from balance.exact.modular import PRIMES, gather, momentum, series
from kinematics.errors import ExactError
from kinematics.linkage import Linkage, Notice
from kinematics.motion import Motion, restriction
from kinematics.reader.geometry import exact_geometry

__all__ = [
    "GIVEN_UP",
    "Exact",
    "Pivot",
    "Witness",
    "conditions",
    "exact_ranks",
    "joints_at_rest",
    "ranks_of",
]

IntArray = NDArray[np.int64]

# Orders that must add nothing before the rank counts as final.
PLATEAU = 3
# And before a rank that was expected is given up, at least.
GIVEN_UP = 12
# Highest orders tried one after the other: for one degree of freedom, and for more.
LADDER = (6, 14, 30, 62, 126)
LADDER_OF_MANY = (5, 9, 17, 33)
# Rays are whole numbers below this, so that they are the same modulo every prime.
RAYS = 2**20


class Pivot(NamedTuple):
    """A condition that the ones before it do not imply.

    Attributes:
        order: order of the derivative.
        ray: index of the ray along which it is taken.
        column: column of the motion, w.
        row: which of ``ExactChain.rows``.
        body: index of the body of the pivot's parameter.
        parameter: which of ``ExactChain.parameters`` of that body.
    """

    order: int
    ray: int
    column: int
    row: int
    body: int
    parameter: int


class Witness(NamedTuple):
    """What shows that a rank is not less: a minor that does not vanish modulo a prime.

    Attributes:
        prime: the prime.
        rays: directions in the columns of the chain.
        pivots: rows and columns of the minor.
    """

    prime: int
    rays: tuple[tuple[int, ...], ...]
    pivots: tuple[Pivot, ...]


class Exact(NamedTuple):
    """Ranks by exact arithmetic.

    Attributes:
        ranks: rank of the conditions up to order 0, 1, 2 …; without a highest order asked
            for, three orders that add nothing are the last.
        parameters: number of inertial parameters.
        primes: the primes used.
        agreed: whether all of them give the same ranks; the larger ones are returned.
        settled: whether the last orders add nothing, and the rank expected was reached.
        regular: whether the loops close at all orders by the rank of their screws, and not
            only at those computed.
        notices: what had to be replaced by rational numbers.
        chain: the linkage in rational numbers.
        witness: proof that the rank is not less.
    """

    ranks: tuple[int, ...]
    parameters: int
    primes: tuple[int, ...]
    agreed: bool
    settled: bool
    regular: bool
    notices: tuple[Notice, ...]
    chain: ExactChain
    witness: Witness

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return self.ranks[-1]

    @property
    def nullity(self) -> int:
        """Dimension of the design space, if the orders computed are all that matter."""
        return self.parameters - self.rank

    @property
    def kmax(self) -> int:
        """The last order that adds a condition."""
        return self.ranks.index(self.rank)

    def to_dict(self) -> dict[str, object]:
        """The entry ``exact`` of the report."""
        return {
            "orders": [
                {"order": k, "rank": rank, "nullity": self.parameters - rank}
                for k, rank in enumerate(self.ranks)
            ],
            "primes": list(self.primes),
            "agreed": self.agreed,
            "settled": self.settled,
            "regular": self.regular,
            "replaced": [notice.message for notice in self.notices],
        }


class _Run(NamedTuple):
    """Ranks and pivots modulo one prime; the number of orders at which the loops close."""

    prime: int
    ranks: tuple[int, ...]
    pivots: IntArray
    closed: int
    enough: bool


def exact_ranks(
    linkage: Linkage,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance = "dynamic",
    max_order: int | None = None,
    *,
    spatial: bool = False,
    expected: int = 0,
) -> Exact:
    """Ranks of the balance conditions by order, as whole numbers without a tolerance.

    Args:
        linkage: read from a file whose loops are closed.
        motion: restriction of the inputs; see `design_space`.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        max_order: compute exactly the orders 0 … max_order, instead of as many as needed.
        spatial: count all ten parameters per body, even if the linkage is planar.
        expected: a rank that is known or believed to be reached: without it, orders are
            added until three in a row add nothing.

    Raises:
        ExactError: the linkage is not from a file with closed loops, or its loops do not
            close exactly, or the motion relates axes whose lengths have no rational ratio.
        MotionError: a relation is wrong, or the motion is that of other inputs.
        MobilityError: the linkage cannot follow the motion.
    """
    geometry = exact_geometry(linkage)
    chain = exact_chain(
        linkage, geometry, restriction(linkage, motion), balance == "force", spatial
    )
    return ranks_of(linkage.source, chain, geometry.notices, max_order, expected)


def ranks_of(
    source: str,
    chain: ExactChain,
    notices: tuple[Notice, ...],
    max_order: int | None = None,
    expected: int = 0,
    highest: int | None = None,
) -> Exact:
    """Ranks of the conditions on a chain by order; see `exact_ranks`.

    Args:
        source: file of the linkage, for messages.
        chain: the linkage in rational numbers.
        notices: numbers of the file that were replaced.
        max_order: compute exactly the orders 0 … max_order, instead of as many as needed.
        expected: a rank that is known or believed to be reached.
        highest: a rank that is known not to be exceeded: the order that reaches it is the
            last one.

    Raises:
        ExactError: the loops do not close exactly, or the inputs do not determine the other
            joints.
    """
    ladder = LADDER if chain.width == 1 else LADDER_OF_MANY
    for order in ladder if max_order is None else (max_order,):
        first, second, rays = _twice(source, chain, order)
        best = tuple(max(pair) for pair in zip(first.ranks, second.ranks, strict=True))
        kmax = best.index(best[-1])
        complete = best[-1] == highest
        plateau = _plateau(kmax, best[-1] >= expected, highest is not None)
        settled = complete or kmax + plateau <= order
        if settled and max_order is None:
            best = best[: kmax + 1 + (0 if complete else PLATEAU)]
            break
    better = max((first, second), key=lambda run: run.ranks[-1])
    return Exact(
        ranks=best, parameters=len(chain.links) * len(chain.parameters),
        primes=(first.prime, second.prime), agreed=first.ranks == second.ranks,
        settled=settled, regular=regular(chain), notices=notices, chain=chain,
        witness=Witness(better.prime, rays, _pivots(chain, better.pivots)),
    )  # fmt: skip


def _plateau(kmax: int, reached: bool, careful: bool) -> int | float:
    """How many orders must add nothing before the rank counts as final.

    A false plateau is no longer than the orders before it, in all linkages tried.

    Args:
        kmax: the last order that added a condition.
        reached: whether the rank expected is reached.
        careful: whether plateaus are to be as long as what came before them; then a rank
            that was expected and is not reached is given up at last.
    """
    if not careful:
        return PLATEAU if reached else inf
    return max(PLATEAU, kmax) if reached else max(GIVEN_UP, 2 * kmax)


def _twice(
    source: str, chain: ExactChain, order: int
) -> tuple[_Run, _Run, tuple[tuple[int, ...], ...]]:
    """Ranks modulo two primes, along as many rays as it takes."""
    width, rows = chain.width, chain.width * len(chain.rows)
    size = len(chain.links) * len(chain.parameters)
    count = 1 if width == 1 else min(comb(width + 1, 2), 3 - (-size // rows))
    while True:
        rays = _rays(count, width)
        runs: list[_Run] = []
        for prime in PRIMES:
            run = _run(chain, rays, order, prime)
            if run is not None and len(runs) < 2:
                runs.append(run)
        if len(runs) < 2:
            raise ExactError(
                f"{source}: its inputs do not determine the other joints, to first "
                "order and exactly; choose other inputs"
            )
        first, second = runs
        closed = min(first.closed, second.closed)
        if closed <= order:
            raise ExactError(
                f"{source}: its geometry is not exactly representable: in the decimals "
                f"of the file the loops close at {closed} orders, and not at the next; "
                "write it with decimals that close exactly, or do without exact arithmetic"
            )
        if first.enough and second.enough:
            return first, second, tuple(map(tuple, rays.tolist()))
        count *= 2


def _rays(count: int, width: int) -> IntArray:
    """Directions without special relations; (count, width)."""
    if width == 1:
        return np.ones((1, 1), dtype=np.int64)
    return np.random.default_rng(5).integers(1, RAYS, (count, width))


def _remainders(rows: Sequence[Sequence[Fraction]], columns: int, p: int) -> IntArray:
    """Rational numbers modulo p; ValueError if p divides a denominator."""
    found = np.zeros((len(rows), columns), dtype=np.int64)
    for i, row in enumerate(rows):
        for j, x in enumerate(row):
            if x:
                found[i, j] = x.numerator * pow(x.denominator, -1, p) % p
    return found


def _modular_chain(chain: ExactChain, p: int) -> tuple[IntArray, ...] | None:
    """The arrays of a chain modulo p, or None if p divides a denominator.

    Returns:
        Parents, screws, ends, mimics, dependent joints and columns, as `series` takes them;
        links, rows and parameters.
    """
    parent, links, dependent = (
        np.array(x, dtype=np.int64) for x in (chain.parent, chain.links, chain.dependent)
    )
    ends = np.array(chain.ends, dtype=np.int64).reshape(-1, 2)
    try:
        screws, rows = _remainders(chain.screws, 6, p), _remainders(chain.rows, 6, p)
        mimics = _remainders(chain.mimics, parent.size, p)
        columns = _remainders(chain.columns, chain.width, p)
        parameters = _remainders(chain.parameters, 10, p)
    except ValueError:
        return None
    return parent, screws, ends, mimics, dependent, columns, links, rows, parameters


def conditions(
    chain: ExactChain, rays: IntArray, order: int, p: int
) -> tuple[IntArray, int] | None:
    """Conditions of the orders 0 … order along rays, modulo p.

    Args:
        chain: the linkage in rational numbers.
        rays: directions in its columns (rays, w), whole numbers below p.
        order: highest order.
        p: a prime below 2^30.

    Returns:
        Remainders (order + 1, rays, w, rows, bodies × parameters) of the derivatives over
        ``k!``, and the number of orders at which all loops close; or None if p divides a
        denominator or a pivot of the loops.
    """
    arrays = _modular_chain(chain, p)
    if arrays is None:
        return None
    V, T, closed = series(*arrays[:6], rays, order, p)
    if closed < 0:
        return None
    links, rows, parameters = arrays[6:]
    X = momentum(links, V, T, p)
    X = _combined(X.reshape(*X.shape[:4], links.size, 10), parameters, p)
    X = _combined(np.moveaxis(X, 3, -1), rows, p)
    X = np.ascontiguousarray(np.moveaxis(X, -1, 3).swapaxes(0, 1))
    return X.reshape(*X.shape[:4], links.size * len(parameters)), closed


def joints_at_rest(chain: ExactChain, order: int) -> tuple[list[int], int]:
    """Joints that do not move at the orders 0 … order, and how many orders the loops close.

    Exact for these orders up to a chance of the prime; no proof for those beyond.
    """
    rays = _rays(min(chain.width, 3), chain.width)
    for p in PRIMES:
        arrays = _modular_chain(chain, p)
        if arrays is None:
            continue
        _, T, closed = series(*arrays[:6], rays, order, p)
        if closed >= 0:
            ground = np.zeros_like(T[:, :, :1])
            carried = np.concatenate([T, ground], axis=2)[:, :, np.array(chain.parent)]
            moves = np.any(carried != T, axis=(0, 1, 3, 4))
            return np.flatnonzero(~moves).tolist(), int(closed)
    return [], 0


def _run(chain: ExactChain, rays: IntArray, order: int, p: int) -> _Run | None:
    """Ranks modulo p, or None if it will not do."""
    if (found := conditions(chain, rays, order, p)) is None:
        return None
    X, closed = found
    spanning = [min(comb(chain.width + k - 1, k), 2**31) for k in range(order + 1)]
    ranks, pivots, enough = gather(
        X.reshape(order + 1, len(rays), -1, X.shape[-1]), np.array(spanning), p
    )
    return _Run(p, tuple(ranks.tolist()), pivots, closed, bool(enough))


def _combined(X: IntArray, weights: IntArray, p: int) -> IntArray:
    """Combinations of the last axis of X with the rows of ``weights``, modulo p."""
    out = np.zeros((*X.shape[:-1], len(weights)), dtype=np.int64)
    for i, j in np.argwhere(weights):
        out[..., i] = (out[..., i] + X[..., j] * weights[i, j]) % p
    return out


def _pivots(chain: ExactChain, found: IntArray) -> tuple[Pivot, ...]:
    """Pivots by name instead of by position."""
    rows, size = len(chain.rows), len(chain.parameters)
    return tuple(
        Pivot(order, ray, row // rows, row % rows, column // size, column % size)
        for order, ray, row, column in found.tolist()
    )
