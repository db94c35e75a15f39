"""<loop_joint> of old versions of Drake and of Isaac Sim."""

import pytest

from tests.support.dialect_loops import loop_joint
from tests.support.dialect_text import (
    ON_C,
    OPEN,
    codes,
    compare_drafts,
    draft_of,
    hand_written,
    refused,
)


@pytest.mark.parametrize(
    "kind", ["revolute", "continuous", "prismatic", "", "spherical", "ball"]
)
def test_a_joint(kind, tmp_path):
    draft = draft_of(tmp_path, OPEN, loop_joint(kind))
    ball = kind in ("spherical", "ball")
    wanted = hand_written("spherical", "") if ball else hand_written(kind or "revolute")
    compare_drafts(draft, draft_of(tmp_path, OPEN, wanted))
    assert not codes(draft)


def test_the_axis_is_x_by_default(tmp_path):
    draft = draft_of(tmp_path, OPEN, loop_joint(axis=""))
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("revolute", "")))


@pytest.mark.parametrize(
    "text, said",
    [
        (loop_joint("universal"), "universal"),
        (loop_joint("gear"), "gear"),
        (loop_joint().replace('link="b"', 'link="x"'), "'x' does not exist"),
        (loop_joint().replace('link="b"', ""), "name two links"),
        (loop_joint().replace('link="b"', 'link="c"'), "one rigid body"),
        (loop_joint().replace(ON_C, "NaN 0 0"), "3 finite"),
        (loop_joint(axis='<axis xyz="0 0 0"/>'), "zero"),
        (loop_joint(axis="<axis/>"), "3 finite"),
        ('<loop_joint name="l" link1="b" link2="c" type="3D"/>', "<loop"),
        ('<loop_joint name="l" link1="b" link2="c"/>', "place of the loop"),
        ('<loop_joint name="l"/>', "name two links"),
        (loop_joint().replace("loop_joint", "loop_jont"), "write <loop_joint> in <robot>"),
        (f"<joint>{loop_joint()}</joint>", ""),
    ],
)
def test_what_says_too_little_is_refused(text, said, tmp_path):
    error = refused(tmp_path, OPEN, text)
    assert said in str(error) and "(line" in error.element
