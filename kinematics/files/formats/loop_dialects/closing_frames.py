"""Frames ``closing_NAME_1`` and ``closing_NAME_2`` of onshape-to-robot and PlaCo.

A mate of that name puts the two frames on the two parts that it joins. The file does not say
what the mate leaves free. PlaCo closes such a pair by the position of one frame relative to
the other, which is a point that the two parts share; so does MuJoCo's ``connect``.
"""

from __future__ import annotations

import re

from kinematics.error_text import clean
from kinematics.files.formats.loop_dialects.draft import Draft
from kinematics.model.document.element import Element

CLOSING_PREFIX = "closing_"
"""Beginning of the names of such frames."""

_FRAME = re.compile(r"closing_(.+)_([12])")


def translate_closing_frames(draft: Draft) -> None:
    """Translate each pair of frames to a point that two bodies share.

    Args:
        draft: the tree of the file, which gets the loops.
    """
    pairs: dict[str, dict[str, Element]] = {}
    for link in draft.tree.every("link"):
        if match := _FRAME.fullmatch(link.name):
            pairs.setdefault(match[1], {})[match[2]] = link
    closed = []
    for name, frames in pairs.items():
        frame = next(iter(frames.values()))
        if len(frames) < 2:
            text = f"its partner '{clean(_partner(frame.name))}' is missing: no loop is closed"
            draft.tell("unread_closure", frame, text)
            continue
        first, second = (frames[digit].name for digit in "12")
        if draft.body(first) != draft.body(second):
            attributes = {"name": f"{CLOSING_PREFIX}{name}"}
            item = Element("loop", attributes, (), frame.line, "", frame.span)
            sides = [(first, None), (second, None)]
            draft.add_loop(item, "closing frames", "spherical", sides, {})
            closed.append(f"{CLOSING_PREFIX}{name}")
    if closed:
        text = (
            f"frames in pairs close loops at a point (3d): {clean(', '.join(closed), 200)}; "
            "where the mate fixes more, write a <loop> of its type between the two frames"
        )
        draft.remarks.append(("closing_frames", text))


def _partner(name: str) -> str:
    return name[:-1] + ("2" if name.endswith("1") else "1")
