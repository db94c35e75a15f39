"""Render HTML pages from a frame, templates with placeholders, and data as JSON.

A page needs no network. It contains its style, its scripts and the data, and its content
security policy forbids the browser to fetch anything else.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files

from balance.support.json_text import json_text

# Spaces between a number and its unit, at which no line ends.
UNBROKEN = re.compile(r"(?<=\d) (?=%|[kM]?N\b|kg\b|g\b|m\b|mm\b|s\b)|(?<=N) (?=m\b)|(?<=±) ")
NO_BREAK = "\u00a0"
# Scripts that must run before a script.
NEEDS = {
    "chart": ("chart_scale",),
    "curves": ("chart",),
    "front": ("chart",),
    "path_run": ("chart",),
    "parallel": ("chart",),
    "sweep": ("parallel",),
    "shapes": ("algebra",),
    "view": ("shapes", "solids", "labels"),
    "stage": ("view", "linkage", "closure"),
    "controls": ("stage",),
    "drawing": ("controls",),
    "motion": ("stage", "chart"),
    "walk": ("stage", "chart"),
    "families": ("controls",),
    "verify": ("stage", "chart"),
    "compare": ("controls",),
    "comparison": ("chart", "shapes"),
    "springs": ("drawing", "chart"),
}


def render_page(
    template: str,
    *,
    title: str,
    summary: str,
    report: object,
    data: Mapping[str, object],
    scripts: Sequence[str],
    **parts: str,
) -> str:
    """Render a page as the text of one HTML file.

    Args:
        template: name of the template file for the content between head and footer.
        title: title of the page, any text.
        summary: summary of the page in one sentence, any text.
        report: all numbers, as JSON in the element ``report``.
        data: further data for the scripts, each as JSON in an element of its name.
        scripts: names of scripts, without suffix, in the order in which they run; those that
            one needs (`NEEDS`) come before it.
        parts: HTML for the placeholders ``{{name}}`` of the template.
    """
    elements = {"report": _script_json(report, indent=2)}
    elements |= {name: _script_json(value) for name, value in data.items()}
    return fill_template(
        "frame.html",
        {
            "title": escape(title),
            "heading": breakable(title),
            "summary": UNBROKEN.sub(NO_BREAK, escape(summary)),
            "style": _read_static("page.css"),
            "content": fill_template(template, parts),
            "data": "\n".join(
                f'<script type="application/json" id="{name}">{text}</script>'
                for name, text in elements.items()
            ),
            "script": "\n".join(_read_static(f"{name}.js") for name in _in_order(scripts)),
        },
    )


def _in_order(scripts: Sequence[str]) -> list[str]:
    """List scripts after those that they need, each once."""
    ordered: dict[str, None] = {"frame": None}

    def append(name: str) -> None:
        for needed in NEEDS.get(name, ()):
            append(needed)
        ordered.setdefault(name)

    for name in scripts:
        append(name)
    return list(ordered)


def fill_template(template: str, parts: Mapping[str, str]) -> str:
    """Fill the placeholders of a template in one pass; inserted text is not searched."""
    return re.sub(
        r"\{\{(\w+)\}\}", lambda placeholder: parts[placeholder[1]], _read_static(template)
    )


def linkage_stage(what: str) -> str:
    """Render the drawing of a moving linkage, and open the column of its controls.

    Args:
        what: what is drawn, as the subject of its label.
    """
    return fill_template("stage.html", {"what": what}).rstrip("\n")


def _read_static(name: str) -> str:
    """Read a file of the folder ``static``."""
    folder = files("balance").joinpath("app", "answers", "html", "static")
    return folder.joinpath(name).read_text(encoding="utf-8")


def _script_json(data: object, indent: int | None = None) -> str:
    """Write JSON for a script element, without ``<``, which could end the element."""
    return json_text(data, indent).replace("<", "\\u003c")


def facts_list(pairs: Iterable[tuple[str, str]]) -> str:
    """Render pairs of label and value as an HTML description list."""
    terms = "\n".join(
        f"<div><dt>{breakable(label)}</dt><dd>{breakable(value)}</dd></div>"
        for label, value in pairs
    )
    return f"<dl>\n{terms}\n</dl>"


def breakable(text: str) -> str:
    """Escape a text, whose long names may break after underscores and commas."""
    return re.sub(r"(?<=\w_)(?=\w)|(?<=[^\s,],)(?=[^\s,])", "<wbr>", escape(text))


def html_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[int] = ()
) -> str:
    """Render an HTML table; on a narrow screen each cell names its column.

    Args:
        head: names of the columns, HTML.
        numbers: indices of the columns that are aligned right.
    """
    kinds = ['class="number"' if i in numbers else "" for i in range(len(head))]
    columns = list(zip(head, kinds, strict=True))
    top = "".join(f'<th scope="col" {kind}>{name}</th>' for name, kind in columns)
    lines = []
    for row in rows:
        cells = [
            f'<td data-head="{name}" {kind}>{cell}</td>'
            for (name, kind), cell in zip(columns, row, strict=True)
        ]
        lines.append(f"<tr>{''.join(cells)}</tr>")
    body = "\n".join(lines)
    return f"<table><thead><tr>{top}</tr></thead>\n<tbody>\n{body}\n</tbody></table>"


def rows_table(
    rows: Sequence[Sequence[str]], numbers: Sequence[int] = (), signed: int | None = None
) -> str:
    """Render the rows of a table as an HTML table, with capitals in its head.

    Args:
        rows: the head, and the rows, any text.
        numbers: indices of the columns that are aligned right.
        signed: index of the first column in which a hyphen is a minus sign; None: in none.
    """
    head, *lines = rows
    at = len(head) if signed is None else signed
    cells = [
        [*map(escape, row[:at]), *(escape(cell).replace("-", "−") for cell in row[at:])]
        for row in lines
    ]
    return html_table([escape(with_capital(name)) for name in head], cells, numbers)


def with_capital(text: str) -> str:
    """Write a text with a capital; the rest, which may have units and names, stays."""
    return text[:1].upper() + text[1:]


def model_section(k: int, name: str, drawing: str, note: str = "") -> str:
    """Render the places for the drawing and the sliders of one of several linkages.

    Args:
        name: its heading, any text.
        drawing: what the drawing shows, any text.
        note: HTML below the heading.
    """
    return (
        f'<section class="model">\n<h2>{breakable(name)}</h2>\n{note}'
        f'<div class="canvas" id="plot{k}" role="group" aria-label="{escape(drawing)}: arrow '
        f'keys turn it, plus and minus magnify"></div>\n'
        f'<fieldset id="sliders{k}"><legend>Motion</legend></fieldset>\n'
        f'<fieldset id="view{k}" class="view screen"><legend>Show</legend></fieldset>\n'
        "</section>"
    )


def bullets(items: Iterable[str]) -> str:
    """Render texts as an HTML list."""
    return f"<ul>{''.join(f'<li>{escape(item)}</li>' for item in items)}</ul>"
