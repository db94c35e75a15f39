"""The page of a design space in a browser that has no network."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from browser import Keys, Select, browser, needs_browser, one, settle, wait_until
from scipy.linalg import expm
from test_page import HOSTILE, hostile

import kinematics
from balance import design_space
from balance.interpretation.explain import explain
from balance.momentum.momentum_lines import meeting, momentum_lines
from balance.report.data import Report, report_data
from balance.report.html.report import report_page
from kinematics.closure.joint_positions import joint_positions
from kinematics.spatial.screws import hat

__all__ = ["browser"]

pytestmark = needs_browser
FOUR_BAR, PARALLEL = "four_bar_antiparallelogram", "three_rsr"
READ = "return document.getElementById('plot').data.find((t) => t.name === arguments[0])"


def written(folder, space):
    """The address of the page of a design space."""
    path = folder / "page.html"
    path.write_text(report_page(Report(space, explain(space))), encoding="utf-8")
    return path.as_uri()


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Design spaces and the addresses of their pages."""
    found = {}
    for model, motion in ((FOUR_BAR, None), (PARALLEL, "u2=u3")):
        space = design_space(kinematics.load(model), motion)
        found[model] = space, written(tmp_path_factory.mktemp("pages"), space)
    return found


@pytest.fixture(scope="module", params=[FOUR_BAR, PARALLEL])
def model(request):
    """Of module scope, so that one page is opened after the other."""
    return request.param


def opened(browser, address):
    """The page at its start: loaded, or put back there if it is loaded already."""
    if browser.current_url != address:
        browser.get_log("browser")
        browser.get(address)
    else:
        reset = one(browser, "#reset")
        if reset.is_enabled():
            reset.click()
        Select(one(browser, "#choice")).select_by_index(0)
    settle(browser)


def drawn(browser, name):
    """Vertices of a trace (n, 3); rows of nan separate lines."""
    trace = browser.execute_script(READ, name)
    return np.array([trace[axis] for axis in "xyz"], dtype=float).T


def links(linkage, q):
    """Displacements of all links at joint positions q, as products of exponentials."""
    H = []
    for joint, value in zip(linkage.joints, q, strict=True):
        before = H[joint.parent] if joint.parent >= 0 else np.eye(4)
        H.append(before @ expm(value * hat(joint.screw)))
    return H


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


def test_slider_moves_the_linkage(browser, pages):
    """The joints are drawn where Python's forward kinematics has them, at either end."""
    space, address = pages[FOUR_BAR]
    linkage = space.linkage
    opened(browser, address)
    rest = drawn(browser, "joints")
    assert np.abs(rest - [joint.point for joint in linkage.joints]).max() < 1e-12
    assert one(browser, "#reset").get_attribute("disabled")
    slider = one(browser, "#sliders input")
    for key in (Keys.END, Keys.HOME):
        slider.send_keys(key)
        settle(browser)
        (degrees,) = re.findall(r"-?[\d.]+", one(browser, "output").text.replace("−", "-"))
        assert abs(float(degrees)) == 60.0
        q = joint_positions(linkage, {linkage.inputs[0]: np.radians(float(degrees))})
        found = drawn(browser, "joints")
        assert np.abs(found - expected_marks(linkage, q)).max() < 1e-6
        assert np.abs(found - rest).max() > 0.1
        assert np.allclose(drawn(browser, "reference")[:2], drawn_at_rest(space)[:2])
    slider.send_keys(Keys.ARROW_RIGHT)
    one(browser, "#reset").click()
    settle(browser)
    assert np.abs(drawn(browser, "joints") - rest).max() < 1e-12


def drawn_at_rest(space):
    """Ends of the first link at the reference pose."""
    return np.array([joint.point for joint in space.linkage.joints[:2]])


def test_primitives_ride_on_their_bodies(browser, pages):
    """All that is drawn of a freedom is carried along by the displacement of its body."""
    space, address = pages[FOUR_BAR]
    linkage = space.linkage
    opened(browser, address)
    names = ("plus", "minus")
    before = [drawn(browser, name) for name in names]
    slider = one(browser, "#sliders input")
    slider.send_keys(Keys.END)
    settle(browser)
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
            name: browser.execute_script(READ, name)["visible"]
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


