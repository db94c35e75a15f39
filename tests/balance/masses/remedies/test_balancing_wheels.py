"""Wheels: closed formulas, momentum by Pinocchio, rolling pitch curves, energy, refusals."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, solve_ivp
from scipy.interpolate import make_interp_spline

import balance
import kinematics
from balance.masses.remedies.balancers.balancing_wheels import (
    apply_active_wheel,
    apply_passive_wheel,
)
from balance.masses.remedies.balancers.on_base import balance_force
from balance.masses.remedies.balancers.varying_ratio import VaryingRatio, integrate
from balance.masses.remedies.request import RemedyRequest
from balance.motion.verification.trajectory import drive, random_motions
from kinematics.errors import PoseError
from kinematics.model.document.element import Document
from tests.support.remedy_files import momentum_by_pinocchio, table
from tests.support.remedy_requests import (
    BALANCED_FORCE,
    PENDULUM,
    SLENDER,
    request_of,
    rod,
)

ROD = PENDULUM[0]


def request(model, inputs=None, **options) -> RemedyRequest:
    return RemedyRequest(kinematics.load(model, inputs=inputs), **options)


@pytest.mark.slow
@pytest.mark.parametrize("gear", [1.0, 2.0, 0.5])
def test_a_rod_gets_a_wheel_of_constant_ratio(gear):
    """A rod of 1/3 kg m² and a counterweight of 1 kg at 0.5 m: J N = 1/3 + 1/4."""
    own = 1.0 / 3.0 + 0.25
    asked = request_of(ROD, gear=gear, radius=0.2, regions={"a": "ball(0,0,0,0.5)"})
    (found,) = apply_passive_wheel(asked)
    wheel = found.details["wheel"]
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert wheel["inertia"] == pytest.approx(own / gear, rel=1e-8)
    assert found.added_mass == pytest.approx(1.0 + own / gear / 0.04, rel=1e-8)
    assert found.input_inertia["j_a"] == pytest.approx(own * (1.0 + gear), rel=1e-8)
    assert found.inertia_ratio == pytest.approx(3.0 * own * (1.0 + gear), rel=1e-8)
    ratio = table(found.files["ratio.csv"])
    np.testing.assert_allclose(ratio["ratio"], -gear, rtol=1e-8)
    np.testing.assert_allclose(ratio["angle"], -gear * ratio["u"], atol=1e-7)
    curves = found.details["pitch_curves"]
    np.testing.assert_allclose(curves["r1"], 0.4 * gear / (1.0 + gear), rtol=1e-8)
    assert curves["closed"] == (gear <= 1.0) and curves["distance"] == 0.4
    assert "circular gears" in found.details["drive"] and "non-" not in found.details["drive"]


@pytest.mark.slow
def test_the_ratio_is_pinocchios_momentum_and_the_angle_its_integral():
    """A general four-bar whose ratio changes its sign: a cam, no gears."""
    (found,) = apply_passive_wheel(request("four_bar_general"))
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert found.details["pitch_curves"] is None and "a cam" in found.details["drive"]
    assert set(found.files) == {"motion.csv", "ratio.csv"} and found.details["full_turn"]
    ratio = table(found.files["ratio.csv"])
    whole = kinematics.load(
        Document("whole.urdf", found.urdf), inputs=["u1", "balancing_wheel_joint"]
    )
    assert whole.mobility == 2
    u = ratio["u"]
    still = np.stack([u, 0.0 * u], axis=1)
    rates = np.tile([1.0, 0.0], (u.size, 1))
    h = momentum_by_pinocchio(whole, drive(whole, u, still, rates, 0.0 * rates))
    J = found.details["wheel"]["inertia"]
    np.testing.assert_allclose(ratio["ratio"], -h[:, 2] / J, atol=1e-10)
    assert np.abs(h[:, 3:]).max() <= 1e-10
    slope = make_interp_spline(u, ratio["ratio"], k=5)(u, 1)
    np.testing.assert_allclose(ratio["slope"], slope, atol=1e-6)
    np.testing.assert_allclose(
        ratio["angle"], cumulative_simpson(ratio["ratio"], x=u, initial=0.0), atol=1e-7
    )
    assert np.abs(ratio["ratio"][:-1]).mean() == pytest.approx(1.0, abs=1e-5)
    # With the wheel at this ratio nothing is left, at any speed: a second motion.
    wheel = make_interp_spline(u, ratio["angle"], k=5)
    t = np.linspace(0.0, 1.0, 400)
    angle, speed, change = 3.0 + 2.0 * np.sin(3 * t), 6.0 * np.cos(3 * t), -18.0 * np.sin(3 * t)
    i, slope = wheel(angle, 1), wheel(angle, 2)
    columns = (
        (angle, wheel(angle)),
        (speed, i * speed),
        (change, i * change + slope * speed**2),
    )
    motion = drive(whole, t, *(np.stack(pair, axis=1) for pair in columns))
    checked = balance.verify(whole, motions=[motion])
    assert max(checked.force_residual, checked.moment_residual) <= 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("gear", "closed"), [(1.0, True), (0.5, True), (0.75, False)])
def test_pitch_curves_roll_on_each_other(gear, closed):
    """They touch on the line of centres, at one tangent, have equal lengths, and give φ."""
    (found,) = apply_passive_wheel(request("slider_crank", gear=gear))
    assert found.verdict == "feasible" and found.residual <= 1e-9
    curves, ratio = (table(found.files[name]) for name in ("pitch_curves.csv", "ratio.csv"))
    data = found.details["pitch_curves"]
    assert data["closed"] is closed
    assert ratio["angle"][-1] == pytest.approx(-2.0 * np.pi * gear, rel=1e-6)
    c, u, turned = data["distance"], curves["u"], curves["turned"]
    np.testing.assert_allclose(curves["r1"] + curves["r2"], c, rtol=1e-12)

    def at(x, y, angle):
        """The points of a curve in the base, its gear turned by an angle."""
        return np.exp(1j * angle) * (x + 1j * y)

    first, second = at(curves["x1"], curves["y1"], u), at(curves["x2"], curves["y2"], turned)
    np.testing.assert_allclose(first, curves["r1"] + 0j, atol=1e-12)
    np.testing.assert_allclose(second + c, curves["r1"] + 0j, atol=1e-12)
    steps = []
    for x, y, angle in (("x1", "y1", u), ("x2", "y2", turned)):
        dx, dy = (make_interp_spline(u, curves[name], k=5)(u, 1) for name in (x, y))
        steps.append(at(dx, dy, angle))
    np.testing.assert_allclose(*steps, atol=1e-7 * c)
    lengths = [np.trapezoid(np.abs(step), u) for step in steps]
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-8)
    assert data["rolled"][0] == pytest.approx(data["rolled"][1], rel=1e-6)
    radius = make_interp_spline(u, curves["r1"], k=5)
    rolled = solve_ivp(
        lambda x, _: -radius(x) / (c - radius(x)), (0, u[-1]), [0.0], rtol=1e-10, atol=1e-12
    )
    assert rolled.y[0, -1] == pytest.approx(ratio["angle"][-1], rel=1e-7)


@pytest.mark.slow
def test_a_crank_that_cannot_turn_gets_a_table_over_its_range():
    """Its ends are a tenth before the dead centres."""
    (found,) = apply_passive_wheel(request("four_bar_general", ["q4"]))
    assert found.verdict == "feasible" and found.residual <= 1e-9, found.reason
    assert not found.details["full_turn"]
    linkage = kinematics.load("four_bar_general", inputs=["q4"])
    time = np.linspace(0.0, 1.0, 50)
    for end in found.details["range"]:
        for share, passes in ((1.0, True), (1.0 / 0.9 + 0.02, False)):
            u = (share * end * time)[:, None]
            try:
                drive(linkage, time, u, 0 * u + share * end, 0 * u)
                assert passes
            except PoseError:
                assert not passes


@pytest.mark.slow
def test_a_sliding_crank_stops_before_a_singular_pose():
    """The pins of this slider-crank meet 0.6 m from its pose, where branches do."""
    (found,) = apply_passive_wheel(request("slider_crank", ["q4"]))
    assert found.verdict == "feasible" and found.residual <= 1e-9, found.reason
    low, high = found.details["range"]
    assert -0.6 < low < -0.3 and 0.3 < high < 0.4 and found.details["pitch_curves"] is None
    assert "does not turn on the base" in found.details["drive"]


@pytest.mark.slow
def test_a_turn_through_a_singular_pose_is_verified_beside_it():
    (found,) = apply_passive_wheel(request("four_bar_kite"))
    assert found.verdict == "feasible" and found.residual <= 1e-9, found.reason
    assert found.details["singular"] and found.details["full_turn"]


@pytest.mark.slow
def test_a_relation_leaves_one_freedom():
    linkage = kinematics.load("five_bar")
    first, second = linkage.inputs
    (found,) = apply_passive_wheel(RemedyRequest(linkage, (f"{first}={second}",)))
    assert found.verdict == "feasible" and found.residual <= 1e-9, found.reason
    (found,) = apply_passive_wheel(RemedyRequest(linkage))
    assert found.verdict == "refused" and "2 degrees of freedom" in found.reason


@pytest.mark.slow
@pytest.mark.parametrize("model", ["four_bar_general", "five_bar"])
def test_a_motor_works_what_the_wheel_stores(model):
    """Torque -ḣ and speed -h/J by Pinocchio's momentum; power is the rate of the energy."""
    asked = request(model)
    (found,) = apply_active_wheel(asked)
    assert found.verdict == "feasible" and found.residual <= 1e-9
    (wheel,), (peaks,) = found.details["wheels"], found.details["peaks"]
    J, motion = wheel["inertia"], table(found.files["drive.csv"])
    t, name = motion["time"], wheel["link"]
    speed, torque, power = (motion[f"{name} {x}"] for x in ("speed", "torque", "power"))
    base = balance_force(asked)
    along = list(random_motions(base.linkage, 5, seed=3))[found.details["worst"] - 1]
    h = momentum_by_pinocchio(base.linkage, along)[:, 2]
    np.testing.assert_allclose(J * speed, -h, atol=1e-9 * np.abs(h).max())
    rate = make_interp_spline(t, h, k=5)(t, 1)
    inner = slice(5, -5)
    size = np.abs(torque).max()
    np.testing.assert_allclose(torque[inner], -rate[inner], atol=1e-3 * size)
    energy = make_interp_spline(t, 0.5 * J * speed**2, k=5)(t, 1)
    np.testing.assert_allclose(power[inner], energy[inner], atol=1e-3 * np.abs(power).max())
    angle = cumulative_simpson(speed, x=t, initial=0.0)
    np.testing.assert_allclose(motion[f"{name} angle"], angle, atol=1e-3)
    assert peaks["power"] == pytest.approx(np.abs(power).max(), rel=1e-12)
    assert peaks["torque"] >= np.abs(torque).max() * (1 - 1e-12)
    # The wheel of the mean speed of the fastest input.
    alls = list(random_motions(base.linkage, 5, seed=3))
    spins = [np.abs(momentum_by_pinocchio(base.linkage, one)[:, 2]).mean() / J for one in alls]
    paces = [np.abs(one.ud).max(axis=1).mean() for one in alls]
    assert np.mean(spins) == pytest.approx(np.mean(paces), rel=1e-9)


