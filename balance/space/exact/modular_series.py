"""Motion and momentum of a chain as power series along a ray, modulo a prime.

The recursions use sums, products, divisions by the order and one linear system, so they run
on remainders modulo a prime p as they do on rational numbers. With the tensors of
`balance.space.momentum.product_tensors`,

    V_j        = V_parent + s_j q̇_j
    k s_{j,k}  = Σ_{a<k} ad(V_{parent,a}) s_{j,k-1-a}
    S_0 C_k    = -Σ_{a≥1} S_a C_{k-a}            (each loop, A minus B)
    k Z_k      = Σ_{a<k} L(V_a) Z_{k-1-a}
    X_{w,k}    = Σ_{a≤k} M(T_{w,a}) Z_{k-a}

along ``u = t δ``, with the order k as index. The columns of Z are the parameters of a body
that is carried along, for unit parameters at the reference pose. (J. J. de Jong, PhD thesis,
University of Twente, chapters 4 and 5.)

Screws and twists have six components, angular first, in the inertial frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from balance.space.exact.chain import ExactChain
from balance.space.exact.modular import Convolution, eliminate, inverse, product
from balance.space.exact.radicals import modular_root, primes_with_roots
from balance.space.momentum.product_tensors import BRACKET, MOMENTUM, RATE
from kinematics.model.chain import loop_signs, paths
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.cyclotomic import number_remainder

_BRACKET, _RATE = (x.astype(np.int64).reshape(6, -1) for x in (BRACKET, RATE))
_MOMENTUM = MOMENTUM.astype(np.int64)
# Combinations of rows that stand for all of them, and the seed of their weights.
SAMPLES, SEED = 2, 11


class Remainders(NamedTuple):
    """An `ExactChain` modulo a prime; n joints, w columns, d of the joints dependent.

    Attributes:
        prime: the prime.
        parent: link before each joint, -1 for the ground (n,).
        path_matrix: the joints on the way from the ground to each link, as ones (n, n).
        loop_signs: the joints around each loop, as signs: A minus B (loops, n).
        screws: joint screws at the reference pose (n, 6).
        dependent: joints whose rates follow from the loops (d,).
        solver: what makes rates of the dependent joints from the closure residual, and
            below what remains of the residual (rows, rows).
        rates: of all joints at the reference pose (n, w).
        closed: whether no residual remains there.
        links: link of each body.
        momentum: rows of the momentum for unit twists (6, rows × 10).
        parameters: those that are counted, as columns (10, parameters).
    """

    prime: int
    parent: IntArray
    path_matrix: Array
    loop_signs: Array
    screws: IntArray
    dependent: IntArray
    solver: IntArray
    rates: IntArray
    closed: bool
    links: IntArray
    momentum: IntArray
    parameters: IntArray


def chain_modulo(chain: ExactChain, p: int) -> Remainders | None:
    """Reduce a chain modulo a prime.

    Args:
        chain: the linkage in rational numbers.
        p: the prime, one in which the roots of the chain exist; see `primes_of`.

    Returns:
        The remainders; None if p divides a denominator or a pivot of the loops.
    """
    dependent = np.array(chain.dependent, dtype=np.int64)
    ways, welds = paths(chain.parent)[:-1], loop_signs(chain.parent, chain.ends)
    try:
        screws, rows = _screws(chain, p), _remainders(chain.rows, 6, p)
        rates = _remainders(chain.columns, chain.width, p)
        parameters = _remainders(chain.parameters, 10, p).T
        loops = _loop_matrix(chain, welds, screws, p)
    except ValueError:
        return None
    count = dependent.size
    A = np.concatenate([loops[:, dependent], np.eye(len(loops), dtype=np.int64)], axis=1)
    pivots = eliminate(A, count, p)
    if np.sum(pivots >= 0) < count:
        return None
    solver = A[np.argsort(np.where(pivots < 0, count, pivots), kind="stable"), count:]
    solution = product(solver, -product(loops, rates, p) % p, p)
    rates[dependent] = solution[:count]
    return Remainders(
        prime=p,
        parent=np.array(chain.parent, dtype=np.int64),
        path_matrix=ways,
        loop_signs=welds,
        screws=screws,
        dependent=dependent,
        solver=solver,
        rates=rates,
        closed=not solution[count:].any(),
        links=np.array(chain.links, dtype=np.int64),
        momentum=(rows @ _MOMENTUM % p).reshape(6, -1),
        parameters=parameters,
    )


def _remainders(rows: Sequence[Sequence[Fraction]], columns: int, p: int) -> IntArray:
    """Reduce rational numbers modulo p.

    Raises:
        ValueError: p divides a denominator.
    """
    remainders = np.zeros((len(rows), columns), dtype=np.int64)
    for i, row in enumerate(rows):
        for j, x in enumerate(row):
            if x:
                remainders[i, j] = number_remainder(x, p)
    return remainders


def _screws(chain: ExactChain, p: int) -> IntArray:
    """Reduce the screws of a chain modulo p, each times its square root."""
    screws = _remainders(chain.screws, 6, p)
    for j, radicands in enumerate(chain.radicands):
        for number in radicands:
            screws[j] = screws[j] * modular_root(number, p) % p
    return screws


def primes_of(chain: ExactChain) -> Iterator[int]:
    """Yield primes below 2^30 in which the square roots and the field of a chain exist.

    Args:
        chain: the linkage in rational numbers.

    Raises:
        ExactError: it has too many square roots.
    """
    radicands = sorted({b for numbers in chain.radicands for b in numbers})
    return primes_with_roots(radicands, chain.conductor)


def _loop_matrix(chain: ExactChain, welds: Array, screws: IntArray, p: int) -> IntArray:
    """Assemble the loop matrix (rows, n): six rows for each loop, and then mimic relations."""
    loops = np.swapaxes(welds.astype(np.int64)[:, :, None] * screws, 1, 2) % p
    mimics = _remainders(chain.mimics, len(screws), p)
    return np.concatenate([loops.reshape(-1, len(screws)), mimics])


def first_order_mobility(chain: ExactChain) -> int:
    """Compute the mobility at first order: joints less the rank of the loop matrix.

    The rank is that modulo a prime that divides no denominator.

    Returns:
        The mobility; -1 if every prime divides a denominator.
    """
    welds = loop_signs(chain.parent, chain.ends)
    for p in primes_of(chain):
        try:
            loops = _loop_matrix(chain, welds, _screws(chain, p), p)
        except ValueError:
            continue
        n = loops.shape[1]
        return n - int(np.sum(eliminate(loops, n, p) >= 0))
    return -1


class Twists:
    """Twists of all links as series along a ray, order by order.

    Attributes:
        orders: number of orders there are.
        closed: number of orders, from 0, at which all loops close.
        moving: whether a joint moves at one of the orders (n,).
        T: twists of all links for unit rates, at the last order (n, w, 6).
        V: twists along the ray, at the last order (n, 6).
    """

    def __init__(self, chain: Remainders, ray: IntArray) -> None:
        """Start without orders; ``ray`` are integers below 2^20 (w,)."""
        self._chain, self._ray = chain, ray
        n, width = chain.rates.shape
        self._brackets = Convolution(n, 6, 6, 1, chain.prime)
        self._joint_twists = Convolution(n, width, 1, 6, chain.prime)
        self.orders = self.closed = 0
        self.moving = np.zeros(n, dtype=np.bool_)
        self.T, self.V = np.empty((n, width, 6), np.int64), np.empty((n, 6), np.int64)

    def extend(self) -> None:
        """Compute the next order."""
        chain, p, k = self._chain, self._chain.prime, self.orders
        if k == 0:
            s, rates, closed = chain.screws, chain.rates, chain.closed
            joint_twists = rates[:, :, None] * s[:, None] % p
        else:
            s = self._brackets.sum(k)[..., 0] * inverse(k, p) % p
            self._joint_twists.append_right(s[:, None])
            joint_twists, rates, closed = self._close(self._joint_twists.sum(k))
        n, width = rates.shape
        T = (chain.path_matrix @ joint_twists.reshape(n, -1)).astype(np.int64) % p
        self.T = T.reshape(n, width, 6)
        self.V = self._ray @ self.T % p
        carried = np.concatenate([self.V, np.zeros_like(self.V[:1])])[chain.parent]
        self._brackets.append_left((carried @ _BRACKET % p).reshape(n, 6, 6))
        self._brackets.append_right(s[:, :, None])
        self._joint_twists.append_left(rates[:, :, None])
        self.moving |= joint_twists.any(axis=(1, 2))
        self.orders += 1
        self.closed += closed and self.closed == k

    def _close(self, joint_twists: IntArray) -> tuple[IntArray, IntArray, bool]:
        """Close the loops at this order by the rates of the dependent joints.

        Args:
            joint_twists: twists of the joints themselves without these rates (n, w, 6).

        Returns:
            The twists (n, w, 6), the rates (n, w), and whether the loops close.
        """
        chain, p = self._chain, self._chain.prime
        n, width = chain.rates.shape
        rates, count = np.zeros((n, width), np.int64), chain.dependent.size
        open_by = -(chain.loop_signs @ joint_twists.reshape(n, -1)).astype(np.int64) % p
        open_by = np.swapaxes(open_by.reshape(-1, width, 6), 1, 2).reshape(-1, width)
        solution = product(chain.solver[:, : len(open_by)], open_by, p)
        rates[chain.dependent] = solution[:count]
        joint_twists = (joint_twists + rates[:, :, None] * chain.screws[:, None]) % p
        return joint_twists, rates, not solution[count:].any()


class Momenta:
    """The regressor of the momentum as a series along a ray, order by order."""

    def __init__(self, chain: Remainders, ray: IntArray) -> None:
        """Start without orders; ``ray`` are integers below 2^20 (w,)."""
        self._chain, self.twists = chain, Twists(chain, ray)
        p, bodies, (_, size) = chain.prime, chain.links.size, chain.parameters.shape
        rows = chain.rates.shape[1] * chain.momentum.shape[1] // 10
        self._carried_parameters = Convolution(bodies, 10, 10, size, p)
        self._products = Convolution(bodies, rows, 10, size, p)
        self._samples = Convolution(bodies, SAMPLES, 10, size, p)
        self._weights = np.random.default_rng(SEED).integers(1, p, (SAMPLES, rows))

    def rows(self, order: int, chosen: Sequence[int] | None = None) -> IntArray:
        """Compute the rows of an order that is not below the last one computed.

        Args:
            order: the order.
            chosen: some of the rows; all by default.

        Returns:
            Remainders (w × rows, bodies × parameters): for each column the rows of the
            momentum, and for each body the parameters that are counted.
        """
        self._extend_to(order)
        return _side_by_side(self._products.sum(order + 1, chosen))

    def samples(self, order: int) -> IntArray:
        """Compute random combinations of these rows, which cost a fraction of all.

        If one of the rows is not implied by others, these combinations are not either, but for
        one case in ``p^SAMPLES``.

        Returns:
            Remainders (`SAMPLES`, bodies × parameters).
        """
        self._extend_to(order)
        return _side_by_side(self._samples.sum(order + 1))

    def _extend_to(self, order: int) -> None:
        while self.twists.orders <= order:
            self._extend()

    def _extend(self) -> None:
        """Compute the next order of the twists, and of the parameters that bodies carry."""
        chain, p, k = self._chain, self._chain.prime, self.twists.orders
        bodies = chain.links.size
        if k == 0:
            Z = np.broadcast_to(chain.parameters, (bodies, *chain.parameters.shape))
        else:
            Z = self._carried_parameters.sum(k) * inverse(k, p) % p
        self.twists.extend()
        T, V = self.twists.T[chain.links], self.twists.V[chain.links]
        M = product(T.reshape(-1, 6), chain.momentum, p).reshape(bodies, -1, 10)
        for series, coefficients in ((self._products, M), (self._samples, self._sample(M))):
            series.append_left(coefficients)
            series.append_right(Z)
        self._carried_parameters.append_left((V @ _RATE % p).reshape(bodies, 10, 10))
        self._carried_parameters.append_right(Z)

    def _sample(self, M: IntArray) -> IntArray:
        """Combine the rows of all bodies alike: (bodies, rows, 10) to (bodies, samples, 10)."""
        return product(self._weights, M, self._chain.prime)


def _side_by_side(X: IntArray) -> IntArray:
    """Put the columns of bodies (bodies, rows, parameters) beside each other."""
    return X.swapaxes(0, 1).reshape(X.shape[1], -1)
