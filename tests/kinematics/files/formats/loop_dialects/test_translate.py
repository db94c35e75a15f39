"""A plain file pays nothing; files of the wild are told of what they close."""

import subprocess
import sys

import pytest

from kinematics import gallery
from kinematics.errors import FileError
from kinematics.files.formats.loop_dialects.translate import translate_loops
from kinematics.files.formats.robot_files import read_files, read_robot
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.loading import model_gallery
from tests.support.dialect_loops import BALL, connect
from tests.support.dialect_text import OPEN, codes, draft_of, hand_written, robot_text

LOADED = (
    "import sys\nfrom kinematics.files.formats.robot_files import read_robot\n"
    "read_robot(sys.argv[1])\nprint('numpy' in sys.modules)"
)


@pytest.mark.parametrize("name", sorted(gallery()))
def test_a_plain_file_stays_as_it_is(name):
    tree = read_robot(gallery()[name]).tree
    found = translate_loops(tree)
    assert found.tree is tree and not found.remarks and not found.dialects


@pytest.mark.slow
@pytest.mark.table(2)
@pytest.mark.parametrize(
    "text, loaded", [(hand_written("revolute"), "False"), (BALL, "False"), (connect(), "True")]
)
def test_numbers_are_loaded_for_frames_on_one_link(text, loaded, tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(robot_text(OPEN, text), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", LOADED, str(path)],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": ":".join(sys.path)},
    )
    assert done.stdout.strip() == loaded


def test_rounded_angles_are_read_as_the_user_chose(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(robot_text(OPEN, connect()), encoding="utf-8")
    ends = []
    for angles in ("nominal", "as_written"):
        tree = read_files(path, None, ReadOptions(angles=angles)).tree
        successor = tree.every("loop")[0].first("successor")
        ends.append(successor.first("origin").vector("xyz", ""))
    assert ends[0] == [0.0, 1.5, 0.0]
    assert ends[1] != ends[0] and abs(ends[1][0]) < 1e-5


def test_a_name_that_is_taken_is_refused_unless_it_is_the_same_loop(tmp_path):
    twice = BALL.replace("<drake:ball_constraint ", '<drake:ball_constraint name="j1" ')
    path = tmp_path / "robot.urdf"
    path.write_text(robot_text(OPEN, twice), encoding="utf-8")
    with pytest.raises(ValueError, match="'j1' is taken by joint 'j1'"):
        read_robot(path)
    same = BALL.replace("<drake:ball_constraint ", '<drake:ball_constraint name="l" ')
    assert codes(draft_of(tmp_path, OPEN, same, hand_written("revolute"))) == ["loops_repeated"]


def test_a_long_decimal_and_an_offset_along_an_irrational_axis(tmp_path):
    """What the exact arithmetic does not take is read in double precision."""
    skew = OPEN.replace(
        '<origin xyz="2 0 0" rpy="0 0 0"/><axis xyz="0 0 1"/>',
        '<origin xyz="2 0 0" rpy="0 0 0"/><axis xyz="0 1 1"/><mimic joint="j1" offset="0.3"/>',
    )
    assert skew != OPEN
    for tree, text in ((skew, connect()), (OPEN, connect(anchor=f"-0.5{'0' * 500} -2 0"))):
        draft = draft_of(tmp_path, tree, text)
        assert len(draft.loops) == 1 and abs(draft.loops[0].gap[:3, 3]).max() < 1e-14


@pytest.mark.slow
def test_robots_of_example_robot_data():
    """They close no loops in these words; the grippers of one are told of."""
    found = model_gallery.robots()
    if not found:
        pytest.skip("needs example-robot-data")
    told = set()
    for name, path in found.items():
        try:
            robot = read_robot(path)
        except FileError:
            continue
        assert not robot.dialects
        told |= {name for code, _ in robot.remarks if code == "unread_closure"}
    assert {"pr2" in name for name in told} <= {True}
