"""Vectors and rotations in rational numbers."""

from __future__ import annotations

from fractions import Fraction

from kinematics.numerics.linalg.rational import dot

Vector3 = tuple[Fraction, Fraction, Fraction]
Rotation = tuple[Vector3, Vector3, Vector3]
ZERO, ONE = Fraction(0), Fraction(1)
NO_TURN: Rotation = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


def rotations(n: Vector3) -> list[Rotation]:
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


def add(a: Vector3, b: Vector3) -> Vector3:
    """Add vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector3, b: Vector3) -> Vector3:
    """Subtract vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(k: Fraction, a: Vector3) -> Vector3:
    """Multiply a vector by a number."""
    return k * a[0], k * a[1], k * a[2]


def turn(R: Rotation, a: Vector3) -> Vector3:
    """Turn a vector."""
    return dot(R[0], a), dot(R[1], a), dot(R[2], a)


def compose(A: Rotation, B: Rotation) -> Rotation:
    """Multiply rotations."""
    columns = tuple(zip(*B, strict=True))
    x, y, z = ((dot(row, columns[0]), dot(row, columns[1]), dot(row, columns[2])) for row in A)
    return x, y, z
