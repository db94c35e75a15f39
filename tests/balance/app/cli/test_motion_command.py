"""``balance motion``: predicted and corrected poses, exit codes, the contract of its JSON."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from jsonschema import Draft202012Validator, ValidationError

import kinematics
from balance.app.cli.main import main
from kinematics.wording import number_text
from tests.independent import reference
from tests.support.command_runs import asked
from tests.support.json_answers import read_schema
from tests.support.motion_command import named, refused, run, table
from tests.support.motions import followed
from tests.support.rounded_four_bar import four_bar

KEYS = (
    "schema model at tool point motion independent dependent joints order condition radius "
    "length poses reached warnings"
).split()


# --- one pose ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "goal"),
    [
        ("five_bar", (0.3, -0.1)),
        ("bennett", (0.9,)),
        ("four_bar_general", (-0.7,)),
        ("three_rsr", (0.2, -0.3, 0.4)),
        ("three_rrr", (0.2, 0.1, -0.1)),
        ("delta", (0.1, -0.2, 0.1)),
        ("slider_crank", (0.3,)),
    ],
)
def test_the_corrected_pose_is_that_of_another_route(name, goal, capsys):
    """And the errors told are those of the prediction against it, to a factor of 2."""
    code, report = run(capsys, name, f"--to={','.join(map(str, goal))}")
    (pose,) = report["poses"]
    assert code == 0 and report["reached"] is True and pose["reason"] is None
    assert pose["inputs"] == list(goal) and pose["distance"] < report["radius"]
    _, expected = followed(name, goal)
    predicted, corrected = (named(report, pose[key]) for key in ("predicted", "corrected"))
    assert len(expected) > len(goal)
    units = {joint["name"]: joint["unit"] for joint in report["joints"]}
    sizes = {"rad": 1.0, "m": report["length"]}
    assert ("m" in units.values()) == (name == "slider_crank")
    for joint, value in expected.items():
        assert corrected[joint] == pytest.approx(value, abs=1e-9)
    worst = max(abs(predicted[j] - value) / sizes[units[j]] for j, value in expected.items())
    assert 0.0 < worst <= 1.001 * pose["difference"]
    assert 0.5 * pose["difference"] < pose["error"] < 2.0 * pose["difference"]


def test_higher_orders_predict_better(capsys):
    differences = []
    for order in (1, 3, 5, 7):
        _, report = run(capsys, "five_bar", "--to", "u2=0.2", "--order", str(order))
        assert report["order"] == order
        differences.append(report["poses"][0]["difference"])
    assert all(b < 0.2 * a for a, b in zip(differences[:-1], differences[1:], strict=True))


def test_json_keeps_its_keys(capsys):
    code, report = run(capsys, "five_bar")
    assert code == 0 and list(report) == KEYS
    assert report["schema"] == "balance.motion/1"
    assert (report["tool"], report["point"]) == (None, None)
    assert (report["motion"], report["poses"]) == ([], [])
    assert report["independent"] == ["u1", "u2"]
    assert sorted(report["dependent"]) == ["q2", "q3", "q4"]
    assert report["reached"] is True and 0.1 < report["radius"] < 3.0
    with pytest.raises(ValidationError):
        Draft202012Validator(read_schema("motion")).validate({**report, "surprise": 1})
    _, report = run(capsys, "hprs", "--to", "prismatic=0.2")
    assert report["radius"] is None and report["dependent"] == []
    assert report["joints"][1] == {"name": "prismatic", "unit": "m"}
    assert report["poses"][0]["difference"] < 1e-15


def test_inputs_are_named_or_in_order(capsys):
    poses = [
        run(capsys, "five_bar", "--to", words)[1]["poses"]
        for words in ("0.0,0.25", "u2=0.25", "u2 = 0.25 , u1 = 0")
    ]
    assert poses[0] == poses[1] == poses[2] != []


def test_inputs_not_named_follow_the_motion(capsys):
    code, report = run(capsys, "three_rsr", "--motion", "u2=-2*u3", "--to", "u3=0.1,u1=0.2")
    assert code == 0 and report["motion"] == ["u2=-2*u3"]
    assert report["poses"][0]["inputs"] == pytest.approx([0.2, -0.2, 0.1], abs=1e-15)
    line = refused(capsys, 3, "three_rsr", "--motion", "u2=u3", "--to", "0.1,0.2,0.3")
    assert "motion 'u2=u3': does not hold at the pose --to" in line


def test_inverse_kinematics_moves_the_tool(capsys):
    """The frame of the link ends where the tool was sent, by the reference's forward route."""
    model, link, sent = "three_rrr", "platform", (0.04, -0.03, 0.2)
    to = ",".join(map(str, sent))
    code, report = run(capsys, model, "--tool", link, "--along", "x,y,rz", "--to", to)
    assert code == 0 and report["tool"] == link
    assert report["independent"] == [f"{link}.x", f"{link}.y", f"{link}.rz"]
    assert {*kinematics.load(model).inputs} < {*report["dependent"]}
    mechanism = reference.load(kinematics.gallery()[model])
    positions = named(report, report["poses"][0]["corrected"])
    q = np.array([positions[joint] for joint in mechanism.joints])
    (start,) = (body.frame for body in kinematics.load(model).bodies if body.name == link)
    number = mechanism.links[mechanism.bodies.index(link)]
    frame = reference.displacements(mechanism, q)[0][number] @ start
    assert frame[:3, 3] - start[:3, 3] == pytest.approx([*sent[:2], 0.0], abs=1e-10)
    R = frame[:3, :3] @ start[:3, :3].T
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(sent[2], abs=1e-10)
    assert np.abs(reference.closure(mechanism, q)[0]).max() < 1e-10


