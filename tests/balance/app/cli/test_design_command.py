"""The command ``balance design``: verdicts, files that are written, and what is refused."""

from __future__ import annotations

import json
import re
import shlex
from typing import get_args

import pytest
from jsonschema import Draft202012Validator, ValidationError

from balance.app.cli.design import OBJECTIVES
from balance.app.cli.main import main
from balance.masses.designs.objectives import Objective
from kinematics.loading.model_gallery import gallery
from tests.support.covering import spread
from tests.support.figures import FIGURES
from tests.support.json_answers import json_answer, read_schema
from tests.support.sidecar_text import PAIR
from tests.support.urdf_text import along, joint, link

SCHEMA = read_schema("design")
YES, NO = "four_bar_antiparallelogram", "four_bar_general"
# Gallery linkages, motions and kinds of balance for which bodies can be built.
FEASIBLE = {
    "four_bar_kite", "four_bar_antiparallelogram", "slider_crank", "scissor_three_stage",
    "three_rsr-u2=u3", "three_rsr_rational-u2=u3", "five_bar-force", "fuga_i-force",
    "four_rrr-force", "four_rrr_pair-force-c1=-a1-b1", "four_rrr_parallel-force-c1=-a1-b1",
    "four_rrr_in_line-force", "four_rrr_symmetric-force",
    "four_rrr_prototype-force-c1=-a1-b1", "four_rrr_side_by_side-force-c1=-a1-b1",
    "two_rrr-force", "double_pendulum_counter_rotary", "double_pendulum_duplicates",
    "four_bar_added_antiparallelogram", "four_bar_added_slider_crank",
    "principal_vector_linkage-u1=-u3-u2=-u3", "principal_vector_linkage_slider",
    "three_four_bars_platform", "zero_reaction_arm-u3=-12*u1-4*u2", "two_rrr_bisector",
    "pantograph_reaction_wheel-force",
}  # fmt: skip


def run(capsys, *words):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "design", *words)


def told(caplog):
    """The words of the command that is told to verify with."""
    (line,) = (text for text in caplog.messages if text.startswith("written: "))
    return shlex.split(line.split("; to verify what was written: balance ")[1])


def refused(capsys, *words):
    """What is said of bad input: one line on standard error, nothing else."""
    assert main(["design", *words]) == 3
    streams = capsys.readouterr()
    assert streams.out == ""
    (line,) = streams.err.splitlines()
    return line.removeprefix("balance: ")


def options(row):
    """The options of a row of the table of figures."""
    return [
        *(word for relation in row.motion for word in ("--motion", relation)),
        "--balance",
        row.balance,
    ]


