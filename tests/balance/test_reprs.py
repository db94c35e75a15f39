"""What Python prints of a result: one to six lines in words, and no array."""

from __future__ import annotations

import inspect
from xml.etree import ElementTree

import numpy as np
import pytest

import balance
import kinematics
from balance.motion.taylor_poses.prediction import Predictions, predict
from balance.space.spaces.save import record_of
from kinematics.closure.assembly.tool_frame import tool
from kinematics.model.spatial.screws import twist_axis
from tests.support.laws import coordinates
from tests.support.source_files import FACES, public_names


def results_of_poses_and_bases(linkage, space):
    """Those of balance in one pose, paths, floating bases and pure inertias."""
    pose = balance.pose.balance_pose(linkage, {"crank": 1.0})
    answers = balance.motion_modes(linkage)
    paths = balance.find_paths("principal_vector_linkage", length=0.1)
    base = balance.motion.FloatingBase(3, 1)
    pure = balance.masses.pure_inertia(space)
    springs = balance.springs(linkage, "base,coupler", gravity=(0, -9.81, 0))
    load = balance.masses.read_payload("coupler=0:0.5")
    force = balance.design_space("four_bar_general", balance="force")
    movable = balance.masses.movable_weights(
        force, "four_bar_general", load, ["crank", "rocker"]
    )
    return [
        (load, "0 to 0.5 kg at coupler"),
        (movable, "kg that move with the load"),
        (movable.weights[0], "kg"),
        (answers, "1 mode of"),
        (answers.modes[0], "mode 1: mobility 1, nullity 5, feasible"),
        (pose, "crank cannot balance"),
        (pose.families["crank"], "5 free parameters"),
        (balance.pose.momentum_map(linkage, {"u1": [0, 0.1]}), "2 poses reached"),
        (balance.pose.reaction_null_space("five_bar", [0.1, 0.1]), "0 of 2 rates"),
        (paths, "2 paths through 1 pose"),
        (paths.paths[0], "of the bodies' own"),
        (
            balance.motion.inertia_chart(
                "five_bar", "left_lower", [2.0], kept="moment", length=0.02
            ),
            "1 path for 1 factor",
        ),
        (
            balance.motion.PathMoments(
                linkage, {"crank": 2.0}, paths.paths[0].u, 0.0, "", paths.paths[0].u, "all"
            ),
            "crank 2",
        ),
        (base, "inertia=1"),
        (springs, "infeasible: no stiffness"),
        (springs.springs[0], "N/m, base at"),
        (springs.springs[0].ends[0], "base at"),
        (balance.quiet_motion(linkage, {}, {"u1": 0.2}, 1.0), "in 1 s"),
        (balance.space.decoupling(space), "no: not balanced"),
        (pure, "0.5 kg stays"),
        (balance.masses.buildable_masses(space, 0.0 * pure.inertias), "feasible"),
        (balance.motion.simulate_floating_base(linkage, base, duration=0.05), "the base moves"),
    ]


def results_of_beams(linkage):
    """Those of links that bend."""
    beam = balance.flexible.Beam(0.1, 0.0045, 0.024)
    arm = balance.flexible.Arm(beam, 0.01)
    other = balance.flexible.Arm(balance.flexible.Beam(0.05, 1e-3, 0.01, 1e6, 1e6), 0.02)
    pin = balance.flexible.Support((0.0,))
    bends = ["coupler=EI:1,rhoA:1"]
    return [
        (beam, "EI 0.0045"),
        (other.beam, "EA 1e+06 N"),
        (arm, "tip of 0.01 kg"),
        (balance.flexible.compare_arms(arm, other), "not similar: 6, 8"),
        (balance.flexible.free_modes(40)[-1], " …"),
        (balance.flexible.support_points(4), "4 points"),
        (balance.flexible.supported_modes(beam, [pin], 9), "9 modes"),
        (pin, "weights=(1.0,)"),
        (balance.flexible.Clamp(0.0), "point=0.0"),
        (balance.flexible.Section(1e-3, 0.01), "width=0.01"),
        (balance.flexible.EndBody(1.0), "mass=1.0"),
        (
            balance.flexible.simulate_flexible(linkage, bends, duration=0.01, samples=3),
            "bends: coupler",
        ),
    ]


