"""Bases that float or stand on springs: conserved quantities, closed forms, printed figures.

[J] J. J. de Jong, PhD thesis, University of Twente, section 2.4, figures 2.8 and 2.9: a slider
pantograph of total inertia ``1 + 2 q²`` on a base.
"""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.bodies import parameters
from balance.motion import FloatingBase, simulate_floating_base
from balance.motion.verification.given_motions import rest_to_rest
from balance.motion.verification.input_paths import SinePath, SplinePath, SteadyPath
from kinematics import ScrewJoint, from_screws
from kinematics.errors import LinkageError, MotionError, PoseError, UsageError
from tests.support.covering import ALL_CASES

PANTOGRAPH = "slider_pantograph"
# One kg m² about the centre with the slider at 0, as in [J]; any mass will do.
BASE = FloatingBase(mass=10.0, inertia=1.0)
SPRING = FloatingBase(mass=10.0, inertia=1.0, turning_stiffness=1e4)
OFFSET = FloatingBase(3.0, (0.4, 0.5, 0.6), (0.2, -0.1, 0.3))
BALANCED = {
    "four_bar_kite_balanced": None,
    "four_bar_antiparallelogram_balanced": None,
    "double_pendulum_counter_rotary": None,
    "double_pendulum_duplicates": None,
    PANTOGRAPH: None,
    "three_rsr": "u2=u3",
}
DURATION = 10.0 if ALL_CASES else 0.5


def closing():
    """The pantograph from q = 2 m to 1.5 m and back, as in [J]."""
    return rest_to_rest(kinematics.load(PANTOGRAPH), [[0.0], [-0.5], [0.0]], 0.5)


def crossings(time, value, rate):
    """Times at which smooth samples go through zero upwards, by cubics between two of them."""
    found = []
    for k in np.flatnonzero((value[:-1] < 0.0) & (value[1:] >= 0.0)):
        h = time[k + 1] - time[k]
        a, b, c, d = value[k], value[k + 1], h * rate[k], h * rate[k + 1]
        roots = np.roots([2 * a - 2 * b + c + d, -3 * a + 3 * b - 2 * c - d, c, a])
        (inside,) = (r.real for r in roots if abs(r.imag) < 1e-9 and 0.0 <= r.real <= 1.0)
        found.append(time[k] + h * inside)
    return np.array(found)


@pytest.mark.slow
def test_pantograph_at_rest_stays_at_rest():
    """[J] Fig. 2.9, first case."""
    found = simulate_floating_base(PANTOGRAPH, BASE, motions=closing())
    assert max(found.rotation, found.displacement) < 1e-12
    assert found.verdict == "the base stays at rest" and found.undisturbed


@pytest.mark.slow
def test_pantograph_turns_faster_when_it_closes():
    """[J] Fig. 2.9, second case: 10 rad/s become 10 (1 + 2·2²) / (1 + 2·1.5²) = 16.3636."""
    found = simulate_floating_base(PANTOGRAPH, BASE, motions=closing(), initial={"wz": 10.0})
    q = 2.0 + found.samples.u[:, 0]
    assert np.allclose(found.samples.turning[:, 2], 90.0 / (1.0 + 2.0 * q**2), rtol=1e-10)
    assert found.samples.turning[:, 2].max() == pytest.approx(16.3636, abs=1e-4)
    assert found.samples.turning[-1, 2] == pytest.approx(10.0, rel=1e-10)
    assert found.verdict == "the inputs disturb the base" and not found.undisturbed


@pytest.mark.slow
def test_pantograph_on_a_spring():
    """[J] prints 5.4 Hz for k = 1e4 N m/rad at q = 2 m; it is √(k/9) / 2π = 5.305 Hz."""
    still = SteadyPath(np.zeros(1), np.zeros(1))
    found = simulate_floating_base(
        PANTOGRAPH, SPRING, motions=still, initial={"wz": 1.0}, duration=0.7
    )
    formula = np.sqrt(1e4 / 9.0) / (2.0 * np.pi)
    assert found.frequencies == pytest.approx((formula,), rel=1e-12)
    assert round(formula, 3) == 5.305
    of = found.samples
    times = crossings(found.time, of.rotation[:, 2], of.turning[:, 2])
    assert (times.size - 1) / np.ptp(times) == pytest.approx(formula, rel=1e-4)
    assert of.rotation[:, 2].max() == pytest.approx(1.0 / np.sqrt(1e4 / 9.0), rel=1e-2)


