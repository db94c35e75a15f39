"""Options for the density of links and of matter: of design, counterweights and reduce."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from math import inf

from balance.app.cli.arguments import Parser
from balance.app.cli.number_arguments import positive_quantity
from balance.support.materials import MATERIALS


def add_density_options(
    parser: Parser, group: str, whose: str, *, points: bool = False
) -> None:
    """Add the options ``--density`` and ``--thickness``; the default is steel.

    Args:
        parser: the parser of a command.
        group: title of their group in the help.
        whose: what has the thickness.
        points: whether the matter may be point masses, by ``--points``; it is then no plates
            without the option.
    """
    parser.group(group).add_argument(
        "--density",
        action="append",
        type=_density_or_none,
        default=[],
        metavar="[L=]KG/M3",
        help="at most 7850, 7.85g/cm3, none = --points (steel)"
        if points
        else "at most: 7850, 7.85g/cm3, lead, none (steel)",
    )
    parser.group(group).add_argument(
        "--thickness",
        type=positive_quantity("length"),
        metavar="METRES",
        help=f"of {whose}{'' if points else ' (default 1/20 of the size)'}",
    )
    if points:
        option = parser.group(group).add_argument(
            "--points", action="store_true", help="point masses: matter of any density"
        )
        option.told_beside = True  # type: ignore[attr-defined]


def add_density_option(
    parser: Parser, group: str, *, steel: bool = False, thickness: str = ""
) -> None:
    """Add the option ``--density`` of one density for all matter.

    Args:
        parser: the parser of a command.
        group: title of its group in the help.
        steel: whether matter is steel without the option; else it has any density.
        thickness: what the option ``--thickness`` is for; empty for none.
    """
    parser.group(group).add_argument(
        "--density",
        type=_one_density,
        default=MATERIALS["steel"] if steel else None,
        metavar="KG/M3",
        help="at most: 7850, 7.85g/cm3, lead, none (steel)"
        if steel
        else "of added matter, at most: steel (default: points)",
    )
    if thickness:
        parser.group(group).add_argument(
            "--thickness",
            type=positive_quantity("length"),
            metavar="METRES",
            help=thickness,
        )


def check_density_options(arguments: argparse.Namespace) -> None:
    """End the command with code 2 if point masses get a density or a thickness."""
    if arguments.points and arguments.density:
        arguments.refuse("--points is for matter without a density: leave out --density")
    if arguments.thickness is not None and without_density(arguments):
        arguments.refuse(
            f"--thickness: point masses have none; leave out {points_words(arguments)}"
        )


def without_density(arguments: argparse.Namespace) -> bool:
    """Whether the options ask for matter of any density: for point masses."""
    return bool(arguments.points) or ("", inf) in arguments.density


def points_words(arguments: argparse.Namespace) -> str:
    """Return the words of the options that ask for point masses."""
    return "--points" if arguments.points else "--density none"


def densities_of(
    arguments: argparse.Namespace, names: Sequence[str]
) -> float | dict[str, float] | None:
    """Collect densities by link; of two for the same links the lower one holds.

    Args:
        arguments: those of the command.
        names: links that a density without a name is for.

    Returns:
        One density, or those of some links; None for no limits.
    """
    if getattr(arguments, "points", False):
        return None
    named: dict[str, float] = {}
    for name, value in arguments.density:
        named[name] = min(named.get(name, value), value)
    unnamed = named.pop("", MATERIALS["steel"])
    if unnamed == inf:
        return named or None
    return dict.fromkeys(names, unnamed) | named if named else unnamed


def _density_or_none(text: str) -> tuple[str, float]:
    """Parse a density, or ``none``: no limit for the links that are not named."""
    return ("", inf) if text.strip().lower() == "none" else _density(text)


def _one_density(text: str) -> float | None:
    """Parse one density; None for ``none``."""
    name, value = _density_or_none(text)
    if name:
        raise argparse.ArgumentTypeError(
            f"'{text}': one density is for all matter; write {value:g}"
        )
    return value if value < inf else None


def _density(text: str) -> tuple[str, float]:
    """Parse name and density of ``L=KG/M3``; the name of all others is empty."""
    name, equals, value = text.rpartition("=")
    if equals and not name:
        raise argparse.ArgumentTypeError(f"'{text}' names no link; write crank=2700, or 2700")
    if value.strip().lower() in MATERIALS:
        return name, MATERIALS[value.strip().lower()]
    try:
        return name, positive_quantity("density")(value)
    except argparse.ArgumentTypeError as error:
        materials = ", ".join(MATERIALS)
        raise argparse.ArgumentTypeError(f"{error}; materials are {materials}") from None
