"""Printed figures come out, or are corrected by a computation; docs/reproduction.md lists them.

[J] J. J. de Jong, PhD thesis, University of Twente. [W] the paper on shaking-force balance
of the planar 4-RRR parallel manipulator, 13th World Congress in Mechanism and Machine
Science (IFToMM), Guanajuato, 2011, A12-523.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.bodies import mass_properties, violations
from balance.momentum import momentum_regressor
from kinematics import Motion
from tests.support import four_rrr
from tests.support.figures import DESIGNS
from tests.support.four_rrr import BODIES, CROSSED, GENERAL, PAIR, SIDE_BY_SIDE
from tests.support.laws import outside, relative, sums
from tests.support.source_files import ROOT

DOCUMENT = ROOT / "docs" / "reproduction.md"
# Other files all of whose tests the document names.
REPRODUCING = (
    "tests/balance/masses/counterweights/test_four_rrr_figures.py",
    "tests/kinematics/closure/taylor/test_thesis_motions.py",
)
# The platform of a planar RRR robot does not rotate; inputs are the joints of leg 1.
STRAIGHT = "c1=-a1-b1"
LEG = ["a1", "b1", "c1"]
PLANES = ["u2=u3", "u1=u3", "u1=u2"]


def momentum_left(linkage, u, motion=None):
    """Largest total momentum, relative to the sum of the bodies' own; ``[ξ; p]`` apart."""
    basis = Motion.parse(motion or (), linkage.inputs).basis
    X = np.einsum("urp,uw->wrp", momentum_regressor(linkage, basis @ u, spatial=True), basis)
    z = np.array([body.inertia for body in linkage.bodies])
    parts = np.einsum("wrbp,bp->wbr", X.reshape(*X.shape[:2], *z.shape), z)
    parts = parts.reshape(*parts.shape[:2], 2, 3)
    own = np.linalg.norm(parts, axis=3).sum(axis=1).max(axis=0)
    return (np.linalg.norm(parts.sum(axis=1), axis=2).max(axis=0) / own).max()


def robot(geometry, folder):
    """The 4-RRR of a geometry, driven by leg 1."""
    path = folder / "robot.urdf"
    path.write_text(geometry.text(), encoding="utf-8")
    return kinematics.load(path)


def force_space(linkage, motion=None):
    return design_space(linkage, motion, "force")


def conditions(found, bodies=None):
    """Orthonormal rows whose null space the design space is; bodies in the order given."""
    order = [found.bodies.index(name) for name in bodies or found.bodies]
    basis = found.basis.reshape(len(order), -1, found.nullity)[order]
    basis = basis.reshape(-1, found.nullity)
    return np.linalg.svd(basis)[0][:, found.nullity :].T


# --- the 3-RSR of the thesis ---------------------------------------------------------------


def test_the_three_rsr_has_the_masses_of_the_table():
    """[J] table 5.4: masses, COM ``c_i = r_i - c_i a_i``, moments about n, along, across."""
    linkage = kinematics.load("three_rsr")
    points = {joint.name: joint for joint in linkage.joints}
    table = {"lower": (1.6, 0.25, (0.5, 0.5, 0.4)), "upper": (0.2, 1.0, (0.6, 0.6, 0.2))}
    for body in linkage.bodies:
        known = mass_properties(body.inertia)
        if body.name == "platform":
            assert known.mass == 0.6 and known.com == pytest.approx([0.0, 0.0, 1.6])
            assert known.inertia == pytest.approx(np.diag([0.3, 0.3, 0.5]))
            continue
        mass, c, moments = table[body.name[:-1]]
        leg = body.name[-1]
        r1, n = points[f"u{leg}"].point, points[f"u{leg}"].screw[:3]
        r3 = points[f"platform{leg}"].point
        bulge = r1 / np.linalg.norm(r1)
        r2 = (r1 + r3) / 2.0 + 0.6 * bulge
        start, end = (r1, r2) if body.name.startswith("lower") else (r2, r3)
        a = end - start
        assert np.linalg.norm(a) == pytest.approx(1.0)
        assert np.linalg.norm(r1) == pytest.approx(3.0)
        assert known.mass == mass and known.com == pytest.approx(start - c * a, abs=1e-12)
        for axis, moment in zip((n, a, np.cross(n, a)), moments, strict=True):
            assert known.inertia @ axis == pytest.approx(moment * axis, abs=1e-12)


