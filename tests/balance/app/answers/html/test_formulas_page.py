"""The page of formulas, read back: names of symbols, values of tables, MathML of conditions."""

from __future__ import annotations

import re
from fractions import Fraction
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest

import balance
from balance.app.cli.main import main
from kinematics import ScrewJoint, from_screws
from tests.support.formula_rows import parameters_in_frames
from tests.support.page_elements import Elements

SVG = "{http://www.w3.org/2000/svg}"


class Page:
    """Tables, drawing and formulas of a page."""

    def __init__(self, text):
        self.text, self.elements = text, Elements(text)
        self.drawing = ElementTree.fromstring(re.search(r"<svg.*?</svg>", text, re.S)[0])
        tables = re.findall(r"<table>.*?</table>", text, re.S)
        self.rows = [
            [
                [ElementTree.fromstring(f"<td>{cell}</td>") for cell in cells]
                for row in re.findall(r"<tr>(.*?)</tr>", table.split("</thead>")[1], re.S)
                for cells in [re.findall(r"<td[^>]*>(.*?)</td>", row, re.S)]
            ]
            for table in tables
        ]
        conditions, dimensions, parameters = self.rows
        self.conditions = [row[0].find("math") for row in conditions]
        self.sums = [number(row[1]) for row in conditions]
        self.dimensions = {row[1].find("code").text: number(row[4]) for row in dimensions}
        self.parameters = {row[1].find("code").text: number(row[4]) for row in parameters}
        self.symbols = [symbol(row[0].find("math")[0]) for row in [*dimensions, *parameters]]

    def titles(self):
        return [title.text for title in self.drawing.iter(f"{SVG}title")]


def number(cell):
    """The number of a cell, without its unit."""
    text = "".join(cell.itertext())
    if both := re.match(r"(\S+) ([+-]) (\S+) i ", text):
        return complex(float(both[1]), float(both[2] + both[3]))
    return float(text.split()[0])


def symbol(msub):
    """The name of a symbol that MathML shows: letter, axis, subscript."""
    assert msub.tag == "msub" and msub[0].tag == "mi"
    axis = "".join(each.text for each in msub[1] if each.tag == "mi")
    return f"{msub[0].text}{axis}_{msub[1].find('mtext').text}"


def value(element, values):
    """Evaluate an element of presentation MathML, a row from left to right."""
    if element.tag == "msub":
        return values[symbol(element)]
    if element.tag == "mn":
        return Fraction(element.text)
    if element.tag == "mi":
        assert element.text == "i"
        return 1j
    if element.tag == "mfrac":
        return value(element[0], values) / value(element[1], values)
    if element.tag == "msup":
        return value(element[0], values) ** int(element[1].text)
    if element.tag == "mover":
        assert element[1].text == "\u203e"
        return np.conj(value(element[0], values))
    assert element.tag in ("mrow", "math")
    total, product, sign = 0, None, 1
    for part in element:
        if part.tag == "mo" and part.text in ("+", "\u2212", "="):
            total += 0 if product is None else sign * product
            product, sign = None, -1 if part.text == "\u2212" else 1
        elif part.tag != "mo":
            factor = value(part, values)
            product = factor if product is None else product * factor
        else:
            assert part.text in ("(", ")", "\u2062")
    return total + (sign * product if product is not None else 0)


def violations(page, masses):
    """Left sides with masses (parameters, n) in the order of the table, over their terms."""
    names = list(page.parameters)
    rows = []
    for condition in page.conditions:
        values = dict(page.dimensions)
        for name in page.dimensions:
            if name.startswith("z_"):  # real formulas have its parts
                values["x" + name[1:]] = page.dimensions[name].real
                values["y" + name[1:]] = page.dimensions[name].imag
        row = [value(condition, values | dict.fromkeys(names, 0) | {name: 1}) for name in names]
        rows.append(np.array(row, complex))
    rows = np.array(rows)
    sizes = (abs(rows) @ abs(masses)).max(axis=1, keepdims=True)
    return abs(rows @ masses) / np.maximum(sizes, 1e-3 * abs(masses).max())


