"""Vibration of an elastic frame, against the textbook formulas of one degree of freedom."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.masses import ElasticFrame
from balance.masses.partial_balance.elastic_frame import is_periodic, vibration
from balance.masses.partial_balance.shaking_problem import ShakingOptions, build_problem
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.trajectory import Trajectory, random_motions
from kinematics.errors import UsageError
from tests.support.points import point_partial

ROTOR = (
    '<robot name="rotor"><link name="base"/><link name="disc"><inertial>'
    '<origin xyz="0.02 0 0"/><mass value="3"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="u" type="continuous"><parent link="base"/><child link="disc"/>'
    '<axis xyz="0 0 1"/></joint></robot>'
)


def still(time, q=None):
    """A trajectory of one joint; only times and ends of the motion count."""
    x = np.zeros((time.size, 1)) if q is None else q
    return Trajectory(time, x, x, x, x, x, x, 0.0, 1.0)


@pytest.mark.table(1)
@pytest.mark.parametrize("ratio", [0.3, 0.95, 2.5])
def test_a_rotating_unbalance_shakes_a_frame_as_in_the_textbook(ratio, robot):
    """``m e ω² / |k - M ω² + i c ω|`` is the radius of the circle of the frame's middle."""
    frame = ElasticFrame(20.0, 1.5, 8e4, 90.0)
    speed = ratio * np.sqrt(frame.stiffness / frame.mass)
    linkage = kinematics.load(robot(ROTOR))
    way, _ = revolve_crank(linkage, speed)
    found = point_partial(
        linkage, ["disc"], 0.0, motions=[way], frame=frame, weight_moment=1e-9
    )
    stiffness = frame.stiffness - frame.mass * speed**2 + 1j * frame.damping * speed
    radius = 3.0 * 0.02 * speed**2 / abs(stiffness)
    assert found.given.vibration == pytest.approx(radius, rel=1e-6)


def test_a_step_of_the_force_on_a_frame_at_rest():
    """``x = -F/k (1 - e^(-δt) (cos ωt + δ/ω sin ωt))``; the rotation is that of M m/I."""
    frame = ElasticFrame(2.0, 0.5, 300.0, 4.0)
    time = np.linspace(0.0, 2.0, 101)
    q = np.linspace(0.0, 1.0, 101)[:, None]
    wrenches = np.zeros((101, 6, 1))
    wrenches[:, 0], wrenches[:, 4] = 0.7, 5.0
    found = vibration(frame, still(time, q), wrenches)[..., 0]
    decay = frame.damping / (2 * frame.mass)
    omega = np.sqrt(frame.stiffness / frame.mass - decay**2)
    shape = 1 - np.exp(-decay * time) * (
        np.cos(omega * time) + decay / omega * np.sin(omega * time)
    )
    assert found[:, 4] == pytest.approx(-5.0 / 300.0 * shape, abs=1e-14)
    assert found[:, 0] == pytest.approx(-0.7 / 300.0 * (2.0 / 0.5) * shape, abs=1e-14)
    assert not found[:, [1, 2, 3, 5]].any()


def test_unequal_steps_and_any_drive_against_a_general_integrator():
    from scipy.integrate import solve_ivp
    from scipy.interpolate import CubicSpline

    rng = np.random.default_rng(3)
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 0.05, 40))])
    wrenches = rng.standard_normal((41, 6, 2))
    frame = ElasticFrame(1.3, 0.4, 500.0, 2.0)
    q = np.linspace(0.0, 1.0, 41)[:, None]
    found = vibration(frame, still(time, q), wrenches)
    spline = CubicSpline(time, wrenches[:, 5, 1])

    def rate(t, x):
        return x[1], (-spline(t) - frame.damping * x[1] - frame.stiffness * x[0]) / frame.mass

    other = solve_ivp(rate, (0.0, time[-1]), [0.0, 0.0], t_eval=time, rtol=1e-10, atol=1e-14)
    assert np.abs(found[:, 5, 1] - other.y[0]).max() < 1e-8 * np.abs(other.y[0]).max()


def test_a_motion_that_joins_its_start_is_repeated():
    space = design_space("slider_crank", max_order=0)
    (way,) = random_motions(space.linkage, 1, 50)
    assert is_periodic(way)
    arrays = (way.time, way.u, way.ud, way.udd, way.q, way.qd, way.qdd)
    half = Trajectory(*(x[:25] for x in arrays), way.closure, way.conditioning)
    assert not is_periodic(half)
    turn, _ = revolve_crank(space.linkage, 10.0)
    assert is_periodic(turn)


@pytest.mark.slow
def test_full_force_balance_shakes_a_soft_frame_more_than_partial_balance_does():
    """The moments that full force balance makes turn a frame that turns easily."""
    add, regions = ["crank", "coupler"], dict.fromkeys(["crank", "coupler"], "ball(0,0,0,1)")
    frame = ElasticFrame(40.0, 0.05, 4e4, 40.0)
    options = {"regions": regions, "weight_moment": 1.0}
    full = point_partial(
        design_space("slider_crank", balance="force"), add, 100.0, regions=regions
    )
    assert full.share < 1e-9
    space = design_space("slider_crank", max_order=0)
    best = point_partial(space, add, full.mass, frame=frame, **options)
    problem = build_problem(space, add, ShakingOptions(regions, weight_moment=1.0, frame=frame))
    s = balanced_coordinates(problem, full)
    figures = problem.figures([s])[0]
    assert figures.force < 1e-9 * best.given.force
    assert figures.vibration > best.given.vibration > best.shaking.vibration
    assert best.shaking.force > 1e-3 * best.given.force


def balanced_coordinates(problem, found):
    """Coordinates of added matter from the parameters that it makes."""
    parts = []
    for b, D in problem.matter.si.items():
        parts.append(np.linalg.solve(D, found.z[b] - problem.matter.given[b]))
    return np.concatenate(parts)


@pytest.mark.parametrize(
    "numbers", [(0, 1, 1, 1), (1, 1, -1, 0), (1, 1, 1, -1), (1, 1, 1, np.nan)]
)
def test_frames_that_cannot_be(numbers):
    with pytest.raises(UsageError, match="no frame has mass"):
        point_partial("slider_crank", ["crank"], 1.0, frame=ElasticFrame(*numbers))
