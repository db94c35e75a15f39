"""Both answers where angles of a file look rounded: with what is meant and what is written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from kinematics.errors import LinkageError
from kinematics.linkage import Notice
from kinematics.reader.angles import READINGS, ROUNDED

if TYPE_CHECKING:
    from balance.space import DesignSpace

__all__ = ["with_both"]

# Loops of more joints may take minutes to be found not to close.
LARGE = 60
# Notices that belong to an answer.
TOLD = ("assembled", "closes_to_rounding", "not_settled")


def with_both(build: Callable[[str], DesignSpace], angles: str) -> DesignSpace:
    """The design space under one reading of rounded angles, and in words under the other.

    Args:
        build: the design space for a reading, ``"nominal"`` or ``"as_written"``.
        angles: the reading wanted.

    Returns:
        The space as built. If angles of its file look rounded, its notice of them tells
        what either reading gives.

    Raises:
        LinkageError: the linkage cannot be used as wanted. If rounded angles may be the
            reason, the notes of the error name them and tell what the other reading gives.
    """
    (other,) = (reading for reading in READINGS if reading != angles)
    try:
        space = build(angles)
    except LinkageError as error:
        if hasattr(error, "__notes__"):
            error.add_note(_named(other, _answer(build, other)))
        raise
    if all(notice.code != ROUNDED for notice in space.notices):
        return space
    here, there = _said(space), "not computed for loops of so many joints"
    if not space.linkage.loops or len(space.linkage.joints) <= LARGE:
        there = _answer(build, other).removeprefix(f"{space.source}: ")
    text = f"{_named(angles, here)}; {_named(other, there)}"
    if here == there:
        text = f"either way: {here}"
    notices = [
        Notice(code, f"{message}; {text}" if code == ROUNDED else message)
        for code, message in space.notices
    ]
    return replace(space, notices=tuple(notices))


def _named(reading: str, answer: str) -> str:
    return f"{reading.replace('_', ' ')}: {answer}"


def _answer(build: Callable[[str], DesignSpace], reading: str) -> str:
    """What a reading gives: an answer in short, or why there is none."""
    try:
        return _said(build(reading))
    except LinkageError as error:
        return str(error)


def _said(space: DesignSpace) -> str:
    """The answer in short, with what was done for it or is missing from it."""
    count = space.rank + space.nullity
    algebra = "planar" if space.planar else "spatial"
    verdict = "balanced" if space.as_given.balanced else "not balanced"
    parts = [
        f"rank {space.rank} of {count} {algebra} parameters",
        f"nullity {space.nullity}",
        f"mobility {space.linkage.mobility}",
        f"{verdict} as given",
        *(notice.message for notice in space.notices if notice.code in TOLD),
    ]
    return ", ".join(parts)
