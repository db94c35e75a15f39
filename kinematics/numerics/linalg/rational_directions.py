"""Unit vectors in rational numbers, next to given directions.

A ratio of two lengths that are not rational is a square root, which arithmetic modulo a prime
has for half of the primes alone. Directions of rational length need none.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from kinematics.numerics.linalg.rational import (
    BITS,
    Vector,
    add_vectors,
    dot,
    nearby_fraction,
    root,
)


def nearby_unit_vector(n: Vector) -> Vector:
    """Compute a rational unit vector (3,) within about ``2**-BITS`` of a direction.

    It is the stereographic image of a rational point (u, v),
    ``[2u, 2v, 1 - u² - v²] / (1 + u² + v²)``.

    Args:
        n: direction (3,) of any length but zero.
    """
    k = _largest(n)
    length = _length(n)
    first, second = (i for i in range(3) if i != k)
    u, v = (nearby_fraction(n[i] / (length + abs(n[k]))) for i in (first, second))
    square = 1 + u * u + v * v
    unit = [Fraction(0)] * 3
    unit[first], unit[second] = 2 * u / square, 2 * v / square
    unit[k] = (2 - square) / square if n[k] > 0 else (square - 2) / square
    return tuple(unit)


def nearby_unit_vector_across(n: Vector, m: Vector) -> Vector:
    """Compute a rational unit vector (3,) next to a direction, exactly across another.

    A reflection moves the other onto a coordinate axis, where the vector is one of a plane.

    Args:
        n: direction (3,) of any length, not parallel to m.
        m: the other (3,), of rational length.
    """
    length = root(dot(m, m))
    assert length is not None
    k = _largest(m)
    mirror = list(m)
    mirror[k] += length if m[k] > 0 else -length
    flat = list(_reflect(n, tuple(mirror)))
    flat[k] = Fraction(0)
    return _reflect(nearby_unit_vector(tuple(flat)), tuple(mirror))


def _reflect(a: Vector, v: Vector) -> Vector:
    """Reflect a vector in the plane at right angles to v: ``a - 2 v (a·v) / v²``."""
    return add_vectors(a, v, -2 * dot(a, v) / dot(v, v))


def _largest(n: Vector) -> int:
    """Find the component of the largest size, the first of equal ones."""
    return max(range(3), key=lambda i: abs(n[i]))


def _length(n: Vector) -> Fraction:
    """Compute the length of a vector, to about ``2**-BITS`` of it."""
    square, largest = dot(n, n), abs(n[_largest(n)])
    scaled = square / (largest * largest)
    digits = isqrt((scaled.numerator << 2 * BITS) // scaled.denominator)
    return largest * Fraction(digits, 1 << BITS)
