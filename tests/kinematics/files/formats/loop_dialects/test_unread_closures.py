"""Elements that name two links and are not read are told of; usual ones are not."""

import pytest

from tests.support.dialect_text import OPEN, codes, draft_of

TOLD = [
    '<closure first="b" second="c"/>',
    '<gazebo><plugin name="closed_loop"><l1>b</l1><l2>c</l2></plugin></gazebo>',
    '<mujoco><custom><tie body="b" to="c"/></custom></mujoco>',
    '<x:tie xmlns:x="y"><end>b</end><end>r::c</end></x:tie>',
    '<tie links="b c"/>',
    '<tie links="b, c"/>',
    '<gazebo><joint:hinge name="h" xmlns:joint="y"><body1>b</body1><body2>c</body2>'
    "</joint:hinge></gazebo>",
    '<cnstraint><parent link="b"/><child link="c"/></cnstraint>',
]
HARMLESS = [
    '<disable_collisions link1="b" link2="c" reason="Adjacent"/>',
    '<mujoco><contact><exclude body1="b" body2="c"/></contact></mujoco>',
    '<gazebo reference="b"><selfCollide>c</selfCollide></gazebo>',
    '<transmission name="t"><joint name="b"/><actuator name="c"/></transmission>',
    '<drake:collision_filter_group xmlns:drake="d" name="g"><drake:member link="b"/>'
    '<drake:member link="c"/></drake:collision_filter_group>',
    '<gazebo><plugin name="p"><bodyName>b</bodyName><frameName>c</frameName></plugin></gazebo>',
    '<gazebo><sensor name="s"><contact>b</contact><parent>c</parent></sensor></gazebo>',
    "<gazebo><a>b</a><a>c</a></gazebo>",
    '<group name="g"><chain base_link="b" tip_link="c"/></group>',
    '<frame name="b" link="c"/>',
    '<note first="b" second="b"/>',
]


@pytest.mark.parametrize("text", TOLD)
def test_a_closure_without_a_known_word(text, tmp_path):
    draft = draft_of(tmp_path, OPEN, text)
    assert codes(draft) == ["unread_closure"]
    (said,) = [n.message for n in draft.notices if n.code == "unread_closure"]
    assert "'b', 'c'" in said and "(line" in said and "<loop>" in said


@pytest.mark.parametrize("text", HARMLESS)
def test_usual_elements(text, tmp_path):
    assert not codes(draft_of(tmp_path, OPEN, text))


def test_links_called_like_numbers(tmp_path):
    text = OPEN.replace('"a"', '"1"').replace('"b"', '"0"')
    assert not codes(draft_of(tmp_path, text, '<note first="0" second="1"/>'))
