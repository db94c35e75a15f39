"""Arithmetic modulo primes on arrays, against Python's whole numbers of any size."""

import numpy as np
import pytest

from balance.space.exact.conditions import directions_of
from balance.space.exact.modular import (
    PRIMES,
    Convolution,
    Echelon,
    eliminate,
    inverse,
    product,
)
from balance.space.momentum.product_tensors import product_tensors
from kinematics.model.spatial.inertia import parameters

P = PRIMES[0]


def remainders(rng, *shape):
    """Remainders of which many are the largest ones."""
    return np.where(
        rng.random(shape) < 0.5, P - 1 - rng.integers(0, 3, shape), rng.integers(0, P, shape)
    )


def whole(A, B):
    """The product of two matrices, by whole numbers of any size."""
    return (A.astype(object) @ B.astype(object)) % P


@pytest.mark.parametrize("inner", [0, 1, 255, 256, 257, 700])
def test_products_are_exact(inner):
    rng = np.random.default_rng(inner)
    A, B = remainders(rng, 3, inner), remainders(rng, inner, 4)
    assert (product(A, B, P) == whole(A, B)).all()
    most = np.full((1, inner), P - 1)
    assert product(most, most.T, P)[0, 0] == inner * (P - 1) ** 2 % P


def test_sums_of_two_series():
    """Of as many orders as ask for more room twice, and for a sum in parts."""
    rng = np.random.default_rng(1)
    A, B = remainders(rng, 40, 2, 3, 10), remainders(rng, 40, 2, 10, 4)
    sums = Convolution(2, 3, 10, 4, P)
    for k in range(40):
        sums.append_left(A[k])
        if k:
            lower = sum(whole(A[a, 1], B[k - 1 - a, 1]) for a in range(k)) % P
            assert (sums.sum(k)[1] == lower).all()
        sums.append_right(B[k])
        expected = sum(whole(A[a, 0], B[k - a, 0]) for a in range(k + 1)) % P
        assert (sums.sum(k + 1)[0] == expected).all()


def dependent_rows(rng):
    """Rows modulo P of which three follow from those before, and which ones."""
    A = remainders(rng, 9, 12)
    A[:, 2] = 0
    for row in (2, 5, 8):
        A[row] = whole(rng.integers(1, P, (1, row)), A[:row])[0]
    return A, [2, 5, 8]


def test_rows_that_follow_have_no_pivot():
    A, following = dependent_rows(np.random.default_rng(2))
    reduced = A.copy()
    pivots = eliminate(reduced, 12, P)
    assert np.flatnonzero(pivots < 0).tolist() == following
    assert not reduced[following].any()
    kept = pivots[pivots >= 0]
    assert (reduced[pivots >= 0][:, kept] == np.eye(6)).all()
    assert kept.tolist() == [0, 1, 3, 4, 5, 6]
    # Each row is the combination of the reduced ones that its entries at the pivots say.
    assert (whole(A[:, kept], reduced[pivots >= 0]) == A).all()


def test_other_columns_are_carried_along():
    """Beside a regular matrix, those of a unit matrix become its inverse."""
    rng = np.random.default_rng(3)
    A = remainders(rng, 5, 5)
    both = np.concatenate([A, np.eye(5, dtype=np.int64)], axis=1)
    pivots = eliminate(both, 5, P)
    assert (whole(both[np.argsort(pivots), 5:], A) == np.eye(5)).all()
    assert inverse(7, P) * 7 % P == 1


@pytest.mark.parametrize("size", [1, 2, 4, 9])
def test_rows_may_come_in_blocks(size):
    A, following = dependent_rows(np.random.default_rng(4))
    echelon, added = Echelon(12, P), []
    for start in range(0, 9, size):
        block = A[start : start + size]
        added += [start + row for row, _ in echelon.absorb(block)]
        assert echelon.absorb(block) == []
    assert added == [row for row in range(9) if row not in following]
    assert echelon.rank == 6


def test_rays_are_the_same_however_many_are_drawn():
    first, second = directions_of(4), directions_of(4)
    drawn = [next(first) for _ in range(5)]
    assert np.array_equal(drawn, [next(second) for _ in range(5)])
    assert np.min(drawn) > 0 and np.max(drawn) < 2**20 and len(np.unique(drawn)) > 15
    assert next(directions_of(1)).tolist() == [1]


@pytest.mark.parametrize("planar", [False, True])
@pytest.mark.parametrize("force", [False, True])
def test_tensors_are_those_of_point_masses(planar, force):
    """``p = v + ω × r``, ``ξ = r × p``; the parameters are quadratic in the position r."""
    rng, some = np.random.default_rng(5), product_tensors(planar, force)
    twist, point, unit = rng.standard_normal(6), rng.standard_normal(3), np.zeros((3, 3))
    if planar:
        twist[[0, 1, 5]] = point[2] = 0.0
    p = twist[3:] + np.cross(twist[:3], point)
    momentum = np.concatenate([np.cross(point, p), p])
    masses = [parameters(1.0, point + step * p, unit) for step in (0.0, 1.0, -1.0)]
    rate = (masses[1] - masses[2]) / 2
    places, rows = [0, 1, 2, 6][: 3 if force else 4], [2, 3, 4][int(force) :]
    if not planar:
        places, rows = range(4 if force else 10), range(3 if force else 0, 6)
    t = twist[2:5] if planar else twist
    z = masses[0][list(places)]
    assert np.allclose(np.einsum("d,diq,q", t, some.momentum, z), momentum[list(rows)])
    assert np.allclose(np.einsum("d,diq,q", t, some.rate, z), rate[list(places)])
    other = rng.standard_normal(t.size)
    bracket = np.einsum("d,dij,j", t, some.bracket, other)
    assert np.allclose(bracket, -np.einsum("d,dij,j", other, some.bracket, t))
