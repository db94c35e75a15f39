"""Commands that have commands of their own, such as ``balance sweep run``."""

from __future__ import annotations

import argparse

from balance.cli.arguments import Parser, Verbs
from balance.cli.outcome import Outcome

__all__ = ["add_group"]


def add_group(verbs: Verbs, name: str, help: str, description: str) -> Verbs:
    """Add a command with commands below it, each of which sets ``compute``.

    Args:
        verbs: the commands of the parser.
        name: the command.
        help: what it is, in a few words.
        description: what it does.

    Returns:
        Where to add the commands below it.
    """
    parser = verbs.add_parser(name, help=help, description=description)
    parser.set_defaults(run=_run)
    return parser.add_subparsers(metavar="what", required=True, parser_class=Parser)


def _run(arguments: argparse.Namespace) -> Outcome:
    """Run the command that was chosen below a group."""
    outcome: Outcome = arguments.compute(arguments)
    return outcome
