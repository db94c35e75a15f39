"""The page of a design in a browser that has no network."""

from __future__ import annotations

import numpy as np
import pytest

from balance.bodies import mass_properties
from kinematics.closure.joint_positions import joint_positions
from tests.support.browser import needs_browser, one, settle, wait_until
from tests.support.design_pages import FOUR_BAR, case
from tests.support.design_space_pages import drawn, links, slide

pytestmark = needs_browser


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    """A design, and a browser that shows its page."""
    found, text = case(FOUR_BAR, None)
    path = tmp_path_factory.mktemp("page") / "design.html"
    path.write_text(text, encoding="utf-8")
    browser.get(path.as_uri())
    settle(browser)
    return found, browser


def choose(browser, value):
    one(browser, f"#shown input[value={value}]").click()
    settle(browser)


def centres(parameters):
    return np.array([mass_properties(z).com for z in parameters])


@pytest.mark.browser
def test_masses_are_drawn_where_they_are(opened):
    found, browser = opened
    before = centres([body.inertia for body in found.space.linkage.bodies])
    after = centres(found.z)
    choose(browser, "designed")
    np.testing.assert_allclose(drawn(browser, "designed centres"), after, atol=1e-12)
    assert drawn(browser, "given centres").size == 0
    choose(browser, "given")
    np.testing.assert_allclose(drawn(browser, "given centres"), before, atol=1e-12)
    assert drawn(browser, "designed centres").size == 0
    choose(browser, "both")
    assert len(drawn(browser, "given centres")) == len(drawn(browser, "designed centres")) == 3
    # Before is in outline where after is a surface.
    assert drawn(browser, "given surfaces").size == 0
    assert len(drawn(browser, "given outlines")) > 50 < len(drawn(browser, "designed outlines"))


@pytest.mark.browser
def test_masses_ride_on_their_bodies(opened):
    found, browser = opened
    linkage = found.space.linkage
    choose(browser, "designed")
    slide(browser, 0, 60)
    settle(browser)
    H = links(linkage, joint_positions(linkage, {linkage.inputs[0]: np.pi / 3.0}))
    carried = [
        H[body.link] @ [*c, 1.0]
        for body, c in zip(linkage.bodies, centres(found.z), strict=True)
    ]
    found = drawn(browser, "designed centres")
    np.testing.assert_allclose(found, np.array(carried)[:, :3], atol=1e-6)
    one(browser, ".reset").click()
    settle(browser)


@pytest.mark.browser
def test_page_is_whole_and_offline(opened):
    _, browser = opened
    severe = [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
    assert severe == []
    assert one(browser, "#caption").text.startswith("The linkage at its reference pose.")
    assert len(browser.find_elements("css selector", "#legend li")) == 4
    one(browser, "summary").click()
    json = "return document.querySelector('#json pre').textContent"
    told = '"schema": "balance.design/2"'
    wait_until(browser, lambda page: told in page.execute_script(json))
