"""The table of modes: ranks and verdicts on each, as at a file written at a pose on it."""

from __future__ import annotations

import json
from importlib.resources import files
from types import SimpleNamespace

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import balance
import kinematics
from balance.app.answers.text.modes import modes_body
from balance.app.answers.text.render import body_text
from balance.app.cli.main import main
from balance.masses.mode_answers import ModeAnswers
from tests.support.meeting_linkages import FLAT, slider_crank

# Ranks by order and whether masses that balance can be built, by number. Two links that turn as
# one about a fixed pin have three conditions: their common centre of mass, and their inertia
# about it.
TURNING = ([3], "infeasible")
PARALLELOGRAM = ([3, 4, 5], "infeasible")
KNOWN = {
    "parallelogram": [PARALLELOGRAM, ([3, 6, 7], "feasible")],
    "kite": [TURNING, ([3, 6, 7], "infeasible")],
    "rhombus": [TURNING, PARALLELOGRAM, TURNING],
}


def made(name, folder):
    return str(FLAT[name].write(folder, "flat"))


@pytest.mark.table(1)
@pytest.mark.parametrize("name", KNOWN)
def test_every_mode_has_its_ranks_and_verdict(name, tmp_path):
    answers = balance.motion_modes(made(name, tmp_path))
    assert answers.sure
    for answer, (ranks, verdict) in zip(answers.modes, KNOWN[name], strict=True):
        assert answer.space.level in ("proved", "verified")
        assert [order.rank for order in answer.space.orders] == ranks
        assert answer.space.nullity == 12 - ranks[-1] and answer.verdict == verdict


def test_a_slider_crank_of_equal_bars_has_six_dimensions_where_it_slides(tmp_path):
    turning, sliding = balance.motion_modes(slider_crank(tmp_path)).modes
    assert [turning.space.rank, sliding.space.rank] == [3, 6]
    assert (turning.verdict, sliding.verdict) == ("infeasible", "feasible")


def test_the_sentence_names_modes_of_one_verdict_together():
    def sentence(*verdicts):
        modes = [
            SimpleNamespace(mode=SimpleNamespace(number=number), verdict=verdict)
            for number, verdict in enumerate(verdicts, 1)
        ]
        return ModeAnswers("", "dynamic", modes).sentence

    few = sentence("infeasible", "feasible", "infeasible", "undecided")
    assert few == "Can it balance? No on modes 1, 3; yes on mode 2; undecided on mode 4."
    many = sentence("feasible", *["infeasible"] * 31)
    assert many == "Can it balance? Yes on mode 1; no on 31 modes."


def run(capsys, *words):
    code = main([*map(str, words)])
    return code, capsys.readouterr().out


@pytest.mark.slow
def test_the_report_lists_the_modes(tmp_path, capsys):
    path = made("rhombus", tmp_path)
    code, out = run(capsys, "report", path, "--json")
    data = json.loads(out)
    text = files("balance").joinpath("app", "schemas", "modes.schema.json").read_text("utf-8")
    Draft202012Validator(json.loads(text)).validate(data)
    assert code == 0 and [mode["rank"] for mode in data["modes"]] == [3, 5, 3]
    assert [mode["here"] for mode in data["modes"]] == [True, True, False]
    code, out = run(capsys, "report", path)
    assert (
        code == 0 and out.strip() == body_text(modes_body(balance.motion_modes(path))).strip()
    )
    assert "2 modes of motion meet at this pose" in out and "mode 3: another" in out
    rows = [line.split() for line in out.splitlines() if line[:1].isdigit()]
    assert [row[0] for row in rows] == ["1", "2", "3"]
    code, out = run(capsys, "report", path, "--balance", "force", "--json")
    assert [mode["rank"] for mode in json.loads(out)["modes"]] == [2, 2, 2]


@pytest.mark.table(1)
@pytest.mark.parametrize("number", [1, 2])
def test_the_file_written_on_a_mode_has_its_answer(number, tmp_path, capsys):
    path, written = made("kite", tmp_path), tmp_path / "written.urdf"
    words = ("report", path, "--mode", number, "--json", "--write-closed", written)
    code, out = run(capsys, *words)
    chosen = json.loads(out)
    assert code == 0 and set(chosen["at"]) == set(chosen["inputs"])
    code, out = run(capsys, "report", written, "--json")
    again = json.loads(out)
    assert code == 0 and again["at"] is None
    for key in ("orders", "nullity", "serial", "parallel", "inputs", "idle"):
        assert again[key] == chosen[key]


@pytest.mark.slow
def test_a_design_on_a_mode_is_verified_on_it(tmp_path, capsys, caplog):
    """The antiparallelogram balances; the parallelogram through the same pose does not."""
    path, out = made("parallelogram", tmp_path), tmp_path / "out.urdf"
    assert main(["design", path, "--mode", "1"]) == 1
    assert main(["design", path, "--mode", "2", "--out", str(out)]) == 0
    assert f"balance verify {out} --mode 2" in caplog.text
    assert main(["verify", str(out), "--mode", "2", "--trajectories", "1"]) == 0
    assert main(["verify", str(out), "--mode", "1", "--trajectories", "1"]) == 1


