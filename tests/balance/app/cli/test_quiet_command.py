"""The command ``balance quiet``: verdicts, files that are written, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from balance.app.cli.main import main
from tests.support.json_answers import json_answer
from tests.support.planned_arms import planar_arm

TO = ("--to", "u1=0.5,u2=-0.3", "--duration", "0.5")


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(planar_arm(2).to_urdf(), encoding="utf-8")
    return str(path)


@pytest.mark.slow
def test_the_table_is_what_verify_takes(capsys, tmp_path, arm):
    table, picture = tmp_path / "a.csv", tmp_path / "a.svg"
    code, plan = json_answer(
        capsys, "quiet", arm, *TO, "--table", str(table), "--plot", str(picture)
    )
    assert code == 0 and plan["verdict"] == "optimal" and plan["law"] == "planned"
    assert plan["motion"]["position"][-1] == pytest.approx([0.5, -0.3])
    assert picture.read_text("utf-8").startswith("<?xml")
    code, told = json_answer(capsys, "verify", arm, "--csv", str(table))
    assert code == 1
    assert told["shaking"]["force"] == pytest.approx(plan["after"]["force_peak"], rel=2e-3)


def test_the_text_shows_both_laws(capsys, arm):
    assert main(["quiet", arm, *TO, "--max-velocity", "u1=9", "--shaking", "both"]) == 0
    text = capsys.readouterr().out
    for words in ("verdict      locally optimal: ", "quintic      the plan shakes ", "planned"):
        assert words in text
    assert "N m count as 1 N" in text and "trapezoidal " in text


def test_an_infeasible_limit_is_one_line(capsys, tmp_path, arm):
    table = tmp_path / "a.csv"
    code = main(["quiet", arm, *TO, "--max-velocity", "u1=0.9", "--table", str(table)])
    assert code == 1 and not table.exists()
    lines = [line for line in capsys.readouterr().out.splitlines() if "infeasible" in line]
    assert len(lines) == 1 and "the velocity of u1 exceeds its limit 0.9" in lines[0]


def test_a_path_from_a_table_and_the_price_of_time(capsys, tmp_path, arm):
    table = tmp_path / "poses.csv"
    table.write_text("u2,u1\n0,0\n0.4,0.2\n0.3,0.6\n", encoding="utf-8")
    code, plan = json_answer(capsys, "quiet", arm, "--path", str(table), "--front", "3")
    assert code == 0 and plan["verdict"] == "optimal"
    assert plan["from"] == [0.0, 0.0] and plan["to"] == pytest.approx([0.6, 0.3])
    values = [point["value"] for point in plan["front"]]
    assert len(values) == 3 and np.all(np.diff(values) < 0.0)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "give the pose to reach"),
        (("--to", "u1=0.1", "--front", "3"), "--front: only with --straight or --path"),
        (
            ("--to", "u1=0.1", "--straight", "--natural-frequency", "9"),
            "--natural-frequency: not with --straight",
        ),
        (("--to", "u1=0.1", "--path", "a.csv"), "--path: leads from its first pose"),
        (("--to", "u1=0.1", "--weight-moment", "1"), "--weight-moment: only with"),
        (("--to", "u1=0.1", "--max-jerk", "=3"), "is not a limit"),
    ],
)
def test_words_that_do_not_fit(capsys, arm, words, told):
    assert main(["quiet", arm, *words]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [("quiet", "--to", "u1=0.2,u2=30mm"), ("paths", "--from", "u1=30mm")]
)
def test_a_length_is_no_angle(words, capsys):
    assert main([words[0], "five_bar", *words[1:]]) == 3
    assert "is revolute: its position is an angle" in capsys.readouterr().err
