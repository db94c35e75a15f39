"""Mobility, inputs and idle joints are found; what cannot move or close is refused."""

import re
from itertools import pairwise

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.momentum import momentum_regressor
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import CoordinateError, MobilityError, OpenLoopError
from tests.independent import reference
from tests.support.covering import joint_types
from tests.support.figures import FIGURES
from tests.support.laws import MODELS, PLANAR, altered, posed, words
from tests.support.urdf_text import about, along, joint, link, loop, saved

MOBILITY = dict.fromkeys(MODELS, 1) | {"delta": 3, "five_bar": 2, "fuga_i": 2}
MOBILITY |= dict.fromkeys(["three_rsr", "three_rsr_rational"], 3)
MOBILITY |= dict.fromkeys(["double_pendulum_counter_rotary", "double_pendulum_duplicates"], 2)
MOBILITY |= dict.fromkeys(
    ["principal_vector_linkage", "three_four_bars_platform", "zero_reaction_arm"], 3
)
MOBILITY |= {"hprs": 6, "pantograph": 2, "stewart_6ups": 6}
MOBILITY |= dict.fromkeys([name for name in MODELS if "_rrr" in name], 3)
MOBILITY |= {"two_rrr_bisector": 2, "pantograph_reaction_wheel": 3}
Z = [0.0, 0.0, 1.0]
MASS = dict(mass=1.0, inertia=0.1 * np.eye(3))


def codes(linkage):
    return [notice.code for notice in linkage.notices]


def remark(linkage, code):
    (text,) = [notice.message for notice in linkage.notices if notice.code == code]
    return text


def unmarked(robot):
    """No joint is an input by its file."""
    for item in (*robot.iter("joint"), *robot.iter("loop")):
        item.attrib.pop("independent", None)


def shifted(offset, turn="0 0 0", name=None):
    """The change that moves the far frame of a loop, the first one by default."""

    def change(robot):
        found = next(x for x in robot.iter("loop") if name in (None, x.get("name")))
        origin = found.find("successor/origin")
        there = np.array(origin.get("xyz").split(), float) + offset
        origin.set("xyz", words(there))
        origin.set("rpy", turn)

    return change


def loop_type(kind):
    def change(robot):
        for item in robot.iter("loop"):
            item.set("type", kind)

    return change


@pytest.mark.table(20)
@pytest.mark.parametrize("name", MODELS)
def test_mobility_and_marked_inputs(name):
    linkage, mechanism = kinematics.load(name), reference.load(name)
    assert linkage.mobility == MOBILITY[name] == len(linkage.inputs)
    assert set(linkage.inputs) == {mechanism.joints[i] for i in mechanism.inputs}
    assert linkage.planar == (name in PLANAR)
    assert "inputs_completed" not in codes(linkage) and "assembled" not in codes(linkage)
    assert linkage.chain.width == linkage.spatial_chain.width == linkage.mobility


@pytest.mark.table
@pytest.mark.parametrize("name", MODELS)
def test_inputs_are_chosen_where_none_is_marked(name, tmp_path):
    linkage = kinematics.load(altered(name, tmp_path, unmarked))
    assert linkage.mobility == MOBILITY[name] == len(linkage.inputs)
    assert "inputs_completed" not in codes(linkage)
    found, given = design_space(linkage), design_space(kinematics.load(name))
    assert (found.rank, found.kmax) == (given.rank, given.kmax)


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("four_bar_general", ["q2"]),
        ("four_bar_general", ["q3"]),
        ("five_bar", ["q4", "u1"]),
        ("hprs", ["wrist_z", "wrist_y", "wrist_x", "revolute", "prismatic", "helical"]),
    ],
)
def test_named_inputs_are_taken_in_their_order(name, inputs):
    linkage = kinematics.load(name, inputs=inputs)
    assert linkage.inputs == tuple(inputs)
    u = 0.1 * np.arange(1.0, 1.0 + len(inputs))
    at = [[joint.name for joint in linkage.joints].index(name) for name in inputs]
    for given in (u, dict(zip(inputs, u, strict=True))):
        assert joint_positions(linkage, given)[at] == pytest.approx(u, abs=1e-14)


