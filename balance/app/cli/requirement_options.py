"""Options for several requirements at once, in place of one motion and one balance."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from balance.app.cli.arguments import refuse_given
from balance.app.cli.number_arguments import point


def add_requirement_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of requirements to a command on design spaces."""
    parser.add_argument(
        "--require", action="append", default=[], metavar="TEXT",
        help="what must vanish, and where, instead of --motion and --balance; all of 'force; "
        "dynamic at u1=0.3; moment about 0,0,0.2 along u2=u3; dynamic up to order 2 about "
        "u1=0.3; force x,y along u2=u1**2; gravity; decoupled'; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--gravity", type=point, metavar="X,Y,Z",
        help="direction of gravity for --require gravity, in the frame of the file (by default "
        "0,0,-9.81)",
    )  # fmt: skip


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
