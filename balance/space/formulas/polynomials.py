"""Polynomials with rational coefficients in several variables, and quotients of their products.

A polynomial is a mapping from exponents to coefficients that do not vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import comb, gcd, lcm
from typing import NamedTuple

Exponents = tuple[int, ...]
Polynomial = dict[Exponents, Fraction]


def leading(polynomial: Polynomial) -> Exponents:
    """Return the largest exponents, in lexicographic order."""
    return max(polynomial)


def quotient_of(a: Polynomial, b: Polynomial) -> Polynomial | None:
    """Divide a by b; None if there is a remainder."""
    rest, quotient = dict(a), {}
    top = leading(b)
    while rest:
        e = leading(rest)
        shift = tuple(i - j for i, j in zip(e, top, strict=True))
        if min(shift) < 0:
            return None
        factor = rest[e] / b[top]
        quotient[shift] = factor
        for f, y in b.items():
            key = tuple(i + j for i, j in zip(shift, f, strict=True))
            value = rest.get(key, Fraction(0)) - factor * y
            if value:
                rest[key] = value
            else:
                rest.pop(key, None)
    return quotient


def value_of(polynomial: Polynomial, values: Sequence[complex]) -> complex:
    """Evaluate a polynomial."""
    total = 0j
    for exponents, coefficient in polynomial.items():
        term = complex(coefficient)
        for x, n in zip(values, exponents, strict=True):
            term *= x**n
        total += term
    return total


def _remainder_of(polynomial: Polynomial, values: Sequence[int], p: int) -> int:
    """Evaluate a polynomial modulo a prime."""
    total = 0
    for exponents, c in polynomial.items():
        term = c.numerator * pow(c.denominator, -1, p)
        for x, n in zip(values, exponents, strict=True):
            term = term * pow(x, n, p) % p
        total += term
    return total % p


def primitive(polynomial: Polynomial) -> tuple[Fraction, Exponents, Polynomial]:
    """Split off the content, with the sign of the leading term, and the common monomial."""
    numerators = gcd(*(c.numerator for c in polynomial.values()))
    denominators = lcm(*(c.denominator for c in polynomial.values()))
    content = Fraction(numerators, denominators)
    if polynomial[leading(polynomial)] < 0:
        content = -content
    common = tuple(map(min, zip(*polynomial, strict=True)))
    rest = {
        tuple(i - j for i, j in zip(e, common, strict=True)): c / content
        for e, c in polynomial.items()
    }
    return content, common, rest


def in_fewest_terms(polynomial: Polynomial, cosines: Sequence[int]) -> Polynomial:
    """Write squares of cosines by sines wherever that leaves fewer terms.

    Args:
        polynomial: the polynomial; sines occur at most once in a term.
        cosines: places of cosines among the variables; a sine follows each.
    """
    for place in cosines:
        written = _by_sines(polynomial, place)
        if len(written) < len(polynomial):
            polynomial = written
    return polynomial


def _by_sines(polynomial: Polynomial, place: int) -> Polynomial:
    """Replace ``c²`` by ``1 - s²``, until the cosine occurs at most once in a term."""
    out: Polynomial = {}
    for exponents, coefficient in polynomial.items():
        half, odd = divmod(exponents[place], 2)
        for n in range(half + 1):
            powers = list(exponents)
            powers[place], powers[place + 1] = odd, exponents[place + 1] + 2 * n
            key = tuple(powers)
            value = out.get(key, Fraction(0)) + coefficient * comb(half, n) * (-1) ** n
            if value:
                out[key] = value
            else:
                out.pop(key, None)
    return out


class Quotient(NamedTuple):
    """A rational function as a product of powers.

    Attributes:
        content: rational factor.
        monomial: exponents of the variables, negative in the denominator.
        factors: primitive polynomials of several terms, each with its exponent.
    """

    content: Fraction
    monomial: Exponents
    factors: tuple[tuple[Polynomial, int], ...]

    def value(self, values: Sequence[complex]) -> complex:
        """Evaluate at values of the variables."""
        total = complex(self.content)
        for x, n in zip(values, self.monomial, strict=True):
            total *= x**n
        for polynomial, n in self.factors:
            total *= value_of(polynomial, values) ** n
        return total

    def remainder(self, values: Sequence[int], p: int) -> int:
        """Evaluate modulo a prime."""
        total = self.content.numerator * pow(self.content.denominator, -1, p)
        for x, n in zip(values, self.monomial, strict=True):
            total = total * pow(x, n, p) % p
        for polynomial, n in self.factors:
            total = total * pow(_remainder_of(polynomial, values, p), n, p) % p
        return total


class FactorPool:
    """Factors seen so far: a polynomial is divided by all of them before it counts as one."""

    def __init__(self) -> None:
        """Start without factors."""
        self._known: list[Polynomial] = []

    def learn(self, polynomial: Polynomial) -> None:
        """Remember what is left of a polynomial after division by the factors known."""
        for _, rest in [(0, primitive(polynomial)[2])]:
            for factor in self._known:
                while len(rest) > 1 and (smaller := quotient_of(rest, factor)) is not None:
                    rest = smaller
            if len(rest) > 1:
                self._known.append(rest)
        self._known.sort(key=lambda each: (sum(leading(each)), len(each)))

    def factorise(self, numerator: Polynomial, denominator: Polynomial) -> Quotient:
        """Write a quotient as a product of known factors."""
        content, monomial = Fraction(1), (0,) * len(leading(numerator))
        powers: list[tuple[Polynomial, int]] = []
        for polynomial, sign in ((numerator, 1), (denominator, -1)):
            size, common, rest = primitive(polynomial)
            content *= size**sign
            monomial = tuple(i + sign * j for i, j in zip(monomial, common, strict=True))
            for factor in self._known:
                count = 0
                while len(rest) > 1 and (smaller := quotient_of(rest, factor)) is not None:
                    rest, count = smaller, count + 1
                if count:
                    powers.append((factor, sign * count))
            size, common, rest = primitive(rest)
            content *= size**sign
            monomial = tuple(i + sign * j for i, j in zip(monomial, common, strict=True))
            if len(rest) > 1:
                powers.append((rest, sign))
        return Quotient(content, monomial, tuple(powers))
