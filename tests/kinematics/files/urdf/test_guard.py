"""The guard refuses bad files with one line that names file, element, problem, remedy."""

import os
import re
import subprocess
import sys
from itertools import product

import pytest

from kinematics.files.formats.robot_files import read_robot
from tests.support.counted_work import instructions
from tests.support.urdf_text import FOUR_BAR, INERTIAL, refusal

J1_AXIS = '<origin xyz="0 0 0" rpy="0 0 1.5"/><axis xyz="0 0 1"/>'
J2_PLACE = '<parent link="crank"/><child link="coupler"/>'
MIMIC = '<mimic joint="j1" multiplier="1" offset="0"/>'
LOOP_AXIS = '<axis xyz="0 0 1"/>\n  </loop>'
PREDECESSOR = '<predecessor link="coupler"><origin xyz="1 0 0"/></predecessor>'
FIXED_J2 = 'name="j2" type="fixed"'
J2 = 'name="j2" type="continuous"'


def test_a_good_file_becomes_a_tree(robot):
    tree = read_robot(robot(FOUR_BAR)).tree
    assert tree.tag == "robot" and tree.name == "four_bar"
    assert [link.name for link in tree.every("link")] == ["base", "crank", "coupler", "rocker"]
    assert tree.every("joint")[0].label == "joint 'j1' (line 8)"
    assert tree.every("loop")[0].first("axis").vector("xyz", "") == [0.0, 0.0, 1.0]
    assert (
        read_robot(str(robot(FOUR_BAR))).tree
        == read_robot(os.fsencode(robot(FOUR_BAR))).tree
        == tree
    )
    with pytest.raises(AttributeError):
        tree.tag = "other"


