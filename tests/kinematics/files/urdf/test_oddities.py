"""What exporters and hands really write: read as meant, or refused with what to do."""

import numpy as np
import pytest

import kinematics
from kinematics.files.formats.robot_files import read_unassembled
from tests.support.urdf_text import FOUR_BAR, INERTIAL, refusal

PLAIN = FOUR_BAR.replace('<mimic joint="j1" multiplier="1" offset="0"/>', "")
J2 = '<origin xyz="1 0 0"/><axis xyz="0 0 1"/>'
FIRST = '<origin xyz="0 0 0" rpy="0 0 1.5"/>'
AXIS = '<axis xyz="0 0 1"/>'
DECLARATION = '<?xml version="1.0"?>'


def moved(text, line):
    """The text with one line at the head of the robot instead of where it was."""
    assert text.count(line) == 1
    head, robot, rest = text.replace(line, "").partition('xacro">\n')
    return head + robot + line + rest


JOINT1 = PLAIN[PLAIN.index('  <joint name="j1"') : PLAIN.index('  <joint name="j2"')]
CLUTTER = """<limit lower="0" upper="-1"/><dynamics damping="x"/><calibration rising="?"/>
<safety_controller k_velocity=""/><joint_properties friction="0,0"/>"""
SENSOR = """<link name="camera"><visual><geometry><mesh filename="package://a/b.dae"/></geometry>
<material name="m"/><material name="m"/></visual></link><material name="m"/><material name="m"/>
<joint name="cam" type="fixed"><parent link="rocker"/><child link="camera"/><axis xyz="0 0 0"/>
</joint><sensor name="s"><parent link="nowhere"/></sensor>"""
FROZEN = """<link name="t"/><joint name="jt" type="fixed"><parent link="rocker"/>
<child link="t"/><mimic joint="j1" offset="1"/></joint>"""

FIXED = """<link name="t"/><joint name="jt" type="fixed"><parent link="rocker"/>
<child link="t"/><axis xyz="100"/></joint>"""

# Files that mean what the plain one means: text replaced and its replacement.
HARMLESS = {
    "axis not of unit length": ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 25.4"/>'),
    "negative zero": ('xyz="0 0 0" rpy', 'xyz="-0 -0.0 -0e0" rpy'),
    "tabs and line breaks": ('xyz="1 0 0"/><axis', 'xyz="\n\t1\r\n 0\t0 "/><axis'),
    "signs and bare points": ('xyz="1 0 0"/><axis', 'xyz="+1. .0 0.E+0"/><axis'),
    "no xyz": (FIRST, '<origin rpy="0 0 1.5"/>'),
    "origin last": (FIRST + AXIS, AXIS + FIRST),
    "clutter": (FIRST, FIRST + CLUTTER),
    "sensor": ("</robot>", SENSOR + "</robot>"),
    "attributes of other tools": ('type="continuous"', 'type="continuous" id="7" drake:x="1"'),
    "ros2_control": (
        "</robot>",
        '<ros2_control name="c"><joint name="zz"/></ros2_control></robot>',
    ),
    "byte order mark": (DECLARATION, "\ufeff" + DECLARATION),
    "no declaration": (DECLARATION + "\n", ""),
    "processing instruction": (
        "<!-- a comment -->",
        "<?xml-model href='x'?><!-- ${a} $(b) -->",
    ),
    "empty inertial of the ground": (
        '<link name="base"/>',
        '<link name="base"><inertial/></link>',
    ),
    "mimic of a fixed joint": ("</robot>", FROZEN + "</robot>"),
}


@pytest.mark.parametrize("case", [*HARMLESS, "joints first", "line ends"])
def test_harmless(robot, case):
    if case == "joints first":
        text = moved(PLAIN, JOINT1)
    elif case == "line ends":
        text = PLAIN.replace("\n", "\r\n")
    else:
        old, new = HARMLESS[case]
        assert old in PLAIN
        text = PLAIN.replace(old, new)
    expected, draft = read_unassembled(robot(PLAIN)), read_unassembled(robot(text))
    for ours, theirs in zip(draft.joints, expected.joints, strict=True):
        assert ours.name == theirs.name
        np.testing.assert_allclose(ours.screw, theirs.screw, atol=1e-15)
    for ours, theirs in zip(draft.bodies, expected.bodies, strict=True):
        assert ours.name == theirs.name
        np.testing.assert_allclose(ours.inertia, theirs.inertia, atol=1e-15)
    assert draft.mimics == () and draft.named_inputs == expected.named_inputs


@pytest.mark.parametrize("origin", ["", "<origin/>"])
def test_no_origin_is_the_frame_of_the_parent(robot, origin):
    draft = read_unassembled(robot(PLAIN.replace(J2, origin + '<axis xyz="0 0 1"/>')))
    assert draft.joints[1].point.tolist() == [0.0, 0.0, 0.0]


