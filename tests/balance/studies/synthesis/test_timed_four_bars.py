"""Points at given angles of the crank: four-bars that are known, their cognates, and files."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from balance import synthesize, verify
from balance.app.answers.html.synthesis import synthesis_page
from balance.app.cli.main import main
from balance.studies.synthesis.four_bar_masses import four_bar_urdf
from balance.studies.synthesis.general_four_bars import merit
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.timed_four_bars import timed_four_bars
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document
from tests.support.covering import number_of_cases
from tests.support.planted_four_bars import move_file, planted_point

PIVOTS = ("crank_base", "rocker_base", "crank_tip", "rocker_tip")
PLACES = [(0.3, 0.1, 0.0), (0.2, 0.3, 0.5), (0.0, 0.4, 1.1), (-0.2, 0.35, 1.9)]
TIMED = "0.3,0.1,10; 0.2,0.3,40; 0,0.4,75"


def timed(points, angles):
    return [Position(z.real, z.imag, a) for z, a in zip(points, angles, strict=True)]


def nearest(designs, pivots):
    """Distance of the pivots of the nearest design from given ones."""
    apart = (
        sum(abs(each.pivots()[name] - z) for name, z in zip(PIVOTS, pivots, strict=True))
        for each in designs
    )
    return min(apart, default=np.inf)


def test_five_points_have_the_four_bar_that_made_them_and_its_cognate():
    """S. Roberts, 1875: the cognate on the third pivot, whose crank turns with the first.

    With the bases at 0 and 1 that pivot is ``λ = (P - A)/(B - A)``; the crank is (1 - λ) A, and
    the rocker is parallel to B P.
    """
    for seed in range(number_of_cases(6, 60)):
        alpha, A, B, points, arm = planted_point(5, seed)
        designs = timed_four_bars(timed(points, alpha))
        assert nearest(designs, (0.0, 1.0, A[0], B[0])) < 1e-9
        rocker_tip = 1.0 + points[0] - B[0]
        assert nearest(designs, (arm, 1.0, arm + (1.0 - arm) * A[0], rocker_tip)) < 1e-9
        for design in designs:
            there = design.tool_points(design.crank_angles[0] + alpha - alpha[0])
            assert np.abs(there - points).max() < 1e-9


def test_a_planted_crank_that_turns_otherwise_is_not_found():
    """The same places at another angle of the crank have not the same four-bar."""
    alpha, A, B, points, _ = planted_point(5, 3)
    moved = alpha + np.array([0.0, 0.0, 1e-3, 0.0, 0.0])
    assert nearest(timed_four_bars(timed(points, moved)), (0.0, 1.0, A[0], B[0])) > 1e-5


@pytest.mark.parametrize(
    "count", [*(pytest.param(n, marks=pytest.mark.slow) for n in (3, 4)), 5]
)
def test_files_lead_the_point_in_time(count):
    """The joints of a file without masses, its crank turned as asked, either way."""
    for seed in range(number_of_cases(1, 10)):
        alpha, _, _, points, _ = planted_point(count, seed)
        designs = timed_four_bars(timed(points, alpha))
        for design in designs[:: len(designs) // 3 + 1]:
            turned = alpha - alpha[0]
            there = move_file(four_bar_urdf(design), turned)[0]
            assert np.abs(there - points).max() < 1e-9
            late = move_file(four_bar_urdf(design), 1.01 * turned)[0]
            assert np.abs(late - points)[1:].max() > 1e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "count", "sign"),
    [("geared-four-bar", 3, -1.0), ("geared-four-bar", 4, 1.0), ("six-bar", 3, 1.0)],
)
def test_files_with_masses_are_balanced(kind, count, sign):
    """The mechanisms of an answer: the point is there in time, and nothing shakes."""
    places = [(x, sign * y, sign * angle) for x, y, angle in PLACES[:count]]
    synthesis = synthesize(places, kind=kind, timed=True)
    best = synthesis.mechanisms[0]
    assert synthesis.verdict == "feasible" and best.good
    points = move_file(best.urdf, [angle for *_, angle in places])[0]
    assert np.abs(points - [complex(x, y) for x, y, _ in places]).max() < 1e-9
    assert best.link_turns == pytest.approx([angle for *_, angle in places], abs=1e-12)
    linkage = load(Document("timed", best.urdf))
    assert linkage.mobility == 1
    assert verify(linkage, trajectories=1).balanced


@pytest.mark.slow
def test_files_of_five_points_that_a_four_bar_made():
    alpha, _, _, points, _ = planted_point(5, 1)
    places = [(z.real, z.imag, a) for z, a in zip(points, alpha, strict=True)]
    synthesis = synthesize(places, kind="geared-four-bar", timed=True)
    for each in synthesis.mechanisms:
        there = move_file(each.urdf, alpha - alpha[0])[0]
        assert np.abs(there - points).max() < 1e-9
        assert verify(load(Document("timed", each.urdf)), trajectories=1).balanced


def test_even_four_bars_come_first():
    """Short couplers turn fast and take much matter: the best has none."""
    designs = timed_four_bars([Position(*place) for place in PLACES[:3]])

    def unevenness(each):
        G, H, W, Z = each.pivots().values()
        links = abs(W - G), abs(Z - W), abs(Z - H), abs(H - G)
        return max(links) / min(links)

    first = designs[0]
    assert unevenness(first) < 4.0 and first.transmission > np.radians(35.0)
    ample = [each for each in designs if each.transmission > np.radians(35.0)]
    even = [each for each in ample if unevenness(each) < 4.0]
    assert first.spread == pytest.approx(min(each.spread for each in even))


def test_no_transmission_angle_makes_up_for_a_short_link():
    """An even four-bar of ample transmission comes first, however wide it is."""
    transmission, spread = np.radians([90.0, 36.0, 34.0]), np.array([np.inf, 19.9, 1.0])
    assert np.argsort(merit(transmission, spread)).tolist() == [1, 0, 2]


def test_whole_turns_of_the_tool_count():
    """A drag link, whose base is shortest: its coupler goes round with the crank."""
    way = np.linspace(0.0, 5.6, 1401)
    A = 2.5 * np.exp(1j * way)
    gap = np.abs(1.0 - A)
    along = (4.0 - 2.2**2 + gap**2) / (2.0 * gap)
    B = A + (along + 1j * np.sqrt(4.0 - along**2)) * (1.0 - A) / gap
    tool = np.unwrap(np.angle(B - A))
    at = np.array([0, 300, 650, 1000, 1400])
    points = (A + (0.4 + 0.3j) * (B - A))[at]
    designs = timed_four_bars(timed(points, way[at]))
    pivots = (0.0, 1.0, A[0], B[0])
    assert nearest(designs, pivots) < 1e-9
    design = min(designs, key=lambda each: nearest([each], pivots))
    turns = [each.angle for each in design.positions]
    assert turns == pytest.approx(tool[at] - tool[0], abs=1e-9) and abs(turns[-1]) > np.pi


def test_places_that_no_tried_four_bar_reaches():
    """Turns of the tool are tried in steps: none among them is no proof."""
    resting = [(0.1, 0.2, 0.0), (0.1, 0.2, 0.3), (0.1, 0.2, 0.9)]
    answer = synthesize(resting, kind="geared-four-bar", timed=True)
    assert answer.verdict == "undecided" and "four-bars that were tried" in answer.words
    more = [(0.1, 0.2, 0.1 * k) for k in range(6)]
    assert synthesize(more, kind="geared-four-bar", timed=True).verdict == "undecided"
    five = [(0.0, 0.0), (0.3, -0.4), (0.1, 0.2), (0.5, 0.5), (-0.4, 0.0)]
    places = [
        (x, y, angle) for (x, y), angle in zip(five, (0.0, 0.35, 0.7, 1.05, 1.6), strict=True)
    ]
    assert synthesize(places, kind="geared-four-bar", timed=True).verdict == "undecided"


@pytest.mark.parametrize(
    ("places", "options", "said"),
    [
        (PLACES[:2], {}, "2 timed positions: give 3 to 20"),
        (PLACES, {"within": 0.01}, "leave out 'within'"),
        (PLACES[:3], {"kind": "four-bar"}, "for the kinds geared-four-bar and six-bar"),
        (PLACES[:3], {"fixed": 0j}, "choose none"),
        ([*PLACES[:3], (0.0, 0.1, 0.9)], {}, "rise or fall"),
        ([*PLACES[:3], (0.0, 0.1, 6.3)], {}, "less than a turn"),
        ([(0, 0, 0), (1, 0, 0), (1, 1, 1)], {}, "rise or fall"),
    ],
)
def test_what_no_crank_can_do_is_refused(places, options, said):
    with pytest.raises(UsageError, match=said):
        synthesize(places, timed=True, **{"kind": "geared-four-bar", **options})


@pytest.mark.slow
def test_command_and_page(capsys, tmp_path):
    """The words name the crank, the page moves the mechanism, and its file is balanced."""
    words = ["synthesize", "--positions", TIMED, "--kind", "geared-four-bar", "--timed"]
    page, out = tmp_path / "page.html", str(tmp_path / "out.urdf")
    assert main([*words, "--html", str(page), "--out", out]) == 0
    text = capsys.readouterr().out
    assert "(0.2, 0.3) with the crank at 40°" in text
    assert re.search(r"turns \(deg\) +30, 65\n", text)
    assert '"motion"' in page.read_text("utf-8")
    assert main(["verify", out, "--trajectories", "1"]) == 0
    capsys.readouterr()
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["timed"] is True
    answer = synthesize(PLACES[:3], kind="geared-four-bar", timed=True)
    assert "positions of the tool" in synthesis_page(answer)
