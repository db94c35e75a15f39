"""The page of a design space in a browser that has no network."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.app.answers.data import Report, report_data
from balance.app.answers.html.scene import scene
from balance.space.interpretation.explain import explain
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import PoseError
from tests.support.browser import (
    Keys,
    Select,
    complaints,
    needs_browser,
    one,
    play_until,
    settle,
    wait_until,
)
from tests.support.design_space_pages import (
    FOUR_BAR,
    PARALLEL,
    READ,
    drawn,
    links,
    opened,
    slide,
    written,
)
from tests.support.hostile_names import HOSTILE, hostile
from tests.support.laws import MODELS

pytestmark = needs_browser


def expected_marks(linkage, q):
    """Where the centres of the joints are drawn (joints, 3)."""
    H = links(linkage, q)
    placed = [
        D[:3, :3] @ joint.point + D[:3, 3] for D, joint in zip(H, linkage.joints, strict=True)
    ]
    return np.array(placed)


def nearest(points, others):
    """The largest distance from one of the points to the nearest of the others."""
    return np.linalg.norm(points[:, None] - others[None], axis=2).min(axis=1).max()


@pytest.mark.browser
def test_slider_moves_the_linkage(browser, pages):
    """The joints are drawn where Python's forward kinematics has them, to either side."""
    space, address = pages[FOUR_BAR]
    linkage = space.linkage
    opened(browser, address)
    rest = drawn(browser, "joints")
    assert np.abs(rest - [joint.point for joint in linkage.joints]).max() < 1e-12
    assert one(browser, ".reset").get_attribute("disabled")
    for degrees in (60, -60):
        slide(browser, 0, degrees)
        assert one(browser, "output").text == f"{degrees}°".replace("-", "−")
        q = joint_positions(linkage, {linkage.inputs[0]: np.radians(degrees)})
        found = drawn(browser, "joints")
        assert np.abs(found - expected_marks(linkage, q)).max() < 1e-6
        assert np.abs(found - rest).max() > 0.1
        assert np.allclose(drawn(browser, "reference")[:2], drawn_at_rest(space)[:2])
    one(browser, "#sliders input").send_keys(Keys.ARROW_RIGHT)
    assert one(browser, "output").text == "−59°"
    one(browser, ".reset").click()
    settle(browser)
    assert np.abs(drawn(browser, "joints") - rest).max() < 1e-12


@pytest.mark.browser
@pytest.mark.parametrize("model", MODELS)
def test_the_page_closes_the_loops_as_python_does(browser, pages, model):
    """Several inputs at once, on the same branch; it stops where Python's way ends."""
    if not browser.current_url.startswith("file:"):
        browser.get(pages[FOUR_BAR][1])
    linkage = kinematics.load(model)
    data = scene(linkage)
    slides = [linkage.joints[j].kind == "prismatic" for j in data["mechanism"]["inputs"]]
    reach = np.where(slides, 0.1 * data["mechanism"]["length"], 0.3)
    u = reach * np.resize([1.0, -0.7, 0.4], linkage.mobility)
    found = browser.execute_script(
        "const m = new Mechanism(arguments[0]);"
        "const {q, reached} = m.toward(new Float64Array(m.size), arguments[1]);"
        "return [[...q], reached, m.closure(q).error]",
        data["mechanism"],
        u.tolist(),
    )
    try:
        expected = joint_positions(linkage, u)
    except PoseError:
        assert not found[1]
    else:
        assert found[1]
        np.testing.assert_allclose(found[0], expected, atol=1e-7)
    assert found[2] < 1e-9


TURNS = "for (let k = 0; k < 120; k++) controls.step(0.1); return controls.values[0]"
OPEN = "return stage.mechanism.closure(stage.q).error"


@pytest.mark.browser
def test_a_crank_turns_fully_and_a_rocker_stops(browser, tmp_path_factory):
    """Play goes round where the loops close, and turns back where they do not."""
    for name, turns in (("four_bar_general", True), ("sarrus", False)):
        space = design_space(kinematics.load(name))
        opened(browser, written(tmp_path_factory.mktemp(name), space))
        found = []
        for _ in range(3):
            found.append(browser.execute_script(TURNS))
            assert browser.execute_script(OPEN) < 1e-9
        settle(browser)
        assert (max(map(abs, found)) > 4.0 * np.pi) == turns
        assert -180 <= float(one(browser, "#sliders input").get_property("value")) <= 180
        slide(browser, 0, -179 if not turns else 10)
        note = one(browser, "#sliders .note").text
        assert ("the loops close no further" in note) != turns


def drawn_at_rest(space):
    """Ends of the first link at the reference pose."""
    return np.array([joint.point for joint in space.linkage.joints[:2]])


@pytest.mark.browser
def test_primitives_ride_on_their_bodies(browser, pages):
    """All that is drawn of a freedom is carried along by the displacement of its body."""
    space, address = pages[FOUR_BAR]
    linkage = space.linkage
    opened(browser, address)
    names = ("plus", "minus")
    before = [drawn(browser, name) for name in names]
    slide(browser, 0, 60)
    q = joint_positions(linkage, {linkage.inputs[0]: np.pi / 3.0})
    H = {body.name: links(linkage, q)[body.link] for body in linkage.bodies}
    (freedom,) = explain(space).freedoms
    for name, points, positive in zip(names, before, (True, False), strict=True):
        bodies = [p.body for p in freedom.primitives if (p.value > 0) == positive]
        moved = [points @ H[body][:3, :3].T + H[body][:3, 3] for body in bodies]
        found = drawn(browser, name)
        kept = ~np.isnan(found[:, 0])
        assert kept.sum() > 50
        assert np.array_equal(kept, ~np.isnan(points[:, 0]))
        off = np.linalg.norm(np.array(moved)[:, kept] - found[kept], axis=2).min(axis=0)
        assert off.max() < 1e-6