def test_masses_do_not_matter(tmp_path, capsys):
    """Not even where the file has none, or where links are told to have none."""
    words = ["--tool", "coupler", "--along", "rz", "--to", "0.05"]
    text = kinematics.gallery()["four_bar_general"].read_text(encoding="utf-8")
    bare = tmp_path / "bare.urdf"
    changed = text.replace("<inertial>", "<!--").replace("</inertial>", "-->")
    bare.write_text(changed, encoding="utf-8")
    same = [
        run(capsys, *model, *words)[1]["poses"]
        for model in (
            ["four_bar_general"],
            [str(bare)],
            ["four_bar_general", "--massless", "coupler"],
        )
    ]
    assert same[0] == same[1] == same[2] != []


# --- poses that are not reached --------------------------------------------------------------


def test_what_is_not_reached_exits_with_1(capsys, caplog):
    name, to = "five_bar", "u1=1.8"
    code, report = run(capsys, name, f"--to={to}")
    (pose,) = report["poses"]
    assert code == 1 and report["reached"] is False
    assert pose["corrected"] is None and pose["difference"] is None
    assert "cannot be closed beyond 44% of the way to u1=1.8, u2=0; give" in pose["reason"]
    assert [warning["code"] for warning in report["warnings"]] == ["beyond_radius"]
    assert main(["motion", name, f"--to={to}"]) == 1
    streams = capsys.readouterr()
    assert f"verdict      not reached: {pose['reason']}" in streams.out
    assert caplog.messages[-1].startswith("beyond_radius: 1 of 1 poses are beyond")


@pytest.mark.parametrize(
    ("name", "goal"),
    [("three_rsr", (0.343, -0.135, 1.109)), ("four_bar_antiparallelogram", (-2.305,))],
)
def test_beyond_the_radius_the_branch_is_kept(name, goal, capsys):
    """From these predictions Newton's method closes the loops elsewhere."""
    code, report = run(capsys, name, f"--to={','.join(map(str, goal))}")
    (pose,) = report["poses"]
    assert code == 0 and pose["distance"] > report["radius"]
    _, expected = followed(name, goal)
    corrected = named(report, pose["corrected"])
    for joint, value in expected.items():
        assert corrected[joint] == pytest.approx(value, abs=1e-9)
    assert [warning["code"] for warning in report["warnings"]] == ["beyond_radius"]


# --- paths ---------------------------------------------------------------------------------


def test_a_path_is_predicted_row_by_row(tmp_path, capsys):
    rows = np.random.default_rng(2).uniform(-0.3, 0.3, (9, 2))
    path = table(tmp_path / "a.csv", ["u2", "u1"], rows[:, ::-1])
    code, report = run(capsys, "five_bar", "--path", path, "--order", "1")
    assert code == 0 and [pose["inputs"] for pose in report["poses"]] == rows.tolist()
    for pose, goal in zip(report["poses"], rows, strict=True):
        _, expected = followed("five_bar", goal)
        corrected = named(report, pose["corrected"])
        for joint, value in expected.items():
            assert corrected[joint] == pytest.approx(value, abs=1e-9)
    assert main(["motion", "five_bar", "--path", path, "--order", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    head = next(k for k, line in enumerate(lines) if line.startswith("pose "))
    assert lines[head].split() == ["pose", "u1", "u2", "distance", "estimated", "difference"]
    assert lines[head + 7] == "" and lines[-1] == "… and 3 more; --json has them all"
    shown = lines[head + 1].split()
    assert [float(x) for x in shown[1:3]] == pytest.approx(rows[0], rel=1e-5)
    worst = max(pose["difference"] for pose in report["poses"])
    guess = max(pose["error"] for pose in report["poses"])
    sizes = [number_text(error, ".2g") for error in (guess, worst)]
    text = "up to {} estimated, {} to the corrected pose".format(*sizes)
    assert text in "\n".join(lines) and sizes[0] != sizes[1]
    path = table(tmp_path / "b.csv", ["u1", "u2"], [[0.1, 0.1], [1.8, 0.0], [0.2, 0.0]])
    code, report = run(capsys, "five_bar", "--path", path)
    assert code == 1
    assert [pose["reason"] is None for pose in report["poses"]] == [True, False, True]
    assert main(["motion", "five_bar", "--path", path]) == 1
    assert "not reached: 1 of 3 poses; pose 2: " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        ("", [], "line 1: the columns must be u1, u2, u3"),
        ("time,u1,u2,u3\n0,0,0,0\n", [], "line 1: the columns must be u1, u2, u3"),
        ("u1,u2\n0,0\n", [], "line 1: the columns must be u1, u2, u3"),
        ("u1,u2,u3\n", [], "holds 0 samples"),
        ("u1,u2,u3\n0,0,0\n0,x,0\n", [], "sample 2: cannot be read as numbers"),
        ("u1,u2,u3\n0,inf,0\n", [], "not finite"),
        ("u1,u2,u3\n0,0,0\n0,0.1,0\n", ["--motion", "u2=u3"], "sample 2: is not on u2=u3"),
        ("u1,u2,u3\n0,1e90,0\n", [], "u1=0, u2=1e+90, u3=0 is too far away to compute with"),
    ],
)
def test_tables_that_do_not_fit_get_one_line(text, options, said, tmp_path, capsys):
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    page = tmp_path / "a.html"
    words = ["three_rsr", "--path", str(path), "--html", str(page), *options]
    assert said in refused(capsys, 3, *words)
    assert not page.exists()


