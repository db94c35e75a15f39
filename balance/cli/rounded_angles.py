"""Both answers where angles of a file look rounded: with what is meant and what is written."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from kinematics.errors import LinkageError

if TYPE_CHECKING:
    from balance.certification.certified_space import CertifiedSpace
    from balance.taylor_poses.prediction import Predictions
    from balance.verification.result import Verification

__all__ = ["solve_both_readings"]

Answer = TypeVar("Answer", "CertifiedSpace", "Predictions", "Verification")

# Loops of more joints may take minutes to be found not to close.
LARGE = 60
# Notices that belong to an answer.
TOLD = ("assembled", "closes_to_rounding", "not_settled")


def solve_both_readings(build: Callable[[str], Answer], angles: str) -> Answer:
    """The answer under one reading of rounded angles, and in words under the other.

    Args:
        build: the answer for a reading, ``"nominal"`` or ``"as_written"``.
        angles: the reading wanted.

    Returns:
        The answer as built. If angles of its file look rounded, its notice of them tells
        what either reading gives.

    Raises:
        LinkageError: the linkage cannot be used as wanted. If rounded angles may be the
            reason, the notes of the error name them and tell what the other reading gives.
    """
    from dataclasses import replace

    from kinematics.urdf.rounded_angles import ANGLE_READINGS, ROUNDED_ANGLES

    (other,) = (reading for reading in ANGLE_READINGS if reading != angles)
    try:
        answer = build(angles)
    except LinkageError as error:
        if hasattr(error, "__notes__"):
            error.add_note(_named(other, _answer(build, other)))
        raise
    if all(notice.code != ROUNDED_ANGLES for notice in answer.notices):
        return answer
    here, there = _said(answer), "not computed for loops of so many joints"
    if not answer.linkage.loops or len(answer.linkage.joints) <= LARGE:
        there = _answer(build, other).removeprefix(f"{answer.linkage.source}: ")
    text = f"{_named(angles, here)}; {_named(other, there)}"
    if here == there:
        text = f"either way: {here}"
    notices = [
        notice._replace(message=f"{notice.message}; {text}") if notice.code == ROUNDED_ANGLES
        else notice
        for notice in answer.notices
    ]  # fmt: skip
    return replace(answer, notices=tuple(notices))


def _named(reading: str, answer: str) -> str:
    return f"{reading.replace('_', ' ')}: {answer}"


def _answer(build: Callable[[str], Answer], reading: str) -> str:
    """What a reading gives: an answer in short, or why there is none."""
    try:
        return _said(build(reading))
    except LinkageError as error:
        return str(error)


def _said(answer: Answer) -> str:
    """The answer in short, with what was done for it or is missing from it."""
    told: list[str] = [notice.message for notice in answer.notices if notice.code in TOLD]
    return ", ".join([answer.brief, *told])
