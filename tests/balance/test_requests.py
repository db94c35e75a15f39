"""What is asked of a linkage must fit it: motions, inputs, orders, rounded angles."""

from __future__ import annotations

import inspect
import re

import numpy as np
import pytest

import balance
import kinematics
from balance import design_space
from balance.app.answers.text.report import report_facts
from kinematics import Motion
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import CoordinateError, FileError, MotionError, PoseError, UsageError
from tests.support.covering import spread
from tests.support.laws import altered
from tests.support.source_files import FACES, public_names
from tests.support.urdf_text import UNIT_INERTIA, joint, link, saved


def test_one_relation_may_come_without_a_list():
    linkage = kinematics.load("three_rsr")
    assert design_space(linkage, "u2=u3").rank == design_space(linkage, ["u2=u3"]).rank == 35


def test_links_and_budgets_may_be_texts():
    """As on the command line: names parted by commas, ``all``, and masses with a unit."""
    space = design_space("four_bar_general", balance="force")
    named = balance.counterweights(space, "crank, rocker", density=None)
    listed = balance.counterweights(space, ["crank", "rocker"], density=None)
    assert named.added_mass == listed.added_mass
    assert set(balance.counterweights(space, "all", density=None).regions) == {*space.bodies}
    some = [balance.partial(space, "crank", mass, density=None) for mass in (0.2, "200g")]
    assert some[0].mass == some[1].mass > 0.0
    with pytest.raises(UsageError, match="'m' is a unit of length: write mass in kg"):
        balance.partial(space, "crank", "0.2m")


def test_a_motion_over_time_is_no_relation_of_inputs():
    turn = balance.motion.one_turn("four_bar_general", "300rpm")
    with pytest.raises(
        UsageError, match="a relation of inputs.*not a Trajectory: .* as motions"
    ):
        balance.partial("four_bar_general", "crank", 0.2, motion=turn)


@pytest.mark.parametrize(
    ("motion", "problem"),
    [
        (Motion(("u1",), (), np.eye(1)), "made for the inputs u1"),
        (Motion(("zz", "u1", "u2"), (), np.eye(3)), "made for the inputs zz, u1, u2"),
        (Motion(("u1", "u2", "u3"), (), np.ones((3, 2))), "must be independent"),
        (Motion(("u1", "u2", "u3"), (), np.full((3, 1), np.nan)), "finite numbers"),
        (Motion(("u1", "u2", "u3"), (), np.ones((2, 1))), "3 rows"),
    ],
)
def test_a_motion_of_another_linkage_is_refused(motion, problem):
    linkage = kinematics.load("three_rsr")
    with pytest.raises(MotionError, match=problem) as caught:
        design_space(linkage, motion)
    assert linkage.source in str(caught.value)


def test_a_motion_may_list_the_inputs_in_any_order():
    linkage = kinematics.load("three_rsr")
    basis = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0]])
    assert design_space(linkage, Motion(("u3", "u1", "u2"), (), basis)).rank == 35


def test_relations_name_the_file_when_they_are_wrong():
    linkage = kinematics.load("four_bar_kite")
    with pytest.raises(MotionError, match="q9") as caught:
        design_space(linkage, "q9=0")
    assert str(caught.value).startswith(linkage.source)


@pytest.mark.parametrize("order", [-1, 2.5, 51, "3"])
def test_an_order_is_a_small_whole_number(order):
    with pytest.raises(ValueError, match="from 0 to 50"):
        design_space(kinematics.load("four_bar_kite"), max_order=order)


def test_a_truncated_answer_says_so():
    linkage = kinematics.load("four_bar_kite")
    told = [
        dict(report_facts(design_space(linkage, max_order=k)))["conditions"] for k in (0, 4)
    ]
    assert told == ["3, up to order 0: not complete", "7, complete at order 2"]


def test_a_number_that_is_also_a_name_is_refused():
    with pytest.raises(MotionError, match=r"1\*0"):
        Motion.parse("1=0", ["0", "1"])
    assert Motion.parse("1=1*0", ["0", "1"]).basis.shape == (2, 1)


def test_a_joint_of_several_coordinates_stands_for_all_of_them():
    with pytest.raises(CoordinateError, match=r"elbow2\.2: stands still"):
        kinematics.load("three_rsr", inputs=["elbow2"])


def dotted(robot):
    """The change that calls joints and loops as if they were the degrees of one joint."""
    for k, item in enumerate(robot.findall("joint") + robot.findall("loop")):
        item.set("name", f"a.{k}")


