"""The command ``balance remedies``: verdicts, files that are written, and what is refused."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import balance
import kinematics
from balance.app.answers.answer import AnswerTable
from balance.app.answers.html.remedies import remedies_page
from balance.app.answers.text.remedies import (
    NO_TRADE_OFF,
    first_choice,
    remedies_body,
    remedies_facts,
    remedies_sentence,
    remedy_rows,
)
from balance.app.cli.main import main
from balance.masses.designs.feasibility import feasible
from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.as_built import AsBuilt
from balance.masses.remedies.catalogue import CATALOGUE, remedy_named
from balance.masses.remedies.compare import RemedyComparison
from balance.masses.remedies.request import RemedyRequest
from tests.support.command_runs import asked
from tests.support.json_answers import json_answer, read_schema
from tests.support.page_elements import without_breaks

SCHEMA = read_schema("remedies")
NO, YES = "four_bar_general", "four_bar_antiparallelogram"


def run(capsys, *words):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "remedies", *words)


@pytest.mark.slow
def test_the_page_has_the_commands_that_are_printed(tmp_path, monkeypatch):
    """That for the least shaking too, with the model, its links and its mass, and it runs."""
    monkeypatch.chdir(tmp_path)
    done = asked(["remedies", NO, "--only", "duplicates", "--html", "page.html"])
    (command,) = re.findall(r"^reduce, in steel +(.*)$", done.out, re.MULTILINE)
    assert command == f"balance reduce {NO} --links all --budget 2"
    assert f"<dd>{command}</dd>" in without_breaks(Path("page.html").read_text("utf-8"))
    assert asked(shlex.split(command)[1:]).code == 0


@pytest.mark.slow
def test_own_masses_and_the_baseline(capsys, tmp_path):
    """Files of what helps are written, and they hold what was said of them."""
    out = tmp_path / "remedies"
    code, found = run(capsys, NO, "--only", "own_masses,partial", "--out", str(out))
    assert (code, found["verdict"]) == (1, "infeasible")
    assert [one["verdict"] for one in found["remedies"]] == ["infeasible", "partial"]
    assert [path.name for path in out.iterdir()] == ["partial.urdf"]
    partial = found["remedies"][1]
    before = balance.verify(NO, trajectories=3).scale
    after = balance.verify(out / "partial.urdf", trajectories=3)
    assert 0.0 < partial["residual"] < 1.0 and before > 0.0
    mass = sum(body.inertia[0] for body in after.linkage.bodies)
    assert mass == pytest.approx(found["given_mass"] + partial["added_mass"], rel=1e-9)
    code, found = run(capsys, YES, "--only", "own_masses")
    assert (code, found["verdict"]) == (0, "feasible")
    assert found["remedies"][0]["residual"] <= 1e-9


@pytest.mark.slow
def test_the_page_has_the_numbers_and_no_network(capsys, tmp_path):
    page = tmp_path / "page.html"
    words = ["remedies", NO, "--only", "partial", "--html", str(page)]
    assert main(words) == 0
    text = page.read_text("utf-8")
    assert '"schema": "balance.remedies/1"' in text and "What each remedy costs" in text
    assert "https://" not in text.partition("<script>")[0]
    assert "counterweights for less shaking (partial)" in capsys.readouterr().out
    drawings = re.findall(r"<figure>(<svg.*?</svg>)", text, re.DOTALL)
    assert len(drawings) == 1
    found = json.loads(re.findall(r'id="report">(.*?)</script>', text, re.DOTALL)[0])
    _, size = _extent(drawings[0])
    radii = [float(r) / size for r in re.findall(r'r="([\d.]+)" fill="#d06a1099"', drawings[0])]
    # Volumes of balls of steel, in a drawing whose scale is that of the four-bar.
    masses = [7850 * 4 / 3 * np.pi * radius**3 for radius in radii]
    assert sum(masses) == pytest.approx(found["remedies"][0]["added_mass"], rel=0.05)


def _extent(drawing):
    """The largest distance of joints in a drawing, and the pixels of a metre."""
    circles = re.findall(r'cx="([\d.]+)" cy="([\d.]+)" r="4"', drawing)
    at = np.array(circles, float)
    places = np.array([joint.point for joint in balance.load(NO).joints])
    far = max(np.linalg.norm(a - b) for a in at for b in at)
    real = max(np.linalg.norm(a - b) for a in places for b in places)
    return far, far / real


@pytest.mark.slow
def test_the_page_draws_springs_and_frames(capsys, tmp_path):
    """One spring and two, each from its foot on the base; their file has the places."""
    page, out = tmp_path / "page.html", tmp_path / "out"
    words = ["--only", "harmonic_springs,free_joint", "--html", str(page), "--out", str(out)]
    code, found = run(capsys, NO, *words)
    assert code == 0 and [one["remedy"] for one in found["remedies"]] == [
        "free_joint",
        "harmonic_springs",
        "harmonic_springs",
    ]
    assert page.read_text("utf-8").count('class="spring"') == 3
    springs = json.loads((out / "harmonic_springs_springs.json").read_text())["springs"]
    assert springs == found["remedies"][1]["details"]["springs"]
    assert found["remedies"][1]["built"] is None and found["why_first"]


@pytest.mark.slow
def test_the_picture_of_costs(tmp_path):
    """A mark for each remedy that helps, with its name; where none does, no file, and why."""
    path = tmp_path / "costs.svg"
    done = asked(["remedies", NO, "--only", "partial", "--plot", str(path)])
    assert done.code == 0 and f"written: {path}\n" in done.err
    text = path.read_text("utf-8")
    assert "added mass with gears, of that of the linkage" in text
    assert "counterweights for less shaking" in text
    path.unlink()
    done = asked(["remedies", NO, "--only", "own_masses", "--plot", str(path)])
    assert done.code == 1 and f"not written, for no remedy helps: {path}" in done.err
    assert "\nwritten: " not in done.err
    assert not path.exists()


def test_every_remedy_of_the_schema_is_in_the_catalogue():
    known = SCHEMA["$defs"]["remedy"]["properties"]["remedy"]["enum"]
    assert tuple(known) == tuple(CATALOGUE)


def test_the_words_of_the_table_name_a_remedy():
    """As its name does; a list of them is divided at its commas."""
    for name, remedy in CATALOGUE.items():
        for text in (name, remedy.short, f" {remedy.short.upper().replace(' ', '_')}"):
            assert remedy_named(text) == name and "," not in text
    found = balance.compare_remedies(NO, ["A pantograph", "a free hinge of the frame"])
    assert [each.remedy for each in found.results] == ["free_joint", "pantograph"]
    assert found.request.only == ("pantograph", "free_joint")


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--only", "wheels"], 2, "no remedy 'wheels'"),
        (["--only", "partial,relation of input"], 2, "(did you mean 'a relation of inputs'?)"),
        (["--only", "input_relations"], 2, "(did you mean 'input_relation'?)"),
        (["--gear", "0"], 2, "positive"),
        (["--gear", "nan"], 2, "positive"),
        (["--rotor-radius", "-1"], 2, "positive"),
        (["--budget", "x"], 2, "positive"),
        (["--links", "ghost"], 3, "ghost"),
        (["--links", "crank,crank"], 2, "not a list"),
        (["--region", "crank=cube(1)"], 2, "crank"),
        (["--links", "crank", "--region", "rocker=ball(0,0,0,1)"], 2, "rocker"),
        (
            ["--region", "crank=ball(0,0,0,1)", "--region", "crank=ball(0,0,0,2)"],
            2,
            "two regions",
        ),
        (["--motion", "u9=0"], 3, "u9"),
    ],
)
def test_bad_requests_get_one_line_and_write_nothing(words, code, said, capsys, tmp_path):
    out = tmp_path / "out"
    assert main(["remedies", NO, *words, "--json", "--out", str(out)]) == code
    streams = capsys.readouterr()
    assert streams.out == "" and said in streams.err.splitlines()[0]
    assert not out.exists()


@pytest.mark.slow
def test_folders_that_cannot_be_written_are_refused_first(capsys, tmp_path):
    """Before any work, and a folder that was there keeps what it held."""
    file = tmp_path / "file"
    file.write_text("x")
    for out in (file, tmp_path / "no" / "such"):
        assert main(["remedies", NO, "--out", str(out)]) == 2
        assert str(out.parent) in capsys.readouterr().err
    model = tmp_path / "partial.urdf"
    model.write_bytes(
        (Path(balance.__file__).parents[1] / f"urdf_models/{NO}.urdf").read_bytes()
    )
    before = model.read_bytes()
    words = ["remedies", str(model), "--only", "partial", "--out", str(tmp_path)]
    assert main(words) == 2
    assert "would replace a file that is read" in capsys.readouterr().err
    assert model.read_bytes() == before and {p.name for p in tmp_path.iterdir()} == {
        "file",
        "partial.urdf",
    }


@pytest.mark.slow
def test_a_failed_page_leaves_no_folder(capsys, tmp_path):
    """All files or none."""
    out = tmp_path / "out"
    page = tmp_path / "no" / "page.html"
    words = ["remedies", NO, "--only", "partial", "--out", str(out), "--html", str(page)]
    assert main(words) == 3
    assert "cannot be written" in capsys.readouterr().err and not out.exists()


@pytest.mark.slow
def test_files_of_balancers_are_verified_as_the_command_says(capsys, caplog, tmp_path):
    """Inputs that a remedy adds follow its table; Pinocchio finds the machine balanced so."""
    balancers = "active_wheel,passive_wheel,moving_mass,free_joint"
    words = ["remedies", "slider_crank", "--only", balancers, "--out", str(tmp_path / "out")]
    assert main(words) == 0
    commands = re.findall(r"balance (verify [^;\n]+)", "\n".join(caplog.messages))
    assert len(commands) == 4
    for command in commands:
        assert main([*shlex.split(command), "--json"]) == 0


def test_a_linkage_without_masses_is_refused(capsys, tmp_path):
    path = tmp_path / "bare.urdf"
    path.write_text(
        '<robot name="r"><link name="b"/><link name="a"/><joint name="j" type="continuous">'
        '<parent link="b"/><child link="a"/><axis xyz="0 0 1"/></joint></robot>'
    )
    assert main(["remedies", str(path), "--json"]) == 3
    streams = capsys.readouterr()
    assert streams.out == "" and "no moving link has a mass" in streams.err


def comparison_of(*results):
    """A comparison of results that nothing has computed: remedy, verdict and added mass."""
    request = RemedyRequest(kinematics.load("four_bar_kite"))
    made = tuple(
        AppliedRemedy(name, f"parts of {name}", verdict, "why", added_mass=mass)
        for name, verdict, mass in results
    )
    return RemedyComparison(request, feasible(request.space), made)


def test_what_one_would_build_first_comes_first():
    """Copies of the whole linkage come after other parts and partial balance, however light."""
    found = comparison_of(
        ("own_masses", "infeasible", None),
        ("separate_rotors", "feasible", 9.0),
        ("counter_rotary_masses", "feasible", 5.0),
        ("duplicates", "feasible", 1.0),
        ("input_relation", "refused", None),
        ("partial", "partial", 2.0),
    )
    assert [row[0] for row in remedy_rows(found)[1:]] == [
        "turning counterweights",
        "rotors against joints",
        "counterweights for less shaking",
        "mirrored copies",
        "counterweights on the links",
    ]
    facts = dict(remedies_facts(found))
    assert "other ways" not in facts
    assert remedies_sentence(found) == (
        "Build turning counterweights: it balances the linkage, keeps all freedoms, and adds "
        "5 kg, the least (next: rotors against joints 9 kg); lighter, but with fewer freedoms, "
        "copies of it all or a frame that turns: mirrored copies 1 kg."
    )


def test_gears_count_in_what_one_would_build_first():
    """A lighter remedy with heavy gears comes after a heavier one without."""
    found = comparison_of(
        ("counter_rotary_masses", "feasible", 5.0), ("passive_wheel", "feasible", 6.0)
    )
    geared = replace(found.results[0], built=AsBuilt(10.0, 1.0, 2.0, 1.5, 1.25))
    found = replace(found, results=(geared, found.results[1]))
    assert [each.remedy for each in found.balanced] == [
        "passive_wheel",
        "counter_rotary_masses",
    ]
    row = dict(zip(*(remedy_rows(found)[k] for k in (0, 2)), strict=True))
    assert (row["added (kg)"], row["of it gears (kg)"]) == ("7", "2")
    assert float(row["added (× mass)"]) == pytest.approx(7.0 / found.request.given_mass, 1e-3)
    assert (row["bearing load (×)"], row["width (×)"]) == ("1.5", "1.25")
    page = remedies_page(replace(found, results=(replace(geared, inertia_ratio=1.0),)))
    (data,) = re.findall(r'id="figures">(.*?)</script>', page, re.DOTALL)
    (mark,) = json.loads(data)[0]["data"]
    assert mark["x"] == pytest.approx([7.0 / found.request.given_mass], rel=1e-12)
    assert "turning counterweights 7 kg" in found.why_first
    (alone,) = comparison_of(("passive_wheel", "feasible", 6.0)).results
    alone = replace(found, results=(replace(alone, lost_freedoms=1),))
    assert alone.why_first == (
        "nothing else that was tried balances it; it takes 1 freedom, and adds 6 kg"
    )
    assert not comparison_of(("partial", "partial", 1.0)).why_first


def test_what_is_too_heavy_is_not_built_first():
    """It comes after what shakes less for little, and the sentence says why."""
    mass = 20.0 * comparison_of().request.given_mass
    found = comparison_of(("separate_rotors", "feasible", mass), ("partial", "partial", 1.0))
    assert [each.remedy for each in found.by_preference] == ["partial", "separate_rotors"]
    found = replace(found, reduce="balance reduce m --links a --budget 1")
    said = dict(remedies_facts(found))
    sentence = remedies_sentence(found)
    assert sentence.startswith(
        "Build counterweights for less shaking (1 kg of point masses added, "
    )
    assert "kg, 20 times the mass" in sentence
    assert said["reduce, in steel"] == "balance reduce m --links a --budget 1"


def test_partial_balance_heavier_than_the_linkage_comes_second():
    """In the sentence, in the table and in the next command; round-off does not count."""
    mass = comparison_of().request.given_mass

    def shown(force, budget):
        results = (
            ("force_masses", "partial", force * mass),
            ("partial", "partial", budget * mass),
        )
        found = comparison_of(("duplicates", "feasible", 8.0 * mass), *results)
        return found, remedies_sentence(found)

    found, said = shown(4.0, 1.0 + 1e-9)
    assert said.startswith("Build counterweights for less shaking (")
    assert "), or, heavier than the linkage, counterweights for the force (" in said
    assert first_choice(found).remedy == "partial"
    assert [row[0] for row in remedy_rows(found)[1:]] == [
        "counterweights for less shaking",
        "counterweights for the force",
        "mirrored copies",
    ]
    for force, budget in ((0.9, 1.0), (4.0, 5.0)):
        found, said = shown(force, budget)
        assert said.startswith("Build counterweights for the force (")
        assert "heavier" not in said and first_choice(found).remedy == "force_masses"


def test_springs_are_not_said_to_shake_less():
    """They take torque alone; a frame that turns is compared with copies too."""
    mass = 20.0 * comparison_of().request.given_mass
    found = comparison_of(
        ("separate_rotors", "feasible", mass), ("harmonic_springs", "partial", 0.0)
    )
    assert remedies_sentence(found).startswith("Balancing all shaking is not worth it: ")
    assert "spring" not in remedies_sentence(found)
    found = comparison_of(("free_joint", "feasible", 1.0), ("duplicates", "feasible", 2.0))
    assert "the least (next: mirrored copies 2 kg)" in found.why_first


def test_what_does_not_apply_has_a_line_for_each_reason():
    found = comparison_of(
        ("input_relation", "refused", None),
        ("own_masses", "infeasible", None),
        ("slider_path", "refused", None),
    )
    assert [row[0] for row in remedy_rows(found)[1:]] == ["counterweights on the links"]
    few = replace(found, request=replace(found.request, only=("input_relation",)))
    lines = [part for part in remedies_body(few) if isinstance(part, str)]
    assert lines[-1] == (
        "not for this machine: a relation of inputs, a path of the slider, because why"
    )


def test_where_all_were_tried_the_answer_comes_before_a_short_rest():
    """What to build, with which command, the costs; what does not help by its name alone."""
    found = comparison_of(
        ("own_masses", "infeasible", None),
        ("duplicates", "undecided", None),
        ("slider_path", "refused", None),
        ("partial", "partial", 1.0),
    )
    found = replace(found, following="balance remedies m --only partial --out built")
    body = remedies_body(found)
    assert body[0].startswith(
        "Build counterweights for less shaking (1 kg of point masses added, "
    )
    assert body[0].endswith(
        "; whether one of these remedies balances the linkage is undecided."
    )
    assert body[1] == "Next: balance remedies m --only partial --out built"
    assert body[2].strip().startswith("with --density steel: the same of steel")
    steel = replace(found, request=replace(found.request, density=7850.0))
    assert remedies_body(steel)[2] == "" and "reduce" not in dict(remedies_facts(steel))
    (table,) = [part for part in body if isinstance(part, AnswerTable)]
    assert [row[0] for row in table.rows[1:]] == ["counterweights for less shaking"]
    assert body[-4:] == [
        "undecided: mirrored copies, because why",
        "no masses do: counterweights on the links",
        "not for this machine: a path of the slider",
        "why: --only NAME, or --html FILE.html for all of them",
    ]
    assert len(found.to_dict()["remedies"]) == 4
    alone = remedies_body(replace(found, results=found.results[1:2]))
    assert alone[-1] == "undecided: mirrored copies, because why"


def test_the_next_command_runs_and_writes_what_was_named(tmp_path, monkeypatch):
    """It keeps what was asked of the model, and leaves out what would be written over."""
    monkeypatch.chdir(tmp_path)
    words = [NO, "--only", "partial,force_masses", "--html", "page.html", "--links", "crank"]
    done = asked(["remedies", *words])
    _, following = done.out.splitlines()[:2]
    command = shlex.split(following.removeprefix("Next: "))
    assert command[:2] == ["balance", "remedies"] and "--html" not in command
    assert following in Path("page.html").read_text("utf-8").replace("&#x27;", "'")
    again = asked(command[1:])
    assert again.code == 0 and again.out.splitlines()[0].startswith(
        "Build counterweights for less"
    )
    assert "Next: " not in again.out and Path("built/partial.urdf").exists()
    assert "written: built/partial.urdf\n" in again.err
    (reduce,) = re.findall(r"^reduce +(.*)$", done.out, re.MULTILINE) or ["balance reduce"]
    assert "--html" not in reduce


def test_copies_are_not_headed_build_first_where_others_shake_less():
    """The heading tells the whole mass, gears included, the size, and what one builds."""
    found = comparison_of(
        ("duplicates", "feasible", 3.0),
        ("force_masses", "partial", 2.0),
        ("partial", "partial", 1.0),
        ("harmonic_springs", "partial", 0.0),
    )
    copies, force, part, springs = found.results
    copies = replace(
        copies, built=AsBuilt(10.0, 1.0, 4.0, 1.5, 3.2), new_links=("a", "b"), new_joints=("c",)
    )
    force = replace(force, residual=5.5, details={"moment_after": 11.0})
    loads = dict(force_before=4.0, force_after=3.0, moment_before=2.0, moment_after=2.5)
    part = replace(part, residual=0.8, details=loads)
    results = (copies, force, part, replace(springs, residual=0.25))
    found = replace(found, results=results)
    said = remedies_sentence(found)
    assert said.startswith("Build counterweights for the force (2 kg of point masses added, ")
    assert "the linkage; rms shaking left: force 0, moment × 5.5), or counterweights" in said
    assert "counterweights for less shaking (1 kg of point masses added, " in said
    assert "left: force × 0.75, moment × 1.25); " in said
    assert "not worth it: the lightest way (mirrored copies) adds 7 kg with its gears" in said
    assert said.endswith("2 links and 1 joint, at 3.2 times the width.")
    assert first_choice(found) == force
    assert "spring" not in said and not found.why_first
    assert [each.remedy for each in found.by_preference] == [
        "force_masses",
        "partial",
        "duplicates",
        "harmonic_springs",
    ]
    cells = [row[-1] for row in remedy_rows(found)[1:]]
    assert cells == [
        "force 0, moment × 5.5",
        "force × 0.75, moment × 1.25",
        "-",
        "torque × 0.25",
    ]
    alone = replace(found, results=(copies, results[3]))
    said = remedies_sentence(alone)
    assert said.startswith(
        "Mirrored copies balance the linkage, and nothing else that was tried"
    )
    assert (
        "2 links and 1 joint, at 3.2 times the width. Worth it only where nothing may" in said
    )
    assert "--only duplicates,force_masses,partial compares them" in said
    assert "adds 7 kg with its gears" in alone.why_first


def test_a_trade_off_that_no_remedy_has_is_said():
    found = comparison_of(("partial", "partial", 1.0))
    assert NO_TRADE_OFF not in remedies_body(found)
    asked_for = replace(found, request=replace(found.request, trade_off=4))
    assert remedies_body(asked_for)[-2:] == ["", NO_TRADE_OFF]


def test_where_only_copies_help_one_sentence_says_so():
    found = comparison_of(("own_masses", "infeasible", None), ("duplicates", "feasible", 1.0))
    facts = dict(remedies_facts(found))
    said = facts["other ways"]
    assert "only copies" in said and "--balance force" in said
    assert facts["reduce, in steel"].startswith("balance reduce")
    forces = replace(found, request=replace(found.request, balance="force"))
    said = dict(remedies_facts(forces))["other ways"]
    assert "only copies" in said and "--balance" not in said
