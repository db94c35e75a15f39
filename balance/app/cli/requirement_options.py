"""Options for several requirements at once, in place of one motion and one balance."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from balance.app.cli.arguments import NAMED_ALONE, Parser, refuse_given
from balance.app.cli.number_arguments import gravity


def add_requirement_options(parser: Parser, explain: bool = True) -> None:
    """Add the options of requirements to a command on design spaces.

    Args:
        parser: the parser of the command.
        explain: whether its help explains them.
    """
    group = parser.group("motion" if explain else NAMED_ALONE)
    group.add_argument(
        "--require",
        action="append",
        default=[],
        metavar="TEXT",
        help="instead: 'force; dynamic at u1=0.3'; repeatable",
    )
    group.add_argument(
        "--gravity", type=gravity, metavar="X,Y,Z", help="for --require gravity (0,0,-9.81)"
    )


def check_requirement_options(arguments: argparse.Namespace, others: Sequence[str]) -> None:
    """End the command with code 2 if options contradict each other.

    Args:
        arguments: the options of a command.
        others: names of options of it that are about a single design space.
    """
    if not arguments.require:
        refuse_given(arguments, ("gravity",), "{} needs --require")
        return
    refuse_given(arguments, ("motion", *others), "{} does not go with --require")
    if arguments.balance != "dynamic":
        arguments.refuse("--balance does not go with --require: write it as a requirement")
