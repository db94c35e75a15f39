"""The command ``balance synthesize``: files that others confirm, and what is refused."""

from __future__ import annotations

import json
import shlex
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from balance.app.cli.main import main
from tests.support.covering import number_of_cases
from tests.support.json_answers import json_answer
from tests.support.pantographs import TABLE, random_triple

TWO = "0.3,0.1,11; 0.1,0.4,-40"
THREE = f"{TWO}; -0.1,0.5,-70"


def run(capsys, *words):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "synthesize", *words)


def spell(places):
    """Positions as an argument, with all their digits."""
    return "; ".join(f"{x!r},{y!r},{float(np.degrees(a))!r}" for x, y, a in places)


@pytest.mark.slow
def test_random_linear_syntheses_through_the_commands(capsys, tmp_path):
    """The written file has one input and is balanced; all with ``ALL_CASES=1``."""
    rng = np.random.default_rng(6)
    out = str(tmp_path / "out.urdf")
    for _ in range(number_of_cases(2, 25)):
        start = (*rng.uniform(-0.5, 0.5, 2).tolist(), float(rng.uniform(-3.0, 3.0)))
        turn = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.3))
        end = (*rng.uniform(-0.5, 0.5, 2).tolist(), start[2] + turn)
        x, y = rng.uniform(-0.5, 0.5, 2).tolist()
        ratio = -float(rng.uniform(0.3, 1.2))
        words = [f"--ratio={ratio!r}", f"--positions={spell([start, end])}", "--out", out]
        code, found = run(capsys, *words, f"--moving={x!r},{y!r}")
        (one,) = found["mechanisms"]
        assert (code, found["verdict"], one["defects"]) == (0, "feasible", [])
        assert one["link_turns"][1] / one["tool_turns"][1] == pytest.approx(ratio, rel=1e-12)
        assert one["coupling"]["radii"] == pytest.approx(1.0 - 1.0 / ratio, rel=1e-12)
        assert main(["report", out, "--json"]) == 0
        report = json.loads(capsys.readouterr().out)
        assert report["as_given"]["balanced"] is True and report["mobility"] == 1
        words = ["verify", out, "--trajectories", "1"]
        assert main([*words, "--tolerance", "1e-10"]) == 0
        capsys.readouterr()


@pytest.mark.slow
def test_random_nonlinear_syntheses_through_the_commands(capsys, tmp_path):
    """The written file is balanced along its table; all with ``ALL_CASES=1``."""
    out, table, masses = (str(tmp_path / name) for name in ("o.urdf", "o.csv", "m.json"))
    done = 0
    for seed in range(number_of_cases(2, 25)):
        places, own, _, _ = random_triple(seed + 100)
        Path(masses).write_text(json.dumps(asdict(own)))
        words = [f"--positions={spell(places)}", "--nonlinear", "--masses", masses]
        code, found = run(capsys, *words, "--out", out, "--table", table)
        assert found["count"] >= 1 and found["mechanisms"][0]["position_error"] < 1e-9
        if code == 0:
            assert main(["verify", out, "--csv", table]) == 0, seed
            assert main(["verify", out, "--trajectories", "1"]) == 1
            capsys.readouterr()
            done += 1
    assert done >= number_of_cases(2, 25) // 2


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("words", "case", "kinds"),
    [
        ("--fixed=0.2,-0.1", "linear", {"pantograph"}),
        ("--nonlinear --moving=0.4,0.4", "nonlinear", {"pantograph"}),
        ("--kind four-bar --moving=0.2,-0.1", "four-bar", {"kite", "antiparallelogram"}),
        ("--kind slider-crank --moving=0.2,-0.1", "slider-crank", {"slider-crank"}),
        ("--kind six-bar --moving=0.2,-0.1", "six-bar", {"six-bar"}),
        ("--kind stack", "stack", {"stack"}),
    ],
)
def test_kinds_pages_and_pictures(words, case, kinds, capsys, tmp_path):
    page, picture = tmp_path / "page.html", tmp_path / "picture.svg"
    files = ["--html", str(page), "--plot", str(picture)]
    code, found = run(capsys, "--positions", TWO, *shlex.split(words), *files)
    assert (code, found["case"]) == (0, case)
    assert {one["kind"] for one in found["mechanisms"]} == kinds
    assert all(one["confirmation"]["momentum"] < 1e-10 for one in found["mechanisms"])
    assert bool(found["contour"]) == (case == "nonlinear")
    text = page.read_text("utf-8")
    assert '"schema": "balance.synthesize/1"' in text
    assert ("Construction" in text) == (case == "linear")
    assert ("Map of the search" in text) == (case == "nonlinear")
    assert "https://" not in text.partition("<script>")[0]
    assert picture.read_bytes().startswith(b"<?xml")
    assert main(["synthesize", "--positions", TWO, *shlex.split(words)]) == 0
    text = capsys.readouterr().out
    assert "feasible" in text and "misses  " in text


