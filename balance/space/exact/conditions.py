"""Balance conditions of a linkage in rational numbers, order by order, modulo a prime."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import count, islice
from math import comb

import numpy as np

from balance.space.exact.chain import ExactChain
from balance.space.exact.modular import Echelon
from balance.space.exact.modular_series import (
    Momenta,
    Remainders,
    Twists,
    chain_modulo,
    primes_of,
)
from kinematics.numerics.array_types import IntArray

# Entries of rays are positive integers below this, so that they are the same modulo every
# prime.
MAX_RAY_ENTRY = 2**20
# Most rays along which joints are tested for rest, and loops for closure.
MAX_TEST_RAYS = 3


def directions_of(width: int) -> Iterator[IntArray]:
    """Generate pseudo-random directions in the columns of a chain, the same for every prime.

    Args:
        width: number of columns (w); for a single one the ray is 1.

    Yields:
        Positive integers below 2^20 (w,).
    """
    rng = np.random.default_rng(5)
    while True:
        yield rng.integers(1, MAX_RAY_ENTRY, width) if width > 1 else np.ones(1, dtype=np.int64)


class ExactConditions:
    """Ranks of the conditions modulo a prime, order by order, along as many rays as needed.

    The conditions are ``(d^k h_w / dt^k) / k!`` at ``t = 0`` of the momentum ``h_w = X_w z``
    for each column w, along ``u = t δ`` for each ray δ. An order is complete once another
    ray adds nothing, or the rays span all derivatives.

    Attributes:
        prime: the prime.
        rays: directions δ.
        ranks: rank after each order.
        pivots: order, ray, row and column of each condition that those before do not imply.
    """

    def __init__(self, chain: Remainders, most: int | None = None) -> None:
        """Start without orders.

        Args:
            chain: a chain modulo the prime.
            most: a rank that is known not to be exceeded; an open chain, whose loops need not
                be watched, is not followed once it is reached.
        """
        self._chain, self._size = chain, chain.links.size * chain.parameters.shape[1]
        self._echelon = Echelon(self._size, chain.prime)
        self._most = None if chain.dependent.size else most
        self._momenta: list[Momenta] = []
        self._directions = directions_of(chain.rates.shape[1])
        self.prime = chain.prime
        self.rays: list[IntArray] = []
        self.ranks: list[int] = []
        self.pivots: list[tuple[int, int, int, int]] = []

    @property
    def closed(self) -> int:
        """Number of orders, from 0, at which all loops close; those computed, or fewer."""
        twists = (momenta.twists for momenta in self._momenta)
        return min((x.closed for x in twists if x.closed < x.orders), default=len(self.ranks))

    def extend(self, likely: Collection[tuple[int, int, int, int]] = ()) -> None:
        """Add the conditions of the next order.

        Args:
            likely: pivots modulo another prime. Their rows are added first, and others only if
                these are not all.
        """
        order, width = len(self.ranks), self._chain.rates.shape[1]
        spanning = comb(width + order - 1, order)
        for ray in count():
            if ray == len(self.rays):
                self.rays.append(next(self._directions))
                self._momenta.append(Momenta(self._chain, self.rays[ray]))
            if self._echelon.rank == self._most:
                break
            rank, momenta = self._echelon.rank, self._momenta[ray]
            self._add_conditions(
                order, ray, [row for k, r, row, _ in likely if (k, r) == (order, ray)]
            )
            # A few combinations of the rows show whether others add more.
            if not self._echelon.implies(momenta.samples(order)):
                self._add_conditions(order, ray, None)
            if self._echelon.rank == rank:
                break
            if ray + 1 >= spanning or self._echelon.rank == self._size:
                break
        self.ranks.append(self._echelon.rank)

    def _add_conditions(self, order: int, ray: int, chosen: list[int] | None) -> None:
        """Add the conditions of an order along a ray; ``chosen`` rows of them, None for all."""
        if chosen == []:
            return
        rows = self._momenta[ray].rows(order, chosen)
        names: Sequence[int] = range(len(rows)) if chosen is None else chosen
        self.pivots += [
            (order, ray, names[row], column) for row, column in self._echelon.absorb(rows)
        ]


def first_orders_of_motion(chain: ExactChain, order: int) -> IntArray:
    """Find the lowest of the orders 0 … order at which each joint has a rate.

    Exact for these orders, unless a prime divides a rate; no proof for higher orders.

    Args:
        chain: the linkage in rational numbers.
        order: the highest order.

    Returns:
        The order for each joint, -1 if it does not move at any (n,); 0 if no prime is usable.
    """
    lowest = np.full(len(chain.parent), -1)
    for twists in _twists_along_rays(chain):
        moving = np.zeros(len(chain.parent), dtype=np.bool_)
        while twists.orders <= order and not (moving | (lowest == 0)).all():
            twists.extend()
            sooner = twists.moving & ~moving & ((lowest < 0) | (lowest >= twists.orders))
            lowest[sooner] = twists.orders - 1
            moving |= twists.moving
    return lowest if (lowest >= 0).any() else np.zeros_like(lowest)


def orders_closed(chain: ExactChain, order: int) -> int:
    """Count the orders, of 0 … order, at which all loops close.

    Args:
        chain: the linkage in rational numbers.
        order: the highest order.

    Returns:
        Their number; 0 if no prime is usable.
    """
    counts = []
    for twists in _twists_along_rays(chain):
        while twists.closed == twists.orders <= order:
            twists.extend()
        counts.append(twists.closed)
    return min(counts, default=0)


def _twists_along_rays(chain: ExactChain) -> Iterator[Twists]:
    """Compute series along a few rays, modulo a prime that divides no denominator or pivot."""
    remainders = next(filter(None, (chain_modulo(chain, p) for p in primes_of(chain))), None)
    if remainders is not None:
        for ray in islice(directions_of(chain.width), min(chain.width, MAX_TEST_RAYS)):
            yield Twists(remainders, ray)
