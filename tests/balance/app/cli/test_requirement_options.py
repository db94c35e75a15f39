"""``--require`` and ``--gravity`` of `balance report` and `balance design`."""

from __future__ import annotations

import json
from importlib.resources import files

import jsonschema
import numpy as np
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from balance.checks import check_certificate

TWO = "dynamic up to order 2; dynamic at u1=0.5"


def printed(capsys, words, code=0):
    """The JSON object that a command prints, which its schema describes."""
    assert main([*words, "--json"]) == code
    data = json.loads(capsys.readouterr().out)
    name = data["schema"].partition("/")[0].removeprefix("balance.")
    path = files("balance").joinpath("app", "schemas", f"{name}.schema.json")
    jsonschema.validate(data, json.loads(path.read_text(encoding="utf-8")))
    return data


def test_a_report_lists_the_requirements(capsys):
    words = [
        "report",
        "five_bar",
        "--require",
        "force; gravity",
        "--require",
        "dynamic at u1=0",
    ]
    data = printed(capsys, [*words, "--gravity=0,-1,0"])
    listed = [tuple(item.values()) for item in data["requirements"]]
    assert listed == [("dynamic at u1=0", 6, 2), ("force", 6, 0), ("gravity", 6, 0)]
    assert (data["rank"], data["orders"], data["kmax"]) == (8, [], None)
    assert data["gravity"] == [0, -1, 0]
    main(words)
    assert "dynamic at u1=0           6              2" in capsys.readouterr().out


def test_a_design_fulfils_the_requirements(tmp_path, capsys):
    """The file that is written has no momentum in the pose, and no force anywhere."""
    path, listed = str(tmp_path / "out.urdf"), "force; dynamic at u1=0.1"
    data = printed(capsys, ["design", "five_bar", "--require", listed, "--out", path])
    assert data["verdict"] == "feasible"
    assert [item["text"] for item in data["requirements"]] == ["dynamic at u1=0.1", "force"]
    linkage = kinematics.load(path)
    z = np.array([body.inertia[[0, 1, 2, 6]] for body in linkage.bodies]).ravel()
    for pose, rows in ({"u1": 0.1}, slice(0, 3)), ({"u1": 0.3, "u2": -0.2}, slice(1, 3)):
        X = balance.momentum.momentum_regressor(linkage, pose)[:, rows]
        assert np.abs(X @ z).max() < 1e-8 * np.abs(X * z).max()
    assert main(["report", path, "--require", listed]) == 0
    assert "as given      balanced" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("listed", "words"),
    [
        (TWO, "'dynamic at u1=0.5' and 'dynamic up to order 2' contradict each other"),
        ("moment; gravity", "'moment' alone has no design"),
        (
            "dynamic at u1=0;dynamic at u1=0.4;dynamic at u1=0.9;dynamic at u1=0.6",
            "no two of the requirements contradict each other, but all together do",
        ),
    ],
)
def test_a_contradiction_is_named(listed, words):
    space = balance.require("four_bar_general", listed)
    answer = balance.design(space, within=None)
    assert answer.verdict == "infeasible"
    assert words in answer.words
    assert check_certificate(space, answer.certificate, None, answer.multipliers).accepted


def test_counterweights_hold_a_linkage_against_gravity(capsys):
    words = ["counterweights", "four_bar_general", "--links", "crank,rocker"]
    held = [*words, "--require", "gravity"]
    data = printed(capsys, [*held, "--gravity", "0,-9.81,0"])
    force = printed(capsys, [*words, "--balance", "force"])
    # One direction in the plane is as much as both: the bars turn.
    assert data["added_mass"] == pytest.approx(force["added_mass"], rel=1e-6)


@pytest.mark.parametrize(
    "words",
    [
        "report five_bar --gravity 0,0,1",
        "report five_bar --require force --motion u1=u2",
        "report five_bar --require force --balance force",
        "report five_bar --require force --explain",
        "report five_bar --require force --max-order 2",
        "design five_bar --require force --max-order 0",
        "reduce five_bar --links left_upper --budget 1 --require force --motion u1=u2",
        "report five_bar --require force --gravity 0,0",
    ],
)
def test_options_that_contradict_each_other(words, capsys):
    assert main(words.split()) == 2
    assert capsys.readouterr().err.strip()


def test_reduce_leaves_the_least_of_requirements(tmp_path, capsys):
    """What is printed is what `least_violation` computes, and the file has the matter."""
    path = str(tmp_path / "out.urdf")
    words = ["reduce", "four_bar_general", "--links", "crank,rocker", "--budget", "3"]
    words += ["--require", "force; dynamic", "--weights", "2,1", "--out", path]
    data = printed(capsys, words)
    space = balance.require("four_bar_general", "force; dynamic")
    # The weights are in the order of the texts, those of the space in its own: dynamic, force.
    answer = balance.masses.least_violation(space, ["crank", "rocker"], 3.0, weights=(1, 2))
    assert data["total"] == pytest.approx(answer.total, rel=1e-6)
    assert [item["weight"] for item in data["requirements"]] == [1, 2]
    assert (data["dearest"], data["contradict"]) == ("dynamic", ["dynamic"])
    added = sum(body.inertia[0] for body in kinematics.load(path).bodies) - sum(
        body.inertia[0] for body in kinematics.load("four_bar_general").bodies
    )
    assert added == pytest.approx(data["mass"], rel=1e-6)


def test_reduce_and_counterweights_name_two_that_contradict(capsys):
    """Each alone is met by the budget, and both together need more."""
    one, two = "force x at u1=0", "force y at u1=0"
    words = ["reduce", "four_bar_general", "--links", "crank", "--budget"]
    needed = [
        printed(capsys, [*words, "50", "--require", text])["mass"]
        for text in (one, two, f"{one};{two}")
    ]
    budget = 0.5 * (max(needed[:2]) + needed[2])
    assert max(needed[:2]) < budget < needed[2]
    data = printed(capsys, [*words, str(budget), "--require", f"{one};{two}"])
    assert data["contradict"] == [one, two]
    assert f"'{one}' and '{two}' contradict each other" in data["words"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--require", "force", "--speed", "300rpm"], "does not go with --require"),
        (["--require", "force", "--pareto", "3"], "does not go with --require"),
        (["--require", "force", "--balance", "force"], "does not go with --require"),
        (["--require", "force", "--budget", "0"], "a --budget above 0"),
        (["--weights", "1"], "--weights needs --require"),
        (["--require", "force", "--weights", "0"], "a weight is above 0"),
        (["--require", "force", "--weights", "1,2"], "2 weights for 1 requirements"),
    ],
)
def test_what_reduce_refuses(words, told, capsys):
    budget = [] if "--budget" in words else ["--budget", "1"]
    given = ["reduce", "four_bar_general", "--links", "crank", *budget]
    assert main([*given, *words]) == 2
    assert told in capsys.readouterr().err.splitlines()[0]