def test_dots_in_the_names_of_joints_do_not_change_the_words(tmp_path):
    """Else all five joints would go by the name a."""
    linkages = [kinematics.load(m) for m in ("five_bar", altered("five_bar", tmp_path, dotted))]
    names = dict(zip(*([joint.name for joint in x.joints] for x in linkages), strict=True))
    plain, found = (balance.explain(design_space(x, balance="force")) for x in linkages)
    words = [f.words for f in plain.freedoms] + [t.title for t in plain.transfers]
    assert sum("-" in text for text in words) > 0
    expected = [re.sub(r"[uq]\d", lambda name: names[name[0]], text) for text in words]
    assert [f.words for f in found.freedoms] + [t.title for t in found.transfers] == expected


def test_a_dot_does_not_make_a_joint_part_of_another(tmp_path):
    parts = [link(name, **UNIT_INERTIA) for name in "xyz"]
    parts += [joint("a", "universal", "ground", "x"), joint("a.b", "revolute", "x", "y")]
    parts += [joint("c.b", "revolute", "y", "z", marks='independent="true"')]
    path = saved(tmp_path, link("ground"), *parts)
    inputs = ["a", "c.b", "a.b"]
    assert kinematics.load(path, inputs=inputs).inputs == ("a.0", "a.1", "c.b", "a.b")
    with pytest.raises(CoordinateError, match="input c: no such joint"):
        kinematics.load(path, inputs=["c"])
    titles = [t.title for t in balance.explain(design_space(kinematics.load(path))).transfers]
    assert titles == ["a (ground, x)", "a.b (x, y)", "c.b (y, z)"]


def test_positions_must_be_finite():
    with pytest.raises(PoseError, match="finite"):
        joint_positions(kinematics.load("four_bar_kite"), [np.nan])


def test_rounded_angles_are_told(tmp_path):
    def rounded(robot):
        for item in robot.findall("joint")[1:]:
            if item.get("name") == "q2":
                item.find("origin").set("rpy", "1.5708 0 0")
                item.find("axis").set("xyz", "0 1 0")
        for loop in robot.findall("loop"):
            robot.remove(loop)

    path = altered("four_bar_general", tmp_path, rounded)
    linkage = kinematics.load(path, angles="as_written")
    assert not linkage.planar
    assert "nearly_planar" in [notice.code for notice in linkage.notices]


def identified_values(linkage, folder):
    """Values of combinations that some loads along a table of a motion would have."""
    time = np.linspace(0.0, 0.8, 33)
    loads = {"time": time, "fx": np.cos(9.0 * time), "mz": np.sin(7.0 * time)}
    answer = balance.identify(linkage, folder / "u1.csv", loads)
    return [each.value for each in answer.combinations if each.value is not None]


def from_measurements(linkage, folder):
    """Functions of identification and of tolerances, as in `from_linkages`."""
    return {
        "exciting_motion": lambda: (
            balance.masses.exciting_motion(linkage, 2.0, tries=1).trajectory.q
        ),
        "identify": lambda: identified_values(linkage, folder),
        "shaking_tolerance": lambda: balance.motion.shaking_tolerance(
            linkage, mass=0.1, trajectories=1
        ).to_dict(),
    }


def from_payloads(linkage):
    """Those of gravity and loads; see `from_linkages`."""
    load = balance.masses.read_payload("coupler=0:0.5")
    force = design_space("four_bar_general", None, "force")
    return {
        "carrying": lambda: balance.masses.carrying(linkage, load).bodies[1].inertia,
        "movable_weights": lambda: (
            balance.masses.movable_weights(force, linkage, load, ["crank", "rocker"]).residual
        ),
        "holding_torques": lambda: balance.motion.holding_torques(
            linkage, [[0.0] * 4], (0.0, -9.81, 0.0)
        ),
        "path_to_pose": lambda: len(balance.path_to_pose(linkage, {"u1": 0.2}).paths),
    }


def changed_peaks(linkage):
    """The sentence on a linkage beside another one."""
    options = {"trajectories": 1, "samples": 8}
    return balance.motion.verify_against(linkage, "four_bar_kite", **options).sentence


def from_paths(linkage):
    """The same on paths."""
    s, still = np.linspace(0.0, 0.1, 9), np.zeros((9, 3))
    path = balance.motion.ReactionlessPath(
        0, np.ones(1), s, still, s[:, None], np.ones((9, 1)), 0.0 * s, 0.0, ()
    )
    return {
        "find_paths": lambda: balance.find_paths(linkage, length=0.1).starts[0].values,
        "inertia_chart": lambda: (
            balance.motion.inertia_chart(linkage, "crank", [2.0], length=0.1)
            .solutions[0]
            .starts[0]
            .values
        ),
        "moments_through_poses": lambda: (
            balance.motion.moments_through_poses(linkage, ["crank"], [[0.0], [0.1]]).residual
        ),
        "timed_path": lambda: balance.motion.timed_path(linkage, path).q,
    }


