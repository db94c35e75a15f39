"""The command ``balance springs``: verdicts, pictures, and what is refused."""

from __future__ import annotations

import json
import re

import pytest

from balance.app.cli.main import main
from tests.support.json_answers import json_answer

GRAVITY = ("--gravity", "0,-9.81,0")
CRANK = ("slider_crank", "--between", "base@0,0.3,0 crank@0.1,0.1,0", *GRAVITY)


def test_the_answer_keeps_to_its_schema_and_has_a_picture(capsys, tmp_path):
    picture = tmp_path / "springs.svg"
    code, answer = json_answer(
        capsys,
        "springs",
        "slider_crank",
        "--between",
        "base,crank",
        *GRAVITY,
        "--plot",
        str(picture),
    )
    assert code == 0 and answer["verdict"] == "feasible" and answer["sets"] == [[1]]
    assert answer["share_left"] == 0.0 and answer["certainty"]["residual"] < 1e-9
    assert picture.read_text("utf-8").startswith("<?xml")


def test_a_catalogue_of_real_springs(capsys, tmp_path):
    """Free lengths have a column, and the page holds the answer."""
    page = tmp_path / "springs.html"
    words = ("springs", *CRANK, "--catalogue", "10:40:15@0.02:0.06:0.04", "--html", str(page))
    code, answer = json_answer(capsys, *words)
    (spring,) = answer["springs"]
    assert code == 1 and (spring["stiffness"], spring["free_length"]) == (40.0, 0.02)
    text = page.read_text("utf-8")
    report = re.search(
        r'<script type="application/json" id="report">(.*?)</script>', text, re.S
    )
    assert json.loads(report[1]) == answer
    assert main(["springs", *CRANK, "--catalogue", "10:40:15@0.02:0.06:0.04"]) == 1
    lines = capsys.readouterr().out.splitlines()
    head = next(line for line in lines if line.startswith("spring "))
    assert "free length (m)" in head and "Springs act as if" not in "\n".join(lines)


@pytest.mark.slow
def test_the_text_says_what_is_left(capsys):
    words = ("springs", *CRANK, "--range", "u1=-20deg:0.5")
    code, answer = json_answer(capsys, *words)
    assert code == 1 and answer["verdict"] == "infeasible" and 0 < answer["share_left"] < 1
    assert main([*words]) == 1
    text = capsys.readouterr().out
    assert "of the torque of gravity (rms)" in text and "not of" not in text
    assert "Springs act as if of no free length" in text


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        ((), 2, "give the links of a spring by --between"),
        (("--between", "base"), 2, "has no known form"),
        (("--between", "base,crank", "--catalogue", "0"), 2, "stiffnesses above 0"),
        (("--between", "base,crank", "--catalogue", "5:9"), 2, "is no steps"),
        (("--between", "base,crank", "--catalogue", "5@0.1"), 2, "one point at each end"),
        (("--between", "base,crank L0=0.1"), 2, "has no known form"),
        (("--between", "base,crank", "--range", "u1=3"), 2, "is not a range"),
        (("--between", "base@0,0,1 crank@1,0,0 k=-2"), 2, "a stiffness is not negative"),
        (("--between", "base,ghost"), 3, "there is no such link"),
        (("--between", "base@0,0,0 base@1,0,0"), 3, "both ends are on one rigid body"),
        (("--between", "base,crank", "--range", "u9=0:1"), 3, "u9 is not an input"),
        (("--between", "base,crank", "--gravity", "0,0,0"), 2, "not all 0"),
        (("--between", "base,crank", "--gravity", "0,0,-9.81"), 3, "gravity does no work"),
    ],
)
def test_what_cannot_be_is_told_in_a_line(capsys, words, code, told):
    assert main(["springs", "slider_crank", *words]) == code
    assert told in capsys.readouterr().err
