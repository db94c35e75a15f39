"""Bearings, gears and room of remedies: by hand, and by Pinocchio from the written file."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import kinematics
from balance.masses.designs.density import STEEL
from balance.masses.remedies.as_built import K_FACTOR, built_in_file, gear_mass, input_steps
from balance.masses.remedies.counter_rotations.separate_rotors import apply_separate_rotors
from balance.motion.verification.verify_motions import PinocchioModel
from kinematics.model.document.element import Document
from tests.support.double_pendulum import REACH, pendulum
from tests.support.remedy_requests import PENDULUM, SLENDER, request_of, request_of_model, rod

GEAR, RADIUS = 2.0, 0.8
# Counterweights of both rods at the reach, and the inertia of each with all that it carries.
M2 = 0.5 / REACH
M1 = (1.5 + M2) / REACH
I2 = 1.0 / 3.0 + M2 * REACH**2
I1 = 1.0 / 3.0 + M1 * REACH**2 + (1.0 + M2) + I2


def peaks(request, units=1.0):
    """Largest rate and acceleration of the inputs along the motions of a request."""
    return (
        max(np.abs(getattr(motion, name) / units).max() for motion in request.motions)
        for name in ("ud", "udd")
    )


def test_two_rods_in_line_pull_at_their_hinges():
    """Centres at 0.5 and 1.5 m of 1 kg each: 2 Ω² along them, and 2 A across."""
    request = pendulum(1.0, 1.0)
    rate, change = peaks(request)
    built = built_in_file(request)
    assert built.bearing_load == pytest.approx(2.0 * max(rate**2, change), rel=1e-9)
    # A rod has its gyration about its centre in two directions: (1/12 + 1/12) / 2.
    assert built.width == pytest.approx(1.5 + np.sqrt(1.0 / 12.0), rel=1e-9)


@pytest.mark.slow
def test_rotors_on_a_pendulum_by_hand_and_by_pinocchio():
    """Gears take the inertia of the rods; rings as large as rotors stand at both hinges."""
    request = pendulum(GEAR, RADIUS)
    applied = next(apply_separate_rotors(request))
    rate, change = peaks(request)
    built = applied.built
    gears = sum(gear_mass(inertia * change, GEAR) for inertia in (I1, I2))
    assert built.gear_mass == pytest.approx(gears, rel=1e-6)
    assert applied.added_mass_with_gears == applied.added_mass + built.gear_mass
    assert built.width == pytest.approx(1.0 + 2.0 * RADIUS, rel=1e-6)
    assert built.width_ratio == pytest.approx(built.width / (1.5 + np.sqrt(1.0 / 12.0)))
    linkage = kinematics.load(Document("rotors", applied.urdf))
    largest = largest_force(linkage, rate, change)
    assert built.bearing_load == pytest.approx(largest, rel=1e-9)
    ratio = largest / (2.0 * max(rate**2, change))
    assert built.bearing_ratio == pytest.approx(ratio, rel=1e-9)
    assert REACH < 1.0 < built.bearing_ratio


def largest_force(linkage, rate, change):
    """Largest force of a joint at the reference pose, by Pinocchio, one input after another."""
    robot = PinocchioModel(linkage, np.array([body.inertia for body in linkage.bodies]))
    data, largest, names = robot.model.createData(), 0.0, [j.name for j in linkage.joints]
    for name in linkage.inputs:
        way = np.zeros(len(names))
        way[names.index(name)] = 1.0
        for mimic in linkage.mimics:
            way[mimic.joint] = mimic.ratio * way[mimic.source]
        for qd, qdd in ((rate * way, 0.0 * way), (0.0 * way, change * way)):
            pin.rnea(robot.model, data, pin.neutral(robot.model), qd, qdd)
            forces = [np.linalg.norm(force.linear) for force in data.f.tolist()[1:]]
            largest = max(largest, *forces)
    return largest


@pytest.mark.parametrize(("ratio", "diameter"), [(1.0, 0.03), (3.0, 0.02), (-0.25, 0.05)])
def test_gears_are_discs_of_the_surface_durability(ratio, diameter):
    """With ``W / (F d) (m + 1) / m = K`` a pinion of any diameter d gets its face width F."""
    torque = 7.0
    m = max(abs(ratio), 1.0 / abs(ratio))
    tangential = 2.0 * torque * min(abs(ratio), 1.0) / diameter
    width = tangential / diameter * (m + 1.0) / m / K_FACTOR
    discs = (np.pi / 4.0 * d**2 * width * STEEL for d in (diameter, m * diameter))
    assert gear_mass(torque, ratio) == pytest.approx(sum(discs), rel=1e-12)


def test_inputs_that_are_related_move_together():
    request = request_of_model("two rods")
    first, second = request.linkage.inputs
    steps = input_steps(request, request.linkage, [f"{second}=-2*{first}"])
    assert steps.ud.shape == (2, 2) and not steps.ud[1].any() and not steps.udd[0].any()
    np.testing.assert_allclose(steps.ud[0, 1], -2.0 * steps.ud[0, 0])
    rate, _ = peaks(request)
    assert np.abs(steps.ud).max() == pytest.approx(rate)


def test_a_sliding_input_moves_a_length_a_second():
    """Rates are those of characteristic lengths, so that files in other units are alike."""
    slider = rod("b", "a", "1 0 0", 1.0, "0.5 0 0", SLENDER, kind="prismatic", axis="1 0 0")
    request = request_of(PENDULUM[0], slider)
    steps = input_steps(request, request.linkage)
    rate, change = peaks(request, np.array([1.0, request.space.length]))
    np.testing.assert_allclose(steps.ud[:2], np.diag([rate, rate * request.space.length]))
    np.testing.assert_allclose(steps.udd[2:], np.diag([change, change * request.space.length]))
