"""Timings of a given path: convex programs beside closed forms and other discretisations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import balance
from balance.motion.quiet.compare import compare_with_laws
from balance.motion.quiet.limits import input_limits
from balance.motion.quiet.motion_space import quintic_path, trapezoidal_path
from balance.motion.quiet.problem import follow_poses, quiet_problem
from kinematics.errors import LinkageError
from tests.support.planned_arms import TASKS, base_wrenches, planar_arm, slide, torques

ENDS = ([0.2, 0.4], [1.4, 1.5])


def line_loads(arm, rates, start, end):
    """Wrenches and torques on a straight line of the inputs, by Pinocchio.

    Args:
        rates: places s, b and b'/2 (3, N).
    """
    s, b, change = rates
    way = np.subtract(end, start)
    u = start + s[:, None] * way
    ud, udd = np.sqrt(np.maximum(b, 0.0))[:, None] * way, change[:, None] * way
    return base_wrenches(arm, u, ud, udd), torques(arm, u, ud, udd)


@pytest.mark.parametrize(("speed", "peak"), [(0.6, 7.2), (0.75, 4.5), (0.9, 4.05)])
def test_a_slide_with_a_limit_of_speed(speed, peak):
    """2 kg over 0.5 m in 1 s: v t = v - 0.5 is the time of acceleration, and F = 2 v / t."""
    plan = balance.quiet_timing(slide(), [[0.0], [0.5]], 1.0, measure="peak", velocity=speed)
    assert plan.feasible and plan.verdict == "optimal"
    assert plan.after.velocity[0] <= speed * 1.002
    assert plan.after.value == pytest.approx(2 * speed / (1 - 0.5 / speed), rel=1e-2)
    assert plan.after.value == pytest.approx(peak, rel=1e-2)


def test_a_law_in_the_place_of_a_plan_is_not_called_optimal():
    """A plan that exceeds a limit yields to the trapezoidal law, whose speed is 1.5 d/T."""
    arm, (start, end) = slide(), (np.array([0.0]), np.array([0.5]))
    problem = quiet_problem(arm, input_limits(arm, 0.8), "force", "rms", None, None, (0, 0, 0))
    line = follow_poses(problem.model, np.linspace(0.0, 0.5, 11)[:, None])
    laws = [law(start, end, 1.0) for law in (quintic_path, trapezoidal_path)]
    answer = compare_with_laws(problem, 1.0, laws[0], line, laws, line, convex=True)
    assert answer.feasible and answer.law == "trapezoidal"
    assert answer.after.value > 1.05 * answer.bound
    assert answer.verdict == "feasible" and answer.words.startswith("feasible: ")


def test_the_least_mean_square_of_a_slide_is_the_cubic_law():
    plan = balance.quiet_timing(slide(), [[0.0], [0.5]], 1.0)
    time, u, ud, _ = plan.samples(51)
    assert plan.after.value == pytest.approx(np.sqrt(12.0), rel=1e-3)
    assert u[:, 0] == pytest.approx(0.5 * time**2 * (3 - 2 * time), abs=2e-4)
    assert ud[:, 0] == pytest.approx(3 * time * (1 - time), abs=5e-3)


def least_by_other_discretisation(arm, start, end, nodes=25):
    """The least root mean square of the force for a unit duration, by SLSQP.

    The law is s(t) with constant accelerations on even intervals of time; b is never formed.
    """
    steps = nodes - 1
    dt, way = 1.0 / steps, np.subtract(end, start)
    # s at nodes and middles from accelerations a; rest and arrival are two conditions.
    half = np.arange(2 * steps + 1) * 0.5 * dt

    def law(a):
        k = np.minimum((half / dt).astype(int), steps - 1)
        speeds = np.append(0.0, np.cumsum(a) * dt)
        places = np.append(0.0, np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * dt))
        rest = half - k * dt
        return (
            places[k] + speeds[k] * rest + 0.5 * a[k] * rest**2,
            speeds[k] + a[k] * rest,
            a[k],
        )

    def mean_square(a):
        s, sd, sdd = (x[1::2, None] for x in law(a))
        force = base_wrenches(arm, start + s * way, sd * way, sdd * way)[:, 3:]
        return (force**2).sum() * dt

    ends = {"type": "eq", "fun": lambda a: [law(a)[0][-1] - 1.0, a.sum()]}
    middle = (np.arange(steps) + 0.5) * dt
    found = minimize(
        mean_square,
        6.0 - 12.0 * middle,
        constraints=[ends],
        method="SLSQP",
        options={"maxiter": 60, "ftol": 1e-9},
    )
    return np.sqrt(found.fun)


@pytest.mark.slow
def test_a_second_discretisation_finds_nothing_better():
    arm, start = planar_arm(2), np.array(ENDS[0])
    plan = balance.quiet_timing(arm, ENDS, 1.0)
    other = least_by_other_discretisation(arm, start, ENDS[1])
    assert plan.after.value == pytest.approx(other, rel=5e-3)


def shortest_by_phase_plane(arm, start, end, most, nodes=1001):
    """The shortest duration within torques, by integration forwards and backwards in (s, b).

    At each s the admissible b'/2 are an interval for a given b; the fastest law accelerates as
    much as it may, and brakes as late as it can (J. E. Bobrow, 1985).
    """
    s = np.linspace(0.0, 1.0, nodes)
    zero, one = np.zeros(nodes), np.ones(nodes)
    still = line_loads(arm, (s, zero, zero), start, end)[1]
    by_b = line_loads(arm, (s, one, zero), start, end)[1] - still
    by_change = line_loads(arm, (s, zero, one), start, end)[1] - still

    def interval(k, b):
        bounds = np.array([-most, most]) - still[k][:, None] - by_b[k][:, None] * b
        ends = np.sort(bounds / by_change[k][:, None], axis=1)
        return ends[:, 0].max(), ends[:, 1].min()

    step = s[1]
    highest = np.full(nodes, np.inf)
    grid = np.linspace(0.0, 400.0, 801)
    for k in range(0, nodes, 20):
        good = [b for b in grid if np.subtract(*interval(k, b)) <= 0.0]
        highest[k : k + 20] = max(good)
    forward, backward = np.zeros(nodes), np.zeros(nodes)
    for k in range(1, nodes):
        rise = 2.0 * step * interval(k - 1, forward[k - 1])[1]
        forward[k] = np.clip(forward[k - 1] + rise, 1e-9, highest[k])
    for k in range(nodes - 2, -1, -1):
        rise = -2.0 * step * interval(k + 1, backward[k + 1])[0]
        backward[k] = np.clip(backward[k + 1] + rise, 1e-9, highest[k])
    roots = np.sqrt(np.minimum(forward, backward))
    return float(np.sum(2.0 * step / (roots[1:] + roots[:-1])))


@pytest.mark.slow
def test_the_shortest_duration_is_that_of_the_phase_plane():
    arm, start = planar_arm(2), np.array(ENDS[0])
    plan = balance.quiet_timing(arm, ENDS, 5.0, torque=12.0, front=2)
    assert plan.feasible
    other = shortest_by_phase_plane(arm, start, ENDS[1], 12.0)
    assert plan.shortest == pytest.approx(other, rel=1e-2)


def test_too_short_a_duration_names_the_limit_and_the_shortest_one():
    """0.5 m at 0.6 m/s, with 1.5 m/s² to reach that speed and to stop."""
    plan = balance.quiet_timing(slide(), [[0.0], [0.5]], 1.0, velocity=0.6, acceleration=1.5)
    assert plan.verdict == "infeasible" and plan.exceeded.joint == "u1"
    assert plan.shortest == pytest.approx(0.5 / 0.6 + 0.6 / 1.5, rel=2e-3)
    assert "the path takes at least 1.2" in plan.words


def test_the_front_falls_with_the_duration():
    """Without limits as the inverse square."""
    plan = balance.quiet_timing(planar_arm(2), ENDS, 1.0, front=3)
    durations, values = np.array(plan.front).T
    assert durations == pytest.approx([0.25, 0.5, 1.0])
    assert values * durations**2 == pytest.approx(plan.after.value, rel=1e-3)


@pytest.mark.parametrize("measure", ["rms", "peak"])
def test_no_worse_than_the_laws_on_a_curved_path(measure):
    arm = planar_arm(3)
    poses = [[0.1, 0.5, 0.3], [0.5, 1.2, 0.1], [1.2, 0.8, -0.5], [1.3, 0.2, -0.4]]
    plan = balance.quiet_timing(arm, poses, 1.0, measure=measure, minimise="both")
    kept = min(plan.quintic.value, plan.trapezoidal.value)
    assert plan.after.value < kept and plan.verdict == "optimal"
    # The poses are passed, in order.
    u = plan.samples(2001)[1]
    distances = np.abs(u[:, None] - np.array(poses)).max(axis=2)
    assert distances.min(axis=0).max() < 2e-3
    assert np.all(np.diff(distances.argmin(axis=0)) > 0)


@pytest.mark.slow
def test_a_path_of_a_closed_linkage():
    build, start, end = TASKS["five_bar"]
    timed = balance.quiet_timing(build(), [start, end], 0.5)
    free = balance.quiet_motion(build(), start, end, 0.5)
    assert free.after.value <= timed.after.value * (1 + 1e-6) < timed.quintic.value


@pytest.mark.parametrize("poses", [[[0.0, 0.0]], [[0.0], [1.0]], [[0, 0], [0, 0], [1, 1]]])
def test_poses_that_are_no_path_are_refused(poses):
    with pytest.raises(LinkageError, match="planar_2r"):
        balance.quiet_timing(planar_arm(2), poses, 1.0)