def test_the_numbers_of_the_report_can_be_read(browser, pages, model):
    space, address = pages[model]
    opened(browser, address)
    one(browser, "summary").click()
    text = browser.execute_script("return document.body.innerText")
    shown = {float(word) for word in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", text)}
    wanted = numbers(json.loads(json.dumps(report_data(Report(space, explain(space))))))
    assert len(wanted) > 30 and not [n for n in wanted if float(n) not in shown]
    assert len(browser.find_elements("css selector", "#spectrum svg path")) > space.rank


def test_each_slider_moves_alone(browser, pages):
    space, address = pages[PARALLEL]
    linkage = space.linkage
    opened(browser, address)
    assert [label.text for label in browser.find_elements("css selector", ".slider label")] == [
        "u1", "u2 = u3",
    ]  # fmt: skip
    first, second = browser.find_elements("css selector", "#sliders input")
    middle = first.get_attribute("value")
    first.send_keys(Keys.END)
    second.send_keys(Keys.HOME)
    settle(browser)
    assert first.get_attribute("value") == middle
    q = joint_positions(linkage, {"u2": -np.pi / 3.0, "u3": -np.pi / 3.0})
    marks = np.concatenate([drawn(browser, "joints"), drawn(browser, "balls")])
    expected = expected_marks(linkage, q)
    assert max(nearest(marks, expected), nearest(expected, marks)) < 1e-6
    assert "moves alone" in one(browser, "#sliders").text


def test_the_page_asks_for_nothing_and_does_not_complain(browser, pages):
    opened(browser, pages[PARALLEL][1])
    one(browser, "#sliders input").send_keys(Keys.END)
    settle(browser)
    assert not [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
    asked = "return performance.getEntriesByType('resource').map((entry) => entry.name)"
    assert all(url.startswith("data:") for url in browser.execute_script(asked))


def test_lines_of_momentum_move_with_the_linkage(browser, tmp_path_factory):
    """Those drawn are the axes that Python finds at the pose; where they meet is said."""
    space = design_space(linkage := kinematics.load("four_bar_kite_balanced"))
    opened(browser, written(tmp_path_factory.mktemp("balanced"), space))
    told = set()
    for key, u in ((None, 0.0), (Keys.HOME, -np.pi / 3.0)):
        if key:
            one(browser, "#sliders input").send_keys(key)
            settle(browser)
        (lines,) = momentum_lines(linkage, [u])
        expected = meeting(lines)
        ends = drawn(browser, "momenta").reshape(-1, 3, 3)[:, :2]
        for line, (a, b) in zip(lines, ends, strict=True):
            d = (b - a) / np.linalg.norm(b - a)
            assert np.abs(d - line.direction).max() < 1e-6
            assert np.linalg.norm(np.cross(a - expected.point, d)) < 1e-6
        assert np.abs(drawn(browser, "meeting") - expected.point).max() < 1e-6
        words = one(browser, "#meeting").text
        assert words.startswith("The three lines meet in one point, ")
        x, y, *_ = re.findall(r"-?[\d.]+\d", words.replace("−", "-"))
        assert np.allclose([float(x), float(y)], expected.point[:2], rtol=1e-3)
        rows = browser.find_elements("css selector", "#momenta tbody tr")
        for row, line in zip(rows, lines, strict=True):
            assert row.text.startswith(f"{line.body} {line.magnitude:.4g} N s")
        told.add(words)
    assert len(told) == 2


def test_lines_of_momentum_of_chosen_freedoms(browser, pages, model):
    """Whatever is chosen of the design space, wrenches along the lines cancel."""
    opened(browser, pages[model][1])
    masses, texts = Select(one(browser, "#masses")), []
    for value in ("all", "chosen", "given", "none"):
        masses.select_by_value(value)
        settle(browser)
        texts.append(one(browser, "#meeting").text)
        found = browser.execute_script(
            "const m = byId('masses').value; if (m === 'none') return [];"
            "return scene.columns.flatMap((c) => c.poses.map((H, k) => scene.bodies.map("
            "(b, i) => momentum(MASSES[m].of()[i], H[b.part], c.rates[k][i]))))"
        )
        for bodies in found:
            h = np.array([[*b["moment"], *b["force"]] for b in bodies])
            whole = max(b["whole"] for b in bodies)
            if value != "given":
                assert np.abs(h.sum(axis=0)).max() < 1e-6 * whole
            elif model == FOUR_BAR:
                assert np.abs(h.sum(axis=0)).max() > 1e-3 * whole
    assert ("meet in one point" in texts[0]) == (model == FOUR_BAR)
    assert texts[2].startswith("These masses are not balanced" if model == FOUR_BAR else "The ")
    assert texts[3] == "" and not browser.find_elements("css selector", "#momenta table")


def test_the_page_can_be_printed(browser, pages):
    """On paper the canvas is a picture, and what is there to be touched is left out."""
    opened(browser, pages[PARALLEL][1])
    wait_until(browser, lambda driver: one(driver, "#paper").get_property("naturalWidth") > 500)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    shown = {
        selector: one(browser, selector).is_displayed()
        for selector in ("#paper", "#plot", "#sliders input", "#choice", "#reset", "#freedoms")
    }
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert {selector for selector, seen in shown.items() if seen} == {"#paper", "#freedoms"}


def test_the_page_fits_a_phone(browser, pages):
    """Also when the phone is turned: the drawing follows the width of the page."""
    phone = {"width": 360, "height": 740, "deviceScaleFactor": 1, "mobile": True}
    opened(browser, pages[PARALLEL][1])
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", phone)
    size = browser.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
    canvas = "return document.querySelector('#plot canvas').clientWidth"
    wait_until(browser, lambda driver: 200 < driver.execute_script(canvas) <= 360)
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert size == [360, 360]


def test_names_of_files_do_not_run(browser, tmp_path):
    opened(browser, written(tmp_path, hostile(tmp_path)))
    assert one(browser, "h1").text == "four_bar" + HOSTILE
    assert one(browser, ".slider label").text == "j1" + HOSTILE
    assert not browser.find_elements("css selector", "h1 b, label b, option b, td b, dd b")
    assert not [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
