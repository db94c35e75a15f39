"""Rockers that follow functions of cranks: four-bars that are known, their files, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest

from balance import synthesize, verify
from balance.app.cli.main import main
from balance.studies.synthesis.four_bar_masses import four_bar_urdf
from balance.studies.synthesis.function_four_bars import FunctionPoint, function_four_bars
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases
from tests.support.planted_four_bars import move_file, place_tips, planted_function

POINTS = [(0.0, 0.0), (0.35, 0.4), (0.8, 1.0)]


def listed(crank, rocker):
    return [FunctionPoint(*pair) for pair in zip(crank, rocker, strict=True)]


def nearest(designs, A, B):
    """Distance of the tips of the nearest design from given ones."""
    apart = (abs(each.crank_tip - A) + abs(each.rocker_tip - B) for each in designs)
    return min(apart, default=np.inf)


def chebyshev(count, low, high):
    k = np.arange(1, count + 1)
    return 0.5 * (low + high) - 0.5 * (high - low) * np.cos((2 * k - 1) * np.pi / (2 * count))


def logarithm(x):
    """Angles of crank and rocker for y = log10 x, x from 1 to 2: both turn by 60°."""
    return np.radians(60.0) * (x - 1.0), np.radians(60.0) * np.log10(x) / np.log10(2.0)


@pytest.mark.parametrize("count", [3, 5])
def test_points_have_the_four_bar_that_made_them(count):
    """Three with the angles at which it starts, five without them: Freudenstein, 1955."""
    for seed in range(number_of_cases(8, 80)):
        alpha, psi, A, B = planted_function(count, seed)
        start = (alpha[0], psi[0]) if count == 3 else None
        # Only differences count.
        points = listed(alpha + 0.3, psi - 0.2)
        assert nearest(function_four_bars(points, start=start), A[0], B[0]) < 1e-8


def test_start_angles_opposite_to_both_links_have_the_same_four_bar():
    """A link that comes out with a negative length is at the opposite angle."""
    alpha, psi, A, B = planted_function(3, 4)
    start = (alpha[0] + np.pi, psi[0] - np.pi)
    assert nearest(function_four_bars(listed(alpha, psi), start=start), A[0], B[0]) < 1e-8


@pytest.mark.slow
def test_four_points_have_one_beside_the_four_bar_that_made_them():
    """Their curve of circle points is sampled on lines 1° apart."""
    for seed in range(number_of_cases(4, 20)):
        alpha, psi, A, B = planted_function(4, seed)
        assert nearest(function_four_bars(listed(alpha, psi)), A[0], B[0]) < 0.1


@pytest.mark.parametrize("count", [3, pytest.param(4, marks=pytest.mark.slow), 5])
def test_rockers_of_files_follow_the_function(count):
    """The joints of a file without masses, closed by another program."""
    for seed in range(number_of_cases(3, 20)):
        alpha, psi, *_ = planted_function(count, seed)
        designs = function_four_bars(listed(alpha, psi), base=0.7)
        assert designs
        for design in designs[:: len(designs) // 3 + 1]:
            assert design.numbers["base"] == pytest.approx(0.7)
            turned = alpha - alpha[0]
            tips, turns = move_file(four_bar_urdf(design), turned)
            assert np.abs(turns - (psi - psi[0])).max() < 1e-9
            assert np.abs(tips - [each.point for each in design.positions]).max() < 1e-9
            late = move_file(four_bar_urdf(design), 1.01 * turned)[1]
            assert np.abs(late - turns)[1:].max() > 1e-4


def test_a_logarithm_is_crossed_at_chebyshevs_points():
    """Between its five points the rocker errs to one side and to the other in turn."""
    x = chebyshev(5, 1.0, 2.0)
    crank, rocker = logarithm(x)
    design = function_four_bars(listed(crank, rocker))[0]
    at = np.linspace(1.0, 2.0, 401)
    way, wanted = logarithm(at)
    lengths = [design.numbers[name] for name in ("crank", "coupler", "rocker")]
    A, B = design.crank_tip, design.rocker_tip
    side = np.sign(((1.0 - A).conjugate() * (B - A)).imag)
    ends = place_tips(design.crank_angles[0] + way - crank[0], lengths, side)[1]
    error = np.unwrap(np.angle(ends - 1.0)) - np.angle(B - 1.0) - (wanted - rocker[0])
    error -= 2.0 * np.pi * np.round(error / (2.0 * np.pi))
    parts = np.split(error, np.searchsorted(at, x))
    signs = [np.sign(part.sum()) for part in parts]
    assert all(a == -b for a, b in zip(signs, signs[1:], strict=False))
    assert 0.01 < np.degrees(np.abs(error).max()) < 0.1
    assert lengths == pytest.approx([3.43288, 0.815258, 3.55926], rel=1e-5)


def test_a_whole_turn_more_is_another_function():
    """A drag link, whose rocker turns by more than π, is not taken for one that goes back."""
    way = np.linspace(0.0, 5.6, 1401)
    A, B = place_tips(way, (2.5, 2.0, 2.2), 1.0)
    psi = np.unwrap(np.angle(B - 1.0))
    at = np.array([0, 300, 650, 1000, 1400])
    assert abs(psi[-1] - psi[0]) > np.pi
    assert nearest(function_four_bars(listed(way[at], psi[at])), A[0], B[0]) < 1e-8
    back = psi[at] - np.array([0.0, 0.0, 0.0, 0.0, 2.0 * np.pi])
    assert nearest(function_four_bars(listed(way[at], back)), A[0], B[0]) > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "density"), [("geared-four-bar", 7850.0), ("six-bar", None)])
def test_files_with_masses_are_balanced(kind, density):
    """The mechanisms of an answer: the rocker follows, and nothing shakes."""
    answer = synthesize(kind=kind, function=POINTS, density=density)
    best = answer.mechanisms[0]
    assert answer.verdict == "feasible" and "whose rocker follows the function" in answer.words
    crank, rocker = np.array(POINTS).T
    assert np.abs(move_file(best.urdf, crank)[1] - rocker).max() < 1e-9
    assert best.tool_turns == pytest.approx(rocker)
    linkage = load(Document("function", best.urdf))
    assert linkage.mobility == 1
    assert verify(linkage, trajectories=1).balanced


def test_functions_that_no_tried_four_bar_follows():
    """A rocker that leaps back and forth: none among those tried, and no proof."""
    leaps = [(0.0, 0.0), (0.1, 2.5), (0.2, 0.1), (0.3, 2.4), (0.4, 0.0)]
    answer = synthesize(kind="geared-four-bar", function=leaps)
    assert answer.verdict == "undecided"
    assert "none of the four-bars that were tried follows the function" in answer.words


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"function": POINTS[:2]}, "2 points of a function: give 3 to 20"),
        ({"function": POINTS * 7}, "21 points of a function: give 3 to 20"),
        ({"function": [*POINTS[:2], (0.2, 1.0)]}, "of the crank: they rise or fall"),
        ({"function": [*POINTS, (6.4, 1.2)]}, "by less than a turn"),
        ({"function": [(0, 1), (1, 1), (2, 1)]}, "the rocker of a function turns"),
        ({"function": [(0, 0), (1, 1), (2, 6.5)]}, "by less than a turn"),
        ({"function": [(0, 0), (1, 1), (2, float("nan"))]}, "finite"),
        ({"kind": "four-bar"}, "for the kinds geared-four-bar and six-bar"),
        ({"positions": [(0, 0, 0), (1, 0, 1), (1, 1, 2)]}, "neither positions nor pivots"),
        ({"timed": True}, "neither positions nor pivots"),
        ({"moving": 0j}, "neither positions nor pivots"),
        ({"within": 0.1}, "leave out 'within'"),
        ({"base": -1.0}, "base -1 m: give a length"),
        ({"base": 1e-150}, "base 1e-150 m: give a length from 1e-06"),
        ({"function": [*POINTS, (1.2, 1.5)], "start": (0, 1)}, "start angles are for three"),
        ({"start": (0.0, float("inf"))}, "start angles are finite"),
    ],
)  # fmt: skip
def test_what_no_rocker_can_do_is_refused(options, said):
    with pytest.raises(UsageError, match=said):
        synthesize(**{"kind": "geared-four-bar", "function": POINTS, **options})


def test_start_angles_and_a_base_are_for_functions():
    with pytest.raises(UsageError, match="are for a function"):
        synthesize([(0, 0, 0), (1, 0, 1), (1, 1, 2)], kind="geared-four-bar", base=1.0)


@pytest.mark.slow
def test_command_and_page(capsys, tmp_path):
    """A table in degrees; the words name the rocker, and the file is balanced."""
    table, out = tmp_path / "function.csv", str(tmp_path / "out.urdf")
    table.write_text("crank [deg],rocker [deg]\n10,0\n30,25\n55,60\n", encoding="utf-8")
    words = ["synthesize", "--function", str(table), "--kind", "geared-four-bar"]
    page = tmp_path / "page.html"
    assert main([*words, "--html", str(page), "--out", out, "--base-length", "400mm"]) == 0
    text = capsys.readouterr().out
    assert "crank 30°, rocker 25°" in text and "base 0.4 m" in text
    assert '"motion"' in page.read_text("utf-8")
    assert "positions of the tip of the rocker" in page.read_text("utf-8")
    assert main(["verify", out, "--trajectories", "1"]) == 0
    capsys.readouterr()
    assert main([*words, "--json", "--start", "30,60"]) in (0, 4)
    assert json.loads(capsys.readouterr().out)["function"][1]["rocker"] == np.radians(25.0)


@pytest.mark.parametrize(
    ("rows", "more", "code", "said"),
    [
        ("angle,rocker\n0,0\n", [], 3, "the columns must be crank, rocker"),
        ("crank,rocker\n0,0\n1,x\n", [], 3, "sample 2"),
        ("crank,rocker\n0,0\n1,1\n", [], 2, "give 3 to 20"),
        (
            "crank,rocker\n0,0\n1,1\n2,1.5\n",
            ["--within", "2mm"],
            2,
            "a unit of angle",
        ),
        ("crank,rocker\n0,0\n1,1\n2,1.5\n", ["--start", "3"], 2, "two angles"),
        ("crank,rocker\n0,0\n1,1\n2,1.5\n", ["--positions", "0,0,0; 1,0,1"], 2, "not allowed"),
    ],
)
def test_what_the_command_refuses(rows, more, code, said, capsys, tmp_path):
    table = tmp_path / "function.csv"
    table.write_text(rows, encoding="utf-8")
    words = ["synthesize", "--function", str(table), "--kind", "geared-four-bar", *more]
    try:
        assert main(words) == code
    except SystemExit as stop:
        assert stop.code == code
    assert said in capsys.readouterr().err