def from_linkages(linkage, folder):
    """Every public function of balance on a linkage, called with what stands for one.

    Args:
        folder: one with tables of motions.
    """
    q, one = [0.1], [1.0]
    screws = [[joint.screw for joint in kinematics.load("four_bar_general").joints]]
    return {
        **from_payloads(linkage),
        **from_paths(linkage),
        "balance_pose": lambda: balance.pose.balance_pose(linkage, {"crank": 1.0}).z,
        "compare_remedies": lambda: (
            balance.compare_remedies(linkage, ["duplicates"]).results[0].added_mass
        ),
        "require": lambda: balance.require(linkage, "force; dynamic at u1=0.1").basis,
        "design_space": lambda: design_space(linkage).basis,
        "design_space_many": lambda: balance.space.design_space_many(linkage, screws).rank,
        "exact_ranks": lambda: balance.checks.exact_ranks(linkage).ranks,
        "locked_inertia": lambda: balance.space.locked_inertia(linkage, q),
        "formulas": lambda: balance.formulas(linkage, "force").text(),
        "motion_modes": lambda: balance.motion_modes(linkage).modes[0].space.basis,
        "momentum_lines": lambda: balance.momentum.momentum_lines(linkage, q)[0][1].point,
        "momentum_map": lambda: balance.pose.momentum_map(linkage, {"u1": [0.0, 0.1]}).matrix,
        "momentum_matrix": lambda: balance.pose.momentum_matrix(linkage, q),
        "momentum_regressor": lambda: balance.momentum.momentum_regressor(linkage, q),
        "momentum_taylor": lambda: balance.momentum.momentum_taylor(linkage, 2).coefficients,
        "momentum_wrenches": lambda: balance.momentum.momentum_wrenches(linkage, q),
        "from_csv": lambda: balance.motion.from_csv(linkage, folder / "u1.csv").q,
        "from_tool_csv": lambda: (
            balance.motion.from_tool_csv(linkage, folder / "x.csv", "coupler").q
        ),
        "one_turn": lambda: balance.motion.one_turn(linkage, 10.0).q,
        "rest_to_rest": lambda: balance.motion.rest_to_rest(linkage, [[0.0], [0.1]]).q,
        **from_measurements(linkage, folder),
        "quiet_motion": lambda: balance.quiet_motion(linkage, [0.0], [0.2], 1.0).bound,
        "quiet_timing": lambda: balance.quiet_timing(linkage, [[0.0], [0.2]], 1.0).bound,
        "reaction_null_space": lambda: (
            balance.pose.reaction_null_space(linkage, q).singular_values
        ),
        "screw_figure": lambda: len(balance.momentum.screw_figure(linkage, q).axes),
        "shaking": lambda: balance.motion.shaking(linkage, q, one, one),
        "simulate_flexible": lambda: (
            balance.flexible.simulate_flexible(
                linkage, ["coupler=EI:1,rhoA:1"], duration=0.01, samples=3
            ).force
        ),
        "simulate_floating_base": lambda: balance.motion.simulate_floating_base(
            linkage, balance.motion.FloatingBase(1, 1), duration=0.01
        ).samples[0],
        "springs": lambda: (
            balance.springs(linkage, "base,crank", gravity=(0, -9.81, 0)).springs[0].stiffness
        ),
        "sweep": lambda: balance.sweep(linkage, {"coupler.length": [0.9]})["rank"],
        "verify": lambda: balance.verify(linkage, trajectories=1, samples=8).force,
        "verify_against": lambda: changed_peaks(linkage),
    }


@pytest.mark.slow
def test_a_linkage_may_be_named(tmp_path):
    """A path, a name and a linkage give the same; anything else is told what is expected.

    Functions are given a name or a path in turn, or each of them; ``load`` makes what they
    take.
    """
    path = kinematics.gallery()["four_bar_general"]
    name = "four_bar_general"
    ways = (kinematics.load(name), name, str(path), path)
    for column in ("u1", "x"):
        rows = [f"{0.1 * k:.1f},{1e-3 * k * k:.6f}" for k in range(9)]
        table = "\n".join([f"time,{column}", *rows])
        (tmp_path / f"{column}.csv").write_text(table, "utf-8")
    functions = [from_linkages(way, tmp_path) for way in ways]
    taking = {
        name
        for face in FACES
        if face.startswith("balance")
        for name, function in public_names(face).items()
        if inspect.isfunction(function)
        and {"linkage", "model"} & inspect.signature(function).parameters.keys()
    } - {"load"}
    assert taking == functions[0].keys()
    for turn, name in enumerate(sorted(taking)):
        expected = functions[0][name]()
        others = [calls[name]() for calls in spread(functions[1:], 3, turn % 3)]
        assert all(np.array_equal(expected, other) for other in others), name
        for wrong in (5, None, [path]):
            with pytest.raises(TypeError, match=r"expected a kinematics.Linkage, a path, the"):
                from_linkages(wrong, tmp_path)[name]()
        with pytest.raises(FileError, match="no such file"):
            from_linkages("four_bar_genera", tmp_path)[name]()
