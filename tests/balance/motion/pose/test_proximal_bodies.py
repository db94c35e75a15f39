"""Bodies on the inputs solved in turn: arms in series, closed linkages, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.bodies import mass_properties, violations
from balance.pose import balance_pose, momentum_matrix
from kinematics import ScrewJoint, from_screws
from kinematics.errors import BodyError, CoordinateError
from tests.support.laws import point_masses, sums
from tests.support.pairs import screw


def geared_arm(rng, count=3):
    """Hinges in series, each with a wheel on the ground that follows it."""
    joints, bodies = [], {}
    for k in range(count):
        parent, wheel = f"a{k - 1}" if k else "base", mass_properties(sums(*point_masses(rng)))
        joints += [
            ScrewJoint(f"u{k}", parent, f"a{k}", screw=screw(rng, "zero")),
            ScrewJoint(
                f"q{k}",
                "base",
                f"b{k}",
                rng.standard_normal(3),
                wheel.com,
                mimic=(f"u{k}", rng.uniform(-9.0, 9.0) * 20.0 ** (count - k)),
            ),
        ]
        bodies[f"a{k}"] = 1.0, np.zeros(3), np.eye(3)
        bodies[f"b{k}"] = tuple(wheel)
    return from_screws(joints, bodies=bodies, inputs=[f"u{k}" for k in range(count)])


def test_an_arm_is_balanced_from_its_end_inwards():
    rng, balanced = np.random.default_rng(2), 0
    for _ in range(40):
        linkage = geared_arm(rng, count=2)
        found = balance_pose(linkage, {"a0": 50.0, "a1": 0.1})
        assert list(found.families) == ["a1", "a0"][: len(found.families)]
        if found.z is None:
            assert list(found.families.values())[-1].reason in found.words
            continue
        balanced += 1
        size = np.abs(momentum_matrix(linkage, [0.0, 0.0], np.abs(found.z))).max()
        assert np.abs(momentum_matrix(linkage, [0.0, 0.0], found.z)).max() < 1e-11 * size
        assert not any(violations(z) for z in found.z)
    assert balanced >= 3


def test_a_closed_linkage_is_balanced_by_its_legs():
    """The spatial 3-RSR, in its pose and in another one; masses of the user."""
    for at in (None, {"u1": 0.1, "u2": -0.05, "u3": 0.02}):
        linkage = kinematics.load("three_rsr", at=at)
        lower = [body.name for body in linkage.bodies if body.name.startswith("lower")]
        found = balance_pose(linkage, dict.fromkeys(lower, 2.0))
        assert sorted(found.families) == sorted(lower) and found.residual < 1e-12
        assert {body.mass for body in found.bodies if body.name in lower} == {2.0}
        M = momentum_matrix(linkage, [0.0, 0.0, 0.0], found.z)
        assert np.abs(M).max() < 1e-11 * np.abs(found.z).max()
        assert not any(violations(z) for z in found.z)


def test_requests_that_cannot_be_met():
    with pytest.raises(BodyError, match="on an input joint"):
        balance_pose("three_rsr", {"platform": 1.0})
    with pytest.raises(BodyError, match="not above 0"):
        balance_pose("three_rsr", {"lower1": 0.0})
    with pytest.raises(CoordinateError, match="0 bodies"):
        balance_pose("hprs")
    linkage = kinematics.load("five_bar")
    inner = [joint.name for joint in linkage.joints if joint.parent >= 0]
    with pytest.raises(CoordinateError, match="between it and the base"):
        balance_pose(kinematics.load("five_bar", inputs=[linkage.inputs[0], inner[-1]]))
    light = balance_pose("three_rsr", {"lower3": 0.01})
    assert light.z is None and "its mass must be above 0.266667 kg" in light.words
