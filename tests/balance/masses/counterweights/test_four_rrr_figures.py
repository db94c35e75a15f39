"""The planar 4-RRR with the masses of printed figures: force, moment, counterweights.

[W] the paper on shaking-force balance of the planar 4-RRR parallel manipulator, 13th World
Congress in Mechanism and Machine Science (IFToMM), Guanajuato, 2011, A12-523.
"""

from dataclasses import replace

import numpy as np
import pytest

import balance
import kinematics
from tests.independent import reference
from tests.independent.second_counterweights import certificate_fault
from tests.support import four_rrr
from tests.support.four_rrr import BODIES
from tests.support.points import point_counterweights

STRAIGHT = "c1=-a1-b1"
LEG = ("a1", "b1", "c1")
# Inputs and relations of the platform on a line without rotation, and the other coordinate.
LINES = {
    "x": (LEG, ("b1=-2*a1", "c1=a1"), 1),
    "y": (("a3", "a4", "c1"), ("a3=-a4", "c1=-a4"), 0),
    "y, side by side": (("a1", "a2", "a4"), ("a4=a1", "a2=-a1"), 0),
}
BASE = ("lower1", "lower2", "lower3", "lower4")
PROTOTYPE = ("four_rrr_prototype", STRAIGHT, BASE)
PARALLEL = ("four_rrr_parallel", STRAIGHT, BASE)
SIDE_BY_SIDE = ("four_rrr_side_by_side", STRAIGHT, ("lower1", "upper1", "lower2", "upper2"))


def force_balanced(model, motion=None):
    return balance.design_space(model, motion, "force").as_given.balanced


def printed_equations(model):
    """Terms and conditions of Eq. 17, and ``[m, mcx, mcy]`` of the nine bodies."""
    linkage = kinematics.load(model)
    at = {joint.name: joint.point[:2] for joint in linkage.joints}
    points = tuple(np.array([at[f"{k}{i}"] for i in range(1, 5)]) for k in "abc")
    given = {body.name: body.inertia[:3] for body in linkage.bodies}
    z = np.concatenate([given[name] for name in BODIES])
    return four_rrr.Terms(points), four_rrr.equation_17(points), z


@pytest.mark.parametrize("model, ones", [("in_line", (1, 3)), ("symmetric", ())])
def test_masses_that_balance_forces_in_every_motion(model, ones):
    """[W] Fig. 4: Eq. 17 holds; q is 0 on legs 1 and 3 (a), or on none and symmetric (b)."""
    terms, twelve, z = printed_equations(f"four_rrr_{model}")
    assert np.abs(np.array(list(twelve.values())) @ z).max() < 1e-15
    q = np.array([[terms.link(i, j)[2] @ z for j in (1, 2)] for i in range(1, 5)])
    for i, row in enumerate(np.abs(q), 1):
        assert (row < 1e-15).all() if i in ones else (row > 1e-3).all()
    mirrored = np.array([[1], [-1], [1], [-1]]) * q[0]
    assert np.allclose(q, mirrored, atol=1e-15) == (model == "symmetric")
    assert force_balanced(f"four_rrr_{model}")


def test_masses_that_balance_forces_without_rotation():
    """[W] Figs. 6c and 7: balanced without rotation only; Eq. 21 is not necessary for 6c."""
    _, twelve, z = printed_equations("four_rrr_side_by_side")
    eight = four_rrr.combined(twelve, {"41": "11", "21": "31"})
    assert len(eight) == 8 and np.abs(eight @ z).min() > 0.05
    for model in ("side_by_side", "prototype"):
        assert force_balanced(f"four_rrr_{model}", STRAIGHT)
        assert not force_balanced(f"four_rrr_{model}")


def poses(model, line, reach, count=6):
    """Follow finite motions; the total momentum over the largest of a body, and the platform.

    Yields:
        Relative momentum; displacement ``H`` of the platform.
    """
    inputs, motion, _ = line
    mechanism = reference.load(model, inputs)
    basis = reference.motion_basis(mechanism, motion)
    rng = np.random.default_rng(8)
    for sign in np.resize([1.0, -1.0], count):
        u = basis @ (sign * rng.uniform(0.3, 1.0, basis.shape[1]) * reach)
        q = reference.follow(mechanism, np.zeros(len(mechanism.joints)), u)
        X = reference.regressor(
            mechanism, q, reference.velocities(mechanism, q, basis), spatial=False
        )
        z = mechanism.inertias[:, [0, 1, 2, 6]]
        parts = X.reshape(len(X), *z.shape) * z
        placed = reference.displacements(mechanism, q)[0]
        platform = mechanism.links[mechanism.bodies.index("platform")]
        left = np.abs(parts.sum(axis=(1, 2))).max() / np.abs(parts.sum(axis=2)).max()
        yield left, placed[platform]


