"""The command ``balance identify``: a plan, a measurement, files, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from balance.support.csv_text import csv_table
from tests.support.json_answers import json_answer
from tests.support.page_elements import Elements, without_breaks

MODEL = "four_bar_general"
NAMES = ("fx", "fy", "fz", "mx", "my", "mz")


@pytest.fixture
def tables(tmp_path):
    """Tables of a motion and of its loads, without gravity, with a frame of a sensor."""
    linkage = kinematics.load(MODEL)
    time = np.linspace(0.0, 1.0, 61)
    u = 0.5 * np.sin(2.0 * np.pi * time) ** 2 + 0.2 * np.sin(3.0 * np.pi * time) ** 2
    a, b = 4.0 * np.pi, 6.0 * np.pi
    ud = 0.25 * a * np.sin(a * time) + 0.1 * b * np.sin(b * time)
    udd = 0.25 * a * a * np.cos(a * time) + 0.1 * b * b * np.cos(b * time)
    wrench = balance.motion.shaking(linkage, u[:, None], ud[:, None], udd[:, None])
    rng = np.random.default_rng(1)
    loads = -np.roll(wrench, 3, axis=1)
    loads += 0.01 * np.abs(loads).max() * rng.normal(size=loads.shape)
    motion = tmp_path / "motion.csv"
    motion.write_bytes(
        csv_table(["time", "u1", "velocity u1", "acceleration u1"], [time, u, ud, udd])
    )
    path = tmp_path / "loads.csv"
    heads = ["time [ms]", *(f"{name} [{'N' if name[0] == 'f' else 'Nmm'}]" for name in NAMES)]
    path.write_bytes(csv_table(heads, [1e3 * time, loads[:, :3], 1e3 * loads[:, 3:]]))
    return ["--motion", str(motion), "--wrench", str(path), "--gravity", "0,0,0"]


def test_the_answer_keeps_to_its_schema_and_writes_its_files(capsys, tables, tmp_path):
    out, picture = tmp_path / "real.urdf", tmp_path / "loads.svg"
    code, answer = json_answer(
        capsys, "identify", MODEL, *tables, "--out", str(out), "--plot", str(picture)
    )
    assert code == 0 and answer["verdict"] == "identified"
    assert answer["relevant"] == answer["determined"] == len(answer["combinations"]) == 8
    for item in answer["combinations"]:
        assert abs(item["file"] - item["value"]) < 4.5 * item["error"]
    assert picture.read_text("utf-8").startswith("<?xml")
    assert len(kinematics.load(out).bodies) == 3


def test_the_page_has_the_answer_and_the_loads(capsys, tables, tmp_path):
    """Sentence and curves are those of the answer, and those of a plan its table."""
    path, plan, table = (tmp_path / name for name in ("a.html", "plan.html", "plan.csv"))
    code, answer = json_answer(capsys, "identify", MODEL, *tables, "--html", str(path))
    assert code == 0
    page = without_breaks(path.read_text("utf-8"))
    assert f'<p class="lede">{answer["sentence"]}</p>' in page
    (chart,) = Elements(page).data("figures")
    measured, by_file, explained = (trace["y"] for trace in chart["data"][:3])
    fit = answer["recordings"][0]["channels"][0]
    rms = [np.sqrt(np.mean(np.square(values))) for values in (measured, by_file, explained)]
    assert rms[0] == pytest.approx(fit["size"], rel=0.02)
    left = np.sqrt(np.mean(np.subtract(measured, explained) ** 2))
    assert left == pytest.approx(fit["residual"], rel=0.02)
    assert [trace["name"] for trace in chart["data"][:2]] == ["measured", "masses of the file"]
    words = ["--plan", "--duration", "2", "--tries", "1", "--out", str(table)]
    code, _ = json_answer(capsys, "identify", MODEL, *words, "--html", str(plan))
    assert code == 0
    (chart,) = Elements(plan.read_text("utf-8")).data("figures")
    inputs = np.genfromtxt(table, delimiter=",", names=True)
    first = chart["data"][0]
    drawn = np.interp(inputs["time"], first["x"], first["y"])
    np.testing.assert_allclose(drawn, inputs["u1"], atol=1e-3)


def test_the_text_names_combinations_loads_and_masses(capsys, tables):
    assert main(["identify", MODEL, *tables]) == 0
    text = capsys.readouterr().out
    assert text.startswith("Identified: all 8 combinations on which balance depends.")
    for words in ("left by the file", "1 sigma", "likeliest", "mcx crank", "coupler"):
        assert words in text


@pytest.mark.slow
def test_a_plan_is_read_by_other_verbs(capsys, tmp_path):
    path = tmp_path / "plan.csv"
    code, answer = json_answer(
        capsys,
        "identify",
        MODEL,
        "--plan",
        "--duration",
        "1.5",
        "--tries",
        "8",
        "--max-velocity",
        "u1=3",
        "--out",
        str(path),
    )
    assert code == 0 and answer["peaks"]["u1"]["velocity"] <= 3.0
    assert answer["planned"]["error"] <= answer["random"]["error"]
    assert main(["identify", MODEL, "--plan", "--tries", "2"]) == 0
    assert "seed 0" in capsys.readouterr().out
    assert main(["verify", MODEL, "--csv", str(path)]) == 1


def test_loads_that_a_sensor_does_not_feel_are_told(capsys, tables, tmp_path):
    """The table of one component alone leaves combinations open."""
    lines = (tmp_path / "loads.csv").read_text("utf-8").splitlines()
    rows = [line.split(",") for line in lines]
    (tmp_path / "loads.csv").write_text("\n".join(f"{r[0]},{r[1]}" for r in rows), "utf-8")
    code, answer = json_answer(capsys, "identify", MODEL, *tables)
    assert code == 1 and answer["verdict"] == "partly identified"
    assert 0 < answer["determined"] < 8
    assert main(["identify", MODEL, *tables]) == 1
    assert "not excited" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "give --motion and --wrench, or --plan"),
        (("--plan", "--offset"), "--offset: not with --plan"),
        (("--plan", "--rotors"), "--rotors: not with --plan"),
        (("--plan", "--cutoff", "3"), "--cutoff: not with --plan"),
        (("--plan", "--prior", "0.1"), "--prior: not with --plan"),
        (("--motion", "a.csv", "--wrench", "b.csv", "--seed", "1"), "--seed: only with --plan"),
        (("--plan", "--harmonics", "1"), "is not a number from 2 to 50"),
        (("--plan", "--max-velocity", "ghost=1"), "'ghost' is no input"),
    ],
)
def test_usage_is_told_in_a_line(capsys, words, told):
    assert main(["identify", MODEL, *words]) == 2
    assert told in capsys.readouterr().err


def test_tables_that_cannot_be_read_are_told(capsys, tables, tmp_path):
    for text, told in (
        ("time,fx\n0,1\n", "holds 1 samples, not 12"),
        ("time,ghost\n" + "0,1\n" * 20, "some of fx, fy, fz, mx, my, mz, u1"),
        ("time\n" + "0\n" * 20, "some of fx"),
        ("time,fx [Nm]\n" + "0,1\n" * 20, "is a unit of torque"),
        ("time,fx\n" + "0,1\n" * 20, "its times do not increase"),
    ):
        (tmp_path / "loads.csv").write_text(text, "utf-8")
        assert main(["identify", MODEL, *tables]) == 3
        assert told in capsys.readouterr().err
