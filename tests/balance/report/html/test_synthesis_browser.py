"""The page of a synthesis in a browser that has no network."""

from __future__ import annotations

from browser import needs_browser, started, wait_until

from balance import synthesize
from balance.report.html.synthesis import synthesis_page

pytestmark = needs_browser
LINES = "return document.querySelectorAll('#traces{} .scatterlayer .trace').length"


def test_mechanism_and_map_on_wide_and_narrow_screens(tmp_path):
    """Links at both positions where they are, the contour, and no sideways scrolling."""
    places = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7)]
    found = synthesize(places, nonlinear=True, moving=0.4 + 0.4j)
    path = tmp_path / "page.html"
    path.write_text(synthesis_page(found), encoding="utf-8")
    with started(tmp_path / "profile") as driver:
        for width in (1280, 390):
            driver.set_window_size(width, 900)
            driver.get(path.as_uri())
            wait_until(driver, lambda page: page.execute_script(LINES.format(1)) >= 2)
            assert driver.execute_script(LINES.format(0)) == 4
            assert driver.get_log("browser") == []
            tool = driver.execute_script(
                "const t = byId('traces0').data[1]; return [t.x[0], t.y[0]]"
            )
            assert tool == [places[0][0], places[0][1]]
            wide = "return document.documentElement.scrollWidth - window.innerWidth"
            assert driver.execute_script(wide) <= 0
        table = driver.find_element("css selector", "table").text
        assert "pantograph" in table and "none" in table
