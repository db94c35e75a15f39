"""The page of a design space: its data, without a browser."""

from __future__ import annotations

import json
import re
from functools import cache

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.app.answers.data import Report, report_data
from balance.app.answers.html.report import report_page
from balance.app.answers.html.scene import scene
from balance.app.cli.main import main
from balance.space.interpretation.explain import explain
from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
from kinematics.wording import size_text
from tests.support.hostile_names import HOSTILE, hostile
from tests.support.page_elements import Elements

CASES = [("four_bar_antiparallelogram", None), ("three_rsr", "u2=u3"), ("hprs", None)]


@cache
def case(model, motion=None):
    """Design space of a model of the gallery, and the elements of its page."""
    space = design_space(kinematics.load(model), motion)
    return space, Elements(
        report_page(Report(space, explain(space), change=distance_to_rank_drop(space)))
    )


@cache
def drawing(model):
    """Linkage of a model of the gallery, and what there is to draw."""
    linkage = kinematics.load(model)
    return linkage, scene(linkage)


def plain(space):
    """The report as a reader of JSON sees it."""
    change = distance_to_rank_drop(space)
    return json.loads(json.dumps(report_data(Report(space, explain(space), change=change))))


@pytest.mark.parametrize("model, motion", CASES)
def test_page_needs_nothing_else(model, motion):
    """Elements are closed; nothing but data is loaded, and a policy forbids the rest."""
    _, found = case(model, motion)
    loading = {"src", "href", "srcset", "action", "data", "poster", "formaction", "background"}
    urls = [value for _, name, value in found.attributes if name in loading]
    assert urls == ["data:,"]
    assert not re.search(r"url\(|@import", found.style)
    policy = next(v for _, n, v in found.attributes if n == "content" and "default-src" in v)
    assert policy.startswith("default-src 'none';") and "http" not in policy
    assert not re.search(r"https?://|\{\{", found.text + found.scripts[-1][1])


@pytest.mark.table(1)
@pytest.mark.parametrize("model, motion", CASES)
def test_page_holds_the_report(model, motion):
    space, found = case(model, motion)
    report = plain(space)
    assert found.data("report") == report
    for order in report["orders"]:
        row = "".join(str(order[key]) for key in ("order", "rank", "nullity"))
        assert row in re.sub(r"\s", "", found.text)
    for number in (space.kept, space.dropped, space.as_given.residual):
        assert size_text(number) in found.text
    words = [f["words"] for f in report["freedoms"]]
    words += [f["words"] for transfer in report["transfers"] for f in transfer["freedoms"]]
    assert words and all(line in found.text for line in words)
    for primitive in (p for f in report["freedoms"] for p in f["primitives"]):
        value = f"{primitive['value']:+.4g}".replace("-", "−")
        assert f"{value} kg" in found.text and f"on {primitive['body']}" in found.text
    for code, message, _ in space.warnings:
        assert code in found.text and message in found.text


@pytest.mark.parametrize("model, motion", CASES)
def test_singular_values_by_order(model, motion):
    space, found = case(model, motion)
    spectra = found.data("scene")["spectra"]
    assert [len(s["values"]) for s in spectra] == [order.rank for order in space.orders]
    assert np.allclose(spectra[-1]["values"], space.singular_values, rtol=1e-3, atol=0.0)
    for spectrum in spectra:
        assert spectrum["kept"] <= min(spectrum["values"]) * 1.001
        assert spectrum["dropped"] < 1e-3 * spectrum["kept"]
        assert spectrum["values"][0] == 1.0


def test_parts_are_drawn_through_their_joints():
    _, found = drawing("three_rsr")
    by_name = {name: part for part in found["parts"] for name in part["names"]}
    assert [len(by_name[name]["corners"]) for name in ("lower1", "upper3", "platform")] == [
        2,
        2,
        3,
    ]
    base = np.array(found["parts"][0]["corners"])
    assert np.allclose(np.linalg.norm(base, axis=1), 3.0) and len(base) == 3
    assert by_name["platform"]["names"] == ["platform"]


@pytest.mark.parametrize(
    "motion, labels",
    [
        (None, ["u1", "u2", "u3"]),
        ("u2=u3", ["u1", "u2 = u3"]),
        ("u1=-2*u3", ["u3 = −0.5 u1", "u2"]),
        (["u1=u2", "u2=u3"], ["u1 = u2 = u3"]),
    ],
)
def test_sliders_are_named_by_their_inputs(motion, labels):
    space = design_space(kinematics.load("three_rsr"), motion)
    columns = scene(space.linkage, space.motion)["columns"]
    assert [column["label"] for column in columns] == labels
    found = np.array([column["column"] for column in columns]).T
    assert np.array_equal(found, space.motion.basis if motion else np.eye(3))


def test_names_of_files_are_text(tmp_path):
    """No name opens an element, ends a script or is taken for a place in the template."""
    space = hostile(tmp_path)
    assert "coupler" + HOSTILE in space.bodies
    change = distance_to_rank_drop(space)
    found, usual = (
        Elements(report_page(Report(space, explain(space), change=change))),
        case(*CASES[0])[1],
    )
    assert all(found.tags[tag] == usual.tags[tag] for tag in ("script", "b", "img"))
    assert "four_bar" + HOSTILE in found.text and "coupler" + HOSTILE in found.text
    assert found.data("report") == plain(space)


def test_command_writes_the_page(tmp_path, capsys):
    path = tmp_path / "page.html"
    assert main(["report", "slider_crank", "--html", str(path)]) == 0
    found = Elements(path.read_text(encoding="utf-8"))
    assert found.data("report")["model"] == kinematics.load("slider_crank").name
    assert main(["report", "slider_crank", "--html", str(tmp_path / "none" / "x.html")]) == 3
    assert "cannot be written" in capsys.readouterr().err
