"""Rational Bennett linkages next to four axes, by the factorisation of motion polynomials.

A dual quaternion ``h = s + λ (n + ε m)``, with the line ``[n; m]``, ``n·m = 0``, is a root of
the real polynomial ``M = t² - 2 s t + s² + λ² n²``, and ``t - h`` is a rotation about the line.
The motion of the link opposite to the ground is ``C = (t - h1) (t - h2)``; it has a second
factorisation ``C = (t - h4) (t - h3)`` with ``M3 = M1`` and ``M4 = M2``, which four divisions
give: with the remainder ``r1 t + r0`` of C modulo M1, ``h3 = -r1⁻¹ r0`` and
``h4 = h1 + h2 - h3``. The four lines are the axes of a Bennett linkage, and each one is of this
kind (G. Hegedüs, J. Schicho and H.-P. Schröcker, Factorization of rational curves in the Study
quadric, 2013). If h1 and h2 are rational, so are h3 and h4.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import (
    Vector,
    add_vectors,
    cross,
    dot,
    nearby_fraction,
    scale_vector,
)


class _Quaternion(NamedTuple):
    """A quaternion: scalar, and vector (3,)."""

    s: Fraction
    v: Vector

    def __add__(self, other: _Quaternion) -> _Quaternion:  # type: ignore[override]
        """Add quaternions."""
        return _Quaternion(self.s + other.s, add_vectors(self.v, other.v))

    def __matmul__(self, other: _Quaternion) -> _Quaternion:
        """Multiply quaternions."""
        v = add_vectors(scale_vector(self.s, other.v), scale_vector(other.s, self.v))
        return _Quaternion(
            self.s * other.s - dot(self.v, other.v), add_vectors(v, cross(self.v, other.v))
        )

    def scaled(self, factor: Fraction) -> _Quaternion:
        """Multiply by a number."""
        return _Quaternion(factor * self.s, scale_vector(factor, self.v))

    @property
    def inverse(self) -> _Quaternion:
        """The inverse."""
        square = self.s * self.s + dot(self.v, self.v)
        return _Quaternion(self.s / square, scale_vector(-1 / square, self.v))


class _DualQuaternion(NamedTuple):
    """A dual quaternion ``a + ε b``."""

    a: _Quaternion
    b: _Quaternion

    def __add__(self, other: _DualQuaternion) -> _DualQuaternion:  # type: ignore[override]
        """Add dual quaternions."""
        return _DualQuaternion(self.a + other.a, self.b + other.b)

    def __matmul__(self, other: _DualQuaternion) -> _DualQuaternion:
        """Multiply dual quaternions."""
        return _DualQuaternion(self.a @ other.a, self.a @ other.b + self.b @ other.a)

    def scaled(self, factor: Fraction) -> _DualQuaternion:
        """Multiply by a number."""
        return _DualQuaternion(self.a.scaled(factor), self.b.scaled(factor))

    @property
    def inverse(self) -> _DualQuaternion:
        """The inverse: ``a⁻¹ - ε a⁻¹ b a⁻¹``."""
        first = self.a.inverse
        return _DualQuaternion(first, (first @ self.b @ first).scaled(Fraction(-1)))


def bennett_axes(screws: Sequence[Array]) -> tuple[Vector, ...] | None:
    """Compute the rational axes of a Bennett linkage next to given ones.

    The first two axes are kept, up to rounding.

    Args:
        screws: unit screws ``[n; p × n]`` (6,) of the four joints, in their order around the
            loop.

    Returns:
        Screws of any length; None if there is no such linkage.
    """
    first, second, third, fourth = screws
    A = np.column_stack([second, -third, -fourth])
    (scale, third_scale, fourth_scale), *_ = np.linalg.lstsq(A, -first, rcond=None)
    n1, n2, n3, n4 = (screw[:3] for screw in screws)
    product = fourth_scale * third_scale * np.cross(n4, n3) - scale * np.cross(n1, n2)
    along = n1 - third_scale * n3
    if along @ along < 1e-12:
        return None
    shift = float(along @ product) / float(along @ along)
    lines = [_rational_line(screw) for screw in (first, second)]
    h1 = _root(Fraction(0), Fraction(1), lines[0])
    h2 = _root(_nearby(shift), _nearby(scale), lines[1])
    # C = t² - (h1 + h2) t + h1 h2, modulo M1 = t² + n1².
    square = dot(lines[0][:3], lines[0][:3])
    r1 = (h1 + h2).scaled(Fraction(-1))
    product_of_roots = h1 @ h2
    r0 = _DualQuaternion(
        _Quaternion(product_of_roots.a.s - square, product_of_roots.a.v), product_of_roots.b
    )
    if not (r1.a.s or any(r1.a.v)):
        return None
    h3 = (r1.inverse @ r0).scaled(Fraction(-1))
    h4 = h1 + h2 + h3.scaled(Fraction(-1))
    axes = [*lines]
    for h, screw in ((h3, third), (h4, fourth)):
        line = h.a.v + h.b.v
        if h.b.s or not any(h.a.v):
            return None
        sign = (
            1
            if float(sum(float(x) * y for x, y in zip(h.a.v, screw[:3], strict=True))) > 0
            else -1
        )
        axes.append(scale_vector(sign, line))
    return tuple(axes)


def _root(s: Fraction, scale: Fraction, line: Vector) -> _DualQuaternion:
    """Make the dual quaternion ``s + λ (n + ε m)``."""
    n, m = scale_vector(scale, line[:3]), scale_vector(scale, line[3:])
    return _DualQuaternion(_Quaternion(s, n), _Quaternion(Fraction(0), m))


def _rational_line(screw: Array) -> Vector:
    """Make a rational line ``[n; p × n]`` next to a unit screw."""
    n = tuple(_nearby(x) for x in screw[:3])
    p = tuple(_nearby(x) for x in np.cross(screw[:3], screw[3:]))
    return n + cross(p, n)


def _nearby(x: float) -> Fraction:
    """Round a number to a fraction."""
    return nearby_fraction(Fraction(float(x)))
