"""Verdicts on design spaces; each design and each proof is judged by finite poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from balance import certify, design_space
from balance.checks import check_certificate, check_design
from balance.masses.designs.feasibility import feasible
from balance.motion.verification.verify_motions import verify
from kinematics.closure.assembly.assemble import assemble
from tests.independent import reference
from tests.support.designs import design_of_any_density
from tests.support.drafts import axis_edge, linked
from tests.support.laws import altered, placed, resized
from tests.support.shapes import (
    antiparallelogram,
    arm,
    bennett,
    conditions,
    functional,
    general,
    kite,
    matrix,
    outside,
    quadrilateral,
    spherical,
)

FEASIBLE = [
    ("four_bar_kite", None),
    ("four_bar_antiparallelogram", None),
    ("slider_crank", None),
    ("scissor_three_stage", None),
    ("three_rsr", "u2=u3"),
    ("three_rsr_rational", "u2=u3"),
]
INFEASIBLE = [
    "four_bar_general",
    "four_bar_parallelogram",
    "five_bar",
    "three_rsr",
    "bennett",
    "four_bar_spherical",
    "hprs",
    "rusr",
    "sarrus",
    "goldberg_five_bar",
    "six_bar_watt",
]


def judged(space, reach=0.25):
    """The verdict, after what it rests on was judged by rows of finite poses."""
    found, rows = feasible(space), conditions(space, reach=reach)
    if found.verdict == "feasible":
        assert found.certificate is None and check_design(space, found.z).accepted
        left = rows @ found.z.reshape(-1)
        assert np.abs(left).max() < 1e-12 * np.abs(rows).max() * np.abs(found.z).sum()
        assert min(np.linalg.eigvalsh(matrix(z))[0] for z in found.z) > 0.0
        assert found.margin > 0.0
    elif found.verdict == "infeasible":
        assert found.z is None and found.y is None and found.margin == 0.0
        assert check_certificate(space, found.certificate).accepted
        assert min(np.linalg.eigvalsh(Z)[0] for Z in found.certificate) > -1e-15
        value = functional(space, found.certificate)
        assert np.linalg.norm(value) > 1e-3 and outside(value, rows) < 1e-7
    return found


@pytest.mark.parametrize(("model", "motion"), FEASIBLE)
def test_linkages_that_can_be_balanced(model, motion):
    space = design_space(kinematics.load(model), motion)
    found = judged(space)
    assert found.verdict == "feasible" and found.margin > 1e-4
    mass = sum(body.inertia[0] for body in space.linkage.bodies)
    assert found.z[:, 0].sum() == pytest.approx(mass, rel=1e-12)
    own = space.basis.reshape(len(space.bodies), -1, space.nullity) @ found.y
    assert np.allclose(own[:, 0], found.z[:, 0], rtol=1e-12)


@pytest.mark.parametrize("model", INFEASIBLE)
def test_linkages_that_cannot_be_balanced(model):
    assert judged(design_space(kinematics.load(model))).verdict == "infeasible"


@pytest.mark.parametrize("model", ["four_bar_kite", "four_bar_general", "slider_crank"])
def test_the_plane_decides_for_space(model):
    """Flat matrices of three rows and full ones of four agree, as does a margin's order."""
    linkage = kinematics.load(model)
    flat, full = (feasible(design_space(linkage, spatial=s)) for s in (False, True))
    assert flat.verdict == full.verdict
    assert full.margin <= flat.margin <= 1.2 * full.margin


@pytest.mark.parametrize("seed", range(3))
def test_the_wide_pair_must_be_the_base(seed):
    rng = np.random.default_rng(seed)
    for corners, wide in ((kite(rng), {2, 3}), (antiparallelogram(rng), {0, 2})):
        for base in range(4):
            space = design_space(quadrilateral(corners, base, rng))
            assert space.nullity == 5
            verdict = "feasible" if base in wide else "infeasible"
            assert judged(space).verdict == verdict, base


