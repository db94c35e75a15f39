"""Rational functions that are known come back from their values modulo a prime."""

from __future__ import annotations

import random
from collections import defaultdict
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from balance.space.formulas.interpolation import Interpolation, TooManyTermsError
from balance.space.formulas.notations import LATEX, PYTHON, TEXT, Variable, Writer
from balance.space.formulas.polynomials import (
    FactorPool,
    in_fewest_terms,
    quotient_of,
    value_of,
)
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS

P = PRIMES_OF_61_BITS[0]


def poly(**terms):
    """A polynomial in x, y, z: ``xxy=3`` is 3 x² y."""
    return {tuple(word.count(c) for c in "xyz"): Fraction(n) for word, n in terms.items()}


def product_of(a, b):
    """The product of two polynomials."""
    out = defaultdict(Fraction)
    for (e, x), (f, y) in product(a.items(), b.items()):
        out[tuple(i + j for i, j in zip(e, f, strict=True))] += x * y
    return {exponents: c for exponents, c in out.items() if c}


def at(polynomial, point):
    return (
        sum(
            c.numerator * pow(c.denominator, -1, P) * x ** e[0] * y ** e[1] * z ** e[2]
            for (x, y, z) in [point]
            for e, c in polynomial.items()
        )
        % P
    )


CASES = [
    (poly(x=1), poly(y=1)),
    (poly(xx=1, yy=1), poly(yz=Fraction(2, 3))),
    (poly(xxy=5, xyz=Fraction(-7, 9), zzz=1), poly(xx=1, xy=2, zz=-3)),
    (poly(xyz=1), poly(x=1, y=1, z=1)),
]


@pytest.mark.parametrize(("up", "down"), CASES)
def test_a_quotient_comes_back(up, down):
    rng = random.Random(1)

    def draw():
        return [rng.randrange(1, P) for _ in range(3)]

    found = Interpolation(
        lambda point: [at(up, point) * pow(at(down, point), -1, P) % P], [False] * 3, draw, P
    )
    degrees = found.degrees([0])[0]
    assert degrees.total == tuple(max(map(sum, side)) for side in (up, down))
    numerator, denominator = found.fit(0, degrees)
    assert product_of(numerator, down) == product_of(denominator, up)


def of_angles(up, down):
    """Sample a quotient of polynomials in lengths a, b and cosine and sine of two angles.

    Cosines are c and d, sines s and t. Keys are words: ``acc`` is a c².
    """

    def sample(point):
        a, b, *tangents = point
        values = dict(zip("ab", (a, b), strict=True))
        for (cosine, sine), t in zip(("cs", "dt"), tangents, strict=True):
            scale = pow(1 + t * t, -1, P)
            values[cosine], values[sine] = (1 - t * t) * scale, 2 * t * scale
        sums = []
        for side in (up, down):
            total = 0
            for word, n in side.items():
                term = n
                for letter in word.strip("1"):
                    term = term * values[letter] % P
                total += term
            sums.append(total)
        return [sums[0] * pow(sums[1], -1, P) % P]

    return sample


def value_in(polynomial, values):
    return sum(
        float(n) * np.prod([x**k for x, k in zip(values, e, strict=True)])
        for e, n in polynomial.items()
    )


ANGLES = [
    ({"as": 1}, {"b": 1}),
    ({"ccd": 2, "tt": -3}, {"s": 1}),
    ({"acst": 1, "bd": -5}, {"acd": 1, "bs": 2}),
    ({"s": 1}, {"1": 1, "c": 1}),  # tan of half the angle
    ({"aaccd": 1, "abst": 2, "bbdd": -1, "aat": 7}, {"abcd": 3, "aass": 1, "bbd": 1}),
]


