"""Screws obey the laws of the Lie algebra se(3); exponentials agree with a general one."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp
from scipy.linalg import expm

from kinematics.model.spatial import screws
from tests.support.laws import displacement, relative, unit_vector

KINDS = ("revolute", "prismatic", "helical")


def joint_screw(kind, rng):
    if kind == "prismatic":
        return screws.prismatic(3.0 * unit_vector(rng))
    pitch = rng.uniform(-1.0, 1.0) if kind == "helical" else 0.0
    return screws.revolute(2.0 * unit_vector(rng), rng.standard_normal(3), pitch)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("q", [0.0, 1e-300, 1e-17, 1e-9, 1e-4, 0.3, -2.0, 3.1415926535, 9.0])
def test_exp_is_the_matrix_exponential(kind, q):
    rng = np.random.default_rng(10)
    for _ in range(5):
        s = joint_screw(kind, rng)
        assert np.abs(screws.exp(s, q) - expm(q * screws.hat(s))).max() < 1e-14 * (1 + abs(q))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("q", [1e-150, 1e-12, 1e-8, 1e-5])
def test_tiny_displacements_keep_their_digits(kind, q):
    """``(exp(q ŝ) - 1) / q`` away from the diagonal, which cannot hold ``q²``."""
    s = joint_screw(kind, np.random.default_rng(11))
    off = ~np.eye(4, dtype=bool)
    expected = (screws.hat(s) + 0.5 * q * (screws.hat(s) @ screws.hat(s)))[off]
    assert relative(screws.exp(s, q)[off] / q, expected) < max(q * q, 1e-15)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("q", [100.0, -1e4, 1e6])
def test_huge_displacements_keep_their_digits(kind, q):
    """Against 60 digits. The angle multiplies what a unit axis lacks of length 1, 1e-16."""
    s = joint_screw(kind, np.random.default_rng(12))
    with mp.workdps(60):
        matrix = mp.matrix(screws.hat(s).tolist()) * mp.mpf(q)
        exact = np.array(mp.expm(matrix).tolist(), dtype=float)
    assert np.abs(screws.exp(s, q) - exact).max() < 2e-15 * abs(q)


def test_exponentials_are_displacements():
    rng = np.random.default_rng(13)
    for kind in KINDS:
        s = joint_screw(kind, rng)
        a, b = rng.uniform(-4.0, 4.0, 2)
        H = screws.exp(s, a)
        assert H[:3, :3].T @ H[:3, :3] == pytest.approx(np.eye(3), abs=1e-14)
        assert np.linalg.det(H[:3, :3]) == pytest.approx(1.0, abs=1e-14)
        assert np.array_equal(H[3], [0.0, 0.0, 0.0, 1.0])
        assert H @ screws.exp(s, b) == pytest.approx(screws.exp(s, a + b), abs=1e-13)


def test_joints_do_what_they_are_called():
    """A revolute joint keeps its axis, a helical one advances by 2πλ in a turn."""
    n, r, pitch = np.array([0.0, 0.6, 0.8]), np.array([1.0, -2.0, 0.5]), 0.07
    H = screws.exp(screws.revolute(5.0 * n, r), 1.2)
    for x in (r, r - 3.0 * n):
        assert H @ [*x, 1.0] == pytest.approx([*x, 1.0], abs=1e-14)
    H = screws.exp(screws.revolute(n, r, pitch), 2.0 * np.pi)
    assert H[:3, :3] == pytest.approx(np.eye(3), abs=1e-14)
    assert H[:3, 3] == pytest.approx(2.0 * np.pi * pitch * n, abs=1e-14)
    H = screws.exp(screws.prismatic(-7.0 * n), 0.4)
    assert H[:3, 3] == pytest.approx(-0.4 * n, abs=1e-15)
    turned = screws.exp(screws.revolute([0.0, 0.0, 1.0], np.zeros(3)), 0.5 * np.pi)
    assert turned @ [1.0, 0.0, 0.0, 1.0] == pytest.approx([0.0, 1.0, 0.0, 1.0], abs=1e-15)


def test_Ad_of_exp_is_exp_of_ad():  # noqa: N802
    rng = np.random.default_rng(14)
    for kind in KINDS:
        s, q = joint_screw(kind, rng), rng.uniform(-3.0, 3.0)
        found, expected = screws.Ad(screws.exp(s, q)), expm(q * screws.ad(s))
        assert found == pytest.approx(expected, abs=1e-13)


def test_Ad_is_a_homomorphism():  # noqa: N802
    rng = np.random.default_rng(15)
    A, B = displacement(rng), displacement(rng)
    assert screws.Ad(A @ B) == pytest.approx(screws.Ad(A) @ screws.Ad(B), abs=1e-13)
    assert screws.Ad(np.linalg.inv(A)) == pytest.approx(np.linalg.inv(screws.Ad(A)), abs=1e-13)
    assert np.array_equal(screws.Ad(np.eye(4)), np.eye(6))


def test_adjoints_are_conjugation_and_commutator():
    rng = np.random.default_rng(16)
    H, (a, b) = displacement(rng), rng.standard_normal((2, 6))
    moved = H @ screws.hat(a) @ np.linalg.inv(H)
    assert screws.hat(screws.Ad(H) @ a) == pytest.approx(moved, abs=1e-13)
    A, B = screws.hat(a), screws.hat(b)
    assert screws.hat(screws.ad(a) @ b) == pytest.approx(A @ B - B @ A, abs=1e-14)
    assert screws.ad(screws.Ad(H) @ a) @ screws.Ad(H) == pytest.approx(
        screws.Ad(H) @ screws.ad(a), abs=1e-13
    )


def test_jacobi_identity_and_antisymmetry():
    a, b, c = np.random.default_rng(17).standard_normal((3, 6))
    bracket = screws.ad
    cyclic = sum(bracket(x) @ (bracket(y) @ z) for x, y, z in ((a, b, c), (b, c, a), (c, a, b)))
    assert cyclic == pytest.approx(np.zeros(6), abs=1e-14)
    assert bracket(a) @ b == pytest.approx(-bracket(b) @ a, abs=1e-15)
    assert bracket(a) @ a == pytest.approx(np.zeros(6), abs=1e-15)


def test_hat_gives_velocities_and_vee_undoes_it():
    rng = np.random.default_rng(18)
    t, x = rng.standard_normal((3, 4, 6)), rng.standard_normal(3)
    assert np.array_equal(screws.vee(screws.hat(t)), t)
    velocity = screws.hat(t) @ [*x, 1.0]
    assert velocity[..., :3] == pytest.approx(np.cross(t[..., :3], x) + t[..., 3:], abs=1e-15)
    assert not velocity[..., 3].any()
    assert screws.skew(x) @ t[0, 0, :3] == pytest.approx(np.cross(x, t[0, 0, :3]), abs=1e-15)
    symmetric = np.zeros((4, 4))
    symmetric[:3, :3] = x[:, None] + x
    assert np.array_equal(screws.vee(screws.hat(t[0, 0]) + symmetric)[3:], t[0, 0, 3:])
    assert screws.vee(symmetric) == pytest.approx(np.zeros(6), abs=0.0)


def test_power_does_not_depend_on_the_frame():
    """Twist and wrench are dual: a force at a point works on the velocity of that point."""
    rng = np.random.default_rng(19)
    H, t, r, f = displacement(rng), *(rng.standard_normal(k) for k in (6, 3, 3))
    wrench = np.concatenate([np.cross(r, f), f])
    power = f @ (screws.hat(t) @ [*r, 1.0])[:3]
    assert wrench @ t == pytest.approx(power, abs=1e-13)
    R, moved_point = H[:3, :3], (H @ [*r, 1.0])[:3]
    moved = np.concatenate([np.cross(moved_point, R @ f), R @ f])
    assert np.linalg.inv(screws.Ad(H)).T @ wrench == pytest.approx(moved, abs=1e-13)
    assert moved @ (screws.Ad(H) @ t) == pytest.approx(power, abs=1e-13)


def swapped(s):
    """A twist as the wrench with the same line, and the other way round."""
    return np.concatenate([s[3:], s[:3]])


READ = {
    "twist": (screws.twist_axis, lambda t: t, screws.Ad),
    "wrench": (screws.wrench_axis, swapped, lambda H: np.linalg.inv(screws.Ad(H)).T),
}


@pytest.mark.parametrize("what", READ)
def test_the_axis_gives_back_the_screw(what):
    axis_of, as_line, _ = READ[what]
    rng = np.random.default_rng(20)
    for _ in range(10):
        s = rng.standard_normal(6) * 10.0 ** rng.uniform(-3, 3, 6)
        axis = axis_of(as_line(s))
        assert axis.direction @ axis.direction == pytest.approx(1.0, abs=1e-14)
        assert abs(axis.direction @ axis.point) < 1e-13 * (1 + np.abs(axis.point).max())
        back = axis.magnitude * screws.revolute(axis.direction, axis.point, axis.pitch)
        assert relative(back[:3], s[:3]) < 1e-13
        assert relative(back[3:], s[3:]) < 1e-13


@pytest.mark.parametrize("what", READ)
def test_the_axis_moves_with_the_screw(what):
    axis_of, as_line, carry = READ[what]
    rng = np.random.default_rng(21)
    for _ in range(10):
        H, s = displacement(rng), as_line(rng.standard_normal(6))
        before, after = axis_of(s), axis_of(carry(H) @ s)
        assert after.pitch == pytest.approx(before.pitch, abs=1e-12)
        assert after.magnitude == pytest.approx(before.magnitude, abs=1e-13)
        assert after.direction == pytest.approx(H[:3, :3] @ before.direction, abs=1e-13)
        moved = (H @ [*before.point, 1.0])[:3]
        assert np.abs(np.cross(moved - after.point, after.direction)).max() < 1e-12


@pytest.mark.parametrize("what", READ)
def test_special_pitches_are_exact(what):
    axis_of, as_line, carry = READ[what]
    rng = np.random.default_rng(22)
    for _ in range(20):
        n, r, size = unit_vector(rng), 10.0 * rng.standard_normal(3), 10.0 ** rng.uniform(-6, 6)
        pure = axis_of(as_line(size * screws.revolute(n, r)))
        assert pure.pitch == 0.0
        assert pure.direction == pytest.approx(n, abs=1e-14)
        assert np.abs(np.cross(pure.point - r, n)).max() < 1e-12
        free = axis_of(as_line(size * screws.prismatic(n)))
        assert free.pitch == np.inf and not free.point.any()
        assert free.direction == pytest.approx(n, abs=1e-14)
        assert free.magnitude == pytest.approx(size, rel=1e-14)
        H = displacement(rng)
        assert axis_of(carry(H) @ as_line(size * screws.prismatic(n))).pitch == np.inf


@pytest.mark.parametrize("axis_of", [screws.twist_axis, screws.wrench_axis])
def test_a_vanishing_screw_has_no_axis(axis_of):
    axis = axis_of(np.zeros(6))
    assert not axis.direction.any() and not axis.point.any()
    assert axis.pitch == 0.0 and axis.magnitude == 0.0


def test_a_rotation_and_a_force_are_read_from_the_right_half():
    """A twist is angular first; a wrench has its line in the last three components."""
    spin, force = [0.0, 0.0, 2.0, 0.0, -2.0, 0.0], [0.0, 0.0, 5.0, 0.0, 3.0, 0.0]
    axis = screws.twist_axis(spin)
    assert axis.pitch == 0.0 and axis.magnitude == 2.0
    assert np.array_equal(axis.point, [1.0, 0.0, 0.0])
    axis = screws.wrench_axis(force)
    assert axis.pitch == 0.0 and axis.magnitude == 3.0
    assert axis.point == pytest.approx([5.0 / 3.0, 0.0, 0.0], abs=1e-15)


def test_functions_broadcast():
    rng = np.random.default_rng(23)
    s = np.array([[joint_screw(kind, rng) for kind in KINDS] for _ in range(2)])
    q = rng.standard_normal((2, 3))
    H = screws.exp(s, q)
    cases = ((screws.hat, s), (screws.ad, s), (screws.Ad, H), (screws.vee, H))
    for function, argument in cases:
        together = function(argument)
        for i in np.ndindex(2, 3):
            assert np.array_equal(together[i], function(argument[i]))
    for i in np.ndindex(2, 3):
        assert H[i] == pytest.approx(screws.exp(s[i], q[i]), abs=1e-15)
    assert screws.exp(s[0, 0], np.arange(5.0)).shape == (5, 4, 4)
    assert screws.exp(s[:, :1], q).shape == (2, 3, 4, 4)
    assert screws.hat([1, 2, 3, 4, 5, 6]).dtype == np.float64
