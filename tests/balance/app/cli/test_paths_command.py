"""The command ``balance paths``: verdicts, files that are written, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from balance.app.cli.main import main
from tests.support.json_answers import json_answer

SHORT = ("--length", "0.3")


def run(capsys, *words):
    """Exit code and JSON of the command."""
    return json_answer(capsys, "paths", *words, *SHORT)


@pytest.mark.slow
def test_the_table_is_what_verify_takes(capsys, tmp_path):
    table, page, picture = (tmp_path / name for name in ("a.csv", "a.html", "a.svg"))
    code, found = run(
        capsys,
        "fuga_i",
        "--table",
        str(table),
        "--which",
        "2",
        "--html",
        str(page),
        "--plot",
        str(picture),
    )
    assert code == 0 and len(found["paths"]) == 2 and found["reason"] is None
    assert found["starts"][0]["kind"] == "crossing"
    assert main(["verify", "fuga_i", "--csv", str(table)]) == 0
    text = page.read_text("utf-8")
    assert '"schema": "balance.paths/1"' in text and "Shaking along the path" in text
    assert "https://" not in text.partition("<script>")[0]
    assert picture.read_text("utf-8").startswith("<?xml")
    assert "balanced" in capsys.readouterr().out


@pytest.mark.lanes
def test_no_path_and_why(capsys, tmp_path):
    table = tmp_path / "a.csv"
    code, found = run(capsys, "five_bar", "--table", str(table))
    assert (code, found["paths"], found["dimension"]) == (1, [], 0)
    assert found["reason"].startswith("the momentum matrix has full column rank in all of 9")
    assert not table.exists()
    assert main(["paths", "five_bar"]) == 1
    assert "full column rank" in capsys.readouterr().out


@pytest.mark.slow
def test_parts_of_the_momentum_and_lines_of_starts(capsys):
    code, found = run(
        capsys, "five_bar", "--moment-only", "--from", "u1=0", "--from", "u1=0.1", "--line", "1"
    )
    assert code == 0 and found["kept"] == "moment" and found["dimension"] == 1
    assert [start["inputs"][0] for start in found["starts"]] == pytest.approx([0, 0.05, 0.1])
    assert len(found["paths"]) == 3 and max(one["momentum"] for one in found["paths"]) < 1e-9
    code, found = run(capsys, "five_bar", "--base", "free", "--base-mass", "2", "--attitude")
    assert code == 0 and found["kept"] == "attitude" and found["base"]["mass"] == 2.0
    assert main(["paths", "five_bar", "--moment-only"]) == 0
    assert "no shaking moment about the inertial origin" in capsys.readouterr().out


@pytest.mark.slow
def test_the_moment_about_another_point(capsys):
    """``ξ - r × p`` vanishes along the path, and ``ξ`` does not."""
    r = (0.4, -0.2, 0.0)
    words = ["--moment-only", "--about", "0.4,-0.2,0", *SHORT]
    code, told = json_answer(capsys, "paths", "five_bar", *words)
    assert code == 0 and told["about"] == list(r) and told["kept"] == "moment"
    (path,) = balance.find_paths("five_bar", kept="moment", about=r, length=0.3).paths
    for u, rates in zip(path.u[::20], path.rates[::20], strict=True):
        momentum = balance.pose.momentum_matrix("five_bar", u) @ rates
        moment, p = momentum[:3], momentum[3:]
        assert np.linalg.norm(moment - np.cross(r, p)) < 1e-8 * np.linalg.norm(moment)
    assert main(["paths", "five_bar", *words]) == 0
    assert "no shaking moment about (0.4, -0.2, 0) m" in capsys.readouterr().out


@pytest.mark.lanes
@pytest.mark.parametrize(
    ("words", "code", "what"),
    [
        (["--attitude"], 2, "only with --base free"),
        (["--base", "free", "--attitude"], 2, "--base-mass"),
        (["--base", "free", "--moment-only"], 2, "not with --moment-only"),
        (["--moment-only", "--force-only"], 2, "not allowed"),
        (["--moment-only", "--balance", "force"], 2, "not with --balance force"),
        (["--about", "1,0,0"], 2, "only with --moment-only"),
        (["--line", "2"], 2, "two poses"),
        (["--length", "0"], 2, "is not a number"),
        (["--moment-only", "--length", "0.1", "--which", "9"], 2, "there are 1 paths"),
        (["--step", "1e-8"], 2, "longer step"),
        (["--from", "ghost=1"], 3, "ghost is not an input"),
        (["--from", "u1=9"], 3, "cannot be closed"),
        (["--motion", "u1=u9"], 3, "u9"),
        (["--massless", "left_lower,left_upper,right_lower,right_upper"], 3, "no moving link"),
    ],
)
def test_refusals(words, code, what, capsys):
    """The first line on standard error says why; nothing is on standard output."""
    assert main(["paths", "five_bar", *words]) == code
    shown = capsys.readouterr()
    assert shown.out == "" and what in shown.err.splitlines()[0]
