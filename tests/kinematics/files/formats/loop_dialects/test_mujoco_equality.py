"""Equalities of MuJoCo in <mujoco> are loops and relations of joints."""

import numpy as np
import pytest

from tests.support.dialect_loops import connect, mimicked, mujoco, related
from tests.support.dialect_text import (
    MORE,
    ON_B,
    ON_C,
    OPEN,
    WELD,
    codes,
    compare_drafts,
    draft_of,
    hand_written,
    refused,
)


def test_an_anchor_is_where_it_is_at_the_pose_of_the_file(tmp_path):
    draft = draft_of(tmp_path, OPEN, connect())
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("spherical", "")))
    assert not codes(draft)
    side = draft.tree.children[-1].children[1]
    assert side.first("origin").attributes["xyz"] == ON_C  # exactly


def test_an_anchor_on_a_turned_link(tmp_path):
    draft = draft_of(tmp_path, OPEN, connect("ca", ON_C))
    side = draft.tree.children[-1].children[1]
    assert side.first("origin").attributes["xyz"] == "1.5 -2 0"


def test_the_world_is_the_root(tmp_path):
    text = mujoco(f'<connect body1="c" anchor="{ON_C}"/>')
    draft = draft_of(tmp_path, OPEN, text)
    assert draft.loops[0].successor == -1
    side = draft.tree.children[-1].children[1]
    assert side.attributes["link"] == "base"
    assert side.first("origin").attributes["xyz"] == "2 1.5 0"


@pytest.mark.parametrize(
    "more",
    ["", 'anchor="1 2 3"', 'relpose="0 1 0 0 0 0 0"', 'torquescale="3"'],
)
def test_a_weld_at_the_pose_of_the_file(more, tmp_path):
    draft = draft_of(tmp_path, OPEN, MORE, mujoco(f'<weld body1="d" body2="c" {more}/>'))
    compare_drafts(draft, draft_of(tmp_path, OPEN, MORE, WELD))
    assert not codes(draft)


@pytest.mark.parametrize("quaternion", ["0 1 -1 0", "0 -0.3 0.3 0"])
def test_a_weld_with_a_pose(quaternion, tmp_path):
    """Link c is turned by π about (1, -1, 0) of d, and its point ON_C is the origin of d."""
    text = f'<weld body1="d" body2="c" relpose="0 0 0 {quaternion}" anchor="{ON_C}"/>'
    draft = draft_of(tmp_path, OPEN, MORE, mujoco(text))
    compare_drafts(draft, draft_of(tmp_path, OPEN, MORE, WELD))


def test_a_weld_without_torque_is_a_point(tmp_path):
    text = f'<weld body1="b" body2="c" torquescale="0" anchor="{ON_C}"/>'
    draft = draft_of(tmp_path, OPEN, mujoco(text))
    swapped = draft_of(tmp_path, OPEN, connect("cb", ON_C))
    compare_drafts(draft, swapped)


def test_two_points_are_a_hinge(tmp_path):
    items = [
        f'<connect body1="b" body2="c" anchor="{ON_B.removesuffix("0")}{z}"/>' for z in (0, 1)
    ]
    draft = draft_of(tmp_path, OPEN, mujoco(*items))
    assert [loop.name for loop in draft.loops] == ["connect_1", "connect_2"]
    assert not codes(draft)


@pytest.mark.parametrize(
    "polycoef, ratio", [("", "1"), ("0 -2 0 0 0", "-2"), ("0 0.5", "0.5"), ("0", "1")]
)
def test_a_line_is_a_relation(polycoef, ratio, tmp_path):
    draft = draft_of(tmp_path, OPEN, related(polycoef))
    compare_drafts(draft, draft_of(tmp_path, mimicked("j3", "j1", ratio)))
    assert not codes(draft)


def test_a_line_with_an_offset(tmp_path):
    draft = draft_of(tmp_path, OPEN, related("0.25 2"))
    wanted = mimicked("j3", "j1", '2" offset="0.25')
    compare_drafts(draft, draft_of(tmp_path, wanted))


