"""Whole polynomials of roots of unity: cyclotomic ones, and those of ``2 cos(2π/N)``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache


@cache
def prime_factors(n: int) -> tuple[int, ...]:
    """Find the prime factors of a number, each once."""
    factors, d = [], 2
    while n > 1:
        if n % d == 0:
            factors.append(d)
            while n % d == 0:
                n //= d
        d += 1
    return tuple(factors)


@cache
def minimal_polynomial(N: int) -> tuple[int, ...]:
    """Compute the coefficients of the minimal polynomial of ``2 cos(2π/N)``, constant first.

    ``Φ_N(z) = z^n ψ(z + 1/z)`` for N > 2; written by ``z^k + z^-k = D_k(c)``.
    """
    if N <= 2:
        return (-2, 1) if N == 1 else (2, 1)
    phi = _cyclotomic(N)
    n = len(phi) // 2
    total = [0] * (n + 1)
    for k in range(n + 1):
        for i, a in enumerate(_dickson(k)):
            total[i] += phi[n + k] * a
    return tuple(total)


@cache
def _dickson(k: int) -> tuple[int, ...]:
    """Compute D_k with ``D_k(z + 1/z) = z^k + z^-k``; 1 for k = 0, counted once."""
    if k == 0:
        return (1,)
    before, here = [2], [0, 1]
    for _ in range(k - 1):
        following = [0, *here]
        for i, a in enumerate(before):
            following[i] -= a
        before, here = here, following
    return tuple(here)


@cache
def _cyclotomic(N: int) -> tuple[int, ...]:
    """Compute the coefficients of the cyclotomic polynomial, by division of ``z^N - 1``."""
    polynomial = [-1, *[0] * (N - 1), 1]
    for d in range(1, N):
        if N % d == 0:
            polynomial = _divide(polynomial, _cyclotomic(d))
    return tuple(polynomial)


def _divide(a: list[int], b: Sequence[int]) -> list[int]:
    """Divide polynomials without a remainder; b has the leading coefficient 1."""
    a, quotient = list(a), [0] * (len(a) - len(b) + 1)
    for k in reversed(range(len(quotient))):
        quotient[k] = a[k + len(b) - 1]
        for i, x in enumerate(b):
            a[k + i] -= quotient[k] * x
    return quotient
