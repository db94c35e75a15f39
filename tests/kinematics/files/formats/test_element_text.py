"""Texts of elements survive xacro: loops, transmissions and plugins keep them."""

from xml.etree import ElementTree

import pytest

from balance.app.cli.main import main
from kinematics.files.formats.robot_files import read_robot
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.model.document.write_numbers import element_text
from tests.support.urdf_text import INERTIAL

HINGE = (
    '<parent link="{}"/><child link="{}"/><origin xyz="{} {} 0"/><axis xyz="0 0 1"/></joint>'
)
ENDS = {
    "j1": ("base", "a", "0", "0"),
    "j2": ("a", "b", "0", "${half}"),
    "j3": ("base", "c", "1.5", "0"),
}
# The hinge that closes the four-bar linkage, in the words of Gazebo.
CLOSING = (
    '<gazebo><joint name="k" type="revolute"><parent>b</parent><child>c</child>'
    "<pose>${half - 0.5} 1 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></gazebo>"
)
FOREIGN = (
    '<transmission name="t"><type>a/B &lt; C &amp; D</type><joint name="j1">'
    "<hardwareInterface>effort</hardwareInterface></joint></transmission>"
    '<gazebo><plugin name="p" filename="q"><topic>\n one\n two </topic></plugin></gazebo>'
)


@pytest.fixture
def model(tmp_path):
    """A four-bar linkage in xacro whose loop is told by texts."""
    links = "".join(f'<link name="{name}">{INERTIAL}</link>' for name in "abc")
    joints = "".join(
        f'<joint name="{name}" type="revolute">{HINGE.format(*ends)}'
        for name, ends in ENDS.items()
    )
    path = tmp_path / "robot.urdf.xacro"
    path.write_text(
        '<robot name="m" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:property name="half" value="0.5"/><link name="base"/>'
        f"{links}{joints}{CLOSING}{FOREIGN}</robot>",
        encoding="utf-8",
    )
    return path


def texts(document):
    """Tags and texts of a file, by a parser that the product does not use."""
    root = ElementTree.fromstring(document)
    return [(item.tag, (item.text or "").strip()) for item in root.iter() if item.text]


@pytest.mark.slow
def test_a_design_can_be_read_and_keeps_the_elements_of_others(model, capsys):
    out = model.with_name("out.urdf")
    words = ["design", str(model), "--balance", "force", "--keep", "b", "--out", str(out)]
    assert main(words) == 0
    assert main(["verify", str(out), "--balance", "force"]) == 0
    found = dict(texts(out.read_bytes()))
    assert found["type"] == "a/B < C & D" and found["hardwareInterface"] == "effort"
    assert found["topic"].split() == ["one", "two"]


@pytest.mark.slow
def test_files_of_remedies_can_be_read_and_are_balanced(model, capsys):
    folder = model.with_name("remedies")
    words = ["remedies", str(model), "--only", "own_masses", "--out", str(folder)]
    assert main([*words, "--balance", "force"]) == 0
    (written,) = folder.glob("*.urdf")
    assert main(["verify", str(written), "--balance", "force"]) == 0


def test_a_closed_pose_keeps_the_loop(model, capsys):
    out = model.with_name("closed.urdf")
    assert main(["report", str(model), "--write-closed", str(out)]) == 0
    assert main(["report", str(out)]) == 0
    assert "1 loop" in capsys.readouterr().out


def test_what_is_written_is_read_again():
    text = '<robot name="r"><a>x &lt;&amp;&gt; "y"&#13;\n\nz</a><b k="1">w<c/></b><d/></robot>'
    tree = build_tree(text.encode())
    again = build_tree(element_text(tree).encode())
    pairs = zip(tree.walk(), again.walk(), strict=True)
    assert all((a.tag, a.attributes, a.text) == (b.tag, b.attributes, b.text) for a, b in pairs)


def test_the_document_of_a_xacro_file_has_its_texts(model):
    document = read_robot(model).document
    assert document is not None
    assert ("xyz", "0 0 1") in texts(document.data) and ("parent", "b") in texts(document.data)
