"""Solve for both interpretations of angles that look rounded: nominal, and as written."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from kinematics.errors import LinkageError

if TYPE_CHECKING:
    from balance.motion.floating_base.result import FloatingBaseMotion
    from balance.motion.taylor_poses.prediction import Predictions
    from balance.motion.verification.result import Verification
    from balance.space.certification.certified_space import CertifiedSpace


Answer = TypeVar(
    "Answer", "CertifiedSpace", "FloatingBaseMotion", "Predictions", "Verification"
)

# Most joints for which the other reading is computed: finding that larger loops do not close
# may take minutes.
MAX_JOINTS = 60
# Codes of notices that belong to a summary.
SUMMARY_NOTICES = ("assembled", "closes_to_rounding", "not_settled")


def solve_both_readings(build: Callable[[str], Answer], angles: str) -> Answer:
    """Solve for one reading of rounded angles, and summarise the other in the notice.

    Args:
        build: function that computes the answer for a reading, ``"nominal"`` or
            ``"as_written"``.
        angles: the reading of the answer.

    Returns:
        The answer for that reading. If angles of its file look rounded, the notice of them
        summarises both readings.

    Raises:
        LinkageError: the linkage cannot be used. If rounded angles may be the reason, the
            notes of the error summarise the other reading.
    """
    from dataclasses import replace

    from kinematics.files.urdf.rounded_angles import ANGLE_READINGS, ROUNDED_ANGLES

    (other,) = (reading for reading in ANGLE_READINGS if reading != angles)
    try:
        answer = build(angles)
    except LinkageError as error:
        if hasattr(error, "__notes__"):
            error.add_note(_label(other, _try_reading(build, other)))
        raise
    if all(notice.code != ROUNDED_ANGLES for notice in answer.notices):
        return answer
    here, there = _summary(answer), "not computed for loops of so many joints"
    if not answer.linkage.loops or len(answer.linkage.joints) <= MAX_JOINTS:
        there = _try_reading(build, other).removeprefix(f"{answer.linkage.source}: ")
    text = f"{_label(angles, here)}; {_label(other, there)}"
    if here == there:
        text = f"either way: {here}"
    notices = [
        notice._replace(message=f"{notice.message}; {text}") if notice.code == ROUNDED_ANGLES
        else notice
        for notice in answer.notices
    ]  # fmt: skip
    return replace(answer, notices=tuple(notices))


def _label(reading: str, answer: str) -> str:
    """Put the name of a reading before its summary."""
    return f"{reading.replace('_', ' ')}: {answer}"


def _try_reading(build: Callable[[str], Answer], reading: str) -> str:
    """Summarise the answer for a reading, or the reason why there is none."""
    try:
        return _summary(build(reading))
    except LinkageError as error:
        return str(error)


def _summary(answer: Answer) -> str:
    """Summarise an answer with its notices on assembly and completeness."""
    notes: list[str] = [
        notice.message for notice in answer.notices if notice.code in SUMMARY_NOTICES
    ]
    return ", ".join([answer.brief, *notes])
