"""The command ``balance models``: the linkages that come with the package."""

from __future__ import annotations

import argparse

from balance.cli.arguments import Parser
from balance.cli.exit_codes import DONE
from balance.cli.outcome import Outcome

__all__ = ["add_models"]


def add_models(parser: Parser) -> None:
    """Add the options of the command ``models``."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_run)


def _run(arguments: argparse.Namespace) -> Outcome:
    """Describe every linkage of the gallery in one line."""
    from kinematics.model_gallery import describe, gallery

    found = {name: describe(path) for name, path in gallery().items()}
    width = max(map(len, found), default=0)
    return Outcome(
        DONE,
        lambda: {"schema": "balance.models/1", "models": found},
        lambda: "\n".join(f"{name:<{width}}  {line}" for name, line in found.items()),
    )