@pytest.mark.table(2)
@pytest.mark.parametrize("row", spread(FIGURES, 3, 2), ids=str)
def test_a_design_is_balanced_and_verified(row, tmp_path, capsys):
    """Written into the file, it passes the report and Pinocchio; else nothing is written."""
    out = tmp_path / "out.urdf"
    spatial = ["--spatial"] if row.spatial else []
    code, found = run(capsys, row.model, *options(row), *spatial, "--out", str(out))
    yes = str(row).replace("-spatial", "") in FEASIBLE
    assert (code, found["verdict"]) == ((0, "feasible") if yes else (1, "infeasible"))
    assert found["residuals"]["accepted"] is True
    assert out.exists() == yes
    if yes:
        assert main(["report", str(out), *options(row), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["as_given"]["balanced"] is True
        assert main(["verify", str(out), *options(row), "--trajectories", "1"]) == 0
    else:
        assert found["bodies"] == [] and found["certificate"]


@pytest.mark.table(2)
@pytest.mark.parametrize("objective", OBJECTIVES)
def test_the_best_design_is_written_too(objective, tmp_path, capsys):
    out = tmp_path / "out.urdf"
    code, found = run(capsys, YES, "--minimise", objective, "--out", str(out))
    assert code == 0 and found["minimise"] == objective and found["value"] > 0.0
    assert main(["verify", str(out), "--trajectories", "1"]) == 0


def test_objectives_are_those_of_the_library():
    assert get_args(Objective) == OBJECTIVES


def test_text_holds_the_verdict_the_bodies_and_the_residuals(capsys):
    _, found = run(capsys, YES)
    assert main(["design", YES]) == 0
    text = capsys.readouterr().out
    assert re.search(r"^verdict +feasible", text, re.MULTILINE)
    assert re.search(r"^residuals +conditions below 1e-12, eigenvalue ", text, re.MULTILINE)
    for body in found["bodies"]:
        line = next(x for x in text.splitlines() if x.startswith(f"{body['name']} "))
        for value in (body["mass"], *body["link_com"], *body["moments"]):
            shown = [float(word.rstrip(",")) for word in line.split()[1:]]
            assert min(abs(x - value) for x in shown) < max(0.1 * abs(value), 1e-6)
    assert main(["design", NO]) == 1
    text = capsys.readouterr().out
    verdict = re.search(r"^verdict +(.*)$", text, re.MULTILINE)[1]
    assert all(name in verdict for name in ("crank", "coupler", "rocker"))
    assert "separation" in text and "mass (kg)" not in text


def test_the_schema_is_strict(capsys):
    _, found = run(capsys, YES)
    assert set(found) == set(SCHEMA["required"]) == set(SCHEMA["properties"])
    for wrong in ({"surprise": 1}, {"verdict": "yes"}, {"bodies": [{}]}, {"margin": None}):
        with pytest.raises(ValidationError):
            Draft202012Validator(SCHEMA).validate(found | wrong)


def test_the_answer_without_limits_is_of_the_same_schema(capsys, tmp_path, caplog):
    """Where there is none within them: exit code 1, and nothing is written."""
    out = tmp_path / "out.urdf"
    words = [NO, "--balance", "force", "--keep", "coupler", "--bounds", "crank=:0.1"]
    code, found = run(capsys, *words, "--out", str(out))
    assert code == 1 and found["verdict"] == "infeasible" and not out.exists()
    assert len(found["multipliers"]) == 3 and found["anywhere"]["verdict"] == "feasible"
    assert caplog.messages == [f"not written, for there is no design: {out}"]
    for wrong in (
        {"anywhere": {}},
        {"within": 0.0},
        {"balls": {"crank": {}}},
        {"multipliers": [-1.0]},
    ):
        with pytest.raises(ValidationError):
            Draft202012Validator(SCHEMA).validate(found | wrong)
    code, free = run(capsys, *words, "--anywhere", "--out", str(out))
    assert code == 0 and free["residuals"]["reach"] == 0.0
    assert main(["verify", str(out), "--balance", "force", "--trajectories", "1"]) == 0


def test_masses_are_bounded_and_kept(capsys, tmp_path):
    """Twice over one link: both bounds count. What is kept stays the same bytes."""
    bounds = ["--bounds", "crank=0.9:", "--bounds", "crank=:0.95", "--bounds", "rocker=1:1.5"]
    code, found = run(capsys, YES, *bounds, "--minimise", "mass")
    mass = {body["name"]: body["mass"] for body in found["bodies"]}
    assert code == 0 and 0.9 <= mass["crank"] * (1.0 + 1e-8) <= 0.95
    assert 1.0 - 1e-9 <= mass["rocker"] <= 1.5
    assert found["bounds"] == {"crank": [0.9, 0.95], "rocker": [1.0, 1.5]}
    code, found = run(capsys, YES, "--bounds", "crank=2:")
    assert found["bounds"] == {"crank": [2.0, None]}
    path = gallery()[f"{YES}_balanced"]
    out = tmp_path / "out.urdf"
    code, found = run(capsys, str(path), "--keep", "coupler", "--out", str(out))
    assert code == 0 and found["keep"] == ["coupler"]
    kept = re.compile(rb'<link name="coupler">.*?</link>', re.DOTALL)
    assert kept.search(out.read_bytes())[0] == kept.search(path.read_bytes())[0]
    assert out.read_bytes() != path.read_bytes()
    assert main(["verify", str(out), "--trajectories", "1"]) == 0


def test_the_file_itself_is_replaced_on_request_alone(tmp_path, capsys, caplog):
    path = tmp_path / "robot.urdf"
    path.write_bytes(gallery()[YES].read_bytes())
    assert main(["verify", str(path), "--trajectories", "1"]) == 1
    capsys.readouterr()
    before = path.read_bytes()
    assert main(["design", str(path), "--out", str(path)]) == 2
    streams = capsys.readouterr()
    assert streams.out == "" and streams.err.count("\n") == 2
    assert streams.err == (
        f"balance: {path}: --out would replace a file that is read; give another path, or "
        "--overwrite\nbalance design --help lists what there is\n"
    )
    assert path.read_bytes() == before
    assert run(capsys, str(path), "--out", str(path), "--overwrite")[0] == 0
    assert told(caplog) == ["verify", str(path)]
    assert main(["verify", str(path), "--trajectories", "1"]) == 0
    assert [item.name for item in tmp_path.iterdir()] == ["robot.urdf"]


def test_nothing_is_written_without_a_design(tmp_path, capsys, caplog):
    out, page = tmp_path / "a.urdf", tmp_path / "a.html"
    code, _ = run(capsys, NO, "--out", str(out), "--html", str(page))
    assert code == 1 and not list(tmp_path.iterdir())
    assert caplog.messages == [f"not written, for there is no design: {out}, {page}"]


def test_nothing_is_said_before_all_is_written(tmp_path, capsys):
    out = tmp_path / "a.urdf"
    folder = tmp_path / "folder.html"
    folder.mkdir()
    for place in (tmp_path / "no" / "a.html", folder):
        line = refused(capsys, YES, "--out", str(out), "--html", str(place))
        assert "cannot be written" in line and list(tmp_path.iterdir()) == [folder]
    page = tmp_path / "a.html"
    assert main(["design", YES, "--html", str(page), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "feasible"
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_two_files_need_two_names(tmp_path, capsys):
    one, other = tmp_path / "a.html", f"{tmp_path}/../{tmp_path.name}/a.html"
    assert main(["design", YES, "--out", str(one), "--html", other, "--overwrite"]) == 2
    streams = capsys.readouterr()
    assert streams.out == "" and not list(tmp_path.iterdir())
    line, _ = streams.err.splitlines()
    assert line.endswith(": both --out and --html are to write it; give each its own file")


def test_the_unit_of_an_input_that_slides_is_told(capsys):
    assert main(["design", "slider_crank", "--inputs", "q4", "--minimise", "rotor"]) == 0
    text = capsys.readouterr().out
    assert re.search(r"^minimised +rotor: \S+ kg m², q4 in lengths of 0\.\d+ m$", text, re.M)
    assert main(["design", "slider_crank", "--minimise", "rotor"]) == 0
    assert re.search(r"^minimised +rotor: \S+ kg m²$", capsys.readouterr().out, re.MULTILINE)


def beside(folder):
    """An antiparallelogram whose loop a YAML file closes."""
    text = gallery()[YES].read_text(encoding="utf-8")
    loop = re.search(r"<loop.*?</loop>", text, re.DOTALL)[0]
    sides = re.findall(r'link="(\w+)".*?xyz="(.*?)"', loop, re.DOTALL)
    frames = "".join(
        link(f"tip_{k}")
        + joint(f"to_{k}", "fixed", name, f"tip_{k}", along([float(x) for x in xyz.split()]))
        for k, (name, xyz) in zip("ab", sides, strict=True)
    )
    path = folder / "robot.urdf"
    path.write_text(text.replace(loop, frames), encoding="utf-8")
    path.with_suffix(".yaml").write_text(PAIR + "type: ['3d']\n", encoding="utf-8")
    return path


@pytest.mark.table(1)
@pytest.mark.parametrize("words", [[], ["--as-written"], ["--loops", "{}"]])
def test_the_command_to_verify_with_is_told(words, tmp_path, capsys, caplog):
    """It finds the loops that a file beside the model holds, and repeats the options."""
    path, out = beside(tmp_path), tmp_path / "my robot.urdf"
    words = [word.format(path.with_suffix(".yaml")) for word in words]
    assert run(capsys, str(path), *words, "--out", str(out))[0] == 0
    command = told(caplog)
    assert command[:2] == ["verify", str(out)] and "--loops" in command
    assert ("--as-written" in command) == ("--as-written" in words)
    assert main([*command, "--trajectories", "1"]) == 0


def test_options_of_the_model_are_repeated(tmp_path, capsys, caplog):
    out = tmp_path / "a.urdf"
    words = ["--motion", "c1=-a1-b1", "--balance", "force", "--inputs", "a1,b1,c1"]
    assert run(capsys, "four_rrr_pair", *words, "--out", str(out))[0] == 0
    command = told(caplog)
    assert sorted(command[2:]) == sorted(words)
    assert main([*command, "--trajectories", "1"]) == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--keep", "crunk"], ["'crunk'", "the bodies are crank, coupler, rocker"]),
        (["--keep", "ground"], ["'ground'", "the bodies are crank, coupler, rocker"]),
        (["--bounds", "crunk=0:1"], ["'crunk'", "the bodies are crank, coupler, rocker"]),
        (["--bounds", "crank=2:1"], ["'crank'", "from 2 to 1 kg", "give 0 ≤ least ≤ largest"]),
        (["--bounds", "crank=2:", "--bounds", "crank=:1"], ["'crank'", "from 2 to 1 kg"]),
        (["--bounds", "crank=-1:2"], ["'crank'", "from -1 to 2 kg"]),
        (
            ["--keep", "crank", "--keep", "coupler", "--keep", "rocker"],
            ["every link is kept", "nothing is left to design", "keep fewer"],
        ),
        (["--keep", "crank", "--bounds", "crank=1:2"], ["'crank'", "kept and bounded"]),
    ],
)
def test_bad_input(words, said, tmp_path, capsys):
    """One line that says what is wrong and what to do; nothing is written."""
    out = tmp_path / "a.urdf"
    line = refused(capsys, YES, *words, "--out", str(out))
    assert re.search(rf"{YES}\.urdf: (every )?link", line), line
    assert all(word in line for word in said), line
    assert not out.exists()


@pytest.mark.parametrize("bounds", ["1e-320:1e-320", "5e-324:1e-300", "1e300:1e308"])
def test_masses_whose_squares_no_double_holds_are_undecided(bounds, capsys):
    """Sums of such masses are zero, or infinite: neither a crash nor a verdict follows."""
    code, answer = json_answer(capsys, "design", YES, "--bounds", f"coupler={bounds}")
    assert (code, answer["verdict"]) == (4, "undecided")
    assert answer["bodies"] == [] and answer["certificate"] is None


@pytest.mark.parametrize(
    "words",
    [
        ["--bounds", "crank"],
        ["--bounds", "crank=1"],
        ["--bounds", "=1:2"],
        ["--bounds", "crank=a:2"],
        ["--bounds", "crank=nan:2"],
        ["--bounds", "crank=0:nan"],
        ["--bounds", "crank=inf:"],
        ["--minimise", "price"],
        ["--keep"],
        [],
    ],
)
def test_usage(words, capsys):
    assert main(["design", *([YES] if words else []), *words]) == 2
    streams = capsys.readouterr()
    assert streams.out == "" and streams.err.startswith("balance design: ")
    if "--bounds" in words:
        assert f"'{words[1]}' is not L=LO:HI, such as crank=0.5:2" in streams.err
