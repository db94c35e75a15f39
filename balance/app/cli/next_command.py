"""The command that leads on where nothing balances: ``balance reduce``, in the words given."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from kinematics.wording import number_text

if TYPE_CHECKING:
    from balance.masses.counterweights.counterweights_result import Relaxation

# Options of other commands that `balance reduce` does not have, and how many words follow.
UNKNOWN = {
    "--minimise": 1,
    "--price-of-mass": 1,
    "--max-order": 1,
    "--spatial": 0,
    "--keep": 1,
    "--bounds": 1,
    "--anywhere": 0,
    "--only": 1,
    "--gear": 1,
    "--rotor-radius": 1,
    "--trade-off": 1,
    "--budget": 1,
    "--workers": 1,
}
# Files of the answer: a command that is proposed writes none.
OUTPUTS = {
    "--out": 1,
    "--html": 1,
    "--plot": 1,
    "--parts": 1,
    "--solids": 0,
    "--merge": 0,
    "--overwrite": 0,
}
# Options that it does not have together with requirements.
OF_MOTIONS = {
    "--csv": 1,
    "--tool-path": 1,
    "--speed": 1,
    "--density": 1,
    "--points": 0,
    "--shape": 1,
}


def reduce_command(
    arguments: argparse.Namespace,
    given_mass: float,
    links: Sequence[str] = (),
) -> str:
    """Write the command for the least shaking of the same model, with what was asked of it.

    Args:
        arguments: the options of the command, with its ``words``.
        given_mass: mass of the moving links, kg: the budget, 1 kg if they have none.
        links: links that get matter, if the words name none.
    """
    dropped = UNKNOWN | OUTPUTS
    if getattr(arguments, "require", None):
        dropped |= OF_MOTIONS
    kept = without_options(arguments.words, dropped)
    named = ["--links", ",".join(links)] if links else []
    budget = ["--budget", f"{float(number_text(given_mass or 1.0, '.2g')):g}"]
    return shlex.join(["balance", "reduce", *kept, *named, *budget])


def changed_command(arguments: argparse.Namespace, change: Relaxation) -> str:
    """Write the command for counterweights with other regions of links, or another shape.

    Args:
        arguments: the options of the command, with its ``words``.
        change: what is changed.
    """
    dropped = OUTPUTS | {"--region": 1} | ({"--shape": 1} if change.shape else {})
    kept = without_options(arguments.words, dropped)
    regions = {**dict(arguments.region), **change.regions}
    shape = ["--shape", change.shape] if change.shape else []
    placed = [word for pair in regions.items() for word in ("--region", "=".join(pair))]
    return shlex.join(["balance", "counterweights", *kept, *shape, *placed])


def without_options(words: Iterable[str], dropped: dict[str, int]) -> list[str]:
    """Leave options out of the words of a command, with their values.

    Args:
        words: the words, in which options may be shortened.
        dropped: options, and how many words follow each.
    """
    kept, after = [], 0
    for word in words:
        name, equals, _ = word.partition("=")
        if after:
            after -= 1
        elif matches := [option for option in dropped if _abbreviates(name, option)]:
            after = 0 if equals else dropped[matches[0]]
        else:
            kept.append(word)
    return kept


def _abbreviates(name: str, option: str) -> bool:
    """Whether a word is the beginning of an option, as the parser takes it."""
    return name.startswith("--") and name != "--" and option.startswith(name)
