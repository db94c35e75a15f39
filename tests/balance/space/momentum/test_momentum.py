"""The momentum ``h = X z`` is that of Pinocchio, and the rate of the mass moment.

Pinocchio gets joints and bodies as data: the joints of the loops become branches without
mass, and the loops themselves constraints on its own Jacobians. What is put to the test is
thus everything after the file is read: closed poses, joint rates, and the regressor. All
frames coincide with the inertial one, up to translations, at the reference pose.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import null_space

import kinematics
from balance.bodies import mass_properties
from balance.momentum import momentum_regressor
from kinematics.closure.joint_positions import joint_positions
from tests.support.covering import spread
from tests.support.laws import (
    MODELS,
    PLANAR,
    altered,
    displacement,
    placed,
    point_masses,
    relative,
    sums,
)

pin = pytest.importorskip("pinocchio")

FIVE = ("three_rsr", "hprs", "bennett", "four_rrr", "four_bar_general")
REACH = 0.3  # radians or metres; the gallery keeps clear of singular poses that far
PLANAR_ROWS, PLANAR_PARAMETERS = [2, 3, 4], [0, 1, 2, 6]


def joint_model(joint):
    """The joint of Pinocchio for a screw."""
    n, v = joint.screw[:3], joint.screw[3:]
    if joint.kind == "prismatic":
        return pin.JointModelPrismaticUnaligned(v)
    if joint.kind == "helical":
        return pin.JointModelHelicalUnaligned(n, float(n @ v))
    return pin.JointModelRevoluteUnaligned(n)


def pinocchio_model(linkage):
    """All joints of a linkage with the bodies on their links; joint ``i + 1`` is joint i."""
    model = pin.Model()
    for joint in linkage.joints:
        before = linkage.joints[joint.parent].point if joint.parent >= 0 else np.zeros(3)
        placement = pin.SE3(np.eye(3), joint.point - before)
        model.addJoint(joint.parent + 1, joint_model(joint), placement, joint.name)
    for body in linkage.bodies:
        mass, com, inertia = mass_properties(body.inertia)
        local = pin.Inertia(mass, com - linkage.joints[body.link].point, inertia)
        model.appendBodyToJoint(body.link + 1, local, pin.SE3.Identity())
    return model


def coordinates(model, q):
    """Joint positions as Pinocchio wants them: some of its joints take (cos, sin)."""
    full = pin.neutral(model)
    for joint, value in zip(model.joints[1:], q, strict=True):
        turning = joint.nq == 2
        full[joint.idx_q : joint.idx_q + joint.nq] = (
            (np.cos(value), np.sin(value)) if turning else value
        )
    return full


def about_origin(force):
    """Pinocchio's linear-first force as ``[moment; force]``."""
    return np.concatenate([force.angular, force.linear])


class Closed:
    """A linkage in Pinocchio at a pose that the product has closed."""

    def __init__(self, linkage, q):
        self.linkage, self.model = linkage, pinocchio_model(linkage)
        self.data, self.q = self.model.createData(), coordinates(self.model, q)
        pin.computeJointJacobians(self.model, self.data, self.q)

    def displacement(self, link):
        """Displacement of a link from the reference pose."""
        if link < 0:
            return np.eye(4)
        at_reference = pin.SE3(np.eye(3), self.linkage.joints[link].point)
        return self.data.oMi[link + 1].act(at_reference.inverse()).homogeneous

    def gap(self):
        """How far the welds are open: radians and metres."""
        gaps = [
            self.displacement(w.end) - self.displacement(w.successor)
            for w in self.linkage.loops
        ]
        return np.abs(gaps).max(initial=0.0)

    def rates(self, rng):
        """Random joint rates that keep the loops closed, and relations; (n,)."""
        rows = [np.zeros((0, self.model.nv))]
        for weld in self.linkage.loops:
            sides = [
                pin.getJointJacobian(self.model, self.data, link + 1, pin.ReferenceFrame.WORLD)
                if link >= 0
                else np.zeros((6, self.model.nv))
                for link in (weld.end, weld.successor)
            ]
            rows.append(sides[0] - sides[1])
        for mimic in self.linkage.mimics:
            row = np.zeros((1, self.model.nv))
            row[0, self.model.joints[mimic.joint + 1].idx_v] = 1.0
            row[0, self.model.joints[mimic.source + 1].idx_v] = -mimic.ratio
            rows.append(row)
        free = null_space(np.vstack(rows), rcond=1e-9)
        assert free.shape[1] == self.linkage.mobility
        return free @ rng.standard_normal(free.shape[1])

    def momentum(self, v):
        """Total momentum about the inertial origin; moment first."""
        hg = pin.computeCentroidalMomentum(self.model, self.data, self.q, v)
        com = self.data.com[0]
        return np.concatenate([hg.angular + np.cross(com, hg.linear), hg.linear])

    def momentum_from_regressors(self, v):
        """The same from Pinocchio's ``bodyRegressor``, which has another order."""
        pin.forwardKinematics(self.model, self.data, self.q, v)
        total = np.zeros(6)
        for body in self.linkage.bodies:
            joint = body.link + 1
            mine = self.model.inertias[joint].toDynamicParameters()
            local = pin.bodyRegressor(pin.Motion.Zero(), self.data.v[joint]) @ mine
            total += about_origin(self.data.oMi[joint].act(pin.Force(local)))
        return total