def test_no_axis_is_x(robot):
    draft = read_unassembled(robot(PLAIN.replace(J2, '<origin xyz="1 0 0" rpy="0 0 -1.5"/>')))
    np.testing.assert_allclose(draft.joints[1].screw[:3], [1, 0, 0], atol=1e-15)


def test_an_empty_inertial_is_none(robot):
    empty = PLAIN.replace(INERTIAL, "<inertial>\n</inertial>", 1)
    draft = read_unassembled(robot(empty))
    assert [b.name for b in draft.bodies] == ["coupler", "rocker"]
    assert [n.code for n in draft.notices] == ["massless"]


def test_an_inertial_without_products_of_inertia(robot):
    draft = read_unassembled(
        robot(PLAIN.replace(' ixy="0" ixz="0"', "").replace(' iyz="0"', ""))
    )
    expected = read_unassembled(robot(PLAIN))
    for ours, theirs in zip(draft.bodies, expected.bodies, strict=True):
        assert np.array_equal(ours.inertia, theirs.inertia)


def test_mimic_without_multiplier_and_offset(robot):
    text = FOUR_BAR.replace(' multiplier="1" offset="0"', "")
    (mimic,) = read_unassembled(robot(text)).mimics
    assert (mimic.joint, mimic.source, mimic.ratio) == (2, 0, 1.0)


# Text replaced and its replacement, and words of the one remark.
REMARKED = {
    "axis with angles of zero": (
        AXIS,
        '<axis rpy="0 0 -0.0" xyz="0 0 1"/>',
        "joint 'j1' (line 8) has an <axis rpy> of zeros",
    ),
    "axis of a fixed joint": (
        "</robot>",
        FIXED + "</robot>",
        "joint 'jt' (line 27) is fixed, and its <axis> is not three numbers",
    ),
    "the same origin twice": (
        FIRST,
        FIRST + '<origin rpy="0 0 1.50"/>',
        "joint 'j1' (line 8) has the same <origin> 2 times",
    ),
    "the same origin to the letter": (FIRST, FIRST * 3, "has the same <origin> 3 times"),
    "inertial outside of links": (
        "</robot>",
        INERTIAL + "</robot>",
        "<inertial> (line 27) is in no link, and is not read",
    ),
    "no name": (' name="four_bar"', "", "<robot> (line 2) has no name, that of the file is"),
    "products below the diagonal": (
        'ixy="0" ixz="0"',
        'iyx="0" izx="0"',
        "link 'crank' (line 5) has iyx for ixy, izx for ixz",
    ),
    "product twice": ('ixy="0"', 'ixy="0" iyx="0"', "link 'crank' (line 5) has iyx for ixy"),
    "mark in capitals": (
        'type="revolute">',
        'type="revolute" independent="True">',
        'joint \'j3\' (line 16) has independent="True" for "true"',
    ),
}


@pytest.mark.parametrize("case", REMARKED)
def test_remarked(robot, case):
    old, new, words = REMARKED[case]
    assert old in PLAIN
    plain, odd = PLAIN, PLAIN.replace(old, new, 1)
    if case == "mark in capitals":
        plain = odd.replace("True", "true")
    expected, draft = (read_unassembled(robot(text)) for text in (plain, odd))
    (notice,) = draft.notices
    assert notice.code == "oddities" and words in notice.message
    assert expected.notices == () and draft.named_inputs == expected.named_inputs
    assert draft.name == ("robot" if case == "no name" else expected.name)
    for ours, theirs in zip(draft.joints, expected.joints, strict=True):
        assert ours.name == theirs.name and np.array_equal(ours.screw, theirs.screw)
    for ours, theirs in zip(draft.bodies, expected.bodies, strict=True):
        assert ours.name == theirs.name and np.array_equal(ours.inertia, theirs.inertia)


def test_many_oddities_are_one_remark(robot):
    text = PLAIN.replace(AXIS, '<axis xyz="0 0 1" rpy="0 0 0"/>').replace("ixy", "iyx")
    (notice,) = read_unassembled(robot(text.replace("</robot>", INERTIAL + "</robot>"))).notices
    assert notice.message.count("; ") == 4 and notice.message.endswith("; and 4 more")


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        (AXIS, '<axis xyz="0 0 1" rpy="0 0 1"/>', "<axis rpy> is not read"),
        (FIRST, f"{FIRST}{FIRST[:-2]}>{AXIS}</origin>", "<axis> in <origin> is not read"),
        ('<robot name="four_bar"', '<robot Name="four_bar"', "<robot Name> is not read"),
        ('ixy="0"', 'ixy="0" iyx="0.1"', "<inertia iyx> is not read"),
        ('type="revolute">', 'type="revolute" independent="yes">', "neither true nor false"),
    ],
)
def test_what_may_change_the_model_is_refused(robot, old, new, problem):
    assert problem in refusal(robot(PLAIN.replace(old, new, 1))).problem


