"""The command ``balance formulas``: notations, exit codes and JSON."""

from __future__ import annotations

import pytest

from balance.app.cli.main import main
from tests.support.json_answers import json_answer

FOUR_BAR = ["formulas", "four_bar_general", "--balance", "force"]


def test_text(capsys):
    assert main(FOUR_BAR) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "s_crank + (l_crank/l_rocker) s_rocker + l_crank m_coupler = 0" in lines
    assert any(line.split()[:3] == ["l_crank", "crank", "AB"] for line in lines)


@pytest.mark.parametrize(
    ("notation", "words"),
    [
        ("latex", r"\frac{l_{\mathrm{crank}}}{l_{\mathrm{rocker}}} \, s_{\mathrm{rocker}}"),
        ("python", "[0, 1, l_coupler/l_rocker, 0, 0, 0]"),
    ],
)
def test_notations(capsys, notation, words):
    assert main([*FOUR_BAR, "--notation", notation]) == 0
    assert words in capsys.readouterr().out


def test_json(capsys):
    code, answer = json_answer(capsys, "formulas", "four_bar_kite")
    assert (code, answer["rank"], answer["unknown"], answer["confirmed"]) == (0, 7, 0, True)
    assert answer["relations"] == ["AB = BD", "AC = CD"]
    equal = {each["name"]: each["equals"] for each in answer["dimensions"]}
    assert equal["l_coupler"] == "l_crank" and equal["l_rocker"] == "l_ground"
    assert [each["letter"] for each in answer["joints"]] == ["A", "B", "C", "D"]


@pytest.mark.parametrize(
    ("notation", "words"),
    [
        ("text", "can be built  l_ground^2 > 2 l_crank^2"),
        ("latex", r"\[ l_{\mathrm{ground}}^{2} > 2 \, l_{\mathrm{crank}}^{2} \]"),
        ("python", "def can_be_built(l_ground, l_crank):"),
        ("sympy", "l_ground**2 > 2*l_crank**2"),
    ],
)
def test_bounds_in_every_notation(capsys, notation, words):
    assert main(["formulas", "four_bar_kite", "--buildable", "--notation", notation]) == 0
    assert words in capsys.readouterr().out


def test_bounds_that_are_not_derived_are_undecided(capsys, caplog):
    words = ("four_bar_spherical", "--balance", "force", "--buildable")
    code, answer = json_answer(capsys, "formulas", *words)
    assert (code, answer["confirmed"], answer["bounds"]["verdict"]) == (4, True, "unknown")
    assert "bounds are not derived: they are of planar linkages" in caplog.text


def test_bounds_in_json(capsys):
    code, answer = json_answer(capsys, "formulas", "four_bar_kite", "--buildable")
    (interval,) = answer["bounds"]["intervals"]
    assert code == 0 and answer["bounds"]["ratio"] == ["l_ground", "l_crank"]
    assert interval["low"] == pytest.approx(2**0.5, abs=1e-12) and interval["high"] is None


def test_time_that_is_over_is_undecided(capsys):
    code, answer = json_answer(capsys, "formulas", "four_bar_general", "--seconds", "1e-9")
    assert (code, answer["unknown"], answer["confirmed"]) == (4, 8, False)


@pytest.mark.parametrize(
    ("words", "code", "problem"),
    [
        (["delta"], 3, "single loops"),
        (["four_bar_general", "--where", "AB=BD"], 3, "does not hold in the file"),
        (["four_bar_general", "--where", "AB"], 2, "write AB=CD"),
        (["four_bar_general", "--solve", "q"], 3, "no parameter 'q'"),
        (["four_bar_general", "--solve", ","], 2, "not a list of parameters"),
        (["four_bar_general", "--motion", "u1=0"], 3, "leaves no input to move"),
        (["five_bar", "--balance", "force", "--motion", "u1=u2"], 3, "depend on the pose"),
        (["four_bar_general", "--seconds", "0"], 2, "--seconds"),
    ],
)
def test_what_is_refused(capsys, words, code, problem):
    assert main(["formulas", *words]) == code
    assert problem in capsys.readouterr().err
