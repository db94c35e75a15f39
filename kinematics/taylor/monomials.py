"""Polynomials in several variables, many at once: the arithmetic of Taylor expansions.

A polynomial is a row of coefficients, one for each monomial ``u^α = Π u_i^{α_i}``: those of
degree 0, then of degree 1, and so on up to the order; within a degree u_1 comes first, as in
``1, u_1, u_2, u_1², u_1 u_2, u_2²``. A mixed partial derivative is symmetric, and is stored
once: it is ``α!`` times the coefficient of ``u^α``.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.compiled.jit import kernel
from kinematics.compiled.simd import LANES, load, store
from kinematics.errors import LinkageError
from kinematics.model.arrays import IntArray, frozen

__all__ = ["Monomials", "monomials", "multiply", "powers"]

Array = NDArray[np.float64]

# Products of coefficients that a table may list, half of them twice as pairs of 16 bytes.
LARGEST = 5_000_000


class Monomials(NamedTuple):
    """The monomials of w variables up to an order, and the table of their products.

    Attributes:
        exponents: multi-indices α (M, w), by degree.
        starts: where each degree begins (order + 2,).
        places: for each monomial, and one beyond, where its pairs begin in the list, and its
            square root, or 0 (the constant) if there is none (M + 1, 2).
        pairs: factors, neither of them constant, of which the product is a monomial (P, 2).
    """

    exponents: IntArray
    starts: IntArray
    places: IntArray
    pairs: IntArray


def monomials(width: int, order: int) -> Monomials:
    """The monomials of ``width`` variables up to degree ``order``.

    Raises:
        LinkageError: there are too many of them.
    """
    products = comb(2 * width + order, order)
    if products > LARGEST:
        raise LinkageError(
            f"order {order} in {width} inputs takes {products:.1e} products; "
            "give a lower order, or restrict the motion"
        )
    rows = [
        np.bincount(factors, minlength=width)
        for k in range(order + 1)
        for factors in combinations_with_replacement(range(width), k)
    ] if width else [np.zeros(0, np.int64)]  # fmt: skip
    exponents = frozen(np.reshape(np.array(rows, dtype=np.int64), (-1, width)), np.int64)
    starts = np.searchsorted(exponents.sum(axis=1), np.arange(order + 2))
    # Sums of codes are codes of products, and within a degree codes descend.
    codes = exponents @ (order + 1) ** np.arange(width, dtype=np.int64)[::-1]
    places = np.zeros((len(codes) + 1, 2), np.int64)
    _list_factors(codes, starts, places, np.empty((0, 2), np.int64))
    np.cumsum(places[:, 0], out=places[:, 0])
    pairs = np.empty((int(places[-1, 0]), 2), np.int64)
    _list_factors(codes, starts, places.copy(), pairs)
    return Monomials(*(frozen(x, np.int64) for x in (exponents, starts, places, pairs)))


@kernel
def _list_factors(codes, starts, places, pairs):
    """Sort pairs of factors by their product: count them, or list them if there is room.

    ``places[t, 0]`` is where the next pair whose product is t is listed; when they are only
    counted, ``places[t + 1, 0]`` is how many there are.
    """
    order = starts.size - 2
    counting = pairs.shape[0] == 0
    for a in range(1, order):
        for b in range(a, order + 1 - a):
            for i in range(starts[a], starts[a + 1]):
                t = starts[a + b]
                for j in range(max(i, starts[b]), starts[b + 1]):
                    while codes[t] != codes[i] + codes[j]:
                        t += 1
                    if i == j:
                        places[t, 1] = i
                    elif counting:
                        places[t + 1, 0] += 1
                    else:
                        pairs[places[t, 0], 0], pairs[places[t, 0], 1] = i, j
                        places[t, 0] += 1


@kernel
def multiply(begin, end, count, lanes, places, pairs, left, right, out):
    """Products of polynomials side by side: their monomials begin … end, into ``out``.

    Arrays are flat, with ``lanes`` numbers for each monomial, one for each product; the first
    ``count`` of them are formed, and others up to a multiple of `LANES`. Constant terms of
    the factors must be 0.
    """
    for t in range(begin, end):
        for x in range(0, count, LANES):
            root = places[t, 1] * lanes + x
            total = load(left, root) * load(right, root)
            for p in range(places[t, 0], places[t + 1, 0]):
                i, j = pairs[p, 0] * lanes + x, pairs[p, 1] * lanes + x
                both = load(left, i) * load(right, j) + load(left, j) * load(right, i)
                total = total + both
            store(out, t * lanes + x, total)


def powers(exponents: IntArray, u: Array) -> Array:
    """Monomials ``u^α`` at points u (..., w); shape (..., M)."""
    highest = int(exponents.max(initial=0))
    table = u[..., None] ** np.arange(highest + 1)
    result = np.ones((*u.shape[:-1], len(exponents)))
    for v in range(exponents.shape[1]):
        result *= table[..., v, :][..., exponents[:, v]]
    return result
