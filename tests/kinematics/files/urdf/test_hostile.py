"""Files that attack, lie or break off: one line, exit code 3, and nothing on stdout.

Each row of the table says what is done to the general four-bar, and what the line must say:
which element, what is wrong with it, and what to do about it.
"""

import json
import re

import pytest

from balance.app.cli.main import main
from kinematics import gallery
from tests.support.refusals import said_of

TEXT = gallery()["four_bar_general"].read_text(encoding="utf-8")
J = next(line for line in TEXT.splitlines() if '<joint name="q2"' in line)
LINE = TEXT.splitlines().index(J) + 1
ORIGIN = TEXT.splitlines()[LINE].strip()
AXIS = TEXT.splitlines()[LINE + 3].strip()
MASS = re.search(r"<mass [^>]*>", TEXT)[0]
LOOP = next(line.strip() for line in TEXT.splitlines() if "<loop " in line)
JOINT2 = f"joint 'q2' (line {LINE})"
ENTITIES = "<!DOCTYPE robot [<!ENTITY a 'b'>" + "".join(
    f"<!ENTITY a{i} '{f'&a{i - 1};' * 9}'>" for i in range(1, 9)
)


def changed(old, new):
    """The four-bar with the first occurrence of a text in joint q2 or after it replaced."""
    head, tail = TEXT[: TEXT.index(J)], TEXT[TEXT.index(J) :]
    return head + tail.replace(old, new, 1) if old in tail else TEXT.replace(old, new, 1)


def after(text, new):
    return changed(text, text + new)