def test_a_line_between_followers_relates_their_sources(tmp_path):
    """``4 q2 + 1 = 2 q1 + 0.25``, since j3 follows j2 already."""
    there = mimicked("j3", "j2", '4" offset="1')
    draft = draft_of(tmp_path, there, related("0.25 2"))
    (joint,) = (x for x in draft.tree.every("joint") if x.name == "j2")
    wanted = {"joint": "j1", "multiplier": "0.5", "offset": "-0.1875"}
    assert joint.first("mimic").attributes == wanted


@pytest.mark.parametrize("polycoef", ["0.25 0", "0.25"])
def test_a_constant_fixes_a_joint(polycoef, tmp_path):
    joints = 'joint1="j3"' if polycoef == "0.25" else 'joint1="j3" joint2="j1"'
    draft = draft_of(tmp_path, OPEN, related(polycoef, joints))
    turned = OPEN.replace('"j3" type="revolute"', '"j3" type="fixed"')
    turned = turned.replace('xyz="2 0 0" rpy="0 0 0"', 'xyz="2 0 0" rpy="0 0 0.25"')
    compare_drafts(draft, draft_of(tmp_path, turned))


def test_a_constant_fixes_followers_too(tmp_path):
    draft = draft_of(tmp_path, mimicked("j3", "j1", "2"), related("0.5", 'joint1="j3"'))
    assert [joint.name for joint in draft.joints] == ["j2"]
    pose = draft.places["a"].pose[:2, :2]
    angle = np.pi / 2 + 0.25
    np.testing.assert_allclose(pose[:, 0], [np.cos(angle), np.sin(angle)], atol=1e-15)


def test_what_is_switched_off_is_told_of(tmp_path):
    for text in (connect(more='active="false"'), mujoco('<joint active="false"/>')):
        draft = draft_of(tmp_path, OPEN, text)
        assert codes(draft) == ["loops_inactive"] and not draft.loops
    assert codes(draft_of(tmp_path, OPEN, mujoco('<flexvert name="x"/>'))) == ["flex_ignored"]


def test_contacts_are_no_closures(tmp_path):
    text = '<mujoco><contact><exclude body1="a" body2="c"/></contact></mujoco>'
    assert not codes(draft_of(tmp_path, OPEN, text))


@pytest.mark.parametrize(
    "text, said",
    [
        (mujoco('<connect site1="s" site2="t"/>'), "sites"),
        (mujoco('<weld site1="s" site2="t"/>'), "sites"),
        (mujoco('<tendon tendon1="s"/>'), "tendon"),
        (mujoco('<distance geom1="s"/>'), "distance"),
        (mujoco('<connect body1="b" body2="c"/>'), "no anchor"),
        (mujoco(f'<connect anchor="{ON_B}"/>'), "name two links"),
        (mujoco(f'<connect body1="b" body2="" anchor="{ON_B}"/>'), "name two links"),
        (connect("bx"), "'x' does not exist"),
        (connect(anchor="0 nan 0"), "3 finite"),
        (connect(("b", "b")), "one rigid body"),
        (connect(("base", "world")), "one rigid"),
        (mujoco('<weld body1="b" body2="c" relpose="1 2"/>'), "7 finite"),
        (mujoco('<weld body1="b" body2="c" torquescale="x"/>'), "a finite number"),
        (mujoco("<joint/>"), "joint1"),
        (related("0 1 0 0 2"), "not a line"),
        (related("0 1 0 0 0 0"), "finite numbers"),
        (related("0 x"), "finite numbers"),
        (related("", 'joint1="j3" joint2="x"'), "joint 'x' does not exist"),
        (related("", 'joint1="j3" joint2="j3"'), "to itself"),
        (related("0 2", 'joint1="j3" joint2="j3"'), "contradicts"),
    ],
)
def test_what_says_too_little_is_refused(text, said, tmp_path):
    error = refused(tmp_path, OPEN, text)
    assert said in str(error) and "(line" in error.element
