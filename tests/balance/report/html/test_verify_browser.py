"""The page of a verification in a browser that has no network."""

from __future__ import annotations

import pytest
import test_page_browser
from test_page_browser import FLAGS

import kinematics
from balance.report.html.verification import webpage
from balance.verification.pinocchio_model import beside, verify

pytestmark = test_page_browser.pytestmark
DRAWN = "return document.querySelectorAll('.traces .scatterlayer path.js-line').length"


def test_curves_are_drawn_offline(tmp_path):
    webdriver = test_page_browser.webdriver
    options = webdriver.ChromeOptions()
    options.binary_location = test_page_browser.BROWSER
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for flag in (*FLAGS.split(), f"--user-data-dir={tmp_path}"):
        options.add_argument(flag)
    options.add_argument("--host-resolver-rules=MAP * ~NOTFOUND")
    first = verify(kinematics.load("four_bar_general"), trajectories=1, samples=40)
    second = beside(first, kinematics.load("four_bar_kite_balanced"))
    path = tmp_path / "page.html"
    path.write_text(webpage([first, second]), encoding="utf-8")
    service = webdriver.ChromeService(executable_path=test_page_browser.DRIVER)
    with webdriver.Chrome(options=options, service=service) as driver:
        driver.get(path.as_uri())
        wait = test_page_browser.WebDriverWait(driver, 60, poll_frequency=0.05)
        wait.until(lambda page: page.execute_script(DRAWN) == 21)
        assert driver.get_log("browser") == []
        # Panels side by side have one scale.
        scales = driver.execute_script(
            "return [0, 1].map((k) => byId(`traces${k}`)._fullLayout.yaxis2.range)"
        )
        assert scales[0] == pytest.approx(scales[1])
        assert scales[0][1] > 1.0
        facts = driver.find_element("css selector", "main").text
        assert "not balanced (tolerance" in facts
