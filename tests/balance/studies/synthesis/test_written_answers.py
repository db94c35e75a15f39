"""Files that are written come back with the same answer: special geometries stay special."""

import json

import pytest

from balance.app.cli.main import main

TWO = "0.3,0.1,11; 0.1,0.4,-40"


def run(capsys, *words):
    """Exit code and object of a command with ``--json``."""
    code = main([*words, "--json"])
    return code, json.loads(capsys.readouterr().out)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "ranks"),
    [
        (["--positions", f"{TWO}; -0.1,0.5,-70", "--kind", "four-bar"], [3, 6, 7]),
        (
            [
                "--positions",
                "0.1,0.5,0; 0.5,0.6,-50",
                "--kind",
                "four-bar",
                "--moving",
                "0.1,0.45",
            ],
            [3, 6, 7],
        ),
        (["--positions", TWO, "--moving", "0.2,-0.1", "--ratio", "-0.5"], None),
    ],
    ids=["three positions", "two positions", "pantograph"],
)
def test_synthesised_mechanisms(words, ranks, tmp_path, capsys):
    """Kites have the ranks 3, 6, 7; the pantograph is balanced too."""
    path = str(tmp_path / "out.urdf")
    assert run(capsys, "synthesize", *words, "--out", path)[0] == 0
    code, report = run(capsys, "report", path)
    assert code == 0 and report["certainty"] in ("proved", "verified")
    assert ranks in (None, [order["rank"] for order in report["orders"]])
    assert run(capsys, "verify", path, "--trajectories", "1")[1]["balanced"]
    assert run(capsys, "design", path)[1]["verdict"] == "feasible"


@pytest.mark.slow
def test_members_of_families(tmp_path, capsys):
    """Kites and antiparallelograms: seven conditions, by masses that can be built."""
    results, path = str(tmp_path / "four.db"), str(tmp_path / "member.urdf")
    search = ["--topology", "four-bar", "--starts", "60", "--workers", "1"]
    assert run(capsys, "discover", "run", *search, "--out", results)[0] == 0
    families = run(capsys, "discover", "show", results)[1]["families"]
    assert len(families) == 2
    for number in range(1, 3):
        words = ["discover", "export", results, "--family", str(number), "--out", path]
        assert run(capsys, *words)[0] == 0
        code, report = run(capsys, "report", path)
        assert (code, [order["rank"] for order in report["orders"]]) == (0, [3, 6, 7])
        assert report["certainty"] in ("proved", "verified")
        assert run(capsys, "design", path)[1]["verdict"] == "feasible"