@pytest.mark.table(1)
@pytest.mark.parametrize(
    "words",
    [
        "report {} --html {}.html",
        "report {} --write-closed {}.urdf",
        "report {} --explain",
        "report {} --exact",
        "design {}",
        "verify {}",
    ],
)
def test_what_needs_one_mode_lists_them(words, tmp_path, capsys):
    path = made("parallelogram", tmp_path)
    assert main(words.replace("{}.", f"{path}.").replace("{}", path).split()) == 3
    said = capsys.readouterr()
    assert not said.out
    for part in (
        "2 modes of motion meet there",
        "mode 1: mobility 1, at a=",
        "mode 2:",
        "such as --mode 1",
    ):
        assert part in said.err


@pytest.mark.parametrize("number, code", [("3", 3), ("0", 2), ("x", 2)])
def test_a_mode_that_does_not_exist_is_refused(number, code, tmp_path, capsys):
    assert main(["report", made("parallelogram", tmp_path), "--mode", number]) == code
    said = capsys.readouterr()
    assert not said.out and ("from 1 to 2" in said.err or "a mode" in said.err)


def test_a_certainty_that_a_mode_misses_is_told(tmp_path, capsys, caplog):
    path = made("rhombus", tmp_path)
    assert main(["report", path, "--certainty", "proved"]) == 4
    assert "mode 2: the answer is verified, not proved" in caplog.text


def test_a_regular_pose_has_one_mode():
    answers = balance.motion_modes("four_bar_kite")
    (only,) = answers.modes
    assert only.mode.here and only.space.nullity == 5
    assert repr(answers).splitlines()[0] == "ModeAnswers: 1 mode of four_bar_kite"


@pytest.mark.slow
def test_masses_of_a_mode_leave_it_without_momentum(tmp_path):
    """At a finite pose on the mode the momentum of its space vanishes, of the other not."""
    path = made("parallelogram", tmp_path)
    spaces = [answer.space for answer in balance.motion_modes(path).modes]
    for number, other in ((0, 1), (1, 0)):
        linkage = kinematics.load(path, mode=number + 1)
        X = balance.momentum.momentum_regressor(linkage, [0.2]).reshape(-1, 12)
        z = spaces[number].basis
        assert np.abs(X @ z).max() < 1e-12
        if spaces[other].nullity > spaces[number].nullity:
            assert np.abs(X @ spaces[other].basis).max() > 1e-3


@pytest.mark.slow
def test_a_study_follows_a_mode(tmp_path):
    """Parallelogram and antiparallelogram of one file; with another coupler it is general."""
    path = made("parallelogram", tmp_path)
    for number, rank in ((1, 5), (2, 7)):
        tables = {
            "model": {"file": path, "mode": number},
            "parameters": {"b.origin.x": [0.5, 0.6]},
            "compute": {"rank": {}},
        }
        assert balance.studies.Study.from_tables(tables).run()["rank"].tolist() == [rank, 8]


@pytest.mark.slow
def test_modes_that_may_be_missing_are_a_doubt(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("kinematics.closure.mobility.reachable_modes.MAX_MODES", 2)
    path = made("rhombus", tmp_path)
    code, out = run(capsys, "report", path)
    assert code == 4 and "there may be more modes: no more than 2 are listed" in out
    code, out = run(capsys, "report", path, "--json")
    assert code == 4 and json.loads(out)["doubt"] == "no more than 2 are listed"


def test_only_inputs_move_a_linkage_on_a_mode(tmp_path, capsys):
    path = made("parallelogram", tmp_path)
    assert main(["report", path, "--mode", "2", "--at", "a=0.3,b=-0.3"]) == 3
    assert "positions of inputs set the pose; choose from a" in capsys.readouterr().err


def test_a_mode_of_a_regular_linkage_is_refused(capsys):
    assert main(["report", "four_bar_kite", "--mode", "2"]) == 3
    said = capsys.readouterr()
    assert not said.out
    assert "one mode of motion leaves its pose; leave out the number of a mode" in said.err


def test_warnings_name_the_mode_that_they_are_about(tmp_path, capsys, caplog):
    """A link without mass is one on all modes; an input that rests on one mode is of that."""
    path = FLAT["kite"].write(tmp_path, "flat")
    text = path.read_text().replace('name="a" type', 'name="a" independent="true" type')
    bare = '<link name="pin"/><joint name="tip" type="continuous"><parent link="rocker"/>'
    path.write_text(text.replace("</robot>", f'{bare}<child link="pin"/></joint></robot>'))
    main(["report", str(path)])
    said = [record.getMessage() for record in caplog.records]
    assert sum("massless: no mass, so no parameters: pin" in line for line in said) == 1
    (told,) = [line for line in said if "inputs_of_mode" in line]
    assert told.startswith("inputs_of_mode: mode 1: a")