@pytest.mark.slow
def test_the_pantograph_drives_the_vibration_of_its_base():
    """[J] Fig. 2.9, third case: 0.3 m at twice the natural frequency, inwards first."""
    frequency = np.sqrt(1e4 / 9.0) / (2.0 * np.pi)
    peaks = []
    for phase in (np.pi, 0.0):
        drive = SinePath(np.array([[0.3]]), np.array([[phase]]), 0.5 / frequency, np.eye(1))
        found = simulate_floating_base(
            PANTOGRAPH, SPRING, motions=drive, initial={"wz": 1.0}, duration=0.8
        )
        turned, late = np.abs(found.samples.rotation[:, 2]), found.time > 0.6
        peaks.append(turned[late].max() * np.sqrt(1e4 / 9.0))
        assert found.agreed and not found.undisturbed
    assert 5.0 < peaks[0] < 7.0 and peaks[1] < 0.5


@pytest.mark.slow
def test_frequencies_of_an_unbalanced_linkage():
    """Held by a rotational spring a base turns about the centre of all masses."""
    linkage = kinematics.load("four_bar_general")
    base = FloatingBase(3.0, 0.4, (0.2, -0.1, 0.0), 300.0)
    z = np.array([body.inertia for body in linkage.bodies]).sum(axis=0) + base.parameters
    inertia = z[6] - (z[1] ** 2 + z[2] ** 2) / z[0]
    formula = np.sqrt(300.0 / inertia) / (2.0 * np.pi)
    still = SteadyPath(np.zeros(1), np.zeros(1))
    # The centre of all masses stays at rest: v + ω × r = 0 with r from the base to it.
    r = z[1:3] / z[0] - np.array(base.com[:2])
    initial = {"wz": 0.2, "vx": 0.2 * r[1], "vy": -0.2 * r[0]}
    found = simulate_floating_base(linkage, base, motions=still, initial=initial, duration=1.0)
    assert found.frequencies == pytest.approx((formula,), rel=1e-12)
    times = crossings(found.time, found.samples.rotation[:, 2], found.samples.turning[:, 2])
    assert (times.size - 1) / np.ptp(times) == pytest.approx(formula, rel=1e-4)


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize("model", BALANCED)
def test_balanced_linkages_leave_the_base_at_rest(model):
    found = simulate_floating_base(model, OFFSET, motion=BALANCED[model], duration=DURATION)
    assert max(found.rotation, found.displacement) < 1e-10
    assert found.undisturbed and found.agreed and not found.remarks


@pytest.mark.slow
def test_decoupled_is_more_than_balanced():
    """On a base that turns, a kite disturbs nothing; the pantograph does, though balanced."""
    initial = {"wz": 3.0, "vx": 1.0}
    for model, verdict in (("four_bar_kite_balanced", True), (PANTOGRAPH, False)):
        found = simulate_floating_base(model, OFFSET, initial=initial, duration=DURATION)
        assert found.undisturbed == verdict and found.agreed


@pytest.mark.slow
@pytest.mark.parametrize("model", ["four_bar_general", "three_rsr"][: 2 if ALL_CASES else 1])
def test_energy_and_momentum_over_ten_seconds(model):
    """On springs and in space; the other eight in ``benchmarks``."""
    base = FloatingBase(3.0, (0.4, 0.5, 0.6), (0.2, -0.1, 0.3), 20.0, 200.0)
    found = simulate_floating_base(model, base, spatial=True)
    assert found.duration == 10.0 and found.displacement > 1e-4
    assert found.energy_drift < 1e-9 and found.momentum_drift < 1e-9


@pytest.mark.slow
def test_a_wheel_on_a_base_has_a_closed_form():
    """τ on a wheel of inertia J: the base turns by -τ t² / 2I, the wheel by τ t² / 2J + … ."""
    linkage = from_screws([ScrewJoint("wheel", "base", "disc")], inputs=["wheel"])
    z = parameters(2.0, [0.0, 0.0, 0.0], np.diag([0.1, 0.1, 0.2]))
    base = FloatingBase(1.0, 0.5)
    found = simulate_floating_base(
        linkage,
        base,
        z,
        torques={"wheel": 0.3},
        duration=1.5,
        spatial=True,
        initial={"wheel": 2.0},
    )
    t = found.time
    # The base rests at the start, so the wheel's momentum is 0.2 · 2.
    assert np.allclose(found.samples.rotation[:, 2], -0.3 * t**2 / (2 * 0.5), atol=1e-12)
    relative = 2.0 * t + 0.5 * t**2 * (0.3 / 0.2 + 0.3 / 0.5)
    assert np.allclose(found.samples.u[:, 0], relative, atol=1e-12)
    assert np.allclose(found.samples.work, 0.3 * relative, atol=1e-12)