def offset_slider():
    """A slider-crank whose slider runs beside the pivot of the crank."""
    end = (1.0, 0.1, 0.0)
    joints = [
        ScrewJoint("u1", "base", "crank", axis=(0, 0, 1)),
        ScrewJoint("q2", "crank", "coupler", axis=(0, 0, 1), point=(0.3, 0.4, 0)),
        ScrewJoint("p", "base", "slider", axis=(1, 0, 0), point=end, kind="prismatic"),
    ]
    loop = ScrewJoint("q3", "coupler", "slider", axis=(0, 0, 1), point=end)
    return from_screws(joints, [loop])


@pytest.fixture(scope="module")
def pages():
    """Formulas and their pages, each made when it is asked for."""
    made = {}

    def page_of(model, kind):
        if (model, kind) not in made:
            linkage = offset_slider() if model == "offset slider" else model
            found = balance.formulas(linkage, kind)
            made[model, kind] = found, Page(found.to_html()), linkage
        return made[model, kind]

    return page_of


CASES = [
    ("four_bar_general", "force"),
    pytest.param("offset slider", "dynamic", marks=pytest.mark.slow),
    pytest.param("six_bar_watt", "force", marks=pytest.mark.slow),
    pytest.param("pantograph", "force", marks=pytest.mark.slow),
    pytest.param("four_bar_kite", "dynamic", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("model", "kind"), CASES)
def test_conditions_hold_with_the_values_that_are_shown(pages, model, kind):
    """Masses of the design space fulfil the MathML, evaluated with the table of dimensions."""
    found, page, linkage = pages(model, kind)
    space = balance.design_space(linkage, balance=kind)
    masses = parameters_in_frames(space)
    assert found.confirmed and len(page.conditions) == len(found.conditions) > 0
    assert violations(page, masses).max() < 1e-5  # six digits are shown
    in_use = [symbol(each) for c in page.conditions for each in c.iter("msub")]
    changed = next(name for name in page.dimensions if name in in_use)
    right = page.dimensions[changed]
    page.dimensions[changed] = 1.01 * right
    wrong = violations(page, masses).max()
    page.dimensions[changed] = right
    assert wrong > 1e-4


@pytest.mark.parametrize(("model", "kind"), CASES)
def test_every_symbol_is_drawn_or_explained(pages, model, kind):
    found, page, _ = pages(model, kind)
    shown = {symbol(each) for c in page.conditions for each in c.iter("msub")}
    explained = {*page.dimensions, *page.parameters}
    explained |= {f"{axis}{name[1:]}" for name in page.dimensions for axis in "xy"}
    assert shown <= explained
    assert page.symbols == [*page.dimensions, *page.parameters]
    joints = [joint.name for joint in found.parts.joints]
    assert sorted(page.titles()) == sorted([*page.dimensions, *joints])
    texts = ["".join(each.itertext()) for each in page.drawing.iter(f"{SVG}text")]
    for body in found.linkage.bodies:
        assert body.name in texts


@pytest.mark.parametrize(("model", "kind"), CASES)
def test_labels_are_inside_and_lines_measure_what_the_table_says(pages, model, kind):
    """The drawing has one scale: lengths of dimension lines are those of the table."""
    _, page, _ = pages(model, kind)
    width, height = map(float, page.drawing.get("viewBox").split()[2:])
    for text in page.drawing.iter(f"{SVG}text"):
        assert 10 < float(text.get("x")) < width - 10
        assert 10 < float(text.get("y")) < height - 5
    lines = []
    for path in page.drawing.iter(f"{SVG}path"):
        if path.get("stroke-width") == "1" and not path.get("stroke-opacity"):
            ends = re.match(r"M(\S+) (\S+)L(\S+) (\S+?)(?:M|$)", path.get("d")).groups()
            x0, y0, x1, y1 = map(float, ends)
            lines.append(np.hypot(x1 - x0, y1 - y0))
    names = [name for name in page.titles() if name in page.dimensions]
    scales = [line / abs(page.dimensions[n]) for line, n in zip(lines, names, strict=True)]
    assert max(scales) < 1.03 * min(scales)  # tenths of a pixel


def label_boxes(drawing):
    """Left, top, right and bottom of each label, pixels, by the widths of wide letters."""
    for text in drawing.iter(f"{SVG}text"):
        spans = list(text.iter(f"{SVG}tspan"))
        words = "".join(part for part in text.itertext())
        title = text.find(f"{SVG}title")
        words = words.removeprefix("" if title is None else title.text)
        width = 0.6 * 14 * len(words)
        if spans:
            width = sum(0.6 * float(x.get("font-size", 14)) * len(x.text) for x in spans)
        x, y = float(text.get("x")), float(text.get("y"))
        yield words, x - width / 2, y - 10, x + width / 2, y + (7 if spans else 3)


@pytest.mark.parametrize(
    "model",
    [
        "four_bar_general",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("four_rrr", "four_rrr_side_by_side", "eight_bar", "pantograph")
        ),
    ],
)
def test_no_two_labels_overlap(pages, model):
    boxes = list(label_boxes(pages(model, "force")[1].drawing))
    crossing = [
        (name, other)
        for (name, *a), (other, *b) in combinations(boxes, 2)
        if max(a[0], b[0]) < min(a[2], b[2]) and max(a[1], b[1]) < min(a[3], b[3])
    ]
    assert len(boxes) > 10 and crossing == []


