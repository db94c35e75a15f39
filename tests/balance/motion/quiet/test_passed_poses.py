"""Poses that a plan passes: of inputs, of a tool that leaves inputs free, and cycles."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import minimize

import balance
from balance.app.answers.text.quiet import quiet_body
from balance.app.answers.text.render import body_text
from kinematics.errors import LinkageError
from tests.support.planned_arms import (
    base_wrenches,
    pinocchio_model,
    planar_arm,
    six_axes,
    slide,
)

ENDS = [0.2, 0.4], [1.4, 1.5]
VIA = [0.9, 0.2]


def rms(linkage, duration, motion):
    """Root mean square of the force over a motion at even times, by Pinocchio."""
    time = np.linspace(0.0, duration, len(motion[0]))
    force = base_wrenches(linkage, *motion)[:, 3:]
    return np.sqrt(np.trapezoid((force**2).sum(axis=1), time) / duration)


def rest_at(stops, times, count=801):
    """The quintic law on each straight line between stops."""
    time = np.linspace(0.0, times[-1], count)
    leg = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(stops) - 2)
    span = np.diff(times)[leg]
    x = ((time - np.array(times)[leg]) / span)[:, None]
    line, span = np.diff(stops, axis=0)[leg], span[:, None]
    return (
        np.array(stops)[leg] + line * (10 * x**3 - 15 * x**4 + 6 * x**5),
        line * 30 * x**2 * (1 - x) ** 2 / span,
        line * 60 * x * (1 - x) * (1 - 2 * x) / span**2,
    )


def test_a_pose_is_passed_at_a_chosen_time():
    arm = planar_arm(2)
    plan = balance.quiet_motion(arm, *ENDS, 1.0, via=[VIA])
    (passed,) = plan.passed
    assert 0.1 < passed.time < 0.9
    u, ud, _ = plan.path.at(np.array([0.0, passed.time, 1.0]))
    assert u == pytest.approx(np.array([ENDS[0], VIA, ENDS[1]]), abs=1e-9)
    assert np.abs(ud[1]).max() > 0.1, "it does not stop there"
    ways = [np.linalg.norm(np.subtract(a, b)) for a, b in ((VIA, ENDS[0]), (ENDS[1], VIA))]
    middle = np.sqrt(ways[0]) / np.sum(np.sqrt(ways))
    stopped = rms(arm, 1.0, rest_at([ENDS[0], VIA, ENDS[1]], [0.0, middle, 1.0]))
    assert stopped == pytest.approx(plan.quintic.value, rel=2e-3)
    planned = rms(arm, 1.0, plan.samples(801)[1:])
    assert planned == pytest.approx(plan.after.value, rel=1e-3)
    assert plan.bound < planned < 0.6 * stopped


@pytest.mark.slow
def test_no_other_time_of_the_pose_shakes_less():
    """Against SLSQP on cubic splines: the knot of the pose moves, the others with it."""
    arm, parts = planar_arm(2), 5
    plan = balance.quiet_motion(arm, *ENDS, 1.0, via=[VIA])
    points, weights = np.polynomial.legendre.leggauss(3)

    def knots_of(at):
        return np.append(np.linspace(0, at, parts + 1), np.linspace(at, 1, parts + 1)[1:])

    def shaking(z):
        knots, rest = knots_of(z[0]), np.zeros((1, 2))
        places, rates = np.split(z[1:].reshape(-1, 2), [2 * parts - 2])
        u = [[ENDS[0]], places[: parts - 1], [VIA], places[parts - 1 :], [ENDS[1]]]
        spline = CubicHermiteSpline(
            knots, np.concatenate(u), np.concatenate([rest, rates, rest])
        )
        half, middle = 0.5 * np.diff(knots)[:, None], 0.5 * (knots[1:] + knots[:-1])[:, None]
        time = (middle + half * points).ravel()
        force = base_wrenches(arm, spline(time), spline(time, 1), spline(time, 2))[:, 3:]
        return np.sqrt((half * weights).ravel() @ (force**2).sum(axis=1))

    u, ud, _ = plan.path.at(knots_of(plan.passed[0].time)[1:-1])
    places = np.delete(u, parts - 1, axis=0)
    first = np.concatenate([[plan.passed[0].time], places.ravel(), ud.ravel()])
    other = minimize(
        shaking,
        first,
        method="SLSQP",
        bounds=[(0.2, 0.8), *[(None, None)] * (len(first) - 1)],
        options={"maxiter": 40, "ftol": 1e-8},
    )
    assert other.fun > 0.99 * plan.after.value


def tool_position(linkage, name, u):
    """The origin of a link's frame, by Pinocchio."""
    import pinocchio as pin

    model, at = pinocchio_model(linkage)
    q = np.zeros(model.nv)
    q[at] = u
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.integrate(model, pin.neutral(model), q))
    return data.oMf[model.getFrameId(name)]


def test_a_tool_reaches_its_pose_and_the_plan_chooses_the_rest():
    arm, start, goal = planar_arm(3), [0.1, 0.5, 0.3], {"x": -0.2, "y": 0.3}
    plan = balance.quiet_motion(arm, start, goal, 1.0, tool="link3")
    before = tool_position(arm, "link3", [0.0, 0.0, 0.0])
    after = tool_position(arm, "link3", plan.end)
    assert (after.translation - before.translation)[:2] == pytest.approx([-0.2, 0.3], abs=1e-9)
    # The nearest of these poses, kept, shakes more.
    law = plan.laws[0].figures
    assert plan.after.value < law.value
    nearest = rms(arm, 1.0, plan.samples(401)[1:])
    assert nearest == pytest.approx(plan.after.value, rel=1e-3)
    turned = np.linspace(-0.3, 0.3, 3)[:, None] * np.array([0.0, 1.0, -1.0])
    fixed = [
        balance.quiet_motion(arm, start, {"x": -0.2, "y": 0.3, "rz": angle}, 1.0, tool="link3")
        for angle in plan.end.sum() + turned[:, 1]
    ]
    values = [other.after.value for other in fixed]
    assert values[1] == pytest.approx(plan.after.value, rel=2e-3)
    assert min(values) > 0.998 * plan.after.value


