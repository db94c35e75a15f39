"""Mass, displacement and rods: what they stand for, and parameters taken apart and back."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from balance.bodies import pseudo_inertia
from balance.space.inertial_parameters.multipole import (
    RODS,
    Primitive,
    displacement_dipole,
    multipole_of,
    point_mass,
    rod,
)
from tests.support.laws import point_masses, relative, sums, unit_vector

SEEDS = range(20)


def directions(rng):
    """Six directions, independent with probability one."""
    return np.array([unit_vector(rng) for _ in range(6)])


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("reach", [0.0, 1.0, 1e3])
def test_taken_apart_and_back(seed, reach):
    """For any numbers, physical or not, about any point, with any rods."""
    rng = np.random.default_rng(seed)
    z, point = rng.standard_normal(10), reach * rng.standard_normal(3)
    for rods in (RODS, directions(rng)):
        found = multipole_of(z, point, rods)
        # Rods that are nearly dependent take values much larger than what they add up to.
        size = max(reach**2, float(np.abs(found.rods).max()), 1.0)
        assert np.abs(found.parameters() - z).max() < 1e-13 * size
        whole = sum(primitive.parameters() for primitive in found.primitives("body"))
        assert np.abs(whole - z).max() < 1e-13 * size


@pytest.mark.parametrize("seed", SEEDS)
def test_put_together_and_back(seed):
    rng = np.random.default_rng(seed)
    mass, moved, rods = rng.standard_normal(), rng.standard_normal(3), rng.standard_normal(6)
    point = rng.standard_normal(3)
    z = (
        mass * point_mass(point)
        + moved @ displacement_dipole(np.eye(3), point)
        + rods @ rod(RODS)
    )
    found = multipole_of(z, point)
    assert abs(found.mass - mass) < 1e-15
    assert relative(found.displacement, moved) < 1e-13
    assert relative(found.rods, rods) < 1e-12


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("reach", [0.0, 1.0, 1e3])
def test_planar_parameters(seed, reach):
    """Taken apart and back, and the same as the spatial ones of a body in the plane."""
    rng = np.random.default_rng(seed)
    z, point = rng.standard_normal(4), reach * rng.standard_normal(2)
    found = multipole_of(z, point)
    assert found.rods.shape == (1,) and found.displacement.shape == (2,)
    assert np.abs(found.parameters() - z).max() < 1e-13 * max(reach**2, 1.0)
    masses, points = point_masses(rng)
    points[:, 2] = 0.0
    spatial = sums(masses, points)
    planar = multipole_of(spatial[[0, 1, 2, 6]], point)
    in_space = multipole_of(spatial, [*point, 0.0])
    size = max(reach**2, 1.0) * spatial[0]
    assert abs(planar.mass - in_space.mass) < 1e-15
    assert np.abs(planar.displacement - in_space.displacement[:2]).max() < 1e-12 * size
    # About the normal, each rod counts with the part of it that lies in the plane.
    about_normal = in_space.rods @ (1.0 - RODS[:, 2] ** 2)
    assert abs(planar.rods[0] - about_normal) < 1e-12 * size
    with pytest.raises(ValueError, match="give all ten"):
        planar.primitives("body")


def test_a_point_mass_is_one_particle():
    points = np.random.default_rng(0).standard_normal((5, 3))
    assert relative(point_mass(points), [sums([1.0], [r]) for r in points]) < 1e-15
    x = np.append(points[0], 1.0)
    assert relative(pseudo_inertia(point_mass(points[0])), np.outer(x, x)) < 1e-15


def test_a_displacement_is_a_derivative():
    """Masses +1/2h and -1/2h at r ± h a: exact at any h, as the parameters are quadratic."""
    rng = np.random.default_rng(1)
    r, a = rng.standard_normal(3), unit_vector(rng)
    pair = sums([1.0, -1.0], [r + 0.5 * a, r - 0.5 * a])
    assert relative(displacement_dipole(a, r), pair) < 1e-14
    assert relative(displacement_dipole(np.array([a, -a]), r), [pair, -pair]) < 1e-14


def test_a_rod_is_a_dumbbell_without_its_mass():
    rng = np.random.default_rng(2)
    for _ in range(10):
        r, b = rng.standard_normal(3), unit_vector(rng)
        dumbbell = sums([0.5, 0.5, -1.0], [r + b, r - b, r])
        assert relative(rod(b), dumbbell) < 1e-14
        P = pseudo_inertia(rod(b))
        assert relative(P[:3, :3], np.outer(b, b)) < 1e-15
        assert not P[3].any()


def test_rods_turn_with_the_axes():
    rng = np.random.default_rng(3)
    R = Rotation.random(random_state=rng).as_matrix()
    z = sums(*point_masses(rng))
    turned = sums(*(m := point_masses(np.random.default_rng(9)))), sums(m[0], m[1] @ R.T)
    assert (
        relative(
            multipole_of(turned[1], np.zeros(3), RODS @ R.T).rods,
            multipole_of(turned[0], np.zeros(3)).rods,
        )
        < 1e-12
    )
    assert (
        relative(
            multipole_of(z, np.zeros(3), 5.0 * RODS).rods, multipole_of(z, np.zeros(3)).rods
        )
        < 1e-14
    )


@pytest.mark.parametrize(
    "rods",
    [
        np.ones((6, 3)),
        np.vstack([RODS[:5], RODS[4]]),
        np.vstack([RODS[:5], np.zeros(3)]),
        np.vstack([RODS[:5], [np.nan, 0.0, 1.0]]),
        # On one cone about z.
        [[np.cos(a), np.sin(a), 1.0] for a in range(6)],
        RODS[:5],
    ],
)
def test_rods_that_do_not_span_are_refused(rods):
    with pytest.raises(ValueError, match="six"):
        multipole_of(np.ones(10), np.zeros(3), rods)


def test_shapes_that_do_not_match_are_refused():
    for z, point in ((10, 2), (4, 3), (9, 3)):
        with pytest.raises(ValueError, match="shapes"):
            multipole_of(np.ones(z), np.zeros(point))


def test_primitives_are_plain_data():
    r, a = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 1.0])
    for primitive, one in (
        (Primitive("mass", "arm", -2.0, r), point_mass(r)),
        (Primitive("displacement", "arm", -2.0, r, a), displacement_dipole(a, r)),
        (Primitive("rod", "arm", -2.0, None, a), rod(a)),
    ):
        assert relative(primitive.parameters(), -2.0 * one) < 1e-15
        data = json.loads(json.dumps(primitive.to_dict()))
        assert data["kind"] == primitive.kind and data["value"] == -2.0
        assert data["point"] == (None if primitive.point is None else [1.0, 2.0, 3.0])
        assert data["direction"] == (None if primitive.direction is None else [0.0, 0.0, 1.0])