def results_of_kinematics(linkage, motion):
    """Those of the package below."""
    return [
        (linkage, "four_bar_antiparallelogram: 3 bodies, 4 joints, 1 loop"),
        (linkage.joints[0], "u1: revolute"),
        (linkage.bodies[0], "crank: "),
        (linkage.loops[0], "welded to"),
        (linkage.chain, "planar, 4 joints, 1 loop"),
        (linkage.chain.frame, "length"),
        (next(iter(linkage.places.values())), "origin"),
        (kinematics.Motion.free(["u1", "u2"]), "2 free"),
        (kinematics.Motion.parse("a=b", ["a", "b"]), "a=b"),
        (kinematics.Notice("code", "text"), "code"),
        (kinematics.ScrewJoint("j", "base", "arm"), "revolute from base to arm"),
        (motion, "order 3"),
        (kinematics.taylor_motion_many(linkage, [[0.0] * 4], 3), "1 pose, order 3"),
        (twist_axis(linkage.joints[1].screw), "pitch 0 m"),
    ]


def results_of_measurements():
    """Those of identification."""
    plan = balance.masses.exciting_motion("four_bar_general", 2.0, tries=1)
    run = balance.verify("four_bar_general", motions=[plan.trajectory]).runs[0]
    names = ("mx", "my", "mz", "fx", "fy", "fz")
    columns = dict(zip(names, -run.shaking.T, strict=True))
    found = balance.identify(
        "four_bar_general",
        plan.trajectory,
        {"time": plan.trajectory.time, **columns},
        gravity=(0.0, 0.0, 0.0),
    )
    spread = balance.motion.shaking_tolerance("four_bar_general", mass=0.02, draws=20)
    return [
        (spread, "worst case: peak force"),
        (plan, "best of 1 motions with seed 0"),
        (found, "identified: all 8 combinations"),
        (found.combinations[0], "±"),
        (found.masses[0], "kg"),
        (found.recordings[0], "401 samples, 2 s"),
    ]


def results_of_masses(space, none):
    """Those of designs, counterweights, remedies and synthesis."""
    design = balance.design(space)
    force = balance.design_space("four_bar_general", balance="force")
    added = balance.counterweights(force, ["crank", "rocker"])
    front = balance.pareto("four_bar_general", ["crank"], 2, 1.0)
    remedies = balance.compare_remedies("four_bar_general", ["own_masses", "partial"])
    rotors = balance.masses.fewest_rotors(none)
    places = [(0.3, 0.1, 0.2), (0.1, 0.4, -0.7)]
    synthesis = balance.synthesize(places, -0.5, moving=0.2 - 0.1j)
    return [
        (design, "feasible"),
        (design.residuals, "accepted"),
        (balance.masses.feasible(space), "feasible"),
        (balance.masses.feasible(none), "infeasible"),
        (balance.masses.feasible(none).residuals, "accepted, eigenvalue"),
        (added, "kg added to 2 kg balance it"),
        (added.weights[0].region, "ball"),
        (front, "four_bar_general"),
        (front.designs[0], "of the shaking in the file"),
        (balance.masses.ElasticFrame(9, 1, 9, 1), "9"),
        (remedies, "infeasible: own_masses"),
        (balance.formulas("four_bar_general", "force"), "l_crank m_coupler = 0"),
        (remedies.results[1], "kg added, input inertia"),
        (rotors, "2"),
        (rotors.sets[0], "u1"),
        (synthesis, "feasible: 1 mechanism"),
        (
            balance.studies.linkage_from_sketch("A=0,0; B=1,0", "base=A; arm=A,B"),
            "arm A-B: 1000",
        ),
        (synthesis.mechanisms[0], "confirmed"),
        (balance.studies.FourBarPlatform(), "3 legs"),
        (balance.studies.PantographMasses(*[0.5] * 13), "3 kg"),
        (balance.studies.StackedChains(), "11 kg"),
        (balance.studies.StackedFourBar(), "antiparallelogram, crank and base 0.2 and 0.6 m"),
        (balance.studies.ParallelepipedPlatform(), "6 freedoms"),
        (balance.studies.PrincipalVectors((0j,), (-1j, 1 + 0j)), "2 elements, 2 rods"),
    ]