@pytest.mark.parametrize("motion", PLANES)
def test_the_three_rsr_is_balanced_on_its_planes_only(motion):
    """[J] table 5.4 and Fig. 5.8: no momentum at random poses, to 1e-9."""
    linkage = kinematics.load("three_rsr")
    assert design_space(linkage, motion).as_given.balanced
    assert not design_space(linkage).as_given.balanced
    rng = np.random.default_rng(1)
    for _ in range(5):
        assert momentum_left(linkage, rng.uniform(-0.3, 0.3, 2), motion) < 1e-9
        assert momentum_left(linkage, rng.uniform(-0.3, 0.3, 3)) > 1e-3


# --- balanced four-bars --------------------------------------------------------------------


@pytest.mark.parametrize("name", DESIGNS)
def test_balanced_four_bars_have_no_momentum_in_any_pose(name):
    """[J] chapter 6. A point mass of 1 % of a link, one length away, is seen."""
    linkage = kinematics.load(name)
    assert design_space(linkage).as_given.balanced
    assert not any(violations(body.inertia) for body in linkage.bodies)
    pivots = {k: v.point for k, v in ((j.name, j) for j in linkage.joints)}
    geometry = kinematics.load(DESIGNS[name])
    assert pivots.keys() == {joint.name for joint in geometry.joints}
    for joint in geometry.joints:
        assert np.array_equal(pivots[joint.name], joint.point)
    rng = np.random.default_rng(2)
    for u in rng.uniform(-0.5, 0.5, (5, 1)):
        assert momentum_left(linkage, u) < 1e-11
        for k, body in enumerate(linkage.bodies):
            extra = sums([0.01 * body.inertia[0]], [[3.0, 2.0, 0.0]])
            bodies = list(linkage.bodies)
            bodies[k] = replace(body, inertia=body.inertia + extra)
            assert momentum_left(replace(linkage, bodies=tuple(bodies)), u) > 1e-6


def test_the_kite_satisfies_the_corrected_equation():
    """[J] Eq. 6.8: its last line needs ``+ m3 c3 (l3 - c3)``; the printed minus unbalances."""
    linkage = kinematics.load("four_bar_kite_balanced")
    o1, o2, o3, o4 = np.array([[0, 0, 0], [0.6, 0.3, 0], [0.72, 0.96, 0], [1, 0, 0]])
    m, c, g, lengths = [], [], [], []
    for body, start, end in zip(linkage.bodies, (o1, o2, o3), (o2, o3, o4), strict=True):
        known, length = mass_properties(body.inertia), np.linalg.norm(end - start)
        along = (end - start) / length
        assert np.linalg.norm(np.cross(known.com - start, along)) < 1e-14
        m.append(known.mass)
        c.append((known.com - start) @ along)
        g.append(known.inertia[2, 2])
        lengths.append(length)
    (m1, m2, m3), (c1, c2, c3), (l1, l2, l3) = m, c, lengths
    assert l1 == pytest.approx(l2) and l3 == pytest.approx(np.linalg.norm(o4 - o1))
    gc1 = g[0] - m1 * c1 * (l1 - c1)
    assert m2 * c2 == pytest.approx(m1 * c1 + m2 * l1, abs=1e-13)
    assert g[1] == pytest.approx(gc1 + m2 * c2 * (l1 - c2), abs=1e-13)
    assert m3 * c3 == pytest.approx(l3 / l1 * (c2 * m2 + l1 * m3), abs=1e-13)
    assert g[2] == pytest.approx(-gc1 + m3 * c3 * (l3 - c3), abs=1e-13)
    crank, coupler, rocker = linkage.bodies
    z = rocker.inertia.copy()
    z[6] += -gc1 - m3 * c3 * (l3 - c3) - g[2]
    printed = replace(linkage, bodies=(crank, coupler, replace(rocker, inertia=z)))
    assert not design_space(printed).as_given.balanced
    assert momentum_left(printed, [0.2]) > 1e-2


