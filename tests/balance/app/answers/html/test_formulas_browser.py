"""The page of formulas in a browser that has no network."""

from __future__ import annotations

from itertools import combinations

import pytest

import balance
from tests.support.browser import complaints, needs_browser, screen, show, too_wide

pytestmark = needs_browser


@pytest.mark.browser
def test_formulas_are_set_on_wide_and_narrow_screens(browser, tmp_path):
    """Fractions stand above each other, the drawing fits, and nothing scrolls sideways."""
    text = balance.formulas("six_bar_watt", "force").to_html()
    fraction = (
        "const [a, b] = document.querySelector('mfrac').children;"
        "return [a.getBoundingClientRect().bottom, b.getBoundingClientRect().top]"
    )
    for width, scheme in ((1280, "light"), (1280, "dark"), (390, "light")):
        with screen(browser, width, scheme=scheme):
            show(browser, tmp_path, text)
            above, below = browser.execute_script(fraction)
            assert above <= below + 1
            drawn = browser.execute_script(
                "return document.querySelector('.linkage svg').getBoundingClientRect().width"
            )
            assert 0 < drawn <= width
            assert complaints(browser) == [] and not too_wide(browser)


@pytest.mark.browser
def test_the_button_selects_what_it_copies(browser, tmp_path):
    found = balance.formulas("four_bar_general", "force")
    show(browser, tmp_path, found.to_html())
    browser.execute_script("document.querySelector('[data-copies=latex]').click()")
    assert browser.execute_script("return String(getSelection())").strip() == found.latex()


@pytest.mark.browser
def test_no_two_labels_overlap_as_they_are_drawn(browser, tmp_path):
    """Rectangles of the texts that the browser measured."""
    show(browser, tmp_path, balance.formulas("four_rrr", "force").to_html())
    measured = browser.execute_script(
        "return [...document.querySelectorAll('.linkage svg text')].map(each => {"
        "const r = each.getBBox(); return [r.x, r.y + 2, r.x + r.width, r.y + r.height - 2] })"
    )
    crossing = [
        (a, b)
        for a, b in combinations(measured, 2)
        if max(a[0], b[0]) < min(a[2], b[2]) and max(a[1], b[1]) < min(a[3], b[3])
    ]
    assert len(measured) == 35 and crossing == []
