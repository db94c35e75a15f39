"""``balance report A B`` and ``balance verify A B``: what each prints alone, side by side."""

from __future__ import annotations

import json
from importlib.resources import files

import pytest
from jsonschema import Draft202012Validator

from balance.app.answers.answer import joined_facts, side_by_side
from balance.app.answers.text.render import body_text
from balance.app.cli.main import main
from tests.support.page_elements import Elements

KITE, GENERAL = "four_bar_kite_balanced", "four_bar_general"
FEW = ("--trajectories", "2", "--seed", "3")


def printed(capsys, *words):
    """Exit code and output of a command."""
    code = main(list(words))
    return code, capsys.readouterr().out


@pytest.mark.parametrize("verb, options, code", [("report", (), 0), ("verify", FEW, 1)])
def test_json_is_the_list_of_the_single_answers(capsys, verb, options, code):
    """The worst exit code counts; the second model of verify has the motions of the first."""
    found = printed(capsys, verb, KITE, GENERAL, "--json", *options)
    data = json.loads(found[1])
    schema = (
        files("balance").joinpath("app", "schemas", "compare.schema.json").read_text("utf-8")
    )
    Draft202012Validator(json.loads(schema)).validate(data)
    assert found[0] == code and data["command"] == verb
    own = files("balance").joinpath("app", "schemas", f"{verb}.schema.json").read_text("utf-8")
    for one in data["results"]:
        Draft202012Validator(json.loads(own)).validate(one)
    alone = json.loads(printed(capsys, verb, KITE, "--json", *options)[1])
    assert data["results"][0] == alone
    assert [one["model"] for one in data["results"]] == [KITE, GENERAL]


def test_the_table_has_a_column_for_each(capsys):
    code, text = printed(capsys, "report", KITE, GENERAL, "four_bar_kite")
    assert code == 0
    row = next(line for line in text.splitlines() if line.startswith("rank by order"))
    assert [cell.strip() for cell in row.removeprefix("rank by order").split("  ") if cell] == [
        "3, 6, 7",
        "3, 6, 7, 8",
        "3, 6, 7",
    ]


def test_one_page_shows_all(capsys, tmp_path):
    for verb, options in (("report", ()), ("verify", FEW)):
        page = tmp_path / f"{verb}.html"
        main([verb, KITE, GENERAL, "--html", str(page), "--json", *options])
        results = json.loads(capsys.readouterr().out)["results"]
        found = Elements(page.read_text(encoding="utf-8"))
        for shown, printed_ in zip(found.data("report"), results, strict=True):
            assert shown == {name: printed_[name] for name in shown}
        assert KITE in found.text and GENERAL in found.text


def test_what_does_not_go_with_several_models(capsys, tmp_path):
    for words in (
        ["report", KITE, GENERAL, "--write-closed", str(tmp_path / "a.urdf")],
        ["verify", KITE, GENERAL, "--against", KITE],
        ["verify", KITE, GENERAL, "--table", str(tmp_path / "a.csv")],
        ["verify", KITE, GENERAL, "--base", "free", "--base-mass", "1", "--base-inertia", "1"],
    ):
        assert main(words) == 2
        assert capsys.readouterr().out == ""
    assert main(["report", KITE, str(tmp_path / "none.urdf")]) == 3
    assert list(tmp_path.iterdir()) == []


def test_facts_are_joined_by_label():
    left, right = [("a", "1"), ("b", "2"), ("b", "3"), ("d", "4")], [("a", "5"), ("c", "6")]
    assert joined_facts([left, right]) == [
        ("a", "1", "5"),
        ("c", "–", "6"),
        ("b", "2; 3", "–"),
        ("d", "4", "–"),
    ]
    body = side_by_side([[("a", "word " * 60)]] * 3)
    assert max(map(len, body_text(body).splitlines())) <= 110
