"""Frames of onshape-to-robot and PlaCo in pairs are points that two bodies share."""

from tests.support.dialect_loops import PAIR, frame
from tests.support.dialect_text import (
    ON_B,
    OPEN,
    codes,
    compare_drafts,
    draft_of,
    hand_written,
)


def test_a_pair_is_a_point(tmp_path):
    draft = draft_of(tmp_path, OPEN, PAIR)
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("spherical", "")))
    assert codes(draft) == ["closing_frames"] and draft.loops[0].name == "closing_hinge"
    assert "closing_hinge" in draft.notices[0].message and "3d" in draft.notices[0].message


def test_one_alone_is_told_of(tmp_path):
    draft = draft_of(tmp_path, OPEN, frame("closing_hinge_1", "b", ON_B))
    assert not draft.loops and codes(draft) == ["unread_closure"]
    assert "'closing_hinge_2' is missing" in draft.notices[0].message
    draft = draft_of(tmp_path, OPEN, frame("closing_time", "b", ON_B))
    assert not draft.loops and not codes(draft)


def test_a_loop_between_the_frames_is_the_stronger(tmp_path):
    rpy = '<origin xyz="0 0 0" rpy="0 3.141592653589793 0"/>'
    loop = (
        '<loop name="l" type="revolute"><predecessor link="closing_hinge_1"/>'
        f'<successor link="closing_hinge_2">{rpy}</successor><axis xyz="0 0 1"/></loop>'
    )
    draft = draft_of(tmp_path, OPEN, PAIR, loop)
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("revolute")))
    assert "loops_repeated" in codes(draft)


def test_a_yaml_file_says_more(tmp_path):
    """A pair of type 6d in the file beside it fixes the frames, and counts once."""
    beside = tmp_path / "robot.yaml"
    for kind, freedoms in (("3d", 3), ("6d", 0)):
        beside.write_text(
            f"closed_loop: [[closing_hinge_1, closing_hinge_2]]\ntype: [{kind}]\n"
        )
        draft = draft_of(tmp_path, OPEN, PAIR)
        assert len(draft.loops) == 1 and len(draft.joints) == 3 + freedoms
        assert "loops_repeated" in codes(draft) and "loops_ignored" not in codes(draft)