@pytest.mark.slow
def test_a_spatial_linkage_gets_three_wheels():
    (found,) = apply_active_wheel(request("bennett"))
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert len(found.new_links) == len(found.new_joints) == len(found.details["wheels"]) == 3
    mass = sum(wheel["mass"] for wheel in found.details["wheels"])
    said = re.match(r"3 wheels about perpendicular axes, ([\d.]+) kg together, on", found.words)
    assert float(said[1]) == pytest.approx(mass, rel=1e-3)
    weights = balance_force(request("bennett")).added
    assert found.added_mass == pytest.approx(mass + weights, rel=1e-9)
    alone = kinematics.load(
        Document("alone.urdf", found.urdf), inputs=["u1", *found.new_joints]
    )
    assert alone.mobility == 4
    # Standing wheels take nothing: the file alone shakes.
    checked = balance.verify(alone, motion=[f"{joint}=0" for joint in found.new_joints])
    assert checked.force_residual <= 1e-9 < checked.moment_residual


@pytest.mark.slow
def test_centres_in_different_planes_need_wheels_across_the_plane():
    """A rod at a height: its counterweight is not, so that a moment turns with it."""
    high = rod("a", "base", "0 0 0", 1.0, "0.5 0 0.1", SLENDER)
    (passive,) = apply_passive_wheel(request_of(high))
    assert passive.verdict == "undecided" and "different planes" in passive.reason
    (active,) = apply_active_wheel(request_of(high))
    assert active.verdict == "feasible" and active.residual <= 1e-9
    assert len(active.new_links) == 3