@pytest.mark.parametrize(
    ("name", "inputs", "culprit", "problem"),
    [
        ("four_bar_general", ["u1", "q2"], "q2", "depends on the other inputs"),
        ("five_bar", ["u1", "u2", "q3"], "q3", "depends on the other inputs"),
        ("four_bar_general", ["u7"], "u7", "no such joint"),
        ("four_bar_general", ["u1", "u1"], "u1", "named twice"),
        ("three_rsr", ["u1", "platform1"], "platform1", "depends on the other inputs"),
    ],
)
def test_inputs_that_will_not_do_are_refused(name, inputs, culprit, problem):
    with pytest.raises(CoordinateError, match=problem) as caught:
        kinematics.load(name, inputs=inputs)
    error = caught.value
    assert error.names == (culprit,)
    assert error.valid and set(error.valid) <= {j.name for j in kinematics.load(name).joints}
    assert culprit in str(error) and ", ".join(error.valid) in str(error)


@pytest.mark.parametrize(
    "name, inputs", [("five_bar", ["u2"]), ("three_rsr", ["u3"]), ("four_rrr", ["a4", "b2"])]
)
def test_missing_inputs_are_completed_and_told(name, inputs):
    linkage = kinematics.load(name, inputs=inputs)
    assert linkage.inputs[: len(inputs)] == tuple(inputs)
    assert len(linkage.inputs) == linkage.mobility == MOBILITY[name]
    text = remark(linkage, "inputs_completed")
    added = linkage.inputs[len(inputs) :]
    assert all(re.search(rf"\b{re.escape(joint)}\b", text) for joint in added)
    assert f"{len(inputs)} inputs named, mobility {MOBILITY[name]}" in text
    assert design_space(linkage).nullity == design_space(kinematics.load(name)).nullity


def test_joints_that_cannot_move_are_idle(tmp_path):
    """A ball joint in a planar four-bar turns about one axis only."""
    linkage = kinematics.load(altered("four_bar_general", tmp_path, loop_type("spherical")))
    assert linkage.mobility == 1 and linkage.planar
    assert len(linkage.idle) == 2 and {name[:3] for name in linkage.idle} == {"q3."}
    found = design_space(linkage)
    assert [order.rank for order in found.orders[:4]] == [3, 6, 7, 8]
    assert set(found.idle) == set(linkage.idle)


def test_idle_joints_depend_on_the_motion():
    """On its plane of symmetry the leg of u1 moves in that plane: its ball turns about y."""
    linkage = kinematics.load("three_rsr")
    assert not {"elbow1_x", "elbow1_y"} & set(linkage.idle)
    found = design_space(linkage, ["u2=u3"])
    assert {"elbow1_x", "elbow1_z"} <= set(found.idle) and "elbow1_y" not in found.idle


@pytest.mark.parametrize("offset", [(0, 0, -1e-3), (9, 0, 0), (0, -7, 0.1)])
def test_an_open_loop_is_refused_with_its_size(offset, tmp_path):
    """Out of the plane, or out of reach: no pose of the joints can close it."""
    path = altered("four_bar_general", tmp_path, shifted(offset))
    with pytest.raises(OpenLoopError) as caught:
        kinematics.load(path)
    error = caught.value
    assert error.loop == "q3"
    assert error.distance == pytest.approx(np.linalg.norm(offset), rel=1e-12)
    assert error.angle == pytest.approx(0.0, abs=1e-12)
    assert f"{error.distance:.3g} m" in str(error) and "'q3'" in str(error)


@pytest.mark.parametrize("angle", [0.01, 1.0, np.pi])
def test_a_tilted_loop_is_refused_with_its_angle(angle, tmp_path):
    """The two frames of the loop share their origin, wherever that of the mechanism is."""
    path = altered("four_bar_general", tmp_path, shifted((0, 0, 0), words([angle, 0, 0])))
    with pytest.raises(OpenLoopError) as caught:
        kinematics.load(path)
    assert caught.value.distance == pytest.approx(0.0, abs=1e-12)
    assert caught.value.angle == pytest.approx(angle, rel=1e-9)


def test_a_loop_turned_over_is_refused(tmp_path):
    """Half a turn has no sine: the loop is amid the joints, so nothing else is open."""
    a, b, d = (np.array(x) for x in ([-1, 0, 0], [-0.5, 1.2, 0], [1.5, -1.2, 0]))
    path = saved(
        tmp_path,
        link("base"),
        *(link(name, **MASS) for name in "abc"),
        joint("j1", "continuous", "base", "a", along(a), Z),
        joint("j2", "continuous", "a", "b", along(b - a), Z),
        joint("j4", "continuous", "base", "c", along(d), Z),
        loop("k", "revolute", ("b", "c"), (along(-b), along(-d) @ about([0, 1, 0], np.pi)), Z),
    )
    with pytest.raises(OpenLoopError) as caught:
        kinematics.load(path)
    assert caught.value.angle == pytest.approx(np.pi, rel=1e-9)


