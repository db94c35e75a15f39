"""A file of another tool gives the answer of the same linkage with <loop>, and is written."""

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from kinematics.files.urdf.write_closed_pose import write_at_reference_pose
from tests.support.dialect_loops import (
    BALL,
    PAIR,
    connect,
    constraint,
    coupling,
    gazebo,
    loop_joint,
    mimicked,
    mujoco,
    plugin,
    related,
)
from tests.support.dialect_text import MORE, OPEN, WELD, answer, hand_written, robot_text

POINT, HINGE = hand_written("spherical", ""), hand_written("revolute")
SAME = {
    "SDF joint": (OPEN + gazebo(), OPEN + HINGE),
    "SDF ball": (OPEN + gazebo("ball"), OPEN + POINT),
    "constraint": (OPEN + constraint(), OPEN + HINGE),
    "Drake ball": (OPEN + BALL, OPEN + POINT),
    "connect": (OPEN + connect(), OPEN + POINT),
    "weld": (OPEN + MORE + mujoco('<weld body1="d" body2="c"/>'), OPEN + MORE + WELD),
    "joint": (OPEN + related("0 -2"), mimicked("j3", "j1", "-2")),
    "loop_joint": (OPEN + loop_joint(), OPEN + HINGE),
    "coupling": (OPEN + coupling(), mimicked("j3", "j1", "-2")),
    "closing frames": (OPEN + PAIR, OPEN + POINT),
    "DetachableJoint": (OPEN + MORE + plugin(), OPEN + MORE + WELD),
}
# Inputs beside the first, where there is more than one.
AT = {"joint": {"j2": 0.2}, "coupling": {"j2": 0.2}}


def saved(folder, text, name="robot"):
    path = folder / f"{name}.urdf"
    path.write_text(robot_text(text), encoding="utf-8")
    return path


@pytest.mark.table(3)
@pytest.mark.parametrize("case", SAME)
def test_the_answer_is_that_of_the_loop(case, tmp_path):
    found, wanted = (answer(saved(tmp_path, text)) for text in SAME[case])
    assert found == wanted
    if case not in ("joint", "coupling"):
        assert found[0] == [3, 6, 7, 8] and found[3] in ("proved", "verified")


@pytest.mark.table(2)
@pytest.mark.parametrize("case", SAME)
def test_a_file_at_another_pose_is_the_same_linkage(case, tmp_path):
    """The file that --write-closed writes at the pose of --at, in the words of the tool."""
    source, target = saved(tmp_path, SAME[case][0]), tmp_path / "closed.urdf"
    moved = kinematics.load(source, at={"j1": 0.3, **AT.get(case, {})})
    target.write_bytes(write_at_reference_pose(moved).data)
    again = kinematics.load(target)
    for joint in ("j1", "j2", "j3"):
        one, other = ([j.screw for j in x.joints if j.name == joint] for x in (moved, again))
        np.testing.assert_allclose(one, other, atol=1e-9)
    assert len(moved.loops) == len(again.loops) and len(moved.mimics) == len(again.mimics)
    assert answer(target)[1:3] == answer(source)[1:3]


@pytest.mark.table(1)
@pytest.mark.parametrize("case", ["SDF joint", "connect", "coupling"])
def test_the_commands_write_what_they_read(case, tmp_path, capsys):
    source, target = saved(tmp_path, SAME[case][0]), tmp_path / "closed.urdf"
    words = ["report", str(source), "--at", "j1=0.2", "--write-closed", str(target)]
    assert main(words) == 0
    said = capsys.readouterr()
    assert ".yaml" not in said.out + said.err
    assert main(["report", str(target), "--json"]) == 0
    capsys.readouterr()
    assert main(["design", str(source), "--balance", "force", "--out", str(target)]) in (0, 1)
    capsys.readouterr()
    assert answer(target)[:3] == answer(source)[:3]
