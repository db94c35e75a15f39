"""The page of a synthesis in a browser that has no network."""

from __future__ import annotations

import pytest

from balance import synthesize
from balance.app.answers.html.synthesis import synthesis_page
from tests.support.browser import complaints, needs_browser, screen, show, too_wide, wait_until

pytestmark = needs_browser
LINES = "return byId('traces{}').querySelectorAll('.line').length"


@pytest.mark.browser
def test_mechanism_and_map_on_wide_and_narrow_screens(browser, tmp_path):
    """Links, frames, path, slot and contour where they are, and no sideways scrolling."""
    places = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7)]
    found = synthesize(places, nonlinear=True, moving=0.4 + 0.4j)
    text = synthesis_page(found)
    for width in (1280, 390):
        with screen(browser, width):
            show(browser, tmp_path, text)
            wait_until(browser, lambda page: page.execute_script(LINES.format(1)) >= 1)
            assert browser.execute_script(LINES.format(0)) == 5
            shade = "return byId('traces1').querySelectorAll('image.shade').length"
            assert browser.execute_script(shade) == 1
            assert complaints(browser) == []
            tool = browser.execute_script(
                "const t = byId('traces0').chart.traces[1]; return [t.x[0], t.y[0]]"
            )
            assert tool == [places[0][0], places[0][1]]
            assert too_wide(browser) == 0
    table = browser.find_element("css selector", "table").text
    assert "pantograph" in table and "none" in table


# By how many pixels texts of a chart stick out of it.
OUTSIDE = """
const chart = byId("traces0"), box = chart.getBoundingClientRect();
return Math.max(...[...chart.querySelectorAll("text")].map((text) => {
  const {left, right} = text.getBoundingClientRect();
  return Math.max(box.left - left, right - box.right);
}));
"""


@pytest.mark.browser
def test_names_of_pivots_stay_on_narrow_screens(browser, tmp_path):
    """A rocker that stands far to the right has its name to the left of it."""
    places = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7), (-0.1, 0.5, -1.22)]
    text = synthesis_page(synthesize(places, kind="four-bar", thickness=0.008))
    for width in (1280, 390):
        with screen(browser, width):
            show(browser, tmp_path, text)
            wait_until(browser, lambda page: page.execute_script(LINES.format(0)) >= 1)
            assert browser.execute_script(OUTSIDE) <= 2
            assert complaints(browser) == [] and too_wide(browser) == 0