@pytest.mark.table(1)
@pytest.mark.parametrize(
    "model, line",
    [
        *((name, line) for name in ("in_line", "symmetric", "prototype") for line in "xy"),
        ("side_by_side", "y, side by side"),
    ],
)
def test_no_moment_on_the_lines_of_symmetry(model, line):
    """[W] section V: no momentum at finite poses of the line, and a moment beside it.

    Without symmetric masses (Fig. 4a) forces vanish there, moments do not.
    """
    inputs, motion, across = LINES[line]
    model, symmetric = f"four_rrr_{model}", model != "in_line"
    for left, H in poses(model, LINES[line], 0.4):
        assert (left < 1e-12) if symmetric else (left > 1e-3)
        assert np.abs(H[:2, :2] - np.eye(2)).max() < 1e-12
        assert abs(H[across, 3]) < 1e-12 and abs(H[1 - across, 3]) > 0.02
    assert min(left for left, _ in poses(model, (LEG, (STRAIGHT,), None), 0.4)) > 0.1
    linkage = kinematics.load(model, inputs=inputs)
    assert balance.design_space(linkage, motion).as_given.balanced == symmetric
    assert force_balanced(linkage, motion)


@pytest.mark.parametrize("body", ["lower3", "upper2"])
def test_moments_vanish_for_equal_moments_of_inertia_only(body):
    """[W] section V asks for equal inertia of the four links of a kind: one that differs."""
    for line in ("x", "y"):
        inputs, motion, _ = LINES[line]
        linkage = kinematics.load("four_rrr_prototype", inputs=inputs)
        extra = 0.01 * (np.arange(10) == 6)
        bodies = [
            replace(one, inertia=one.inertia + extra * (one.name == body))
            for one in linkage.bodies
        ]
        changed = replace(linkage, bodies=tuple(bodies))
        assert not balance.design_space(changed, motion).as_given.balanced
        assert force_balanced(changed, motion)


def without_counterweights(model, links):
    """The linkage with slender rods of 0.5 kg in place of some links of its legs."""
    linkage = kinematics.load(model)
    points = {joint.name: joint.point for joint in linkage.joints}
    bodies = []
    for body in linkage.bodies:
        if body.name in links:
            ends = "ab" if body.name.startswith("lower") else "bc"
            start, end = (points[letter + body.name[-1]] for letter in ends)
            d = end - start
            inertia = 0.5 / 12.0 * (d @ d * np.eye(3) - np.outer(d, d)) + 1e-5 * np.eye(3)
            z = balance.bodies.parameters(0.5, (start + end) / 2.0, inertia)
            body = replace(body, inertia=z)
        bodies.append(body)
    return replace(linkage, bodies=tuple(bodies))


def with_lumps(linkage, weights):
    """The bodies with point masses added at their places in the link frames, all parallel."""
    points = {joint.name: joint.point for joint in linkage.joints}
    lumps = {weight.link: weight.lumps for weight in weights}
    for body in linkage.bodies:
        z = body.inertia
        for lump in lumps.get(body.name, ()):
            letter = "a" if body.name.startswith("lower") else "b"
            at = points[letter + body.name[-1]] + lump.position
            z = z + balance.bodies.parameters(lump.mass, at, np.zeros((3, 3)))
        yield replace(body, inertia=z)


def asked(case, links, rotates=False):
    """Answer whether matter on the links alone cancels the shaking force, checked."""
    model, motion, heavy = case
    linkage = without_counterweights(model, heavy)
    space = balance.design_space(linkage, None if rotates else motion, balance="force")
    assert not space.as_given.balanced
    found = point_counterweights(space, links, relax=False)
    if found.verdict == "infeasible":
        assert certificate_fault(found, np.random.default_rng(0)) == ""
    else:
        heavier = replace(linkage, bodies=tuple(with_lumps(linkage, found.weights)))
        assert balance.design_space(heavier, motion, balance="force").as_given.balanced
    return found.verdict


@pytest.mark.parametrize("case", [PROTOTYPE, PARALLEL])
def test_three_of_four_base_links_are_enough(case):
    """[W] Figs. 6b and 7: counterweights on the base links; any three balance as well."""
    assert asked(case, BASE) == "feasible"
    assert asked(case, BASE, rotates=True) == "infeasible"
    for k in range(4):
        assert asked(case, BASE[:k] + BASE[k + 1 :]) == "feasible"
    assert asked(case, ("lower1", "lower2")) == "infeasible"


def test_side_by_side_legs_need_a_counterweight_off_the_base():
    """[W] Fig. 6c: one for each of four sets of parallel links; three of the sets do."""
    heavy = SIDE_BY_SIDE[2]
    assert asked(SIDE_BY_SIDE, heavy) == "feasible"
    assert asked(SIDE_BY_SIDE, heavy, rotates=True) == "infeasible"
    for links in (("lower1", "lower2", "upper1"), ("lower3", "lower4", "upper3")):
        assert asked(SIDE_BY_SIDE, links) == "feasible"
    assert asked(SIDE_BY_SIDE, ("lower1", "upper1", "upper2")) == "infeasible"
    assert asked(SIDE_BY_SIDE, BASE) == "infeasible"
