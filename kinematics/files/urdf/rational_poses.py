"""Compute rigid displacements in rational numbers.

A rotation about a rational axis n of any length is rational for a rational τ: the angle whose
half has the tangent ``τ |n|`` (A. Cayley, 1846).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import copysign, pi, sqrt, tan
from typing import NamedTuple

from kinematics.model.linkage import GROUND, Joint
from kinematics.numerics.linalg.rational import (
    Vector,
    add_vectors,
    cross,
    dot,
    nearby_fraction,
    root,
    scale_vector,
)

Matrix = tuple[Vector, ...]

# Largest denominator of a simple fraction, and distance of a double from one: of random
# numbers, about one in 2e7 is so near.
SIMPLE, SIMPLE_ROUND_OFF = 4096, 2e-15

AXES = tuple(tuple(Fraction(int(i == j)) for j in range(3)) for i in range(3))
"""The unit vectors along the coordinate axes."""


class RationalPose(NamedTuple):
    """A displacement: rotation (3, 3) by rows, and position (3,)."""

    R: Matrix = AXES
    d: Vector = (Fraction(0),) * 3

    def turn(self, a: Vector) -> Vector:
        """Rotate a vector (3,): ``R a``."""
        return tuple(dot(row, a) for row in self.R)

    def carry(self, screw: Vector) -> Vector:
        """Displace a screw ``[n; m]`` (6,): ``[R n; R m + d × R n]``."""
        n, m = self.turn(screw[:3]), self.turn(screw[3:])
        return n + add_vectors(m, cross(self.d, n))

    def __matmul__(self, other: RationalPose) -> RationalPose:
        """Compose displacements: ``other``, followed by this one."""
        columns = [self.turn(column) for column in zip(*other.R, strict=True)]
        return RationalPose(
            tuple(zip(*columns, strict=True)), add_vectors(self.d, self.turn(other.d))
        )


def rotation(n: Vector, tau: Fraction, quarter: int = 0) -> Matrix:
    """Compute the rotation matrix (3, 3) about n by ``2 arctan(τ |n|)`` and by quarter turns.

    ``R = 1 + sin θ n̂ + (1 - cos θ) n̂²`` with the unit vector along n.

    Args:
        n: axis (3,) of any length; of rational length if there are quarter turns.
        tau: tangent of half the angle, over the length of n.
        quarter: number of quarter turns.
    """
    if not tau and not quarter % 4:
        return AXES
    square = dot(n, n)
    secant = 1 + tau * tau * square  # 1 / cos² of half the angle
    c, s = (2 - secant) / secant, 2 * tau / secant  # s is the sine over the length of n
    for _ in range(quarter % 4):
        length = root(square) or Fraction(1)
        c, s = -s * length, c / length
    columns = []
    for axis in AXES:
        once = cross(n, axis)
        moved = add_vectors(axis, once, s)
        columns.append(add_vectors(moved, cross(n, once), (1 - c) / square))
    return tuple(zip(*columns, strict=True))


def equate_sizes(positions: Sequence[float]) -> list[float]:
    """Make positions exactly equal or opposite that are so but for round-off.

    Relations such as those of a parallelogram then hold at the rational pose.
    """
    alike: dict[float, float] = {}
    first = 0.0
    for size in sorted(abs(q) for q in positions):
        if size - first > SIMPLE_ROUND_OFF * max(1.0, size):
            first = size
        alike[size] = first
    return [copysign(alike[abs(q)], q) for q in positions]


def move_screws(
    joints: Sequence[Joint], screws: Sequence[Vector], positions: Sequence[float]
) -> tuple[Vector, ...]:
    """Move every joint to a rational position near a given one, and displace the screws.

    Half-angle tangents of turns, and lengths of slides, both over the length of the axis, are
    rounded to simple fractions where these are their doubles up to round-off, else to multiples
    of ``2**-BITS``. Half turns are exact.

    Args:
        joints: joints, parents first (n,).
        screws: their screws before they move, with axes of any length (n, 6).
        positions: their positions (n,), in radians and metres.

    Returns:
        The screws at that pose (n, 6), in the inertial frame.
    """
    links: dict[int, RationalPose] = {GROUND: RationalPose()}
    moved_screws = []
    for j, (joint, screw, q) in enumerate(zip(joints, screws, positions, strict=True)):
        before = links[joint.parent]
        moved_screws.append(before.carry(screw))
        links[j] = before @ _step(joint.kind, screw, float(q))
    return tuple(moved_screws)


def _step(kind: str, screw: Vector, q: float) -> RationalPose:
    """Compute the displacement of a joint ``[n; r × n + λ n]`` or ``[0; n]`` at position q."""
    n, m = screw[:3], screw[3:]
    if kind == "prismatic":
        return RationalPose(AXES, scale_vector(_rounded(q / sqrt(dot(m, m))), m))
    square = dot(n, n)
    length = sqrt(square)
    halves = round(q / pi) if root(square) is not None else 0
    R = RationalPose(rotation(n, _rounded(tan((q - halves * pi) / 2) / length), 2 * halves))
    foot = scale_vector(1 / square, cross(n, m))
    away = add_vectors(foot, R.turn(foot), -1)
    slide = dot(n, m) / square * nearby_fraction(Fraction(q / length))
    return RationalPose(R.R, add_vectors(away, n, slide))


def _rounded(x: float) -> Fraction:
    """Round a position to a simple fraction, if it is one up to round-off, else near it."""
    simple = Fraction(x).limit_denominator(SIMPLE)
    if abs(simple - Fraction(x)) <= SIMPLE_ROUND_OFF * max(1.0, abs(x)):
        return simple
    return nearby_fraction(Fraction(x))