@pytest.mark.slow
def test_a_base_on_a_spring_swings_as_a_pendulum_of_mass():
    """A translational spring alone: x = v sin(ω t) / ω with ω² = k / m of the whole."""
    linkage = kinematics.load(PANTOGRAPH)
    base = FloatingBase(10.0, 1.0, stiffness=500.0)
    still = SteadyPath(np.zeros(1), np.zeros(1))
    found = simulate_floating_base(
        linkage, base, motions=still, initial={"vx": 0.1}, duration=1.0
    )
    omega = np.sqrt(500.0 / 12.0)
    assert found.frequencies == pytest.approx((omega / 2 / np.pi,) * 2, rel=1e-9)
    expected = 0.1 * np.sin(omega * found.time) / omega
    assert np.allclose(found.samples.displacement[:, 0], expected, atol=1e-12)


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize("samples", [21, 51, 101])
def test_a_table_of_any_number_of_samples(samples):
    """Pieces of a spline that end a hair after a step: the base returns with the inputs."""
    time = np.linspace(0.0, 1.0, samples)
    path = SplinePath.through(time, 0.5 * (1.0 - np.cos(2.0 * np.pi * time))[:, None])
    found = simulate_floating_base("four_bar_general", BASE, motions=path)
    assert found.verdict == "the base moves" and found.rotation > 1e-3
    assert found.momentum_drift < 1e-9


@pytest.mark.slow
def test_drift_is_noticed(monkeypatch):
    """A wrong force in the equations breaks the balance of energy."""
    monkeypatch.setattr(
        "balance.motion.floating_base.dynamics.turn_momenta", lambda t, h: np.zeros(h.shape)
    )
    found = simulate_floating_base("four_bar_general", BASE, initial={"wz": 3.0}, duration=0.5)
    assert not found.agreed and found.verdict == "no verdict"
    assert found.to_dict()["undisturbed"] is None and "no verdict" in found.remarks[-1]


@pytest.mark.table
@pytest.mark.parametrize(
    ("error", "match", "options"),
    [
        (UsageError, "mass and moments", {"base": FloatingBase(0.0, 1.0)}),
        (UsageError, "1 \\+ 1 < 3", {"base": FloatingBase(1.0, (1.0, 1.0, 3.0))}),
        (UsageError, "spring needs", {"base": FloatingBase(1.0, 1.0, stiffness=-1.0)}),
        (UsageError, "moves in its plane", {"initial": {"wx": 1.0}}),
        (UsageError, "finite numbers", {"initial": {"wz": np.nan}}),
        (UsageError, "finite numbers", {"torques": {"u1": np.inf}}),
        (UsageError, "is prescribed", {"initial": {"u1": 1.0}}),
        (UsageError, "either", {"torques": {}, "motions": SteadyPath(np.zeros(1), np.ones(1))}),
        (UsageError, "no motion takes", {"duration": -1.0}),
        (PoseError, "joint x is not an input", {"torques": {"x": 1.0}}),
        (PoseError, "joint x is not an input", {"initial": {"x": 1.0}}),
        (PoseError, "closed|singular", {"motions": SteadyPath(np.zeros(1), np.full(1, 9.0))}),
        (PoseError, "vibrates 3408", {"base": FloatingBase(1.0, 1.0, stiffness=1e15)}),
        (PoseError, "too many steps", {"base": FloatingBase(1.0, 1.0, stiffness=200.0)}),
        (MotionError, "inputs", {"motion": "x=0"}),
    ],
)
def test_bad_requests_are_refused(error, match, options, monkeypatch):
    monkeypatch.setattr("balance.motion.floating_base.simulate.MAX_EVALUATIONS", 3000)
    base = options.pop("base", BASE)
    with pytest.raises(error, match=match) as caught:
        simulate_floating_base("four_bar_general", base, **options)
    assert "\n" not in str(caught.value)


def test_torques_on_nothing_are_refused():
    linkage = from_screws(
        [ScrewJoint("a", "base", "arm"), ScrewJoint("b", "arm", "hand", point=(1, 0, 0))]
    )
    point = np.vstack([parameters(1.0, [0.5, 0, 0], np.eye(3)), np.zeros(10)])
    with pytest.raises(LinkageError, match="do not determine its motion"):
        simulate_floating_base(linkage, BASE, point, torques={})
    with pytest.raises(LinkageError, match="no moving link has a mass"):
        simulate_floating_base(linkage, BASE, np.zeros(20))
