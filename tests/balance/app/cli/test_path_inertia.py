"""``balance paths --factors`` and ``--through``: answers by a second route, and refusals."""

from __future__ import annotations

import pytest

from balance.app.cli.main import main
from tests.support.json_answers import json_answer
from tests.support.page_elements import Elements
from tests.support.two_links import LENGTHS, MASSES, tip, turned

pytestmark = pytest.mark.slow


@pytest.fixture
def arm(tmp_path):
    """The file of two links in a plane, straight along x."""
    parts, before = [], "base"
    for k, (length, mass) in enumerate(zip(LENGTHS, MASSES, strict=True), 1):
        x = 0.0 if k == 1 else LENGTHS[0]
        inertia = mass * length**2 / 12
        parts.append(
            f'<link name="link{k}"><inertial><origin xyz="{length / 2} 0 0"/>'
            f'<mass value="{mass}"/><inertia ixx="{0.1 * inertia}" iyy="{inertia}" '
            f'izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="u{k}" type="continuous">'
            f'<parent link="{before}"/><child link="link{k}"/><origin xyz="{x} 0 0"/>'
            '<axis xyz="0 0 1"/></joint>'
        )
        before = f"link{k}"
    path = tmp_path / "arm.urdf"
    path.write_text(f'<robot name="arm"><link name="base"/>{"".join(parts)}</robot>', "utf-8")
    return str(path)


@pytest.mark.parametrize("of_tool", [False, True])
def test_a_pose_or_a_point_of_the_tool_gives_the_factor(of_tool, arm, capsys, tmp_path):
    """The path of 2.5 times the inertia of the second link is an integral in closed form."""
    u1, u2 = turned(0.4, 1.6, second=2.5), 1.6
    x, y = map(float, tip(u1, u2) - (sum(LENGTHS), 0.0))
    words = ["--through", f"u1={u1!r},u2={u2!r}"]
    if of_tool:
        words = ["--through", f"x={x!r},y={y!r}", "--tool", "link2", "--point", "0.4,0,0"]
    page, picture = tmp_path / "a.html", tmp_path / "a.svg"
    words += ["--from", "u1=0,u2=0.4", "--change", "link2", "--moment-only"]
    words += ["--html", str(page), "--plot", str(picture)]
    code, answer = json_answer(capsys, "paths", arm, *words)
    assert code == 0 and answer["reason"] is None and answer["momentum"] < 1e-9
    assert answer["factors"] == {"link2": pytest.approx(2.5, rel=1e-6)}
    assert answer["poses"][1] == pytest.approx([u1, u2], abs=1e-9)
    elements = Elements(page.read_text("utf-8"))
    assert elements.data("report") == answer and "link2 times 2.5" in elements.text
    assert picture.read_text("utf-8").startswith("<?xml")


def test_paths_for_each_factor(arm, capsys, tmp_path):
    page = tmp_path / "a.html"
    words = ["--factors", "link2=0.25,4", "--from", "u1=0.1,u2=0.7", "--moment-only"]
    words += ["--length", "0.2", "--html", str(page)]
    code, answer = json_answer(capsys, "paths", arm, *words)
    assert code == 0 and [chart["factor"] for chart in answer["charts"]] == [0.25, 4.0]
    for chart in answer["charts"]:
        ((a, b), *_, (c, d)) = chart["solution"]["paths"][0]["inputs"]
        assert c - a == pytest.approx(turned(b, d, second=chart["factor"]), abs=1e-9)
    traces = Elements(page.read_text("utf-8")).data("figures")[0]["data"]
    assert [trace["name"] for trace in traces] == [
        f"{factor} of the inertia of link2" for factor in ("0.25", "4")
    ]
    assert main(["paths", arm, *words[:-2]]) == 0
    assert "those of link2 times a factor; mass and centre stay" in capsys.readouterr().out


def test_why_there_is_no_path(arm, capsys):
    """Two links on a fixed base always shake it by a force, which no inertia changes."""
    words = ["--factors", "link2=0.5", "--length", "0.1"]
    assert json_answer(capsys, "paths", arm, *words)[0] == 1
    words = ["--through", "u1=0.2,u2=0.4", "--change", "link2"]
    code, answer = json_answer(capsys, "paths", arm, *words)
    assert code == 1 and answer["reason"].startswith("no such path was found: the least mom")


@pytest.mark.parametrize(
    ("words", "code", "what"),
    [
        ("--through u1=1", 2, "--through and --change go together"),
        ("--change link2", 2, "--through and --change go together"),
        ("--factors link2", 2, "'link2' is not LINK=0.5,2"),
        ("--factors link2=0", 2, "'0' is not a positive number"),
        ("--factors link2=1kg", 2, "write the number alone"),
        ("--factors link3=1", 3, "link3"),
        ("--factors link2=2 --through u1=1 --change link2", 2, "not with --through"),
        ("--factors link2=2 --to u1=1", 2, "--to: not with --factors"),
        ("--factors link2=2 --table a.csv", 2, "not with --factors"),
        ("--factors link2=2 --base free", 2, "--base free: not with --factors"),
        ("--factors link2=2 --from u1=0 --from u1=1", 2, "--from: one pose"),
        ("--through u1=1 --change link2 --length 1", 2, "--length: not with --through"),
        ("--through u1=1 --change link2 --force-only", 2, "forces do not depend on"),
        ("--through u1=1 --change link9", 3, "link9"),
        ("--through u1=0 --change link2", 3, "nothing moves"),
        ("--through x=0.1 --change link2", 2, "a pose with x is one of a tool"),
        ("--through x=9 --change link2 --tool link2 --from u2=1", 3, "cannot reach x=9"),
        ("--through w=9 --change link2", 3, "w is not an input"),
    ],
)
def test_refusals(words, code, what, arm, capsys):
    assert main(["paths", arm, *words.split()]) == code
    shown = capsys.readouterr()
    assert shown.out == "" and what in shown.err.splitlines()[0], shown.err