@pytest.mark.parametrize("seed", range(5))
def test_no_general_four_bar(seed):
    rng = np.random.default_rng(seed)
    assert judged(design_space(quadrilateral(general(rng), 3, rng))).verdict == "infeasible"


@pytest.mark.slow
def test_no_bennett_linkage():
    rng = np.random.default_rng(50)
    for _ in range(50):
        space = design_space(bennett(rng))
        assert (space.rank, space.nullity) == (13, 17)
        assert judged(space).verdict == "infeasible"


def test_no_spherical_linkage():
    rng = np.random.default_rng(20)
    for _ in range(20):
        space = design_space(spherical(rng))
        assert space.nullity == 15
        assert judged(space, reach=0.05).verdict == "infeasible"


@pytest.mark.parametrize("seed", range(6))
def test_no_serial_arm(seed):
    rng = np.random.default_rng(seed)
    assert judged(design_space(arm(rng, 2 + seed % 3))).verdict == "infeasible"


@pytest.mark.parametrize("model", ["five_bar", "four_bar_general", "bennett"])
def test_forces_alone_can_be_balanced(model):
    """Counterweights balance the forces of these; only masses must be positive."""
    linkage = kinematics.load(model)
    space = design_space(linkage, balance="force")
    found = feasible(space)
    assert found.verdict == "feasible" and check_design(space, found.z).accepted
    mechanism = reference.load(model)
    rates = np.eye(len(mechanism.inputs))
    start = np.zeros(len(mechanism.joints))
    for u in np.random.default_rng(1).uniform(-0.3, 0.3, (2, len(rates))):
        q = reference.follow(mechanism, start, u)
        moving = reference.velocities(mechanism, q, rates)
        X = reference.regressor(mechanism, q, moving, "force")
        assert np.abs(X @ found.z[:, :4].reshape(-1)).max() < 1e-11 * np.abs(found.z).max()
    assert min(np.linalg.eigvalsh(matrix(z))[0] for z in found.z) > 0.0


def test_a_sliding_arm_pushes_its_base():
    space = design_space(kinematics.load("hprs"), balance="force")
    assert judged(space).verdict == "infeasible"


@pytest.mark.parametrize(
    ("model", "motion", "entry"), [(*FEASIBLE[0], 8), (*FEASIBLE[0], 3), (*FEASIBLE[4], 1)]
)
def test_designs_do_not_shake_for_pinocchio(model, motion, entry):
    """All six components, also of a planar linkage: Exz or mcz would make moments out of it."""
    linkage = kinematics.load(model)
    z = feasible(design_space(linkage, motion)).z
    found = verify(linkage, z, motion=motion, trajectories=1, samples=20)
    assert found.verdict == "balanced"
    tilted = z.copy()
    tilted[1, entry] += 1e-3
    shaken = verify(linkage, tilted, motion=motion, trajectories=1, samples=20)
    assert shaken.verdict == "not balanced"


@pytest.mark.table
@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(
    ("model", "motion"), [*FEASIBLE[:3], FEASIBLE[4], ("four_bar_general", None)]
)
def test_size_and_place_do_not_matter(model, motion, size, tmp_path):
    """Another unit, and a thousand lengths away: the margin is that of the same linkage."""
    plain = design_space(kinematics.load(model), motion)
    H = np.eye(4)
    H[:3, :3] = Rotation.from_rotvec([0.3, -1.0, 0.5]).as_matrix()
    H[:3, 3] = 1000.0 * size * plain.length * np.array([2.0, -3.0, 6.0]) / 7.0
    path = altered(model, tmp_path, resized(size), placed(H))
    space = design_space(kinematics.load(path), motion)
    known, found = feasible(plain), feasible(space)
    assert found.verdict == known.verdict
    assert found.margin == pytest.approx(known.margin, rel=1e-5)
    if found.z is not None:
        lightest = [design_of_any_density(s, "mass").value for s in (plain, space)]
        assert lightest[1] == pytest.approx(lightest[0], rel=1e-5)
        off = found.z.copy()
        off[0, 0] *= 1.0 + 1e-6
        assert not check_design(space, off).accepted


