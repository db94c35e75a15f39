"""A spring in rational numbers, whose stiffness is to be found exactly."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from balance.masses.springs.rational_vectors import Vector3


class SpringTerm(NamedTuple):
    """A spring whose stiffness, and shifts of one end, are to be found exactly.

    Attributes:
        links: links of both ends.
        points: both ends at the reference pose, inertial frame, metres.
        axes: directions in which one of them may be shifted, likewise.
        end: that end, 0 or 1.
        stiffness: the stiffness by floating point, N/m.
        given: whether it must be that one.
        length: the free length, metres.
    """

    links: tuple[int, int]
    points: tuple[Vector3, Vector3]
    axes: tuple[Vector3, ...]
    end: int
    stiffness: Fraction
    given: bool
    length: Fraction
