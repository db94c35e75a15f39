"""Constraints of Drake: a ball closes a loop, a bushing is a spring."""

import pytest

from tests.support.dialect_loops import BALL
from tests.support.dialect_text import (
    ON_B,
    ON_C,
    OPEN,
    codes,
    compare_drafts,
    draft_of,
    hand_written,
    refused,
)

BUSHING = (
    f'<frame name="f" link="b" xyz="{ON_B}"/><frame name="g" link="c" xyz="{ON_C}"/>'
    '<drake:linear_bushing_rpy xmlns:drake="d"><drake:bushing_frameA name="f"/>'
    '<drake:bushing_frameC name="g"/></drake:linear_bushing_rpy>'
)


def test_a_ball(tmp_path):
    draft = draft_of(tmp_path, OPEN, BALL)
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("spherical", "")))
    assert not codes(draft)


def test_a_bushing_is_refused_with_the_loop_to_write(tmp_path):
    error = refused(tmp_path, OPEN, BUSHING)
    assert "spring" in error.problem and "linear_bushing_rpy> (line" in error.element
    for part in ('link="b"', f'"{ON_B}"', 'link="c"', f'"{ON_C}"', "<loop"):
        assert part in error.remedy
    bare = BUSHING.replace('name="f"/><drake', 'name="h"/><drake')
    assert 'link="h"' in refused(tmp_path, OPEN, bare).remedy


def test_a_spring_is_told_of_and_a_tendon_refused(tmp_path):
    spring = '<drake:linear_spring_damper xmlns:drake="d"><drake:x name="b"/></drake:{}>'
    draft = draft_of(tmp_path, OPEN, spring.format("linear_spring_damper"))
    assert codes(draft) == ["springs_ignored"]
    tendon = '<drake:tendon_constraint xmlns:drake="d"/>'
    assert "<mimic>" in refused(tmp_path, OPEN, tendon).remedy


@pytest.mark.parametrize(
    "text, said",
    [
        (BALL.replace('name="b"', 'name="x"'), "'x' does not exist"),
        (BALL.replace('name="b"', 'name=""'), "name two links"),
        (BALL.replace('<drake:ball_constraint_body_A name="b"/>', ""), "name two links"),
        (BALL.replace(ON_C, "0 inf 0"), "not 3 finite"),
        (BALL.replace('name="b"', 'name="c"'), "one rigid body"),
    ],
)
def test_what_says_too_little_is_refused(text, said, tmp_path):
    error = refused(tmp_path, OPEN, text)
    assert said in str(error) and "(line" in error.element
