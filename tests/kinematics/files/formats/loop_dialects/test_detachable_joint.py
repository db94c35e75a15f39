"""The plugin DetachableJoint welds two links at the pose of the file."""

import pytest

from tests.support.dialect_loops import plugin
from tests.support.dialect_text import (
    MORE,
    OPEN,
    WELD,
    codes,
    compare_drafts,
    draft_of,
    refused,
)


@pytest.mark.parametrize("model", ["r", "__model__", ""])
def test_two_links_of_this_file(model, tmp_path):
    draft = draft_of(tmp_path, OPEN, MORE, plugin(model=model))
    compare_drafts(draft, draft_of(tmp_path, OPEN, MORE, WELD))
    assert not codes(draft)
    other = plugin(name="attach").replace("-", "_")
    compare_drafts(draft, draft_of(tmp_path, OPEN, MORE, other))


@pytest.mark.parametrize(
    "text",
    [
        plugin(model="box"),
        plugin(child="box"),
        plugin(parent=""),
        '<gazebo><plugin name="gz::sim::systems::DetachableJoint"/></gazebo>',
    ],
)
def test_other_models_are_refused(text, tmp_path):
    error = refused(tmp_path, OPEN, MORE, text)
    assert 'type="fixed"' in error.remedy and "(line" in error.element
