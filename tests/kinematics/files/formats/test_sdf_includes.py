"""SDF files that include others, and models inside models."""

from __future__ import annotations

import numpy as np
import pytest

from kinematics.files.formats.robot_files import read_unassembled
from tests.support.urdf_text import pose_of, refusal

MASS = (
    "<inertial><mass>2</mass><pose>0.1 0 0 0 0 0</pose><inertia><ixx>1</ixx><iyy>2</iyy>"
    "<izz>2.5</izz></inertia></inertial>"
)
# An arm of two links whose second joint has its axis along that of the arm's own frame.
ARM = f"""<sdf version="1.9"><model name="arm"><pose>9 9 9 0 0 0</pose>
<link name="low">{MASS}</link>
<link name="high"><pose relative_to="low">0 0 0.5 0.3 0 0</pose>{MASS}</link>
<joint name="elbow" type="revolute"><parent>low</parent><child>high</child>
<axis><xyz expressed_in="__model__">0 1 0</xyz></axis></joint>
<frame name="tip" attached_to="high"><pose>0 0 0.4 0 0 0</pose></frame></model></sdf>"""
HOST = """<sdf version="1.9"><model name="robot"><link name="base">{mass}</link>
<joint name="fix" type="fixed"><parent>world</parent><child>base</child></joint>
{inside}
<joint name="shoulder" type="revolute"><parent>base</parent><child>{child}</child>
<axis><xyz>0 0 1</xyz></axis></joint>{more}</model></sdf>"""
PLACE = ([0.1, 0.2, 0.3], [0, 0.4, 0])


@pytest.fixture
def files(tmp_path):
    """A folder of models, and what writes the main file."""
    folder = tmp_path / "models" / "arm"
    folder.mkdir(parents=True)
    (folder / "arm_9.sdf").write_text(ARM)
    (folder / "model.config").write_text(
        '<model><name>arm</name><sdf version="1.5">old.sdf</sdf>'
        '<sdf version="1.9">arm_9.sdf</sdf></model>'
    )

    def save(inside, child="left::low", more="", name="robot.sdf"):
        path = tmp_path / name
        path.write_text(HOST.format(mass=MASS, inside=inside, child=child, more=more))
        return path

    return save


def include(uri, name="left", pose="0.1 0.2 0.3 0 0.4 0", marks="", more=""):
    named = f"<name>{name}</name>" if name else ""
    return f"<include {marks}><uri>{uri}</uri>{named}<pose>{pose}</pose>{more}</include>"


def joints(path):
    return {item.name: item for item in read_unassembled(path).joints}


def check_arm(found, prefix):
    """The axes where rigid displacements of the host's place put them."""
    H = pose_of(*PLACE)
    elbow, shoulder = found[f"{prefix}elbow"], found["shoulder"]
    np.testing.assert_allclose(elbow.screw[:3], H[:3, :3] @ [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(
        np.cross(elbow.screw[:3], (H @ [0, 0, 0.5, 1])[:3] - elbow.point), 0, atol=1e-12
    )
    np.testing.assert_allclose(shoulder.screw[:3], H[:3, 2], atol=1e-12)
    np.testing.assert_allclose(
        np.cross(shoulder.screw[:3], np.array(PLACE[0]) - shoulder.point), 0, atol=1e-12
    )


@pytest.mark.parametrize("uri", ["models/arm", "models/arm/arm_9.sdf"])
def test_a_path_relative_to_the_file(files, uri):
    check_arm(joints(files(include(uri))), "left::")


def test_a_model_in_the_folders_of_the_environment(files, tmp_path, monkeypatch):
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", f"/nowhere:{tmp_path / 'models'}")
    check_arm(joints(files(include("model://arm"))), "left::")


def test_a_model_beside_the_folder_of_the_file(files, tmp_path, monkeypatch):
    monkeypatch.delenv("GZ_SIM_RESOURCE_PATH", raising=False)
    (tmp_path / "models" / "host").mkdir()
    check_arm(joints(files(include("model://arm"), name="models/host/robot.sdf")), "left::")


def test_a_name_that_the_file_does_not_give_is_that_of_the_model(files):
    check_arm(joints(files(include("models/arm", name=""), child="arm::low")), "arm::")


def test_a_merged_model_keeps_its_names(files):
    path = files(include("models/arm", marks='merge="true"'), child="low")
    check_arm(joints(path), "")


def test_a_joint_to_a_model_is_one_to_its_first_link(files):
    check_arm(joints(files(include("models/arm"), child="left")), "left::")


def test_two_copies_and_a_frame_inside_one(files):
    second = include("models/arm", "right", "0 0 0 0 0 0").replace(
        "<pose>", '<pose relative_to="left::tip">'
    )
    more = (
        '<joint name="wrist" type="revolute"><parent>left::high</parent>'
        "<child>right::low</child><axis><xyz>0 0 1</xyz></axis></joint>"
    )
    found = joints(files(include("models/arm") + second, more=more))
    check_arm(found, "left::")
    H = pose_of(*PLACE) @ pose_of([0, 0, 0.5], [0.3, 0, 0]) @ pose_of([0, 0, 0.4], [0, 0, 0])
    wrist = found["wrist"]
    np.testing.assert_allclose(wrist.screw[:3], H[:3, 2], atol=1e-12)
    elbow = found["right::elbow"]
    np.testing.assert_allclose(elbow.screw[:3], H[:3, 1], atol=1e-12)


def test_a_model_that_is_written_inside_another(files):
    nested = ARM.partition("<model name=")[2].rpartition("</sdf>")[0]
    nested = f"<model name={nested}".replace('"arm"', '"left"', 1).replace(
        "9 9 9 0 0 0", "0.1 0.2 0.3 0 0.4 0"
    )
    check_arm(joints(files(nested)), "left::")


def test_the_mobility_of_a_world_with_one_included_model(tmp_path, files):
    path = tmp_path / "world.sdf"
    path.write_text(
        '<sdf version="1.9"><world name="w"><include><uri>model://sun</uri></include>'
        "<include><uri>models/arm</uri></include></world></sdf>"
    )
    assert list(joints(path)) == ["elbow"]


@pytest.mark.parametrize(
    ("inside", "fragment"),
    [
        (include("models/leg"), "no model 'models/leg'"),
        (include("model://leg"), "GZ_SIM_RESOURCE_PATH"),
        (include("https://fuel/arm"), "not on this machine"),
        (include(""), "no <uri>"),
        (include("robot.sdf"), "includes itself"),
        (include("models/arm", more="<placement_frame>tip</placement_frame>"), "placement"),
        (include("models/arm") + include("models/arm"), "two nested models 'left'"),
    ],
)
def test_what_cannot_be_included(files, inside, fragment):
    assert fragment in str(refusal(files(inside)))


def test_a_file_that_is_not_well_formed_is_named(files, tmp_path):
    (tmp_path / "models" / "arm" / "arm_9.sdf").write_text("<sdf><model>")
    text = str(refusal(files(include("models/arm"))))
    assert "arm_9.sdf" in text and "<include> (line" in text