def input_rates(linkage, v):
    return v[[[j.name for j in linkage.joints].index(name) for name in linkage.inputs]]


def masses(linkage):
    return np.concatenate([body.inertia for body in linkage.bodies])


def loaded(name, rng):
    """A linkage of the gallery with bodies of random point masses.

    The masses of some files are balanced, at least in part: nothing but round-off, or not
    much more, would be compared.
    """
    linkage = kinematics.load(name)
    bodies = []
    for body in linkage.bodies:
        weights, points = point_masses(rng, reach=0.3)
        z = sums(weights, points + body.inertia[1:4] / body.inertia[0])
        bodies.append(replace(body, inertia=z))
    return replace(linkage, bodies=tuple(bodies))


@pytest.mark.table(3)
@pytest.mark.parametrize("name", spread(sorted({*FIVE, *MODELS}), 2, 0))
def test_momentum_is_that_of_pinocchio(name):
    rng = np.random.default_rng(40)
    linkage = loaded(name, rng)
    z, worst = masses(linkage), 0.0
    for _ in range(100 if name in FIVE else 10):
        u = rng.uniform(-REACH, REACH, linkage.mobility)
        q = joint_positions(linkage, u)
        closed = Closed(linkage, q)
        assert closed.gap() < 1e-12
        assert input_rates(linkage, q) == pytest.approx(u, abs=1e-15)
        v = closed.rates(rng)
        X = momentum_regressor(linkage, u, spatial=True)
        assert X.shape == (linkage.mobility, 6, 10 * len(linkage.bodies))
        h = np.einsum("w,wij,j->i", input_rates(linkage, v), X, z)
        for expected in (closed.momentum(v), closed.momentum_from_regressors(v)):
            worst = max(worst, np.linalg.norm(h - expected) / np.linalg.norm(expected))
    assert worst < 1e-12


@pytest.mark.table
@pytest.mark.parametrize("name", MODELS)
def test_planar_regressors_are_part_of_the_spatial_ones(name):
    linkage = kinematics.load(name)
    u = np.random.default_rng(41).uniform(-REACH, REACH, linkage.mobility)
    if not linkage.planar:
        assert np.array_equal(
            momentum_regressor(linkage, u), momentum_regressor(linkage, u, spatial=True)
        )
        return
    flat = momentum_regressor(linkage, u)
    count = len(linkage.bodies)
    spatial = momentum_regressor(linkage, u, spatial=True).reshape(-1, 6, count, 10)
    part = spatial[:, PLANAR_ROWS][..., PLANAR_PARAMETERS].reshape(flat.shape)
    assert relative(flat, part) < 1e-13


