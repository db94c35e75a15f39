"""The page of a sweep in a browser that has no network."""

from __future__ import annotations

import pytest

from balance.app.answers.html.sweep import sweep_page
from balance.studies.runs.results_file import ResultsFile
from tests.fuzz.sweep_words import sweep_files
from tests.support.browser import complaints, needs_browser, one, screen, too_wide, wait_until

pytestmark = needs_browser

# Drag with the mouse from one share of the first axis to another.
DRAG = """
const box = parallel.root.getBoundingClientRect();
const at = (share) => ({pointerId: 1, clientX: box.left + parallel.x(0),
  clientY: box.top + parallel.bottom + share * (parallel.top - parallel.bottom)});
parallel.root.setPointerCapture = () => {};
const [from, to] = arguments;
for (const [kind, share] of [["down", from], ["move", to], ["up", to]]) {
  parallel.root.dispatchEvent(new PointerEvent(`pointer${kind}`, at(share)));
}
"""
DRAWN = """
const marks = byId("linkage").chart.traces.filter((trace) => trace.mode === "markers");
return marks.flatMap(({text, x, y}) => text.map((name, k) => [name, x[k], y[k]]));
"""


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    """A browser that shows four rows, of rocker lengths 0.8 to 1.1; the second one last."""
    folder = tmp_path_factory.mktemp("page")
    path = folder / "sweep.html"
    with ResultsFile.open(sweep_files(["{results}"], folder)["results"]) as file:
        path.write_text(sweep_page(file, "rank"), encoding="utf-8")
    browser.get(path.as_uri())
    return browser


def numbers(page):
    """The numbers of the rows in the table."""
    return [button.text for button in page.find_elements("css selector", "#rows button")]


def rocker(page):
    """The length of the rocker that is drawn."""
    place = {name: (x, y) for name, x, y in page.execute_script(DRAWN)}
    return sum((a - b) ** 2 for a, b in zip(place["q4"], place["q3"], strict=True)) ** 0.5


@pytest.mark.browser
def test_a_clicked_row_is_drawn(opened):
    assert numbers(opened) == ["2", "0", "1", "3"]
    assert rocker(opened) == pytest.approx(1.0, abs=1e-5)
    for button, length in zip(
        opened.find_elements("css selector", "#rows button"), (1.0, 0.8, 0.9, 1.1), strict=True
    ):
        button.click()
        assert one(opened, "#which").text == f"row {button.text}"
        assert rocker(opened) == pytest.approx(length, abs=1e-5)


@pytest.mark.browser
def test_a_brushed_range_keeps_its_rows(opened):
    """Shares 0.2 to 0.8 of the lengths 0.8 to 1.1 hold 0.9 and 1.0."""
    opened.execute_script(DRAG, 0.8, 0.2)
    assert numbers(opened) == ["2", "1"]
    assert "2 of 4 rows are kept" in one(opened, "#kept").text
    fields = opened.find_elements("css selector", "#ranges input")
    least = float(fields[0].get_property("value"))
    assert least == pytest.approx(0.86, abs=0.01)
    opened.execute_script(DRAG, 0.5, 0.5)
    assert numbers(opened) == ["2", "0", "1", "3"]
    assert fields[0].get_property("value") == ""


@pytest.mark.browser
def test_a_range_may_be_given_in_numbers(opened):
    opened.execute_script("document.querySelector('#all details').open = true")
    field = opened.find_elements("css selector", "#ranges input")[1]
    field.send_keys("0.95\t")
    assert numbers(opened) == ["0", "1"]
    field.clear()
    field.send_keys("\t")
    assert len(numbers(opened)) == 4
    assert complaints(opened) == []


@pytest.mark.browser
def test_the_page_fits_a_phone(opened):
    with screen(opened, 390):
        wait_until(opened, lambda page: too_wide(page) == 0)
        assert one(opened, "#linkage svg").is_displayed()
