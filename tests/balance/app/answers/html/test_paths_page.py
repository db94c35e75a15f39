"""The page of reactionless paths: what it holds, and that it is drawn without a network."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import balance
from balance.app.answers.html.paths import momentum_field, paths_page


def run_of(text):
    """The data of the script of a page."""
    return json.loads(re.findall(r'id="run">(.*?)</script>', text, re.DOTALL)[0])


@pytest.mark.slow
def test_the_field_is_the_momentum_matrix_of_each_pose():
    """Shade and strokes by `reaction_null_space` at single poses, whatever has no path too."""
    for name, kept in (("five_bar", "all"), ("five_bar", "moment")):
        found = balance.find_paths(name, kept=kept, length=0.2)
        field = momentum_field(found)
        for i, j in ((30, 30), (12, 36), (45, 9)):
            u = [field.first[i], field.second[j]]
            M = balance.pose.momentum_matrix(found.linkage, u)[
                0 if kept == "all" else slice(0, 3)
            ]
            single = balance.pose.reaction_null_space(
                found.linkage, u, "both" if kept == "all" else "moment"
            )
            counted = 1 if kept == "all" else 0
            expected = single.singular_values[counted] / single.scale
            assert field.size[i, j] == pytest.approx(expected, rel=1e-6)
            if kept == "moment":
                k = 3 * (i // 3 * len(field.first[::3]) + j // 3)
                way = field.strokes[k + 1] - field.strokes[k]
                assert np.abs(M @ way).max() < 1e-9 * np.abs(M).max()


@pytest.mark.slow
def test_a_page_without_paths_shows_where_the_linkage_is_quiet():
    found = balance.find_paths("five_bar")
    data = run_of(paths_page(found))
    assert data["paths"] == [] and len(data["field"]["size"]) == 61
    spatial = balance.find_paths("three_rrr", kept="force", length=0.1)
    assert run_of(paths_page(spatial))["field"] is None


@pytest.mark.slow
def test_an_input_that_rests_is_no_axis():
    """Each path in the plane of what moves; one input alone over the length of the path."""
    found = balance.find_paths("pantograph_reaction_wheel", length=0.5)
    names, alone = found.linkage.inputs, 0
    data = run_of(paths_page(found))
    for path, drawn in zip(found.paths, data["paths"], strict=True):
        reach = np.ptp(path.u, axis=0)
        axes, ranges = drawn["plane"]["axes"], drawn["plane"]["ranges"]
        x, y = (np.array(drawn["u"][k]) for k in axes)
        assert (axes[0] == len(names)) == (np.sort(reach)[-2] < 1e-6)
        for axis, values in zip(ranges, (x, y), strict=True):
            assert axis[0] <= values.min() and values.max() <= axis[1]
            assert np.ptp(axis) < 1.3 * np.ptp(values)
        if axes[0] == len(names):
            alone += 1
            assert data["inputs"][axes[0]].startswith("arc length")
            assert axes[1] == np.argmax(reach)
            # The curve: at each place along the path the input is where the path has it.
            np.testing.assert_allclose(y, np.interp(x, path.s, path.u[:, axes[1]]), atol=5e-3)
        else:
            assert set(axes) == set(np.argsort(-reach)[:2])
    assert 0 < alone < len(found.paths)


@pytest.mark.slow
def test_shaking_is_drawn_beside_what_would_shake_if_nothing_cancelled():
    """The axis of a path without shaking is not one of round-off."""
    found = balance.find_paths("slider_pantograph", length=0.5)
    loads = run_of(paths_page(found))["paths"][0]["loads"]
    for name in ("force", "moment"):
        whole, bodies = np.array(loads[name]), np.array(loads[f"own {name}"])
        assert bodies.max() > 1e-2 and whole.max() < 1e-9 * bodies.max()


@pytest.mark.browser
def test_the_page_runs_offline(request, tmp_path):
    """The slider moves the linkage, another path is chosen; no wider than the screen."""
    helper = pytest.importorskip("tests.support.browser")
    if not (helper.BROWSER and helper.DRIVER):
        pytest.skip("no chromium with its chromedriver on the PATH")
    driver = request.getfixturevalue("browser")
    text = paths_page(balance.find_paths("fuga_i", length=0.3))
    drawn = "return document.querySelectorAll('#plane image.shade').length"
    dot = "return document.querySelector('#plane .mark').getAttribute('transform')"
    choose = "byId(arguments[0]).value = arguments[1];"
    choose += "byId(arguments[0]).dispatchEvent(new Event('input'))"
    for width in (1280, 390):
        with helper.screen(driver, width):
            helper.show(driver, tmp_path, text)
            helper.wait_until(driver, lambda view: view.execute_script(drawn) == 1)
            places = [driver.execute_script(dot)]
            for name, value in (("time", "30"), ("time", "45"), ("chosen", "1")):
                driver.execute_script(choose, name, value)
                places.append(driver.execute_script(dot))
            assert len(set(places)) == 4
            assert helper.complaints(driver) == []
            assert helper.too_wide(driver) == 0
