"""Square roots modulo a prime, and primes in which given numbers have them."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isqrt

# Divisors that are split off, so that roots of 2, 8 and 18 are multiples of each other.
SMALL = [q for q in range(2, 1000) if all(q % d for d in range(2, isqrt(q) + 1))]


def prime_with_roots(squares: Sequence[Fraction], first: int) -> int:
    """The first prime, from one downwards, modulo which all numbers are squares."""
    atoms = {x for square in squares for x in _atoms(square)[1]}
    p = first
    while not (_is_prime(p) and all(pow(x, (p - 1) // 2, p) == 1 for x in atoms)):
        p -= 1 if p % 2 == 0 else 2
    return p


def root_of_fraction(square: Fraction, p: int) -> int:
    """A root modulo p; those of numbers of one field are of one choice of signs.

    ``√(a/b) = √(a b) / b``, and ``√(a b)`` is the product of the roots of its prime factors.
    """
    whole, atoms = _atoms(square)
    root = whole.numerator * pow(whole.denominator, -1, p) % p
    for x in atoms:
        root = root * _root(x, p) % p
    return root


def _atoms(square: Fraction) -> tuple[Fraction, list[int]]:
    """A rational factor of a root, and different numbers whose roots are the other factors.

    All but the last are prime; the last has no small divisor.
    """
    left, whole, atoms = square.numerator * square.denominator, 1, []
    for q in SMALL:
        while left % (q * q) == 0:
            left, whole = left // (q * q), whole * q
        if left % q == 0:
            left //= q
            atoms.append(q)
    if isqrt(left) ** 2 == left:
        whole, left = whole * isqrt(left), 1
    return Fraction(whole, square.denominator), [*atoms, left] if left > 1 else atoms


def _root(x: int, p: int) -> int:
    """A square root modulo a prime, by Cipolla: ``(a + √(a² - x))^((p+1)/2)``."""
    a = next(a for a in range(p) if pow(a * a - x, (p - 1) // 2, p) == p - 1)
    w = (a * a - x) % p
    result, base, power = (1, 0), (a, 1), (p + 1) // 2
    while power:
        if power & 1:
            result = _times(result, base, w, p)
        base, power = _times(base, base, w, p), power >> 1
    assert result[1] == 0 and result[0] ** 2 % p == x % p, "not a square"
    return result[0]


def _times(a: tuple[int, int], b: tuple[int, int], w: int, p: int) -> tuple[int, int]:
    """Product of ``a_0 + a_1 √w`` and ``b_0 + b_1 √w``."""
    return (a[0] * b[0] + a[1] * b[1] * w) % p, (a[0] * b[1] + a[1] * b[0]) % p


def _is_prime(p: int) -> bool:
    """By the test of Miller and Rabin, which is certain for these bases below 2³²."""
    odd, twos = p - 1, 0
    while odd % 2 == 0:
        odd, twos = odd // 2, twos + 1
    for base in (2, 3, 5, 7):
        x = pow(base, odd, p)
        if x in (1, p - 1):
            continue
        for _ in range(twos - 1):
            x = x * x % p
            if x == p - 1:
                break
        else:
            return False
    return True
