"""Tutorials as Jupyter notebooks, from their text or from a page that does it in Python."""

from __future__ import annotations

import re
from collections.abc import Container
from pathlib import PurePosixPath

import jupytext
from code_blocks import FENCE

IN_PYTHON = "notebooks"
"""Folder beside the tutorials of pages that do their jobs in Python."""


def notebook_page(tutorial: PurePosixPath, pages: Container[str]) -> PurePosixPath:
    """Find the page whose blocks are the notebook of a tutorial.

    Args:
        tutorial: the tutorial in the folder of the documentation.
        pages: names of all pages there.
    """
    page = PurePosixPath(IN_PYTHON, tutorial.name)
    return page if page.as_posix() in pages else tutorial


def notebook(markdown: str) -> str:
    """Convert a tutorial to the text of a notebook.

    Commands become cells of the shell, which do not stop at an exit code, and files become
    cells that write them. What is printed is left out; links lead to the pages beside
    the notebook.
    """
    text = FENCE.sub(_cell, markdown)
    text = re.sub(r"\.md(#[\w-]+)?\)", r".html\1)", text)
    book = jupytext.reads(text, "md")
    book.cells = [cell for cell in book.cells if cell["source"].strip()]
    book.metadata["kernelspec"] = {
        "name": "python3",
        "language": "python",
        "display_name": "Python 3",
    }
    for number, cell in enumerate(book.cells):
        cell["id"] = f"cell-{number}"
    return jupytext.writes(book, "ipynb")


def _cell(found: re.Match[str]) -> str:
    """Rewrite a code block as the Python cell that does the same."""
    title = re.search(r'title="([^"]+)"', found["info"] or "")
    text = found["text"]
    if found["language"] == "text":
        return ""
    if title:
        text = f"%%writefile {title[1]}\n{text}"
    elif found["language"] == "sh":
        text = f"%%sh --no-raise-error\n{text}"
    return f"```python\n{text}```"
