"""What all pages are made of: one frame, templates with places to fill, data as JSON.

A page needs no network: its style, its scripts, the library that draws and the data are all
in it, and a policy in its head forbids the browser to fetch anything else.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files

from balance.json_text import json_text
from kinematics.errors import PackageError

__all__ = ["bullets", "facts_list", "render_page", "html_table"]


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
    """A page as the text of one HTML file.

    Args:
        template: name of the file that holds what stands between head and footer.
        title: name of the page; any text.
        summary: the page in a sentence; any text.
        report: all numbers, for the reader and as JSON in the element ``report``.
        data: further data for the scripts, each as JSON in an element of its name.
        scripts: names of scripts, without suffix, in the order in which they run.
        parts: HTML for the places ``{{name}}`` of the template.

    Raises:
        PackageError: Plotly is missing.
    """
    elements = {"report": _json(report, indent=2)}
    elements |= {name: _json(value) for name, value in data.items()}
    return _filled("frame.html", {
        "title": escape(title),
        "summary": escape(summary),
        "style": _source("page.css"),
        "content": _filled(template, parts),
        "data": "\n".join(
            f'<script type="application/json" id="{name}">{text}</script>'
            for name, text in elements.items()
        ),
        "plotly": _plotly(),
        "script": "\n".join(_source(f"{name}.js") for name in ("frame", *scripts)),
    })  # fmt: skip


def _filled(template: str, parts: Mapping[str, str]) -> str:
    """A template with its places filled; what fills them is not searched for places."""
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _source(template))


def _source(name: str) -> str:
    """The text of a file that pages are made of."""
    folder = files("balance").joinpath("report", "html", "static")
    return folder.joinpath(name).read_text(encoding="utf-8")


def _json(data: object, indent: int | None = None) -> str:
    """JSON that may stand in a script element: no ``<`` can end it."""
    return json_text(data, indent).replace("<", "\\u003c")


def facts_list(pairs: Iterable[tuple[str, str]]) -> str:
    """Pairs of a label and a value as a list of terms."""
    terms = "\n".join(
        f"<div><dt>{escape(label)}</dt><dd>{escape(value)}</dd></div>" for label, value in pairs
    )
    return f"<dl>\n{terms}\n</dl>"


def html_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[int] = ()
) -> str:
    """A table of HTML cells; on a narrow screen each cell names its column.

    Args:
        head: names of the columns, HTML.
        rows: cells, HTML.
        numbers: columns that are set flush right.
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


def bullets(items: Iterable[str]) -> str:
    """Texts as a list."""
    return f"<ul>{''.join(f'<li>{escape(item)}</li>' for item in items)}</ul>"


def _plotly() -> str:
    """The library that draws.

    Raises:
        PackageError: it is missing.
    """
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise PackageError("a page", "Plotly", "pip install plotly") from None
    return str(get_plotlyjs())
