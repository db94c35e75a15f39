"""The files of ``balance report``: the page, and the URDF file at the closed pose."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.files import replacing_all
from kinematics.linkage import Linkage, Notice

if TYPE_CHECKING:
    from balance.meaning.explain import Explanation
    from balance.spaces.space import DesignSpace

__all__ = ["write_files"]

# Most joints that a notice names.
NAMED = 6


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
    page, closed = arguments.html, arguments.write_closed
    contents, notices = [], []
    if closed is not None:
        from kinematics.reader.posing import at_reference_pose

        posed = at_reference_pose(space.linkage)
        contents.append((closed, posed.data))
        text = _describe_pose(space.linkage, dict(posed.moved))
        if posed.beside:
            text += "; its loops are in another file: give that with --loops"
        notices.append(Notice("closed_pose", f"{closed}: written {text}"))
    if page is not None:
        from balance.web.page import page as page_of

        contents.append((page, page_of(space, explanation).encode()))
    replacing_all(contents)
    return tuple(notices)


def _describe_pose(linkage: Linkage, positions: dict[str, float]) -> str:
    """The pose at which a linkage is written, by how far its joints have moved."""
    if not positions:
        return "as it was, for its loops close at its own pose"
    kinds = {joint.name: joint.kind for joint in linkage.joints}
    named = [
        f"{name} by {q:.6g} {'m' if kinds[name] == 'prismatic' else 'rad'}"
        for name, q in sorted(positions.items(), key=lambda item: -abs(item[1]))
    ]
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    return (
        f"at the pose at which its loops close: only origins of joints differ, moved are "
        f"{', '.join(named[:NAMED])}{more}; limits of joints count from there"
    )