# text replaced, replacement, element, words of the problem, words of the remedy
EDITS = {
    "decimal comma": ('xyz="0 0 0"', 'xyz="2,5 0 0"', "joint 'j1' (line 8)",
        '<origin xyz="2,5 0 0"> (line 10) is not 3 finite numbers', 'xyz="0.5 0 -1e-3"'),
    "nan": ('rpy="0 0 1.5"', 'rpy="0 nan 0"', "joint 'j1'", '<origin rpy="0 nan 0">', "rpy="),
    "inf": ('xyz="0 0 0"', 'xyz="inf 0 0"', "joint 'j1'", "finite", "xyz="),
    "overflow": ('xyz="0 0 0"', 'xyz="1e999 0 0"', "joint 'j1'", "finite", "xyz="),
    "out of range": ('xyz="0 0 0"', 'xyz="1e200 0 0"', "joint 'j1'", "finite", "xyz="),
    "underscore": ('xyz="0 0 0"', 'xyz="1_0 0 0"', "joint 'j1'", "1_0", "xyz="),
    "other digits": ('xyz="0 0 0"', 'xyz="٣ 0 0"', "joint 'j1'", "٣", "xyz="),
    "hexadecimal": ('xyz="0 0 0"', 'xyz="0x1 0 0"', "joint 'j1'", "0x1", "xyz="),
    "four numbers": ('xyz="0 0 0"', 'xyz="0 0 0 0"', "joint 'j1'", "3 finite", "xyz="),
    "two numbers": ('xyz="0 0 0"', 'xyz="0 0"', "joint 'j1'", "3 finite", "xyz="),
    "empty": ('xyz="0 0 0"', 'xyz=""', "joint 'j1'", 'xyz=""', "xyz="),
    "quaternion": ('rpy="0 0 1.5"', 'quat_xyzw="0 0 0 1"', "joint 'j1'", "quat_xyzw", "rpy"),
    "two origins": (J1_AXIS, J1_AXIS + "<origin/>", "joint 'j1'", "more than one <origin>",
        "keep one"),
    "axis nan": (J1_AXIS, '<axis xyz="0 0 nan"/>', "joint 'j1'", "finite", "xyz="),
    "axis short": (J1_AXIS, '<axis xyz="1"/>', "joint 'j1'", "3 finite", "xyz="),
    "axis zero": (J1_AXIS, '<axis xyz="0 0 0"/>', "joint 'j1'", "<axis> (line 10) is zero",
        "direction"),
    "axis tiny": (J1_AXIS, '<axis xyz="0 0 1e-300"/>', "joint 'j1'", "is zero", "direction"),
    "axis bare": (J1_AXIS, "<axis/>", "joint 'j1'", "no <axis xyz", "add <axis"),
    "mass empty": ('value="1"', 'value=""', "link 'crank' (line 5)", '<mass value="">',
        'value="0.5"'),
    "mass nan": ('value="1"', 'value="nan"', "link 'crank'", "finite number", "value="),
    "mass without value": ('<mass value="1"/>', "<mass/>", "link 'crank'",
        "has no <mass value", "remove the <inertial>"),
    "no mass": ('<mass value="1"/>', "", "link 'crank'", "has no <mass", "add it"),
    "no inertia": (INERTIAL, '<inertial><mass value="1"/></inertial>', "link 'crank'",
        "has no <inertia ixx", "add it"),
    "no izz": (' izz="1"', "", "link 'crank'", "has no <inertia izz", "add it"),
    "ixy": ('ixy="0"', 'ixy="zero"', "link 'crank'", '<inertia ixy="zero">', "ixy="),
    "izz": ('izz="1"', 'izz="1 1"', "link 'crank'", '<inertia izz="1 1">', "izz="),
    "com": ('xyz="0.5 0 0"', 'xyz="0,5 0 0"', "link 'crank'", "0,5", "xyz="),
    "multiplier": ('multiplier="1"', 'multiplier="x"', "joint 'j3'", '<mimic multiplier="x">',
        "multiplier="),
    "offset": ('offset="0"', 'offset="-inf"', "joint 'j3'", "finite number", "offset="),
    "pitch": (J1_AXIS, '<screw_thread_pitch value="1e999"/>', "joint 'j1'",
        '<screw_thread_pitch value="1e999">', "value="),
    "pitch bare": (J1_AXIS, "<screw_thread_pitch/>", "joint 'j1'", "no <screw_thread_pitch",
        "add"),
    "pitch of a slider": ('revolute" independent="true">',
        'prismatic"><screw_thread_pitch value="1"/>', "joint 'j1'",
        "<screw_thread_pitch> on a prismatic joint", 'type="revolute"'),
    "link twice": ('name="coupler"', 'name="crank"', "link 'crank' (line 6)",
        "is taken by link 'crank' (line 5)", "rename this link"),
    "joint twice": ('name="j2"', 'name="j1"', "joint 'j1' (line 12)",
        "is taken by joint 'j1' (line 8)", "rename this joint"),
    "loop and joint": ('name="k"', 'name="j1"', "loop 'j1'", "taken by joint 'j1'", "rename"),
    "coordinate twice": ('name="k"', 'name="j2.1"', "loop 'j2.1'", "taken by joint 'j2'",
        "rename"),
    "link without name": ('<link name="base"/>', "<link/>", "<link> (line 4)", "no name",
        'add name="…" to <link>'),
    "joint without name": ('name="j1" ', "", "<joint> (line 8)", "no name", "<joint>"),
    "loop with blank name": ('name="k"', 'name=" "', "loop ' ' (line 20)", "no name", "<loop>"),
    "unknown parent": ('parent link="crank"', 'parent link="krank"', "joint 'j2' (line 12)",
        "parent link 'krank' does not exist", "the links are 'base', 'crank'"),
    "unknown child": ('child link="coupler"', 'child link="x"', "joint 'j2'",
        "child link 'x' does not exist", "correct the name"),
    "no parent": ('<parent link="crank"/>', "", "joint 'j2'", "no <parent link", "add"),
    "no child": ('<child link="coupler"/>', "<child/>", "joint 'j2'", "no <child link", "add"),
    "two parents": ('child link="rocker"', 'child link="coupler"', "joint 'j3' (line 16)",
        "'coupler' is already the child of joint 'j2' (line 12)", "<loop> element"),
    "itself": (J2_PLACE, '<parent link="coupler"/><child link="coupler"/>', "joint 'j2'",
        "'coupler' to itself", "<parent>"),
    "cycle": ('<parent link="base"/><child link="crank"/>',
        '<parent link="coupler"/><child link="crank"/>', "joint 'j", "form a cycle", "<loop>"),
    "loose link": ('<link name="base"/>', '<link name="base"/><link name="stray"/>',
        "link 'stray' (line 4)", "a loose link: no joint connects it", "--ground base"),
    "unknown type": (J2, 'name="j2" type="ball"', "joint 'j2'", "unknown type 'ball'",
        "revolute, continuous"),
    "no type": (J2, 'name="j2"', "joint 'j2'", "no type", "choose from"),
    "independent": ('independent="true"', 'independent="yes"', "joint 'j1'",
        'independent="yes"', 'independent="true"'),
    "mimics unknown": ('mimic joint="j1"', 'mimic joint="j9"', "joint 'j3' (line 16)",
        "unknown joint 'j9'", "the joints are 'j1', 'j2', 'j3'"),
    "mimics itself": ('mimic joint="j1"', 'mimic joint="j3"', "joint 'j3'", "mimics itself",
        "be free"),
    "mimics nobody": (MIMIC, "<mimic/>", "joint 'j3'", "no <mimic joint", "add"),
    "mimics a loop": ('mimic joint="j1"', 'mimic joint="k"', "joint 'j3'", "unknown",
        "the joints are"),
    "mimic circle": (J1_AXIS, J1_AXIS + '<mimic joint="j3"/>', "joint 'j", "in a circle",
        "be free"),
    "loop predecessor": ('predecessor link="coupler"', 'predecessor link="x"',
        "loop 'k' (line 20)", "predecessor link 'x' does not exist", "correct the name"),
    "loop successor": ('successor link="rocker"', 'successor link="x"', "loop 'k'",
        "successor link 'x' does not exist", "correct the name"),
    "no predecessor": (PREDECESSOR, "", "loop 'k'", "no <predecessor link", "add"),
    "two predecessors": (PREDECESSOR, PREDECESSOR * 2, "loop 'k'", "more than one", "keep one"),
    "loop type": ('name="k" type="revolute"', 'name="k" type="gear"', "loop 'k'",
        "unknown type 'gear'", "choose from fixed, revolute"),
    "one link": ('successor link="rocker"', 'successor link="coupler"', "loop 'k'",
        "one rigid body", "move apart"),
    "loop axis zero": (LOOP_AXIS, '<axis xyz="0 0 0"/></loop>', "loop 'k'", "is zero", "xyz="),
    "loop axis": (LOOP_AXIS, '<axis xyz="a b c"/></loop>', "loop 'k'", "finite", "xyz="),
    "loop axis2": (LOOP_AXIS, '<axis2 xyz="0 1 0"/></loop>', "loop 'k'",
        "<axis2> on a revolute loop", "remove"),
    "loop origin": ('<successor link="rocker"><origin xyz="1 0 0"/>',
        '<successor link="rocker"><origin xyz="1 0"/>', "loop 'k'", 'xyz="1 0"', "xyz"),
    "loop child": (LOOP_AXIS, "<limit/><gear/></loop>", "loop 'k'", "<limit>, <gear>",
        "predecessor, successor, axis"),
    "loop side": ('<successor link="rocker">', '<successor link="rocker"><axis/>', "loop 'k'",
        "unknown child <axis>", "an origin"),
    "coupling": ("</robot>", '<coupling name="c"/></robot>', "coupling 'c'", "<predecessor>",
        'link="…"'),
    "xacro element": ('<link name="base"/>', '<xacro:include filename="a"/>',
        "", "No such file", "run xacro first"),
    "xacro deep inside": (J1_AXIS, "<xacro:axis/>", "", "unknown macro name: xacro:axis",
        "correct the file"),
    "xacro value": ('xyz="0 0 0"', 'xyz="${a} 0 0"', "", "name 'a' is not defined",
        "correct the file"),
    "doctype": ("<robot", "<!DOCTYPE robot>\n<robot", "<!DOCTYPE> (line 2)", "entities",
        "remove the DOCTYPE"),
    "line break in a name": ('name="j2" type="continuous"', 'name="j&#10;2" type="x"',
        "joint 'j 2'", "the unprintable character U+000A", "rename this joint"),
}  # fmt: skip


