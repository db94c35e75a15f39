"""Loops in the words of other tools are refused with the element to write, never ignored."""

import pytest
from refusals import said_of
from urdf_text import INERTIAL

TREE = "".join(
    [
        '<link name="base"/>', *(f'<link name="{name}">{INERTIAL}</link>' for name in "abc"),
        *(
            f'<joint name="j{child}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{x} 1 0"/>'
            '<axis xyz="0 0 1" rpy="0 0 0"/></joint>'
            for parent, child, x in (("base", "a", 0), ("a", "b", 0), ("base", "c", 2))
        ),
    ]
)  # fmt: skip
CLOSURES = {
    "spherical": [
        '<drake:ball_constraint xmlns:drake="d"><drake:ball_constraint_body_A name="b"/>'
        '<drake:ball_constraint_body_B name="c"/></drake:ball_constraint>',
        '<constraint name="l" type="spherical_joint"><parent link="b"/><child link="c"/>'
        "</constraint>",
        '<mujoco><equality><connect body1="b" body2="c" anchor="2 0.5 0"/></equality></mujoco>',
        '<gazebo><joint name="l" type="ball"><parent>b</parent><child>c</child></joint>'
        "</gazebo>",
    ],
    "revolute": [
        '<gazebo><joint name="l" type="revolute"><parent>b</parent><child>c</child></joint>'
        "</gazebo>",
    ],
    "fixed": ['<mujoco><equality><weld body1="b" body2="c"/></equality></mujoco>'],
}


@pytest.mark.parametrize(
    "kind, text", [(kind, text) for kind, texts in CLOSURES.items() for text in texts]
)
def test_a_loop_of_another_tool_is_refused(kind, text, robot, capsys):
    said = said_of(robot(f'<robot name="r">\n{TREE}\n{text}</robot>'), capsys)
    assert "closes a loop" in said and "(line 3)" in said
    assert f'<loop name="…" type="{kind}">' in said
    assert '<predecessor link="b">' in said and '<successor link="c">' in said


@pytest.mark.parametrize(
    "text",
    [
        '<drake:linear_bushing_rpy xmlns:drake="d"><drake:bushing_frameA name="f"/>'
        '<drake:bushing_frameC name="g"/></drake:linear_bushing_rpy>',
        '<gazebo><plugin name="gz::sim::systems::DetachableJoint"/></gazebo>',
    ],
)
def test_so_is_one_that_does_not_name_its_links(text, robot, capsys):
    said = said_of(robot(f'<robot name="r">{TREE}{text}</robot>'), capsys)
    assert "closes a loop" in said and '<predecessor link="…">' in said


def test_what_closes_no_loop_is_passed_over(read):
    extras = (
        '<gazebo reference="a"><material>Gazebo/Red</material></gazebo>',
        '<mujoco><compiler meshdir="m"/><equality/></mujoco>',
    )
    assert len(read(TREE, *extras).joints) == 3


def test_a_turned_axis_is_refused(robot, capsys):
    text = TREE.replace('1" rpy="0 0 0"', '1" rpy="0 0.1 0"', 1)
    said = said_of(robot(f'<robot name="r">{text}</robot>'), capsys)
    assert "<axis rpy> is not read" in said
