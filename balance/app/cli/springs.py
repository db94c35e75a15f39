"""The command ``balance springs``: its options, and its answer."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser
from balance.app.cli.exit_codes import verdict_code
from balance.app.cli.model_options import Coordinates, add_model_options, load_model
from balance.app.cli.number_arguments import point
from balance.app.cli.outputs import add_page_option, add_picture_option, result_files
from balance.app.cli.payload_option import add_payload_option
from balance.app.cli.progress import spinner
from balance.support.options import GRAVITY
from balance.support.units import read_quantity
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.masses.springs.spring_balance import SpringBalance
    from balance.masses.springs.spring_catalogue import CatalogueSpring


def add_springs(parser: Parser) -> None:
    """Add the options of the command ``springs``."""
    parser.description = (
        "Finds springs between links that balance gravity in every pose, the fewest that do, "
        "and where they are attached; or those that leave the least torque. Without L0 springs "
        "act as if of no free length. Exits with 0 if springs balance, 1 if none of those do, "
        "4 if it is in doubt."
    )
    parser.add_examples(
        "balance springs lamp.urdf --between base,lower --between base,upper",
        "balance springs lamp.urdf --between 'base@0,0,0:0.2 lower@0.1,0,0 k=800'",
        "balance springs lamp.urdf --between base,lower --catalogue 400,600,800",
        "balance springs lamp.urdf --between 'base@0,0,0.2 lower@0.1,0,0' --catalogue "
        "200:800:100@0.05",
        "balance springs lamp.urdf --between base,lower --payload upper=0:1",
    )
    add_model_options(parser, unused=("--motion", "--balance", "--spatial"))
    parser.set_defaults(run=_run)
    group = parser.group("matter")
    group.add_argument(
        "--between",
        action="append",
        default=[],
        metavar="SPRING",
        help="'A,B' or 'A@X,Y,Z B@X,Y,Z k=K L0=L': links, points in their frames (m), "
        "stiffness (N/m), free length (m, default 0); a number may be a range low:high; "
        "repeatable",
    )
    group.add_argument(
        "--catalogue",
        type=_catalogue,
        default=[],
        metavar="K1,K2@L0",
        help="stiffnesses that can be had, N/m, each with a free length or without, or steps "
        "low:high:step of both (default: any)",
    )
    add_payload_option(parser)
    motion = parser.group("motion")
    motion.add_argument(
        "--gravity",
        type=point,
        default=GRAVITY,
        metavar="X,Y,Z",
        help="acceleration of gravity, inertial frame (0,0,-9.81)",
    )
    motion.add_argument(
        "--range",
        action="append",
        type=_range,
        default=[],
        metavar="J=LOW:HIGH",
        help="workspace of an input (default: its limits, or 1 rad or length each way)",
    )
    add_page_option(parser, "that moves, with the springs and the torques over the workspace")
    add_picture_option(parser, "write a picture of the torques without and with the springs")


def _run(arguments: argparse.Namespace) -> Answer:
    """Find the springs of the options.

    Raises:
        LinkageError: the file, the linkage, or a spring cannot be used.
        SystemExit: no spring is asked for.
    """
    if not arguments.between:
        arguments.refuse("give the links of a spring by --between, such as --between base,arm")
    with spinner("finding springs"):
        answer = _find(arguments)
    from balance.app.answers.text.springs import springs_body

    return Answer(
        verdict_code(answer.verdict),
        answer.to_dict,
        lambda: springs_body(answer),
        answer.notices,
        files=lambda: result_files(arguments, answer),
    )


def _find(arguments: argparse.Namespace) -> SpringBalance:
    """Load the linkage, and find its springs."""
    low, high = (
        Coordinates((name, values[k]) for name, values in arguments.range) for k in range(2)
    )
    arguments.lowest, arguments.highest = low, high
    payload, arguments.payload = arguments.payload, None  # `springs` carries it
    linkage = load_model(arguments, arguments.angles)
    from balance.masses.springs.find_springs import springs

    return springs(
        linkage,
        arguments.between,
        gravity=arguments.gravity,
        catalogue=arguments.catalogue,
        ranges=dict(arguments.range),
        payload=payload,
    )


def _range(text: str) -> tuple[str, tuple[float, float]]:
    """Parse ``u1=-30deg:60deg``."""
    name, _, words = text.rpartition("=")
    low, colon, high = words.partition(":")
    try:
        values = tuple(read_quantity(word, "angle", "length") for word in (low, high))
    except UsageError as error:
        raise argparse.ArgumentTypeError(f"'{text}' is not a range: {error}") from None
    if not name.strip() or not colon or not all(abs(value) < 1e6 for value in values):
        raise argparse.ArgumentTypeError(f"'{text}' is not a range such as u1=-30deg:60deg")
    return name.strip(), (values[0], values[1])


def _catalogue(text: str) -> list[CatalogueSpring]:
    """Parse springs of ``100,0.2N/mm@0.05,300:500:100``."""
    from balance.masses.springs.spring_catalogue import read_catalogue

    try:
        return read_catalogue(text)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
