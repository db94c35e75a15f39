"""Options for the motion of the inputs: tables, or a crank that turns at constant speed."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from balance.app.cli.number_arguments import point
from balance.support.units import UnitNumber, read_quantity
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.motion.verification.trajectory import Trajectory
    from kinematics.model.linkage import Linkage, Notice


# How several inputs turn together.
ONE_CRANK = "and the ratio of others by --motion u2=u1, or --motion u2=-2*u1"
# What a relation of inputs does to masses that are computed.
MASSES_WHILE = " (the masses are then for this motion alone)"
# Options that choose the motion, or which random ones.
MOTION_OPTIONS = ("csv", "tool_path", "speed", "trajectories", "seed")


def add_motion_source(group: argparse._ArgumentGroup, otherwise: str) -> None:
    """Add the options ``--csv``, which may stand several times, and ``--speed``.

    All motions that are given count.

    Args:
        otherwise: the motions without them, for the help.
    """
    group.add_argument(
        "--csv",
        action="append",
        default=[],
        metavar="FILE",
        help=f"motion that counts; repeatable (default: {otherwise})",
    )
    group.add_argument(
        "--tool-path",
        action="append",
        default=[],
        type=_tool_path,
        metavar="LINK=FILE",
        help="that of a link: time,x,y,…; LINK@X,Y,Z of its point",
    )
    add_speed(group, "one turn of the crank at this speed")


def add_other_motion(group: argparse._ActionsContainer) -> None:
    """Add the options ``--csv``, ``--tool-path`` and ``--speed``, each of one motion.

    Args:
        group: one whose options exclude each other.
    """
    group.add_argument(
        "--csv", metavar="FILE", help="motion to use instead: time and the inputs"
    )
    group.add_argument(
        "--tool-path",
        type=_tool_path,
        metavar="LINK=FILE",
        help="or that of a link: time,x,y,…; LINK@X,Y,Z of its point",
    )
    add_speed(group, "one turn of the crank at this speed instead")


def add_speed(group: argparse._ActionsContainer, purpose: str) -> None:
    """Add the option ``--speed``."""
    group.add_argument("--speed", type=read_speed, metavar="[J=]300rpm", help=purpose)


class ToolPath(str):
    """The path of a table of the motion of a link.

    Attributes:
        link: name of the link.
        point: its point that moves (3,), metres, in the frame of the link; None for the origin.
    """

    link: str
    point: tuple[float, ...] | None


def motions_of(
    arguments: argparse.Namespace, linkage: Linkage, related: str = ""
) -> list[Trajectory] | None:
    """Compute the motions of the options; None without any.

    Args:
        related: as for `balance.motion.verification.crank_revolution.revolve_crank`.

    Raises:
        LinkageError: a table cannot be read, or the linkage cannot follow.
    """
    from balance.motion.verification.crank_revolution import revolve_crank
    from balance.motion.verification.given_motions import from_csv
    from kinematics.model.motion import motion_of

    limits = motion_of(linkage, arguments.motion)
    motions = [from_csv(linkage, path, limits) for path in _listed(arguments.csv)]
    for path in _listed(arguments.tool_path):
        from balance.motion.verification.tool_motion import from_tool_csv

        motions.append(from_tool_csv(linkage, path, path.link, path.point, limits))
    if arguments.speed is not None:
        crank, speed = arguments.speed
        motions.append(revolve_crank(linkage, speed, crank, limits, related=related)[0])
    return motions or None


def _listed(value: list[Any] | str | None) -> list[Any]:
    """List the values of an option that stands once, several times or not at all."""
    return value if isinstance(value, list) else [value] if value else []


def random_motions_remark(
    arguments: argparse.Namespace, linkage: Linkage, motions: Iterable[Trajectory]
) -> str:
    """Ask for a motion where the loads are those of random ones; empty if one was asked for.

    Args:
        arguments: the options of a command that moves the linkage at random without a motion.
        motions: the random ones, if they are.
    """
    from balance.app.answers.text.linkage import amplitude_text
    from balance.motion.verification.trajectory import input_reach

    given = (getattr(arguments, name, None) for name in MOTION_OPTIONS)
    turning = {joint.name for joint in linkage.joints if joint.kind == "revolute"}
    cranks = [name for name in linkage.inputs if name in turning]
    if not cranks or any(value is not None and value != [] for value in given):
        return ""
    reach = amplitude_text(linkage, input_reach(linkage, motions))
    text = f"the loads are those of random motions of 1 s, of at most {reach}: "
    if len(linkage.inputs) == 1:
        return text + (
            "if it turns as a crank, --speed 300rpm gives the loads of a turn at that speed"
        )
    columns = ",".join(("time", *linkage.inputs))
    return f"{text}--csv FILE with the columns {columns} gives those of another motion"


def notices_of(linkage: Linkage, motions: list[Trajectory] | None) -> list[Notice]:
    """List notices of motions whose angles may be degrees."""
    from balance.motion.verification.given_motions import large_angles

    return [notice for motion in motions or () for notice in large_angles(linkage, motion.u)]


def _tool_path(text: str) -> ToolPath:
    """Parse ``LINK=FILE`` or ``LINK@X,Y,Z=FILE``."""
    head, _, file = text.partition("=")
    link, at, place = head.partition("@")
    if not (link.strip() and file.strip()):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not LINK=FILE.csv, such as platform=path.csv"
        )
    path = ToolPath(file.strip())
    path.link, path.point = link.strip(), point(place) if at else None
    return path


def read_speed(text: str) -> tuple[str | None, float]:
    """Parse ``[J=]300rpm``: name of the crank or None, and its speed in rad/s."""
    name, equals, word = text.rpartition("=")
    if "," in text:
        raise argparse.ArgumentTypeError(
            f"'{text}' is more than one speed: give that of one crank, {ONE_CRANK}"
        )
    try:
        speed = read_quantity(word, "angular velocity")
    except UsageError:
        speed = 0.0
    if not isinstance(speed, UnitNumber) or bool(equals) != bool(name.strip()):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a speed: write 300rpm, 31.4rad/s, 1800deg/s, 5hz or u1=300rpm"
        )
    return name.strip() or None, float(speed)
