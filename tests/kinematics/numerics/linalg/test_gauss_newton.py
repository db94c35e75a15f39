"""Newton's method: laws of the loop and of its rules, on equations with known solutions."""

from __future__ import annotations

import numpy as np
import pytest

from kinematics.numerics.linalg.gauss_newton import (
    FixedRank,
    LeastNorm,
    LevenbergMarquardt,
    gauss_newton,
    never_stop,
    step_grows,
)


def circle(x):
    """On the circle of radius 5 and on the line y = x + 1: (3, 4) and (-4, -3)."""
    return (
        np.array([x @ x - 25.0, x[1] - x[0] - 1.0]),
        np.array([2.0 * x, [-1.0, 1.0]]),
    )


def rosenbrock(x):
    """Residuals whose sum of squares is the valley of H. Rosenbrock (1960); zero at (1, 1)."""
    return (
        np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]),
        np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]]),
    )


def small(path):
    return path[-1].error <= 1e-13


@pytest.mark.parametrize("rule", [LeastNorm(1e-9), FixedRank(2), LevenbergMarquardt(0.1)])
def test_equations_of_two_unknowns_are_solved(rule):
    last, solved = gauss_newton(circle, np.array([2.0, 4.0]), rule, small, never_stop, 40)
    assert solved and last.x == pytest.approx([3.0, 4.0], abs=1e-13)


def test_convergence_is_quadratic():
    """Each error is of the order of the square of the one before."""
    errors = []

    def note(path):
        errors.append(float(np.abs(path[-1].x - [3.0, 4.0]).max()))
        return small(path)

    assert gauss_newton(
        circle, np.array([2.5, 4.5]), LeastNorm(1e-9), note, never_stop, 10
    ).solved
    for before, after in zip(errors[:-1], errors[1:], strict=True):
        assert after <= before**2 + 1e-14


@pytest.mark.parametrize("rule", [LeastNorm(1e-9), FixedRank(1)])
def test_least_norm_moves_straight_to_a_sphere(rule):
    """Fewer equations than unknowns: the nearest point is on the ray through the start."""
    start = np.array([1.0, 2.0, -2.0])
    last, solved = gauss_newton(
        lambda x: (np.array([x @ x - 36.0]), 2.0 * x[None]), start, rule, small, never_stop, 20
    )
    assert solved and last.x == pytest.approx(2.0 * start, abs=1e-12)


def test_a_direction_that_the_equations_hardly_see_is_left_alone():
    def equations(x):
        return np.array([x[0] - 1.0, 1e-6 * (x[1] - 1.0)]), np.diag([1.0, 1e-6])

    far = gauss_newton(
        equations, np.zeros(2), LeastNorm(1e-9), never_stop, never_stop, 1
    ).last.next
    near = gauss_newton(
        equations, np.zeros(2), LeastNorm(1e-3), never_stop, never_stop, 1
    ).last.next
    one = gauss_newton(
        equations, np.zeros(2), FixedRank(1), never_stop, never_stop, 1
    ).last.next
    assert far == pytest.approx([1.0, 1.0])
    assert near == pytest.approx([1.0, 0.0]) and one == pytest.approx([1.0, 0.0])


def test_long_steps_are_shortened_along_their_direction():
    rule = LeastNorm(1e-9, longest=0.5)
    last = gauss_newton(
        circle, np.array([2.0, 4.0]), LeastNorm(1e-9), never_stop, never_stop, 1
    ).last
    short = gauss_newton(circle, np.array([2.0, 4.0]), rule, never_stop, never_stop, 1).last
    assert last.size > 0.5 and short.size == pytest.approx(0.5)
    assert short.step == pytest.approx(last.step * 0.5 / last.size, abs=1e-14)


def test_the_method_gives_up_at_a_step_that_grows():
    """Newton's method on the cube root doubles its distance from 0 at every step."""

    def root(x):
        return np.cbrt(x), np.diag(np.abs(np.cbrt(x)) ** -2 / 3.0)

    def run(start, stop):
        """How often the cube root is evaluated, and where the method ends."""
        seen = []
        found = gauss_newton(
            lambda x: (seen.append(x), root(x))[1],
            np.array([start]),
            LeastNorm(0),
            small,
            stop,
            9,
        )
        assert not found.solved
        return len(seen), float(found.last.x[0])

    assert run(0.01, step_grows(0.5)) == (2, pytest.approx(-0.02))
    assert run(1.0, step_grows(0.5)) == (1, 1.0)
    assert run(0.01, step_grows(1.0, negligible=0.1)) == (3, pytest.approx(0.04))


def test_damped_steps_never_move_away_and_descend_a_curved_valley():
    """Every point accepted is nearer to a solution than those before."""
    sizes = []

    def note(path):
        sizes.append(np.linalg.norm(path[-1].residual))
        return small(path)

    start = np.array([-1.2, 1.0])
    last, solved = gauss_newton(
        rosenbrock, start, LevenbergMarquardt(0.1), note, never_stop, 200
    )
    assert solved and last.x == pytest.approx([1.0, 1.0], abs=1e-12)
    assert all(after <= before for before, after in zip(sizes[:-1], sizes[1:], strict=True))


def test_a_step_that_is_refused_is_damped_more():
    """An equation without a solution: damping grows, the point stays where it is lowest."""
    rule = LevenbergMarquardt(0.1)
    start = np.array([1e-3])

    def equations(x):
        return np.array([1.0 + x[0] ** 4]), np.array([[4.0 * x[0] ** 3 or 1e-9]])

    last, solved = gauss_newton(
        equations, start, rule, small, lambda path: rule.damping > 1e6, 500
    )
    assert not solved and last.error == pytest.approx(1.0, abs=1e-9)


def test_unknowns_need_not_be_a_vector():
    """A rotation of the plane, as a complex number, that takes 1 to i."""
    found = gauss_newton(
        lambda turn: (np.array([np.angle(turn / 1j)]), np.eye(1)),
        1.0 + 0.0j,
        LeastNorm(1e-9),
        small,
        never_stop,
        5,
        lambda turn, step: turn * np.exp(-1j * step[0]),
    )
    assert found.solved and found.last.x == pytest.approx(1j)


def test_without_equations_the_start_is_the_solution():
    last, solved = gauss_newton(
        lambda x: (np.empty(0), np.empty((0, 2))),
        np.ones(2),
        LeastNorm(1e-9),
        small,
        never_stop,
        3,
    )
    assert solved and last.x.tolist() == [1.0, 1.0]
