"""The atlas of special geometries: its script, and the page that is kept."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

from balance.studies.discovery.topologies import TOPOLOGIES

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def make_atlas(monkeypatch):
    """The script."""
    monkeypatch.syspath_prepend(str(DOCS))
    return import_module("make_atlas")


@pytest.mark.docs
def test_a_chapter_names_what_is_known(make_atlas, tmp_path):
    """Of the four-bar: kite and antiparallelogram; again, text and figures are the same."""
    entry = make_atlas.Chapter("four-bar", "Four-bar", 100, 0)
    text, figures = make_atlas.chapter(entry, tmp_path, 0)
    assert "antiparallelogram: R. Ricard" in text and "kite: R. Ricard" in text
    assert "not found" not in text
    links = re.findall(r"\]\(atlas/([\w.]+)\)", text)
    assert sorted(links) == sorted(figures) and len(links) >= 2
    for name, svg in figures.items():
        root = ElementTree.fromstring(svg)
        letters = [node.text for node in root.iter() if node.tag.endswith("text")]
        assert sorted(letters) == ["A", "B", "C", "D"], name
    assert make_atlas.chapter(entry, tmp_path, 0) == (text, figures)


def test_the_atlas_has_all_topologies_and_its_figures(make_atlas):
    text = (DOCS / "atlas.md").read_text(encoding="utf-8")
    assert {entry.name for entry in make_atlas.CHAPTERS} == set(TOPOLOGIES)
    for entry in make_atlas.CHAPTERS:
        assert f"\n## {entry.title}\n" in text
        assert f"\n{entry.starts} walks to any special geometry: " in text
    links = set(re.findall(r"\]\((atlas/[\w.]+)\)", text))
    kept = {path.relative_to(DOCS).as_posix() for path in (DOCS / "atlas").glob("*.svg")}
    assert links == kept and len(links) > 4


@pytest.mark.parametrize(("name", "link"), [("four-bar", 2), ("slider-crank", 2), ("3-rsr", 3)])
def test_the_coupler_is_off_the_ground(make_atlas, name, link):
    assert make_atlas.coupler_of(TOPOLOGIES[name]) == link
