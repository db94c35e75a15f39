"""<coupling> of URDF+ relates joint positions, as <mimic> does."""

import pytest

from tests.support.dialect_loops import coupling, mimicked
from tests.support.dialect_text import OPEN, codes, compare_drafts, draft_of, refused


def test_the_successor_follows_the_predecessor(tmp_path):
    draft = draft_of(tmp_path, OPEN, coupling())
    compare_drafts(draft, draft_of(tmp_path, mimicked("j3", "j1", "-2")))
    assert not codes(draft) and draft.mimics


def test_an_input_is_not_made_to_follow(tmp_path):
    driven = OPEN.replace('<joint name="j3"', '<joint independent="true" name="j3"')
    draft = draft_of(tmp_path, driven, coupling())
    wanted = mimicked("j1", "j3", "-0.5").replace(
        '<joint name="j3"', '<joint independent="true" name="j3"'
    )
    compare_drafts(draft, draft_of(tmp_path, wanted))
    assert draft.named_inputs == ("j3",)


def test_a_relation_that_is_there_counts_once(tmp_path):
    there = mimicked("j3", "j1", "-2")
    for text in (coupling(), coupling("ca", '<ratio value="-0.5"/>')):
        draft = draft_of(tmp_path, there, text)
        compare_drafts(draft, draft_of(tmp_path, there))
        assert codes(draft) == ["loops_repeated"]
    error = refused(tmp_path, there, coupling(ratio='<ratio value="2"/>'))
    assert "contradicts" in str(error)


def test_a_relation_of_followers_relates_their_sources(tmp_path):
    # j3 follows j2 already: j1 and j2 are related through it.
    there = mimicked("j3", "j2", "4")
    draft = draft_of(tmp_path, there, coupling())
    (new,) = [m for m in draft.mimics if draft.joints[m.joint].name == "j2"]
    assert draft.joints[new.source].name == "j1" and new.ratio == -0.5


@pytest.mark.parametrize(
    "text, said",
    [
        (coupling("bc"), "2 and 1 joints"),
        (coupling("ab"), "0 and 1 joints"),
        (coupling("aa"), "0 and 0 joints"),
        (coupling("xc"), "<predecessor>"),
        (coupling(ratio=""), "<ratio"),
        (coupling(ratio='<ratio value="nan"/>'), "finite"),
        (coupling(ratio="<ratio/>"), "<ratio"),
        ("<coupling/>", "<predecessor>"),
        (coupling(ratio='<ratio value="2"/><ratio value="2"/>'), "more than one <ratio>"),
        (coupling().replace("coupling", "couplin"), "write <coupling> in <robot>"),
    ],
)
def test_what_says_too_little_is_refused(text, said, tmp_path):
    error = refused(tmp_path, OPEN, text)
    assert said in str(error) and "(line" in error.element