@pytest.mark.slow
def test_refusals_say_why():
    for apply in (apply_passive_wheel, apply_active_wheel):
        (found,) = apply(request("four_bar_general", balance="force"))
        assert found.verdict == "refused" and "only the force" in found.reason
        (found,) = apply(request("four_bar_kite_balanced"))
        assert found.verdict == "refused" and "no moment is left" in found.reason
        tight = {"a": "ball(0.5,0,0,0.1)"}
        (found,) = apply(request_of(ROD, named_links=("a",), regions=tight))
        assert found.verdict == "infeasible" and "takes no force" in found.reason
        assert found.proof["check"] and found.urdf is None
    (found,) = apply_passive_wheel(request("bennett"))
    assert found.verdict == "refused" and "spatial" in found.reason
    (found,) = apply_passive_wheel(request_of(*BALANCED_FORCE))
    assert found.verdict == "refused" and "2 degrees" in found.reason


def test_integrals_of_cubic_functions_are_exact():
    x = np.array([0.0, 0.3, 1.0, 1.1])
    found = integrate(x, x**3 - x, 3 * x**2 - 1)
    np.testing.assert_allclose(found, x**4 / 4 - x**2 / 2, atol=1e-15)


def test_a_positive_ratio_is_reversed_by_equal_wheels():
    u = np.linspace(0.0, 2.0 * np.pi, 41)
    ratio = VaryingRatio(
        "c", True, 1.0, u, 1.0 + 0.5 * np.cos(u), -0.5 * np.sin(u), u + 0.5 * np.sin(u)
    )
    curves = ratio.pitch_curves(1.0)
    assert curves.reversed and curves.closed and curves.turned[-1] < 0.0
    changing = VaryingRatio("c", True, 1.0, u, np.cos(u), -np.sin(u), np.sin(u))
    assert changing.pitch_curves(1.0) is None
