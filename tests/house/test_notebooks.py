"""The notebook of each tutorial runs in a kernel.

Blocks of their pages run in `test_docs.py`. Here the cells run as a reader runs them: files by
``%%writefile``, commands by a shell, Python in one kernel.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path, PurePosixPath

import pytest

from tests.support.waiting import HANGS

nbclient = pytest.importorskip("nbclient")
jupytext = pytest.importorskip("jupytext")
pytest.importorskip("ipykernel")

from code_blocks import code_blocks  # noqa: E402
from notebooks import notebook, notebook_page  # noqa: E402

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {page.relative_to(DOCS).as_posix() for page in DOCS.glob("**/*.md")}
TUTORIALS = sorted(
    name for name in PAGES if name.startswith("tutorials/") and name != "tutorials/index.md"
)


@pytest.fixture
def command(tmp_path, monkeypatch):
    """The command ``balance`` of this interpreter, on the path of shells."""
    script = tmp_path / "bin" / "balance"
    script.parent.mkdir()
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m balance "$@"\n', encoding="utf-8")
    script.chmod(0o755)
    monkeypatch.setenv("PATH", f"{script.parent}{os.pathsep}{os.environ['PATH']}")
    root = str(DOCS.parent)
    monkeypatch.setenv("PYTHONPATH", f"{root}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")


@pytest.mark.docs
@pytest.mark.parametrize("tutorial", TUTORIALS)
def test_a_notebook_runs_and_prints_what_its_page_shows(tutorial, command, tmp_path):
    """No cell raises, and the first line that each block shows is among what is printed."""
    page = DOCS / notebook_page(PurePosixPath(tutorial), PAGES)
    text = page.read_text(encoding="utf-8")
    folder = tmp_path / "work"
    folder.mkdir()
    for name in re.findall(r"\]\(([\w.-]+)\)", text):
        if (page.parent / name).is_file() and not name.endswith(".md"):
            shutil.copy(page.parent / name, folder)
    book = jupytext.reads(notebook(text), "ipynb")
    resources = {"metadata": {"path": str(folder)}}
    nbclient.NotebookClient(book, timeout=HANGS, resources=resources).execute()
    printed = "".join(
        output.get("text", "")
        for cell in book.cells
        if cell["cell_type"] == "code"
        for output in cell["outputs"]
    )
    assert "not found" not in printed and "\x1b[" not in printed
    words = set(map(_without_numbers, printed.splitlines()))
    for block in code_blocks(text):
        first = block.text.splitlines()[0]
        if block.language == "text" and not block.reason and first != "…":
            assert _without_numbers(first) in words, first


def _without_numbers(line):
    """A line of words alone."""
    return re.sub(r"[\d.]+(e-?\d+)?", "#", " ".join(line.split()))