@pytest.mark.parametrize(("up", "down"), ANGLES)
def test_quotients_of_cosines_and_sines_come_back(up, down):
    """Other values of the angles give the same value, whatever the writing."""
    rng = random.Random(1)
    angles = [False, False, True, True]

    def draw():
        return [rng.randrange(1, P) for _ in range(4)]

    found = Interpolation(of_angles(up, down), angles, draw, P)
    numerator, denominator = (
        in_fewest_terms(each, [2, 4]) for each in found.fit(0, found.degrees([0])[0])
    )
    a, b, x, y = 1.3, -0.7, 0.4, 2.2
    values = [a, b, np.cos(x), np.sin(x), np.cos(y), np.sin(y)]
    letters = dict(zip("abcsdt", values, strict=True))
    above, below = (
        sum(n * np.prod([letters[k] for k in word.strip("1")]) for word, n in side.items())
        for side in (up, down)
    )
    ours = value_in(numerator, values) / value_in(denominator, values)
    assert ours == pytest.approx(above / below, rel=1e-12)
    assert len(numerator) + len(denominator) <= len(up) + len(down) + 1


def test_many_variables_take_few_unknowns():
    """A sum of eight products of ten variables has some thousand monomials of its degree."""
    rng = random.Random(3)
    terms = [sorted(rng.sample(range(10), 5)) for _ in range(8)]

    def sample(point):
        total = 0
        for k, chosen in enumerate(terms):
            product = k + 1
            for i in chosen:
                product = product * point[i] % P
            total += product
        return [total % P]

    def draw():
        return [rng.randrange(1, P) for _ in range(10)]

    found = Interpolation(sample, [False] * 10, draw, P, most_unknowns=40)
    degrees = found.degrees([0])[0]
    assert degrees.unknowns() > 200
    numerator, _ = found.fit(0, degrees)
    assert {e: n / min(numerator.values()) for e, n in numerator.items()} == {
        tuple(int(i in chosen) for i in range(10)): k + 1 for k, chosen in enumerate(terms)
    }
    found.most_unknowns = 10
    with pytest.raises(TooManyTermsError):
        found.fit(0, degrees)


def test_functions_that_are_none_do_not_fit():
    rng = random.Random(2)
    found = Interpolation(
        lambda point: [rng.randrange(P)],
        [False] * 3,
        lambda: [rng.randrange(1, P) for _ in range(3)],
        P,
    )
    assert found.degrees([0])[0] is None


def test_division_and_factors():
    first, second = poly(x=1, y=-1), poly(xx=1, yz=2)
    cubic = product_of(product_of(first, first), second)
    assert quotient_of(cubic, first) == product_of(first, second)
    assert quotient_of(second, first) is None
    pool = FactorPool()
    pool.learn(first)
    quotient = pool.factorise(cubic, poly(x=3))
    assert sorted(power for _, power in quotient.factors) == [1, 2]
    point = (2.0, 3.0, 5.0)
    expected = value_of(cubic, point) / 6
    assert abs(quotient.value(point) - expected) < 1e-12


def test_notations():
    """An imaginary variable brings its i; a conjugate is written as one."""
    variables = [
        Variable("l_a", "real"),
        Variable("y_b", "imaginary"),
        Variable("z_c", "conjugate"),
    ]
    pool = FactorPool()
    quotient = pool.factorise(poly(xy=-2), poly(xz=1, zz=1))
    assert Writer(TEXT, variables).quotient(quotient) == (
        True,
        "2 i l_a y_b/(conj(z_c) (l_a + conj(z_c)))",
    )
    assert Writer(TEXT, variables).quotient(quotient, 1) == (
        False,
        "2 l_a y_b/(conj(z_c) (l_a + conj(z_c)))",
    )
    assert r"\overline{z_{\mathrm{c}}}" in Writer(LATEX, variables).quotient(quotient).text
    text = Writer(PYTHON, variables).quotient(quotient).text
    values = {"l_a": 2.0, "y_b": 3.0, "z_c": 1 + 2j, "conj": lambda z: z.conjugate()}
    exact = quotient.value([2.0, 3j, 1 - 2j])
    assert abs(-eval(text, values) - exact) < 1e-12
