"""Shell completion: the scripts of ``balance --completion`` complete what the parsers know."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from balance.app.cli.completion import SHELLS
from balance.app.cli.main import COMMANDS, main
from kinematics import gallery
from tests.fuzz.request_words import options, parsers

ASK = """
eval "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _shtab_balance
printf '%s\\n' "${COMPREPLY[@]}"
"""


def script(shell, capsys):
    """What the command prints."""
    assert main(["--completion", shell]) == 0
    return capsys.readouterr().out


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash on the PATH")
def test_bash_completes_commands_options_words_and_models(capsys, tmp_path):
    text = script("bash", capsys)

    def completed(*words):
        done = subprocess.run(
            ["bash", "-c", ASK, "bash", text, "balance", *words],
            capture_output=True,
            text=True,
            check=True,
            cwd=tmp_path,
        )
        assert done.stderr == ""
        return set(done.stdout.split())

    assert completed("re") == {"reduce", "report", "remedies"}
    assert completed("") == set(COMMANDS)
    assert {"--version", "--completion"} <= completed("-")
    assert completed("report", "--balance", "") == {"dynamic", "force"}
    assert completed("flex", "mo") == {"modes"} and "--clamp" in completed("flex", "modes", "-")
    kites = {name for name in gallery() if name.startswith("four_bar_k")}
    assert completed("verify", "four_bar_k") == kites
    (tmp_path / "table.csv").touch()
    assert completed("verify", "arm.urdf", "--csv", "ta") == {"table.csv"}
    for verb in ("report", "verify", "design", "counterweights", "reduce"):
        assert set(options(parsers()[verb])) <= completed(verb, "--")


@pytest.mark.parametrize("shell", SHELLS)
def test_scripts_name_every_option_of_every_command(shell, capsys):
    text = script(shell, capsys)
    for verb, parser in parsers().items():
        for name in options(parser):
            wanted = f"-l {name[2:]}" if shell == "fish" else name
            assert wanted in text, (verb, name)


def test_other_shells_are_usage_errors(capsys):
    assert main(["--completion", "tcsh"]) == 2
    assert capsys.readouterr().out == ""
