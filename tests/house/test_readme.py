"""What the README shows is what happens."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import tomllib
from pathlib import Path

from code_blocks import lines_match

import balance
from balance.app.cli.main import main

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
OPTIONS = (ROOT / "docs" / "command_line.md").read_text(encoding="utf-8")


def fenced(mark: str) -> list[str]:
    """Contents of the code fences after HTML comments."""
    return re.findall(rf"<!-- {mark} -->\n```\w+\n(.*?)```", README, re.DOTALL)


def verbs_of_help(capsys) -> list[str]:
    """List the verbs that ``balance --help`` has."""
    assert main(["--help"]) == 0
    verbs = re.findall(r"^    (\w+)(?:  |$)", capsys.readouterr().out, re.MULTILINE)
    assert len(verbs) > 5
    return verbs


def test_the_examples_print_what_they_say():
    examples, outputs = fenced("example"), fenced("output")
    assert len(examples) == len(outputs) == 5
    for example, output in zip(examples, outputs, strict=True):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(example, "README.md", "exec"), {})
        got = printed.getvalue().splitlines()
        assert lines_match(output.splitlines(), got), printed.getvalue()


def test_what_is_installed_and_what_is_imported_have_their_names():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    (command,) = project["scripts"]
    start = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert f"installed as `{project['name']}` and imported as `{command}`" in README
    assert f"installed as `{project['name']}`" in start
    assert balance.__name__ == command


def test_the_first_command_runs(capsys):
    line = re.search(r"&& (balance report .*)", README)[1]
    assert main(shlex.split(line)[1:]) == 0
    (shown,) = fenced("report")
    got = capsys.readouterr().out
    assert lines_match(shown.splitlines(), got.splitlines()), got


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


def test_the_jobs_are_those_of_the_command(capsys):
    assert main([]) == 0
    assert fenced("jobs") == [capsys.readouterr().out]


def test_each_option_is_described(capsys):
    """All are; of those of other programs the workers of Dask have one."""
    flex = (["flex", kind] for kind in ("modes", "supports", "similar", "simulate"))
    files = ([verb, k] for verb in ("sweep", "discover") for k in ("run", "show", "export"))
    grouped = ("flex", "sweep", "discover", "models")
    verbs = ([verb] for verb in verbs_of_help(capsys) if verb not in grouped)
    for words in (*verbs, *flex, *files, ["discover", "walk"], []):
        assert main([*words, "--help"]) == 0
    known = set(re.findall(r"--[a-z][a-z-]*", capsys.readouterr().out))
    described = set(re.findall(r"--[a-z][a-z-]*", OPTIONS))
    assert known - described <= {"--help", "--version"}
    assert described - known <= {"--nthreads"}


def test_links_of_the_documents_lead_to_files():
    """Those to pages made from the code are checked when the site is built."""
    for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"), ROOT / "tests/README.md"):
        for link in re.findall(r"\]\(([^)#:]+)\)", path.read_text(encoding="utf-8")):
            made = link.startswith("reference/")
            assert made or (path.parent / link).exists(), f"{path.name}: {link}"


def test_each_verb_has_a_folder(capsys):
    """The table from verbs to folders names all verbs, and folders that exist."""
    rows = re.findall(r"^\| `balance (\w+)[^|]*\| ([^|]*) \|$", README, re.MULTILINE)
    assert [verb for verb, _ in rows] == verbs_of_help(capsys)
    for verb, places in rows:
        folders = re.findall(r"`([\w/]+/)`", places)
        assert folders and all((ROOT / folder).is_dir() for folder in folders), verb
