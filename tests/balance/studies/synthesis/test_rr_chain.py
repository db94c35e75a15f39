"""RR chains through two and three positions, by routes that do not use their equation.

[B] G. Becht, MSc thesis, TU Delft, 2020, chapter 3.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from balance.studies.synthesis.positions import Position, displacements
from balance.studies.synthesis.rr_chain import (
    chain_from_fixed_pivot,
    chain_from_moving_pivot,
    chain_from_three_positions,
)
from kinematics.errors import SynthesisError, UsageError

A = Position(0.3, 0.1, 0.2)
B = Position(0.1, 0.4, -0.7)


def rotated(point, about, angle):
    """A point turned about another, with a matrix of sines and cosines."""
    c, s = math.cos(angle), math.sin(angle)
    x, y = point.real - about.real, point.imag - about.imag
    return about + complex(c * x - s * y, s * x + c * y)


def misses(chain, ratio):
    """Distances of the tool from its positions, link by link: first the second joint turns."""
    found = []
    start = chain.positions[0]
    for position in chain.positions:
        turn = position.angle - start.angle
        tool = rotated(start.point, chain.moving, turn - ratio * turn)
        tool = rotated(tool, chain.fixed, ratio * turn)
        found.append(abs(tool - position.point) / (1.0 + abs(chain.fixed) + abs(chain.moving)))
    return found


def random_positions(rng, count):
    return [
        Position(*rng.uniform(-1.0, 1.0, 2), angle)
        for angle in rng.choice([-1.0, 1.0], count) * rng.uniform(0.1, 2.5, count)
    ]


def test_random_positions_are_met():
    """[B] section 3.1: the chain passes through 2 and 3 positions, the angles in the ratio."""
    rng = np.random.default_rng(1)
    for _ in range(100):
        ratio = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.9))
        two, three = random_positions(rng, 2), random_positions(rng, 3)
        pivot = complex(*rng.uniform(-1.0, 1.0, 2))
        for chain in (
            chain_from_fixed_pivot(two, ratio, pivot),
            chain_from_moving_pivot(two, ratio, pivot),
            chain_from_three_positions(three, ratio),
        ):
            assert max(misses(chain, ratio)) < 1e-12
            size = 1.0 + abs(chain.fixed) + abs(chain.moving)
            assert chain.error < 1e-12 * size
            for link, tool in zip(chain.link_turns[1:], chain.tool_turns[1:], strict=True):
                assert link / tool == pytest.approx(ratio, rel=1e-14)
            assert max(misses(chain, ratio + 0.01)) > 1e-9
        assert chain_from_fixed_pivot(two, ratio, pivot).fixed == pivot
        assert chain_from_moving_pivot(two, ratio, pivot).moving == pivot


def test_two_of_three_positions_give_the_same_chain():
    three = random_positions(np.random.default_rng(2), 3)
    whole = chain_from_three_positions(three, -0.6)
    part = chain_from_moving_pivot(three[:2], -0.6, whole.moving)
    assert part.fixed == pytest.approx(whole.fixed, abs=1e-12)


def test_the_moving_pivot_of_the_second_position_has_the_corrected_sign():
    """[B] Eq. 25 prints ``d2 + A (d1 - W1)``; it is ``d2 + A (W1 - d1)``."""
    moving = 0.2 - 0.1j
    chain = chain_from_moving_pivot([A, B], -0.5, moving)
    A12 = cmath.exp(1j * (B.angle - A.angle))
    right = B.point + A12 * (moving - A.point)
    printed = B.point + A12 * (A.point - moving)
    here = rotated(moving, chain.fixed, chain.link_turns[1])
    assert here == pytest.approx(right, abs=1e-14)
    assert abs(here - printed) > 0.1
    assert displacements([A, B])[0].move(moving) == pytest.approx(right, abs=1e-14)


def test_the_turn_of_the_first_link_is_an_arcsine():
    """[B] Eq. 24 prints ``2 arctan(|W2 - W1| / 2 |W1 - G|)``; it is the arcsine."""
    chain = chain_from_moving_pivot([A, B], -0.8, 0.2 - 0.1j)
    end = displacements([A, B])[0].move(chain.moving)
    half = 0.5 * abs(end - chain.moving) / chain.length
    assert 2.0 * math.asin(half) == pytest.approx(abs(chain.link_turns[1]), abs=1e-14)
    assert abs(2.0 * math.atan(half) - abs(chain.link_turns[1])) > 1e-2


@pytest.mark.parametrize("ratio", [-0.5, -1.0, -2.5])
def test_the_path_is_a_hypotrochoid(ratio):
    """[B] Eqs. 15 and 16, their signs corrected: a circle of radius b rolls inside one of a.

    Printed: ``y = n sin t - h sin(-n t / b)``, which adds; and Eq. 16 with k for ``-1 / k``.
    """
    chain = chain_from_fixed_pivot([A, B], ratio, 0.1 - 0.3j)
    turns = np.linspace(min(chain.link_turns), max(chain.link_turns), 50)
    path = chain.tool_points(turns, turns / ratio) - chain.fixed
    first, second = chain.first_angle, cmath.phase(chain.reach)
    # The arm of the rolling circle turns by -n/b for one turn of the centre.
    n, h = chain.length, abs(chain.reach)
    b = -n * ratio
    t, s = turns + first, -turns * n / b + second
    assert np.allclose(path.real, n * np.cos(t) + h * np.cos(s), atol=1e-13)
    assert np.allclose(path.imag, n * np.sin(t) + h * np.sin(s), atol=1e-13)
    # It rolls without slip: arcs of both circles are equal, ``a dt = -b (ds - dt)``.
    assert (n + b) == pytest.approx(-b * (-n / b - 1.0))
    # Printed signs, from the same angles: another curve.
    k = -1.0 / ratio
    theta = turns + first
    right = n * np.exp(1j * theta) + h * np.exp(1j * (second - k * turns))
    printed = n * np.exp(1j * theta) + h * np.exp(1j * (second + k * turns))
    assert np.allclose(path, right, atol=1e-13) and np.abs(path - printed).max() > 1e-2


@pytest.mark.parametrize(
    ("positions", "ratio", "error", "said"),
    [
        ([A, A], -1.0, SynthesisError, "positions 1 and 2 coincide"),
        ([A, B], 0.0, UsageError, "k = 0: the first link stands still"),
        ([A, B], 1.0, UsageError, "k = 1: both links are one body"),
        ([A, B], math.nan, UsageError, "no finite number"),
        ([A], -1.0, UsageError, "1 positions: give 2 to 20"),
        ([A, B, (1, 1, 1)], -1.0, UsageError, "3 positions: give 2"),
        ([A, (0.3, 0.1, 0.2 + 2 * math.pi)], -1.0, SynthesisError, "coincide"),
        ([A, (0.5, 0.1, 0.2)], -1.0, SynthesisError, "same angle"),
        ([A, (0.5, math.inf, 0.2)], -1.0, UsageError, "position 2 is not of finite numbers"),
        ([A, (0.5, 0.5, A.angle + math.pi)], 2.0, SynthesisError, "whole turns only"),
        ([A, (0.5, 0.5, A.angle + math.pi)], 3.0, None, ""),
    ],
)
def test_what_has_no_chain_is_refused(positions, ratio, error, said):
    if error is None:
        assert chain_from_moving_pivot(positions, ratio, 0.1j).error < 1e-12
        return
    with pytest.raises(error, match=said):
        chain_from_moving_pivot(positions, ratio, 0.1j)


def test_pivots_on_poles_are_refused():
    (step,) = displacements([A, B])
    for make in (chain_from_fixed_pivot, chain_from_moving_pivot):
        with pytest.raises(SynthesisError, match="is the pole"):
            make([A, B], -0.5, step.pole)
    with pytest.raises(SynthesisError, match="does not turn against"):
        chain_from_fixed_pivot([A, (0.5, 0.5, A.angle + math.pi)], 3.0, 0.1j)
    # Turned about one point: the only chain has both pivots there.
    about = [Position(math.cos(a), math.sin(a), a) for a in (0.0, 0.4, 1.1)]
    with pytest.raises(SynthesisError, match="pole"):
        chain_from_three_positions(about, -1.0)
