"""Transmissions to the ground: their links in the file, and masses by hand formulas."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.remedies.counter_rotations.transmissions import (
    LARGEST_LEVER,
    LEAST_LEVER,
    LEVERS,
    _fewest_on_ground,
    _judged,
    _TransmissionWriter,
    apply_parallelogram_transmission,
    apply_planetary_transmission,
    mass_per_length,
)
from balance.masses.remedies.request import RemedyRequest
from kinematics import ScrewJoint, from_screws
from kinematics.loading.model_gallery import as_linkage
from kinematics.model.document.element import Document
from tests.support.covering import spread

BOTH = [apply_planetary_transmission, apply_parallelogram_transmission]
RADIUS, REACH, GEAR = 0.5, 0.5, 2.0
# Of wheels along rods of 1 m.
WHEEL = 0.25


def arm(count):
    """A request for a planar arm of slender rods of 1 kg and 1 m."""
    rod = np.diag([0.0, 1.0 / 12.0, 1.0 / 12.0])
    names = ["base", *(f"L{k}" for k in range(1, count + 1))]
    joints = [
        ScrewJoint(f"q{k + 1}", names[k], names[k + 1], point=(k, 0, 0)) for k in range(count)
    ]
    bodies = {name: (1.0, (k + 0.5, 0, 0), rod) for k, name in enumerate(names[1:])}
    linkage = from_screws(joints, bodies=bodies, inputs=[joint.name for joint in joints])
    regions = {name: f"ball(0,0,0,{REACH})" for name in bodies}
    return RemedyRequest(linkage, regions=regions, gear=GEAR, radius=RADIUS)


def test_planetary_transmission_of_a_double_pendulum():
    """Two wheels turn with the second rod, one of them on the ground; each rotor takes one rod.

    The last rod has a length of 0.5 m, as far as its centre of mass is away: μ = 2 kg / 1.5 m.
    A wheel of the radius r, a quarter of a rod, is a disc of 2 μ r.
    """
    request = arm(2)
    (found,) = apply_planetary_transmission(request)
    assert found.verdict == "feasible", found
    assert mass_per_length(request) == pytest.approx(2.0 / 1.5)
    assert "wheels of 0.25 m (a radius, and a bound: smaller ones weigh less)" in found.words
    wheel = 2.0 / 1.5 * 2.0 * WHEEL
    spin = wheel * WHEEL**2 / 2.0
    m2 = 0.5 / REACH
    second = 1.0 / 3.0 + m2 * REACH**2 + 2.0 * spin  # all that turns with the second rod
    end = 1.0 + m2 + wheel  # at the second hinge
    m1 = (0.5 + end) / REACH
    first = 1.0 / 3.0 + m1 * REACH**2 + end
    rotors = (first + second) / GEAR / RADIUS**2
    assert found.added_mass == pytest.approx(m1 + m2 + 2.0 * wheel + rotors, rel=1e-8)
    # The second link turns with the first if q2 rests.
    both = (first + second) * (1.0 + GEAR)
    inertia = {"q1": both, "q2": second * (1.0 + GEAR)}
    assert found.input_inertia == pytest.approx(inertia, rel=1e-8)


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize("apply", BOTH)
def test_the_train_has_the_rotation_of_the_last_link(apply):
    """At finite poses of three rods: rotors turn -N times as far as their link, idlers once."""
    (found,) = apply(arm(3))
    assert found.verdict == "feasible" and found.residual <= 1e-9
    linkage = kinematics.load(Document("again", found.urdf), None, ["q1", "q2", "q3"])
    q = {"q1": 0.3, "q2": -0.2, "q3": 0.25}
    turned = absolute_rotations(linkage, q)
    angle = {"L1": 0.3, "L2": 0.1, "L3": 0.35}
    for name, value in angle.items():
        assert turned[name] == pytest.approx(value, abs=1e-12)
        assert turned[f"{name}_rotor"] == pytest.approx(-GEAR * value, abs=1e-12)
    carriers = [name for name in turned if "_idler" in name or "_wheel" in name]
    moving = [name for name in carriers if "sum" not in name and "bar" not in name]
    assert len(moving) >= 3
    for name in moving:
        assert turned[name] == pytest.approx(angle[name[:2]], abs=1e-12), name


def absolute_rotations(linkage, inputs):
    """Angle of each body about z at a pose, from positions of all joints along its path."""
    from kinematics.closure.joint_positions import joint_positions

    positions = joint_positions(linkage, inputs)
    angles = {-1: 0.0}
    for j, joint in enumerate(linkage.joints):
        angles[j] = angles[joint.parent] + joint.screw[2] * positions[j]
    return {body.name: angles[body.link] for body in linkage.bodies}


@pytest.mark.slow
@pytest.mark.parametrize("model", spread(("four_bar_general", "five_bar"), 2))
@pytest.mark.parametrize("apply", BOTH)
def test_exports_are_verified(model, apply):
    """Links and loops of the transmission stand in the file; Pinocchio finds it balanced."""
    found = list(apply(RemedyRequest(as_linkage(model))))[-1]
    assert found.verdict == "feasible" and "driven by" in found.words
    linkage = kinematics.load(Document(model, found.urdf))
    assert linkage.mobility == as_linkage(model).mobility and found.lost_freedoms == 0
    more = len(linkage.loops) - len(as_linkage(model).loops)
    assert more == (1 if apply is apply_parallelogram_transmission else 0)
    checked = balance.verify(linkage, trajectories=2)
    assert max(checked.force_residual, checked.moment_residual) <= 1e-9
    assert set(found.new_links) <= set(linkage.places)


@pytest.mark.parametrize("apply", BOTH)
def test_what_is_refused(apply):
    """Spatial linkages, force balance, and linkages that need no rotor."""
    (found,) = apply(RemedyRequest(as_linkage("bennett")))
    assert found.verdict == "refused" and "not parallel" in found.reason
    (found,) = apply(RemedyRequest(as_linkage("five_bar"), balance="force"))
    assert found.verdict == "refused" and "force balance" in found.reason
    (found,) = apply(RemedyRequest(as_linkage("slider_crank")))
    assert found.verdict == "refused" and "no counter-rotation" in found.reason


@pytest.mark.slow
def test_levers_of_the_least_mass_are_sought_where_the_remedy_is_named():
    """None of a grid adds less, and the words say the bound."""
    key = "parallelogram_transmission"
    request = RemedyRequest(as_linkage("four_bar_general"), only=(key,))
    best = list(apply_parallelogram_transmission(request))[-1]
    (size,) = best.details["carried_sizes"].values()
    span = np.hypot(0.1, 0.3)  # of the crank
    masses = []
    for share in (LEAST_LEVER, 0.2, 0.3, 0.4, LARGEST_LEVER):
        rotor_set = next(
            each
            for each in _fewest_on_ground(request).sets
            if set(each.joints) == {"crank", "coupler"}
        )
        write = _TransmissionWriter.parallelograms
        tried = _judged(request, key, rotor_set, write, "by bars", LEVERS, share)
        masses.append(tried.added_mass)
    assert best.added_mass <= min(masses) * (1.0 + 1e-6)
    at_bound = min(abs(size / span - bound) for bound in (LEAST_LEVER, LARGEST_LEVER)) < 1e-3
    assert ("a bound" in best.words) == at_bound
