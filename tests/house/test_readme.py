"""What the README shows is what happens."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from pathlib import Path

from balance.cli.main import main

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def fenced(mark: str) -> list[str]:
    """Contents of the code fences after HTML comments."""
    return re.findall(rf"<!-- {mark} -->\n```\w+\n(.*?)```", README, re.DOTALL)


def test_the_examples_print_what_they_say():
    examples, outputs = fenced("example"), fenced("output")
    assert len(examples) == len(outputs) == 3
    for example, output in zip(examples, outputs, strict=True):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(example, "README.md", "exec"), {})
        assert printed.getvalue() == output


def test_the_first_command_runs(capsys):
    line = re.search(r"&& (balance report .*)", README)[1]
    assert main(shlex.split(line)[1:]) == 0
    assert "35 of 70 dimensions" in capsys.readouterr().out


def test_the_options_shown_exist(capsys):
    shown = set(
        re.findall(r"--[a-z-]+", README.split("## On the command line")[1].split("##")[0])
    )
    for verb in (["report"], ["verify"], ["design"], ["motion"], []):
        assert main([*verb, "--help"]) == 0
    assert shown <= set(re.findall(r"--[a-z-]+", capsys.readouterr().out))
