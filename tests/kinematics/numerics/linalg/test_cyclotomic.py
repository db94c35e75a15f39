"""Numbers of real cyclotomic fields, against 40 digits of mpmath and the laws of a field."""

from fractions import Fraction
from math import gcd
from random import Random

import pytest
from mpmath import cos, mpf, pi, sin, sqrt, workdps

from kinematics.numerics.linalg.cyclotomic import (
    FieldNumber,
    conductor_of_root,
    cosine_of_part,
    degree_of_field,
    number_remainder,
    prime_has_field,
    root_of_integer,
    sine_of_part,
)
from kinematics.numerics.linalg.rational import echelon, root

CONDUCTORS = (8, 12, 16, 20, 24, 28, 36, 60)
# Primes -1 modulo the conductor: 12 k - 1, and 60 k - 1.
PRIMES = {12: 1073741783, 60: 1073741399}


def close(x, y):
    """Whether a number of a field is a real number, to 40 digits."""
    near = x.nearby if isinstance(x, FieldNumber) else Fraction(x)
    return abs(mpf(near.numerator) / near.denominator - y) < mpf("1e-38")


def some(rng, N):
    """A number of the field of conductor N."""
    return sum(
        (
            Fraction(rng.randint(-9, 9), rng.randint(1, 5)) * cosine_of_part(k, N)
            for k in range(degree_of_field(N))
        ),
        Fraction(0),
    )


@pytest.mark.parametrize("N", CONDUCTORS)
def test_cosines_and_sines_are_those_of_mpmath(N):
    with workdps(45):
        for k in range(-2, N + 2):
            assert close(cosine_of_part(k, N), cos(2 * pi * k / N))
            assert close(sine_of_part(k, N), sin(2 * pi * k / N))
            assert cosine_of_part(k, N) ** 2 + sine_of_part(k, N) ** 2 == 1


@pytest.mark.parametrize("d", [2, 3, 5, 6, 7, 10, 13, 15])
def test_roots_of_integers_are_the_positive_ones(d):
    N = conductor_of_root(d)
    found = root_of_integer(d, N)
    assert found * found == d and found > 0 and root(found) is None
    with workdps(45):
        assert close(found, sqrt(d))
    if 60 % N == 0:
        assert root_of_integer(d, 60) ** 2 == d


@pytest.mark.parametrize("N", [12, 36, 60])
def test_laws_of_a_field(N):
    rng = Random(N)
    for _ in range(10):
        a, b, c = (some(rng, N) for _ in range(3))
        assert a * (b + c) == a * b + a * c and (a * b) * c == a * (b * c)
        assert a - a == 0 and not a - a and type(a - a) is Fraction
        if a and b:
            assert (a / b) * (b / a) == 1 and type((a / b) * (b / a)) is Fraction
        assert (a < b) == (float(a) < float(b)) and abs(a) == abs(-a)
        assert Fraction(1, 3) - a == -(a - Fraction(1, 3)) and 2 * a == a + a


def test_elimination_in_a_field_sees_what_depends():
    r = root_of_integer(3, 12)
    rows = [[Fraction(1), r, Fraction(0)], [r, Fraction(3), Fraction(0)], [r, r, Fraction(1)]]
    assert len(echelon(rows)[0]) == 2


@pytest.mark.parametrize("N", [12, 60])
def test_remainders_are_a_homomorphism(N):
    p, rng = PRIMES[N], Random(7)
    assert prime_has_field(p, N) and all(pow(a, p - 1, p) == 1 for a in (2, 3, 5, 7))
    for _ in range(10):
        a, b = some(rng, N), some(rng, N)
        x, y = number_remainder(a, p), number_remainder(b, p)
        assert number_remainder(a * b, p) == x * y % p
        assert number_remainder(a + b, p) == (x + y) % p
    assert number_remainder(root_of_integer(3, N), p) ** 2 % p == 3


def test_degrees_are_half_of_what_is_prime_to_the_conductor():
    for N in CONDUCTORS:
        assert degree_of_field(N) == sum(gcd(k, N) == 1 for k in range(N)) // 2


def test_numbers_of_two_fields_do_not_mix():
    with pytest.raises(ValueError, match="two fields"):
        root_of_integer(3, 12) + root_of_integer(2, 8)
    with pytest.raises(TypeError, match="numerator"):
        _ = root_of_integer(3, 12).numerator
