"""Render the body of any answer as plain text, or with the styles of a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, repeat
from textwrap import wrap

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerSection, AnswerTable, Facts

# Characters of a line of wrapped cells, and the least of a column.
LINE, LEAST = 110, 22


def body_text(body: AnswerBody) -> str:
    """Write the body of an answer as plain text."""
    return "\n".join(chain.from_iterable(map(_lines, body)))


def _lines(part: AnswerPart) -> Iterator[str]:
    """Write a part of a body in lines."""
    if isinstance(part, str):
        yield part
    elif isinstance(part, AnswerTable):
        yield from _aligned(part.rows, part.align, part.least, " " * part.gap)
    elif isinstance(part, AnswerSection):
        yield f"{part.title}:"
        yield from (f"  {line}" for line in _lines(Facts(part.pairs)))
    else:
        yield from _fact_lines(part)


def _fact_lines(facts: Facts) -> Iterator[str]:
    """Write facts in lines; single values run on beside columns of several ones."""
    labels = [label for label, *_ in facts.rows]
    width = max([facts.least, *map(len, labels)])
    texts: list[list[str]] = [values for _, *values in facts.rows]
    columns = [values for values in texts if len(values) > 1]
    if columns and not facts.wrapped:
        aligned = iter(list(_aligned(columns)))
        texts = [[next(aligned)] if len(values) > 1 else values for values in texts]
    for label, values in zip(labels, texts, strict=True):
        lines = values[:1]
        if facts.wrapped:
            lines = _wrapped(values, max((LINE - width - 1) // len(values) - 2, LEAST))
        gap = " " * (1 if facts.least else 2)
        for start, line in zip(chain([label], repeat("")), lines, strict=False):
            yield f"{start:<{width}}{gap}{line}"


def _wrapped(cells: Sequence[str], width: int) -> list[str]:
    """Write cells beside each other, each in a column of the same width and several lines."""
    texts = [wrap(cell, width) for cell in cells]
    count = max(map(len, texts))
    rows = zip(*(text + [""] * (count - len(text)) for text in texts), strict=True)
    return ["  ".join(f"{part:<{width}}" for part in row).rstrip() for row in rows]


def _aligned(
    rows: Sequence[Sequence[str]], align: str = "<", least: int = 0, gap: str = "  "
) -> Iterator[str]:
    """Align the columns of a table."""
    widths = [max(least, *map(len, column)) for column in zip(*rows, strict=True)]
    sides = align.ljust(len(widths), align[-1])
    forms = [f"{side}{width}" for side, width in zip(sides, widths, strict=False)]
    for row in rows:
        cells = (f"{cell:{form}}" for cell, form in zip(row, forms, strict=True))
        yield gap.join(cells).rstrip()


def styled_text(body: AnswerBody) -> str:
    """Write the body of an answer with the styles of a terminal, and its last line end."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table as Grid

    console = Console()
    with console.capture() as capture:
        for part in body:
            if isinstance(part, Facts):
                grid = Grid.grid(padding=(0, 2))
                for label, *values in part.rows:
                    grid.add_row(f"[bold]{label}", *map(escape, values))
            elif isinstance(part, AnswerTable):
                head, *rows = part.rows
                grid = Grid(*head)
                for row in rows:
                    grid.add_row(*row)
            elif isinstance(part, AnswerSection):
                grid = Grid("", "", title=part.title, title_justify="left", show_header=False)
                for left, right in part.pairs:
                    grid.add_row(escape(left), escape(right))
            else:
                console.print(escape(part))
                continue
            console.print(grid)
    return capture.get()
