"""Pages of planned motions: what the scripts draw is what the plan and its timings shake."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from balance.app.answers.html.quiet_page import quiet_page
from tests.support.page_elements import Elements
from tests.support.planned_arms import base_wrenches, planar_arm, slide


def by_name(chart):
    """The traces of a chart by name."""
    return {trace["name"]: trace for trace in chart["data"]}


@pytest.mark.slow
def test_the_curve_of_time_and_shaking():
    """2 kg over 0.5 m at 0.8 m/s: F = 2 v / t with v t = v T - 0.5.

    In the shortest duration 9 m/s² reach the speed; the plan is at the end of the curve.
    """
    speed, duration = 0.8, 1.0
    options = {"measure": "peak", "velocity": speed, "acceleration": 9.0, "front": 5}
    plan = balance.quiet_timing(slide(), [[0.0], [0.5]], duration, **options)
    traces = by_name(Elements(quiet_page(plan)).data("front"))
    times, forces = (np.array(traces["least"][axis]) for axis in "xy")
    assert times[0] == pytest.approx(0.5 / speed + speed / 9.0, rel=5e-3)
    by_hand = 2.0 * speed / (times - 0.5 / speed)
    assert forces[1:] == pytest.approx(by_hand[1:], rel=2e-2)
    for name, height in (("planned", forces[-1]), ("quintic", 10.0 / np.sqrt(3.0))):
        assert traces[name]["x"] == [duration]
        assert traces[name]["y"][0] == pytest.approx(height, rel=1e-3)
    # 15 d / (8 T) is the speed of the quintic law, 1.5 d / T that of the trapezoidal one.
    symbols = {name: trace["marker"].get("symbol") for name, trace in traces.items()}
    assert symbols["quintic"] == "x" and symbols["trapezoidal"] == "circle"


@pytest.mark.slow
def test_curves_over_time_are_those_of_pinocchio():
    """No curve of time and shaking without a front; the force of both motions."""
    arm = planar_arm(2)
    plan = balance.quiet_timing(arm, [[0.2, 0.4], [1.4, 1.5]], 1.0)
    text = quiet_page(plan)
    assert "front_curve" not in text
    paths = plan.path, plan.laws[0].path
    for model, path in zip(Elements(text).data("models"), paths, strict=True):
        (run,) = model["runs"]
        time = np.array(run["time"])
        force = np.linalg.norm(base_wrenches(arm, *path.at(time))[:, 3:], axis=1)
        curve = next(t for t in run["chart"]["data"] if t.get("yaxis") == "y")
        drawn = np.interp(time, curve["x"], np.array(curve["y"], dtype=float))
        assert np.abs(drawn - force).max() < 2e-3 * force.max()


@pytest.mark.browser
def test_the_curve_is_drawn_offline(request, tmp_path):
    helper = pytest.importorskip("tests.support.browser")
    if not (helper.BROWSER and helper.DRIVER):
        pytest.skip("no chromium with its chromedriver on the PATH")
    driver = request.getfixturevalue("browser")
    drawn = "return document.querySelectorAll('#front_curve .line').length"
    plan = balance.quiet_timing(slide(), [[0.0], [0.5]], 1.0, velocity=0.75, front=4)
    for width in (1280, 390):
        with helper.screen(driver, width):
            helper.show(driver, tmp_path, quiet_page(plan))
            helper.wait_until(driver, lambda view: view.execute_script(drawn) == 1)
            assert helper.complaints(driver) == []
            assert helper.too_wide(driver) == 0
