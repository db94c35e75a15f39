"""The option for the shape of counterweights: of counterweights and reduce."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from balance.app.cli.arguments import Parser
from balance.app.cli.density_options import points_words, without_density
from kinematics.errors import UsageError


def add_shape_option(parser: Parser, text: str) -> None:
    """Add the option ``--shape``.

    Args:
        parser: the parser of a command.
        text: its help.
    """
    parser.group("matter").add_argument(
        "--shape", action=_SetOnce, type=_shape, metavar="KIND=METRES", help=text
    )


def check_shape_option(arguments: argparse.Namespace, clash: str) -> None:
    """End the command with code 2 if a shape and other options contradict each other.

    Args:
        arguments: those of the command.
        clash: what else contradicts it, in words; empty if nothing does.
    """
    if not arguments.shape:
        return
    if arguments.move:
        arguments.refuse("--shape is for added matter: leave out --move")
    if without_density(arguments):
        arguments.refuse(
            f"--shape: point masses have none; leave out {points_words(arguments)}"
        )
    if clash:
        arguments.refuse(clash)


class _SetOnce(argparse.Action):
    """Set the shape, and refuse a second one."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        """Set the value of one option."""
        if getattr(namespace, self.dest) is not None:
            raise argparse.ArgumentError(
                self, "given twice: give one shape, of one size or several, as in disc=5mm/8mm"
            )
        setattr(namespace, self.dest, values)


def _shape(text: str) -> str:
    """Check the text of a shape."""
    from balance.masses.counterweights.shaped.weight_shape import read_weight_shapes

    try:
        read_weight_shapes(text)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text