@pytest.mark.browser
def test_freedoms_can_be_chosen(browser, pages, model):
    space, address = pages[model]
    opened(browser, address)
    explanation = explain(space)
    freedoms = [*explanation.freedoms, *(f for t in explanation.transfers for f in t.freedoms)]
    options = "return Array.from(document.querySelectorAll('#choice option'), (o) => o.text)"
    texts = browser.execute_script(options)
    assert len(texts) == len(freedoms)
    assert all(f.words in text for f, text in zip(freedoms, texts, strict=True))
    choice = Select(one(browser, "#choice"))
    for k in {0, len(freedoms) // 2, len(freedoms) - 1}:
        choice.select_by_index(k)
        settle(browser)
        assert one(browser, "#words").text == freedoms[k].words
        rows = browser.find_elements("css selector", "#primitives tbody tr")
        assert len(rows) == len(freedoms[k].primitives)
        for row, primitive in zip(rows, freedoms[k].primitives, strict=True):
            assert row.text.startswith(f"{primitive.value:+.4g}".replace("-", "−"))
            assert f"on {primitive.body}" in row.text
        signs = {primitive.value > 0 for primitive in freedoms[k].primitives}
        visible = {
            name: len(browser.execute_script(READ, name)) > 0
            for name in ("plus", "arrows", "minus")
        }
        assert (visible["plus"] or visible["arrows"]) == (True in signs)
        assert visible["minus"] == (False in signs)


def numbers(data):
    """All numbers in plain data."""
    if isinstance(data, dict | list):
        items = data.values() if isinstance(data, dict) else data
        return [number for item in items for number in numbers(item)]
    return [data] if type(data) in (int, float) else []


@pytest.mark.browser
def test_the_numbers_of_the_report_can_be_read(browser, pages, model):
    space, address = pages[model]
    opened(browser, address)
    one(browser, "summary").click()
    wanted = {
        float(n)
        for n in numbers(json.loads(json.dumps(report_data(Report(space, explain(space))))))
    }

    is_written = "return document.querySelector('#json pre').textContent !== ''"
    wait_until(browser, lambda page: page.execute_script(is_written))
    text = browser.execute_script("return document.body.innerText")
    words = re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", text)
    assert len(wanted) > 30 and wanted <= set(map(float, words))
    assert len(browser.find_elements("css selector", "#spectrum svg path")) > space.rank


@pytest.mark.browser
def test_sliders_combine(browser, pages):
    """Both are where they were put, and the linkage where Python has it for both."""
    space, address = pages[PARALLEL]
    linkage = space.linkage
    opened(browser, address)
    assert [label.text for label in browser.find_elements("css selector", ".slider label")] == [
        "u1",
        "u2 = u3",
    ]
    slide(browser, 0, 30)
    slide(browser, 1, -40)
    texts = [output.text for output in browser.find_elements("css selector", "#sliders output")]
    assert texts == ["30°", "−40°"]
    a, b = np.radians([30, -40])
    q = joint_positions(linkage, {"u1": a, "u2": b, "u3": b})
    marks = np.concatenate([drawn(browser, "joints"), drawn(browser, "balls")])
    expected = expected_marks(linkage, q)
    assert max(nearest(marks, expected), nearest(expected, marks)) < 1e-6
    assert "Play moves u2 = u3" in one(browser, "#sliders").text


@pytest.mark.browser
def test_play_moves_the_last_slider(browser, pages):
    """The picture changes while it plays, and stays when it stops."""
    opened(browser, pages[PARALLEL][1])
    slide(browser, 0, 10)
    moved = "Math.abs(controls.values[0] - Math.PI / 18) > 0.1"
    assert play_until(browser, ".play", moved) == ["Stop", "Play"]
    values = browser.execute_script("return controls.values")
    assert values[1] == 0.0
    assert browser.execute_script("return stage.mechanism.closure(stage.q).error") < 1e-9
    settle(browser)
    assert browser.execute_script("return controls.values") == values


@pytest.mark.browser
def test_the_page_asks_for_nothing_and_does_not_complain(browser, pages):
    opened(browser, pages[PARALLEL][1])
    slide(browser, 0, 60)
    assert complaints(browser) == []
    asked = "return performance.getEntriesByType('resource').map((entry) => entry.name)"
    assert all(url.startswith("data:") for url in browser.execute_script(asked))


@pytest.mark.browser
def test_names_of_files_do_not_run(browser, tmp_path):
    opened(browser, written(tmp_path, hostile(tmp_path)))
    assert one(browser, "h1").text == f"four_bar{HOSTILE} (hostile.urdf)"
    assert one(browser, ".slider label").text == "j1" + HOSTILE
    assert not browser.find_elements("css selector", "h1 b, label b, option b, td b, dd b")
    assert complaints(browser) == []