def test_given_masses_are_changed_as_said(capsys, tmp_path):
    """The linear case moves the centre of link 3 and raises a moment of inertia."""
    masses = tmp_path / "masses.json"
    masses.write_text(json.dumps(asdict(TABLE)))
    words = ["--positions", TWO, "--moving=0.2,-0.1", "--masses", str(masses)]
    _, found = run(capsys, *words)
    own = found["mechanisms"][0]["numbers"]
    assert abs(own["C"]) < 1e-15 and own["J1"] == pytest.approx(own["J2"], rel=1e-12)
    changed = [words.split()[0] for words in found["remarks"]]
    assert changed[0] == "s3" and changed[1] in ("inertia_1", "inertia_2")
    for name, value in asdict(TABLE).items():
        assert (own[name] == value) == (name not in changed)


def test_a_synthesis_without_a_design_says_so(capsys, tmp_path):
    out = tmp_path / "out.urdf"
    words = ["--positions", "0,0,0; 0.2,0.1,20; 0.3,0.4,0.1", "--nonlinear", "--out", str(out)]
    code, found = run(capsys, *words)
    assert (code, found["verdict"], found["mechanisms"]) == (1, "infeasible", [])
    assert "no such mechanism" in found["words"] and not out.exists()
    # A chain whose parallelogram must fold: named, not hidden.
    code, found = run(capsys, "--positions", "0,0,0; 0.2,0.1,120", "--fixed=0.3,0.3")
    assert code == 1 and found["mechanisms"][0]["defects"][0]["kind"] == "branch"
    assert "flat" in found["words"]


BAD_MASSES = {"m3": -1.0}
# Numbers whose squares no double holds.
EXTREME = {
    "long": ({"l3": 1e200}, 2, "l3 = 1e+200 is more than 1e+12"),
    "light": ({"m1": 1e-300}, 2, "m1 = 1e-300 is less than 1e-12"),
    "whole": ({"m6": 10**400}, 3, "m6: is no number"),
}


