"""Balance conditions of a linkage in rational numbers, order by order, modulo a prime."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from balance.exact.chain import ExactChain
from balance.exact.modular import PRIMES, eliminate, fill_loop_matrix, momentum, series

__all__ = ["conditions", "first_order_mobility", "joints_at_rest", "rays_of"]

IntArray = NDArray[np.int64]

# Entries of rays are positive integers below this, and so the same modulo every prime.
RAYS = 2**20


def rays_of(count: int, width: int) -> IntArray:
    """Pseudo-random directions in the columns of a chain, the same for every prime.

    Args:
        count: number of rays; for one degree of freedom there is one.
        width: number of columns.

    Returns:
        Positive integers below 2^20; (count, width).
    """
    if width == 1:
        return np.ones((1, 1), dtype=np.int64)
    return np.random.default_rng(5).integers(1, RAYS, (count, width))


def conditions(
    chain: ExactChain, rays: IntArray, order: int, p: int
) -> tuple[IntArray, int] | None:
    """Conditions of the orders 0 … order along rays, modulo p.

    They are ``(d^k h_w / dt^k) / k!`` at ``t = 0`` of the momentum ``h_w = X_w z`` for each
    column w, along ``u = t δ`` for each ray δ.

    Args:
        chain: the linkage in rational numbers.
        rays: directions in its columns (rays, w), integers below p.
        order: highest order.
        p: a prime below 2^30.

    Returns:
        Remainders (order + 1, rays, w, rows, bodies × parameters), and the number of orders
        at which all loops close; or None if p divides a denominator or a pivot of the loops.
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
    """Joints that do not move at the orders 0 … order, and the closure of the loops.

    Exact for these orders, but for a prime that divides a rate; no proof for higher ones.

    Args:
        chain: the linkage in rational numbers.
        order: highest order.

    Returns:
        Numbers of the joints, ascending, and the number of orders at which all loops close;
        no joints and 0 if no prime will do.
    """
    rays = rays_of(min(chain.width, 3), chain.width)
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


def first_order_mobility(chain: ExactChain) -> int:
    """Joints less the rank of the loop matrix, modulo a prime that divides no denominator.

    The mobility at first order; -1 if every prime divides a denominator.
    """
    n = len(chain.parent)
    for p in PRIMES:
        arrays = _modular_chain(chain, p)
        if arrays is None:
            continue
        parent, screws, ends, mimics = arrays[:4]
        rows = 6 * len(ends) + len(mimics)
        A = np.zeros((rows, n + rows), np.int64)
        fill_loop_matrix(parent, screws, ends, mimics, np.arange(n), p, A)
        return n - int(eliminate(A, n, p))
    return -1


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


def _remainders(rows: Sequence[Sequence[Fraction]], columns: int, p: int) -> IntArray:
    """Rational numbers modulo p; ValueError if p divides a denominator."""
    found = np.zeros((len(rows), columns), dtype=np.int64)
    for i, row in enumerate(rows):
        for j, x in enumerate(row):
            if x:
                found[i, j] = x.numerator * pow(x.denominator, -1, p) % p
    return found


def _combined(X: IntArray, weights: IntArray, p: int) -> IntArray:
    """Combinations of the last axis of X with the rows of ``weights``, modulo p."""
    out = np.zeros((*X.shape[:-1], len(weights)), dtype=np.int64)
    for i, j in np.argwhere(weights):
        out[..., i] = (out[..., i] + X[..., j] * weights[i, j]) % p
    return out
