"""Examples in docstrings: every public function has one, and all of them run.

They run in a folder of their own, in which ``robot.urdf`` is a planar four-bar linkage.
"""

from __future__ import annotations

import ast
import doctest
import inspect
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.source_files import (
    FACES,
    PRODUCT,
    ROOT,
    Definition,
    label,
    public_names,
    tree,
)

MODEL = ROOT / "urdf_models" / "four_bar_general.urdf"
Place = tuple[Path, str, str]


def docstrings(path: Path) -> Iterator[Place]:
    """File, name and docstring of all functions, classes and methods that show an example."""
    if ">>> " not in path.read_text(encoding="utf-8"):
        return
    for node in ast.walk(tree(path)):
        text = ast.get_docstring(node) if isinstance(node, Definition) else None
        if text and ">>> " in text:
            yield path, node.name, text


def failures(text: str, name: str = "example") -> str:
    """What the examples of a docstring print instead of what it shows; empty if they agree."""
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    found: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=found.append)
    return "".join(found)


@pytest.mark.parametrize("face", FACES)
def test_every_public_function_has_one_example(face: str):
    texts = {
        name: inspect.getdoc(value) or ""
        for name, value in public_names(face).items()
        if inspect.isroutine(value)
    }
    assert texts
    missing = [
        name
        for name, text in texts.items()
        if text.count("Example:\n") != 1 or ">>> " not in text.partition("Example:\n")[2]
    ]
    assert not missing


@pytest.mark.table(1)
@pytest.mark.parametrize(
    "place",
    [place for path in PRODUCT for place in docstrings(path)],
    ids=lambda place: f"{label(place[0])}:{place[1]}",
)
def test_examples_run(place: Place, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    _, name, text = place
    shutil.copy(MODEL, tmp_path / "robot.urdf")
    monkeypatch.chdir(tmp_path)
    assert not failures(text, name)


def test_a_wrong_example_is_found():
    assert not failures(">>> 1 + 1\n2\n")
    assert "Got:\n    2\n" in failures(">>> 1 + 1\n3\n")
    assert "ZeroDivisionError" in failures(">>> 1 / 0\n")
