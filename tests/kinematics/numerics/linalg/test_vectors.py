"""Vectors that are one but for rounding, and what a span leaves of others."""

from __future__ import annotations

import numpy as np
import pytest

from kinematics.numerics.linalg.vectors import alike_groups, distinct_vectors, project_out


def near(some, one):
    return np.abs(some - one).max(axis=1) <= 1e-6


def test_groups_are_those_that_a_comparison_of_all_pairs_gives():
    """Clusters far apart: what is alike is an equivalence, and groups are its classes."""
    rng = np.random.default_rng(1)
    centres = rng.standard_normal((7, 3))
    which = rng.integers(0, 7, 60)
    points = centres[which] + rng.uniform(-1e-7, 1e-7, (60, 3))
    found = alike_groups(points, near)
    assert sorted(i for group in found for i in group) == list(range(60))
    assert {tuple(group) for group in found} == {
        tuple(np.flatnonzero(which == c).tolist()) for c in set(which.tolist())
    }
    assert [group[0] for group in found] == sorted(group[0] for group in found)
    assert distinct_vectors(points, near) == [group[0] for group in found]


def test_a_vector_joins_by_the_first_of_its_group():
    """Steps of 0.8e-6: the third is near the second, not near the first."""
    line = np.array([[0.0], [0.8e-6], [1.6e-6], [2.4e-6]])
    assert alike_groups(line, near) == [[0, 1], [2, 3]]
    assert alike_groups(line[[0, 2, 1]], near) == [[0, 2], [1]]


def test_no_vectors_make_no_group():
    assert alike_groups([], near) == [] and distinct_vectors(np.empty((0, 3)), near) == []


@pytest.mark.parametrize("count", [0, 1, 3])
def test_what_is_left_is_perpendicular_and_what_is_perpendicular_is_left(count):
    """Against the projector of a complete orthogonal basis."""
    rng = np.random.default_rng(2)
    Q = np.linalg.qr(rng.standard_normal((5, 5)))[0]
    vectors = rng.standard_normal((5, 4))
    left = project_out(vectors, Q[:, :count])
    assert left == pytest.approx(Q[:, count:] @ Q[:, count:].T @ vectors, abs=1e-14)
    assert np.abs(Q[:, :count].T @ left).max(initial=0.0) < 1e-14
    assert project_out(left, Q[:, :count]) == pytest.approx(left, abs=1e-14)
    assert project_out(vectors[:, 0], Q[:, :count]) == pytest.approx(left[:, 0], abs=1e-14)


def test_one_direction_may_be_given_alone():
    n = np.array([2.0, -1.0, 2.0]) / 3.0
    v = np.array([1.0, 2.0, 3.0])
    assert project_out(v, n) == pytest.approx(np.cross(n, np.cross(v, n)), abs=1e-15)
    both = project_out(np.array([v, n]).T, n)
    assert both == pytest.approx(np.array([np.cross(n, np.cross(v, n)), 0 * n]).T, abs=1e-15)
