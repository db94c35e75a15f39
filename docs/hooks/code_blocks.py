"""Code blocks of a page of the documentation, and what running them prints.

Rules for authors (also in CONTRIBUTING.md):

- A block with ``title="NAME"`` is a file of that name. A file that lies beside the page, and to
  which the page links, is there too.
- ``sh``: commands of `balance`, one a line; ``# exits with N`` names an exit code other than 0,
  ``> NAME`` keeps what is printed, ``# long`` or ``# exits with N, long`` leaves it to
  ``ALL_CASES=1``. Indented lines that start with ``balance`` are commands too.
- ``python``: run in one session a page.
- ``text``: what the block before printed. A line ``…`` stands for any lines.
  Numbers that are not integers agree to 1e-3: the last digit of an optimum may depend on the
  processor.
- ``xml``, ``json`` and ``toml`` without a title have to be well-formed.
- ``<!-- not run: REASON -->`` on the line before a block leaves it out, ``<!-- long -->``
  leaves it to ``ALL_CASES=1``.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from xml.etree import ElementTree

from balance.app.cli.main import main

FENCE = re.compile(
    r"(?:^<!-- (?:not run: (?P<reason>[^\n]+)|(?P<long>long)) -->\n)?"
    r"^(?P<pad> *)```(?P<language>\w+)(?P<info>[^\n]*)\n(?P<text>.*?\n)(?P=pad)```$"
    r"|^ {4}(?P<command>balance (?:[^\n]*\\\n)*[^\n]+)$",
    re.DOTALL | re.MULTILINE,
)
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]\w)")


@dataclass(frozen=True)
class Block:
    """One code block.

    Attributes:
        language: the word after the fence.
        title: name of the file that it is, or nothing.
        text: its lines.
        line: line of the page on which it starts.
        reason: why it is not run, or nothing.
    """

    language: str
    title: str
    text: str
    line: int
    reason: str = ""


def code_blocks(markdown: str) -> list[Block]:
    """List the code blocks of a page."""
    return [_block(found, markdown) for found in FENCE.finditer(markdown)]


def _block(found: re.Match[str], markdown: str) -> Block:
    line = markdown.count("\n", 0, found.start()) + 1
    if found["command"]:
        return Block("sh", "", found["command"] + "\n", line)
    title = re.search(r'title="([^"]+)"', found["info"])
    text = re.sub(rf"^{found['pad']}", "", found["text"], flags=re.MULTILINE)
    name = title[1] if title else ""
    long = "long" if found["long"] and not os.environ.get("ALL_CASES") else ""
    return Block(found["language"], name, text, line, found["reason"] or long)


def produced(markdown: str, folder: Path) -> dict[str, Path]:
    """Find the files that a page made in a folder and shows or links, by name."""
    return {name: folder / name for name in _links(markdown) if (folder / name).is_file()}


def _links(markdown: str) -> list[str]:
    """List the names of files in the same folder to which a page links."""
    return re.findall(r"\]\(([\w.-]+)\)", markdown)


def run_page(markdown: str, folder: Path, beside: Path | None = None) -> None:
    """Run the blocks of a page in a folder, and compare what they print.

    Args:
        markdown: the text of the page.
        folder: where files are read and written; it becomes the working directory.
        beside: the folder of the page, whose files are copied if the page links to them.

    Raises:
        AssertionError: a block fails, or prints something else than the page shows.
    """
    session: dict[str, object] = {"__name__": "page"}
    shown = ""
    for name in _links(markdown) if beside else ():
        if (beside / name).is_file() and not name.endswith(".md"):
            shutil.copy(beside / name, folder)
    with contextlib.chdir(folder):
        for block in code_blocks(markdown):
            if block.reason:
                continue
            if block.title:
                Path(block.title).write_text(block.text, encoding="utf-8")
            elif block.language == "text":
                _compare(block, shown)
            else:
                shown = _run(block, session)


def _run(block: Block, session: dict[str, object]) -> str:
    """Run or read one block and return what it prints."""
    if block.language == "sh":
        return "".join(_command(line, block) for line in command_lines(block.text))
    if block.language == "python":
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(block.text, f"line {block.line}", "exec"), session)
        return printed.getvalue()
    readers = {"xml": ElementTree.fromstring, "json": json.loads, "toml": tomllib.loads}
    assert block.language in readers, f"line {block.line}: nothing runs {block.language!r}"
    readers[block.language](block.text)
    return ""


def command_lines(text: str) -> Iterator[str]:
    """Yield the commands of a block, continued lines joined."""
    return filter(None, map(str.strip, text.replace("\\\n", " ").splitlines()))


def _command(line: str, block: Block) -> str:
    """Run one command and return what a terminal shows."""
    wanted = re.search(r"# exits with (\d+)", line)
    if re.search(r"# (exits with \d+, )?long$", line) and not os.environ.get("ALL_CASES"):
        return ""
    words = shlex.split(line, comments=True)
    assert words[0] == "balance", f"line {block.line}: not a command of balance: {line}"
    name = words[-1] if ">" in words else ""
    printed, told = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(told):
        code = main(words[1 : -2 if name else None])
    expected = int(wanted[1]) if wanted else 0
    assert code == expected, f"line {block.line}: {line}: {code}\n{told.getvalue()}"
    if name:
        Path(name).write_text(printed.getvalue(), encoding="utf-8")
        return ""
    return printed.getvalue() or told.getvalue()


def _compare(block: Block, printed: str) -> None:
    """Compare a shown output with a printed one."""
    shown, got = (text.strip("\n").splitlines() for text in (block.text, printed))
    assert lines_match(shown, got), f"line {block.line}: printed\n{printed}"


def lines_match(shown: list[str], got: list[str]) -> bool:
    """Compare lines as said on top; a line … stands for any lines."""
    if not shown:
        return not got
    if shown[0].strip() == "…":
        return any(lines_match(shown[1:], got[k:]) for k in range(len(got) + 1))
    return bool(got) and _alike(shown[0], got[0]) and lines_match(shown[1:], got[1:])


def _alike(shown: str, got: str) -> bool:
    """Compare two lines: words and integers exactly, other numbers as said on top."""
    one, two = (NUMBER.sub("#", " ".join(line.split())) for line in (shown, got))
    numbers = zip(NUMBER.findall(shown), NUMBER.findall(got), strict=False)
    return one == two and all(a == b or _close(a, b) for a, b in numbers)


def _close(a: str, b: str) -> bool:
    """Compare two numbers that are written differently."""
    whole = a.lstrip("-").isdigit() and b.lstrip("-").isdigit()
    return not whole and isclose(float(a), float(b), rel_tol=1e-3)