# What the file holds; the element; what is wrong with it; what to do about it.
ROWS = {
    "entity expansion": (ENTITIES + "]>" + TEXT.partition("?>")[2], "<!DOCTYPE> (line 1)",
        "entities are not accepted", "remove the DOCTYPE"),
    "external entity": ("<!DOCTYPE r [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>"
        "<robot name='r'>&x;</robot>", "<!DOCTYPE>", "entities", "remove the DOCTYPE"),
    "any doctype": ("<!DOCTYPE robot>" + TEXT.partition("?>")[2], "<!DOCTYPE>", "entities",
        "remove the DOCTYPE"),
    "undefined entity": (changed(ORIGIN, "&lol;" + ORIGIN), f"line {LINE + 1}",
        "undefined entity", "write the character itself"),
    "not a number": (changed('xyz="', 'xyz="nan '), JOINT2, '<origin xyz="nan', "xyz="),
    "infinite": (changed('rpy="0', 'rpy="inf'), JOINT2, '<origin rpy="inf', 'rpy="0.5'),
    "overflow": (changed('rpy="0', 'rpy="1e999'), JOINT2, "1e999", 'rpy="0.5'),
    "far turn": (changed('rpy="0', 'rpy="1e9'), JOINT2, "an angle beyond 10000 rad",
        "between -π and π"),
    "xacro value": (changed('rpy="0', 'rpy="${x}'), "", "name 'x' is not defined",
        "correct the file"),
    "decimal comma": (changed('rpy="0', 'rpy="2,5'), JOINT2, "2,5", 'rpy="0.5'),
    "axis of four": (changed(AXIS, '<axis xyz="0 0 1 0"/>'), JOINT2, '<axis xyz="0 0 1 0">',
        'xyz="0.5 0 -1e-3"'),
    "axis of zero": (changed(AXIS, '<axis xyz="0 0 0"/>'), JOINT2,
        f"<axis> (line {LINE + 4}) is zero", 'xyz="0 0 1"'),
    "mass": (TEXT.replace(MASS, '<mass value="NaN"/>', 1), "link 'crank'",
        '<mass value="NaN">', 'value="0.5"'),
    "link twice": (TEXT.replace('<link name="coupler"', '<link name="crank"'),
        "link 'crank'", "is taken by link 'crank'", "rename this link"),
    "joint twice": (changed('name="q2"', 'name="u1"'), "joint 'u1'", "is taken by joint 'u1'",
        "rename this joint"),
    "loop twice": (after("</loop>", "\n" + TEXT[TEXT.index(LOOP) : TEXT.index("</robot>")]),
        "loop 'q3'", "is taken by loop 'q3'", "rename this loop"),
    "two parents": (TEXT.replace('<child link="rocker"', '<child link="coupler"'),
        "joint 'q4'", "'coupler' is already the child of joint 'q2'", "<loop> element"),
    "to itself": (changed('parent link="crank"', 'parent link="coupler"'), JOINT2,
        "joins link 'coupler' to itself", "correct its <parent> or its <child>"),
    "cycle": (TEXT.replace('parent link="base"', 'parent link="coupler"', 1), "joint 'u1'",
        "'coupler', 'crank' form a cycle", "<loop> element"),
    "no root": (TEXT.replace('parent link="base"', 'parent link="coupler"', 1).replace(
        '<link name="base"/>', "").replace('"base"', '"crank"'), "joint 'u1'",
        "form a cycle of joints", "<loop> element"),
    "loose link": (after('<link name="base"/>', '<link name="stray"/>'), "link 'stray'",
        "a loose link: no joint connects it to the others", "fixed joint"),
    "unknown link": (changed('child link="coupler"', 'child link="couple"'), JOINT2,
        "child link 'couple' does not exist", "the links are 'base', 'crank', 'coupler'"),
    "unknown link of a loop": (TEXT.replace('successor link="rocker"',
        'successor link="rock"'), "loop 'q3'", "successor link 'rock' does not exist",
        "'rocker'"),
    "xacro element": (after(ORIGIN, "<xacro:if/>"), "", "unbound prefix", "declare it"),
    "xacro by another prefix": (TEXT.replace("<robot",
        '<robot xmlns:x="http://www.ros.org/wiki/xacro"').replace(ORIGIN, "<x:property/>", 1),
        "<x:property> (line", "a xacro element", "run xacro first"),
    "namespace of its own": (changed(AXIS, '<d:axis xyz="0 0 1"/>').replace("<robot",
        '<robot xmlns:d="d"'), f"<d:axis> (line {LINE + 4})",
        "<d:axis> in <joint> is not read",
        "write <axis>"),
    "root of a namespace": (TEXT.replace("<robot", "<u:robot").replace("</robot",
        "</u:robot"), "u:robot", "the root element is not <robot>", "URDF"),
    "colon": (changed("rpy=", "rpy:="), f"<origin> (line {LINE + 1})",
        "'rpy:' begins or ends with a colon", "remove the colon"),
    "misspelt element": (changed(AXIS, AXIS.replace("axis", "Axis")),
        f"<Axis> (line {LINE + 4})", "<Axis> in <joint> is not read",
        "write <axis>, or remove it"),
    "misspelt attribute": (changed("rpy=", "ryp="), f"<origin> (line {LINE + 1})",
        "<origin ryp> is not read", "write xyz or rpy, or remove it"),
    "misspelt loop": (TEXT.replace("<loop ", "<lop ").replace("</loop", "</lop"), "lop 'q3'",
        "<lop> in <robot> is not read", "write <loop>"),
    "misspelt input": (TEXT.replace("independent", "independant"), "joint 'u1'",
        "<joint independant> is not read", "write independent"),
    "buried axis": (changed(AXIS, f"<group>{AXIS}</group>"), f"<axis> (line {LINE + 4})",
        f"inside <group> (line {LINE + 4}), where it is not read", "move it out of <group>"),
    "buried loop": (TEXT.replace(LOOP, f"<gazebo>{LOOP}").replace("</loop>",
        "</loop></gazebo>"), "loop 'q3'", "a loop inside another element", "into <robot>"),
    "misplaced mass": (after("</loop>", "<mass/>"), "<mass> (line",
        "<mass> in <robot> is not read", "move it into its <inertial>"),
    "misplaced and misspelt": (after("</loop>", '<xais xyz="0 0 1"/>'), "<xais> (line",
        "<xais> in <robot> is not read", "write <axis> and move it into its <joint> or <loop>"),
    "numbers as text": (changed(ORIGIN, "<origin>1 0 0</origin>"), "<origin> (line",
        "the text '1 0 0' in <origin> is not read", "as elements and attributes"),
    "quoted element": (changed(AXIS, f"<![CDATA[{AXIS}]]>"), JOINT2, "the text '<axis",
        "as elements and attributes"),
    "loop of another tool": (after("</loop>", "<loop_joint name='l'/>"), "loop_joint 'l'",
        "does not name two links", "<loop name="),
    "far mimic": (after(AXIS, '<mimic joint="u1" offset="1e9"/>'), JOINT2,
        "its <mimic> places it at 1e+09 rad, which is out of range", "correct the offsets"),
    "UTF-32": (TEXT.encode("utf-32"), "", "text in UTF-32", "save it as UTF-8"),
    "unknown encoding": ('<?xml version="1.0" encoding="klingon"?><robot/>', "",
        "unknown encoding", "save it as UTF-8"),
    "binary": (bytes(range(256)), "line 1", "not well-formed XML", "export or save it again"),
    "nothing": ("", "", "empty file", "export or save it again"),
}  # fmt: skip


