"""One command on several models: their options, and their answers side by side."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kinematics.model.linkage import Linkage, Notice

__all__ = ["COMPARE_SCHEMA", "add_other_models", "compared", "each_model", "named_notices"]

COMPARE_SCHEMA = "balance.compare/1"


def add_other_models(parser: argparse.ArgumentParser) -> None:
    """Add the models after the first one to a command."""
    parser.add_argument(
        "others", nargs="*", metavar="MODEL",
        help="more models, beside the first one: a table, a list with --json, one page",
    )  # fmt: skip


def each_model(arguments: argparse.Namespace) -> list[argparse.Namespace]:
    """Give the options of the command for each of its models alone."""
    alone = {**vars(arguments), "others": []}
    models = [arguments.model, *arguments.others]
    return [argparse.Namespace(**(alone | {"model": model})) for model in models]


def compared(command: str, results: Sequence[dict[str, object]]) -> dict[str, object]:
    """Collect the answers on several models as plain data for JSON.

    Args:
        command: its name.
        results: what the command prints for each model alone.
    """
    return {"schema": COMPARE_SCHEMA, "command": command, "results": list(results)}


def named_notices(linkage: Linkage, notices: Sequence[Notice]) -> list[Notice]:
    """Name the linkage in notices that stand beside those of others.

    Args:
        linkage: the one that they are about.
        notices: the notices.
    """
    return [one._replace(message=f"{linkage.name}: {one.message}") for one in notices]
