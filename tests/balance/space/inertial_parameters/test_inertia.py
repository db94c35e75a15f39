"""Inertial parameters are sums over point masses, and physical if some body has them."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import balance
from balance.space.inertial_parameters.conversions import (
    from_chain,
    parameter_labels,
    to_chain,
)
from kinematics.model.arrays import Frame
from kinematics.model.spatial.inertia import displace_parameters, inertia_tensor
from tests.support.laws import displacement, point_masses, relative, sums

RNG_RUNS = range(20)


def cloud(seed, reach=1.0):
    return point_masses(np.random.default_rng(seed), reach=reach)


def with_moments(rng, moments, mass=1.0):
    """Parameters of a body with given principal moments, somewhere, turned somehow."""
    R = Rotation.random(random_state=rng).as_matrix()
    return balance.bodies.parameters(mass, rng.standard_normal(3), R @ np.diag(moments) @ R.T)


@pytest.mark.parametrize("seed", RNG_RUNS)
def test_mass_properties_are_sums_over_the_cloud(seed):
    masses, points = cloud(seed)
    found = balance.bodies.mass_properties(sums(masses, points))
    com = masses @ points / masses.sum()
    arms = points - com
    central = np.einsum("i,i,ab->ab", masses, (arms**2).sum(axis=1), np.eye(3))
    central -= np.einsum("i,ia,ib->ab", masses, arms, arms)
    assert found.mass == pytest.approx(masses.sum(), rel=1e-14)
    assert found.com == pytest.approx(com, abs=1e-14)
    assert relative(found.inertia, central) < 1e-13


@pytest.mark.parametrize("seed", RNG_RUNS)
def test_parameters_and_mass_properties_undo_each_other(seed):
    z = sums(*cloud(seed))
    assert relative(balance.bodies.parameters(*balance.bodies.mass_properties(z)), z) < 1e-14
    rng = np.random.default_rng(seed)
    tensor = rng.standard_normal((3, 3))
    given = rng.uniform(0.1, 2.0), rng.standard_normal(3), tensor + tensor.T
    found = balance.bodies.mass_properties(balance.bodies.parameters(*given))
    for one, other in zip(found, given, strict=True):
        assert relative(one, other) < 1e-13


@pytest.mark.parametrize("seed", RNG_RUNS)
def test_pseudo_inertia_is_the_second_moment_of_the_cloud(seed):
    """``P = Σ m [x; 1][x; 1]ᵀ``."""
    masses, points = cloud(seed)
    ones = np.column_stack([points, np.ones(len(points))])
    expected = np.einsum("i,ia,ib->ab", masses, ones, ones)
    assert relative(balance.bodies.pseudo_inertia(sums(masses, points)), expected) < 1e-14


def test_the_inertia_tensor_gives_the_angular_momentum():
    """``E ω = Σ m x × (ω × x)``: the products of inertia have their sign."""
    masses, points = cloud(60)
    omega = np.random.default_rng(61).standard_normal(3)
    momentum = masses @ np.cross(points, np.cross(omega, points))
    assert relative(inertia_tensor(sums(masses, points)) @ omega, momentum) < 1e-14


@pytest.mark.parametrize("seed", RNG_RUNS)
def test_displacing_a_body_is_moving_its_points(seed):
    masses, points = cloud(seed)
    H = displacement(np.random.default_rng(seed + 100))
    moved = points @ H[:3, :3].T + H[:3, 3]
    assert relative(displace_parameters(sums(masses, points), H), sums(masses, moved)) < 1e-13


def test_displacing_holds_for_any_affine_map():
    """Also for a change of units, or a sheared cloud."""
    masses, points = cloud(62)
    H = np.eye(4)
    H[:3] = np.random.default_rng(63).standard_normal((3, 4))
    moved = points @ H[:3, :3].T + H[:3, 3]
    assert relative(displace_parameters(sums(masses, points), H), sums(masses, moved)) < 1e-13


@pytest.mark.parametrize("count", [3, 4, 10])
def test_parameters_change_with_the_frame_of_the_chain(count):
    """``x' = (x - o) / L``, in the axes of the plane for 4 planar parameters or 3 of force."""
    masses, points = cloud(70)
    rng = np.random.default_rng(71)
    planar, force = count < 10, count == 3
    R = Rotation.random(random_state=rng).as_matrix() if planar else np.eye(3)
    frame = Frame(R, rng.standard_normal(3), 0.37)
    kept = [0, 1, 2, 6][:count] if planar else range(10)
    found = to_chain(sums(masses, points)[None], frame, planar, force)[0]
    expected = sums(masses, (points - frame.origin) @ R.T / frame.length)[kept]
    assert relative(found, expected) < 1e-13
    in_si = sums(masses, points @ R.T)[kept]
    assert relative(from_chain(frame, planar, force) @ found, in_si) < 1e-13
    assert len(parameter_labels(planar, force)) == count


