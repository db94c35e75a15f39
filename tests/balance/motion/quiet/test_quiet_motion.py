"""Planned motions: never worse than the usual laws, within limits, and not beaten by others."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import minimize

import balance
from balance.app.answers.text.quiet import quiet_facts
from balance.motion.quiet import convex_steps
from balance.motion.quiet.limits import InputLimits
from balance.motion.verification.given_motions import from_csv
from balance.support.clarabel_adapter import solve_cones
from kinematics.errors import LinkageError
from tests.support.covering import number_of_cases
from tests.support.planned_arms import TASKS, base_wrenches, planar_arm, slide, torques

OBJECTIVES = [("force", "rms"), ("force", "peak"), ("both", "rms"), ("both", "peak")]


def size(wrench, plan):
    """The size of the shaking that a plan minimises, at instants, from wrenches."""
    force = wrench[:, 3:]
    moment = wrench[:, :3] - np.cross(plan.objective.point, force)
    parts = {
        "force": [force],
        "moment": [moment],
        "both": [force, moment / plan.objective.length],
    }
    return np.linalg.norm(np.concatenate(parts[plan.objective.part], axis=1), axis=1)


def value(time, sizes, measure):
    """Peak, or root mean square over time."""
    return (
        sizes.max() if measure == "peak" else np.sqrt(np.trapezoid(sizes**2, time) / time[-1])
    )


def quintic(start, end, tau, duration):
    """Positions, velocities and accelerations of the quintic law."""
    way = np.subtract(end, start)
    laws = (
        10 * tau**3 - 15 * tau**4 + 6 * tau**5,
        30 * tau**2 * (1 - tau) ** 2 / duration,
        60 * tau * (1 - tau) * (1 - 2 * tau) / duration**2,
    )
    return [start * (k == 0) + law[:, None] * way for k, law in enumerate(laws)]


def trapezoid(start, end, tau, duration):
    """The same of the law with thirds of constant acceleration, speed and braking."""
    way, late = np.subtract(end, start), 1 - tau
    s = np.where(
        tau < 1 / 3, 2.25 * tau**2, np.where(tau > 2 / 3, 1 - 2.25 * late**2, 1.5 * tau - 0.25)
    )
    speed = np.minimum(np.minimum(4.5 * tau, 1.5), 4.5 * late)
    change = np.where(tau < 1 / 3, 4.5, np.where(tau > 2 / 3, -4.5, 0.0))
    laws = s, speed / duration, change / duration**2
    return [start * (k == 0) + law[:, None] * way for k, law in enumerate(laws)]


def check_against_the_laws(name, part, measure):
    """No worse than both laws, by Pinocchio."""
    build, start, end = TASKS[name]
    linkage, duration, start = build(), 0.8, np.array(start)
    options = {"minimise": part, "measure": measure, "file_limits": False}
    plan = balance.quiet_motion(linkage, start, end, duration, **options)
    tau = np.linspace(0.0, 1.0, 241)
    motion = plan.samples(tau.size)[1:]
    assert motion[0][[0, -1]] == pytest.approx(np.array([start, end]), abs=1e-12)
    assert motion[1][[0, -1]] == pytest.approx(0.0, abs=1e-9)
    laws = [law(start, end, tau, duration) for law in (quintic, trapezoid)]
    sizes = []
    for path in (motion, *laws):
        wrench = base_wrenches(linkage, *path)
        sizes.append(value(duration * tau, size(wrench, plan), measure))
    assert sizes[0] == pytest.approx(plan.after.value, rel=2e-3)
    assert sizes[1] == pytest.approx(plan.quintic.value, rel=2e-3)
    assert sizes[0] <= min(sizes[1:]) * (1 + 2e-3)
    assert plan.bound <= plan.after.value * (1 + 1e-6)


@pytest.mark.parametrize(("part", "measure"), OBJECTIVES)
def test_never_worse_than_the_laws(part, measure):
    check_against_the_laws("planar_2r", part, measure)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in TASKS if name != "planar_2r"])
def test_never_worse_on_other_linkages(name):
    for part, measure in OBJECTIVES[: number_of_cases(1, 4)]:
        check_against_the_laws(name, part, measure)


@pytest.mark.slow
def test_the_table_is_what_verify_reads(tmp_path):
    """Peak and root mean square of the shaking by Pinocchio, with the loops of a five-bar."""
    plan = balance.quiet_motion("five_bar", {}, {"u1": 0.5, "u2": -0.3}, 0.5)
    table = tmp_path / "quiet.csv"
    table.write_bytes(plan.table())
    motion = from_csv(plan.linkage, table)
    (run,) = balance.verify(plan.linkage, motions=[motion]).runs
    assert run.rms("force") == pytest.approx(plan.after.force_rms, rel=3e-3)
    assert run.peak("force") == pytest.approx(plan.after.force_peak, rel=3e-3)
    assert run.rms("moment") == pytest.approx(plan.after.moment_rms, rel=3e-3)


def other_solution(linkage, start, end, plan):
    """The least that SLSQP finds on cubic splines with velocities at knots, from the plan.

    Accelerations jump at the knots; samples are the middles of even intervals between them.
    """
    knots, width = np.linspace(0.0, plan.duration, 9), len(start)
    time = plan.duration * (np.arange(64) + 0.5) / 64

    def shaking_of(x):
        inner = x.reshape(2, -1, width)
        u = np.concatenate([[start], inner[0], [end]])
        ud = np.concatenate([np.zeros((1, width)), inner[1], np.zeros((1, width))])
        spline = CubicHermiteSpline(knots, u, ud)
        wrench = base_wrenches(linkage, spline(time), spline(time, 1), spline(time, 2))
        return np.sqrt(np.mean(size(wrench, plan) ** 2))

    path = plan.path.at(knots[1:-1])
    first = np.concatenate([path[0].ravel(), path[1].ravel()])
    options = {"maxiter": 25, "ftol": 1e-7}
    return minimize(shaking_of, first, method="SLSQP", options=options).fun


PROBLEMS = [
    ("planar_2r", [0.2, 0.4], [1.4, 1.5], "both"),
    ("scara", [0.3, 1.0, 0.0], [0.9, 0.2, -0.1], "force"),
    ("planar_2r", [0.0, 1.0], [-0.8, 0.3], "both"),
    ("planar_2r", [0.2, 0.4], [1.4, 1.5], "force"),
    ("planar_2r", [0.5, -1.0], [1.5, 0.5], "both"),
    ("planar_2r", [0.0, 0.8], [1.0, 2.0], "both"),
    ("scara", [0.0, 0.6, 0.0], [0.8, 1.2, 0.1], "both"),
    ("planar_2r", [0.0, 2.0], [1.0, 1.0], "both"),
    ("planar_2r", [0.0, 0.3], [0.6, 1.2], "both"),
    ("scara", [0.0, 1.0, 0.0], [-1.0, 1.4, 0.2], "both"),
]


@pytest.mark.slow
@pytest.mark.table(2)
@pytest.mark.parametrize(("name", "start", "end", "part"), PROBLEMS)
def test_a_second_solver_finds_nothing_better(name, start, end, part):
    linkage = TASKS[name][0]()
    plan = balance.quiet_motion(linkage, start, end, 1.0, minimise=part)
    assert other_solution(linkage, start, end, plan) > 0.99 * plan.after.value


@pytest.mark.slow
@pytest.mark.parametrize(("name", "most"), [("planar_2r", 90), ("ur5e", 200)])
def test_a_plan_takes_few_convex_programs(name, most, monkeypatch):
    """So that two joints take less than two seconds, and six less than twenty."""
    solved = []

    def solve_and_count(*given):
        solved.append(given)
        return solve_cones(*given)

    monkeypatch.setattr(convex_steps, "solve_cones", solve_and_count)
    build, start, end = TASKS[name]
    given = {"minimise": "both", "measure": "peak", "file_limits": False}
    assert balance.quiet_motion(build(), start, end, 0.8, **given).feasible
    assert 2 < len(solved) <= most


@pytest.mark.parametrize("limit", ["velocity", "acceleration", "jerk", "torque"])
def test_limits_are_kept(limit):
    """Of the first input, 0.9 of what the motion takes without it."""
    arm, start, end = planar_arm(2), [0.2, 0.4], [1.4, 1.5]
    given = {"jerk": {"jerk": 250.0}} if limit == "jerk" else {}
    free = balance.quiet_motion(arm, start, end, 1.0, **given.get(limit, {}))
    time = np.linspace(0.0, 1.0, 401)
    if limit == "jerk":
        peak = np.abs(free.path.jerk(time)[:, 0]).max()
        assert free.path.at(np.array([0.0, 1.0]))[2] == pytest.approx(0.0, abs=1e-8)
    else:
        peak = getattr(free.after, limit)[0]
    plan = balance.quiet_motion(arm, start, end, 1.0, **{limit: {"u1": 0.9 * peak}})
    u, ud, udd = plan.path.at(time)
    reached = {
        "velocity": ud,
        "acceleration": udd,
        "jerk": plan.path.jerk(time),
        "torque": torques(arm, u, ud, udd),
    }[limit]
    assert plan.feasible
    assert np.abs(reached[:, 0]).max() <= 0.9 * peak * 1.003
    assert plan.after.value > 0.999 * free.after.value or limit == "jerk"


def test_limits_of_the_file_count(tmp_path):
    text = planar_arm(2).to_urdf()
    path = tmp_path / "arm.urdf"
    limits = '<limit lower="-0.5" upper="2" velocity="1.35" effort="1e4"/></joint>'
    text = text.replace('type="continuous"', 'type="revolute"').replace("</joint>", limits)
    path.write_text(text, encoding="utf-8")
    options = ([0.2, 0.4], [1.4, 1.5], 1.0)
    assert balance.quiet_motion(path, *options).after.velocity.max() <= 1.353
    free = balance.quiet_motion(path, *options, file_limits=False)
    assert free.after.velocity.max() > 1.6
    beyond = balance.quiet_motion(path, [0.2, 0.4], [2.4, 1.5], 3.0)
    assert (beyond.exceeded.kind, beyond.exceeded.joint) == ("position", "u1")


def test_an_infeasible_limit_is_named():
    """0.5 m in 1 s need a mean speed of 0.5 m/s, and 2 m/s² at least."""
    plan = balance.quiet_motion(slide(), [0.0], [0.5], 1.0, velocity=0.4)
    assert (plan.verdict, plan.exceeded.kind, plan.exceeded.joint) == (
        "infeasible",
        "velocity",
        "u1",
    )
    assert plan.words.startswith("infeasible: the velocity of u1 exceeds its limit 0.4 by 0.2")
    plan = balance.quiet_motion(slide(), [0.0], [0.5], 1.0, acceleration=1.9)
    assert plan.exceeded.kind == "acceleration"
    assert balance.quiet_motion(slide(), [0.0], [0.5], 1.0, acceleration=2.1).feasible


def test_natural_frequencies_of_the_base_are_not_excited():
    arm, frequency = planar_arm(2), 2.0
    plans = [
        balance.quiet_motion(arm, [0.2, 0.4], [1.4, 1.5], 1.0, frequencies=given)
        for given in ((), (frequency,))
    ]
    excited = []
    for plan in plans:
        time, *motion = plan.samples(401)
        wave = np.exp(-2j * np.pi * frequency * time)[:, None]
        force = base_wrenches(arm, *motion)[:, 3:]
        excited.append(np.linalg.norm(np.trapezoid(wave * force, time, axis=0)))
    assert plans[1].feasible and excited[1] < 5e-3 * plans[1].quintic.value
    assert excited[0] > 10 * excited[1]
    # A frame that takes far longer than the motion feels the motion as a whole.
    slow = balance.quiet_motion(slide(), [0.0], [0.5], 1.0, frequencies=[0.02])
    assert slow.feasible or slow.exceeded.kind == "excitation"


def test_a_balanced_linkage_is_quiet_on_any_motion():
    plan = balance.quiet_motion("four_bar_kite_balanced", [0.0], [0.4], 1.0)
    assert plan.feasible and plan.after.value < 1e-8


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"end": {"ghost": 1.0}}, "joint ghost is not an input"),
        ({"end": {}}, "the two poses are one"),
        ({"end": [1.0]}, "give 2 displacements of the inputs"),
        ({"duration": 0.0}, "the duration must be above 0"),
        ({"velocity": -1.0}, "limit of velocity of u1: must be above 0"),
        ({"torque": {"ghost": 1.0}}, "limit of torque: 'ghost' is no input"),
        ({"minimise": "noise"}, "minimise: 'noise' is none of force, moment, both"),
        ({"frequencies": [0.0]}, "frequencies of the base must be above 0"),
        ({"weight_moment": -1.0}, "the length that weighs moments must be above 0"),
    ],
)
def test_bad_words_are_refused(options, words):
    given = {"start": {}, "end": {"u1": 0.3}, "duration": 1.0} | options
    with pytest.raises(LinkageError, match=words):
        balance.quiet_motion(planar_arm(2), **given)


def test_loops_that_cannot_be_closed_are_refused():
    with pytest.raises(LinkageError, match="five_bar"):
        balance.quiet_motion("five_bar", {}, {"u1": 3.0, "u2": -3.0}, 1.0)


@pytest.mark.parametrize("minimise", ["force", "moment"])
def test_a_balanced_linkage_does_not_shake(minimise):
    """Of round-off no law has less, and none of its digits is written."""
    plan = balance.quiet_motion("four_bar_kite_balanced", [0.0], [0.3], 1.0, minimise=minimise)
    assert plan.balanced and plan.verdict == "optimal" and plan.law == "planned"
    assert plan.words.startswith("optimal: below 1e-")
    facts = dict(quiet_facts(plan))
    assert facts["quintic"] == facts["trapezoidal"] == "does not shake"


def test_the_widest_limits_are_none():
    """Velocities from -1e308 to 1e308: their distance is no number of double precision."""
    widest = np.full((5, 1), 1e308)
    limits = InputLimits(-widest, widest)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert limits.excess(1, np.array([[2.0], [-3.0]])) == -1.0
        assert limits.spans[0] == 1.0
        least = np.full((5, 1), 1e-300)
        assert InputLimits(-least, least).excess(3, np.array([[1e200]])) == np.inf


def test_where_loops_do_not_close_along_a_plan_a_law_is_kept():
    """The plan of least moment leaves the workspace between its samples."""
    plan = balance.quiet_motion(
        "five_bar", [0.0, 0.0], [0.5, -0.3], 1.0, minimise="moment", acceleration=20.0
    )
    assert plan.exceeded is None
    assert plan.after.value <= min(law.figures.value for law in plan.laws if law.figures)
