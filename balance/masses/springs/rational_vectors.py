"""Vectors and rotations in rational numbers."""

from __future__ import annotations

from fractions import Fraction

Vector = tuple[Fraction, Fraction, Fraction]
Rotation = tuple[Vector, Vector, Vector]
ZERO, ONE = Fraction(0), Fraction(1)
NO_TURN: Rotation = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


def rotations(n: Vector) -> list[Rotation]:
    """List the rotations about an axis at t = 0, 1 and infinity; see `energy_identity`."""
    N, turned = dot(n, n), []
    for c, s in ((ONE, ZERO), ((1 - N) / (1 + N), 2 / (1 + N)), (-ONE, ZERO)):
        f = (1 - c) / N
        x, y, z = n
        turned.append(
            (
                (c + f * x * x, f * x * y - s * z, f * x * z + s * y),
                (f * x * y + s * z, c + f * y * y, f * y * z - s * x),
                (f * x * z - s * y, f * y * z + s * x, c + f * z * z),
            )
        )
    return turned


def dot(a: Vector, b: Vector) -> Fraction:
    """Compute a scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def add(a: Vector, b: Vector) -> Vector:
    """Add vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector, b: Vector) -> Vector:
    """Subtract vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(k: Fraction, a: Vector) -> Vector:
    """Multiply a vector by a number."""
    return k * a[0], k * a[1], k * a[2]


def turn(R: Rotation, a: Vector) -> Vector:
    """Turn a vector."""
    return dot(R[0], a), dot(R[1], a), dot(R[2], a)


def compose(A: Rotation, B: Rotation) -> Rotation:
    """Multiply rotations."""
    columns = tuple(zip(*B, strict=True))
    x, y, z = ((dot(row, columns[0]), dot(row, columns[1]), dot(row, columns[2])) for row in A)
    return x, y, z
