"""Tables that notebooks show of results: the facts of the repr, small and escaped."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser

import pytest

import balance
import kinematics
from kinematics.wording import html_facts

MODEL = "four_bar_kite_balanced"
HOSTILE = """<script>alert('1')</script>&amp;" onload="x"""


class Table(HTMLParser):
    """The elements and texts of one table."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.texts = [], set(), []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attributes):
        assert not attributes
        self.open.append(tag)
        self.tags.add(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def results():
    """The results that notebooks show as tables, and words of their reprs."""
    linkage = kinematics.load(MODEL)
    open_space = balance.design_space(linkage)
    space = balance.certify(open_space)
    force = balance.design_space(linkage, balance="force")
    found = balance.verify(linkage, trajectories=1, samples=20)
    return [
        (linkage, ["Linkage four_bar_kite_balanced", "planar", "crank", linkage.source]),
        (open_space, ["DesignSpace of", space.parts, open_space.assurance]),
        (space, ["CertifiedSpace of", space.parts, space.assurance, "balanced"]),
        (balance.design(force, "mass", bounds={"crank": (1.0, 2.0)}), ["crank", " kg"]),
        (found, ["Verification of", "below 1e-10 N", found.verdict]),
    ]


@pytest.fixture(scope="module")
def instances():
    return results()


def test_tables_hold_the_facts(instances):
    for result, words in instances:
        table = Table(result._repr_html_())
        assert table.tags == {"table", "caption", "tbody", "tr", "th", "td"}
        assert all(any(word in text for text in table.texts) for word in words), table.texts
        assert len(result._repr_html_()) < 2000


def test_hostile_names_are_escaped(instances):
    linkage = instances[0][0]
    bodies = tuple(replace(body, name=HOSTILE) for body in linkage.bodies)
    renamed = replace(linkage, name=HOSTILE, source=HOSTILE, inputs=(HOSTILE,), bodies=bodies)
    space = instances[2][0]
    for result in (
        renamed,
        replace(space, linkage=renamed),
        replace(instances[3][0], space=replace(space, linkage=renamed), words=HOSTILE),
        replace(instances[4][0], linkage=renamed),
    ):
        text = result._repr_html_()
        table = Table(text)
        assert "script" not in table.tags and "<script" not in text and '"' not in text
        assert HOSTILE in "".join(table.texts) and HOSTILE in unescape(text)


def test_long_tables_are_cut():
    rows = [(f"row {k}", "x" * 500) for k in range(40)]
    table = Table(html_facts("y" * 500, *rows))
    assert table.texts[-1] == "and 29 more" and "row 10" in table.texts
    assert "row 11" not in table.texts and max(map(len, table.texts)) <= 96
    assert Table(html_facts("title")).texts == ["title"]


def test_tables_need_no_library_at_load():
    code = "import sys, kinematics.wording; print('html' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"
