"""The option for a payload: of design, counterweights, reduce and springs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.app.cli.arguments import Parser
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.masses.payload import Payload


def add_payload_option(parser: Parser, ranges: bool = True) -> None:
    """Add the option ``--payload``.

    Args:
        parser: the parser of a command.
        ranges: whether it takes ranges of loads; where not, the load is a body of its own,
            which designs keep.
    """
    parser.set_defaults(payload_apart=not ranges)
    parser.group("matter").add_argument(
        "--payload",
        type=_payload if ranges else _single_load,
        metavar="L=KG" if not ranges else "L=KG[:KG]",
        help="load at L, or L@X,Y,Z, that is not in the file",
    )


def _payload(text: str) -> Payload:
    """Parse a payload."""
    from balance.masses.payload import read_payload

    try:
        return read_payload(text)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _single_load(text: str) -> Payload:
    """Parse a payload of one load."""
    payload = _payload(text)
    if payload.varies:
        raise argparse.ArgumentTypeError(
            f"payload '{text}' is a range: a design is for one load; counterweights, reduce "
            "and springs take ranges"
        )
    return payload
