"""Load the model of the options by each reading of its angles, and solve for it.

Angles that look rounded have two readings: nominal, and as written. The answer is that of the
reading that was asked for; a summary of the other stands beside it.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from balance.app.cli.model_options import load_model
from kinematics.errors import LinkageError

if TYPE_CHECKING:
    from balance.motion.floating_base.floating_base_motion import FloatingBaseMotion
    from balance.motion.taylor_poses.prediction import Predictions
    from balance.motion.verification.verification import Verification
    from balance.space.certification.certified_space import CertifiedSpace
    from kinematics.model.linkage import Linkage


Solution = TypeVar(
    "Solution", "CertifiedSpace", "FloatingBaseMotion", "Predictions", "Verification"
)

# Most joints for which the other reading is computed: finding that larger loops do not close
# may take minutes.
MAX_JOINTS = 60
# Codes of notices that belong to a summary.
SUMMARY_NOTICES = ("assembled", "closes_to_rounding", "not_settled")


class ReadFile(NamedTuple):
    """One reading of the angles of a file: its linkage, or why there is none."""

    angles: str
    linkage: Linkage | LinkageError


def certified_space(arguments: argparse.Namespace) -> CertifiedSpace:
    """Compute and certify the design space of the options.

    Raises:
        LinkageError: the file, the linkage or the motion cannot be used.
    """

    def certify_linkage(linkage: Linkage) -> CertifiedSpace:
        # Load the kernels only after the file is accepted.
        from balance.space.certification.certify_space import certify
        from balance.space.certification.compare_branches import compare_branches
        from balance.space.spaces.compute_space import design_space

        if arguments.require:
            from balance.space.requirements.require import require
            from balance.support.options import GRAVITY

            return require(
                linkage,
                arguments.require,
                spatial=arguments.spatial,
                gravity=arguments.gravity or GRAVITY,
            )
        space = design_space(
            linkage,
            arguments.motion,
            arguments.balance,
            arguments.max_order,
            spatial=arguments.spatial,
        )
        return compare_branches(certify(space))

    return solve_model(arguments, certify_linkage)


def solve_model(
    arguments: argparse.Namespace, solve: Callable[[Linkage], Solution], model: str = ""
) -> Solution:
    """Load the linkage of the options and solve for it.

    Args:
        solve: computes the solution for a linkage.
        model: path or name of another model to load with the same options.

    Returns:
        The solution for the reading of the options. If angles of its file look rounded, the
        notice of them summarises both readings.

    Raises:
        LinkageError: the linkage cannot be used. If rounded angles may be the reason, the
            notes of the error summarise the other reading.
    """
    return solve_readings(load_readings(arguments, model), solve)


def solve_readings(
    readings: Sequence[ReadFile], solve: Callable[[Linkage], Solution]
) -> Solution:
    """Solve for a linkage as `solve_model` does, from the readings of its file.

    Args:
        readings: from `load_readings`.
        solve: computes the solution for a linkage.

    Raises:
        LinkageError: see `solve_model`.
    """
    first, *others = readings
    if isinstance(first.linkage, LinkageError):
        for other in others:
            first.linkage.add_note(_label(other, _solve_in_words(other, solve)))
        raise first.linkage
    solution = solve(first.linkage)
    for other in others:
        there = _solve_in_words(other, solve).removeprefix(f"{first.linkage.source}: ")
        solution = _tell_both(solution, first, other, there)
    return solution


def load_readings(arguments: argparse.Namespace, model: str) -> list[ReadFile]:
    """Load the linkage by the reading of the options, and by the other if that may differ."""
    from kinematics.files.urdf.rounded_angles import ANGLE_READINGS, ROUNDED_ANGLES

    first = _load_reading(arguments, arguments.angles, model)
    (angles,) = (reading for reading in ANGLE_READINGS if reading != arguments.angles)
    if isinstance(first.linkage, LinkageError):
        looks_rounded = hasattr(first.linkage, "__notes__")
    else:
        looks_rounded = any(x.code == ROUNDED_ANGLES for x in first.linkage.notices)
        if looks_rounded and first.linkage.loops and len(first.linkage.joints) > MAX_JOINTS:
            reason = LinkageError("not computed for loops of so many joints")
            return [first, ReadFile(angles, reason)]
    return [first, _load_reading(arguments, angles, model)] if looks_rounded else [first]


def _load_reading(arguments: argparse.Namespace, angles: str, model: str) -> ReadFile:
    """Load the linkage by one reading."""
    try:
        return ReadFile(angles, load_model(arguments, angles, model))
    except LinkageError as error:
        return ReadFile(angles, error)


def _solve_in_words(reading: ReadFile, solve: Callable[[Linkage], Solution]) -> str:
    """Summarise the solution for a reading, or the reason why there is none."""
    if isinstance(reading.linkage, LinkageError):
        return str(reading.linkage)
    try:
        return _summary(solve(reading.linkage))
    except LinkageError as error:
        return str(error)


def _tell_both(solution: Solution, first: ReadFile, other: ReadFile, there: str) -> Solution:
    """Add the summaries of both readings to the notice of rounded angles."""
    from dataclasses import replace

    from kinematics.files.urdf.rounded_angles import ROUNDED_ANGLES

    here = _summary(solution)
    text = f"{_label(first, here)}; {_label(other, there)}"
    if here == there:
        text = f"either way: {here}"
    notices = [
        notice._replace(message=f"{notice.message}; {text}")
        if notice.code == ROUNDED_ANGLES
        else notice
        for notice in solution.notices
    ]
    return replace(solution, notices=tuple(notices))


def _label(reading: ReadFile, summary: str) -> str:
    """Put the name of a reading before its summary."""
    return f"{reading.angles.replace('_', ' ')}: {summary}"


def _summary(solution: Solution) -> str:
    """Summarise a solution with its notices on assembly and completeness."""
    notes: list[str] = [
        notice.message for notice in solution.notices if notice.code in SUMMARY_NOTICES
    ]
    return ", ".join([solution.brief, *notes])