# --- bad requests --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--to", "u9=1"], "input u9: not an independent coordinate; choose from u1, u2"),
        (["--to", "1"], "--to gives 1 displacements, and there are 2 inputs (u1, u2)"),
        (["--to", "1,2,3"], "--to gives 3 displacements"),
        (["--to", "1e300,0"], "is too far away to compute with; give a nearer pose"),
        (["--path", "none.csv"], "none.csv: cannot be read (No such file"),
        (["--tool", "nothing", "--along", "x"], "link 'nothing': no moving link of this name"),
        (["--tool", "left_upper", "--along", "q"], "q: no direction of a tool"),
        (["--tool", "left_upper", "--along", "z"], "cannot move this way"),
        (["--tool", "left_upper", "--along", "x", "--to", "y=1"], "input y: not an indep"),
        (["--motion", "q2=0"], "'q2' is not an input"),
        (["--inputs", "u9"], "u9"),
    ],
)
def test_bad_requests_get_one_clear_line(words, said, capsys):
    assert said in refused(capsys, 3, "five_bar", *words)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--to", "u1=0.1,0.2"], "'u1=0.1,0.2' is not u1=0.3,u2=-0.1 with each input once"),
        (["--to", "u1=1,u1=2"], "with each input once"),
        (["--to", "=1"], "--to"),
        (["--to", "u1=x"], "--to"),
        (["--to", "0.1,,2"], "--to"),
        (["--to", "nan,0"], "--to"),
        (["--to", ""], "--to"),
        (["--to", "1,2", "--path", "a.csv"], "--path: not allowed with argument --to"),
        (["--order", "0"], "'0' is not an order from 1 to 50"),
        (["--order", "51"], "--order"),
        (["--order", "½"], "--order"),
        (["--plot", "a.gif"], "ends neither in .png nor in .svg"),
        (["--tool", "left_upper"], "--tool and --along go together"),
        (["--along", "x"], "--tool and --along go together"),
        (["--tool", "left_upper", "--along", "x", "--inputs", "u1"], "named by --along"),
    ],
)
def test_usage_errors_exit_with_2(words, said, capsys):
    line = refused(capsys, 2, "five_bar", *words)
    assert line.startswith("balance motion: error: ") and said in line


def test_too_many_terms_are_refused(capsys):
    assert "give a lower order" in refused(capsys, 3, "stewart_6ups", "--order", "20")


def test_both_readings_of_rounded_angles_are_told(tmp_path, capsys):
    code, report = run(capsys, str(four_bar(tmp_path)), "--to", "0.1")
    (warning,) = report["warnings"]
    assert code == 0 and warning["code"] == "rounded_angles"
    told = f"; nominal: mobility 1, radius of convergence {report['radius']:.3g}"
    assert told in warning["message"]
    assert "; as written: loop 'q3': does not close: " in warning["message"]


def test_a_missing_library_costs_a_line(monkeypatch, tmp_path, capsys):
    option = ["--plot", str(tmp_path / "a.png")]
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert "pip install matplotlib'" in refused(capsys, 2, "bennett", *option)
    assert list(tmp_path.iterdir()) == []


def test_nobody_means_degrees_by_a_number_out_of_all_reach():
    """Its refusal is one line, without a notice before it."""
    done = asked(["motion", "five_bar", "--to=u1=-1e300"])
    assert done.code == 3 and done.err.count("\n") == 1 and "too far away" in done.err
