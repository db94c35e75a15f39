"""Mass against input inertia of rotors on a double pendulum, against a search over its levers.

With the formulas of `test_rotors`, for counterweights at levers a1, a2 up to the reach,

    mass = m1 + m2 + (I1 + I2) / N / ρ²        inertia = (1 + N) (I1 + I2).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from balance.masses.remedies.compare import compare_request
from balance.masses.remedies.counter_rotations.counter_rotary_masses import (
    apply_counter_rotary_masses,
)
from balance.masses.remedies.counter_rotations.separate_rotors import apply_separate_rotors
from balance.masses.remedies.trade_off import TradeOff, best_points
from tests.support.double_pendulum import REACH, pendulum

RADIUS = 0.8


def costs(levers, gear):
    """Added mass and input inertia for two levers."""
    a1, a2 = levers
    m2 = 0.5 / a2
    m1 = (1.5 + m2) / a1
    second = 1.0 / 3.0 + m2 * a2**2
    first = 1.0 / 3.0 + m1 * a1**2 + 1.0 + m2 + second
    both = first + second
    return m1 + m2 + both / gear / RADIUS**2, (1.0 + gear) * both


def least_sum(price, gear):
    """Least inertia + price mass over both levers, from many starts."""
    grid = np.linspace(0.05 * REACH, REACH, 12)

    def total(levers):
        mass, inertia = costs(levers, gear)
        return inertia + price * mass

    start = min(((a, b) for a in grid for b in grid), key=total)
    found = minimize(total, start, bounds=[(1e-3, REACH)] * 2, options={"ftol": 1e-15})
    return found.fun


def with_points(count, gear=2.0):
    """The request, with a trade-off."""
    request = pendulum(gear, RADIUS)
    return type(request)(
        request.linkage, regions=request.regions, gear=gear, radius=RADIUS, trade_off=count
    )


def test_points_are_best_for_their_price():
    """No levers do better; the first point is the least mass, and the files' inertia."""
    gear = 2.0
    rotors = next(apply_separate_rotors(with_points(5, gear)))
    first, *rest = rotors.trade_off
    assert first.price is None and first.added_mass == rotors.added_mass
    assert first.inertia == pytest.approx(sum(rotors.input_inertia.values()), rel=1e-12)
    assert (first.added_mass, first.inertia) == pytest.approx(costs((REACH, REACH), gear), 1e-7)
    assert len(rest) >= 2
    for point in rest:
        reached = point.inertia + point.price * point.added_mass
        assert reached == pytest.approx(least_sum(point.price, gear), rel=1e-6)
        assert 0.0 <= point.gap < 1e-6
    masses, inertias = np.array([[p.added_mass, p.inertia] for p in rotors.trade_off]).T
    assert (np.diff(masses) > 0.0).all() and (np.diff(inertias) < 0.0).all()


@pytest.mark.slow
def test_smaller_gears_take_heavier_rotors_of_less_inertia():
    """Points of several gears make one curve, and the files are those without a curve."""
    comparison = compare_request(with_points(3), ["separate_rotors"])
    plain = compare_request(pendulum(2.0, RADIUS), ["separate_rotors"])
    points = comparison.results[0].trade_off
    assert {point.gear for point in points} == {2.0, 1.0, 0.5}
    for point in points:
        if point.price is not None:
            reached = point.inertia + point.price * point.added_mass
            assert reached == pytest.approx(least_sum(point.price, point.gear), rel=1e-6)
    assert [each.urdf for each in comparison.results] == [each.urdf for each in plain.results]
    assert not plain.results[0].trade_off


def test_points_that_others_beat_are_left_out():
    points = [TradeOff(m, i, 1.0, None, 0.0) for m, i in ((1, 5), (2, 6), (3, 4), (3.1, 3.999))]
    assert [point.added_mass for point in best_points(points)] == [1, 3]


def turning_costs(masses, gear):
    """Added mass, input inertia, and how far limits are kept, of two turning counterweights."""
    m1, m2 = masses
    a1 = 1.5 + m2
    second = 1.0 / 3.0 + 0.25 / m2
    first = 1.0 / 3.0 + 1.0 + m2 + a1**2 / m1 + second + second / gear
    rims = m1 * RADIUS**2 - first / gear, m2 * RADIUS**2 - second / gear
    levers = REACH - a1 / m1, REACH - 0.5 / m2
    return m1 + m2, (1.0 + gear) * (first + second), np.array([*rims, *levers])


@pytest.mark.slow
@pytest.mark.parametrize("gear", [1.0, 2.0])
def test_turning_counterweights_move_to_where_they_are_felt_least(gear):
    """Levers are sizes of the trade-off: no two masses that keep all limits do better."""
    request = with_points(4, gear)
    turning = next(apply_counter_rotary_masses(request))
    first, *rest = turning.trade_off
    assert first.added_mass == turning.added_mass and len(rest) >= 2
    for point in rest:
        price = point.price

        def total(masses, price=price):
            mass, inertia, _ = turning_costs(masses, gear)
            return inertia + price * mass

        best = minimize(
            total,
            [8.0, 3.0],
            bounds=[(0.1, 1e3)] * 2,
            constraints={"type": "ineq", "fun": lambda m: turning_costs(m, gear)[2]},
            options={"ftol": 1e-13, "maxiter": 500},
        )
        reached = point.inertia + price * point.added_mass
        assert reached == pytest.approx(best.fun, rel=1e-3)
        assert reached >= best.fun * (1.0 - 1e-6)
        assert 0.0 <= point.gap < 1e-3
