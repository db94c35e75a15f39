"""Pages of searches in a browser that has no network: families, and a walk to watch."""

from __future__ import annotations

import re

import pytest

from balance.app.answers.html.families import families_page
from balance.app.answers.html.walk import walk_page
from balance.app.answers.text.discovery import families_data, search_data
from balance.studies.discovery.families import group_members
from balance.studies.discovery.job import DiscoveryJob
from balance.studies.discovery.search_results import SearchResults, examine
from balance.studies.discovery.watch import watch_walk
from tests.support.browser import (
    complaints,
    needs_browser,
    one,
    play_until,
    screen,
    settle,
    show,
    too_wide,
)
from tests.support.search_ends import special_ends

pytestmark = needs_browser

# The third start of this search ends at a kite.
START = 2
TENTHS = {"⁻": "-", **dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789", strict=True))}


class FewRows:
    """A file of results, as far as its facts are told."""

    path, rows = "search.db", 50

    def computed(self):
        """Return the rows that are there."""
        return 50, 50


@pytest.fixture(scope="module")
def search():
    """A search for four-bars: the job, what was found, and one family examined."""
    job = DiscoveryJob("four-bar", 50)
    rows = job.compute(0)
    found = special_ends(rows)
    families = group_members(job.topology, job.structure, job.generic, found)[:1]
    data = search_data(
        FewRows(), SearchResults(job, {"special": len(found)}, families), None, "show"
    )
    examined = [examine(job, family, members=8, tried=2) for family in families]
    return job, families_data(data, examined), examined


@pytest.fixture(scope="module")
def walk(browser, tmp_path_factory):
    """A browser that shows a walk."""
    page = walk_page(watch_walk(DiscoveryJob("four-bar", 50), START))
    show(browser, tmp_path_factory.mktemp("walk"), page)
    settle(browser)
    return browser


def value(page):
    """The singular value that is shown."""
    text = one(page, "#now").text.rsplit(" ", 1)[1]
    found = re.fullmatch(r"([\d.]+)?×?(?:10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text)
    power = int("".join(TENTHS[c] for c in found[2])) if found[2] else 0
    return float(found[1] or 1.0) * 10.0**power


def joints(page):
    """The joints that are drawn."""
    return page.execute_script("return stage.drawn('joints')")


def put(page, at):
    """Move the slider to a place of the walk."""
    page.execute_script(
        "place.value = arguments[0]; place.dispatchEvent(new Event('input'))", at
    )
    settle(page)


@pytest.mark.browser
def test_play_deforms_the_linkage_while_the_value_falls(walk):
    put(walk, 0)
    before, high = joints(walk), value(walk)
    assert high == pytest.approx(walk.execute_script("return walk.ratios[0]"), rel=1e-3)
    play_until(walk, "#play", "valueAt(Number(place.value)) < 1e-3 * walk.ratios[0]")
    assert value(walk) < 1.001e-3 * high
    after = joints(walk)
    moved = max(
        abs(a - b)
        for p, q in zip(before, after, strict=True)
        for a, b in zip(p, q, strict=True)
    )
    assert moved > 0.01
    assert complaints(walk) == []


@pytest.mark.browser
def test_the_end_of_the_walk_is_a_kite(walk):
    """Two pairs of neighbouring links are equal in the drawing."""
    put(walk, walk.execute_script("return last"))
    assert value(walk) < 1e-14
    a, b, c, d = (complex(x, y) for x, y, _ in joints(walk))
    assert abs(d - a) == pytest.approx(abs(c - d), rel=1e-4)
    assert abs(b - a) == pytest.approx(abs(c - b), rel=1e-4)


@pytest.mark.browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_fit_a_phone(browser, search, tmp_path, scheme):
    pages = [families_page(*search), walk_page(watch_walk(search[0], START))]
    for page in pages:
        with screen(browser, 390, scheme=scheme):
            show(browser, tmp_path, page)
            settle(browser)
            assert too_wide(browser) == 0 and complaints(browser) == []


@pytest.mark.browser
def test_a_member_of_each_family_moves(browser, search, tmp_path):
    job, data, examined = search
    show(browser, tmp_path, families_page(job, data, examined))
    settle(browser)
    rows = browser.find_elements("css selector", "#families tbody tr")
    assert len(rows) == len(examined) == 1
    assert all(text in rows[0].text for text in data["families"][0]["relations"])
    drawn = "return stages[0].stage.drawn('joints')"
    before = browser.execute_script(drawn)
    play_until(browser, "#sliders0 .play", "Math.abs(stages[0].stage.q[0]) > 0.1")
    assert browser.execute_script(drawn) != before
    assert complaints(browser) == []