def test_functions_broadcast_and_are_linear():
    a, b = sums(*cloud(64)), sums(*cloud(65))
    H = displacement(np.random.default_rng(66))
    stack = np.array([[a, b, 2.0 * a - 3.0 * b]])
    for function in (
        balance.bodies.pseudo_inertia,
        inertia_tensor,
        lambda z: displace_parameters(z, H),
    ):
        one, other, combined = function(stack)[0]
        assert relative(one, function(a)) < 1e-14 and relative(other, function(b)) < 1e-14
        assert relative(combined, 2.0 * one - 3.0 * other) < 1e-13


def test_a_point_mass_a_rod_and_a_box_are_known():
    assert balance.bodies.parameters(2.0, [1, 2, 3], np.zeros((3, 3))) == pytest.approx(
        [2, 2, 4, 6, 26, 20, 10, -4, -6, -12], abs=1e-15
    )
    rod = np.diag([0.0, 1.0, 1.0]) * 3.0 * 2.0**2 / 12.0
    # A uniform rod of 3 kg from x = 0 to x = 2: a third of m l² about its end.
    assert balance.bodies.parameters(3.0, [1, 0, 0], rod)[4:] == pytest.approx(
        [0, 4, 4, 0, 0, 0]
    )


@pytest.mark.parametrize("mass", [-1.0, -1e-12, 0.0])
def test_a_mass_that_is_not_positive_is_named(mass):
    z = balance.bodies.parameters(1.0, [0.1, 0.2, 0.3], np.eye(3))
    z[0] = mass
    (problem,) = balance.bodies.violations(z)
    assert problem.startswith("mass ") and ("zero" if mass == 0.0 else "negative") in problem


def test_no_body_is_no_violation():
    assert balance.bodies.violations(np.zeros(10)) == []


@pytest.mark.parametrize("seed", RNG_RUNS)
def test_negative_moments_are_named(seed):
    rng = np.random.default_rng(seed)
    moments = [-0.3, 0.7, 1.1] if seed % 2 else [-0.3, -0.2, 1.1]
    found = balance.bodies.violations(with_moments(rng, moments))
    values = [float(re.fullmatch(r"principal moment (\S+) is negative", t)[1]) for t in found]
    assert sorted(values) == pytest.approx([m for m in moments if m < 0.0], abs=1e-5)


@pytest.mark.parametrize("seed", RNG_RUNS)
def test_a_violated_triangle_is_named(seed):
    rng = np.random.default_rng(seed)
    moments = rng.permutation([0.4, 0.7, 1.3])
    (text,) = balance.bodies.violations(with_moments(rng, moments))
    numbers = re.fullmatch(r"principal moments (\S+) \+ (\S+) < (\S+)", text).groups()
    assert [float(x) for x in numbers] == pytest.approx([0.4, 0.7, 1.3], abs=1e-5)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_rounding_is_not_a_violation(scale):
    """A flat plate and a rod lie on the boundary, in any unit of length."""
    rng = np.random.default_rng(67)
    for moments in ([1.0, 1.0, 2.0], [0.0, 1.0, 1.0], [0.3, 0.7, 1.0], [0.0, 0.0, 0.0]):
        z = with_moments(rng, moments)
        assert (
            balance.bodies.violations(
                displace_parameters(z, np.diag([scale, scale, scale, 1.0]))
            )
            == []
        )
    z = with_moments(rng, [1.0, 1.0, 2.001])
    assert balance.bodies.violations(
        displace_parameters(z, np.diag([scale, scale, scale, 1.0]))
    )


def test_the_tolerance_is_asked_for():
    z = with_moments(np.random.default_rng(68), [1.0, 1.0, 2.0 + 1e-4])
    assert balance.bodies.violations(z)
    assert balance.bodies.violations(z, tolerance=1e-3) == []


def test_physical_means_a_positive_pseudo_inertia():
    """Random moments, random masses; those too near the boundary to call are left out."""
    rng = np.random.default_rng(69)
    counts = {True: 0, False: 0}
    for _ in range(400):
        z = with_moments(rng, rng.uniform(-0.2, 1.0, 3), rng.uniform(-0.2, 1.0))
        lowest = np.linalg.eigvalsh(balance.bodies.pseudo_inertia(z))[0]
        if abs(lowest) > 1e-6:
            counts[lowest > 0.0] += 1
            assert (balance.bodies.violations(z) == []) == (lowest > 0.0)
    assert min(counts.values()) > 50
    for seed in RNG_RUNS:
        assert balance.bodies.violations(sums(*cloud(seed))) == []
