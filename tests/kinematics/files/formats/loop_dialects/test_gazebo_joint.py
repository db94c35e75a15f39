"""Joints of SDF in <gazebo> are the loops that Gazebo closes with them."""

import pytest

from tests.support.dialect_loops import gazebo
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


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
def test_a_joint_in_the_frame_of_its_child(kind, tmp_path):
    rpy = ("0 0 1.5707963267948966", "0 3.141592653589793 0")
    draft = draft_of(tmp_path, OPEN, gazebo(kind))
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written(kind, rpy=rpy)))
    assert not codes(draft)


@pytest.mark.parametrize(
    "pose",
    [
        f"<pose relative_to='b'>{ON_B} 0 0 0</pose>",
        f"<pose relative_to='j2'>{ON_B} 0 0 0</pose>",
        "<pose relative_to='__model__'>2 1.5 0 0 3.141592653589793 0</pose>",
        "<pose relative_to='r::base'>2 1.5 0 0 3.14159 0</pose>",
    ],
)
def test_a_joint_in_another_frame(pose, tmp_path):
    draft = draft_of(tmp_path, OPEN, gazebo(pose=pose))
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("revolute")))


@pytest.mark.parametrize(
    "axis",
    [
        '<axis><xyz expressed_in="base">0 0 -1</xyz></axis>',
        '<axis><xyz expressed_in="b">0 0 1</xyz></axis>',
        "<axis><xyz>0 0 -1</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>",
        "",
    ],
)
def test_an_axis_in_another_frame(axis, tmp_path):
    draft = draft_of(tmp_path, OPEN, gazebo(axis=axis))
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("revolute")))


def test_ball_universal_and_fixed(tmp_path):
    ball = draft_of(tmp_path, OPEN, gazebo("ball", axis=""))
    # Freedoms of a spherical joint are along the axes of the frame on its parent.
    rpy = ("0 0 1.5707963267948966", "0 0 0")
    compare_drafts(ball, draft_of(tmp_path, OPEN, hand_written("spherical", "", rpy)))
    axes = "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>"
    universal = draft_of(tmp_path, OPEN, gazebo("universal", axis=axes))
    words = '<axis xyz="0 0 1"/><axis2 xyz="0 1 0"/>'
    rpy = ("0 0 1.5707963267948966", "0 3.141592653589793 0")
    compare_drafts(universal, draft_of(tmp_path, OPEN, hand_written("universal", words, rpy)))
    fixed = gazebo("fixed", f"<pose>{ON_C} 0 0 0</pose>", "", "dc")
    compare_drafts(draft_of(tmp_path, OPEN, MORE, fixed), draft_of(tmp_path, OPEN, MORE, WELD))


@pytest.mark.parametrize("kind", ["screw", "revolute2", "gearbox", "", "hinge"])
def test_types_without_a_loop_are_refused(kind, tmp_path):
    error = refused(tmp_path, OPEN, gazebo(kind))
    assert "joint 'l' (line" in error.element and "<loop" in error.remedy
    assert '<predecessor link="b">' in error.remedy and '<successor link="c">' in error.remedy


@pytest.mark.parametrize(
    "text, said",
    [
        (gazebo().replace("<gazebo>", '<gazebo reference="b">'), "reference"),
        (
            gazebo().replace("<gazebo>", "<gazebo><model>").replace("</g", "</model></g"),
            "not directly",
        ),
        (gazebo(ends="bx"), "'x' does not exist"),
        (gazebo(ends="bd"), "'d' does not exist"),
        (gazebo(pose="<pose>0 1 nan 0 0 0</pose>"), "not 6 finite"),
        (gazebo(pose="<pose>0 1</pose>"), "not 6 finite"),
        (gazebo(pose="<pose degrees='true'>0 1 0 0 0 90</pose>"), "degrees"),
        (gazebo(pose="<pose relative_to='x'>0 1 0 0 0 90</pose>"), "frame 'x'"),
        (gazebo(axis="<axis><xyz>0 0 0</xyz></axis>"), "zero"),
        (gazebo(axis="<axis><xyz>0 0</xyz></axis>"), "not 3 finite"),
        (gazebo("universal"), "axis2"),
        (gazebo().replace("<child>c</child>", ""), "name two links"),
        (gazebo().replace(">c<", "><"), "name two links"),
        (gazebo(ends=("world", "base")), "one rigid body"),
    ],
)
def test_what_says_too_little_is_refused(text, said, tmp_path):
    error = refused(tmp_path, OPEN, text)
    assert said in str(error) and "(line" in error.element


def test_a_base_fixed_to_the_world_closes_nothing(tmp_path):
    draft = draft_of(tmp_path, OPEN, gazebo("fixed", "", "", ("world", "base")))
    assert not draft.loops and not codes(draft)


def test_a_joint_of_the_tree_counts_once(tmp_path):
    text = gazebo(ends="ab").replace('name="l"', 'name="j2"')
    draft = draft_of(tmp_path, OPEN, text)
    assert not draft.loops and codes(draft) == ["loops_repeated"]
    assert "another type" in str(refused(tmp_path, OPEN, text.replace("revolute", "ball")))


def test_what_closes_no_loop_is_passed_over(tmp_path):
    extras = (
        '<gazebo reference="a"><material>Gazebo/Red</material><joint type="ball"/></gazebo>',
        '<gazebo><plugin name="p"><leftJoint>j1</leftJoint><bodyName>a</bodyName></plugin>'
        "<plugin name='q'><bodyName>b</bodyName><frameName>c</frameName></plugin></gazebo>",
    )
    draft = draft_of(tmp_path, OPEN, *extras)
    assert not draft.loops and not codes(draft)
    draft = draft_of(tmp_path, OPEN, '<gazebo><joint name="l" type="revolute"/></gazebo>')
    assert codes(draft) == ["unread_closure"]
