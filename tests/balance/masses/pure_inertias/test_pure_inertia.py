"""Momentum stays the same on the way to pure inertias and back; what stays has a reason."""

from functools import cache

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.bodies import mass_properties, parameters
from balance.masses import pure_inertia
from balance.space.inertial_parameters.multipole import point_mass, rod
from kinematics import ScrewJoint, from_screws
from kinematics.errors import MobilityError, OpenLoopError, UsageError
from tests.support.covering import number_of_cases
from tests.support.planar_masses import in_plane, momentum, with_masses


def random_linkage(rng):
    """A planar linkage with revolute joints: a tree of links, and loops if it still moves."""
    count = int(rng.integers(2, 7))
    names = ["base", *(f"link{k}" for k in range(count))]
    joints = [
        ScrewJoint(
            f"q{k}",
            names[int(rng.integers(0, k + 1))],
            names[k + 1],
            point=(*rng.uniform(-1, 1, 2), 0),
        )
        for k in range(count)
    ]
    closing = []
    for k in range(int(rng.integers(0, (count - 1) // 2 + 1))):
        one, other = rng.choice(names, 2, replace=False)
        closing.append(
            ScrewJoint(f"loop{k}", str(one), str(other), point=(*rng.uniform(-1, 1, 2), 0))
        )
    return from_screws(joints, closing), [*joints, *closing]


@cache
def random_linkages():
    """Fifty linkages without rigid parts, with their joints and random numbers, or 200."""
    rng, found = np.random.default_rng(23), []
    while len(found) < number_of_cases(50, 200):
        try:
            linkage, joints = random_linkage(rng)
        except (MobilityError, OpenLoopError):
            continue
        if all(item.joints for item in design_space(linkage).transfers):
            found.append((linkage, joints, rng.spawn(1)[0]))
    return found


@pytest.mark.slow
def test_pure_inertias_come_back_from_masses_at_joints():
    """Inertias and masses moved at joints; the inertias are found again."""
    for linkage, joints, rng in random_linkages():
        names = [body.name for body in linkage.bodies]
        g = rng.uniform(-1, 1, len(names))
        z = np.outer(g, 0.5 * (rod([1, 0, 0]) + rod([0, 1, 0])))
        pure = in_plane(z).copy()
        for joint in joints:
            mass = rng.uniform(-1, 1) * point_mass(joint.point)
            for name, sign in ((joint.child, 1.0), (joint.parent, -1.0)):
                if name in names:
                    z[names.index(name)] += sign * mass
        before, size = momentum(linkage, in_plane(z))
        after, _ = momentum(linkage, pure)
        assert np.abs(after - before).max() < 1e-12 * size
        found = pure_inertia(design_space(with_masses(linkage, z)))
        assert found.complete, found.immovable
        # Equal, unless bodies turn alike and could exchange inertia.
        apart, largest = found.inertias - g, max(1.0, np.abs(in_plane(z)).max())
        assert np.abs(found.conditions @ apart).max(initial=0.0) < 1e-11 * largest
        assert len(found.relations) or np.abs(apart).max() < 1e-11 * largest
        there, _ = momentum(linkage, found.parameters)
        assert np.abs(there - before).max() < 1e-12 * size


@pytest.mark.slow
def test_any_masses_keep_their_momentum():
    """Random masses: what stays, stays with the same momentum."""
    for linkage, _, rng in random_linkages():
        z = np.array(
            [
                parameters(rng.uniform(0.5, 2), [*rng.uniform(-1, 1, 2), 0], 0.3 * np.eye(3))
                for _ in linkage.bodies
            ]
        )
        found = pure_inertia(design_space(with_masses(linkage, z)))
        before, size = momentum(linkage, in_plane(z))
        there, _ = momentum(linkage, found.parameters)
        assert np.abs(there - before).max() < 1e-12 * size
        # Back: what bodies gained at joints is taken away again.
        back = found.parameters.copy()
        for item in found.moved:
            x, y = item.point
            for name, mass in item.gains.items():
                at = found.space.bodies.index(name)
                back[at] -= mass * np.array([1, x, y, x * x + y * y])
        assert np.abs(back - in_plane(z)).max() < 1e-11
        stay = {item.body for item in found.immovable}
        for name, row in zip(found.space.bodies, found.parameters, strict=True):
            assert (name in stay) == bool(np.any(row[:3] != 0.0))


def test_a_body_that_keeps_its_mass_has_a_reason():
    left = {x.body: x.reason for x in pure_inertia(design_space("four_bar_general")).immovable}
    assert set(left) == {"crank", "coupler", "rocker"}
    assert "m beside the line through its revolute joints" in left["crank"]
    distance = float(left["crank"].split()[5])
    com = mass_properties(kinematics.load("four_bar_general").bodies[0].inertia).com
    o1, o2 = (kinematics.load("four_bar_general").joints[k].point for k in (0, 1))
    n = (o2 - o1) / np.linalg.norm(o2 - o1)
    assert distance == pytest.approx(np.linalg.norm(np.cross(com - o1, n)), rel=1e-3)


def test_masses_on_slides_that_cannot_be_moved_are_named():
    """A slider with its centre off its pin; one without any pin; one that turns and slides."""
    found = pure_inertia(design_space("slider_crank"))
    (reason,) = (x.reason for x in found.immovable if x.body == "slider")
    assert "0.02 m from its revolute joint, across the slide" in reason
    assert "a prismatic joint lets no point mass pass" in reason
    found = pure_inertia(design_space("slider_pantograph"))
    reasons = {x.body: x.reason for x in found.immovable}
    assert "no revolute joint leads to a body" in reasons["slider"]
    assert "prismatic" in reasons["slider"]


def test_a_slider_with_its_centre_in_the_pin_is_a_point_mass():
    """[J] section 6.2: its mass is moved through the pin to the links."""
    linkage = kinematics.load("slider_crank")
    z = np.array([body.inertia for body in linkage.bodies])
    z[2] = parameters(0.8, [0.6, 0, 0], 0.004 * np.eye(3))
    # Coupler and crank on their lines, their centres so that the whole is balanced.
    z[1] = parameters(0.6, [0.3 - 0.8 / 0.6 * 0.3, 0.4 + 0.8 / 0.6 * 0.4, 0], 0.05 * np.eye(3))
    z[0] = parameters(2.0, [-0.7 * 0.3, -0.7 * 0.4, 0], 0.02 * np.eye(3))
    found = pure_inertia(design_space(with_masses(linkage, z)))
    assert found.complete
    before, size = momentum(linkage, in_plane(z))
    after, _ = momentum(linkage, found.parameters)
    assert np.abs(after - before).max() < 1e-13 * size


def test_only_planar_dynamic_spaces_have_pure_inertias():
    for space in (
        design_space("bennett"),
        design_space("five_bar", balance="force"),
        design_space("four_bar_kite", spatial=True),
    ):
        with pytest.raises(UsageError, match="planar"):
            pure_inertia(space)
