"""Pages of counterweights and of partial balance, and the sentence on top of answers."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import balance
from balance.app.answers.html.counterweights import counterweights_page
from balance.app.answers.html.filled_surface import filled_surface
from balance.app.answers.html.partial_balance import front_page, loads_of
from balance.app.cli.main import main
from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.region_text import read_region
from balance.support.change_text import change_text, mass_added_text
from tests.support.page_elements import Elements

MODEL = "four_bar_general"
LINKS = ["crank", "rocker"]


def test_changes_in_words():
    assert change_text(22.0, 1.7, "N") == "22 → 1.7 N (−92 %)"
    assert change_text(3.1, 7.9, "N m") == "3.1 → 7.9 N m (+155 %)"
    assert change_text(22.0, 1.7, "N", worded=True) == "22 → 1.7 N (92 % less)"
    assert change_text(3.1, 7.9, "N", worded=True) == "3.1 → 7.9 N (155 % more)"
    assert change_text(5.0, 5.01, "N") == "5 → 5.01 N (unchanged)"
    assert change_text(135.1, 124.6, "N", worded=True) == "135 → 125 N (8 % less)"
    assert change_text(2.0, 1240.0, "N") == "2 → 1240 N (620 times)"
    # A load of which some is left is not 100 % less.
    assert change_text(8.4, 0.0021, "N", worded=True) == "8.4 → 0.0021 N (99.97 % less)"
    assert change_text(8.4, 1e-6, "N", 1e-9).endswith("(−99.99 %)")
    # What round-off decides is nothing, and nothing has no percentage.
    assert change_text(22.0, 1e-13, "N", 1e-12) == "22 → 0 N (−100 %)"
    assert change_text(1e-13, 3.0, "N", 1e-12) == "0 → 3 N"
    assert change_text(1e-13, 2e-13, "N", 1e-12) == "0 N"
    assert [mass_added_text(m) for m in (2.34567, 0.0851234, 0.0)] == [
        "2.346 kg added",
        "85.12 g added",
        "nothing added",
    ]


def lines_of(chart):
    """The lines of the uppermost panel: before, and after."""
    return [line for line in chart["data"] if line["yaxis"] == "y"]


@pytest.fixture(scope="module")
def balanced():
    """Counterweights against the force, of point masses."""
    space = balance.design_space(MODEL, balance="force")
    return balance.counterweights(space, LINKS, density=None)


@pytest.mark.slow
def test_page_shows_both_loads_and_all_weights(balanced):
    elements = Elements(counterweights_page(balanced))
    report = elements.data("report")
    assert report["sentence"] in " ".join(elements.text.split())
    # Every motion before and after, on the same time: the force is gone.
    first = elements.data("comparison")["motions"][0]
    (was, now) = lines_of(first["time"])
    assert was["x"] == now["x"] and max(was["y"]) > 10.0 and max(now["y"]) < 1e-9
    assert first["harmonics"] is None
    reach = np.hypot(first["polar"]["data"][0]["x"], first["polar"]["data"][0]["y"])
    np.testing.assert_allclose(reach, was["y"], rtol=1e-4, atol=1e-4)
    # The table is in grams and millimetres; balls of steel have the masses of the lumps.
    (lump,) = balanced.weights[0].lumps
    assert f"{1e3 * lump.mass:.6g}" in elements.text
    drawn = elements.data("additions")[0]["lumps"][0]
    assert 7850.0 * 4.0 / 3.0 * np.pi * drawn["radius"] ** 3 == pytest.approx(lump.mass)


@pytest.mark.slow
def test_sentence_is_made_of_the_numbers_of_json(capsys, tmp_path):
    page = tmp_path / "page.html"
    words = ["counterweights", MODEL, "--links", "crank,rocker", "--balance", "force"]
    words += ["--speed", "300rpm", "--html", str(page)]
    assert main([*words, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    along = report["along"]
    assert along["speed"]["rpm"] == pytest.approx(300.0) and along["motions"] == 1
    percent = 100.0 * (along["after"]["moment"] / along["before"]["moment"] - 1.0)
    force = float(f"{along['before']['force']:.3g}")
    assert report["sentence"].startswith(
        f"Shaking force {force:g} → 0 N peak (−100 %), moment "
    )
    assert f"(+{percent:.0f} %), {report['added_mass']:.4g} kg added." in report["sentence"]
    elements = Elements(page.read_text(encoding="utf-8"))
    assert report["sentence"] in " ".join(elements.text.split())
    assert elements.data("report") == report
    # The peaks are those of `balance verify` at this speed.
    verified = balance.verify(MODEL, speed=10.0 * np.pi)
    assert along["before"]["force"] == pytest.approx(verified.force, rel=1e-12)
    harmonics = elements.data("comparison")["motions"][0]["harmonics"]["data"]
    assert len(harmonics) == 4 and max(harmonics[1]["y"]) < 1e-9


@pytest.mark.slow
def test_answers_begin_with_the_sentence(capsys):
    words = ["reduce", MODEL, "--links", "crank,rocker", "--budget", "0.5"]
    assert main([*words, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    (design,) = report["designs"]
    before, after = report["given"]["force"], design["found"]["force"]
    percent = 100.0 * (1.0 - after / before)
    peak = 100.0 * (1.0 - design["found"]["peak_force"] / report["given"]["peak_force"])
    assert design["sentence"].startswith(
        f"Shaking force {before:.3g} → {after:.3g} N rms (−{percent:.0f} %, peak −{peak:.0f} %)"
    )
    # `verify` has the same root mean squares by another program.
    assert main(["verify", MODEL, "--json"]) == 1
    verified = json.loads(capsys.readouterr().out)["rms"]
    for part in ("force", "moment"):
        assert verified[part] == pytest.approx(report["given"][part], rel=1e-9)
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[:2] == [design["sentence"], ""]
    # The lines below have the numbers of the sentence, digit by digit.
    sizes = re.findall(r"([\d.]+) → ([\d.]+) (N m|N) rms", design["sentence"])
    assert len(sizes) == 2
    for first, then, unit in sizes:
        assert f" {first} {unit} before, {then} {unit} after (rms)" in printed
    peaks = report["given"]["peak_force"], design["found"]["peak_force"]
    assert "; {:.3g} N before, {:.3g} N after (peak)".format(*peaks) in printed
    assert f"{design['mass']:.4g} kg added." in design["sentence"]


@pytest.mark.slow
def test_the_lines_below_a_sentence_have_its_digits(capsys):
    """Added masses of counterweights, and peaks of two verifications beside each other."""
    words = ["counterweights", MODEL, "--links", "crank,rocker", "--balance", "force"]
    assert main([*words, "--speed", "300rpm"]) == 0
    printed = capsys.readouterr().out
    (mass,) = re.findall(r"([\d.]+ kg) added\.$", printed, re.MULTILINE)
    for line in (f"feasible: {mass} added to", f"mass: {mass}; gap", f"{mass}, 1.5 times"):
        assert line in printed
    assert main(["verify", "four_bar_kite", "--against", MODEL, "--speed", "60rpm"]) == 1
    printed = capsys.readouterr().out
    loads = re.findall(r"([\d.]+) → ([\d.]+) (N m|N) peak", printed.splitlines()[0])
    assert [unit for *_, unit in loads] == ["N", "N m"]
    for before, after, unit in loads:
        for size in (before, after):
            assert f"peak {size} {unit} at" in printed


@pytest.mark.slow
def test_page_of_designs_has_the_loads_of_the_last(balanced):
    front = balance.pareto(MODEL, LINKS, 3, 0.5)
    elements = Elements(front_page(front))
    words = " ".join(elements.text.split())
    assert front.designs[-1].sentence in words
    assert "What each kilogram buys" in elements.text
    # Peaks over all motions, which Pinocchio computes, are those of the program.
    best = front.designs[-1]
    loads = loads_of(best)
    assert loads.before.force == pytest.approx(best.given.peak_force, rel=1e-9)
    assert loads.after.force == pytest.approx(best.shaking.peak_force, rel=1e-9)
    assert loads.after.drive_peaks == pytest.approx(best.shaking.torque, rel=1e-9)
    assert f"{loads.after.force:.3g} N" in elements.text
    # The sentence has root mean squares, so that the peaks stand beside it.
    peaks = re.search(
        r"added\. Peaks of the curves: shaking force ([\d.]+) → ([\d.]+) N", words
    )
    written = [float(size) for size in peaks.groups()]
    # Three digits.
    assert written == pytest.approx([loads.before.force, loads.after.force], rel=0.005)


REGIONS = {
    "crank": "cylinder(0,-0.1,0.03,0,0,1,0.12,0.04)",
    "rocker": "box(-0.05:0.2,-0.4:-0.1,0.01:0.05)",
}


@pytest.mark.slow
@pytest.mark.parametrize("regions", [None, REGIONS])
def test_matter_of_limited_density_is_drawn_as_its_volume(regions):
    """A closed surface in the region, around the volume and the centre of mass of the weight.

    By the divergence theorem; edges are cut by part of a cell, so that 7 % may be missing.
    """
    space = balance.design_space(MODEL, balance="force")
    answer = balance.counterweights(space, LINKS, density=7850.0, regions=regions)
    for weight in answer.weights:
        points, faces = filled_surface(weight)
        signed = np.linalg.det(points[faces]) / 6.0
        centre = (signed[:, None] * points[faces].sum(axis=1)).sum(axis=0) / 4.0 / signed.sum()
        assert 0.9 < signed.sum() / (weight.mass / weight.density) < 1.01
        assert np.linalg.norm(centre - weight.com) < 5e-3 * weight.region.size
        assert weight.region.contains(points, 1e-3).all()
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        assert sorted(map(tuple, edges)) == sorted(map(tuple, edges[:, ::-1]))


def test_a_web_is_drawn_as_a_solid_beside_its_disc():
    space = balance.design_space(MODEL, balance="force")
    answer = balance.counterweights(space, LINKS, density=7850.0, shape="disc=0.02")
    for weight in answer.weights:
        points, faces = filled_surface(weight)
        bar = faces[faces.min(axis=1) >= len(points) - 8]
        volume = np.linalg.det(points[bar]).sum() / 6.0
        assert volume == pytest.approx(weight.web.volume, rel=1e-9)
        whole = np.linalg.det(points[faces]).sum() / 6.0
        assert 0.9 < (whole - volume) / weight.region.volume < 1.01


def test_point_masses_have_no_surface():
    region = read_region("ball(0,0,0,1)")
    weight = Counterweight("crank", 1.0, np.zeros(3), np.zeros((3, 3)), (), region)
    assert filled_surface(weight) is None
