"""Notices on a file in short form, for the commands beside ``balance report``.

They are the same for every command on the file. What was read and the remedy stay; the names of
the elements, which can be many, are left to ``balance report``. Notices on masses, loops and
integers that may be wrong have no short form.
"""

from __future__ import annotations

from kinematics.model.linkage import Notice

WHERE = "balance report names them"


def shorten_notice(notice: Notice) -> Notice:
    """Return a notice without the names that it lists; see `Notice`."""
    if not notice.names:
        return notice
    short = notice.message.replace(f": {notice.names}", f" ({WHERE})", 1)
    return notice._replace(message=short)
