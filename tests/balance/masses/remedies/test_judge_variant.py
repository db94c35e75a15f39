"""The judgement of variants: least matter, written files, and what is left of them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import balance
import kinematics
from balance.masses.remedies.judge_variant import judge_variant
from balance.masses.remedies.request import RemedyRequest, freedoms_of, input_inertia
from balance.masses.remedies.variant import Variant, append_elements, free_name, names_taken
from balance.motion.verification.verify_motions import PinocchioModel
from kinematics import ScrewJoint, from_screws
from kinematics.closure.joint_positions import joint_positions
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element

ARM = """<?xml version="1.0"?>
<!-- kept -->
<robot name="arm">
  <link name="base"/>
  <link name="arm">
    <inertial><origin xyz="0.5 0 0"/><mass value="1"/>
      <inertia ixx="0" iyy="0.0833333333333" izz="0.0833333333333" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="j" type="continuous">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
  </joint>
</robot>
"""


def arm_request(**options) -> RemedyRequest:
    linkage = kinematics.load(Document("arm.urdf", ARM.encode()))
    return RemedyRequest(linkage, **options)


def rotor_on(request: RemedyRequest, carrier: str, place, gear: float) -> Variant:
    """A rotor on a carrier that turns ``-gear`` times as fast as the joint j."""
    pose = np.eye(4)
    pose[:3, 3] = place
    at = make_elements.origin(pose)
    parts = [
        make_elements.link("rotor"),
        make_elements.joint(
            "gear", "continuous", carrier, "rotor", at, ("0 0 1", ""), mimic=("j", -gear, 0.0)
        ),
    ]
    return Variant(
        "separate_rotors",
        "a rotor",
        append_elements(request.base, parts),
        ("arm", "rotor"),
        {"rotor": "ball(0,0,0,0.2)"},
        new_links=("rotor",),
        new_joints=("gear",),
    )


@pytest.mark.slow
def test_an_arm_with_a_rotor_has_the_least_mass_of_the_textbook():
    """A counterweight at distance r, and a ring whose J cancels what both turn with.

    The arm has 0.5 kg m, so that 0.5/r kg balance its force, inside a ball of 0.25 m. It turns
    with 1/3 + 0.5 r kg m² about the joint; a ring of radius ρ needs that over ρ² and over the
    gear g. The sum is least at r = ρ √g.
    """
    for gear in (1.0, 4.0, 16.0):
        found = judge_variant(arm_request(), rotor_on(arm_request(), "base", (0, 0, 0), gear))
        assert found.verdict == "feasible", found.reason
        r = min(0.25, 0.2 * gear**0.5)
        own = 0.0833333333333 + 0.25 + 0.5 * r
        assert found.added_mass == pytest.approx(0.5 / r + own / 0.04 / gear, rel=1e-6)
        # The rotor on the base adds J gear² to what the input feels.
        felt = own + own / gear * gear**2
        assert found.input_inertia == {"j": pytest.approx(felt, rel=1e-6)}
        assert found.inertia_ratio == pytest.approx(felt / (0.0833333333333 + 0.25), rel=1e-6)
        assert found.residual <= 1e-9 and found.lost_freedoms == 0
        again = kinematics.load(Document("again.urdf", found.urdf))
        assert balance.verify(again).balanced
        assert b"<!-- kept -->" in found.urdf


def test_a_rotor_that_turns_with_the_arm_helps_nothing():
    """The proof is the sign: no masses whatever."""
    found = judge_variant(arm_request(), rotor_on(arm_request(), "base", (0, 0, 0), -1.0))
    assert found.verdict == "infeasible" and found.reason.startswith("no masses whatever: ")
    assert found.urdf is None and found.added_mass is None


def test_regions_of_the_user_are_not_widened():
    """The plain kite has a balanced design, which its default regions do not hold."""
    kite = kinematics.load("four_bar_kite")
    request = RemedyRequest(kite)
    base = Variant("own_masses", "", request.base, request.links)
    assert judge_variant(request, base).verdict == "feasible"
    tight = dict.fromkeys(request.links, "ball(0,0,0,0.1)")
    found = judge_variant(RemedyRequest(kite, regions=tight), base)
    assert found.verdict == "infeasible" and "no masses whatever" not in found.reason


def test_links_between_the_joints_of_a_floating_joint_stay_massless():
    """A body held at a point balances by matter about that point, as its own masses do."""
    joints = [ScrewJoint("free", "ground", "bob", point=(0, 0, -1), kind="floating")]
    loops = [ScrewJoint("pin", "ground", "bob", kind="spherical")]
    bob = {"bob": (1.0, (0.0, 0.0, -1.0), np.diag([0.1, 0.1, 0.1]))}
    linkage = from_screws(joints, loops, bob, name="hung")
    request = RemedyRequest(linkage, balance="force")
    assert linkage.mobility == 3
    base = Variant("own_masses", "", request.base, request.links)
    assert judge_variant(request, base).verdict == "feasible"


@pytest.mark.parametrize("model", ["hprs", "four_bar_general", "three_rrr", "rusr", "delta"])
def test_input_inertia_is_twice_pinocchios_kinetic_energy(model):
    """At a unit rate of the input, with the rates of all joints from poses beside."""
    linkage = kinematics.load(model)
    masses = np.array([body.inertia for body in linkage.bodies])
    robot = PinocchioModel(linkage, masses)
    data, rest = robot.model.createData(), pin.neutral(robot.model)
    h = 1e-4
    for k, name in enumerate(linkage.inputs):
        step = np.eye(len(linkage.inputs))[k] * h
        ends = [joint_positions(linkage, sign * step) for sign in (1, -1)]
        rates = (ends[0] - ends[1]) / (2 * h)
        energy = pin.computeKineticEnergy(robot.model, data, rest, rates)
        assert input_inertia(linkage)[name] == pytest.approx(2.0 * energy, rel=1e-6)


def test_the_base_is_the_file_or_says_what_it_lacks(tmp_path):
    """Another pose, or loops from elsewhere, are written anew."""
    own = kinematics.load("four_bar_general")
    assert RemedyRequest(own).base.data == kinematics.gallery()["four_bar_general"].read_bytes()
    moved = kinematics.load("four_bar_general", at={"u1": 0.2})
    again = kinematics.load(RemedyRequest(moved).base)
    assert again.displaced is None
    for one, other in zip(moved.joints, again.joints, strict=True):
        np.testing.assert_allclose(one.screw, other.screw, atol=1e-12)


def test_links_declared_massless_have_no_mass_in_what_is_written():
    given = kinematics.load("five_bar")
    name = given.bodies[0].name
    linkage = kinematics.load("five_bar", massless=[name])
    again = kinematics.load(RemedyRequest(linkage).base)
    assert name not in [body.name for body in again.bodies] and len(again.bodies) == 3


def test_freedoms_under_relations():
    five = kinematics.load("five_bar")
    assert freedoms_of(five, ()) == 2
    assert freedoms_of(five, (f"{five.inputs[0]}=0",)) == 1


def test_elements_are_appended_and_nothing_else_changes():
    document = Document(
        "a.urdf", b"<robot name='a'><!-- x -->\r\n\t<link name='l'/>\r\n</robot>"
    )
    new = append_elements(document, [Element("link", {"name": "m"})])
    assert new.data == (
        b"<robot name='a'><!-- x -->\r\n\t<link name='l'/>\r\n\t<link name=\"m\"/>\r\n</robot>"
    )
    assert names_taken(new) == {"l", "m"}
    assert free_name("m", names_taken(new)) == "m_2" and free_name("n", {"m"}) == "n"