@pytest.mark.table
@pytest.mark.parametrize(("words", "code", "said"), [
    ("--positions '0,0,0; 0,0,0' --fixed 1,1", 3, "positions 1 and 2 coincide"),
    ("--positions '0,0,0' --fixed 1,1", 2, "give 2 to 20"),
    ("--positions 'x' --fixed 1,1", 2, "is not x,y,deg"),
    ("--positions '0,0,nan; 1,1,1' --fixed 1,1", 2, "is not x,y,deg"),
    (f"--positions '{TWO}'", 2, "choose the fixed or the moving one"),
    (f"--positions '{TWO}' --kind stack --fixed 0,1", 2, "meets its positions wherever"),
    (f"--positions '{TWO}' --kind stack --within 1mm", 2, "leave out 'within'"),
    ("--positions '0,0,0; 0,0,170' --kind stack", 3, "turns by up to 153°"),
    (f"--positions '{TWO}' --fixed 0,1 --ratio 0", 2, "k = 0"),
    (f"--positions '{TWO}' --fixed 0,1 --ratio 1", 2, "k = 1"),
    (f"--positions '{TWO}' --fixed 0,1 --ratio 0.5", 3, "the same way"),
    (f"--positions '{TWO}' --fixed 0,1 --ratio x", 2, "is not a number"),
    (f"--positions '{TWO}' --fixed 0,1 --ratio -1 --nonlinear", 2, "not allowed with"),
    (f"--positions '{TWO}' --fixed 0,1 --ratio -1 --kind four-bar", 2, "for the linear case"),
    (f"--positions '{THREE}' --fixed 0,1", 2, "choose none"),
    ("--positions '0,0,0; 1,0,0' --moving 0.2,0.2", 3, "same angle"),
    ("--positions '0,0,0; 1,0,30' --moving 0,0 --nonlinear --window 0,1", 3, "is horizontal"),
    ("--positions '0,0,0; 1,1,90' --fixed 0,1", 3, "is the pole"),
    ("--positions '0,0,0; 1,1,90' --fixed 0,1 --nonlinear", 3, "is the pole"),
    (f"--positions '{TWO}' --fixed 0,1 --window 0,1", 2, "nonlinear case"),
    (f"--positions '{TWO}' --fixed 0,1 --nonlinear --window 1,0", 2, "to a larger one"),
    (f"--positions '{TWO}' --fixed 0,1 --table {{folder}}/t.csv", 2, "only with --nonlinear"),
    (f"--positions '{TWO}' --fixed 0,1 --slot {{folder}}/t.csv", 2, "only with --nonlinear"),
    (f"--positions '{TWO}' --fixed 0,1 --nonlinear --slot t.txt", 2, "neither in .csv, .svg"),
    (f"--positions '{TWO}' --fixed 0,1 --masses {{folder}}/bad.json", 2, "m3 = -1"),
    (f"--positions '{TWO}' --fixed 0,1 --masses {{folder}}/none.json", 3, "cannot be read"),
    (f"--positions '{TWO}' --fixed 0,1 --masses {{folder}}/odd.json", 3, "follows from"),
    (f"--positions '{TWO}' --fixed 0,1 --masses {{folder}}/text.json", 3, "is no JSON"),
    (f"--positions '{TWO}' --fixed 0,1 --kind four-bar --masses {{folder}}/bad.json", 2, "m3"),
    (f"--positions '{TWO}' --fixed 0,1 --kind slider-crank --ratio -1", 2, "linear case"),
    (f"--positions '{TWO}' --kind slider-crank", 2, "choose the fixed or the moving one"),
    (f"--positions '{THREE}' --kind slider-crank --within 1mm", 2, "met exactly"),
    ("--positions '0,0,0; 1,1,90' --fixed 0,1 --kind slider-crank", 3, "about a pole"),
    ("--positions '0,0,0; 1,0,0; 2,1,0' --kind slider-crank", 3, "differ in angle"),
    (f"--positions '{THREE}; 1,1,1; 1,2,3; 2,1,5' --kind six-bar", 2, "up to five positions"),
    (f"--positions '{THREE}; 1,1,1' --kind six-bar --within 1mm", 2, "meets its positions"),
    (f"--positions '{TWO}' --kind six-bar --timed", 2, "2 timed positions: give 3 to 20"),
    (f"--positions '{THREE}' --timed", 2, "for the kinds geared-four-bar and six-bar"),
    ("--positions '0,0,0; 1,0,9; 1,1,3' --kind six-bar --timed", 2, "rise or fall"),
    (f"--positions '{TWO}' --fixed 0,1 --density 2700", 2, "for four-bars"),
    (f"--positions '{TWO}' --fixed 0,1 --thickness 8mm", 2, "for four-bars"),
    (f"--positions '{THREE}' --kind four-bar --density none --thickness 8mm", 2, "have none"),
    *((f"--positions '{TWO}' --fixed 0,1 --masses {{folder}}/{name}.json", code, said)
      for name, (_, code, said) in EXTREME.items()),
    (f"--positions '{TWO}' --fixed 1e308,1e308", 2, "finite numbers up to 1e+06 m"),
    (f"--positions '{TWO}' --fixed 0,1 --ratio=-1e308", 2, "from 1e-06 to 1e+06"),
    (f"--positions '{TWO}' --fixed 0,1 --nonlinear --window=-1e300,1e300", 2, "up to 1e+06 m"),
])  # fmt: skip
def test_bad_requests_get_one_line_and_write_nothing(words, code, said, capsys, tmp_path):
    (tmp_path / "bad.json").write_text(json.dumps(asdict(TABLE) | BAD_MASSES))
    (tmp_path / "odd.json").write_text(json.dumps({"s1": 1.0}))
    (tmp_path / "text.json").write_text("{")
    for name, (number, *_) in EXTREME.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(asdict(TABLE) | number))
    out = tmp_path / "out.urdf"
    words = shlex.split(words.format(folder=tmp_path))
    assert main(["synthesize", *words, "--json", "--out", str(out)]) == code
    streams = capsys.readouterr()
    assert streams.out == "" and said in streams.err.splitlines()[0]
    assert code == 2 or len(streams.err.splitlines()) == 1
    assert not out.exists()