def test_words_name_who_clashes():
    found = feasible(design_space(kinematics.load("four_bar_general")))
    assert found.words.startswith("infeasible: ")
    assert all(name in found.words for name in ("crank", "coupler", "rocker"))
    assert "\n" not in found.words and "balance the forces alone" in found.words
    slide = feasible(design_space(kinematics.load("hprs"), balance="force")).words
    assert slide.endswith("change the geometry or restrict the motion")


def test_words_say_what_to_ask_less_of():
    """What cannot be balanced anyway is not put down to what is kept."""
    models = ("four_bar_kite", "four_bar_parallelogram")
    kite, none = (design_space(kinematics.load(model)) for model in models)
    words = design_of_any_density(kite, keep=["crank"]).words
    assert "crank, as kept, cannot" in words and words.endswith("; keep fewer links")
    words = design_of_any_density(
        kite, bounds={"crank": (1.0, 1.0), "coupler": (1.0, 1.0)}
    ).words
    assert words.endswith("keep fewer links, or widen the bounds")
    words = design_of_any_density(none, bounds={"crank": (0.1, 9.0)}).words
    assert "change the geometry" in words and "bounds" not in words


@pytest.mark.parametrize(
    ("kind", "pitch", "what"),
    [
        ("revolute", 0.0, "some second moments"),
        ("prismatic", 0.0, "the masses"),
        ("helical", 0.3, "some second moments"),
    ],
)
def test_a_joint_alone_clashes_with_itself(kind, pitch, what):
    """On a hinge all mass would have to be on the axis; on a slide there can be none."""
    rng = np.random.default_rng(0)
    edge = axis_edge(kind, np.array([0.0, 0.6, 0.8]), rng.random(3), (0, 1), "j", pitch)
    found = judged(design_space(assemble(linked([edge], [1], rng))))
    assert found.verdict == "infeasible" and f"{what} of b0 are zero" in found.words


def test_no_masses_at_all_balance_a_hinge_on_a_slide():
    """The space is a point: every matrix that is definite is a certificate."""
    x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    joints = [
        axis_edge("prismatic", x, np.zeros(3), (0, 1), "slide"),
        axis_edge("revolute", z, np.array([0.3, 0.1, 0.0]), (1, 2), "hinge"),
    ]
    space = design_space(assemble(linked(joints, [2], np.random.default_rng(0))))
    assert space.nullity == 0
    found = feasible(space)
    assert found.verdict == "infeasible"
    assert check_certificate(space, found.certificate).accepted
    kept = design_of_any_density(space, bounds={"b0": (1.0, 2.0)})
    assert kept.verdict == "infeasible"


def doubted(model, **changes):
    """A certified space about which something is in doubt."""
    options = {"balance": "force"} if model == "fuga_i" else {}
    space = certify(design_space(kinematics.load(model), **options))
    assert feasible(space).verdict != "undecided"
    certainty = space.certainty._replace(level="estimated", doubts=("in doubt",), **changes)
    return replace(space, certainty=certainty)


def test_a_design_in_a_doubtful_space_is_undecided():
    """Conditions may be missing, and the design may break them."""
    found = feasible(doubted("slider_crank"))
    assert found.verdict == "undecided" and "not all conditions are known" in found.words


def test_a_design_made_of_proved_transfers_stands():
    """Counterweights on the links of an open chain balance its forces."""
    found = feasible(doubted("fuga_i"))
    assert found.verdict == "feasible" and found.residuals.accepted


def test_more_conditions_leave_an_infeasible_space_infeasible():
    assert feasible(doubted("four_bar_general")).verdict == "infeasible"


def test_false_conditions_may_hide_a_design():
    """The rank is above the one that exact arithmetic finds."""
    assert feasible(doubted("four_bar_general", rank=7)).verdict == "undecided"