# --- the planar 4-RRR ----------------------------------------------------------------------


@pytest.mark.parametrize("geometry", [GENERAL, PAIR, CROSSED, SIDE_BY_SIDE])
def test_the_twelve_conditions_of_the_paper_are_all_of_them(geometry, tmp_path):
    """[W] Eq. 17: twelve independent conditions of 27 parameters, and no others."""
    found = force_space(robot(geometry, tmp_path))
    assert (found.rank, found.nullity) == (12, 15)
    printed = four_rrr.equation_17(geometry.points)
    assert len(printed) == 12
    rows = np.array(list(printed.values()))
    assert outside(rows.T, conditions(found, BODIES).T) < 1e-12
    assert np.linalg.matrix_rank(rows, tol=1e-6) == 12


def test_leg_by_leg_is_the_serial_space(tmp_path):
    """[W] Eqs. 8 to 11: sixteen conditions on 28 unknowns; its solutions open no loop."""
    found = force_space(robot(GENERAL, tmp_path))
    rows = four_rrr.leg_by_leg(GENERAL.points)
    assert rows.shape == (16, 28) and np.linalg.matrix_rank(rows, tol=1e-9) == 16
    solutions = four_rrr.gathered(GENERAL.points) @ np.linalg.svd(rows)[2][16:].T
    assert np.linalg.matrix_rank(solutions, tol=1e-9) == found.serial_nullity == 12
    order = [BODIES.index(name) for name in found.bodies]
    ours = solutions.reshape(9, 3, 12)[order].reshape(27, 12)
    assert max(outside(ours, found.serial), outside(found.serial, ours)) < 1e-12


@pytest.mark.parametrize(
    ("geometry", "rank"),
    [
        (GENERAL, 10),
        (PAIR, 8),
        (CROSSED, 6),
        (SIDE_BY_SIDE, 6),
        ("four_rrr", 10),
        ("four_rrr_pair", 8),
        ("four_rrr_parallel", 6),
    ],
)
def test_conditions_without_rotation_of_the_platform(geometry, rank, tmp_path):
    """[W] Figs. 5a and 5b, and geometries between: 10, 8 and 6 conditions."""
    named = isinstance(geometry, str)
    linkage = kinematics.load(geometry, inputs=LEG) if named else robot(geometry, tmp_path)
    found = force_space(linkage, STRAIGHT)
    assert found.settled and found.rank == rank and found.nullity == 27 - rank
    assert found.kept > 1e-3 and found.dropped < 1e-12
    assert force_space(linkage).rank == 12
    if not named:
        twelve = np.array(list(four_rrr.equation_17(geometry.points).values()))
        assert outside(conditions(found, BODIES).T, twelve.T) < 1e-11


@pytest.mark.parametrize(
    ("geometry", "pairs"),
    [(CROSSED, {"42": "11", "22": "31"}), (SIDE_BY_SIDE, {"41": "11", "21": "31"})],
)
def test_the_eight_conditions_of_the_paper_are_sufficient_not_necessary(
    geometry, pairs, tmp_path
):
    """[W] Eqs. 19 and 21: six combinations of the eight are enough.

    Both pairs of legs carry the same translation, so that the rates of their four links
    obey two relations more, which the paper does not use.
    """
    found = force_space(robot(geometry, tmp_path), STRAIGHT)
    eight = four_rrr.combined(four_rrr.equation_17(geometry.points), pairs)
    assert np.linalg.matrix_rank(eight, tol=1e-6) == len(eight) == 8
    six = conditions(found, BODIES)
    assert outside(six.T, eight.T) < 1e-12
    assert outside(eight.T, six.T) > 0.1