@pytest.mark.parametrize("name", ["four_bar_general", "slider_crank", "four_rrr"])
def test_a_tilted_plane_has_its_own_axes(name, tmp_path):
    """Rows and parameters of a planar regressor are in the axes ``frame.R`` of the plane."""
    H = displacement(np.random.default_rng(42))
    linkage = kinematics.load(altered(name, tmp_path, placed(H)))
    assert linkage.planar
    R = linkage.chain.frame.R
    assert R @ R.T == pytest.approx(np.eye(3), abs=1e-14)
    u = np.random.default_rng(43).uniform(-REACH, REACH, linkage.mobility)
    # The mass of a planar body lies in the plane z = 0 of the file: only m, mc and the
    # moments about the normal bear on its momentum there.
    points, planar_z = [], []
    for body in linkage.bodies:
        mass, com, inertia = mass_properties(body.inertia)
        c = R @ com
        points.append(R[2] @ com)
        normal_moment = R[2] @ inertia @ R[2] + mass * (c[0] ** 2 + c[1] ** 2)
        planar_z += [mass, mass * c[0], mass * c[1], normal_moment]
    flat = momentum_regressor(linkage, u) @ planar_z
    h = momentum_regressor(linkage, u, spatial=True) @ masses(linkage)
    expected = np.column_stack([h[:, :3] @ R[2], h[:, 3:] @ R[0], h[:, 3:] @ R[1]])
    assert relative(flat, expected) < 1e-12
    assert np.abs(h[:, 3:] @ R[2]).max() < 1e-12 * np.abs(h).max()


def slope(function, h=0.02):
    """Derivative at 0 by central differences of eighth order, with Romberg's weights."""
    steps = h / 2.0 ** np.arange(4)
    table = [(function(s) - function(-s)) / (2.0 * s) for s in steps]
    for k in range(1, 4):
        table = [(4.0**k * fine - coarse) / (4.0**k - 1.0) for coarse, fine in pairwise(table)]
    return table[0]


@pytest.mark.parametrize("name", spread(MODELS, 3, 1))
def test_linear_momentum_is_the_rate_of_the_mass_moment(name):
    """``p_w = ∂/∂u_w Σ m c``, with the centre of mass of Pinocchio.

    Differences of double numbers at steps of 2.5e-3 leave 1e-13, their truncation
    ``h⁸ f⁽⁹⁾`` up to 1e-11.
    """
    linkage = kinematics.load(name)
    u = np.random.default_rng(44).uniform(-0.1, 0.1, linkage.mobility)
    X = momentum_regressor(linkage, u, spatial=True)
    model = pinocchio_model(linkage)
    data = model.createData()
    total = sum(body.inertia[0] for body in linkage.bodies)
    for w, direction in enumerate(np.eye(linkage.mobility)):

        def mass_moment(step, direction=direction):
            q = joint_positions(linkage, u + step * direction)
            return total * pin.centerOfMass(model, data, coordinates(model, q))

        assert X[w, 3:] @ masses(linkage) == pytest.approx(slope(mass_moment), abs=1e-9)


@pytest.mark.table
@pytest.mark.parametrize("name", PLANAR)
def test_moments_of_inertia_multiply_the_rate_of_the_angle(name):
    """The column of Ezz is the derivative of the angle of its body; steps as above."""
    linkage = kinematics.load(name)
    u = np.random.default_rng(45).uniform(-0.1, 0.1, linkage.mobility)
    X = momentum_regressor(linkage, u).reshape(linkage.mobility, 3, -1, 4)
    for w, direction in enumerate(np.eye(linkage.mobility)):
        rates = slope(lambda step, d=direction: joint_positions(linkage, u + step * d))
        for b, body in enumerate(linkage.bodies):
            spin, link = 0.0, body.link
            while link >= 0:
                spin += rates[link] * linkage.joints[link].screw[2]
                link = linkage.joints[link].parent
            assert X[w, 0, b, 3] == pytest.approx(spin, abs=1e-9)


def test_poses_may_be_given_in_three_ways():
    linkage = kinematics.load("five_bar")
    u = {"u1": 0.2, "u2": -0.1}
    X = momentum_regressor(linkage, u)
    assert np.array_equal(X, momentum_regressor(linkage, [0.2, -0.1]))
    assert np.array_equal(X, momentum_regressor(linkage, joint_positions(linkage, u)))
    still = momentum_regressor(linkage, {})
    assert relative(momentum_regressor(linkage, np.zeros(5)), still) < 1e-15
    with pytest.raises(ValueError, match="leave the loops open"):
        momentum_regressor(linkage, [0.2, 0.0, 0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="is not an input"):
        momentum_regressor(linkage, {"q2": 0.1})
    with pytest.raises(ValueError, match=r"give 2 \(the inputs\) or 5"):
        momentum_regressor(linkage, [0.1, 0.2, 0.3])
    with pytest.raises(ValueError, match="cannot be closed"):
        momentum_regressor(linkage, [3.0, -3.0])
