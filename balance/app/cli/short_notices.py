"""Notices on a file in short form, for the commands beside ``balance report``.

They are the same for every command on the file. What was read and the remedy stay; the names of
the elements, which can be many, are left to ``balance report``. Notices on masses, loops and
integers that may be wrong are never shortened.
"""

from __future__ import annotations

import re

from kinematics.files.urdf.read import MASSLESS
from kinematics.files.urdf.rounded_angles import ROUNDED_ANGLES
from kinematics.model.linkage import Notice

# Names that are short enough to be listed by every command.
FEW_NAMES = 3
WHERE = "balance report names them"


def short_notice(notice: Notice) -> Notice:
    """Return a notice without its list of names, if that is long and the notice harmless."""
    if notice.code == MASSLESS:
        what, _, names = notice.message.rpartition(": ")
        count = len(names.split(", "))
        if count > FEW_NAMES:
            return notice._replace(message=f"{what}: {count} links ({WHERE})")
    if notice.code == ROUNDED_ANGLES:
        return notice._replace(
            message=re.sub(r": [^;]*;", f" ({WHERE});", notice.message, count=1)
        )
    return notice
