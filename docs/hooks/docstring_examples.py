"""Docstrings on the site: examples are a Python session, pages of theory are links."""

from __future__ import annotations

import re

from griffe import Extension

PAGE = re.compile(r"docs/theory/(\w+)\.md")


class DocstringsOfTheSite(Extension):
    """Rename the section of examples, whose plural griffe takes for a session; link pages."""

    def on_object(self, *, obj, **_):
        """Change the docstring of one object."""
        if obj.docstring is not None:
            text = obj.docstring.value.replace("\nExample:\n", "\nExamples:\n")
            obj.docstring.value = PAGE.sub(r"[Theory](../../theory/\1.md)", text)
