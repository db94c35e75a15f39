"""Square roots modulo primes: the lengths of axes that relations of rates compare.

A rate of a screw is that of its joint over the length of the axis, a square root. Square
classes of lengths are written over pairwise coprime numbers ``b_i`` that are no squares. Then
the field of the roots ``√b_i`` has degree ``2^k``, its automorphisms change the sign of each
root alone, and any choice of roots modulo a prime in which all ``b_i`` are squares extends to a
ring homomorphism: a minor that does not vanish there does not vanish. (S. Lang, Algebra,
chapter VI, on Kummer extensions.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import islice
from math import gcd, isqrt

from balance.space.exact.modular import PRIMES
from kinematics.errors import ExactError
from kinematics.numerics.linalg.cyclotomic import prime_has_field

# Most square roots that need not be rational: half of the primes do for each.
MAX_RADICANDS = 10
# Bases with which the test of Miller and Rabin is certain below 3.2e9.
WITNESSES = (2, 3, 5, 7)


def square_classes(squares: Sequence[Fraction]) -> list[frozenset[int]]:
    """Write each positive number as a square times a product of a common set of numbers.

    Returns:
        For each number b_i, pairwise coprime and no squares, of which the product is the
        number but for a rational square; the same b_i for all of the numbers.
    """
    whole = [square.numerator * square.denominator for square in squares]
    basis: list[int] = []
    for number in whole:
        basis = _refine(basis, number)
    radicands = [b for b in basis if isqrt(b) ** 2 != b]
    return [frozenset(b for b in radicands if _multiplicity(number, b) % 2) for number in whole]


def _refine(basis: list[int], number: int) -> list[int]:
    """Extend pairwise coprime numbers so that products of them give another number too."""
    if number == 1:
        return basis
    for k, b in enumerate(basis):
        common = gcd(number, b)
        if common > 1:
            rest = basis[:k] + basis[k + 1 :]
            for part in (b // common, common, number // common):
                rest = _refine(rest, part)
            return rest
    return [*basis, number]


def _multiplicity(number: int, factor: int) -> int:
    """Count how many times a number has a factor."""
    count = 0
    while number % factor == 0:
        number //= factor
        count += 1
    return count


def primes_with_roots(radicands: Sequence[int], conductor: int = 1) -> Iterator[int]:
    """Yield the usual primes in which numbers have square roots, and where few do, others.

    Args:
        radicands: positive numbers, prime to the conductor.
        conductor: of the real cyclotomic field that the primes must have as well.

    Raises:
        ExactError: there are too many numbers.
    """
    if len(radicands) > MAX_RADICANDS:
        raise ExactError(
            f"the lengths of axes that relations join need {len(radicands)} square roots, more "
            f"than {MAX_RADICANDS}; write axes of equal or rational length"
        )
    if not radicands and conductor == 1:
        yield from PRIMES
        return
    suitable = (
        p for p in _primes_below(2**30, conductor) if all(_has_root(b, p) for b in radicands)
    )
    yield from islice(suitable, len(PRIMES))


def _primes_below(limit: int, conductor: int) -> Iterator[int]:
    """Yield primes ``4 k + 3`` with a field, below a limit that 4 divides, largest first."""
    numbers = (p for p in range(limit - 1, 2, -4) if prime_has_field(p, conductor))
    return filter(_is_prime, numbers)


def _is_prime(n: int) -> bool:
    """Decide whether a number ``4 k + 3`` from 11 to 3.2e9 is a prime (G. Miller, M. Rabin)."""
    return all(pow(a, (n - 1) // 2, n) in (1, n - 1) for a in WITNESSES)


def _has_root(number: int, p: int) -> bool:
    """Decide whether a number has a root other than zero modulo the prime (L. Euler)."""
    return pow(number, (p - 1) // 2, p) == 1


def modular_root(number: int, p: int) -> int:
    """Compute a square root of a number modulo a prime ``4 k + 3``.

    Args:
        number: a number that is a square modulo the prime.
    """
    return pow(number, (p + 1) // 4, p)
