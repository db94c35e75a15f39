"""What an answer that helps little leads to: the command, option or row that is next."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import balance
import kinematics
from balance.app.answers.html.render import rows_table
from balance.app.answers.text.design import unusual_matter
from balance.app.cli.next_command import reduce_command, relaxed_command
from balance.masses.counterweights.counterweights_result import Relaxation
from balance.masses.counterweights.regions import ball_region
from balance.masses.designs.density import Solid
from balance.support.change_text import grows
from balance.support.linkage_names import linkage_title
from tests.support.command_runs import asked

MODEL = "four_bar_general"


def row_of(text, label):
    """The value of a fact among printed lines."""
    return re.search(rf"^{label} +(.*)$", text, re.MULTILINE).group(1)


@pytest.mark.parametrize(
    ("words", "kept"),
    [
        (["--links", "crank"], "--links crank"),
        (["--links", "crank", "--minimise", "inertia", "--json"], "--links crank --json"),
        (["--links=crank", "--price-of-mass=2", "--minim", "rotor"], "--links=crank"),
        (["--region", "crank=ball(0,0,0,0.1)"], "--region 'crank=ball(0,0,0,0.1)'"),
        (["--shape", "disc=20mm", "--max-order", "1"], "--shape disc=20mm"),
        (["--max-order", "2", "--spatial", "--points"], "--points"),
    ],
)
def test_the_words_of_a_request_lead_on(words, kept):
    arguments = SimpleNamespace(words=["m.urdf", *words], require=[])
    command = f"balance reduce m.urdf {kept} --budget 2.3"
    assert reduce_command(arguments, 2.345) == command


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("report", "Can it balance while u2=u1? Not with these masses"),
        ("verify --trajectories 1 --against five_bar", "(five_bar.urdf) while u2=u1."),
        ("verify --trajectories 1", "not balanced while u2=u1; the moment does not count"),
        ("design", "feasible while u2=u1: "),
        (
            "counterweights --links all",
            "No shaking force (the moment does not count) while u2=u1",
        ),
        ("counterweights --links all --speed 60rpm", " %) while u2=u1, "),
        ("counterweights --links left_lower", "balances the linkage while u2=u1."),
        ("reduce --links left_lower --budget 1", " while u2=u1, 1 kg added."),
        ("remedies --only force_masses", "While u2=u1: none of these remedies balances"),
    ],
)
def test_answers_of_a_motion_name_it(words, said):
    verb, *options = words.split()
    words = [verb, "five_bar", "--balance", "force", "--motion", "u2=u1", *options]
    out = " ".join(asked(words).out.split())
    assert said in out


def test_requirements_leave_motions_out():
    arguments = SimpleNamespace(words=["m.urdf", "--points", "--csv", "a"], require=["force"])
    assert reduce_command(arguments, 0.0, ["a", "b"]) == (
        "balance reduce m.urdf --links a,b --budget 1"
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        f"counterweights {MODEL} --links crank --minimise inertia --points",
        f"counterweights {MODEL} --links crank --balance force --shape disc=20mm",
        f"counterweights {MODEL} --links crank --require 'force; gravity' --points",
        f"design {MODEL} --density none",
        "counterweights five_bar --links left_lower --speed u1=300rpm --motion u2=u1 --points",
    ],
)
def test_the_command_that_is_named_runs(words):
    infeasible = asked(shlex.split(words))
    assert infeasible.code == 1
    command = shlex.split(row_of(infeasible.out, "reduce"))
    assert command[:3] == ["balance", "reduce", words.split()[1]]
    assert asked(command[1:]).code == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("five_bar --links left_lower", "--links left_lower,"),
        (f"{MODEL} --links coupler,rocker", "--links coupler,rocker,crank"),
        (f"{MODEL} --links crank,rocker --density 200 --thickness 10mm", "--density "),
        (f"{MODEL} --links crank", "--links crank,rocker "),
    ],
)
def test_the_relaxed_request_that_comes_next_balances(words, change):
    """Each command that is named runs, with the links, the region or the density it names."""
    infeasible = asked(["counterweights", *words.split(), "--balance", "force"])
    assert infeasible.code == 1
    command = row_of(infeasible.out, "Next:")
    assert change in f"{command} "
    relaxed = asked(shlex.split(command)[1:])
    assert relaxed.code == 0 and "feasible: " in row_of(relaxed.out, "verdict")


def relaxed(words, *changes, chosen=("a",), density=(), limits=None):
    """The command of a request on link ``a`` that changes make feasible."""
    arguments = SimpleNamespace(words=["m", *words], links=["a"], density=density, region=[])
    matter = SimpleNamespace(
        worth_naming=tuple(Relaxation(*change) for change in changes),
        chosen=chosen,
        density=limits,
        regions={"a": ball_region([0.0, 0.0, 0.0], 0.1)},
    )
    return relaxed_command(arguments, matter).removeprefix("balance counterweights ")


def test_the_relaxed_request_is_written_where_options_can():
    words = ["--links", "a"]
    more = (("b", "c"), None, 1.0)
    assert relaxed(words, more) == "m --links a,b,c"
    assert relaxed(words, (("all",), None, 1.0)) == "m --links all"
    assert relaxed([*words, "--out", "w.urdf", "--merge"], more) == "m --links a,b,c"
    assert relaxed(words, more, density=[("a", 8e3)]) == "" == relaxed(words)
    grown = (("a",), 2.0, 0.8)
    assert relaxed(words, grown, more) == "m --links a --region a=202mm"
    assert relaxed(words, grown, more, chosen=()) == "m --links a,b,c"
    assert relaxed(words, (("a",), 2.0, 9.0), more) == "m --links a,b,c"
    assert relaxed(words, ((), 2.0, 1.0), limits={"a": 200.0}) == "m --links a --density 404"
    assert relaxed(words, ((), 2.0, 1.0), limits={"a": 200.0, "b": 300.0}) == ""
    sized = [*words, "--shape", "disc=2mm"]
    room = {"a": "ball(0,0,0,2)"}
    assert relaxed(sized, (("a",), 2.0, 1.0, room)) == (
        "m --links a --shape disc=2mm --region 'a=ball(0,0,0,2)'"
    )
    assert relaxed(sized, ((), 2.0, 1.0, {}, "disc=4mm")) == "m --links a --shape disc=4mm"


@pytest.mark.slow
@pytest.mark.parametrize("speed", ["300rpm", "u1=300rpm"])
def test_the_motion_that_is_named_turns_fully(speed):
    """The five-bar turns with one crank, and with both at one rate, and not with the other."""
    linkage = kinematics.load("five_bar")
    refused = asked(["verify", "five_bar", "--speed", speed])
    assert refused.code == 3 and "--csv FILE with the columns time,u1,u2" in refused.err
    ways = re.findall(r"(--motion (\S+) )?--speed (\w+)=300rpm", refused.err)
    assert [bool(way[0]) for way in ways] == [False, True]
    for _, relation, crank in ways:
        motion = kinematics.Motion.parse(relation, linkage.inputs) if relation else None
        turn = balance.motion.one_turn(linkage, "300rpm", crank, motion)
        at = linkage.inputs.index(crank)
        assert np.ptp(turn.u[:, at]) == pytest.approx(2.0 * np.pi)


@pytest.mark.slow
def test_links_that_get_nothing_are_listed():
    """A balanced linkage needs no matter; with too few kilograms one link gets all of it."""
    words = ["counterweights", "four_bar_kite_balanced", "--links", "crank,coupler", "--points"]
    out = asked(words).out
    assert [line.split()[1:3] for line in out.splitlines() if line.startswith("c")][-2:] == [
        ["none", "needed"],
        ["none", "needed"],
    ]
    words = ["reduce", MODEL, "--links", "crank,rocker", "--budget", "1", "--points"]
    out = asked([*words, "--speed", "300rpm"]).out
    assert re.search(r"^rocker +none *$", out, re.MULTILINE)


def test_an_option_of_another_command_is_named_with_what_to_write():
    refused = asked(["reduce", MODEL, "--links", "crank", "--budget", "1", "--max-order", "1"])
    assert refused.code == 2
    assert "--max-order" in refused.err and "of balance counterweights alone" in refused.err
    assert "motions of --csv" in refused.err and "did you mean" not in refused.err


@pytest.mark.slow
def test_a_moment_that_grows_has_a_note_beside_it():
    words = ["counterweights", MODEL, "--links", "crank,rocker", "--points"]
    force = asked([*words, "--balance", "force", "--speed", "300rpm"]).out
    note = row_of(force, "moment")
    assert "%) N m" not in note and "it grows" in note and "--minimise inertia" in note
    assert row_of(force, "about").endswith(" m, the middle of the mechanism")
    assert re.search(r"\(\+\d+ %\)", note).group() in force.splitlines()[0]
    words = ["reduce", MODEL, "--links", "crank,rocker", "--points", "--budget", "1"]
    note = row_of(asked(words).out, "moment")
    assert "it grows" in note and "--weight-moment less than" in note and "--about" in note
    forces = row_of(asked([*words, "--balance", "force"]).out, "moment")
    assert "--balance dynamic" in forces


def test_a_weight_on_a_crank_has_no_moment_about_its_shaft(tmp_path):
    """At one speed; along other motions it has one."""
    path = str(tmp_path / "engine.urdf")
    points = "O=10mm,0; A=O+50mm@60deg; C=A:180mm,O@0deg"
    sketch = ["--points", points, "--links", "crank=O,A; rod=A,C", "--sliders", "piston=C@0deg"]
    asked(["new", path, *sketch, "--section", "30mmx20mm", "--mass", "piston=0.5kg"])
    words = ["reduce", path, "--links", "crank", "--budget", "0.5", "--balance", "force"]
    words += ["--region", "crank=100mm"]
    turn = [*words, "--speed", "300rpm"]
    note = row_of(asked(turn).out, "moment")
    (about,) = re.findall(r"about the axis of \w+ it stays as it is: (--about \S+)$", note)
    assert about == "--about 0.01,0,0"
    data = json.loads(asked([*turn, *about.split(), "--json"]).out)
    (design,) = data["designs"]
    assert design["found"]["moment"] == pytest.approx(data["given"]["moment"], rel=1e-9)
    assert design["found"]["peak_moment"] == pytest.approx(
        data["given"]["peak_moment"], rel=1e-9
    )
    other = row_of(asked(words).out, "moment")
    assert "it grows" in other and other.endswith("--about X,Y,Z takes it about another point")


def test_a_load_grows_by_more_than_round_off():
    assert grows(1.0, 1.1) and not grows(1.0, 1.004) and not grows(1.0, 0.5)
    assert grows(0.0, 1.0) and not grows(0.0, 1e-12, 1e-11)


def test_titles_name_a_file_of_another_name(tmp_path):
    kite = kinematics.load("four_bar_kite")
    assert linkage_title(kite) == "four_bar_kite"
    path = tmp_path / "fb.urdf"
    path.write_text(Path(kite.source).read_text("utf-8"), "utf-8")
    assert linkage_title(kinematics.load(path)) == "four_bar_kite (fb.urdf)"
    assert linkage_title(SimpleNamespace(name="kite", source="<stdin>")) == "kite"


def test_heads_of_tables_keep_their_units_and_names():
    text = rows_table([("force (N rms)", "from f_1 to F_2"), ("1", "2")])
    assert "Force (N rms)" in text and "From f_1 to F_2" in text


@pytest.mark.parametrize(
    ("size", "said"),
    [
        (0.02, "denser than steel"),
        (0.1, ""),
        (2.0, "lighter than air"),
        (0.0, "without volume"),
    ],
)
def test_unusual_matter_is_told(size, said):
    """Balls of 1 kg: 30 000, 239, 0.03 kg/m³, and a point."""
    ball = Solid("ellipsoid", 1.0, np.zeros(3), size * np.eye(3))
    space = SimpleNamespace(bodies=("arm", "kept"))
    design = SimpleNamespace(space=space, solids=(ball, ball), keep=("kept",), more_mass={})
    told = unusual_matter(design)
    assert [label for label, _ in told] == ["matter"] * bool(said)
    assert all(text.startswith("arm is ") and said in text for _, text in told)
