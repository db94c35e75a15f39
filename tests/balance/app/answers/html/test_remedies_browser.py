"""The page of remedies in a browser that has no network."""

from __future__ import annotations

import pytest

from balance.app.answers.html.remedies import remedies_page
from balance.masses.remedies.compare import compare_remedies
from tests.support.browser import complaints, needs_browser, screen, show, too_wide, wait_until

pytestmark = needs_browser
MARKS = "return document.querySelectorAll('#traces0 .mark').length"


@pytest.mark.browser
def test_a_mark_for_each_remedy_that_helps(browser, tmp_path):
    """Where its cost is, on a wide and on a narrow screen without sideways scrolling."""
    found = compare_remedies("four_bar_kite", ["own_masses", "partial"])
    text = remedies_page(found)
    for width in (1280, 390):
        with screen(browser, width):
            show(browser, tmp_path, text)
            wait_until(browser, lambda page: page.execute_script(MARKS) == 2)
            assert complaints(browser) == []
            drawn = browser.execute_script(
                "return byId('traces0').chart.traces.map((mark) => [mark.x[0], mark.y[0]])"
            )
            assert drawn == [[one.mass_ratio, one.inertia_ratio] for one in found.results]
            assert too_wide(browser) == 0
    table = browser.find_element("css selector", "table").text
    assert "counterweights on the links" in table and "counterweights for less shaking" in table
