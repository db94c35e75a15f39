"""Completion of commands, options and words by a shell, generated from the parsers.

The scripts hold all words: nothing of this program runs when a word is completed, except that
the names of models are read once, when the script is made.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from typing import NamedTuple

__all__ = ["SHELLS", "completion_script"]

SHELLS = ("bash", "zsh", "fish")


class _Option(NamedTuple):
    """An option: its names, its words, whether it takes a value, and its help."""

    names: tuple[str, ...]
    words: tuple[str, ...]
    valued: bool
    help: str


class _Command(NamedTuple):
    """A command: its words (``flex modes``), options, commands inside, and its help."""

    path: tuple[str, ...]
    options: tuple[_Option, ...]
    inner: tuple[str, ...]
    models: bool
    help: str


def completion_script(parser: argparse.ArgumentParser, shell: str) -> str:
    """Write the script that completes the words of a command in a shell.

    Args:
        parser: the parser of the program.
        shell: one of `SHELLS`.

    Returns:
        The script: for bash and zsh to be evaluated, for fish to be sourced.
    """
    from kinematics.model_gallery import gallery

    commands = list(_commands(parser, (), ""))
    models = tuple(sorted(gallery()))
    if shell == "fish":
        return _fish(parser.prog, commands, models)
    bash = _bash(parser.prog, commands, models)
    return f"autoload -U +X bashcompinit && bashcompinit\n{bash}" if shell == "zsh" else bash


def _commands(
    parser: argparse.ArgumentParser, path: tuple[str, ...], text: str
) -> Iterator[_Command]:
    """List the commands of a parser, those inside a command after it."""
    groups = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    inner = {name: one for group in groups for name, one in group.choices.items()}
    helps = {choice.dest: choice.help or "" for group in groups
             for choice in group._choices_actions}  # fmt: skip
    named = [a for a in parser._actions if a.option_strings and a.help != argparse.SUPPRESS]
    options = tuple(
        _Option(tuple(a.option_strings), tuple(map(str, a.choices or ())), a.nargs != 0,
                " ".join((a.help or "").split()))
        for a in named
    )  # fmt: skip
    models = any(a.dest == "model" and not a.option_strings for a in parser._actions)
    yield _Command(path, options, tuple(inner), models, text)
    for name, one in inner.items():
        yield from _commands(one, (*path, name), helps.get(name, ""))


def _bash(program: str, commands: list[_Command], models: tuple[str, ...]) -> str:
    """Write the script for bash."""
    cases, valued = [], []
    for command in commands:
        flags = [name for option in command.options for name in option.names]
        key = " ".join(command.path)
        words = " ".join([*command.inner, *flags])
        kinds = f"models={int(command.models)} files={int(not command.inner)}"
        cases.append(f'    "{key}") words="{words}"; {kinds} ;;')
        for option in command.options:
            if option.words:
                names = "|".join(f'"{key} {name}"' for name in option.names)
                valued.append(f'    {names}) choices="{" ".join(option.words)}" ;;')
    inner = [f'    "{" ".join(c.path)}") known=" {" ".join(c.inner)} " ;;'
             for c in commands if c.inner]  # fmt: skip
    return f"""_{program}() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} last=${{COMP_WORDS[COMP_CWORD-1]}}
  local path="" known words="" models=0 files=0 choices="" word k
  for ((k = 1; k < COMP_CWORD; k++)); do
    word=${{COMP_WORDS[k]}}; known=" "
    case "$path" in
{chr(10).join(inner)}
    esac
    [[ $known == *" $word "* ]] && path="${{path:+$path }}$word" || break
  done
  case "$path" in
{chr(10).join(cases)}
  esac
  case "$path $last" in
{chr(10).join(valued)}
    *) ;;
  esac
  if [[ -n $choices ]]; then COMPREPLY=($(compgen -W "$choices" -- "$cur")); return; fi
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
  if [[ $cur != -* ]]; then
    [[ $models == 1 ]] && COMPREPLY+=($(compgen -W "{" ".join(models)}" -- "$cur"))
    [[ $files == 1 ]] && COMPREPLY+=($(compgen -f -- "$cur"))
  fi
}}
complete -o filenames -F _{program} {program}"""


def _fish(program: str, commands: list[_Command], models: tuple[str, ...]) -> str:
    """Write the script for fish."""
    lines = [f"complete -c {program} -f"]
    for command in commands:
        seen = [f"__fish_seen_subcommand_from {word}" for word in command.path]
        if command.inner:
            seen.append(f"not __fish_seen_subcommand_from {' '.join(command.inner)}")
        here = f"complete -c {program} -n {_quoted('; and '.join(seen) or 'true')}"
        lines += [f"{here} -a {_quoted(inner)} -d {_quoted(_help_of(commands, command, inner))}"
                  for inner in command.inner]  # fmt: skip
        if command.models:
            lines.append(f"{here} -F -a {_quoted(' '.join(models))}")
        for option in command.options:
            names = " ".join(f"-l {n[2:]}" if n.startswith("--") else f"-s {n[1:]}"
                             for n in option.names)  # fmt: skip
            value = " -r" if option.valued else ""
            value += f" -f -a {_quoted(' '.join(option.words))}" if option.words else ""
            about = re.split(r"[;:.(]", option.help)[0].strip()
            lines.append(f"{here} {names}{value} -d {_quoted(about)}")
    return "\n".join(lines)


def _help_of(commands: list[_Command], outer: _Command, name: str) -> str:
    """Return the help of a command inside another."""
    return next(one.help for one in commands if one.path == (*outer.path, name))


def _quoted(text: str) -> str:
    """Quote a text for fish."""
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
