"""Rational Bennett linkages: the conditions on their lengths and twists, exactly."""

from fractions import Fraction

import numpy as np
import pytest

from kinematics.loading.meant.bennett_loops import bennett_axes
from kinematics.numerics.linalg.rational import cross, dot
from tests.independent.meant_linkages import cross as mp_cross
from tests.independent.meant_linkages import meant_linkage


def screws(seed):
    """Unit screws of a Bennett linkage, in their order around the loop."""
    joints = meant_linkage("bennett", seed).joints
    lines = [
        np.array([float(x) for x in (*j.axis, *mp_cross(j.point, j.axis))]) for j in joints
    ]
    return [lines[k] for k in (0, 1, 3, 2)]


def invariants(a, b):
    """``cos²`` of the angle between two lines, and their squared distance; rational."""
    n, m = a[:3], b[:3]
    across = cross(n, m)
    moment = dot(n, b[3:]) + dot(m, a[3:])
    square = dot(across, across)
    return dot(n, m) ** 2 / (dot(n, n) * dot(m, m)), moment**2 / square


@pytest.mark.parametrize("seed", range(4))
def test_opposite_links_are_equal_and_the_axes_are_near(seed):
    known = screws(seed)
    axes = bennett_axes(known)
    assert axes is not None
    around = [invariants(axes[k], axes[(k + 1) % 4]) for k in range(4)]
    assert around[0] == around[2] and around[1] == around[3]
    # a² / sin² α = b² / sin² β
    ratios = [square / (1 - cosine) for cosine, square in around]
    assert ratios[0] == ratios[1]
    for axis, screw in zip(axes, known, strict=True):
        assert dot(axis[:3], axis[3:]) == Fraction(0)
        unit = np.array([float(x) for x in axis]) / float(dot(axis[:3], axis[:3])) ** 0.5
        np.testing.assert_allclose(unit, screw, atol=1e-12)


def test_general_axes_are_not_those_of_a_bennett_linkage():
    known = screws(1)
    known[2] = known[2].copy()
    known[2][3:] += np.cross([0.01, 0.0, 0.0], known[2][:3])
    axes = bennett_axes(known)
    if axes is not None:
        unit = [np.array([float(x) for x in a]) / float(dot(a[:3], a[:3])) ** 0.5 for a in axes]
        assert max(np.abs(u - s).max() for u, s in zip(unit, known, strict=True)) > 1e-4
