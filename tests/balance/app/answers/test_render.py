"""The renderers of answers: what stands in which column, on any body."""

from __future__ import annotations

import pytest

from balance.app.answers.answer import AnswerSection, AnswerTable, Facts
from balance.app.answers.text.render import body_text, styled_text

ROWS = [("name", "size", "note"), ("a", "1", "x y"), ("longer one", "12", ""), ("", "-7", "z")]


@pytest.mark.parametrize("align", ["<", ">", "<>", "><"])
@pytest.mark.parametrize("least, gap", [(0, 2), (8, 0), (6, 1)])
def test_the_cells_of_a_column_are_under_each_other(align, least, gap):
    """Read back by the widths alone, every line gives its cells; none ends with a blank."""
    lines = body_text([AnswerTable(ROWS, align, least, gap)]).split("\n")
    widths = [max(least, *map(len, column)) for column in zip(*ROWS, strict=True)]
    for line, row in zip(lines, ROWS, strict=True):
        assert line == line.rstrip()
        at = 0
        for k, (cell, width) in enumerate(zip(row, widths, strict=True)):
            part = line[at : at + width].ljust(width)
            side = align[min(k, len(align) - 1)]
            assert part.strip() == cell
            assert not cell or (part[0] if side == "<" else part[-1]) != " "
            at += width + gap


@pytest.mark.parametrize("least, start", [(0, 7), (1, 6), (9, 10)])
def test_the_values_of_facts_begin_in_one_column(least, start):
    lines = body_text([Facts([("a", "1"), ("label", "2 3")], least)]).split("\n")
    assert [line[start:] for line in lines] == ["1", "2 3"]
    assert [line[:start].strip() for line in lines] == ["a", "label"]


def test_single_values_run_on_beside_columns():
    text = body_text([Facts([("a", "1", "x"), ("b", "222", "y"), ("note", "of all of them")])])
    assert text.split("\n") == ["a     1    x", "b     222  y", "note  of all of them"]


def test_wrapped_cells_keep_their_words_and_their_column():
    words = [f"w{k}" for k in range(60)]
    lines = body_text([Facts([("a", " ".join(words), "other")], wrapped=True)]).split("\n")
    assert len(lines) > 1 and max(map(len, lines)) <= 110
    assert " ".join(" ".join(lines).replace("other", "").split()) == " ".join(["a", *words])


def test_lines_and_blank_lines_are_printed_as_they_are():
    body = ["first", "", AnswerSection("title", [("a", "1"), ("bb", "2")]), ""]
    assert body_text(body) == "first\n\ntitle:\n  a   1\n  bb  2\n"


def test_a_terminal_shows_the_same_words():
    """Markup in a text is text."""
    body = [
        Facts([("a", "[b]1")]),
        "",
        AnswerTable(ROWS),
        AnswerSection("title", [("left", "[i]right")]),
    ]
    text = styled_text(body)
    for word in ("[b]1", "longer one", "12", "title", "left", "[i]right"):
        assert word in text
