"""Pages of springs in a browser without a network: drawn springs, their lengths, the curves."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from balance.app.answers.html.springs import springs_page
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
from tests.support.spring_energies import lamp

pytestmark = needs_browser

BETWEEN = (
    "base@0,0,0.2 upper@0.4,0,0",
    "lower@0,0,0.7 upper@0.4,0,0 k=20:60",
    "base@0,0,0.2 lower@0,0,0.1 L0=0.04",
)


@pytest.fixture(scope="module")
def answer():
    """Springs of the lamp, one of them with a free length."""
    return balance.springs(lamp(), BETWEEN)


@pytest.fixture(scope="module")
def page(browser, answer, tmp_path_factory):
    """A browser that shows them."""
    show(browser, tmp_path_factory.mktemp("springs"), springs_page(answer))
    settle(browser)
    return browser


def turned(angle, point, about=(0.0, 0.0)):
    """A point (x, z) after a turn about the y axis."""
    x, z = np.subtract(point, about)
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * x + s * z, c * z - s * x]) + about


def expected_lengths(first, second):
    """Distances of the ends at inputs, by hand: hinges at the origin and at (0, 0.4)."""
    elbow = turned(first, (0.0, 0.4))
    tip = elbow + turned(first + second, (0.4, 0.0))
    ends = [
        (np.array([0.0, 0.2]), tip),
        (turned(first, (0.0, 0.7)), tip),
        (np.array([0.0, 0.2]), turned(first, (0.0, 0.1))),
    ]
    return [np.linalg.norm(a - b) for a, b in ends]


def put(page, *degrees):
    """Move the sliders."""
    for k, value in enumerate(degrees):
        page.execute_script(
            "arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input'))",
            one(page, f"#sliders-{k}"),
            value,
        )
    settle(page)


@pytest.mark.browser
@pytest.mark.parametrize("degrees", [(0, 0), (40, -25), (-70, 90)])
def test_springs_are_as_long_as_their_points_are_apart(page, answer, degrees):
    put(page, *degrees)
    lengths = expected_lengths(*np.radians(degrees))
    rows = page.find_elements("css selector", "#lengths tbody tr")
    cells = [[cell.text for cell in row.find_elements("css selector", "td")] for row in rows]
    needed = [k for k, spring in enumerate(answer.springs) if spring.stiffness > 0.0]
    assert len(cells) == len(needed)
    for k, (length, force) in zip(needed, cells, strict=True):
        spring = answer.springs[k]
        assert float(length.removesuffix(" m")) == pytest.approx(lengths[k], rel=1e-3)
        pull = spring.stiffness * (lengths[k] - spring.free_length)
        assert float(force.replace("−", "-").removesuffix(" N")) == pytest.approx(
            pull, rel=2e-3
        )
    drawn = [p for p in page.execute_script("return stage.drawn('springs')") if p]
    ends = [p for p in page.execute_script("return stage.drawn('spring ends')") if p]
    gaps = [np.linalg.norm(np.array(drawn) - end, axis=1).min() for end in np.array(ends)]
    assert len(ends) == 2 * len(needed) and max(gaps) < 1e-9
    assert complaints(page) == []


@pytest.mark.browser
def test_curves_are_the_torques_of_the_answer(page, answer):
    traces = page.execute_script("return torques.map(({data}) => data.map(({x, y}) => [x, y]))")
    for k, chart in enumerate(traces):
        for (x, y), torques in zip(chart, (answer.before, answer.after), strict=True):
            order = np.argsort(answer.inputs[:, k])
            assert x == pytest.approx(answer.inputs[order, k], rel=1e-5)
            size = np.abs(answer.before).max()
            assert y == pytest.approx(torques[order, k], abs=1e-5 * size)


@pytest.mark.browser
def test_the_lamp_moves(page):
    put(page, 0, 0)
    before = page.execute_script("return stage.drawn('springs')")
    play_until(page, "#sliders .play", "Math.abs(stage.q[0]) + Math.abs(stage.q[1]) > 0.1")
    assert page.execute_script("return stage.drawn('springs')") != before
    assert complaints(page) == []


@pytest.mark.browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_a_phone(browser, answer, tmp_path, scheme):
    with screen(browser, 390, scheme=scheme):
        show(browser, tmp_path, springs_page(answer))
        settle(browser)
        assert too_wide(browser) == 0 and complaints(browser) == []
