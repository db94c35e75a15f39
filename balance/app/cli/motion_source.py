"""Options for the motion of the inputs: tables, or a crank that turns at constant speed."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.support.units import UnitNumber, read_quantity
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.motion.verification.trajectory import Trajectory
    from kinematics.model.linkage import Linkage, Notice


def add_motion_source(group: argparse._ArgumentGroup, otherwise: str) -> None:
    """Add the options ``--csv``, which may stand several times, and ``--speed``.

    All motions that are given count.

    Args:
        otherwise: the motions without them, for the help.
    """
    group.add_argument(
        "--csv", action="append", default=[], metavar="FILE",
        help=f"motion that counts; repeatable (default: {otherwise})",
    )  # fmt: skip
    add_speed(group, "one turn of the crank at this speed")


def add_speed(group: argparse._ActionsContainer, purpose: str) -> None:
    """Add the option ``--speed``."""
    group.add_argument("--speed", type=_speed, metavar="[J=]300rpm", help=purpose)


def motions_of(arguments: argparse.Namespace, linkage: Linkage) -> list[Trajectory] | None:
    """Compute the motions of the options; None without any.

    Raises:
        LinkageError: a table cannot be read, or the linkage cannot follow.
    """
    from balance.motion.verification.crank_revolution import revolve_crank
    from balance.motion.verification.given_motions import from_csv
    from kinematics.model.motion import motion_of

    limits = motion_of(linkage, arguments.motion)
    motions = [from_csv(linkage, path, limits) for path in arguments.csv]
    if arguments.speed is not None:
        crank, speed = arguments.speed
        motions.append(revolve_crank(linkage, speed, crank, limits)[0])
    return motions or None


def notices_of(linkage: Linkage, motions: list[Trajectory] | None) -> list[Notice]:
    """List notices of motions whose angles may be degrees."""
    from balance.motion.verification.given_motions import large_angles

    return [notice for motion in motions or () for notice in large_angles(linkage, motion.u)]


def _speed(text: str) -> tuple[str | None, float]:
    """Parse ``[J=]300rpm``: name of the crank or None, and its speed in rad/s."""
    name, equals, word = text.rpartition("=")
    try:
        speed = read_quantity(word, "angular velocity")
    except UsageError:
        speed = 0.0
    if not isinstance(speed, UnitNumber) or bool(equals) != bool(name.strip()):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a speed: write 300rpm, 31.4rad/s, 1800deg/s, 5hz or u1=300rpm"
        )
    return name.strip() or None, float(speed)
