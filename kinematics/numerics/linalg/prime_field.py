"""Arithmetic modulo primes of 61 bits in whole numbers of Python: for results, not for ranks.

Fractions of numerators and denominators below a billion can be read off remainders modulo
such a prime. Matrices are lists of rows; a matrix of a few hundred entries costs less here
than the calls of an array library. `balance.space.exact.modular` has ranks of large matrices.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isqrt

PRIMES_OF_61_BITS = (2**61 - 1, 2**61 - 45, 2**61 - 229, 2**61 - 465)
"""The largest primes below 2^61 that are 3 modulo 4, so that roots need one power."""

Row = list[int]


def root_modulo(a: int, p: int) -> int | None:
    """Compute a square root of a modulo a prime p that is 3 modulo 4; None without one."""
    root = pow(a, (p + 1) // 4, p)
    return root if root * root % p == a % p else None


def echelon_modulo(
    rows: Sequence[Sequence[int]], columns: Sequence[int], p: int
) -> tuple[list[Row], list[int]]:
    """Compute the reduced row echelon form modulo p, for an order of the columns.

    Args:
        rows: remainders, of equal length.
        columns: where pivots are sought, the first of them first.
        p: the prime.

    Returns:
        Independent rows, each 1 at its pivot, where the others are 0; and the pivots.
    """
    remaining = [list(row) for row in rows]
    done: list[Row] = []
    pivots: list[int] = []
    for column in columns:
        place = next((i for i, row in enumerate(remaining) if row[column]), None)
        if place is None:
            continue
        row = remaining.pop(place)
        scale = pow(row[column], -1, p)
        row = [x * scale % p for x in row]
        for group in (remaining, done):
            for i, other in enumerate(group):
                if factor := other[column]:
                    group[i] = [(x - factor * y) % p for x, y in zip(other, row, strict=True)]
        done.append(row)
        pivots.append(column)
    return done, pivots


def invert_modulo(
    A: Sequence[Sequence[int]], columns: int, p: int
) -> tuple[list[int], list[int], list[Row]]:
    """Choose independent rows and columns of a matrix, and invert them modulo p.

    Returns:
        Rows, columns (the first that are independent), and the inverse of what they share.
    """
    rows = echelon_modulo(list(zip(*A, strict=True)), range(len(A)), p)[1]
    chosen = [A[r] for r in rows]
    pivots = echelon_modulo(chosen, range(columns), p)[1]
    square = [
        [row[c] for c in pivots] + [int(r == i) for i in range(len(chosen))]
        for r, row in enumerate(chosen)
    ]
    solved, order = echelon_modulo(square, range(len(chosen)), p)
    inverse = dict(zip(order, solved, strict=True))
    return rows, pivots, [inverse[r][len(chosen) :] for r in range(len(chosen))]


def fraction_of(a: int, p: int) -> Fraction | None:
    """Find the fraction whose remainder modulo p is a; None if there is no small one.

    Numerator and denominator are below the root of p / 2, so that there is at most one (P. S.
    Wang, 1981).
    """
    bound = isqrt(p // 2)
    (r0, s0), (r1, s1) = (p, 0), (a % p, 1)
    while r1 > bound:
        q = r0 // r1
        (r0, s0), (r1, s1) = (r1, s1), (r0 - q * r1, s0 - q * s1)
    return Fraction(r1, s1) if 0 < abs(s1) <= bound else None


def degrees_of_fraction(
    points: Sequence[int], values: Sequence[int], p: int
) -> tuple[int, int] | None:
    """Find the degrees of the rational function of one variable through points, modulo p.

    Args:
        points: distinct remainders (n,).
        values: of the function there (n,).
        p: the prime.

    Returns:
        Degrees of numerator and denominator in lowest terms; None if the function has more
        coefficients than the points determine, with two to spare (J. von zur Gathen,
        J. Gerhard, Modern Computer Algebra, section 5.7).
    """
    if not any(values):
        return -1, 0
    older = [1]
    for x in points:
        older = _times_linear(older, x, p)
    newer = interpolate_modulo(points, values, p)
    s_older, s_newer = [0], [1]
    best: tuple[int, int] | None = None
    while any(newer):
        newer = _trim(newer)
        degrees = len(newer) - 1, len(_trim(s_newer)) - 1
        if best is None or sum(degrees) < sum(best):
            best = degrees
        quotient, rest = _divide(older, newer, p)
        older, newer = newer, rest
        s_older, s_newer = s_newer, _minus_product(s_older, quotient, s_newer, p)
    return best if best is not None and sum(best) + 3 <= len(points) else None


def _trim(a: Row) -> Row:
    """Drop the zeros at the end of a polynomial, lowest coefficient first."""
    end = len(a)
    while end > 1 and not a[end - 1]:
        end -= 1
    return a[:end]


def _times_linear(a: Row, root: int, p: int) -> Row:
    """Multiply a polynomial by ``x - root``."""
    return [(u - root * v) % p for u, v in zip([0, *a], [*a, 0], strict=True)]


def interpolate_modulo(points: Sequence[int], values: Sequence[int], p: int) -> Row:
    """Interpolate a polynomial (I. Newton), lowest coefficient first."""
    result, product = [values[0] % p], [1]
    for n in range(1, len(points)):
        product = _times_linear(product, points[n - 1], p)
        at, size = _value(result, points[n], p), _value(product, points[n], p)
        factor = (values[n] - at) * pow(size, -1, p) % p
        longer = [*result, *[0] * (len(product) - len(result))]
        result = [(u + factor * v) % p for u, v in zip(longer, product, strict=True)]
    return result


def _value(a: Row, x: int, p: int) -> int:
    total = 0
    for c in reversed(a):
        total = (total * x + c) % p
    return total


def _divide(a: Row, b: Row, p: int) -> tuple[Row, Row]:
    """Divide polynomials with remainder."""
    remainder, quotient = list(a), [0] * max(len(a) - len(b) + 1, 1)
    lead = pow(b[-1], -1, p)
    for shift in range(len(a) - len(b), -1, -1):
        factor = remainder[shift + len(b) - 1] * lead % p
        quotient[shift] = factor
        if factor:
            for i, c in enumerate(b):
                remainder[shift + i] = (remainder[shift + i] - factor * c) % p
    return quotient, remainder[: max(len(b) - 1, 1)]


def _minus_product(a: Row, b: Row, c: Row, p: int) -> Row:
    """Compute the polynomial ``a - b c``."""
    out = list(a) + [0] * max(len(b) + len(c) - 1 - len(a), 0)
    for i, x in enumerate(b):
        for j, y in enumerate(c):
            out[i + j] = (out[i + j] - x * y) % p
    return out
