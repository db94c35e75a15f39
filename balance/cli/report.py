"""The command ``balance report``: its options, and the files that it writes."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.atomic_files import replacing_all
from balance.cli.arguments import page_path, whole_number

if TYPE_CHECKING:
    from balance.interpretation.explain import Explanation
    from balance.spaces.design_space_result import DesignSpace
    from kinematics.model.linkage import Linkage, Notice

__all__ = ["add_options", "write_files"]

# Most joints that a notice names.
NAMED = 6


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of ``report`` beside those of every command on a model."""
    parser.add_argument(
        "--max-order", type=whole_number(0, 50, "an order"), metavar="K",
        help="compute exactly the orders 0 to K, instead of as many as needed",
    )  # fmt: skip
    parser.add_argument(
        "--explain", action="store_true",
        help="say what may be moved across each joint, and what the loops add",
    )  # fmt: skip
    parser.add_argument(
        "--html", type=page_path, metavar="FILE.html",
        help="write a page with the moving linkage and all of this; it needs no network",
    )  # fmt: skip
    parser.add_argument(
        "--write-closed", metavar="FILE",
        help="write the URDF file at the pose at which its loops close",
    )  # fmt: skip
    parser.add_argument(
        "--exact", action="store_true",
        help="also compute the ranks by exact arithmetic, from the decimals of the file",
    )  # fmt: skip
    parser.add_argument(
        "--require", choices=("proved", "verified"),
        help="exit with 4 if the answer is less certain than that",
    )  # fmt: skip


def write_files(
    arguments: argparse.Namespace, space: DesignSpace, explanation: Explanation | None
) -> tuple[Notice, ...]:
    """Write the files that ``--html`` and ``--write-closed`` name: all of them, or none.

    Args:
        arguments: the options of the command.
        space: the design space.
        explanation: it in words, if asked for.

    Returns:
        Notices about the files for the user.

    Raises:
        FileError: a file cannot be written, or the linkage was not read from a file.
    """
    from kinematics.model.linkage import Notice

    page, closed = arguments.html, arguments.write_closed
    contents, notices = [], []
    if closed is not None:
        from kinematics.urdf.write_closed_pose import at_reference_pose

        posed = at_reference_pose(space.linkage)
        contents.append((closed, posed.data))
        text = _describe_pose(space.linkage, dict(posed.moved))
        if posed.beside:
            text += "; its loops are in another file: give that with --loops"
        notices.append(Notice("closed_pose", f"{closed}: written {text}"))
    if page is not None:
        from balance.report.html.report import page as page_of

        contents.append((page, page_of(space, explanation).encode()))
    replacing_all(contents)
    return tuple(notices)


def _describe_pose(linkage: Linkage, positions: dict[str, float]) -> str:
    """The pose at which a linkage is written, by how far its joints have moved."""
    from kinematics.model.full_turns import measured, within_turn

    if not positions:
        return "as it was, for its loops close at its own pose"
    moved = [joint for joint in linkage.joints if joint.name in positions]
    within, _ = within_turn(moved, [positions[joint.name] for joint in moved])
    pairs = sorted(zip(moved, within.tolist(), strict=True), key=lambda pair: -abs(pair[1]))
    named = [f"{joint.name} by {measured(joint, q, 6)}" for joint, q in pairs]
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    where = "the pose asked for" if linkage.at else "the pose at which its loops close"
    return (
        f"at {where}: only origins of joints differ, moved are "
        f"{', '.join(named[:NAMED])}{more}; limits of joints count from there"
    )
