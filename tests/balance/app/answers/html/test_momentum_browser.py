"""Lines of momentum on the page of a design space, in a browser that has no network."""

from __future__ import annotations

import re

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.space.momentum.momentum_lines import meeting, momentum_lines
from tests.support.browser import Select, needs_browser, one, settle
from tests.support.design_space_pages import (
    FOUR_BAR,
    drawn,
    opened,
    slide,
    written,
)

pytestmark = needs_browser


@pytest.mark.browser
def test_lines_of_momentum_move_with_the_linkage(browser, tmp_path_factory):
    """Those drawn are the axes that Python finds at the pose; where they meet is said."""
    space = design_space(linkage := kinematics.load("four_bar_kite_balanced"))
    opened(browser, written(tmp_path_factory.mktemp("balanced"), space))
    told = set()
    for u in (0.0, -np.pi / 3.0):
        slide(browser, 0, np.degrees(u))
        (lines,) = momentum_lines(linkage, [u])
        expected = meeting(lines)
        ends = drawn(browser, "momenta").reshape(-1, 3, 3)[:, :2]
        for line, (a, b) in zip(lines, ends, strict=True):
            d = (b - a) / np.linalg.norm(b - a)
            assert np.abs(d - line.direction).max() < 1e-6
            assert np.linalg.norm(np.cross(a - expected.point, d)) < 1e-6
        assert np.abs(drawn(browser, "meeting") - expected.point).max() < 1e-6
        words = one(browser, "#meeting").text
        assert words.startswith("The three lines meet in one point, ")
        x, y, *_ = re.findall(r"-?[\d.]+\d", words.replace("−", "-"))
        assert np.allclose([float(x), float(y)], expected.point[:2], rtol=1e-3)
        rows = browser.find_elements("css selector", "#momenta tbody tr")
        for row, line in zip(rows, lines, strict=True):
            assert row.text.startswith(f"{line.body} {line.magnitude:.4g} N s")
        told.add(words)
    assert len(told) == 2


@pytest.mark.browser
def test_lines_of_momentum_of_chosen_freedoms(browser, pages, model):
    """Whatever is chosen of the design space, wrenches along the lines cancel."""
    opened(browser, pages[model][1])
    masses, texts = Select(one(browser, "#masses")), []
    for value in ("all", "chosen", "given", "none"):
        masses.select_by_value(value)
        settle(browser)
        texts.append(one(browser, "#meeting").text)
        found = browser.execute_script(
            "const m = byId('masses').value; if (m === 'none') return [];"
            "return [-0.4, 0, 0.7].flatMap((value) => scene.columns.map((c, k) => {"
            "controls.home(); controls.slide(k, value);"
            "const {twists} = rate(); return scene.bodies.map("
            "(b, i) => momentum(MASSES[m].of()[i], stage.pose[b.part], twists[i])); }))"
        )
        for bodies in found:
            h = np.array([[*b["moment"], *b["force"]] for b in bodies])
            whole = max(b["whole"] for b in bodies)
            if value != "given":
                assert np.abs(h.sum(axis=0)).max() < 1e-6 * whole
            elif model == FOUR_BAR:
                assert np.abs(h.sum(axis=0)).max() > 1e-3 * whole
    assert ("meet in one point" in texts[0]) == (model == FOUR_BAR)
    assert texts[2].startswith("These masses are not balanced" if model == FOUR_BAR else "The ")
    assert texts[3] == "" and not browser.find_elements("css selector", "#momenta table")
