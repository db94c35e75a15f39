"""The page of a verification in a browser that has no network."""

from __future__ import annotations

import numpy as np
import pytest
from selenium.webdriver.common.by import By

import kinematics
from balance.app.answers.html.verification_page import verification_page
from balance.motion.verification.verify_motions import verify, verify_second
from tests.support.browser import (
    Select,
    complaints,
    needs_browser,
    one,
    play_until,
    settle,
    show,
    too_wide,
)

pytestmark = needs_browser
MODELS = ("four_bar_general", "four_bar_kite_balanced")


@pytest.fixture(scope="module")
def found():
    """Verifications of two linkages over three motions."""
    first = verify(kinematics.load(MODELS[0]), trajectories=3, samples=40)
    return first, verify_second(first, kinematics.load(MODELS[1]))


@pytest.fixture
def opened(browser, tmp_path, found):
    """A browser that shows their page."""
    show(browser, tmp_path, verification_page(*found))
    settle(browser)
    return browser


def numbers(browser, k):
    """The table of the motion drawn, as text by label."""
    rows = one(browser, f"#numbers{k}").find_elements(By.CSS_SELECTOR, "tr")
    return {
        row.find_element(By.TAG_NAME, "th").text: row.find_element(By.TAG_NAME, "td").text
        for row in rows
    }


def size_of(load):
    """A load in words; the second linkage is balanced, and its loads are round-off."""
    return f"{load:.3g}" if load > 1e-3 else "below 1e-09"


@pytest.mark.browser
def test_curves_are_drawn_offline(opened):
    lines = "return document.querySelectorAll('#traces0 .line, #traces1 .line').length"
    assert opened.execute_script(lines) == 21
    # Panels side by side have one scale.
    scales = opened.execute_script(
        "return [0, 1].map((k) => byId(`traces${k}`).chart.panels[1].y.range)"
    )
    assert scales[0] == scales[1] and scales[0][1] > 1.0
    assert "not balanced (tolerance" in one(opened, "main").text
    assert complaints(opened) == [] and too_wide(opened) == 0


@pytest.mark.browser
def test_numbers_belong_to_the_motion_drawn(opened, found):
    """The choice changes curves, poses and the table, of both linkages."""
    choice = Select(one(opened, "#motion"))
    assert choice.first_selected_option.text.endswith("which decides the verdict")
    assert choice.options.index(choice.first_selected_option) == found[0].plotted
    for k in range(3):
        choice.select_by_index(k)
        settle(opened)
        for i, verification in enumerate(found):
            run = verification.runs[k]
            told = numbers(opened, i)
            assert told["shaking force, peak"] == f"{size_of(run.peak('force'))} N"
            assert told["shaking moment, rms"] == f"{size_of(run.rms('moment'))} N m"
            drawn = opened.execute_script(
                "return byId(arguments[0]).chart.traces.map((t) => t.y)", f"traces{i}"
            )
            np.testing.assert_allclose(drawn[0], run.trajectory.u[:, 0], rtol=1e-5, atol=1e-9)
            np.testing.assert_allclose(drawn[1], -run.middle[:, 3], rtol=1e-5, atol=1e-9)


@pytest.mark.browser
def test_the_mechanism_moves_with_the_time(opened, found):
    """The slider and Play put the joints where the motion has them."""
    opened.execute_script("time.value = 500; time.dispatchEvent(new Event('input'))")
    settle(opened)
    run = found[0].runs[found[0].plotted].trajectory
    q, t = opened.execute_script("return [[...stages[0].q], parseFloat(now.textContent)]")
    at = int(np.argmin(np.abs(run.time - run.time[0] - t)))
    np.testing.assert_allclose(q, run.q[at], rtol=1e-5, atol=1e-9)
    labels = play_until(opened, "#play", "Math.abs(time.value - 500) > 60")  # two samples
    assert labels == ["Stop", "Play"]
    moved = opened.execute_script("return [...stages[0].q]")
    assert np.abs(np.array(moved) - q).max() > 1e-4


@pytest.mark.browser
def test_the_polar_plot_is_the_shaking_force(opened, found):
    run = found[0].runs[found[0].plotted]
    (trace,) = opened.execute_script("return byId('polar0').chart.traces")
    reach = np.hypot(trace["x"], trace["y"])
    np.testing.assert_allclose(reach, run.sizes("force"), rtol=1e-5, atol=1e-9)
