"""Notices as commands print them: in short form, and of several files with their names.

The short forms are for the commands beside ``balance report``, and the same for all of them.
What was read and the remedy stay; the names of the elements, which can be many, are left to
``balance report``. Notices on masses, loops and integers that may be wrong have no short form.
"""

from __future__ import annotations

from collections.abc import Sequence

from balance.support.linkage_names import linkage_names
from kinematics.model.linkage import Linkage, Notice

WHERE = "balance report names them"


def shorten_notice(notice: Notice) -> Notice:
    """Return a notice without the names that it lists; see `Notice`."""
    if not notice.names:
        return notice
    short = notice.message.replace(f": {notice.names}", f" ({WHERE})", 1)
    return notice._replace(message=short)


def notices_by_file(
    linkages: Sequence[Linkage], notices: Sequence[Sequence[Notice]]
) -> list[Notice]:
    """List the notices on two linkages, each with the name of its linkage or file.

    One on both is listed once.

    Args:
        linkages: the linkages.
        notices: those of each.
    """
    first, second = notices
    names = linkage_names(linkages)
    parts = [
        ("both", linkages[0], [notice for notice in first if notice in second]),
        (names[0], linkages[0], [notice for notice in first if notice not in second]),
        (names[1], linkages[1], [notice for notice in second if notice not in first]),
    ]
    return [
        notice
        if notice.message.startswith(linkage.source)
        else notice._replace(message=f"{name}: {notice.message}")
        for name, linkage, told in parts
        for notice in told
    ]
