"""The command ``balance new``: its file, its answer, and what it refuses."""

from __future__ import annotations

import pytest

from balance.app.cli.main import main
from kinematics import load
from tests.fuzz.good_words import SKETCH
from tests.support.command_runs import asked
from tests.support.json_answers import json_answer

WORDS = ("--points", SKETCH[0], "--links", SKETCH[1])


def test_the_file_is_written_and_told(tmp_path):
    path = tmp_path / "mine.urdf"
    matter = ["--section", "30mmx10mm", "--section", "crank=d20mm", "--mass", "rocker=1"]
    done = asked(["new", str(path), *WORDS, *matter, "--density", "aluminium"])
    assert done.code == 0 and done.err == ""
    linkage = load(path)
    assert (linkage.name, linkage.inputs, linkage.mobility) == ("mine", ("A",), 1)
    assert [body.name for body in linkage.bodies] == ["crank", "coupler", "rocker"]
    rows = {line.split()[0]: line.split() for line in done.out.splitlines() if line}
    assert rows["written"][1] == str(path) and rows["linkage"][1] == "mine,"
    assert rows["rocker"][-5:] == ["565.685", "30", "×", "10", "1000"]
    assert rows["crank"][-4:] == ["250", "ø", "20", "212.058"]
    assert rows["C"][1:3] == ["200", "400"] and "closes a loop" in " ".join(rows["C"])
    assert f"balance verify {path}" in done.out


def test_json_keeps_to_its_schema(capsys, tmp_path):
    path = str(tmp_path / "mine.urdf")
    code, answer = json_answer(capsys, "new", path, *WORDS, "--inputs", "D")
    assert code == 0 and answer["inputs"] == ["D"] and answer["base"] == ["A", "D"]
    assert answer["points"]["B"] == [0.0, 0.25] and answer["base_by_rule"] is True
    assert [link["mass"] for link in answer["links"]] == [None] * 3


def test_a_file_is_replaced_only_if_asked(tmp_path):
    path = tmp_path / "mine.urdf"
    path.write_text("mine")
    done = asked(["new", str(path), *WORDS])
    assert (done.code, done.out) == (2, "") and "exists: give another name" in done.err
    assert path.read_text() == "mine"
    assert main(["new", str(path), *WORDS, "--overwrite"]) == 0
    assert path.read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("words", "code", "problem"),
    [
        (["x.txt", *WORDS], 2, "the name of the file ends in .urdf"),
        (["x.urdf", *WORDS, "--base", "A,D"], 2, "write base=A,B in --links"),
        (["x.urdf", *WORDS, "--material", "steel"], 2, "did you mean '--density'"),
        (["x.urdf", *WORDS, "--inputs", "K"], 3, "choose from A"),
        (["x.urdf", "--links", "a=A,B"], 2, "--points"),
        (["x.urdf", "--points", "A=0,0; B=9,0; C=A:1,B:1", "--links", "a=A,B"], 3, "7000 mm"),
    ],
)
def test_refusals_have_one_line(words, code, problem, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = asked(["new", *words])
    assert (done.code, done.out) == (code, "") and problem in done.err
    assert len(done.err.splitlines()) == (2 if code == 2 else 1)
    assert not list(tmp_path.iterdir())


def test_lengths_of_hundreds_of_metres_get_a_notice(tmp_path):
    points = "A=0,0; B=0,250; C=200,400; D=600,0"
    done = asked(["new", str(tmp_path / "x.urdf"), "--points", points, "--links", SKETCH[1]])
    assert done.code == 0 and "large_machine" in done.err
