"""Multiply and evaluate polynomials in several variables, for Taylor expansions.

A polynomial is a row of coefficients, one for each monomial ``u^α = Π u_i^{α_i}``: those of
degree 0, then of degree 1, and so on up to the order; within a degree u_1 comes first, as in
``1, u_1, u_2, u_1², u_1 u_2, u_2²``. A mixed partial derivative is symmetric, and is stored
once: it is ``α!`` times the coefficient of ``u^α``.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations_with_replacement
from math import comb
from typing import NamedTuple

import numpy as np

from kinematics.errors import LinkageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import VECTOR_WIDTH, broadcast, load_vector, store_vector

# Largest number of products in a table, which lists half of them as pairs of 16 bytes.
MAX_PRODUCTS = 5_000_000


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


@lru_cache(maxsize=16)
def monomial_table(width: int, order: int) -> Monomials:
    """List the monomials of ``width`` variables up to degree ``order``, and their products.

    Args:
        order: highest degree.

    Returns:
        Exponents and products.

    Raises:
        LinkageError: there are too many products.
    """
    products = comb(2 * width + order, order)
    if products > MAX_PRODUCTS:
        raise LinkageError(
            f"order {order} in {width} inputs takes {products:.1e} products; "
            "give a lower order, or restrict the motion"
        )
    rows = (
        [
            np.bincount(factors, minlength=width)
            for k in range(order + 1)
            for factors in combinations_with_replacement(range(width), k)
        ]
        if width
        else [np.zeros(0, np.int64)]
    )
    exponents = freeze(np.reshape(np.array(rows, dtype=np.int64), (-1, width)), np.int64)
    starts = np.searchsorted(exponents.sum(axis=1), np.arange(order + 2))
    # Sums of codes are codes of products, and within a degree codes descend.
    codes = exponents @ (order + 1) ** np.arange(width, dtype=np.int64)[::-1]
    places = np.zeros((len(codes) + 1, 2), np.int64)
    _list_factors(codes, starts, places, np.empty((0, 2), np.int64))
    np.cumsum(places[:, 0], out=places[:, 0])
    pairs = np.empty((int(places[-1, 0]), 2), np.int64)
    _list_factors(codes, starts, places.copy(), pairs)
    return Monomials(*(freeze(x, np.int64) for x in (exponents, starts, places, pairs)))


@kernel
def _list_factors(codes, starts, places, pairs):
    """Sort pairs of factors by their product: count them, or list them.

    Args:
        codes: in; codes of the monomials, which add up as these multiply (M,).
        starts: in; where each degree begins (order + 2,).
        places: in and out (M + 1, 2). ``places[t, 0]`` is where the next pair whose product is
            t is listed; when they are counted, ``places[t + 1, 0]`` is how many there are.
            ``places[t, 1]`` takes the square root of t.
        pairs: out; factors (P, 2). An array of length 0 says that they are only counted.
    """
    order = starts.size - 2
    # degrees a ≤ b of the two factors
    for a in range(1, order):
        for b in range(a, order + 1 - a):
            for i in range(starts[a], starts[a + 1]):
                _list_products(i, a, b, codes, starts, places, pairs)


@kernel(inline=True)
def _list_products(i, a, b, codes, starts, places, pairs):
    """Count or list the products of monomial i, of degree a, with those of degree b.

    Codes descend within a degree: as j goes on, so does the product t.

    Args:
        a: its degree.
        b: degree of the other factor.
        codes: in; as in `_list_factors`, as are the others.
        starts: in.
        places: in and out.
        pairs: out.
    """
    counting = pairs.shape[0] == 0
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


@kernel(inline=True, reference_counting=False)
def multiply_polynomials(
    begin, end, count, lanes, places, pairs, left_factors, right_factors, out
):
    """Multiply polynomials side by side: the coefficients of monomials begin … end.

    ``out_t = a_r b_r + Σ_(i,j) (a_i b_j + a_j b_i)`` with the left factors a and the right ones
    b, the root r of t, if it is a square, and the pairs (i, j) of different factors of t.
    Constant terms of the factors must be 0: monomials that are no squares have the root 0.

    Args:
        end: monomial after the last one.
        count: number of products; it is rounded up to a multiple of `VECTOR_WIDTH`.
        lanes: numbers of each monomial, one for each product; a multiple of `VECTOR_WIDTH`.
        places: in; as in `Monomials`.
        pairs: in; as in `Monomials`.
        left_factors: in; flat (monomials * lanes,).
        right_factors: in; likewise.
        out: out; products.
    """
    for t in range(begin, end):
        for x in range(0, count, VECTOR_WIDTH):
            root = places[t, 1] * lanes + x  # that of the constant term, 0, if there is none
            total = load_vector(left_factors, root) * load_vector(right_factors, root)
            # Two sums hide the latency of additions, and a slice what signs of indices cost.
            other, factors = broadcast(0.0), pairs[places[t, 0] : places[t + 1, 0]]
            for p in range(factors.shape[0]):
                i, j = factors[p, 0] * lanes + x, factors[p, 1] * lanes + x
                total = total + load_vector(left_factors, i) * load_vector(right_factors, j)
                other = other + load_vector(left_factors, j) * load_vector(right_factors, i)
            store_vector(out, t * lanes + x, total + other)


def monomial_powers(exponents: IntArray, u: Array) -> Array:
    """Evaluate monomials ``u^α``.

    Args:
        exponents: multi-indices α (M, w).
        u: points (..., w).

    Returns:
        Shape (..., M).
    """
    if u.ndim == 1:  # a third of the time of a table
        powers: Array = np.multiply.reduce(u**exponents, axis=1)
        return powers
    highest = int(exponents.max(initial=0))
    table = u[..., None] ** np.arange(highest + 1)
    result = np.ones((*u.shape[:-1], len(exponents)))
    for v in range(exponents.shape[1]):
        result *= table[..., v, :][..., exponents[:, v]]
    return result
