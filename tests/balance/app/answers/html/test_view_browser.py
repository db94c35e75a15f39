"""How a drawing looks and is handled: labels, frame, keys, light and dark, paper, phones."""

from __future__ import annotations

import numpy as np
import pytest

from kinematics.closure.joint_positions import joint_positions
from tests.support.browser import Keys, Select, needs_browser, one, screen, settle, wait_until
from tests.support.design_space_pages import (
    FOUR_BAR,
    PARALLEL,
    drawn,
    links,
    opened,
    slide,
)

pytestmark = needs_browser


@pytest.mark.browser
def test_labels_do_not_collide(browser, pages, model):
    """No label covers another or leaves the frame, at several poses."""
    opened(browser, pages[model][1])
    for degrees in (0, 25, -25):
        slide(browser, 0, degrees)
        boxes, size = browser.execute_script(
            "return [stage.view.placed.map((w) => w.box), [stage.view.W, stage.view.H]]"
        )
        assert len(boxes) > 3
        for k, (x0, y0, x1, y1) in enumerate(boxes):
            assert x0 > -1 and y0 > -1 and x1 < size[0] + 1 and y1 < size[1] + 1
            for a0, b0, a1, b1 in boxes[:k]:
                assert min(x1, a1) - max(x0, a0) < 3 or min(y1, b1) - max(y0, b0) < 3


@pytest.mark.browser
def test_the_figure_fills_its_frame(browser, pages, model):
    opened(browser, pages[model][1])
    box = browser.execute_script(
        "const p = stage.cloud().map((x) => stage.view.project(x));"
        "const ends = (x) => [Math.min(...x), Math.max(...x)];"
        "return [0, 1].map((i) => ends(p.map((x) => x[i])))"
    )
    size = browser.execute_script("return [stage.view.W, stage.view.H]")
    pairs = list(zip(box, size, strict=True))
    assert all(0 < low and high < full for (low, high), full in pairs)
    assert max((high - low) / full for (low, high), full in pairs) > 0.75


@pytest.mark.browser
def test_keys_turn_and_magnify(browser, pages):
    opened(browser, pages[PARALLEL][1])
    canvas = one(browser, "#plot canvas")
    state = "return [stage.view.zoom, ...stage.view.toward]"
    before = browser.execute_script(state)
    canvas.send_keys(Keys.ARROW_LEFT, "+")
    turned = browser.execute_script(state)
    assert turned[0] == pytest.approx(1.2 * before[0])
    assert np.abs(np.subtract(turned[1:], before[1:])).max() > 0.05
    canvas.send_keys(Keys.HOME)
    settle(browser)
    assert browser.execute_script(state) == pytest.approx(before)


@pytest.mark.browser
def test_centres_of_mass_and_a_path(browser, pages):
    """Centres are drawn where the bodies have them; the path passes the end of the body."""
    space, address = pages[FOUR_BAR]
    opened(browser, address)
    one(browser, "#view input[name=centres]").click()
    Select(one(browser, "#view select")).select_by_index(1)
    slide(browser, 0, 20)
    slide(browser, 0, 40)
    bodies = [body for body in space.linkage.bodies if body.inertia[0] > 0]
    q = joint_positions(space.linkage, {space.inputs[0]: np.radians(40)})
    H = links(space.linkage, q)
    expected = [(H[b.link] @ [*b.inertia[1:4] / b.inertia[0], 1.0])[:3] for b in bodies]
    np.testing.assert_allclose(drawn(browser, "centres"), expected, atol=1e-6)
    mass = [body.inertia[0] for body in bodies]
    common = np.average(expected, axis=0, weights=mass)
    trail = drawn(browser, "trail")
    np.testing.assert_allclose(trail[~np.isnan(trail[:, 0])][-1], common, atol=1e-6)
    one(browser, "#view input[name=centres]").click()
    Select(one(browser, "#view select")).select_by_index(0)


@pytest.mark.browser
def test_the_page_can_be_printed(browser, pages):
    """On paper what is there to be touched is left out, also in the dark; colours are light."""
    opened(browser, pages[PARALLEL][1])
    places = (
        "#plot canvas",
        "#sliders input",
        "#choice",
        ".reset",
        ".play",
        "#view",
        "#freedoms",
    )
    dark = [{"name": "prefers-color-scheme", "value": "dark"}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print", "features": dark})
    browser.execute_script("dispatchEvent(new Event('beforeprint'))")
    shown = {selector: one(browser, selector).is_displayed() for selector in places}
    ground = browser.execute_script("return getComputedStyle(document.body).backgroundColor")
    ink = browser.execute_script("return tone('#1b1e22')")
    browser.execute_script("dispatchEvent(new Event('afterprint'))")
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})
    assert {selector for selector, seen in shown.items() if seen} == {
        "#plot canvas",
        "#freedoms",
    }
    assert ground == "rgb(255, 255, 255)" and ink.startswith("rgb(27 30 34")


@pytest.mark.browser
def test_light_and_dark(browser, pages):
    """Text and links differ from the ground in either scheme, without a new load."""
    opened(browser, pages[PARALLEL][1])
    colour = "return getComputedStyle(document.body).backgroundColor"
    for scheme, ground in (("light", 255), ("dark", 26)):
        with screen(browser, 800, 700, scheme):
            shown = f"rgb({ground}, {ground}, {ground})"
            wait_until(browser, lambda page, shown=shown: page.execute_script(colour) == shown)
            settle(browser)
            ink, link = browser.execute_script("return [shade(INK), shade(LINK)]")
            assert (
                abs(np.mean(ink) - ground / 255) > 0.5
                and abs(np.mean(link) - ground / 255) > 0.25
            )


@pytest.mark.browser
def test_the_page_fits_a_phone(browser, pages):
    """Also when the phone is turned: the drawing follows the width of the page."""
    opened(browser, pages[PARALLEL][1])
    with screen(browser, 360, 740):
        canvas = "return document.querySelector('#plot canvas').clientWidth"
        wait_until(browser, lambda driver: 200 < driver.execute_script(canvas) <= 360)
        size = browser.execute_script(
            "return [document.documentElement.scrollWidth, innerWidth]"
        )
    assert size == [360, 360]
