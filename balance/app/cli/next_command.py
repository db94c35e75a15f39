"""Commands that lead on where nothing balances, in the words given."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from balance.masses.counterweights.link_regions import ALL, radius_text
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import number_text

if TYPE_CHECKING:
    from balance.masses.counterweights.counterweights_result import Counterweights, Relaxation

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

# Factor on what was found to be enough, before it is rounded to three digits.
ENOUGH = 1.01
# Relative difference of masses which decides nothing between two changes of a request.
ABOUT_EQUAL = 0.1


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


def relaxed_command(arguments: argparse.Namespace, matter: Counterweights) -> str:
    """Write the same request with a change that was checked to make it feasible.

    Of those that need about the least mass, it is the first; for a shape, the first of all,
    which needs the least room.

    Args:
        arguments: the options of ``balance counterweights``, with its ``words``.
        matter: the answer to them.

    Returns:
        The command; empty if no change helps, or options cannot write it.
    """
    changes = matter.worth_naming
    equal = np.inf if any(change.for_shape for change in changes) else ABOUT_EQUAL
    order = rank_least_first([change.mass for change in changes], relative=equal)
    changed = (_relaxed_words(arguments, matter, changes[k]) for k in order)
    words = next((words for words in changed if words), None)
    return shlex.join(["balance", "counterweights", *words]) if words else ""


def plates_command(arguments: argparse.Namespace, matter: Counterweights) -> str:
    """Write the request for a shape of plate in place of any shape; see `propose_shape`.

    Args:
        arguments: the options of ``balance counterweights``, with its ``words``.
        matter: the answer to them, which balances.

    Returns:
        The command; empty without such a shape.
    """
    from balance.masses.counterweights.shaped.propose_shape import propose_shape

    change = propose_shape(matter)
    words = _relaxed_words(arguments, matter, change) if change else []
    return shlex.join(["balance", "counterweights", *words]) if words else ""


def _relaxed_words(
    arguments: argparse.Namespace, matter: Counterweights, change: Relaxation
) -> list[str]:
    """Change the words of a request; empty if no options write the change.

    Regions that were given are the room that there is: only balls by default grow, but for a
    shape, which needs another region.
    """
    words = without_options(arguments.words, OUTPUTS)
    by_link = any(name for name, _ in arguments.density)
    if change.for_shape:
        kept = without_options(
            words, {"--region": 1} | ({"--shape": 1} if change.shape else {})
        )
        shape = ["--shape", change.shape] if change.shape else []
        return [*kept, *shape, *_region_words({**dict(arguments.region), **change.regions})]
    if change.factor is None:
        links = change.links if ALL in change.links else (*arguments.links, *change.links)
        more = [*without_options(words, {"--links": 1}), "--links", ",".join(links)]
        return [] if by_link else more
    if change.links:
        grown = _grown_balls(matter, change.links, change.factor)
        return [*words, *grown] if grown else []
    densities = {*(matter.density or {}).values()}
    if by_link or len(densities) != 1:
        return []
    density = number_text(ENOUGH * change.factor * densities.pop(), ".3g")
    return [*without_options(words, {"--density": 1}), "--density", density]


def _region_words(regions: Mapping[str, str]) -> list[str]:
    return [word for pair in regions.items() for word in ("--region", "=".join(pair))]


def _grown_balls(matter: Counterweights, links: Sequence[str], factor: float) -> list[str]:
    """Write the default regions of links larger, as options; empty if some were given."""
    if not {*links} <= {*matter.chosen}:
        return []
    larger = ENOUGH * factor
    return _region_words({x: radius_text(matter.regions[x], larger) for x in links})


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
