"""What the README shows is what happens."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from pathlib import Path

from balance.app.cli.main import main

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
OPTIONS = (ROOT / "docs" / "command_line.md").read_text(encoding="utf-8")


def fenced(mark: str) -> list[str]:
    """Contents of the code fences after HTML comments."""
    return re.findall(rf"<!-- {mark} -->\n```\w+\n(.*?)```", README, re.DOTALL)


def test_the_examples_print_what_they_say():
    examples, outputs = fenced("example"), fenced("output")
    assert len(examples) == len(outputs) == 5
    for example, output in zip(examples, outputs, strict=True):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(example, "README.md", "exec"), {})
        assert printed.getvalue() == output


def test_the_first_command_runs(capsys):
    line = re.search(r"&& (balance report .*)", README)[1]
    assert main(shlex.split(line)[1:]) == 0
    (shown,) = fenced("report")
    assert capsys.readouterr().out == shown


def test_the_first_screen_is_that_of_the_start_page():
    """Both show one machine: its picture, its loads, and the commands, which the page runs."""
    start = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    screen = README.split("**Install it")[0]

    def commands(text: str) -> list[str]:
        blocks = "".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL)).replace("\\\n", " ")
        lines = (line.partition("  #")[0].split() for line in blocks.splitlines())
        return [" ".join(words) for words in lines if words and words[0] == "balance"]

    assert len(commands(screen)) == 3
    assert commands(screen) == commands(start)[:3]
    tables = [re.findall(r"^\| .*$", text, re.MULTILINE)[:3] for text in (screen, start)]
    assert tables[0] == tables[1] and len(tables[0]) == 3
    assert "](docs/shaking.svg)" in screen and "](shaking.svg)" in start


def test_the_options_of_the_documents_are_those_of_the_commands(capsys):
    """All that are shown exist, and all that exist are described."""
    section = README.split("## On the command line")[1].split("##")[0]
    flex = (["flex", kind] for kind in ("modes", "supports", "similar", "simulate"))
    files = ([verb, k] for verb in ("sweep", "discover") for k in ("run", "show", "export"))
    files = [*files, ["discover", "walk"]]
    for verb in (
        ["report"],
        ["verify"],
        ["identify"],
        ["design"],
        ["counterweights"],
        ["reduce"],
        ["remedies"],
        ["springs"],
        *flex,
        ["motion"],
        ["paths"],
        ["quiet"],
        *files,
        ["synthesize"],
        ["formulas"],
        [],
    ):
        assert main([*verb, "--help"]) == 0
    known = set(re.findall(r"--[a-z][a-z-]*", capsys.readouterr().out))
    shown = set(re.findall(r"--[a-z][a-z-]*", section))
    assert shown <= known
    described = set(re.findall(r"--[a-z][a-z-]*", OPTIONS))
    assert not known - shown - {"--help"}
    assert not known - described - {"--help", "--version"}


def test_links_of_the_documents_lead_to_files():
    """Those to pages made from the code are checked when the site is built."""
    for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"), ROOT / "tests/README.md"):
        for link in re.findall(r"\]\(([^)#:]+)\)", path.read_text(encoding="utf-8")):
            made = link.startswith("reference/")
            assert made or (path.parent / link).exists(), f"{path.name}: {link}"


def test_each_verb_has_a_folder(capsys):
    """The table from verbs to folders names all verbs, and folders that exist."""
    rows = re.findall(r"^\| `balance (\w+)[^|]*\| ([^|]*) \|$", README, re.MULTILINE)
    assert main(["--help"]) == 0
    verbs = re.findall(r"^    (\w+)(?:  |$)", capsys.readouterr().out, re.MULTILINE)
    assert len(verbs) > 5 and [verb for verb, _ in rows] == verbs
    for verb, places in rows:
        folders = re.findall(r"`([\w/]+/)`", places)
        assert folders and all((ROOT / folder).is_dir() for folder in folders), verb
