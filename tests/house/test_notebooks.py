"""The notebooks of tutorials run in a kernel: those of half a minute, all with ``ALL_CASES=1``.

Blocks of their pages run in `test_docs.py`. Here the cells run as a reader runs them: files by
``%%writefile``, commands by a shell, Python in one kernel.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

from tests.support.covering import ALL_CASES
from tests.support.waiting import HANGS

nbclient = pytest.importorskip("nbclient")
jupytext = pytest.importorskip("jupytext")
pytest.importorskip("ipykernel")

from code_blocks import code_blocks  # noqa: E402
from notebooks import notebook  # noqa: E402

TUTORIALS = Path(__file__).parents[2] / "docs" / "tutorials"
PAGES = sorted(page.stem for page in TUTORIALS.glob("*.md") if page.stem != "index")
SHORT = [
    "desk_lamp",
    "exoskeleton_leg",
    "flexible_coupler",
    "formulas",
    "pick_and_place",
    "space_arm",
    "synthesis",
    "which_masses",
]


@pytest.fixture
def command(tmp_path, monkeypatch):
    """The command ``balance`` of this interpreter, on the path of shells."""
    script = tmp_path / "bin" / "balance"
    script.parent.mkdir()
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m balance "$@"\n', encoding="utf-8")
    script.chmod(0o755)
    monkeypatch.setenv("PATH", f"{script.parent}{os.pathsep}{os.environ['PATH']}")
    root = str(TUTORIALS.parents[1])
    monkeypatch.setenv("PYTHONPATH", f"{root}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")


@pytest.mark.docs
@pytest.mark.parametrize("page", PAGES if ALL_CASES else SHORT)
def test_a_notebook_runs_and_prints_what_its_page_shows(page, command, tmp_path):
    """No cell raises, and the first line that each block shows is among what is printed."""
    text = (TUTORIALS / f"{page}.md").read_text(encoding="utf-8")
    folder = tmp_path / "work"
    folder.mkdir()
    for name in re.findall(r"\]\(([\w.-]+)\)", text):
        if (TUTORIALS / name).is_file() and not name.endswith(".md"):
            shutil.copy(TUTORIALS / name, folder)
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