@pytest.mark.table
@pytest.mark.parametrize("case", EDITS)
def test_refused(robot, case):
    old, new, element, problem, remedy = EDITS[case]
    assert old in FOUR_BAR
    text = FOUR_BAR.replace(old, new, 1)
    if case == "coordinate twice":
        text = text.replace(J2, 'name="j2" type="planar"')
    error = refusal(robot(text))
    assert error.file.endswith("robot.urdf")
    assert error.element.startswith(element)
    assert problem in error.problem
    assert remedy in error.remedy


SEVERAL = ["planar", "spherical", "cylindrical", "universal"]


@pytest.mark.parametrize(("kind", "end"), [*product(SEVERAL, ["j1", "j3"]), ("fixed", "j1")])
def test_mimics_join_single_freedoms(robot, kind, end):
    text = re.sub(rf'name="{end}" type="\w+"', f'name="{end}" type="{kind}"', FOUR_BAR)
    error = refusal(robot(text))
    assert error.element.startswith("joint 'j3'") and f"'{end}'" in error.problem
    assert "one degree of freedom" in error.problem and "<mimic>" in error.remedy


def test_a_loop_between_rigidly_joined_links(robot):
    text = FOUR_BAR.replace(J2, FIXED_J2).replace('link="rocker"><', 'link="crank"><')
    assert "one rigid body" in refusal(robot(text)).problem


