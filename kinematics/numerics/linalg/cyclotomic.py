"""Numbers of real cyclotomic fields: roots of small integers, sines and cosines of parts of π.

The field ``Q(c)``, ``c = 2 cos(2π/N)``, has degree ``φ(N)/2``. It holds ``cos(2πk/N)``, sines
if 4 divides N, and the root of each integer whose quadratic field has a conductor that divides
N (L. C. Washington, Introduction to Cyclotomic Fields, chapter 2; roots are Gauss sums). A
number is a polynomial in c with rational coefficients; sums, products and quotients are exact,
and zero is told from others exactly. Those that are rational become fractions.

Modulo a prime ``p ≡ -1`` modulo N the polynomial of c has roots: a trace of order N. Each one
gives a ring homomorphism, so what does not vanish there does not vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from math import gcd, isqrt, lcm, prod
from typing import NamedTuple

from kinematics.numerics.linalg.rational import echelon, pi

MAX_DEGREE = 8
"""Largest degree of a field: products take its square of steps."""
# Bits of the rational number next to c, with which numbers are compared.
_PRECISION = 160


@cache
def degree_of_field(N: int) -> int:
    """Compute the degree ``φ(N)/2`` of the field of ``2 cos(2π/N)``."""
    totient = N
    for q in prime_factors(N):
        totient -= totient // q
    return max(1, totient // 2)


class _Field(NamedTuple):
    """The field of c.

    Attributes:
        conductor: N.
        degree: n.
        powers: ``c^n … c^(2n-2)`` as polynomials of degree below n.
        value: c, to `_PRECISION` bits.
    """

    conductor: int
    degree: int
    powers: tuple[tuple[int, ...], ...]
    value: Fraction


@cache
def _field(N: int) -> _Field:
    """Make the field of ``c = 2 cos(2π/N)``."""
    minimal = minimal_polynomial(N)
    n = len(minimal) - 1
    powers = [tuple(-a for a in minimal[:-1])]
    while len(powers) < n - 1:
        last = powers[-1]
        moved = [0, *last[:-1]]
        powers.append(tuple(a + last[-1] * b for a, b in zip(moved, powers[0], strict=True)))
    return _Field(N, n, tuple(powers[: n - 1]), _cosine(2 * pi() / N) * 2)


def _cosine(x: Fraction) -> Fraction:
    """Compute a cosine to `_PRECISION` bits."""
    unit = 1 << _PRECISION
    square = round(x * x * unit)
    term, total, k = unit, 0, 0
    while term:
        total += term
        k += 2
        size = abs(term) * square // (unit * k * (k - 1))
        term = -size if term > 0 else size
    return Fraction(total, unit)


class FieldNumber(Fraction):
    """An irrational number of a real cyclotomic field; it computes as fractions do.

    Results that are rational are fractions. It is not a quotient of whole numbers: numerator is
    undefined.
    """

    __slots__ = ("_coefficients", "_common", "_of")

    _of: _Field
    _coefficients: tuple[int, ...]
    _common: int

    @staticmethod
    def _make(of: _Field, coefficients: Sequence[int], common: int) -> Fraction:
        """Make ``Σ_i a_i c^i / common``; a fraction if it is rational."""
        if not any(coefficients[1:]):
            return Fraction(coefficients[0], common)
        divisor = gcd(common, *coefficients)
        if common < 0:
            divisor = -divisor
        number = Fraction.__new__(FieldNumber)
        assert isinstance(number, FieldNumber)
        number._of = of
        number._coefficients = tuple(a // divisor for a in coefficients)
        number._common = common // divisor
        return number

    @property
    def conductor(self) -> int:
        """Conductor N of its field."""
        return self._of.conductor

    @property
    def numerator(self) -> int:
        """Not defined.

        Raises:
            TypeError: always.
        """
        raise TypeError("an irrational number has no numerator")

    @property
    def denominator(self) -> int:
        """Least common denominator of the coefficients."""
        return self._common

    def _other(self, x: object) -> tuple[tuple[int, ...], int] | None:
        """Coefficients and denominator of another operand; None if it is no exact number."""
        if isinstance(x, FieldNumber):
            if x._of is not self._of:
                raise ValueError("numbers of two fields")
            return x._coefficients, x._common
        if isinstance(x, (int, Fraction)):
            zeros = (0,) * (self._of.degree - 1)
            return (x.numerator, *zeros), x.denominator
        return None

    def __add__(self, x):  # type: ignore[no-untyped-def]
        """Add."""
        other = self._other(x)
        if other is None:
            return float(self) + x
        b, d = other
        e = self._common
        return self._make(
            self._of, [p * d + q * e for p, q in zip(self._coefficients, b, strict=True)], d * e
        )

    __radd__ = __add__

    def __neg__(self):  # type: ignore[no-untyped-def]
        """Change the sign."""
        return self._make(self._of, [-a for a in self._coefficients], self._common)

    def __pos__(self):  # type: ignore[no-untyped-def]
        """Return it."""
        return self

    def __sub__(self, x):  # type: ignore[no-untyped-def]
        """Subtract."""
        return self + -x

    def __rsub__(self, x):  # type: ignore[no-untyped-def]
        """Subtract it from another number."""
        return -self + x

    def __mul__(self, x):  # type: ignore[no-untyped-def]
        """Multiply."""
        other = self._other(x)
        if other is None:
            return float(self) * x
        b, d = other
        if not any(b[1:]):
            return self._make(
                self._of, [a * b[0] for a in self._coefficients], self._common * d
            )
        return self._make(self._of, _product(self._of, self._coefficients, b), self._common * d)

    __rmul__ = __mul__

    def _inverse(self) -> Fraction:
        """Invert: the unknown coefficients solve ``Σ_i x_i (a c^i) = 1``."""
        n = self._of.degree
        columns, moved = [], self._coefficients
        generator = (0, 1, *[0] * (n - 2))
        for _ in range(n):
            columns.append(moved)
            moved = tuple(_product(self._of, moved, generator))
        rows = [[Fraction(column[i]) for column in columns] for i in range(n)]
        for i, row in enumerate(rows):
            row.append(Fraction(int(i == 0) * self._common))
        solution = [row[-1] for row in echelon(rows)[0]]
        common = lcm(*(x.denominator for x in solution))
        return self._make(
            self._of, [x.numerator * (common // x.denominator) for x in solution], common
        )

    def __truediv__(self, x):  # type: ignore[no-untyped-def]
        """Divide."""
        if isinstance(x, FieldNumber):
            return self * x._inverse()
        if isinstance(x, (int, Fraction)):
            return self * Fraction(x.denominator, x.numerator)
        return float(self) / x

    def __rtruediv__(self, x):  # type: ignore[no-untyped-def]
        """Divide another number by it."""
        return self._inverse() * x

    def __pow__(self, k):  # type: ignore[no-untyped-def]
        """Raise to a whole power that is not negative."""
        return prod([self] * k, start=Fraction(1))

    def __bool__(self) -> bool:
        """Return True: it is irrational."""
        return True

    @property
    def nearby(self) -> Fraction:
        """A rational number next to it."""
        total = Fraction(0)
        for a in reversed(self._coefficients):
            total = total * self._of.value + a
        return total / self._common

    def __float__(self) -> float:
        """Nearest double, but for round-off."""
        return float(self.nearby)

    def __abs__(self):  # type: ignore[no-untyped-def]
        """Size."""
        return -self if self.nearby < 0 else self

    def __eq__(self, x: object) -> bool:
        """Whether it is the same number."""
        return isinstance(x, FieldNumber) and self._key == x._key

    def __hash__(self) -> int:  # type: ignore[override]
        """Hash of field and coefficients."""
        return hash(self._key)

    @property
    def _key(self) -> tuple[object, ...]:
        return self._of.conductor, self._coefficients, self._common

    def __lt__(self, x) -> bool:  # type: ignore[no-untyped-def]
        """Compare."""
        return self.nearby < _near(x)

    def __le__(self, x) -> bool:  # type: ignore[no-untyped-def]
        """Compare."""
        return self.nearby <= _near(x)

    def __gt__(self, x) -> bool:  # type: ignore[no-untyped-def]
        """Compare."""
        return self.nearby > _near(x)

    def __ge__(self, x) -> bool:  # type: ignore[no-untyped-def]
        """Compare."""
        return self.nearby >= _near(x)

    def __str__(self) -> str:
        """Give the polynomial in ``c = 2 cos(2π/N)``."""
        terms = [
            f"{Fraction(a, self._common)} c^{i}" for i, a in enumerate(self._coefficients) if a
        ]
        return f"{' + '.join(terms)}, c = 2 cos(2π/{self.conductor})"

    __repr__ = __str__

    def remainder(self, p: int) -> int:
        """Compute its image modulo a prime.

        Args:
            p: a prime ``-1`` modulo N that does not divide the denominator.

        Raises:
            ValueError: it does.
        """
        total, c = 0, _modular_generator(self.conductor, p)
        for a in reversed(self._coefficients):
            total = (total * c + a) % p
        return total * pow(self._common, -1, p) % p


def _near(x: Fraction | int | float) -> Fraction | int | float:
    return x.nearby if isinstance(x, FieldNumber) else x


def _product(of: _Field, a: Sequence[int], b: Sequence[int]) -> list[int]:
    """Multiply polynomials in c, and reduce the product."""
    n = of.degree
    full = [0] * (2 * n - 1)
    for i, x in enumerate(a):
        if x:
            for j, y in enumerate(b):
                full[i + j] += x * y
    reduced = full[:n]
    for x, power in zip(full[n:], of.powers, strict=True):
        if x:
            for i, y in enumerate(power):
                reduced[i] += x * y
    return reduced


def number_remainder(x: Fraction, p: int) -> int:
    """Compute the image of a number modulo a prime.

    Args:
        x: a fraction, or a number of a field that has one; see `prime_has_field`.

    Raises:
        ValueError: it divides the denominator.
    """
    if isinstance(x, FieldNumber):
        return x.remainder(p)
    return x.numerator * pow(x.denominator, -1, p) % p


def prime_has_field(p: int, N: int) -> bool:
    """Whether the field of conductor N has a homomorphism modulo p that is computed here.

    Args:
        N: the conductor, 1 for the rational numbers.
    """
    return (p + 1) % N == 0


@cache
def _modular_generator(N: int, p: int) -> int:
    """Find the image of ``2 cos(2π/N)``: the trace ``z + 1/z`` of an element of order N.

    Elements of norm 1 of the field of p² numbers form a cyclic group of ``p + 1``.
    """
    for trace in range(3, p):
        if pow(trace * trace - 4, (p - 1) // 2, p) != p - 1:
            continue
        candidate = _lucas(trace, (p + 1) // N, p)
        if all(_lucas(candidate, N // q, p) != 2 for q in prime_factors(N)):
            return candidate
    raise ValueError(f"no root modulo {p}")


def _lucas(trace: int, k: int, p: int) -> int:
    """Compute ``z^k + z^-k`` from ``z + 1/z`` modulo p, by doubling."""
    low, high = 2, trace
    for bit in bin(k)[2:]:
        middle = (low * high - trace) % p
        if bit == "1":
            low, high = middle, (high * high - 2) % p
        else:
            low, high = (low * low - 2) % p, middle
    return low


@cache
def cosine_of_part(k: int, N: int) -> Fraction:
    """Compute ``cos(2πk/N)`` in the field of conductor N."""
    of = _field(N)
    k %= N
    k = min(k, N - k)
    if k == 0:
        return Fraction(1)
    generator = (0, 1, *[0] * (of.degree - 2)) if of.degree > 1 else (round(of.value),)
    before, here = [2, *[0] * (of.degree - 1)], list(generator)
    for _ in range(k - 1):
        following = _product(of, here, generator)
        before, here = here, [a - b for a, b in zip(following, before, strict=True)]
    return FieldNumber._make(of, here, 2)


def sine_of_part(k: int, N: int) -> Fraction:
    """Compute ``sin(2πk/N)`` in the field of conductor N, which 4 divides."""
    return cosine_of_part(N // 4 - k, N)


def conductor_of_root(d: int) -> int:
    """Compute a conductor of a cyclotomic field that has the root of a number.

    Args:
        d: a positive number that no square divides.
    """
    parts = (8 if q == 2 else q if q % 4 == 1 else 4 * q for q in prime_factors(d))
    return lcm(1, *parts)


@cache
def root_of_integer(d: int, N: int) -> Fraction:
    """Compute the root of a number, by Gauss sums over its prime factors.

    Args:
        d: a positive number that no square divides, or 1.
        N: a conductor that `conductor_of_root` divides.
    """
    total = Fraction(1)
    for q in prime_factors(d):
        if q == 2:
            total *= 2 * cosine_of_part(N // 8, N)
            continue
        value = Fraction(0)
        for a in range(1, (q - 1) // 2 + 1):
            symbol = 1 if pow(a, (q - 1) // 2, q) == 1 else -1
            part = cosine_of_part if q % 4 == 1 else sine_of_part
            value += 2 * symbol * part(a * (N // q), N)
        total *= value
    assert isqrt(d) ** 2 == d or total * total == d
    return total


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
