"""What stands in a page of HTML: its elements, attributes, texts, scripts and data."""

from __future__ import annotations

import json
from collections import Counter
from html.parser import HTMLParser

VOID = {"meta", "link", "br", "wbr", "img", "input"}


def without_breaks(page: str) -> str:
    """The text of a page without the places at which its lines may, or may not, end."""
    return page.replace("<wbr>", "").replace("\N{NO-BREAK SPACE}", " ")


class Elements(HTMLParser):
    """Elements of a page: attributes, texts outside of scripts, and scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: Counter[str] = Counter()
        self.attributes: list[tuple[str, str, str | None]] = []
        self.scripts: list[tuple[dict, str]] = []
        self.text, self.style = "", ""
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags[tag] += 1
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag == "script":
            self.scripts.append((dict(attrs), ""))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "script" in self.open:
            attributes, text = self.scripts.pop()
            self.scripts.append((attributes, text + data))
        elif "style" in self.open:
            self.style += data
        else:
            self.text += data

    def data(self, name: str):
        """The JSON in the script element of that id."""
        return next(json.loads(t) for a, t in self.scripts if a.get("id") == name)