def test_base_links_alone_balance_the_translating_platform():
    """[W] Fig. 6b: rank of the columns of the base links 6 of 6; in general motion 8 of 12.

    Whatever the other bodies weigh, counterweights on the base links are enough.
    """
    linkage = kinematics.load("four_rrr_parallel")
    lower = [name.startswith("lower") for name in (body.name for body in linkage.bodies)]
    for motion, rank, total in ((STRAIGHT, 6, 6), (None, 8, 12)):
        rows = conditions(force_space(linkage, motion)).reshape(total, 9, 3)
        values = np.linalg.svd(rows[:, lower].reshape(total, 12))[1]
        assert (values > 1e-3).sum() == rank and (values[rank:] < 1e-12).all()
    bodies = counterweighted(linkage, lower)
    balanced = replace(linkage, bodies=bodies)
    assert not any(violations(body.inertia) for body in bodies)
    assert force_space(balanced, STRAIGHT).as_given.balanced
    assert not force_space(balanced).as_given.balanced
    assert not force_space(linkage, STRAIGHT).as_given.balanced


def counterweighted(linkage, chosen):
    """Bodies of which the chosen ones get a point mass each, so that forces balance."""
    rows = conditions(force_space(linkage, STRAIGHT)).reshape(6, 9, 3)
    given = np.array([body.inertia[:3] for body in linkage.bodies])
    weight = np.where(chosen, 5.0, 0.0)
    given[:, 0] += weight
    moments = np.linalg.lstsq(
        rows[:, chosen, 1:].reshape(6, 8), -np.einsum("rbp,bp->r", rows, given), rcond=None
    )[0].reshape(-1, 2)
    bodies, places = [], iter(moments / 5.0)
    for body, mass in zip(linkage.bodies, weight, strict=True):
        extra = sums([mass], [[*next(places), 0.0]]) if mass else 0.0
        bodies.append(replace(body, inertia=body.inertia + extra))
    return tuple(bodies)


def test_the_platform_of_the_two_rrr_may_turn_about_its_joint():
    """[W] Fig. 8: force-balanced with rotation if and only if so without it, and with the
    centre of mass of the platform at the joint.
    """
    linkage = kinematics.load("two_rrr")
    points = {joint.name: joint.point for joint in linkage.joints}
    assert np.array_equal(points["a1"], points["a2"])
    assert relative(points["c1"], points["c2"]) < 1e-15
    free, straight = force_space(linkage), force_space(linkage, STRAIGHT)
    assert (free.rank, straight.rank) == (6, 4)
    at_joint = np.zeros((2, 15))
    platform = 3 * free.bodies.index("platform")
    at_joint[:, platform : platform + 3] = np.column_stack([-points["c1"][:2], np.eye(2)])
    assert outside(at_joint.T, conditions(straight).T) > 0.1
    both = np.vstack([conditions(straight), at_joint])
    assert np.linalg.matrix_rank(both, tol=1e-9) == 6
    assert outside(both.T, conditions(free).T) < 1e-12


# --- the document --------------------------------------------------------------------------


def test_the_document_names_tests_that_exist():
    text = DOCUMENT.read_text(encoding="utf-8")
    named = {word for word in text.replace("`", " ").split() if word.startswith("test_")}
    named = {word for word in named if not word.endswith(".py")}
    files = list(ROOT.glob("tests/**/test_*.py"))
    tests = {
        path: set(re.findall(r"(?m)^def (test_\w+)", path.read_text(encoding="utf-8")))
        for path in files
    }
    there = set().union(*tests.values())
    ours = {name for name in globals() if name.startswith("test_")}
    ours = ours.union(*(tests[ROOT / file] for file in REPRODUCING))
    ours.remove("test_the_document_names_tests_that_exist")
    named -= {path.stem for path in files}
    assert named >= ours and named <= there
