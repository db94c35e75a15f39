"""Arithmetic modulo primes of 61 bits, against fractions."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

from kinematics.numerics.linalg.prime_field import (
    PRIMES_OF_61_BITS,
    degrees_of_fraction,
    echelon_modulo,
    fraction_of,
    root_modulo,
)
from kinematics.numerics.linalg.rational import echelon

P = PRIMES_OF_61_BITS[0]


def remainder(x: Fraction, p: int = P) -> int:
    return x.numerator * pow(x.denominator, -1, p) % p


@pytest.mark.parametrize("p", PRIMES_OF_61_BITS)
def test_they_are_primes_that_are_3_modulo_4(p):
    assert p % 4 == 3 and p.bit_length() == 61
    assert all(pow(a, p - 1, p) == 1 for a in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29))


def test_fractions_come_back():
    rng = random.Random(1)
    for _ in range(50):
        x = Fraction(rng.randint(-(10**8), 10**8), rng.randint(1, 10**8))
        assert fraction_of(remainder(x), P) == x


def test_roots():
    assert root_modulo(9, P) in (3, P - 3)
    squares = [root_modulo(a, P) is not None for a in range(2, 200)]
    assert 60 < sum(squares) < 140  # half of all numbers are squares


def test_echelon_form_is_that_of_fractions():
    rng = random.Random(2)
    rows = [[Fraction(rng.randint(-9, 9)) for _ in range(6)] for _ in range(3)]
    rows.append([a + 2 * b for a, b in zip(rows[0], rows[1], strict=True)])
    exact, pivots = echelon(rows)
    found, columns = echelon_modulo([[remainder(x) for x in row] for row in rows], range(6), P)
    assert columns == pivots
    assert found == [[remainder(x) for x in row] for row in exact]


@pytest.mark.parametrize(
    ("degrees", "function"),
    [
        ((0, 0), lambda x: 5),
        ((2, 3), lambda x: (3 * x * x + 1) * pow(x**3 - 7, -1, P)),
        ((1, 1), lambda x: (x + 1) * pow(x + 2, -1, P)),
        ((0, 2), lambda x: pow(x * x + 1, -1, P)),
        ((-1, 0), lambda x: 0),
    ],
)
def test_degrees(degrees, function):
    points = range(3, 14)
    assert degrees_of_fraction(points, [function(x) % P for x in points], P) == degrees
    few = range(3, 3 + max(sum(degrees), 0) + 2)
    assert degrees_of_fraction(few, [function(x) % P for x in few], P) in (None, (-1, 0))