def test_the_loop_that_is_furthest_open_is_named(tmp_path):
    path = altered(
        "four_rrr", tmp_path, shifted((0, 0, 0.01), name="c2"), shifted((0, 0, 0.2), name="c3")
    )
    with pytest.raises(OpenLoopError, match="'c3'") as caught:
        kinematics.load(path)
    assert caught.value.distance == pytest.approx(0.2, rel=1e-12)


def platform(folder, feet, heads):
    """A planar platform on bars from ``feet`` to ``heads``; the first carries it."""
    feet, heads = (np.column_stack([x, np.zeros(len(x))]) for x in (feet, heads))
    elements = [link("base"), link("top", **MASS)]
    for i, (foot, head) in enumerate(zip(feet, heads, strict=True)):
        elements.append(link(f"bar{i}", **MASS))
        elements.append(joint(f"a{i}", "continuous", "base", f"bar{i}", along(foot), Z))
        if i == 0:
            up = along(head - foot)
            elements.append(joint("b0", "continuous", "bar0", "top", up, Z))
            continue
        frames = along(head - foot), along(head - heads[0])
        elements.append(loop(f"b{i}", "revolute", (f"bar{i}", "top"), frames, Z))
    return saved(folder, *elements)


def test_a_rigid_structure_is_refused(tmp_path):
    path = platform(tmp_path, [(0, 0), (1, 0), (2, 0)], [(0.1, 1), (1.3, 0.9), (1.5, 1.2)])
    with pytest.raises(MobilityError, match="rigid"):
        kinematics.load(path)


def test_parallel_bars_of_one_length_move(tmp_path):
    """Overconstrained, and mobile all the same: the platform of a swing."""
    linkage = kinematics.load(
        platform(tmp_path, [(0, 0), (1, 0), (2, 0.3)], [(0.2, 1), (1.2, 1), (2.2, 1.3)])
    )
    assert linkage.mobility == 1
    q = joint_positions(linkage, [0.4])
    by_name = dict(zip((j.name for j in linkage.joints), q, strict=True))
    bars = [by_name[name] for name in ("a0", "a1", "a2")]
    assert bars == pytest.approx(3 * bars[:1], abs=1e-12) and 0.4 in bars


def arm(folder, mimic):
    elbow = joint("j2", "continuous", "lower", "upper", along([0.7, 0, 0]), Z, more=mimic)
    return saved(
        folder,
        link("base"),
        link("lower", **MASS, origin=along([0.3, 0.1, 0])),
        link("upper", **MASS, origin=along([0.2, -0.1, 0])),
        joint("j1", "continuous", "base", "lower", along([0, 0, 0]), Z),
        elbow,
    )


@pytest.mark.parametrize(("ratio", "offset"), [(-2.0, 0.0), (0.5, 0.3), (1.0, -1.0)])
def test_a_mimic_joint_follows_its_source(ratio, offset, tmp_path):
    """Two links in the plane, by hand: ``θ2 = θ1 + ratio θ1 + offset``."""
    path = arm(tmp_path, f'<mimic joint="j1" multiplier="{ratio}" offset="{offset}"/>')
    linkage = kinematics.load(path)
    assert linkage.mobility == 1 and linkage.inputs == ("j1",)
    u = 0.35
    assert joint_positions(linkage, [u]) == pytest.approx([u, ratio * u], abs=1e-15)

    def turned(angle, vector):
        return np.exp(1j * angle) * complex(*vector)

    upper = (1 + ratio) * u + offset
    bodies = [(u, 1.0, 0.0, (0.3, 0.1)), (upper, 1 + ratio, 0.7, (0.2, -0.1))]
    moment, force = 0.0, 0.0
    for angle, spin, reach, com in bodies:
        at = turned(u, (reach, 0)) + turned(angle, com)
        speed = 1j * turned(u, (reach, 0)) + 1j * spin * turned(angle, com)
        force += speed
        moment += 0.1 * spin + (at.conjugate() * speed).imag
    X = momentum_regressor(linkage, [u], spatial=True)[0]
    z = np.concatenate([body.inertia for body in linkage.bodies])
    assert X @ z == pytest.approx([0, 0, moment, force.real, force.imag, 0], abs=1e-14)
    assert kinematics.load(arm(tmp_path, "")).mobility == 2