def results():
    """An instance of every class of results, and words that its repr must hold."""
    linkage = kinematics.load("four_bar_antiparallelogram")
    open_space = balance.design_space(linkage)
    space = balance.certify(open_space)
    none = balance.certify(balance.design_space("four_bar_general"))
    explained = balance.explain(space)
    required = balance.require(linkage, "force; gravity")
    verification = balance.verify(linkage, trajectories=1, samples=20)
    lines = balance.momentum.momentum_lines(linkage, [0.2])[0]
    motion = kinematics.taylor_motion(linkage, 3)
    taylor = balance.momentum.momentum_taylor(linkage, 2)
    screws = np.array([[joint.screw for joint in linkage.joints]])
    poses = (predict(motion, [0.1]),)
    varied = {"coupler.length": [0.9, 0.95]}
    study = balance.studies.Study.from_tables({"parameters": varied}, linkage)
    return [
        (study, "2 geometries"),
        (balance.sweep(linkage, varied), "columns coupler.length"),
        *results_of_poses_and_bases(linkage, space),
        *results_of_beams(linkage),
        *results_of_kinematics(linkage, motion),
        *results_of_masses(space, none),
        *results_of_measurements(),
        (space, "rank 7 of 12 planar parameters"),
        (space, "verified: balanced at"),
        (space, "ranks by order 3, 6, 7"),
        (required, "force; gravity"),
        (balance.motion.verify_against(verification, verification), "Shaking force"),
        (balance.masses.least_violation(required, ["crank"], 0.1), "costs most"),
        (record_of(space), "nullity 5 = 4 serial + 1 par"),
        (open_space, "estimated: by floating-point arithmetic alone"),
        (space.certainty, "verified"),
        (none.certainty.proof, "rank=8"),
        (none.certainty.proof.chain, "4 joints"),
        (none.certainty.proof.witness, "8 pivots"),
        (balance.checks.exact_ranks(space), "rank 7 of 12 parameters, settled"),
        (explained, "4 transfers, 1"),
        (explained.transfers[0], "a point mass"),
        (explained.freedoms[0], "rod +1 on the cr"),
        (explained.freedoms[0].primitives[0], "+1 kg m² rod on crank"),
        (space.transfers[0], "across u1 (ground, crank): 1 independent"),
        (space.bodies_of(coordinates(space))[0], "crank: "),
        (balance.bodies.mass_properties(linkage.bodies[0].inertia), "kg m²"),
        (balance.bodies.multipole_of(linkage.bodies[0].inertia, [0, 0, 0]), "6 rods"),
        (balance.space.design_space_many(linkage, screws), "1 geometry, planar, dynamic"),
        (taylor, "order 2 in u1, 3 rows of 12 parameters"),
        (lines[0], "of crank: "),
        (balance.momentum.meeting(lines), "missed by"),
        (verification, "not balanced"),
        (verification.runs[0], "20 samples"),
        (verification.runs[0].trajectory, "over 1 s"),
        (Predictions(motion, None, True, poses, ()), "1 pose, 1 reached"),
        (poses[0], "reached, true error"),
    ]


@pytest.fixture(scope="module")
def instances():
    return results()


@pytest.mark.slow
def test_every_public_class_has_a_short_repr(instances):
    """Six lines of 100 characters at most, which name the class and say what matters."""
    for item, words in instances:
        text = repr(item)
        lines = text.splitlines()
        assert 1 <= len(lines) <= 6 and max(map(len, lines)) <= 100, text
        assert "array(" not in text and "object at" not in text, text
        assert words in text and text.startswith(type(item).__name__), text


@pytest.mark.slow
def test_notebooks_show_a_table_of_sweeps_fronts_motions_and_paths(instances):
    """One table each, of texts of the answer."""
    shown = {
        "SweepTable": ("coupler.length", "0.9 to 0.95 m"),
        "ParetoFront": ("kg", "Shaking force"),
        "QuietMotion": ("shaking moment", "N m"),
        "ReactionlessPaths": ("path 2", "of the bodies"),
    }
    for item, _ in instances:
        words = shown.pop(type(item).__name__, ())
        if words:
            table = ElementTree.fromstring(item._repr_html_())
            assert table.tag == "table" and len(table.findall(".//tr")) > 1
            assert all(word in "".join(table.itertext()) for word in words)
    assert not shown


@pytest.mark.slow
def test_no_public_class_is_left_out(instances):
    public = {
        value
        for face in FACES
        for value in public_names(face).values()
        if inspect.isclass(value)
    }
    assert len(public) > 25
    assert not {value.__name__ for value in public - {type(item) for item, _ in instances}}


@pytest.mark.slow
@pytest.mark.parametrize("model", ["delta", "stewart_6ups", "three_rsr", "hprs"])
def test_large_linkages_are_as_short(model):
    linkage = kinematics.load(model)
    space = balance.design_space(linkage, max_order=0)
    for item in (linkage, linkage.chain, linkage.spatial_chain, space, balance.explain(space)):
        text = repr(item)
        assert len(text.splitlines()) <= 6 and len(text) < 500, text
    if model == "hprs":
        last = linkage.bodies[-1].name
        assert len(repr(tool(linkage, last, "x")).splitlines()) == 4
