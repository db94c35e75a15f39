"""Rational unit vectors next to directions, and across others."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from kinematics.numerics.linalg.rational import cross, dot, nearby_vector
from kinematics.numerics.linalg.rational_directions import (
    nearby_unit_vector,
    nearby_unit_vector_across,
)

# Far below the 2^-53 of the doubles that directions come from.
NEAR = Fraction(1, 2**60)
DIRECTIONS = [
    (0.0, 0.0, 1.0),
    (0.0, -1.0, 0.0),
    (1.0, 1.0, 1.0),
    (0.6, -0.8, 0.0),
    (3e-17, -0.6, 0.8),
    *np.random.default_rng(71).standard_normal((8, 3)).tolist(),
]


def square_of_sine(a, b):
    """Square of the sine of the angle between two directions, exactly."""
    n = cross(a, b)
    return dot(n, n) / (dot(a, a) * dot(b, b))


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_unit_vector_is_next_to_its_direction(direction):
    n = nearby_vector(np.array(direction))
    unit = nearby_unit_vector(n)
    assert dot(unit, unit) == 1 and dot(unit, n) > 0
    assert square_of_sine(unit, n) < NEAR**2


def test_coordinate_axes_stay():
    for n in ((0, 0, 5), (0, -1, 0), (2, 0, 0)):
        unit = nearby_unit_vector(tuple(map(Fraction, n)))
        assert unit == tuple(Fraction((x > 0) - (x < 0)) for x in n)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_unit_vector_across_another_is_so_exactly_and_next_to_the_rest(direction):
    m = nearby_unit_vector(nearby_vector(np.array(direction)))
    for turned in np.random.default_rng(72).standard_normal((3, 3)):
        n = nearby_vector(turned)
        unit = nearby_unit_vector_across(n, m)
        assert dot(unit, unit) == 1 and dot(unit, m) == 0 and dot(unit, n) > 0
        rest = tuple(x - dot(n, m) * y for x, y in zip(n, m, strict=True))
        assert square_of_sine(unit, rest) < NEAR**2