@pytest.mark.slow
def test_masses_of_the_file_are_those_of_the_table():
    """Left sides of a balanced file are zero; its values fulfil the MathML, others do not."""
    for model, zero in (("four_bar_kite_balanced", True), ("four_bar_kite", False)):
        found = balance.formulas(model)
        page = Page(found.to_html())
        masses = np.array(list(page.parameters.values()), complex)[:, None]
        broken = violations(page, masses).max()
        assert (broken < 1e-5) == zero == (page.sums == [0.0] * len(page.sums))
        bodies = {body.name: body for body in found.linkage.bodies}
        for name, body in bodies.items():
            assert page.parameters[f"m_{name}"] == pytest.approx(body.inertia[0], rel=1e-5)


@pytest.mark.slow
def test_left_sides_are_those_of_the_values_shown(pages):
    _, page, _ = pages("four_bar_kite", "dynamic")
    values = page.dimensions | page.parameters
    for condition, shown in zip(page.conditions, page.sums, strict=True):
        assert value(condition, values) == pytest.approx(shown, rel=1e-4, abs=1e-6)


@pytest.mark.slow
def test_bounds_are_set_as_an_inequality():
    """Both sides of its MathML, for lengths on either side of the bound."""
    pytest.importorskip("sympy")
    text = balance.formulas("four_bar_kite", buildable=True).to_html()
    math = re.search(r"can be built where (<math>.*?</math>)\.", text)[1]
    row = list(
        ElementTree.fromstring(math.replace("<math>", "<mrow>").replace("/math", "/mrow"))
    )
    place = next(k for k, each in enumerate(row) if each.text == ">")
    sides = [list(row[:place]), list(row[place + 1 :])]
    for ground, holds in ((1.41, False), (1.42, True)):
        values = {"l_ground": ground, "l_crank": 1.0}
        left, right = (
            np.prod([float(value(each, values)) for each in side if each.tag != "mo"])
            for side in sides
        )
        assert (left > right) == holds


def test_the_page_needs_no_network_and_has_latex_to_copy(pages):
    found, page, _ = pages("four_bar_general", "force")
    assert found.latex() in page.elements.text and found.python() in page.elements.text
    assert page.elements.data("report") == found.to_dict()
    links = [v for _, name, v in page.elements.attributes if name in ("src", "href")]
    assert links == ["data:,"]
    assert "in 20 other geometries" in page.elements.text
    assert "2 complex conditions of force balance" in page.elements.text


def test_what_is_not_known_is_said(tmp_path):
    """Time that is over leaves a page with the drawing, and no formula."""
    path = tmp_path / "page.html"
    words = ["formulas", "four_bar_general", "--balance", "force", "--seconds", "1e-9"]
    assert main([*words, "--html", str(path)]) == 4
    text = path.read_text(encoding="utf-8")
    assert "None is known." in text and "4 more are not known" in text
    assert len(re.findall("<title>l_", text)) == 4


@pytest.mark.parametrize(
    ("words", "code", "problem"),
    [
        (["four_bar_general", "--html", "page"], 2, "ends neither in .html nor in .htm"),
        (["delta", "--html", "page.html"], 3, "single loops"),
        (["four_bar_general", "--html", "none/page.html"], 3, "none"),
    ],
)
def test_what_is_refused(tmp_path, monkeypatch, capsys, words, code, problem):
    monkeypatch.chdir(tmp_path)
    assert main(["formulas", *words, "--balance", "force"]) == code
    assert problem in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
