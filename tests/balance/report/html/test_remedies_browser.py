"""The page of remedies in a browser that has no network."""

from __future__ import annotations

from browser import needs_browser, started, wait_until

from balance.remedies.compare import compare_remedies
from balance.report.html.remedies import remedies_page

pytestmark = needs_browser
MARKS = "return document.querySelectorAll('#traces0 .scatterlayer .points path').length"


def test_a_mark_for_each_remedy_that_helps(tmp_path):
    """Where its cost is, on a wide and on a narrow screen without sideways scrolling."""
    found = compare_remedies("four_bar_kite", ["own_masses", "partial"])
    path = tmp_path / "page.html"
    path.write_text(remedies_page(found), encoding="utf-8")
    with started(tmp_path / "profile") as driver:
        for width in (1280, 390):
            driver.set_window_size(width, 900)
            driver.get(path.as_uri())
            wait_until(driver, lambda page: page.execute_script(MARKS) == 2)
            assert driver.get_log("browser") == []
            drawn = driver.execute_script(
                "return byId('traces0').data.map((mark) => [mark.x[0], mark.y[0]])"
            )
            assert drawn == [[one.mass_ratio, one.inertia_ratio] for one in found.results]
            wide = "return document.documentElement.scrollWidth - window.innerWidth"
            assert driver.execute_script(wide) <= 0
        table = driver.find_element("css selector", "table").text
        assert "own_masses" in table and "partial" in table
