"""Rotors on a double pendulum against formulas by hand, and what the files of rotors hold.

Two slender rods of 1 kg and 1 m, hinged at their ends, with counterweights at most a from the
hinges, and rotors of radius ρ that turn N times. Force balance about the second hinge and then
about the first:

    m2 a = 1/2,    m1 a = 1/2 + (1 + m2) · 1

With the inertia of the second rod about its hinge, and of all masses about the first where the
second arm with its counterweight counts as a point (of mass 1 + m2) and as an inertia I2,

    I2 = 1/3 + m2 a²,    I1 = 1/3 + m1 a² + (1 + m2) + I2,

the angular momentum is I1 q̇1 + I2 q̇2 (balanced arms have no other terms).
"""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.masses.remedies.counter_rotations.counter_rotary_masses import (
    apply_counter_rotary_masses,
    lightest_places,
)
from balance.masses.remedies.counter_rotations.separate_rotors import apply_separate_rotors
from balance.masses.remedies.request import RemedyRequest
from kinematics import ScrewJoint, from_screws
from kinematics.loading.model_gallery import as_linkage
from kinematics.model.document.element import Document
from tests.support.double_pendulum import REACH, pendulum

M2 = 0.5 / REACH
M1 = (0.5 + 1.0 + M2) / REACH
I2 = 1.0 / 3.0 + M2 * REACH**2
I1 = 1.0 / 3.0 + M1 * REACH**2 + (1.0 + M2) + I2


@pytest.mark.table(1)
@pytest.mark.parametrize("gear", [1.0, 2.0])
def test_separate_rotors_on_the_ground(gear):
    """Rotors with N J = I1 and I2 add J / ρ² each; an input turns itself and its rotor."""
    radius = 0.8
    found = next(apply_separate_rotors(pendulum(gear, radius)))
    assert found.verdict == "feasible", found
    mass = M1 + M2 + (I1 + I2) / gear / radius**2
    assert found.added_mass == pytest.approx(mass, rel=1e-8)
    inertia = {"q1": I1 * (1.0 + gear), "q2": I2 * (1.0 + gear)}
    assert found.input_inertia == pytest.approx(inertia, rel=1e-8)
    before = (1.0 / 3.0 + 1.0 / 3.0 + 1.0 * (1.0 + 2 * 0.5)) + 1.0 / 3.0
    ratio = sum(inertia.values()) / before
    assert found.inertia_ratio == pytest.approx(ratio, rel=1e-8)


