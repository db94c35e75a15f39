"""The fewest counter-rotations: known numbers, brute force over all sets, checked proofs."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

import balance
import kinematics
from balance.masses.designs.pseudo_inertia_cone import cone_of_columns
from balance.masses.remedies.counter_rotations.counter_rotors import rotor_conditions
from balance.masses.remedies.counter_rotations.fewest_rotors import (
    fewest_rotors,
    own_inertia,
    search_sets,
)
from balance.masses.remedies.counter_rotations.rotor_sets import (
    RotorCertificate,
    RotorDesign,
    check_rotor_certificate,
    check_rotor_design,
    decide_rotors,
)
from balance.space.inertial_parameters.conversions import basis_from_chain
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic
from benchmarks.inputs.geometry import two_loops
from kinematics import ScrewJoint, from_screws
from kinematics.model.document.element import Document
from kinematics.model.spatial.inertia import parameters
from tests.support.covering import number_of_cases

Z = (0.0, 0.0, 1.0)
ROD = (1.0, np.diag([1e-3, 1.0 / 12.0, 1.0 / 12.0]))

# The fewest counter-rotations of the infeasible models of the gallery; None: no set does.
FEWEST = {
    "bennett": 1, "bennett_rational": 1, "delta": None, "eight_bar": 4, "five_bar": 3,
    "four_bar_chain": 6, "four_bar_general": 2, "four_bar_parallelogram": 1,
    "four_bar_spherical": 2, "four_rrr": 6, "fuga_i": 3, "goldberg_five_bar": 2, "hprs": None,
    "pantograph": 2, "rusr": None, "sarrus": 3, "six_bar_stephenson": 3, "six_bar_watt": 3,
    "stewart_6ups": None, "three_rrr": 5, "three_rsr": None, "two_rrr": 3,
}  # fmt: skip


def arm(axes, points):
    """A serial arm of rods of 1 kg with these axes and joints."""
    names = ["base", *(f"L{k + 1}" for k in range(len(axes)))]
    joints = [
        ScrewJoint(f"j{k + 1}", names[k], names[k + 1], axis=axis, point=point)
        for k, (axis, point) in enumerate(zip(axes, points, strict=True))
    ]
    middles = {name: np.add(p, (0.5, 0, 0)) for name, p in zip(names[1:], points, strict=True)}
    bodies = {name: (ROD[0], at, ROD[1]) for name, at in middles.items()}
    return from_screws(joints, bodies=bodies)


def test_arms_need_a_rotor_on_every_joint():
    """Each joint can turn alone, with positive inertia about its axis."""
    flat = arm([Z, Z], [(0, 0, 0), (1, 0, 0)])
    assert fewest_rotors(balance.design_space(flat)).sets[0].joints == ("j1", "j2")
    spatial = arm([Z, (0, 1, 0), (0, 1, 0)], [(0, 0, 0), (0, 0, 0.5), (1, 0, 0.5)])
    found = fewest_rotors(balance.design_space(spatial))
    assert (found.count, len(found.sets)) == (3, 1)


@pytest.mark.table(1)
@pytest.mark.parametrize("model", FEWEST)
def test_fewest_of_the_gallery(model):
    """Every infeasible model names its fewest, or a certificate excludes all of them."""
    space = balance.certify(balance.design_space(model))
    found = fewest_rotors(space)
    assert found.count == FEWEST[model], found
    assert found.verdict == ("infeasible" if found.count is None else "feasible")
    assert all(
        check_rotor_certificate(found.conditions, x).accepted for x in found.certificates
    )
    if found.count is None:
        assert found.certificates[0].excluded.all()
    else:
        fewer = combinations(range(len(found.candidates)), found.count - 1)
        excluded = [proof.excluded for proof in found.certificates]
        assert all(any(mask[list(one)].all() for mask in excluded) for one in fewer)


@pytest.mark.parametrize("model", ["four_bar_general", "bennett", "sarrus"])
def test_designs_have_no_momentum_with_discs_on_joints_that_follow(model):
    """At finite poses of linkages with one more body; discs of fixed axes on the ground."""
    linkage, gear = kinematics.load(model), 2.5
    space = balance.design_space(linkage, spatial=True)
    conditions = rotor_conditions(space, gear=gear)
    design = decide_rotors(conditions, range(len(conditions.joints)))
    assert isinstance(design, RotorDesign) and design.J.any()
    rng = np.random.default_rng(3)
    q = {u: rng.uniform(-0.2, 0.2) for u in linkage.inputs}
    own = balance.momentum.momentum_regressor(linkage, q, spatial=True)
    z = basis_from_chain(design.z[:, None], space.chain.frame, False, False)[:, 0]
    h, parts = own @ z, np.abs(own) @ np.abs(z)
    by_body = own.reshape(*own.shape[:2], -1, 10)
    for name, momentum in zip(conditions.joints, design.J * space.length**2, strict=True):
        joint = linkage.joints[linkage.positions_of([name])[0]]
        n, axial = joint.screw[:3], momentum / gear
        disc = axial * (np.outer(n, n) + np.eye(3)) / 2.0
        X = balance.momentum.momentum_regressor(
            with_rotor(linkage, name, gear), q, spatial=True
        )
        rotor = X.reshape(*X.shape[:2], -1, 10)[:, :, -1]
        h = h + rotor @ parameters(0.0, joint.point, disc)
        if joint.parent >= 0 and turns_about_a_fixed_axis(linkage, joint):
            carrier = [body.link for body in linkage.bodies].index(joint.parent)
            h = h - by_body[:, :, carrier] @ parameters(0.0, joint.point, disc)
    assert np.abs(h).max() <= 1e-12 * parts.max()


def turns_about_a_fixed_axis(linkage, joint):
    """Whether every joint before it has a parallel axis."""
    before, found = joint.parent, True
    while before >= 0:
        axis = linkage.joints[before].screw[:3]
        found &= bool(np.abs(np.cross(axis, joint.screw[:3])).max() < 1e-12)
        before = linkage.joints[before].parent
    return found


def with_rotor(linkage, name, gear):
    """The linkage read again from its text, with a rotor that follows one joint."""
    j = int(linkage.positions_of([name])[0])
    joint = linkage.joints[j]
    links = {body.link: (body.name, body.frame) for body in linkage.bodies}
    carrier, frame = links.get(joint.parent, ("base", np.eye(4)))
    at = np.linalg.solve(frame, [*joint.point, 1.0])[:3]
    axis = np.linalg.solve(frame[:3, :3], joint.screw[:3])
    if joint.parent < 0:
        carrier = next(link for link, place in linkage.places.items() if place.link < 0)
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
    more = (
        f'<link name="rotor">{inertial} iyz="0"/></inertial></link>'
        f'<joint name="spin" type="continuous"><parent link="{carrier}"/><child link="rotor"/>'
        f'<origin xyz="{" ".join(map(repr, map(float, at)))}"/>'
        f'<axis xyz="{" ".join(map(repr, map(float, axis)))}"/>'
        f'<mimic joint="{name}" multiplier="{-gear}"/></joint></robot>'
    )
    text = linkage.to_urdf().replace("</robot>", more)
    return kinematics.load(Document("rotor", text.encode()), None, linkage.inputs)


def six_candidates(seed, kind):
    """A random linkage with six revolute joints in its tree: trees and loops."""
    rng = np.random.default_rng([seed, 7])
    flat = kind.startswith("planar")

    def point():
        x = np.round(rng.uniform(-1.0, 1.0, 3), 2)
        return (x[0], x[1], 0.0 if flat else x[2])

    def axis():
        return Z if flat else tuple(np.round(rng.uniform(-1.0, 1.0, 3), 1) + (0, 0, 0.05))

    parents = [rng.integers(0, k + 1) if kind.endswith("tree") else k for k in range(6)]
    if kind.endswith("arms"):
        parents = [0, 1, 0, *rng.integers(1, 4, 3)]
    joints = [
        ScrewJoint(f"j{k + 1}", f"L{parents[k]}", f"L{k + 1}", axis=axis(), point=point())
        for k in range(6)
    ]
    loops = []
    if kind.endswith("loop"):
        loops = [ScrewJoint("end", "L6", "L0", axis=axis(), point=point())]
    if kind.endswith("arms"):
        loops = [ScrewJoint("end", "L2", "L3", axis=axis(), point=point())]
    return from_screws(joints, loops)


@pytest.mark.table(1)
@pytest.mark.parametrize("seed", range(number_of_cases(1, 3)))
@pytest.mark.parametrize(
    "kind", ["planar tree", "planar loop", "planar arms", "spatial tree", "spatial loop"]
)
def test_pruned_search_against_all_64_sets(kind, seed):
    """Every set has the verdict of a program of its own in other variables."""
    space = balance.design_space(six_candidates(seed, kind))
    conditions = rotor_conditions(space)
    assert len(conditions.joints) == 6
    search = search_sets(conditions)
    assert search.programs <= 64 and not search.open
    for size in range(7):
        for chosen in combinations(range(6), size):
            assert search.feasible(chosen) == by_brute_force(conditions, chosen), chosen


def by_brute_force(conditions, chosen):
    """Maximise the margin over all parameters, with the conditions as equations."""
    A = np.column_stack([conditions.bodies, conditions.rotors[:, list(chosen)]])
    p, n = conditions.bodies.shape[1], A.shape[1]
    cone = cone_of_columns(conditions.space, np.eye(p))
    count, s = len(cone.blocks), len(chosen)
    unit = np.tile(cone.rows(np.eye(cone.size)), count)
    rows = np.zeros((len(A) + unit.size + s + 1, n + 1))
    rows[: len(A), :n] = A
    rows[len(A) : len(A) + unit.size, :p] = cone.stack_rows(cone.blocks)
    rows[len(A) : len(A) + unit.size, n] = -unit
    rows[len(A) + unit.size : -1, p:n] = np.eye(s)
    rows[-1, :p], rows[-1, p:n] = -np.einsum("bnii->n", cone.blocks), -1.0
    offset = np.append(np.zeros(len(rows) - 1), 1.0)
    parts = [ConstraintBlock("zero", len(A)), *[cone.part] * count]
    parts.append(ConstraintBlock("nonnegative", s + 1))
    found = solve_conic(-np.eye(n + 1)[n], rows, offset, parts)
    return bool(found.x[n] > 1e-7)


def test_changed_proofs_are_rejected():
    """One digit of a weight, a joint more, a body that sinks: each fails its check."""
    conditions = rotor_conditions(balance.design_space("four_bar_general"))
    proof = decide_rotors(conditions, [0])
    design = decide_rotors(conditions, [0, 2])
    assert isinstance(proof, RotorCertificate) and isinstance(design, RotorDesign)
    weights = proof.weights.copy()
    weights[np.argmax(np.abs(weights))] *= 1.0 + 1e-9
    assert not check_rotor_certificate(conditions, proof._replace(weights=weights)).accepted
    every = np.ones(3, dtype=bool)
    assert not check_rotor_certificate(conditions, proof._replace(excluded=every)).accepted
    assert not check_rotor_certificate(
        conditions, proof._replace(matrices=-proof.matrices)
    ).accepted
    assert check_rotor_design(conditions, design)
    assert not check_rotor_design(conditions, design._replace(J=design.J * (1.0 + 1e-9)))
    assert not check_rotor_design(conditions, RotorDesign(-design.z, -design.J))


def test_all_sets_of_twelve_candidates_are_decided():
    """Two loops of seven links: 4096 sets, progress up to the last, a program for few of them.

    The benchmark ``fewest_rotors_of_twelve`` measures the time.
    """
    conditions = rotor_conditions(balance.design_space(two_loops(7, seed=5)))
    seen = []
    found = search_sets(conditions, lambda done, total: seen.append((done, total)))
    assert len(conditions.joints) == 12 and seen[-1] == (4096, 4096)
    assert min(map(len, found.minimal)) == 10 and not found.open
    assert found.programs < 4096 // 8


def test_least_momentum_of_a_pendulum():
    """A counterweight at r has the mass k / r and the inertia k r; its mass costs L² / 100."""
    linkage = arm([Z], [(0.0, 0.0, 0.0)])
    space = balance.design_space(linkage)
    found = fewest_rotors(space)
    k, price = 0.5, 0.01 * space.length**2
    momentum = 1.0 / 3.0 + k * np.sqrt(price)  # least k r + price k / r
    # Momentum and price together are least to 1e-10, each of them to the square root of that.
    assert found.sets[0].momenta[0] == pytest.approx(momentum, rel=1e-5)
    assert own_inertia(space) == pytest.approx(1.0 / 12.0)
    assert found.sets[0].ratio == pytest.approx(12.0 * momentum, rel=1e-5)


def test_a_feasible_linkage_needs_none_and_force_balance_is_refused():
    """Sets of no joint; a space of force balance has no moments."""
    found = fewest_rotors(balance.design_space("slider_crank"))
    assert (found.verdict, found.count, found.sets[0].joints) == ("feasible", 0, ())
    with pytest.raises(ValueError, match="dynamic balance"):
        fewest_rotors(balance.design_space("five_bar", balance="force"))
