"""A file whose loops were left out by an exporter is asked about, and no other file."""

import xml.etree.ElementTree as ElementTree

import pytest

import kinematics
from kinematics.loading.forgotten_loops import forgotten_loop
from tests.support.command_runs import asked

# Loops that join the ends of two chains.
FORGOTTEN = ("four_bar_general", "five_bar", "eight_bar", "delta", "three_rsr", "four_rrr")


def without_loops(name, shift=0.0):
    """The file of a model without its loops, but with frames where they closed.

    Args:
        shift: distance by which one of the two frames of each loop is moved, metres.
    """
    robot = ElementTree.fromstring(kinematics.gallery()[name].read_text("utf-8"))
    for k, loop in enumerate(robot.findall("loop")):
        robot.remove(loop)
        for side in ("predecessor", "successor"):
            end = loop.find(side)
            ElementTree.SubElement(robot, "link", name=f"{side}{k}")
            joint = ElementTree.SubElement(robot, "joint", name=f"at_{side}{k}", type="fixed")
            ElementTree.SubElement(joint, "parent", link=end.get("link"))
            ElementTree.SubElement(joint, "child", link=f"{side}{k}")
            xyz = [float(word) for word in end.find("origin").get("xyz").split()]
            xyz[0] += shift if side == "successor" else 0.0
            text = " ".join(map(str, xyz))
            ElementTree.SubElement(joint, "origin", xyz=text)
    return ElementTree.tostring(robot, encoding="unicode")


def notices_of(text):
    linkage = kinematics.load(text, bodies="all")
    assert not linkage.loops
    return [notice.message for notice in linkage.notices if notice.code == "no_loop"]


@pytest.mark.parametrize("name", FORGOTTEN)
def test_two_ends_at_one_place_are_told(name):
    (told,) = notices_of(without_loops(name))
    assert told.startswith("no loop: did you forget one? The links '")
    assert "predecessor" in told and "successor" in told
    assert not notices_of(without_loops(name, shift=0.01))


def test_robots_of_the_gallery_are_not_asked():
    """Those with loops, and serial ones."""
    for name in ("five_bar", "hprs", "double_pendulum_duplicates", "principal_vector_linkage"):
        assert not [x for x in kinematics.load(name).notices if x.code == "no_loop"]


def test_fingers_of_a_gripper_start_at_one_place():
    """Each is one joint from the hand that carries both."""
    axes = {"left": "0 1 0", "right": "0 -1 0"}
    fingers = "".join(
        f"<link name='{side}'/><joint name='{side}_slide' type='prismatic'>"
        "<parent link='hand'/>"
        f"<child link='{side}'/><origin xyz='0 0 0.1'/><axis xyz='{axis}'/>"
        "<limit lower='0' upper='0.04' effort='1' velocity='1'/></joint>"
        for side, axis in axes.items()
    )
    text = f"""<robot name='hand'><link name='base'/><link name='arm'/><link name='hand'/>
        <joint name='j1' type='continuous'><parent link='base'/><child link='arm'/></joint>
        <joint name='j2' type='continuous'><parent link='arm'/><child link='hand'/>
        <origin xyz='0.3 0 0'/><axis xyz='0 1 0'/></joint>{fingers}</robot>"""
    assert not notices_of(text)


def test_the_command_says_so(tmp_path):
    path = tmp_path / "tree.urdf"
    path.write_text(without_loops("five_bar"), encoding="utf-8")
    done = asked(["report", str(path)])
    assert done.code == 0 and "no loop: did you forget one?" in done.err


def test_a_loop_is_enough():
    """A file with loops is not asked for more of them."""
    linkage = kinematics.load("five_bar")
    assert linkage.loops and forgotten_loop(linkage) == []
