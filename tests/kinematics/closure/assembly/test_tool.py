"""Inverse kinematics by virtual joints, against closed forms and forward kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from balance import design_space
from kinematics import taylor_motion, tool
from kinematics.errors import BodyError, LinkageError
from tests.independent.reference import displacements, load
from tests.support.five_bar_tip import TIP, two_links
from tests.support.laws import displacement, relative
from tests.support.robots import SIX, arm

# A link that is fixed to one of the five-bar.
FRAME = (
    '<link name="tip"/><joint name="mount" type="fixed"><parent link="left_upper"/>'
    '<child link="tip"/><origin xyz="0.1 -0.2 0.3" rpy="0 0 1"/></joint></robot>'
)


def tip_of_the_five_bar(link="left_upper", directions="x,y"):
    return tool(kinematics.load("five_bar"), link, directions, TIP)


@pytest.mark.parametrize("link", ["left_upper", "right_upper"])
def test_the_tip_of_the_five_bar_in_closed_form(link):
    """All four angles from two triangles; order 10 at a tenth of the radius."""
    linkage = tip_of_the_five_bar(link)
    assert linkage.inputs == (f"{link}.x", f"{link}.y") and linkage.mobility == 2
    assert linkage.planar
    motion = taylor_motion(linkage, 10)
    far = 0.1 * motion.radius * motion.scales[0]
    d = far * np.array([[0, 0], [1, 0], [0, 1], [-0.7, 0.7], [0.7, 0.7]])
    q = motion.evaluate(d)
    for bases, elbow, names in (
        ((0.0, 0.0), (-0.2, 0.6), ("u1", "q2")),
        ((0.9, 0.1), (1.2, 0.5), ("u2", "q4")),
    ):
        angles = two_links(np.array(bases), TIP[:2] + d, np.array(elbow))
        for name, angle in zip(names, angles, strict=True):
            found = q[:, motion.joints.index(name)]
            assert found == pytest.approx(angle - angle[0], abs=1e-11)


def pose_of_the_last_link(path, q):
    placed, _ = displacements(load(path), q)
    return placed[5]


def test_a_straight_wrist_is_told(tmp_path):
    """Axes 4 and 6 of an arm are one line: five freedoms there, six nearby."""
    path = tmp_path / "arm.urdf"
    path.write_text(straight_arm(), encoding="utf-8")
    with pytest.raises(LinkageError, match="singular one, where the tool has 5 freedoms"):
        tool(kinematics.load(path), "l5", "x,y,z,rx,ry,rz")
    bent = kinematics.load(path, at={"j4": 0.5, "j2": 0.4})
    assert tool(bent, "l5", "x,y,z,rx,ry,rz").mobility == 6


def straight_arm():
    """A robot arm with three axes through its wrist."""
    axes = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
    places = ("0 0 0.3", "0 0 0.2", "0 0 0.5", "0.3 0 0", "0.2 0 0", "0.1 0 0")
    text, parent = '<robot name="arm"><link name="base"/>', "base"
    for k, (axis, place) in enumerate(zip(axes, places, strict=True)):
        text += (
            f'<link name="l{k}"/><joint name="j{k}" type="continuous"><origin xyz="{place}"/>'
            f'<parent link="{parent}"/><child link="l{k}"/><axis xyz="{axis}"/></joint>'
        )
        parent = f"l{k}"
    return f"{text}</robot>"


def test_six_joints_take_the_tool_anywhere(tmp_path):
    """Forward kinematics of predicted and polished joints gives back the pose asked for."""
    path = arm(tmp_path, *SIX)
    linkage = tool(kinematics.load(path), "l6", "x,y,z,rx,ry,rz", (0.6, 0.1, 0.65))
    assert linkage.mobility == 6 and not linkage.notices
    motion = taylor_motion(linkage, 4)
    u = np.random.default_rng(4).uniform(-0.02, 0.02, 6)
    R = Rotation.from_euler("XYZ", u[3:]).as_matrix()
    expected = np.eye(4)
    expected[:3, :3] = R
    expected[:3, 3] = np.array([0.6, 0.1, 0.65]) + u[:3] - R @ [0.6, 0.1, 0.65]
    for q, tolerance in ((motion.polish(u), 1e-13), (motion.evaluate(u), 3e-6)):
        found = pose_of_the_last_link(path, q[:6])
        assert np.abs(found - expected).max() < tolerance


@pytest.mark.parametrize("directions", [["y"], ["z", "x"], ["rz"]])
def test_directions_not_named_are_held(directions, tmp_path):
    path = arm(tmp_path, *SIX)
    linkage = tool(kinematics.load(path), "l6", directions)
    assert linkage.inputs == tuple(f"l6.{d}" for d in directions)
    motion = taylor_motion(linkage, 6)
    u = np.full(len(directions), 0.03)
    H = pose_of_the_last_link(path, motion.polish(u)[:6])
    at = np.array(SIX[0][5])
    shift = H[:3, :3] @ at + H[:3, 3] - at
    expected = [0.03 * (d in directions) for d in "xyz"]
    assert shift == pytest.approx(expected, abs=1e-12)
    turn = Rotation.from_matrix(H[:3, :3]).as_rotvec()
    assert turn == pytest.approx([0.0, 0.0, 0.03 * (directions == ["rz"])], abs=1e-12)


def test_what_cannot_be_held_follows():
    """The coupler of a five-bar turns when its tip moves along x alone, and y is held."""
    linkage = tip_of_the_five_bar(directions="x")
    assert linkage.mobility == 1
    names = [joint.name for joint in linkage.joints]
    assert "left_upper.y" not in names and "left_upper.rz" in names
    whole = taylor_motion(tip_of_the_five_bar(), 6)
    part = taylor_motion(linkage, 6)
    x = np.array([[0.05], [-0.1]])
    q = part.evaluate(x)
    expected = whole.evaluate(np.hstack([x, 0 * x]))
    for name in ("u1", "q2", "u2", "q4", "left_upper.rz"):
        i, j = part.joints.index(name), whole.joints.index(name)
        assert q[:, i] == pytest.approx(expected[:, j], abs=1e-13)


def test_a_parallel_robot_that_only_translates():
    """The platform of the delta does not turn, whichever joints drive it."""
    delta = kinematics.load("delta")
    linkage = tool(delta, "platform", "x,y,z")
    assert linkage.mobility == 3
    assert {"platform.rx", "platform.ry", "platform.rz"} <= set(linkage.idle)
    forward, inverse = taylor_motion(delta, 5), taylor_motion(linkage, 5)
    u = np.array([0.01, -0.02, 0.03])
    q = inverse.polish(u)
    drives = [inverse.joints.index(name) for name in delta.inputs]
    assert relative(q[: len(delta.joints)], forward.polish(q[drives])) < 1e-12


def test_seven_joints_keep_one_for_themselves(tmp_path):
    """With all six directions given, one joint is left over; a notice says which."""
    points, axes = SIX
    path = arm(tmp_path, [*points, (0.6, 0.1, 0.5)], [*axes, (0, 1, 0.5)])
    linkage = tool(kinematics.load(path), "l7", "x,y,z,rx,ry,rz")
    assert linkage.mobility == 7 and linkage.inputs[-1].startswith("j")
    assert [n.code for n in linkage.notices] == ["inputs_completed"]
    assert tool(kinematics.load(path), "l7", "x").mobility == 2


def test_masses_are_those_of_the_robot():
    """The design space of a five-bar does not depend on what drives it."""
    one, other = design_space(kinematics.load("five_bar")), design_space(tip_of_the_five_bar())
    assert (other.rank, other.nullity) == (one.rank, one.nullity)


@pytest.mark.parametrize(
    ("link", "directions", "told"),
    [
        ("nothing", "x", "no moving link of this name; the bodies are left_lower"),
        ("left_upper", "x,w", "input w: no direction of a tool; choose from x, y, z, rx"),
        ("left_upper", "x,x", "input x: named twice"),
        ("left_upper", [], "no direction is named"),
        ("left_upper", "z", "cannot move this way at the reference pose; choose from x, y, rz"),
        ("left_upper", "x,y,rz", "input rz: depends on x, y at the reference pose"),
        ("left_lower", "x,rz", "input rz: depends on x at the reference pose"),
    ],
)
def test_what_is_wrong_is_told(link, directions, told):
    with pytest.raises(LinkageError, match=told):
        tip_of_the_five_bar(link, directions)


def test_a_tool_frame_on_a_fixed_joint(tmp_path):
    """It is the point that it stands for, also where closing the loops moved it."""
    text = kinematics.gallery()["five_bar"].read_text(encoding="utf-8")
    turned = text.replace('"0 0 0" rpy="0 0 0"', '"0 0 0" rpy="0 0 0.05"', 1)
    for written in (text, turned):
        path = tmp_path / "robot.urdf"
        path.write_text(written.replace("</robot>", FRAME), encoding="utf-8")
        linkage = kinematics.load(path)
        (body,) = (body for body in linkage.bodies if body.name == "left_upper")
        point = body.frame[:3, :3] @ (0.1, -0.2, 0.3) + body.frame[:3, 3]
        one, other = tool(linkage, "tip", "x,y"), tool(linkage, "left_upper", "x,y", point)
        motions = [taylor_motion(found, 3).coefficients for found in (one, other)]
        assert np.abs(motions[0] - motions[1]).max() < 1e-12 * np.abs(motions[0]).max()
    assert "assembled" in {notice.code for notice in linkage.notices}


@pytest.mark.parametrize("directions", ["x,y", "rz"])
def test_a_point_in_the_frame_of_the_link(directions, tmp_path):
    """Of a frame that is turned by 1 rad on its body; the same point in the inertial frame."""
    text = kinematics.gallery()["five_bar"].read_text(encoding="utf-8")
    path = tmp_path / "robot.urdf"
    path.write_text(text.replace("</robot>", FRAME), encoding="utf-8")
    five_bar, at = kinematics.load(path), np.array([0.3, -0.2, 0.1])
    (body,) = (body for body in five_bar.bodies if body.name == "left_upper")
    on_body = Rotation.from_euler("xyz", [0.0, 0.0, 1.0]).apply(at) + (0.1, -0.2, 0.3)
    point = body.frame[:3, :3] @ on_body + body.frame[:3, 3]
    linkages = [
        tool(five_bar, "tip", directions, at, frame="link"),
        tool(five_bar, "tip", directions, point),
        tool(five_bar, "tip", directions, at),
        tool(five_bar, "tip", directions, (0, 0, 0), frame="link"),
        tool(five_bar, "tip", directions),
    ]
    inside, outside, wrong, zero, origin = (
        taylor_motion(linkage, 3).coefficients for linkage in linkages
    )
    assert relative(inside, outside) < 1e-12 and relative(zero, origin) < 1e-12
    assert relative(inside, wrong) > 1e-2 and relative(inside, origin) > 1e-2


def test_points_and_second_tools_are_refused():
    linkage = kinematics.load("five_bar")
    for point in ((0.0, 1.0), (0.0, np.nan, 1.0)):
        with pytest.raises(BodyError, match="three finite numbers"):
            tool(linkage, "left_upper", "x", point)
    with pytest.raises(BodyError, match="give metres, in the link frame"):
        tool(linkage, "left_upper", "x", (0.0, np.inf, 0.0), frame="link")
    with pytest.raises(ValueError, match="one of inertial, link, not 'world'"):
        tool(linkage, "left_upper", "x", frame="world")
    with pytest.raises(BodyError, match="is a tool already"):
        tool(tip_of_the_five_bar(), "left_upper", "x")


def test_a_robot_at_another_place_moves_the_same(tmp_path):
    """Directions are inertial: with the axes turned along, joints do the same."""
    points, axes = (np.array(x, float) for x in SIX)
    R = displacement(np.random.default_rng(2))[:3, :3]
    straight = arm(tmp_path, points, axes)
    one = taylor_motion(tool(kinematics.load(straight), "l6", "x,y,z"), 3)
    turned = arm(tmp_path, points @ R.T, axes @ R.T)
    other = taylor_motion(tool(kinematics.load(turned), "l6", "x,y,z"), 3)
    u = np.random.default_rng(3).uniform(-0.05, 0.05, (4, 3))
    assert relative(other.evaluate(u @ R.T)[:, :6], one.evaluate(u)[:, :6]) < 1e-11
