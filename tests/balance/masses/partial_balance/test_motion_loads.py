"""Loads as functions of added matter, against Pinocchio and against loads of the sums."""

from __future__ import annotations

import numpy as np
import pytest

from balance import design_space
from balance.masses.counterweights.link_regions import regions_of
from balance.masses.partial_balance.motion_loads import AddedParameters, motion_loads
from balance.motion.verification.joint_reactions import joint_reactions
from balance.motion.verification.shaking_wrench import inertia_loads
from balance.motion.verification.trajectory import random_motions
from balance.motion.verification.verify_motions import PinocchioModel
from tests.support.robots import arm

POINTS = [
    [0, 0, 0.1],
    [0, 0.1, 0.2],
    [0.4, 0.1, 0.2],
    [0.8, 0, 0.2],
    [0.8, 0.1, 0.1],
    [0.8, 0.1, 0],
]
AXES = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 0]]


@pytest.fixture
def case(request, tmp_path):
    """Loads along two random motions, and random coordinates of added matter."""
    path = arm(tmp_path, POINTS, AXES) if request.param == "arm" else request.param
    space = design_space(path, max_order=0)
    regions = regions_of(space, space.bodies[:2], {space.bodies[1]: "box(0:1,0:1,-1:1)"})
    matter = AddedParameters.of(space, regions)
    motions = list(random_motions(space.linkage, 2, 25))
    s = np.random.default_rng(5).standard_normal(matter.count)
    return space.linkage, matter, motion_loads(matter, motions), s


MODELS = ["arm", "slider_crank", "three_rsr"]


@pytest.mark.parametrize("case", MODELS, indirect=True)
def test_the_wrench_is_that_of_pinocchio(case):
    linkage, matter, loads, s = case
    model = PinocchioModel(linkage, matter.parameters(s))
    for one in loads:
        found = one.wrench_columns @ np.append(s, 1.0)
        expected = model.reactions(one.trajectory)
        expected[:, :3] -= np.cross(matter.chain.frame.origin, expected[:, 3:])
        assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()
        assert one.weights.sum() == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("case", ["arm"], indirect=True)
def test_drives_of_an_arm_are_those_of_pinocchio(case):
    pin = pytest.importorskip("pinocchio")
    linkage, matter, loads, s = case
    model = PinocchioModel(linkage, matter.parameters(s)).model
    data, x = model.createData(), np.append(s, 1.0)
    inertia = np.diag(pin.crba(model, data, np.zeros(model.nq)))
    assert matter.input_inertia() @ x == pytest.approx(inertia, rel=1e-12)
    for one in loads:
        way = one.trajectory
        rows = zip(way.q, way.qd, way.qdd, strict=True)
        torque = np.array([pin.rnea(model, data, *row).copy() for row in rows])
        found = one.torques(one.reactions()) @ x
        assert np.abs(found - torque).max() < 1e-12 * np.abs(torque).max()


@pytest.mark.parametrize("model", ["slider_crank", "three_rsr"])
def test_the_drives_do_no_work_over_a_period(model):
    """The kinetic energy is that of the start again; sums over a period are exact."""
    space = design_space(model, max_order=0)
    matter = AddedParameters.of(space, regions_of(space, space.bodies[:2], {}))
    x = np.append(np.random.default_rng(5).standard_normal(matter.count), 1.0)
    (one,) = motion_loads(matter, list(random_motions(space.linkage, 1, 401)))
    power = np.einsum("ki,ki->k", one.torques(one.reactions()) @ x, one.trajectory.ud)
    assert abs(one.weights @ power) < 1e-9 * (one.weights @ np.abs(power))


@pytest.mark.parametrize("case", MODELS, indirect=True)
def test_reactions_are_those_of_the_sum_of_all_masses(case):
    """Columns of reactions, combined, against the reactions of the combined masses."""
    linkage, matter, loads, s = case
    x, chain = np.append(s, 1.0), matter.chain
    for one in loads:
        way = one.trajectory
        ud, udd = way.ud / matter.input_units, way.udd / matter.input_units
        plain = inertia_loads(chain, matter.parameters(s), way.q / chain.units, ud, udd)
        expected = joint_reactions(chain, plain)
        found = one.reactions()
        size = np.abs(expected.joints).max()
        assert np.abs(found.joints @ x - expected.joints).max() < 1e-11 * size
        single = one.reactions(x[:, None])
        assert np.abs(single.joints[..., 0] - expected.joints).max() < 1e-11 * size
