"""Pages of answers in a browser: matter, identification, links that bend, floating bases.

Each one is opened at the width of a desk and of a phone, in light and in dark.
"""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

import balance
import kinematics
from balance.app.answers.data import Report
from balance.app.answers.html.compare import compare_page
from balance.app.answers.text.identification import plan_sentence
from balance.masses.identification.load_rows import load_rows
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.interpretation.explain import explain
from balance.support.options import GRAVITY
from kinematics.closure.joint_positions import input_chain
from tests.support.browser import (
    complaints,
    needs_browser,
    one,
    play_until,
    screen,
    settle,
    show,
    too_wide,
)
from tests.support.design_space_pages import drawn, slide

pytestmark = [needs_browser, pytest.mark.browser]

MODEL = "four_bar_general"
SCREENS = ((1280, "light"), (1280, "dark"), (390, "light"), (390, "dark"))
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")


@cache
def plan():
    """A motion to be measured."""
    return balance.masses.exciting_motion(MODEL, 1.0, harmonics=2, tries=4)


@cache
def identification():
    """Masses from the wrench of 1.3 times the masses of the file."""
    linkage, way = kinematics.load(MODEL), plan().trajectory
    masses = to_chain(
        np.array([1.3 * body.inertia for body in linkage.bodies]),
        input_chain(linkage).frame,
        False,
        False,
    )
    wrench = load_rows(linkage, way, np.array(GRAVITY), np.zeros(3)).wrench @ masses.ravel()
    noise = 1e-3 * np.random.default_rng(1).normal(size=wrench.shape)
    loads = dict(zip(WRENCH, (wrench + noise).T, strict=True))
    return balance.identify(linkage, way, {"time": way.time, **loads}, on_linkage=True)


@cache
def weights():
    return balance.counterweights(
        MODEL, ["crank", "rocker"], balance="force", density=7850.0, speed="300rpm"
    )


@cache
def front():
    return balance.pareto(MODEL, ["crank", "rocker"], 2, 0.3, speed="300rpm")


@cache
def bending():
    return balance.flexible.simulate_flexible(
        MODEL, ["coupler=EI:40,rhoA:1"], {"u1": "spin:20,0.02"}, duration=0.05, samples=21
    )


@cache
def floating():
    base = balance.motion.FloatingBase(5.0, 1.0)
    return balance.motion.simulate_floating_base(MODEL, base, duration=0.05)


@cache
def pair():
    heavier = [2.0 * body.inertia for body in kinematics.load(MODEL).bodies]
    double = balance.verify(MODEL, heavier, speed="60rpm", crank="u1")
    return balance.motion.verify_against(double, MODEL)


@pytest.mark.parametrize("width", [1280, 390])
def test_linkages_side_by_side(width, browser, tmp_path):
    """Each has its drawing and its sliders; the top has the dimension of each."""
    reports = [
        Report(space, explain(space)) for space in map(balance.design_space, (MODEL, "hprs"))
    ]
    with screen(browser, width):
        show(browser, tmp_path, compare_page(reports))
        settle(browser)
        assert complaints(browser) == [] and too_wide(browser) == 0
        words = one(browser, ".lede").text
        for report in reports:
            space = report.space
            count = f"{space.nullity} dimensions of {space.rank + space.nullity}"
            assert space.linkage.name in words and count in words
        assert len(browser.find_elements("css selector", ".model canvas")) >= 2
        assert len(browser.find_elements("css selector", "input[type=range]")) == sum(
            report.space.linkage.mobility for report in reports
        )


