"""xacro: expanded files give what their URDF gives; errors of xacro are one line."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kinematics.files.formats import expand_xacro as module
from kinematics.files.formats.robot_files import read_files, read_robot, read_unassembled
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.model.document.element import Document
from tests.support.urdf_text import FOUR_BAR, refusal

HEAD = '<robot name="m" xmlns:xacro="http://www.ros.org/wiki/xacro">'
MACRO = (
    '<xacro:macro name="bar" params="name mass"><link name="${name}"><inertial>'
    '<origin xyz="${length / 2} 0 0"/><mass value="${mass}"/>'
    '<inertia ixx="1" iyy="1" izz="1"/></inertial></link></xacro:macro>'
)
BODY = (
    '<link name="base"/><xacro:bar name="arm" mass="${2 * 3}"/>'
    '<joint name="j" type="revolute"><parent link="base"/><child link="arm"/>'
    '<origin xyz="$(arg reach) 0 0" rpy="0 0 ${pi / 2}"/><axis xyz="0 0 1"/></joint></robot>'
)
LENGTH = '<xacro:property name="length" value="0.5"/>'
REACH = '<xacro:arg name="reach" default="2"/>'


def saved(folder, text, name="m.urdf.xacro"):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def check(draft):
    (joint,), (body,) = draft.joints, draft.bodies
    assert np.abs(joint.screw - [0, 0, 1, 0, -2, 0]).max() < 1e-15
    assert body.inertia[0] == 6.0 and np.abs(body.inertia[1:4] - [12, 1.5, 0]).max() < 1e-12


def test_macros_properties_and_arguments(tmp_path):
    check(read_unassembled(saved(tmp_path, HEAD + REACH + LENGTH + MACRO + BODY)))


def test_the_text_of_a_stream():
    data = (HEAD + REACH + LENGTH + MACRO + BODY).encode()
    check(read_unassembled(Document("<stdin>", data)))


@pytest.mark.parametrize(
    "name", ["parts/bar.xacro", "$(find other)/bar.xacro", "$(find mine)/more/bar.xacro"]
)
def test_files_that_are_included(tmp_path, name):
    """Beside the file, in its package, and in a package beside that one."""
    for package in ("mine", "other"):
        line = f"<package><name>{package}</name></package>"
        saved(tmp_path / package, line, "package.xml")
    place = name.replace("$(find ", "").replace(")", "")
    home = tmp_path if "find" in name else tmp_path / "mine" / "urdf"
    saved(home, f"{HEAD}{MACRO}</robot>", place)
    text = f'{HEAD}{REACH}{LENGTH}<xacro:include filename="{name}"/>{BODY}'
    check(read_unassembled(saved(tmp_path / "mine" / "urdf", text)))


def test_an_old_manifest_in_a_folder_of_a_package(tmp_path):
    """It makes a package of that folder, and not of every name that is asked for."""
    home = tmp_path / "mine" / "urdf"
    saved(tmp_path / "mine", "<package><name>mine</name></package>", "package.xml")
    saved(home, "<package/>", "manifest.xml")
    saved(tmp_path / "mine", f"{HEAD}{MACRO}</robot>", "more/bar.xacro")
    include = '<xacro:include filename="$(find mine)/more/bar.xacro"/>'
    check(read_unassembled(saved(home, f"{HEAD}{REACH}{LENGTH}{include}{BODY}")))


def test_another_current_folder(tmp_path):
    saved(tmp_path, f"{HEAD}{MACRO}</robot>", "bar.xacro")
    text = f'{HEAD}{REACH}{LENGTH}<xacro:include filename="bar.xacro"/>{BODY}'
    path = saved(tmp_path, text)
    check(read_unassembled(os.path.relpath(path)))


WRONG = {
    "argument": (HEAD + LENGTH + MACRO + BODY, "reach"),
    "property": (HEAD + REACH + MACRO + BODY, "length"),
    "macro": (HEAD + REACH + LENGTH + BODY, "bar"),
    "include": (f'{HEAD}<xacro:include filename="nowhere.xacro"/></robot>', "nowhere.xacro"),
    "package": (f'{HEAD}<xacro:include filename="$(find nowhere)/x"/></robot>', "nowhere"),
    "endless": (
        f'{HEAD}<xacro:macro name="a"><xacro:a/></xacro:macro><xacro:a/></robot>',
        "end",
    ),
    "expression": (f'{HEAD}<link name="${{1 +}}"/></robot>', "xacro"),
    "zero": (f'{HEAD}<link name="${{1 / 0}}"/></robot>', "zero"),
    "import": (f'{HEAD}<link name="${{__import__(1)}}"/></robot>', "import"),
    "memory": (f"{HEAD}<link name=\"${{len('a' * 10**10)}}\"/></robot>", "without end"),
}


@pytest.mark.table(2)
@pytest.mark.parametrize("case", WRONG)
def test_errors_of_xacro_are_one_line(tmp_path, case, capfd):
    text, words = WRONG[case]
    error = refusal(saved(tmp_path, text))
    assert words in str(error) and "Traceback" not in str(error)
    assert capfd.readouterr() == ("", "")


def test_what_the_expansion_holds_is_checked(tmp_path):
    text = HEAD + REACH + LENGTH + MACRO + BODY
    error = refusal(saved(tmp_path, text.replace('xyz="0 0 1"', 'xyz="0 0 ${0 * 1}"')))
    assert "joint 'j'" in str(error) and "zero" in str(error)


def test_an_expansion_has_its_time(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "MAX_SECONDS", 0.5)
    path = saved(tmp_path, f'{HEAD}<link name="${{len(range(1)) + 9**9**9}}"/></robot>')
    assert "more than 0.5 s" in str(refusal(path))


def test_the_packages_are_optional(tmp_path, monkeypatch):
    """The worker has the packages; without them the error says how to get them."""
    fake = saved(tmp_path, "raise ModuleNotFoundError(name='xacrodoc')", "lib/xacrodoc.py")
    monkeypatch.setenv("PYTHONPATH", str(fake.parent))
    error = refusal(saved(tmp_path, HEAD + REACH + LENGTH + MACRO + BODY))
    assert "pip install xacrodoc" in error.remedy and "run xacro first" in error.remedy


def test_a_namespace_alone_is_no_xacro(tmp_path, monkeypatch):
    """Files that xacro has written declare it."""
    monkeypatch.setattr(module.subprocess, "run", None)
    path = saved(tmp_path, FOUR_BAR, "robot.urdf")
    assert read_robot(path).document is None


@pytest.mark.parametrize("name", ["m.yaml", "m.urdf.yaml"])
def test_the_loops_may_be_in_a_file_beside(tmp_path, name):
    two = (
        '<link name="tip"/><joint name="k" type="revolute"><parent link="base"/>'
        '<child link="tip"/><origin xyz="2 0 0"/><axis xyz="0 0 1"/></joint></robot>'
    )
    text = HEAD + REACH + LENGTH + MACRO + BODY.replace("</robot>", two)
    saved(tmp_path, "closed_loop: [[arm, tip]]\ntype: [3d]\n", name)
    file = read_files(saved(tmp_path, text), None, ReadOptions())
    assert len(file.tree.every("loop")) == 1


def test_sdf_with_xacro(tmp_path):
    text = (
        '<sdf version="1.9" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:property name="m" value="6"/><model name="m"><link name="base"/>'
        '<link name="arm"><pose>2 0 0 0 0 ${pi/2}</pose><inertial><pose>0.25 0 0 0 0 0</pose>'
        "<mass>${m}</mass></inertial></link><joint name='j' type='revolute'>"
        "<parent>base</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>"
        "</model></sdf>"
    )
    check(read_unassembled(saved(tmp_path, text, "m.sdf.xacro")))


def test_plain_urdf_starts_no_reader_of_other_formats(tmp_path):
    """Nor does it load numpy."""
    path = saved(tmp_path, FOUR_BAR, "robot.urdf")
    code = (
        "import sys; from kinematics.files.formats.robot_files import read_robot; "
        f"read_robot({str(path)!r}); print([name for name in sys.modules if name in "
        "('numpy', 'kinematics.files.formats.expand_xacro', 'kinematics.files.formats.sdf')])"
    )
    root = Path(__file__).parents[4]
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