@pytest.mark.slow
def test_six_axes_turn_their_tool():
    """All six coordinates of the tool, by Pinocchio."""
    arm, bent = six_axes(), [0, -0.4, 0.9, 0.2, 0.1, 0]
    goal = {"x": -0.2, "y": 0.2, "z": 0.1, "rx": 0.3, "ry": -0.2, "rz": 0.4}
    plan = balance.quiet_motion(arm, bent, goal, 1.0, tool="link6")
    assert plan.feasible and not plan.passed
    before = tool_position(arm, "link6", np.zeros(6))
    after = tool_position(arm, "link6", plan.end)
    assert after.translation - before.translation == pytest.approx([-0.2, 0.2, 0.1], abs=1e-9)
    a, b, c = 0.3, -0.2, 0.4
    X = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    Y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    Z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    assert after.rotation @ before.rotation.T == pytest.approx(X @ Y @ Z, abs=1e-9)


@pytest.mark.parametrize(("measure", "least"), [("rms", 8.0 * np.sqrt(3.0)), ("peak", 16.0)])
def test_the_least_cycle_of_a_slide(measure, least):
    """The factors of m d / T² for a cycle; few harmonics of a square wave are not reached."""
    plan = balance.quiet_motion(
        slide(), [0.0], [0.5], 1.0, cycle=True, measure=measure, harmonics=9
    )
    assert plan.bound == pytest.approx(least, rel=1e-12)
    assert least <= plan.after.value < (1.001 if measure == "rms" else 1.05) * least
    u = plan.samples(1001)[1]
    assert np.ptp(u) == pytest.approx(0.5, abs=2e-3)


def test_a_cycle_is_periodic_and_of_few_harmonics():
    arm = planar_arm(2)
    plan = balance.quiet_motion(arm, ENDS[0], None, 0.8, via=[VIA, ENDS[1]], cycle=True)
    assert plan.feasible and plan.harmonics == 5
    time, *motion = plan.samples(65)
    for values in motion:
        assert values[0] == pytest.approx(values[-1], abs=1e-8)
    spectrum = np.abs(np.fft.rfft(motion[0][:-1], axis=0))
    assert spectrum[6:].max() < 1e-10 * spectrum[0].max()
    times = [point.time for point in plan.passed]
    assert times[0] == 0.0 and np.all(np.diff(times) > 0.0)
    for point, pose in zip(plan.passed, (ENDS[0], VIA, ENDS[1]), strict=True):
        assert plan.path.at(np.array([point.time]))[0][0] == pytest.approx(pose, abs=1e-9)
    assert plan.bound < rms(arm, 0.8, plan.samples(401)[1:]) < 0.8 * plan.quintic.value
    text = body_text(quiet_body(plan))
    assert "a cycle of 5 harmonics" in text and "passed at (s)" in text


def test_lines_of_a_cycle_next_to_a_natural_frequency_vanish():
    """By the spectrum of the shaking force, of Pinocchio."""
    arm = planar_arm(2)
    options = {"cycle": True, "harmonics": 6}
    free = balance.quiet_motion(arm, *ENDS, 1.0, **options)
    plan = balance.quiet_motion(arm, *ENDS, 1.0, frequencies=[3.3], **options)
    sizes = []
    for each in (free, plan):
        force = base_wrenches(arm, *each.samples(257)[1:])[:-1, 3:]
        sizes.append(np.linalg.norm(np.fft.rfft(force, axis=0), axis=1) / len(force))
    assert plan.feasible and plan.frequencies == (3.0, 4.0)
    assert sizes[1][[3, 4]].max() < 2e-3 * plan.after.value
    assert sizes[0][3] > 20.0 * sizes[1][3]
    assert free.after.value <= plan.after.value * (1 + 1e-3)


def test_a_pose_that_a_cycle_cannot_pass_is_named():
    """One harmonic goes to and fro once; the laws, which turn at all poses, are too fast."""
    given = {"via": [[0.5], [0.1], [0.4], [0.2]], "cycle": True, "harmonics": 1}
    plan = balance.quiet_motion(slide(), [0.0], None, 1.0, **given)
    assert plan.verdict == "feasible" and plan.law != "planned"
    plan = balance.quiet_motion(slide(), [0.0], None, 1.0, velocity=2.0, **given)
    assert plan.verdict == "infeasible" and plan.exceeded.kind == "pose"
    assert "is missed, by" in plan.words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"end": {"x": 0.1}}, "name the link that is the tool"),
        ({"end": {"x": 0.1}, "tool": "ghost"}, "ghost"),
        ({"end": {"x": 9.0}, "tool": "link2"}, "cannot reach x=9"),
        ({"end": {"z": 0.1}, "tool": "link2"}, "cannot reach z=0.1"),
        ({"end": None}, "give the pose to reach"),
        ({"end": [0.3, 0.3], "via": [[0.3, 0.3]]}, "two poses that follow are one"),
        ({"end": [0.3, 0.3], "cycle": True, "harmonics": 0}, "number of harmonics"),
    ],
)
def test_bad_poses_are_refused(options, words):
    given = {"start": [0.2, 0.4], "duration": 1.0} | options
    with pytest.raises(LinkageError, match=words):
        balance.quiet_motion(planar_arm(2), **given)
