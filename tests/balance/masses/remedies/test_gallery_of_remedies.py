"""Models of the gallery with a remedy built in: their masses by hand, and no momentum.

Masses and lengths are read from the files by ElementTree alone, and the momentum comes from
finite poses of the independent route (``tests/independent/reference.py``).
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

import balance
import kinematics
from tests.independent import reference

BALANCED = [
    ("double_pendulum_counter_rotary", (), 2),
    ("double_pendulum_duplicates", (), 2),
    ("four_bar_added_antiparallelogram", (), 1),
    ("four_bar_added_slider_crank", (), 1),
    ("principal_vector_linkage", ("u1=-u3", "u2=-u3"), 1),
    ("principal_vector_linkage_slider", (), 1),
    ("three_four_bars_platform", (), 3),
    ("zero_reaction_arm", ("u3=-12*u1-4*u2",), 2),
]
FORCE_ONLY = ["principal_vector_linkage", "zero_reaction_arm"]


def masses(name):
    """Mass, centre of mass in the link frame and izz of each link."""
    root = ElementTree.parse(kinematics.gallery()[name]).getroot()
    found = {}
    for link in root.findall("link"):
        if (inertial := link.find("inertial")) is not None:
            at = np.array(inertial.find("origin").get("xyz").split(), float)
            mass = float(inertial.find("mass").get("value"))
            found[link.get("name")] = mass, at, float(inertial.find("inertia").get("izz"))
    return found


def momenta(name, motion, seed, reach=0.3):
    """Momentum ``[ξ; p]`` of unit rates at a random pose, and the size of its parts."""
    mechanism = reference.load(name)
    basis = reference.motion_basis(mechanism, motion)
    u = basis @ np.random.default_rng(seed).uniform(-reach, reach, basis.shape[1])
    q = reference.follow(mechanism, np.zeros(len(mechanism.joints)), u)
    X = reference.regressor(mechanism, q, reference.velocities(mechanism, q, basis))
    z = mechanism.inertias
    parts = np.einsum("rbp,bp->rb", X.reshape(len(X), *z.shape), z).reshape(-1, 6, len(z))
    return parts.sum(axis=2), np.abs(parts).sum(axis=2).max()


@pytest.mark.parametrize(("name", "motion", "freedoms"), BALANCED)
def test_no_momentum_at_random_poses(name, motion, freedoms):
    for seed in range(4):
        total, size = momenta(name, motion, seed)
        assert total.shape == (freedoms, 6)
        assert np.abs(total).max() < 1e-12 * size


@pytest.mark.parametrize("name", FORCE_ONLY)
def test_without_the_relation_the_force_vanishes_and_the_moment_does_not(name):
    for seed in range(4):
        total, size = momenta(name, (), seed)
        assert len(total) == 3
        assert np.abs(total[:, 3:]).max() < 1e-12 * size
        assert np.abs(total[:, :3]).max() > 1e-2 * size


@pytest.mark.parametrize(("name", "motion", "freedoms"), BALANCED)
def test_only_translating_bodies_have_no_say_in_the_moment(name, motion, freedoms):
    """A pure inertia of any other body has a moment at the reference pose."""
    mechanism = reference.load(name)
    basis = reference.motion_basis(mechanism, motion)
    rates = reference.velocities(mechanism, np.zeros(len(mechanism.joints)), basis)
    X = reference.regressor(mechanism, np.zeros(len(mechanism.joints)), rates)
    spins = X.reshape(-1, 6, len(mechanism.bodies), 10)[:, 2, :, 6]
    still = {"coupler", "dyad_slider", "element2"}
    turning = {name for name, x in zip(mechanism.bodies, spins.T, strict=True) if np.any(x)}
    assert set(mechanism.bodies) - turning <= still


def test_counter_rotary_masses_by_hand():
    """Rods of 1 kg and 1 m; arms 0.5 m and 0.25 m; gear 4."""
    m, length, a1, a2, gear = 1.0, 1.0, 0.5, 0.25, 4.0
    k2 = m * length / 2 / a2
    k1 = (m * length / 2 + (m + k2) * length) / a1
    j2 = (m * length**2 / 3 + k2 * a2**2) / (gear - 1)
    i1 = m * length**2 / 3 + (m + k2) * length**2 + k1 * a1**2
    j1 = (i1 + gear * j2) / (gear - 1)
    found = masses("double_pendulum_counter_rotary")
    assert found["counter1"][0] == pytest.approx(k1, rel=1e-14)
    assert found["counter2"][0] == pytest.approx(k2, rel=1e-14)
    assert found["counter1"][2] == pytest.approx(j1, rel=1e-14)
    assert found["counter2"][2] == pytest.approx(j2, rel=1e-14)
    for rod in ("rod1", "rod2"):
        assert found[rod][2] == pytest.approx(1 / 12, rel=1e-14)
        assert np.linalg.norm(found[rod][1]) == pytest.approx(0.5, rel=1e-14)


def test_duplicates_by_hand():
    """Three copies: mirrored twice, so that masses and inertias are those of the original."""
    found = masses("double_pendulum_duplicates")
    for rod in ("rod1", "rod2"):
        for tag, signs in (("", (1, 1)), ("a", (1, -1)), ("b", (-1, 1)), ("c", (-1, -1))):
            mass, at, izz = found[rod + tag]
            assert (mass, izz) == found[rod][::2] == (1.0, pytest.approx(1 / 12))
            assert at[:2] == pytest.approx(found[rod][1][:2] * signs)
    root = ElementTree.parse(kinematics.gallery()["double_pendulum_duplicates"]).getroot()
    ratios = {
        joint.get("name")[-1]: float(mimic.get("multiplier"))
        for joint in root.findall("joint")
        if (mimic := joint.find("mimic")) is not None
    }
    assert ratios == {"a": -1.0, "b": -1.0, "c": 1.0}


def test_pure_inertias_of_the_added_antiparallelogram():
    """With the couplers put at their ends: crank + rocker = -coupler = rocker of the dyad."""
    found = masses("four_bar_added_antiparallelogram")
    o2, b, far = np.array([0.04, 0.32]), np.array([-0.1, 0.3]), np.array([-0.16, -0.28])

    def about(name):
        mass, at, izz = found[name]
        return izz + mass * at @ at

    half, quarter = found["dyad_coupler"][0] / 2, found["coupler"][0] / 2
    crank = about("crank") + half * o2 @ o2 + quarter * b @ b
    rocker = about("rocker") + quarter * b @ b
    coupler = found["dyad_coupler"][2] - half * 2 * 0.5 * 0.5
    dyad = about("dyad_rocker") + half * far @ far
    assert [crank + rocker, -coupler, dyad] == pytest.approx([0.3, 0.3, 0.3], abs=1e-15)


def test_inertias_of_the_added_slider_crank():
    """The link of the dyad with its slider turns at -w, crank and rocker at w."""
    found = masses("four_bar_added_slider_crank")
    p, b = np.array([0.3, 0.4]), np.array([-0.1, 0.3])

    def about(name):
        mass, at, izz = found[name]
        return izz + mass * at @ at

    link = about("dyad_link") + found["dyad_slider"][0] * 0.25
    carried = found["dyad_link"][0] + found["dyad_slider"][0]
    crank = about("crank") + carried * p @ p + 0.25 * b @ b
    rocker = about("rocker") + 0.25 * b @ b
    assert link == pytest.approx(0.75) and crank + rocker == pytest.approx(0.75)


def test_principal_points_by_hand():
    """|A1 P1| = m1 s1 / (m1 + m2 + m3), and the same on the other side."""
    found = masses("principal_vector_linkage_slider")
    (m1, s1, j1), (m2, s2, _), (m3, s3, j3) = (found[f"element{k}"] for k in (1, 2, 3))
    total = m1 + m2 + m3
    assert m1 * np.linalg.norm(s1) / total == pytest.approx(0.15)
    assert m3 * np.linalg.norm(s3) / total == pytest.approx(0.15)
    assert m1 * -0.5 + m2 * s2[0] + m3 * 0.5 == pytest.approx(0.0)
    assert j1 == j3


def test_equal_inertias_are_needed():
    """With another moment of inertia of element 3 the slider does not balance."""
    linkage = kinematics.load("principal_vector_linkage_slider")
    space = balance.design_space(linkage)
    given = np.array([body.inertia for body in linkage.bodies])
    X = balance.momentum.momentum_regressor(linkage, [0.2], spatial=True)[0]
    assert np.abs(X @ given.ravel()).max() < 1e-14
    changed = given.copy()
    changed[[body.name for body in linkage.bodies].index("element3"), 6] += 0.01
    assert np.abs(X @ changed.ravel())[2] == pytest.approx(0.01)
    assert space.as_given.balanced


def test_a_balanced_antiparallelogram_is_a_rigid_body():
    """Its moment of inertia about any point of its base is the same in every pose."""
    mechanism = reference.load("four_bar_antiparallelogram_balanced")
    found = []
    for u in (0.0, 0.3, -0.4):
        q = reference.follow(mechanism, np.zeros(3), np.array([u]))
        placed = reference.displacements(mechanism, q)[0]
        total = np.zeros(3)
        for link, z in zip(mechanism.links, mechanism.inertias, strict=True):
            R, d = placed[link][:3, :3], placed[link][:3, 3]
            moment = R @ z[1:4]
            total += [z[6] + 2 * d @ moment + z[0] * d @ d, *(moment + z[0] * d)[:2]]
        found.append(total)
    assert found[1] == pytest.approx(found[0], abs=1e-14)
    assert found[2] == pytest.approx(found[0], abs=1e-14)


@pytest.mark.table(1)
@pytest.mark.parametrize(("name", "motion", "freedoms"), BALANCED)
def test_report_and_verify_agree(name, motion, freedoms, capsys):
    from balance.app.cli.main import main

    relations = [word for relation in motion for word in ("--motion", relation)]
    assert main(["report", name, *relations]) == 0
    assert f"mobility      {kinematics.load(name).mobility}" in capsys.readouterr().out
    assert main(["verify", name, "--trajectories", "2", *relations]) == 0