def test_second_axis_of_a_universal_joint_is_perpendicular(robot):
    text = FOUR_BAR.replace(J2, 'name="j2" type="universal"')
    good = text.replace(J2_PLACE, J2_PLACE + '<axis2 xyz="3 1 0"/>')
    read_robot(robot(good))
    error = refusal(robot(good.replace("3 1 0", "3 1 0.001")))
    assert "<axis2>" in error.problem and "perpendicular" in error.problem


def test_fixed_joints_may_have_an_axis_of_zero(robot):
    place = '<origin xyz="1 0 0"/><axis xyz="0 0 1"/>'
    text = FOUR_BAR.replace(place, '<axis xyz="0 0 0"/>')
    assert "'j2'" in refusal(robot(text)).element
    read_robot(robot(text.replace(J2, FIXED_J2)))


def test_cycle_names_its_links(robot):
    text = FOUR_BAR.replace(
        '<parent link="base"/><child link="crank"/>',
        '<parent link="coupler"/><child link="crank"/>',
    )
    problem = refusal(robot(text)).problem
    assert "'crank'" in problem and "'coupler'" in problem and "'rocker'" not in problem


def test_a_refusal_loads_nothing_heavy(robot):
    path = robot(FOUR_BAR.replace('xyz="0 0 0"', 'xyz="nan 0 0"'))
    program = (
        "import sys\n"
        "from kinematics.errors import FileError\n"
        "from kinematics.files.formats.robot_files import read_robot\n"
        "try:\n    read_robot(sys.argv[1])\n"
        "except FileError as error:\n    print(error)\n"
        "print(sorted({'numpy', 'scipy', 'numba', 'yourdfpy', 'lxml'} & set(sys.modules)))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(path)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert "nan" in run.stdout and run.stdout.splitlines()[-1] == "[]"


def mimicking_chain(count):
    """A chain of links; each joint mimics the one before it."""
    parts = ['<robot name="c"><link name="l0"/>']
    for i in range(1, count):
        mimic = f'<mimic joint="j{i - 1}"/>' if i > 1 else ""
        parts.append(
            f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/>'
            f'<child link="l{i}"/>{mimic}</joint>'
        )
    return "".join(parts) + "</robot>"


def test_long_chains_of_joints_and_mimics(robot):
    text = mimicking_chain(1000)
    read_robot(robot(text))
    last = '<child link="l1"/><mimic joint="j999"/>'
    closed = text.replace('<child link="l1"/>', last)
    assert "circle" in refusal(robot(closed)).problem


@pytest.mark.slow
def test_the_work_to_check_a_chain_grows_linearly(robot):
    """Equal steps in the number of joints take equal numbers of instructions."""
    counts = [
        instructions(lambda n=n: read_robot(robot(mimicking_chain(n)))) for n in (100, 200, 300)
    ]
    assert 0 < counts[2] - counts[1] < 1.02 * (counts[1] - counts[0])