# Answers, what the top of their page says, and how many lines their curves have at least.
ANSWERS = {
    "identification": (identification, lambda answer: answer.sentence, 6),
    "plan": (plan, plan_sentence, 3),
    "counterweights": (weights, lambda answer: answer.sentence, 6),
    "front": (front, lambda answer: answer.designs[-1].sentence, 6),
    "bending": (bending, lambda answer: "It shakes its mount with at most", 6),
    "floating base": (floating, lambda answer: answer.verdict, 10),
    "comparison": (pair, lambda answer: answer.sentence, 6),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_pages_are_whole_on_a_desk_and_on_a_phone(name, browser, tmp_path):
    make, sentence, lines = ANSWERS[name]
    text = make().to_html()
    for width, scheme in SCREENS:
        with screen(browser, width, scheme=scheme):
            show(browser, tmp_path, text)
            settle(browser)
            assert complaints(browser) == [] and too_wide(browser) == 0
            words = " ".join(one(browser, ".lede").text.split())
            assert sentence(make()).removesuffix(".") in words
            assert len(browser.find_elements("css selector", ".traces .line")) >= lines
            colour = one(browser, "body").value_of_css_property("background-color")
            shade = np.mean([float(part) for part in re.findall(r"[\d.]+", colour)[:3]])
            assert shade < 64 if scheme == "dark" else shade > 192


def test_identified_masses_explain_what_was_measured(browser, tmp_path):
    """Lines of the identified masses are among the marks; those of the file are 1.3 away."""
    answer = identification()
    (recording,) = answer.recordings
    measured = recording.measurements.values
    from_file, identified = recording.predicted
    assert np.abs(identified - measured).max() < 0.01
    size = np.abs(measured).max()
    assert np.abs(1.3 * from_file - measured).max() < 0.01 < 0.1 * size
    show(browser, tmp_path, answer.to_html())
    settle(browser)
    figure = browser.execute_script("return data('figures')[0]")
    by_name = {}
    for trace in figure["data"]:
        by_name.setdefault(trace["name"], []).append(trace["y"])
    seen = {key: np.array(values, dtype=float) for key, values in by_name.items()}
    assert (
        seen["measured"].shape == seen["identified"].shape == seen["masses of the file"].shape
    )
    np.testing.assert_allclose(seen["identified"], seen["measured"], atol=0.02)
    np.testing.assert_allclose(1.3 * seen["masses of the file"], seen["measured"], atol=0.05)
    tables = [table.text for table in browser.find_elements("css selector", "section table")]
    assert any("Load" in text or "fx" in text for text in tables)


def test_a_plan_rests_at_both_ends(browser, tmp_path):
    show(browser, tmp_path, plan().to_html())
    settle(browser)
    for trace in browser.execute_script("return data('figures')[0].data"):
        assert abs(trace["y"][0]) < 1e-6 and abs(trace["y"][-1]) < 1e-6 < max(trace["y"])


def test_matter_rides_on_its_link_inside_its_region(browser, tmp_path):
    show(browser, tmp_path, weights().to_html())
    settle(browser)

    def centre():
        return np.nanmean(drawn(browser, "matter"), axis=0)

    start, matter = centre(), drawn(browser, "matter")
    assert len(matter) > 200
    border = drawn(browser, "regions")
    low, high = np.nanmin(border, axis=0), np.nanmax(border, axis=0)
    assert (matter > low - 1e-6).all() and (matter < high + 1e-6).all()
    slide(browser, 0, 30)
    assert np.linalg.norm(centre() - start) > 1e-3
    one(browser, "#shown input[value=given]").click()
    settle(browser)
    assert drawn(browser, "matter").size == 0 < drawn(browser, "regions").size


def test_rigid_links_are_drawn_through_their_joints(browser, tmp_path):
    """At the start where the file has the joints; later as far apart as at the start."""
    show(browser, tmp_path, bending().to_html())
    settle(browser)
    points = {joint.name: joint.point[:2] for joint in kinematics.load(MODEL).joints}
    crank, rocker = (
        np.array(line) for line in browser.execute_script("return linesAt(0).links")
    )
    for line, names in ((crank, {"u1", "q2"}), (rocker, {"q3", "q4"})):
        for name in names:
            assert np.abs(line - points[name]).max(axis=1).min() < 1e-6, name
    lengths = [np.linalg.norm(np.diff(line, axis=0)) for line in (crank, rocker)]
    labels = play_until(browser, "#play", "Number(byId('time').value) > 3")
    assert labels == ["Stop", "Play"]
    later = browser.execute_script("return linesAt(Number(time.value)).links")
    assert np.abs(np.array(later[0]) - crank).max() > 1e-4
    for line, length in zip(later, lengths, strict=True):
        assert np.linalg.norm(np.diff(line, axis=0)) == pytest.approx(length, abs=1e-5)