@pytest.mark.slow
def test_separate_rotors_on_the_links():
    """The rotor of the second joint rides on the end of the first link."""
    gear, radius = 2.0, 0.8
    found = list(apply_separate_rotors(pendulum(gear, radius)))[1]
    assert "link before" in found.words
    J2 = I2 / gear
    rider = J2 / radius**2
    m1 = M1 + rider / REACH
    carried = I1 + rider + rider / REACH * REACH**2 + J2
    mass = m1 + M2 + rider + carried / gear / radius**2
    assert found.added_mass == pytest.approx(mass, rel=1e-8)
    inertia = {"q1": carried * (1.0 + gear), "q2": I2 * (1.0 + gear)}
    assert found.input_inertia == pytest.approx(inertia, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("gear", [1.0, 2.0])
def test_counter_rotary_masses(gear):
    """The counterweights themselves turn: no mass beyond force balance."""
    found = next(apply_counter_rotary_masses(pendulum(gear, 1.0)))
    assert found.verdict == "feasible", found
    assert found.added_mass == pytest.approx(M1 + M2, rel=1e-8)
    # A rotor turns with the link before its joint, whose inertia it adds to.
    J2 = I2 / gear
    inertia = {"q1": (I1 + J2) * (1.0 + gear), "q2": I2 * (1.0 + gear)}
    assert found.input_inertia == pytest.approx(inertia, rel=1e-8)
    assert found.details["levers"] == pytest.approx({"upper": REACH, "lower": REACH})


def least_turning_masses(gear, radius):
    """Masses of the lightest turning counterweights, from the tip to the base.

    A counterweight m with the first moment a turns with the inertia ``J = m ρ²``, so that
    ``I + a² / m = N m ρ²``, at most `REACH` from the joint. The rotor of the second joint turns
    with the first arm besides, whose inertia it adds to.
    """

    def mass(a, inertia):
        square = gear * radius**2
        root = np.sqrt(inertia**2 + 4.0 * square * a**2)
        return max((inertia + root) / (2.0 * square), a / REACH)

    m2 = mass(0.5, 1.0 / 3.0)
    second = 1.0 / 3.0 + 0.25 / m2
    a1 = 0.5 + 1.0 + m2
    m1 = mass(a1, 1.0 / 3.0 + 1.0 + m2 + second + second / gear)
    return m1, m2, a1 / m1, 0.5 / m2


@pytest.mark.table(3)
@pytest.mark.parametrize(
    ("gear", "radius"), [(1.0, 1.0), (1.0, 0.6), (1.0, 0.3), (4.0, 0.15), (2.5, 0.4)]
)
def test_places_of_the_lightest_turning_counterweights(gear, radius):
    """Each link has a lever of its own, and no places need less mass."""
    m1, m2, *levers = least_turning_masses(gear, radius)
    lightest = lightest_places(pendulum(gear, radius), ["q1", "q2"])
    assert lightest.mass == pytest.approx(m1 + m2, rel=1e-6)
    centres = np.array([lightest.centres["upper"], lightest.centres["lower"]])
    np.testing.assert_allclose(centres[:, 0], -np.array(levers), rtol=1e-3)
    np.testing.assert_allclose(centres[:, 1:], 0.0, atol=1e-6)


def test_a_small_counter_rotary_mass_turns_nearer_to_its_joint():
    """The file is balanced, and as heavy as the closed form says, within a thousandth."""
    request = pendulum(1.0, 0.6)
    found = next(apply_counter_rotary_masses(request))
    m1, m2, *levers = least_turning_masses(1.0, 0.6)
    assert found.verdict == "feasible" and found.residual <= 1e-9
    assert m1 + m2 <= found.added_mass <= 1.001 * (m1 + m2)
    assert list(found.details["levers"].values()) == pytest.approx(levers, rel=1e-3)
    # Separate rotors of this radius on the ground are heavier, by the closed forms above.
    assert found.added_mass < M1 + M2 + (I1 + I2) / 0.6**2


def test_rotors_by_default_know_of_the_tip_of_an_arm():
    """The joints are 1 m apart, and the last rod is as long; a loop has no such end."""
    assert pendulum(1.0, None).rotor_radius == pytest.approx(0.25, rel=1e-12)
    loop = RemedyRequest(as_linkage("four_bar_general"))
    assert loop.rotor_radius == pytest.approx(0.25 * loop.space.length, rel=1e-12)


def test_exported_rotors_follow_their_joints():
    """The file has continuous joints that follow with -N, and every byte of the old one."""
    request = RemedyRequest(as_linkage("four_bar_general"), gear=3.0)
    found = next(apply_separate_rotors(request))
    own = request.base.data.decode()
    text = found.urdf.decode()
    assert text.startswith(own[: own.rindex("</robot>")].rstrip())
    assert found.new_joints == ("u1_rotor_joint", "q4_rotor_joint")
    for joint, source in zip(found.new_joints, ("u1", "q4"), strict=True):
        element = text[text.index(f'<joint name="{joint}" type="continuous">') :]
        element = element[: element.index("</joint>")]
        assert f'<mimic joint="{source}" multiplier="-3"' in element
    again = kinematics.load(Document("again", found.urdf))
    mass = sum(body.inertia[0] for body in again.bodies)
    assert mass - request.given_mass == pytest.approx(found.added_mass, rel=1e-12)
    assert found.residual <= 1e-9


def test_spatial_arm_needs_three_rotors():
    """Rotors of joints whose axes turn ride on the link before."""
    bodies = {f"L{k}": (1.0, (0.3 * k, 0, 0.5), 0.01 * np.eye(3)) for k in (1, 2, 3)}
    joints = [
        ScrewJoint("j1", "base", "L1"),
        ScrewJoint("j2", "L1", "L2", axis=(0, 1, 0), point=(0, 0, 0.5)),
        ScrewJoint("j3", "L2", "L3", axis=(0, 1, 0), point=(0.6, 0, 0.5)),
    ]
    linkage = from_screws(joints, bodies=bodies)
    found = list(apply_separate_rotors(RemedyRequest(linkage, gear=4.0, radius=0.5)))
    assert [one.verdict for one in found] == ["feasible"], found
    assert found[0].details["fewest"] == 3 and len(found[0].new_links) == 3
    assert "j1 (on the ground) and j2, j3 (on the link before)" in found[0].words


def test_where_rotors_are_no_remedy():
    """Force balance, a feasible linkage, and one that no rotors balance."""
    force = RemedyRequest(as_linkage("five_bar"), balance="force")
    for apply in (apply_separate_rotors, apply_counter_rotary_masses):
        (found,) = apply(force)
        assert found.verdict == "refused" and "force balance" in found.reason
        (found,) = apply(RemedyRequest(as_linkage("slider_crank")))
        assert found.verdict == "refused" and "no counter-rotation is needed" in found.reason
        (found,) = apply(RemedyRequest(as_linkage("rusr")))
        assert found.verdict == "infeasible" and "certificate" in found.reason


@pytest.mark.slow
@pytest.mark.parametrize("gear", [1.0, 3.0])
def test_rotors_of_steel_balance_where_point_masses_do(gear):
    """A steel rotor at its radius weighs more than a ring of points, and not much more."""
    requests = [
        RemedyRequest(as_linkage("four_bar_general"), gear=gear, density=density)
        for density in (None, 7850.0)
    ]
    points, steel = (next(apply_separate_rotors(request)) for request in requests)
    assert (points.verdict, steel.verdict) == ("feasible", "feasible"), steel.reason
    assert steel.residual <= 1e-9
    assert points.added_mass < steel.added_mass < 1.5 * points.added_mass
