"""Completion of commands, options and words by a shell, by shtab.

The scripts hold all words: nothing of this program runs when a word is completed. The names of
models are read once, when the script is made.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from balance.app.cli.outputs import INPUTS, MODELS, OUTPUTS

SHELLS = ("bash", "zsh", "fish")
_FILES = {*INPUTS, *OUTPUTS}
# What completes a model: its function in each shell, and the definitions of these functions.
_MODEL = {"bash": "_balance_models", "zsh": "_balance_models", "fish": "(_balance_models)"}
_DEFINITIONS = {
    "bash": '_balance_models() {{ compgen -W "{names}" -- "$1"; compgen -f -- "$1"; }}',
    "zsh": "_balance_models() {{ compadd {names}; _files; }}",
    "fish": "function _balance_models\n  printf '%s\\n' {names}\n"
    "  __fish_complete_path (commandline -ct)\nend",
}


def completion_script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Write the script that completes the words of a command in a shell.

    Args:
        parser: the parser of the program.
        shell: one of `SHELLS`.

    Returns:
        The script: for bash and zsh to be evaluated, for fish to be sourced.
    """
    import shtab

    from kinematics.loading.model_gallery import gallery

    for argument in _arguments(parser):
        if argument.dest in MODELS:
            argument.complete = _MODEL  # type: ignore[attr-defined]
        elif argument.dest in _FILES:
            argument.complete = shtab.FILE  # type: ignore[attr-defined]
    names = " ".join(sorted(gallery()))
    return shtab.complete(parser, shell, preamble=_DEFINITIONS[shell].format(names=names))


def _arguments(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """List the arguments of a parser and of the commands below it."""
    for argument in parser._actions:
        yield argument
        if isinstance(argument, argparse._SubParsersAction):
            for command in argument.choices.values():
                yield from _arguments(command)