def test_a_mimic_ratio_has_units(tmp_path):
    """A rack on a pinion: metres per radian, whatever length the chain is scaled by."""
    path = saved(
        tmp_path,
        link("base"),
        link("pinion", **MASS),
        link("rack", **MASS),
        joint("turn", "continuous", "base", "pinion", along([5, 0, 0]), Z),
        joint(
            "slide",
            "prismatic",
            "base",
            "rack",
            along([5, 3, 0]),
            [1, 0, 0],
            more='<limit effort="1" velocity="1" lower="-9" upper="9"/>'
            '<mimic joint="turn" multiplier="-0.25"/>',
        ),
    )
    linkage = kinematics.load(path)
    assert linkage.mobility == 1 and linkage.inputs == ("turn",)
    assert joint_positions(linkage, [0.8]) == pytest.approx([0.8, -0.2], abs=1e-15)
    X = momentum_regressor(linkage, [0.8], spatial=True)[0].reshape(6, 2, 10)
    assert X[3:, 1, 0] == pytest.approx([-0.25, 0, 0], abs=1e-15)
    assert X[2, 0, 6] == pytest.approx(1.0, abs=1e-15)


LOOPED = [
    f for f in FIGURES if not f.motion and "loop" in joint_types(kinematics.gallery()[f.model])
]


@pytest.mark.table(8)
@pytest.mark.parametrize("figure", LOOPED, ids=str)
def test_a_slightly_open_file_is_closed_and_told(figure, tmp_path):
    """Joints of the tree are turned by 1e-4 in the file: the same linkage, a bit open."""
    mechanism, rng = reference.load(figure.model), np.random.default_rng(110)
    turning = [
        name
        for name, twist in zip(mechanism.joints, mechanism.twists, strict=True)
        if twist[:3, :3].any()
    ]
    angles = dict(zip(turning, 1e-4 * rng.choice([-1, 1], len(turning)), strict=True))
    linkage = kinematics.load(altered(figure.model, tmp_path, posed(angles)))
    told = re.search(
        r"open by (\S+) .*closed from the pose of the file; joint '(\S+)' moved furthest, "
        r"by (\S+) (rad|m)$",
        remark(linkage, "assembled"),
    )
    gap, moved = float(told[1]), abs(float(told[3]))
    assert 1e-5 < gap < 1e-2 and gap / 30 < moved < 30 * gap
    assert told[2] in {joint.name for joint in linkage.joints}
    assert linkage.mobility == MOBILITY[figure.model]
    found = design_space(linkage, balance=figure.balance, spatial=figure.spatial)
    assert found.kmax == figure.kmax and found.settled
    if "three_rsr" not in figure.model:  # their pose in the file is symmetric
        assert [order.rank for order in found.orders[: figure.kmax + 1]] == list(figure.ranks)
    assert found.nullity == figure.nullity
    assert not joint_positions(linkage, np.zeros(linkage.mobility)).any()


@pytest.mark.parametrize("name", ["four_bar_general", "five_bar", "bennett"])
@pytest.mark.parametrize("seed", range(3))
def test_a_widely_open_file_is_assembled(name, seed, tmp_path):
    """The distance of the two joints of a link, and the angle of their axes, stay."""
    rng = np.random.default_rng(120 + seed)
    angles = {joint: rng.uniform(-1, 1) for joint in ("u1", "q2", "q4")}
    paths = altered(name, tmp_path, posed(angles)), name
    linkage, given = (kinematics.load(path) for path in paths)
    assert "assembled" in codes(linkage) and linkage.mobility == MOBILITY[name]
    for one, other in pairwise(["u1", "q2", "q3", "q4"]):
        found = [sides(each, one, other) for each in (linkage, given)]
        assert found[0] == pytest.approx(found[1], abs=1e-11)
    assert design_space(linkage).nullity == design_space(given).nullity


def sides(linkage, one, other):
    """Distance of two joints, and cosine between their axes."""
    a, b = (next(j for j in linkage.joints if j.name == name) for name in (one, other))
    return np.linalg.norm(a.point - b.point), a.screw[:3] @ b.screw[:3]


def test_a_spun_loop_frame_is_not_open(tmp_path):
    """A revolute loop may be written at any angle about its axis."""
    path = altered("four_bar_general", tmp_path, shifted((0, 0, 0), "0 0 1.2"))
    linkage = kinematics.load(path)
    assert linkage.mobility == 1 and codes(linkage) == []
    assert design_space(linkage).nullity == 4
