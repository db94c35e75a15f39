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
