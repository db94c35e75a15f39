"""One command on several models: their options, and their answers side by side."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Protocol

from balance.app.cli.arguments import Parser

if TYPE_CHECKING:
    from kinematics.model.linkage import Linkage, Notice


COMPARE_SCHEMA = "balance.compare/1"


def add_other_models(parser: Parser) -> None:
    """Add the models after the first one to a command."""
    parser.group("model").add_argument(
        "others",
        nargs="*",
        default=[],
        metavar="MODEL",
        help="more models, beside the first",
    )


def each_model(arguments: argparse.Namespace) -> list[argparse.Namespace]:
    """Give the options of the command for each of its models alone."""
    alone = {**vars(arguments), "others": []}
    models = [arguments.model, *arguments.others]
    return [argparse.Namespace(**(alone | {"model": model})) for model in models]


class _Result(Protocol):
    """The result on one linkage."""

    def to_dict(self) -> dict[str, object]: ...


def data_against(first: _Result, second: _Result | None = None) -> dict[str, object]:
    """Return the data of a result, and of that on a second linkage (``--against``).

    Args:
        first: the result on the linkage.
        second: that on a second linkage; None without one.
    """
    return first.to_dict() | {"against": second.to_dict() if second else None}


def compared(command: str, results: Sequence[dict[str, object]]) -> dict[str, object]:
    """Collect the answers on several models as plain data for JSON.

    Args:
        results: what the command prints for each model alone.
    """
    return {"schema": COMPARE_SCHEMA, "command": command, "results": list(results)}


def named_notices(answers: Iterable[tuple[Linkage, Sequence[Notice]]]) -> list[Notice]:
    """Name the linkage in notices that stand beside those of others.

    Args:
        answers: each linkage, and the notices on it.
    """
    return [
        notice._replace(message=f"{linkage.name}: {notice.message}")
        for linkage, notices in answers
        for notice in notices
    ]
