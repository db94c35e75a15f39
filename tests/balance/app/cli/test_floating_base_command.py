"""``balance verify --base``: exit codes, the contract of its JSON, files, refusals."""

from __future__ import annotations

import csv

import pytest

from balance.app.cli.main import main
from tests.support.json_answers import json_answer

BALANCED, SHAKING = "four_bar_kite_balanced", "four_bar_general"
FREE = ["--base", "free", "--base-mass", "3", "--base-inertia", "0.5", "--duration", "0.2"]
SPRING = [*FREE[:1], "spring", *FREE[2:], "--stiffness", "1e3", "--stiffness", "2e4N/m"]


def run(capsys, *arguments):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "verify", *arguments, schema="floating_base")


@pytest.mark.slow
def test_exit_codes_tell_the_verdict(capsys, monkeypatch):
    code, report = run(capsys, BALANCED, *FREE)
    assert code == 0 and report["undisturbed"] and report["verdict"] == "the base stays at rest"
    code, report = run(capsys, SHAKING, *FREE, "--against", BALANCED)
    assert code == 1 and report["undisturbed"] is False
    assert report["against"]["undisturbed"] is True
    assert report["against"]["duration"] == report["duration"] == 0.2
    assert main(["verify", SHAKING, *FREE, "--tolerance", "0.99"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].split()[:5] == (
        "verdict the base stays at".split()
    )
    monkeypatch.setattr(
        "balance.motion.floating_base.floating_base_motion.BASE_DRIFT_RELATIVE", 0.0
    )
    code, report = run(capsys, BALANCED, *FREE)
    assert code == 4 and report["undisturbed"] is None


@pytest.mark.slow
def test_springs_torques_and_velocities(capsys):
    words = ["--torque", "u1=0.1", "--initial", "wz=1,u1=2", "--base-com", "0.1,0,0"]
    code, report = run(capsys, SHAKING, *SPRING, *words)
    assert code == 1 and report["verdict"] == "the inputs disturb the base"
    assert report["torques"] == {"u1": 0.1} and report["initial"] == {"wz": 1.0, "u1": 2.0}
    assert len(report["frequencies"]) == 3 and report["base"]["com"] == [0.1, 0.0, 0.0]
    assert (report["base"]["turning_stiffness"], report["base"]["stiffness"]) == (1e3, 2e4)
    assert main(["verify", SHAKING, *SPRING, *words]) == 1
    text = capsys.readouterr().out
    assert "1000 N m/rad, 20000 N/m" in text and "torques u1 = 0.1" in text


@pytest.mark.slow
def test_a_planar_linkage_on_a_spatial_base(capsys):
    _, report = run(
        capsys, SHAKING, *FREE[:4], "--base-inertia", "0.5,0.6,0.7", *FREE[6:], "--spatial"
    )
    assert report["algebra"] == "spatial" and report["base"]["inertia"] == [0.5, 0.6, 0.7]
    _, report = run(capsys, SHAKING, *FREE, "--speed", "60rpm")
    assert report["algebra"] == "planar" and report["duration"] == 0.2
    assert report["end"]["inputs"]["u1"] == pytest.approx(0.2 * 6.283185307179586)


@pytest.mark.slow
@pytest.mark.parametrize("elements", ["0.7,0.7,0.5", "0.7,0.7,0.5,0.1,0,-0.1"])
def test_elements_of_the_inertia_are_printed_in_their_places(elements, capsys):
    inertia = ["--base-inertia", elements]
    assert main(["verify", SHAKING, *FREE[:4], *inertia, *FREE[6:], "--spatial"]) == 1
    assert f"3 kg, {elements.replace(',', ', ')} kg m²" in capsys.readouterr().out


@pytest.mark.slow
def test_files(tmp_path, capsys):
    table, motion = tmp_path / "base.csv", tmp_path / "motion.csv"
    rows = "".join(f"{k / 20!r},{0.3 * (k / 20) ** 3!r}\n" for k in range(11))
    motion.write_text(f"time,u1\n{rows}", encoding="utf-8")
    options = [*FREE[:-2], "--csv", str(motion)]
    page, picture = tmp_path / "page.html", tmp_path / "picture.svg"
    written = ["--table", str(table), "--html", str(page), "--plot", str(picture)]
    code, report = run(capsys, SHAKING, *options, *written)
    assert code == 1 and report["duration"] == pytest.approx(0.5)
    assert report["end"]["inputs"]["u1"] == pytest.approx(0.3 * 0.125)
    with table.open(encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == report["samples"]
    assert float(lines[-1]["rotation_z"]) == report["end"]["rotation"][2]
    assert float(lines[-1]["u1"]) == report["end"]["inputs"]["u1"]
    assert "<svg" in picture.read_text("utf-8")
    assert "base rotation (rad)" in page.read_text("utf-8")
    both = tmp_path / "both.html"
    main(["verify", SHAKING, *FREE, "--against", BALANCED, "--html", str(both)])
    text = both.read_text("utf-8")
    assert "traces1" in text and "the base stays at rest" in text and "http-equiv" in text


@pytest.mark.parametrize(
    ("code", "match", "words"),
    [
        (2, "--base-mass: only with --base free", ["--base-mass", "1"]),
        (2, "--torque: only with --base free", ["--torque", "u1=1"]),
        (2, "give --base-mass and --base-inertia", ["--base", "free"]),
        (2, "--stiffness belongs to --base spring", [*FREE, "--stiffness", "1e3"]),
        (2, "--stiffness belongs to --base spring", ["--base", "spring", *FREE[2:]]),
        (2, "one rotational and one translational", [*SPRING, "--stiffness", "5"]),
        (2, "not with --balance force", [*FREE, "--balance", "force"]),
        (2, "one motion with --base", [*FREE, "--trajectories", "2"]),
        (2, "--torque: frees the inputs", [*FREE, "--torque", "u1=1", "--seed", "2"]),
        (2, "'-1' is not a number from", [*FREE[:2], "--base-mass=-1", *FREE[4:]]),
        (2, "nor three", [*FREE[:4], "--base-inertia", "1,2"]),
        (2, "no base has these moments", [*FREE[:4], "--base-inertia", "1,1,3"]),
        (2, "nor six elements", [*FREE[:4], "--base-inertia", "1,1,1,0"]),
        (2, "no base has these moments", [*FREE[:4], "--base-inertia", "1,1,1,0,2,0"]),
        (2, "is not a point", [*FREE, "--base-com", "1,2"]),
        (2, "is not a stiffness", [*FREE, "--stiffness", "5N/mm"]),
        (2, "moves in its plane", [*FREE, "--initial", "wx=1"]),
        (2, "motion of input u1 is prescribed", [*FREE, "--initial", "u1=1"]),
        (3, "joint x is not an input", [*FREE, "--torque", "x=1"]),
        (3, "vibrates", [*FREE[:1], "spring", *FREE[2:], "--stiffness", "1e12N/m"]),
    ],
)
def test_refusals(code, match, words, capsys, monkeypatch):
    monkeypatch.setattr("balance.motion.floating_base.simulate.MAX_EVALUATIONS", 2000)
    assert main(["verify", SHAKING, *words, "--json"]) == code
    out, err = capsys.readouterr()
    assert out == "" and match in err.splitlines()[0]
