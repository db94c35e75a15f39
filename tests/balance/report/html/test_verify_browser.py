"""The page of a verification in a browser that has no network."""

from __future__ import annotations

import pytest
from browser import needs_browser, started, wait_until

import kinematics
from balance.report.html.verification import verification_page
from balance.verification.to_pinocchio import verify, verify_second

pytestmark = needs_browser
DRAWN = "return document.querySelectorAll('.traces .scatterlayer path.js-line').length"


def test_curves_are_drawn_offline(tmp_path):
    first = verify(kinematics.load("four_bar_general"), trajectories=1, samples=40)
    second = verify_second(first, kinematics.load("four_bar_kite_balanced"))
    path = tmp_path / "page.html"
    path.write_text(verification_page([first, second]), encoding="utf-8")
    with started(tmp_path / "profile") as driver:
        driver.get(path.as_uri())
        wait_until(driver, lambda page: page.execute_script(DRAWN) == 21)
        assert driver.get_log("browser") == []
        # Panels side by side have one scale.
        scales = driver.execute_script(
            "return [0, 1].map((k) => byId(`traces${k}`)._fullLayout.yaxis2.range)"
        )
        assert scales[0] == pytest.approx(scales[1])
        assert scales[0][1] > 1.0
        facts = driver.find_element("css selector", "main").text
        assert "not balanced (tolerance" in facts
