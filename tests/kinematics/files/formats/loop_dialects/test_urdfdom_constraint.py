"""<constraint> of a proposal to urdfdom: two frames, two axes."""

import pytest

from tests.support.dialect_loops import constraint
from tests.support.dialect_text import (
    ON_B,
    OPEN,
    codes,
    compare_drafts,
    draft_of,
    hand_written,
    refused,
)


@pytest.mark.parametrize(
    "kind", ["revolute", "continuous", "prismatic", "cylindrical", "planar"]
)
@pytest.mark.parametrize("suffix", ["", "_joint"])
def test_one_axis(kind, suffix, tmp_path):
    draft = draft_of(tmp_path, OPEN, constraint(kind + suffix))
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written(kind)))
    assert not codes(draft)
    for axes in (("0 0 1", ""), ("", "0 0 1")):
        compare_drafts(draft, draft_of(tmp_path, OPEN, constraint(kind, axes)))


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "planar"])
def test_axes_of_other_numbers(kind, tmp_path):
    text = constraint(kind, ("0 0 1", "0 0 -1"), ("0 0 0", "0 0 0"))
    wanted = draft_of(tmp_path, OPEN, hand_written(kind))
    compare_drafts(draft_of(tmp_path, OPEN, text), wanted)
    text = constraint(kind, ("0 0 1", "0 2 0"), ("0 0 0", "-1.5708 0 0"))
    compare_drafts(draft_of(tmp_path, OPEN, text), wanted)


@pytest.mark.parametrize("kind", ["spherical", "spherical_joint", "ball"])
def test_a_point(kind, tmp_path):
    wanted = draft_of(tmp_path, OPEN, hand_written("spherical", ""))
    compare_drafts(draft_of(tmp_path, OPEN, constraint(kind, ("", ""))), wanted)


def test_a_universal_one(tmp_path):
    draft = draft_of(tmp_path, OPEN, constraint("universal_joint", ("0 0 1", "0 1 0")))
    words = '<axis xyz="0 0 1"/><axis2 xyz="0 1 0"/>'
    compare_drafts(draft, draft_of(tmp_path, OPEN, hand_written("universal", words)))


@pytest.mark.parametrize(
    "text, said",
    [
        (constraint("gear"), "type"),
        (constraint(axes=("", "")), "parent_axis"),
        (constraint("universal", ("0 0 1", "")), "child_axis"),
        (constraint("prismatic", ("0 0 1", "1 0 0")), "relative rotation"),
        (constraint(axes=("0 0 0", "")), "zero"),
        (constraint(axes=("0 0 nan", "")), "not 3 finite"),
        (constraint().replace('link="b"', 'link="x"'), "'x' does not exist"),
        (constraint().replace('<child link="c"/>', ""), "name two links"),
        (constraint().replace(ON_B, "0 1"), "3 finite"),
        (constraint().replace('"0 0 0"', '"0 0 1e9"'), "beyond"),
        (constraint().replace('link="b"', 'link="c"'), "one rigid body"),
        (
            constraint().replace(
                "<child l", '<child link="b"/><child_axis xyz="0 0 1"/><child l'
            ),
            "more than one <child>",
        ),
    ],
)
def test_what_says_too_little_is_refused(text, said, tmp_path):
    error = refused(tmp_path, OPEN, text)
    assert said in str(error) and "(line" in error.element


def test_constraints_of_other_kinds_are_told_of(tmp_path):
    text = '<constraint kind="spring"><body name="a"/><body name="c"/></constraint>'
    draft = draft_of(tmp_path, OPEN, text)
    assert codes(draft) == ["unread_closure"] and not draft.loops
