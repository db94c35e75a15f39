"""``balance verify --tolerance mass=2%,…``: the worst case, its JSON, and what is refused."""

from __future__ import annotations

import pytest

from balance.app.cli.main import main
from tests.support.json_answers import json_answer

KITE = "four_bar_kite_balanced"
ONE = ("--trajectories", "1")


def test_the_answer_keeps_to_its_schema(capsys):
    code, answer = json_answer(
        capsys, "verify", KITE, *ONE, "--tolerance", "mass=2%,com=0.1mm", schema="verify"
    )
    found = answer["tolerances"]
    assert code == 0 and answer["balanced"] and answer["tolerance"] == 1e-9
    assert (found["mass"], found["length"], found["com"]) == (0.02, 0.0, 1e-4)
    force = found["force"]
    assert force["nominal"] < 1e-9 * force["bound"]
    assert force["largest"] < force["bound"] and found["proved"]
    assert force["reached"] <= force["bound"] < 1.02 * force["reached"]
    total = sum(share["force"] for share in found["shares"])
    assert abs(total - force["reached"]) < 0.02 * total


def test_the_text_names_what_adds_most(capsys):
    words = ("verify", "four_bar_general", *ONE, "--tolerance", "length=0.1mm,mass=0.01")
    assert main([*words]) == 1
    text = capsys.readouterr().out
    for part in ("worst case", "to first order in lengths", "mass of coupler", "axis of u1"):
        assert part in text


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (("--tolerance", "mass=2"), 2, "is not one of mass=2%"),
        (("--tolerance", "mass=2mm"), 2, "is not one of mass=2%"),
        (("--tolerance", "com=1kg"), 2, "is not one of mass=2%"),
        (("--tolerance", "com=1mm,com=2mm"), 2, "each once"),
        (("--tolerance", "mass=0"), 2, "no tolerance above 0"),
        (("--tolerance", "mass=1%", "--against", KITE), 2, "not with a second linkage"),
        (
            (
                "--tolerance",
                "mass=1%",
                "--base",
                "free",
                "--base-mass",
                "1",
                "--base-inertia",
                "1",
            ),
            2,
            "not with --base",
        ),
    ],
)
def test_what_cannot_be_asked_is_told(capsys, words, code, told):
    assert main(["verify", KITE, *ONE, *words]) == code
    assert told in capsys.readouterr().err


def test_overconstrained_loops_are_refused(capsys):
    assert main(["verify", "bennett", *ONE, "--tolerance", "length=0.1mm"]) == 3
    assert "the linkage is overconstrained" in capsys.readouterr().err
