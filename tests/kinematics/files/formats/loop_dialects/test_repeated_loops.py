"""One loop in the words of two tools counts once; that with fewer freedoms stays."""

import pytest

from kinematics.errors import LinkageError
from tests.support.dialect_loops import (
    BALL,
    PAIR,
    connect,
    constraint,
    gazebo,
    loop_joint,
    mujoco,
    plugin,
)
from tests.support.dialect_text import (
    MORE,
    OPEN,
    WELD,
    codes,
    compare_drafts,
    draft_of,
    hand_written,
)

HINGES = {
    "loop": hand_written("revolute"),
    "SDF": gazebo(),
    "constraint": constraint(),
    "loop_joint": loop_joint(),
}
POINTS = {
    "MuJoCo": connect(),
    "Drake": BALL,
    "frames": PAIR,
    "constraint": constraint("ball"),
    "SDF": gazebo("ball"),
    "swapped": connect("cb", "0 1.5 0"),
}


@pytest.mark.parametrize("one", HINGES)
@pytest.mark.parametrize("other", HINGES)
def test_a_hinge_in_two_dialects(one, other, tmp_path):
    if one != other:
        draft = draft_of(tmp_path, OPEN, HINGES[one], HINGES[other])
        compare_drafts(draft, draft_of(tmp_path, OPEN, HINGES["loop"]))
        assert codes(draft) == ["loops_repeated"]


@pytest.mark.table
@pytest.mark.parametrize("hinge", HINGES)
@pytest.mark.parametrize("point", POINTS)
def test_a_hinge_implies_its_points(hinge, point, tmp_path):
    if hinge == point:
        return
    draft = draft_of(tmp_path, OPEN, POINTS[point], HINGES[hinge])
    compare_drafts(draft, draft_of(tmp_path, OPEN, HINGES["loop"]))
    assert codes(draft).count("loops_repeated") == 1


def test_the_file_itself_is_preferred(tmp_path):
    draft = draft_of(tmp_path, OPEN, BALL, connect(), hand_written("spherical", ""))
    assert [loop.name for loop in draft.loops] == ["l"]
    assert codes(draft) == ["loops_repeated"] * 2


def test_digits_that_tools_cut_off(tmp_path):
    near = connect(anchor="-0.500001 -2.000001 0")
    assert len(draft_of(tmp_path, OPEN, near, hand_written("revolute")).loops) == 1
    apart = connect(anchor="-0.501 -2 0")
    draft = draft_of(tmp_path, OPEN, apart, hand_written("revolute"))
    assert len(draft.loops) == 2 and not codes(draft)


def test_what_is_not_implied_stays(tmp_path):
    # A point beside the axis of the hinge; a weld implies what it holds, but not conversely.
    draft = draft_of(tmp_path, OPEN, connect(anchor="-0.5 -1 0"), gazebo())
    assert len(draft.loops) == 2 and not codes(draft)
    draft = draft_of(tmp_path, OPEN, MORE, plugin(), WELD)
    compare_drafts(draft, draft_of(tmp_path, OPEN, MORE, WELD))
    assert codes(draft) == ["loops_repeated"]


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "cylindrical", "planar", "fixed"])
def test_kinds_that_imply_each_other(kind, tmp_path):
    weaker = {
        "revolute": ["revolute", "spherical", "cylindrical", "planar"],
        "prismatic": ["prismatic", "cylindrical"],
        "cylindrical": ["cylindrical"],
        "planar": ["planar"],
    }
    axis = "" if kind == "fixed" else '<axis xyz="0 0 1"/>'
    for other in ("revolute", "prismatic", "spherical", "cylindrical", "planar"):
        axes = ("", "") if other == "spherical" else ("0 0 1", "0 0 1")
        text = constraint(other, axes)
        draft = draft_of(tmp_path, OPEN, text.replace('"l"', '"m"'), hand_written(kind, axis))
        count = 1 if other in weaker.get(kind, [other]) or kind in weaker.get(other, []) else 2
        assert len(draft.loops) == count, other


def test_a_floating_joint_repeats_no_loop(tmp_path):
    """It closes nothing, and is refused as it is where it stands alone."""
    floating = hand_written("floating", "")
    with pytest.raises(LinkageError) as alone:
        draft_of(tmp_path, OPEN, floating)
    with pytest.raises(LinkageError) as beside:
        draft_of(tmp_path, OPEN, floating, constraint("ball").replace('"l"', '"m"'))
    assert "floating" in str(alone.value) and "floating" in str(beside.value)


def test_two_hinges_of_a_universal_loop(tmp_path):
    words = '<axis xyz="0 0 1"/><axis2 xyz="0 1 0"/>'
    text = constraint("universal", ("0 0 1", "0 1 0"))
    draft = draft_of(tmp_path, OPEN, text, hand_written("universal", words), connect())
    assert len(draft.loops) == 1 and codes(draft) == ["loops_repeated"] * 2


def test_points_of_one_dialect_all_stay(tmp_path):
    twice = mujoco(*['<connect body1="b" body2="c" anchor="-0.5 -2 0"/>'] * 2)
    assert len(draft_of(tmp_path, OPEN, twice).loops) == 2
    elsewhere = hand_written("spherical", "").replace("-0.5 -2 0", "-0.5 -1 0")
    assert len(draft_of(tmp_path, OPEN, twice, elsewhere).loops) == 3


def test_a_yaml_file_beside_a_dialect(tmp_path):
    (tmp_path / "robot.yaml").write_text("closed_loop: [[p, q]]\ntype: [3d]\n")
    pair = PAIR.replace("closing_hinge_1", "p").replace("closing_hinge_2", "q")
    draft = draft_of(tmp_path, OPEN, pair, gazebo())
    compare_drafts(draft, draft_of(tmp_path, OPEN, gazebo(), pair))
    assert len(draft.loops) == 1 and codes(draft) == ["loops_repeated"]