# text replaced, replacement, words of the problem, words of the remedy
REFUSED = {
    "axis of a joint that turns": (AXIS, '<axis xyz="001"/>', "001", 'xyz="0.5 0'),
    "two origins": (FIRST, FIRST + "<origin/>", "more than one <origin>", "keep one"),
    "axis of words": (AXIS, '<axis xyz="up"/>', "up", 'xyz="0.5 0'),
    "capital type": ('type="continuous"', 'type="Continuous"', "unknown type 'Continuous'",
        'write type="continuous"'),
    "blank in type": ('type="continuous"', 'type="continuous "', "unknown type",
        'write type="continuous"'),
    "commas between": ('xyz="1 0 0"/><axis', 'xyz="1, 0, 0"/><axis', "1, 0, 0", 'xyz="0.5 0'),
    "decimal comma": ('<mass value="1"/>', '<mass value="1,5"/>', "1,5", 'value="0.5"'),
    "unit": ('<mass value="1"/>', '<mass value="1 kg"/>', "1 kg", 'value="0.5"'),
    "fraction": ('rpy="0 0 1.5"', 'rpy="0 0 pi/2"', "pi/2", 'rpy="0.5'),
    "Fortran": ('xyz="1 0 0"/><axis', 'xyz="1d0 0 0"/><axis', "1d0", 'xyz="0.5'),
    "minus sign of a typesetter": ('rpy="0 0 1.5"', 'rpy="0 0 −1.5"', "−1.5", 'rpy="0.5'),
    "mass as text": ('<mass value="1"/>', "<mass>1</mass>", "<mass value=", "add it"),
    "mass alone": (INERTIAL, '<inertial><mass value="1"/></inertial>', "has no <inertia ixx",
        "remove the <inertial>"),
    "link as text": ('<parent link="crank"/>', "<parent>crank</parent>", "no <parent link=",
        "add <parent link="),
    "blank in a name": ('<parent link="crank"/>', '<parent link="crank "/>',
        "parent link 'crank ' does not exist", "'crank'"),
    "xacro argument": ('xyz="1 0 0"/><axis', 'xyz="$(arg x) 0 0"/><axis', "$(arg x)", "xyz="),
    "instruction first": (DECLARATION, "<?a b?>" + DECLARATION, "declaration not at start",
        "remove what precedes <?xml, blank lines too"),
    "two robots": ("</robot>", "</robot><robot name='s'/>", "junk after document", "export"),
    "moving mimic of a fixed joint": ('name="j1" type="revolute"', 'name="j1" type="fixed"',
        "joint 'j1' (line 8) is fixed", "or fix this joint too"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(robot, case):
    old, new, problem, remedy = REFUSED[case]
    assert old in FOUR_BAR
    error = refusal(robot(FOUR_BAR.replace(old, new, 1)))
    assert problem in error.problem and remedy in error.remedy


@pytest.mark.parametrize(
    ("text", "problem", "remedy"),
    [
        (
            "version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
            "Git LFS",
            "git lfs pull",
        ),
        ("<!DOCTYPE html><html><body>404</body></html>", "entities", "remove the DOCTYPE"),
        ("<html><body>404</body></html>", "not <robot>", "URDF"),
        ("<sdf><model name='m'/></sdf>", "no version", "give SDF 1.4 to 1.12"),
        ("<robot name='r'/>", "no <link>", "links and joints"),
    ],
)
def test_other_files(robot, text, problem, remedy):
    error = refusal(robot(text))
    assert problem in error.problem and remedy in error.remedy


def test_of_many_names_the_close_ones_are_listed(robot):
    links = "".join(f'<link name="link_{k}"/>' for k in range(300))
    error = refusal(
        robot(
            PLAIN.replace('parent link="crank"', 'parent link="cranc"').replace(
                '<link name="base"/>', f'<link name="base"/>{links}'
            )
        )
    )
    assert "'crank'" in error.remedy and len(error.remedy) < 200


def test_a_mimic_joint_of_ratio_zero_rests(robot):
    """Its source and it have no component in common."""
    mimic = '<mimic joint="j1" multiplier="0" offset="0.5"/>'
    text = PLAIN[: PLAIN.index("  <loop")] + "</robot>"
    linkage = kinematics.load(robot(text.replace(J2, J2 + mimic)))
    assert linkage.mobility == 2 and linkage.idle == ("j2",)