@pytest.mark.table(16)
@pytest.mark.parametrize("case", ROWS)
def test_refused_in_one_line(case, tmp_path, capsys):
    content, element, problem, remedy = ROWS[case]
    assert content != TEXT
    path = tmp_path / "robot.urdf"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    line = said_of(path, capsys)
    assert line.startswith("/robot.urdf: ")
    where, what, todo = (line.find(part) for part in (element, problem, remedy))
    assert 0 <= where <= what < todo or 0 <= what <= where < todo, line


@pytest.mark.table
@pytest.mark.parametrize("percent", range(10, 100))
def test_truncated(percent, tmp_path, capsys):
    data = TEXT.encode()
    path = tmp_path / "robot.urdf"
    path.write_bytes(data[: len(data) * percent // 100])
    line = said_of(path, capsys)
    assert re.search(r"not well-formed XML at line \d+, column \d+ \(.+\); ", line)
    assert line.endswith("; export or save it again")


YAML = "closed_loop: [[coupler_tip, rocker_tip]]\n"
BESIDE = {
    "unknown key": (YAML + "colour: red\n", "colour (line 2)", "unknown key", "the keys are"),
    "unequal lists": (YAML + "type: [3d, 6d]\n", "type (line 2)",
        "2 types for the 1 entries of closed_loop", "a type for each"),
    "anchors bomb": ("a: &a [x, x]\n" + "".join(f"b{i}: [*a, *a]\n" for i in range(99)),
        "line 1", "an anchor or an alias", "write the names out"),
    "object": (YAML + "type: !!python/object/apply:os.system ['exit 1']\n", "line 2",
        "the tag 'tag:yaml.org,2002:python/object/apply:os.system'", "write plain names"),
    "frame again": (YAML.replace("]]", "], [crank, rocker_tip]]"), "closed_loop (line 1)",
        "'rocker_tip' of 'crank/rocker_tip' is a frame of 'coupler_tip/rocker_tip' too",
        "give each pair frames of its own"),
    "unknown frame": (YAML.replace("rocker_tip", "rocket"), "closed_loop (line 1)",
        "'rocket' does not exist", "correct the name"),
    "cut": (YAML[:-4], "", "not readable as YAML at line", "write keys with lists"),
}  # fmt: skip


@pytest.mark.parametrize("case", BESIDE)
@pytest.mark.parametrize("explicit", [True, False])
def test_refused_beside(case, explicit, tmp_path, capsys):
    content, element, problem, remedy = BESIDE[case]
    frames = "".join(
        f'<link name="{end}_tip"/><joint name="t_{end}" type="fixed"><parent link="{end}"/>'
        f'<child link="{end}_tip"/></joint>'
        for end in ("coupler", "rocker")
    )
    text = TEXT[: TEXT.index("<loop")] + frames + "</robot>"
    path, beside = tmp_path / "robot.urdf", tmp_path / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    beside.write_text(content if case != "anchors bomb" else YAML + content, encoding="utf-8")
    line = said_of(path, capsys, *(["--loops", str(beside)] if explicit else []))
    assert line.startswith("/robot.yaml: ")
    element = element.replace("line 1", "line 2") if case == "anchors bomb" else element
    where, what, todo = (line.find(part) for part in (element, problem, remedy))
    assert 0 <= where < what < todo or (element == "" and 0 <= what < todo), line


# mass and moments ixx iyy izz of the crank, and the inequality that they break, if any
BODIES = {
    "negative mass": ("-1", "1 1 1", "mass -1 kg breaks m ≥ 0"),
    "negative moment": (
        "1",
        "-0.5 1 1",
        "principal moment -0.5 kg m² of its inertia breaks I₁ ≥ 0",
    ),
    "triangle": (
        "1",
        "1 1 3",
        "principal moments 1, 1 and 3 kg m² of its inertia break I₃ ≤ I₁ + I₂",
    ),
    "both": ("-1", "1 1 3", "mass -1 kg breaks m ≥ 0, principal moments 1, 1 and 3"),
    "flat": ("1", "1 2 3", ""),
    "flat to six digits": ("1", "1.00000 2.00000 3.00001", ""),
    "rod": ("1", "0 2 2", ""),
    "point": ("1", "0 0 0", ""),
}


@pytest.mark.parametrize("case", BODIES)
def test_bodies_that_cannot_be_are_named_and_change_no_rank(case, tmp_path, caplog, capsys):
    mass, moments, broken = BODIES[case]
    ixx, iyy, izz = moments.split()
    crank = re.search(r'<link name="crank">.*?</link>', TEXT, re.DOTALL)[0]
    body = f'<mass value="{mass}"/><inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}"/>'
    new = f'<link name="crank"><inertial>{body}</inertial></link>'
    path = tmp_path / "robot.urdf"
    path.write_text(TEXT.replace(crank, new), encoding="utf-8")
    assert main(["report", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["rank"], report["nullity"]) == (8, 4)
    messages = [w["message"] for w in report["warnings"] if w["code"] == "unphysical"]
    if not broken:
        assert messages == []
        return
    (message,) = messages
    line = TEXT[: TEXT.index(crank)].count("\n") + 1
    assert message.startswith(f"{path}: link 'crank' (line {line}): {broken}")
    assert "; correct it where the file was exported" in message
    assert f"unphysical: {message}" in caplog.messages


MEANT_WELL = {
    "no limits": TEXT.replace("continuous", "revolute"),
    "byte order mark": TEXT.encode("utf-8-sig"),
    "UTF-16": TEXT.encode("utf-16"),
    "line ends": TEXT.replace("\n", "\r\n"),
    "old line ends": TEXT.replace("\n", "\r"),
    "comments": TEXT.replace("<axis", "<!-- a <b/> --><axis"),
    "default namespace": TEXT.replace("<robot", '<robot xmlns="http://drake.mit.edu"'),
    "other namespaces": TEXT.replace("<robot", '<robot xmlns:d="d" d:version="2"').replace(
        "</robot>", "<d:note d:a='1'><d:b/></d:note></robot>"
    ),
    "xacro declared": TEXT.replace("<robot", '<robot xmlns:xacro="http://ros.org/wiki/xacro"'),
    "elements of other tools": TEXT.replace(
        "</loop>", "</loop><gazebo><joint/></gazebo><ros2_control><joint/></ros2_control>"
    ).replace("<axis", "<limit lower='a'/><axis", 3),
}


@pytest.mark.parametrize("case", MEANT_WELL)
def test_read_as_meant(case, tmp_path, capsys):
    content = MEANT_WELL[case]
    path = tmp_path / "robot.urdf"
    data = content if isinstance(content, bytes) else content.encode()
    assert data != TEXT.encode()
    path.write_bytes(data)
    assert main(["report", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["rank"], report["nullity"], report["warnings"]) == (8, 4, [])
